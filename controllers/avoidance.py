"""Collision avoidance as a layer under every law: slow down before what is ahead, and turn away from it.

The speed falls linearly from ``slow_range`` to 0 at ``stop_range`` (a common speed scale; the constants
are ours), felt through the cosine of the thing's bearing, so that what stands beside does not brake. The
turn is to the freer side; where both are alike, to the side that it turns to already, else to the left.
Things are the neighbours in sight and, where the robot has a proximity ring, whatever its sectors meet.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import AvoidanceConfig
from swarmvision.controllers.crowd import FARTHEST
from swarmvision.controllers.law import Layer
from swarmvision.data import SECTOR_BEARINGS, BoolArray, Commands, Senses
from swarmvision.geometry import FloatArray


def avoid(commands: Commands, senses: Senses, config: AvoidanceConfig) -> Commands:
    """Return the commands ``(...)`` with less speed towards what is near, and a turn away from it."""
    neighbours = senses.neighbours
    others = np.where(neighbours.seen, neighbours.range, np.inf)
    distance = np.minimum(np.concatenate([others, senses.proximity], -1), FARTHEST)
    sectors = np.broadcast_to(SECTOR_BEARINGS, senses.proximity.shape)
    bearing = np.concatenate([np.where(neighbours.seen, neighbours.bearing, 0.0), sectors], -1)
    near = np.clip((config.slow_range - distance) / (config.slow_range - config.stop_range), 0.0, 1.0)
    # Driving backwards, what is behind is ahead.
    forwards = np.where(commands.speed < 0.0, -1.0, 1.0)
    ahead = near * np.maximum(forwards[..., None] * np.cos(bearing), 0.0)
    side = np.sign(np.round(np.sin(bearing), 9))
    left, middle, right = (_worst(ahead, side == there) for there in (1.0, 0.0, -1.0))
    brake = 1.0 - np.maximum(np.maximum(left, right), middle)
    freer = right - left
    towards = np.sign(np.where(freer == 0.0, forwards * commands.turn_rate, freer))
    towards = np.where(towards == 0.0, 1.0, towards)
    away = config.turn_gain * forwards * np.clip(freer + towards * middle, -1.0, 1.0)
    return Commands(commands.speed * brake, commands.turn_rate + away)


def _worst(ahead: FloatArray, side: BoolArray) -> FloatArray:
    worst: FloatArray = np.max(np.where(side, ahead, 0.0), axis=-1, initial=0.0)
    return worst


LAYER = Layer(frozenset({"range", "bearing", "proximity"}), avoid)
