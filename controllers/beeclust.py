"""Aggregation on a spot of the ground, as young bees do it on warmth: who meets a robot waits there.

Source: T. Schmickl, R. Thenius, C. Moeslinger, et al., "Get in touch: cooperative decision making based on
robot-to-robot collisions", Autonomous Agents and Multi-Agent Systems 18, 2009,
doi:10.1007/s10458-008-9058-5: drive straight; turn away from a wall; on meeting a robot, stop and wait for
``w = w_max e^2 / (e^2 + theta)``, then turn away and drive on. ``e`` is what the ground sensor reads.

Where we differ: ``e`` is 0..1 and theta is the square of ``half_cue``; its start value 0.46 is
``sqrt(7000) / 180``, from a theta of 7000 at readings to 180, which we did not find in print, and so ours.
A wait of 120 s is what later work with Kobots used. With nobody in sight a robot drives straight on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from swarmvision.config.controller import BeeclustConfig
from swarmvision.controllers.crowd import crowd
from swarmvision.controllers.law import Keys, Law
from swarmvision.data import SECTOR_BEARINGS, Commands, IntArray, Senses
from swarmvision.geometry import FloatArray
from swarmvision.randomness import draw

AHEAD = np.pi / 3.0  # rad to either side: ours
AHEAD_SECTORS = np.abs(SECTOR_BEARINGS) <= AHEAD
DEAF = 2.0  # s after a wait in which meetings do not count, or the same two would wait again: ours


class BeeMemory(NamedTuple):
    """Of each robot, shape ``(...)``."""

    key: Keys
    meetings: IntArray
    """Turns begun so far: the count of its random numbers."""
    wait: FloatArray
    """s left."""
    turn: FloatArray
    """rad left, signed; begun when the wait is over."""
    deaf: FloatArray
    """s left."""


def begin(config: BeeclustConfig, keys: Keys) -> BeeMemory:
    """Return the memory of robots that drive."""
    still = np.zeros(keys.shape)
    return BeeMemory(keys, np.zeros(keys.shape, dtype=np.int64), still, still, still)


def step(senses: Senses, memory: BeeMemory, config: BeeclustConfig) -> tuple[Commands, BeeMemory]:
    """Return the commands ``(...)``, and the memory after them."""
    others = crowd(senses.neighbours, config.robot_range)
    near = others.within(np.abs(np.angle(others.towards)) <= AHEAD).anybody
    wall = np.where(senses.proximity_robot, np.inf, senses.proximity)[..., AHEAD_SECTORS]
    driving = (memory.wait <= 0.0) & (memory.turn == 0.0)
    met = driving & near & (memory.deaf <= 0.0)
    blocked = driving & ~met & (near | (wall <= config.obstacle_range).any(axis=-1))
    # After a wait, and before a wall, it turns by 90 to 270 degrees, either way.
    angle = np.pi * (0.5 + draw(memory.key, memory.meetings, 0))
    angle = np.where(draw(memory.key, memory.meetings, 1) < 0.5, angle, -angle)
    wait = np.where(met, waiting_time(senses.cue, config), memory.wait)
    turn = np.where(met | blocked, angle, memory.turn)
    turning = (wait <= 0.0) & (turn != 0.0)
    pace = np.minimum(config.turn_rate, np.abs(turn) / senses.dt)
    turn_rate = np.where(turning, np.sign(turn) * pace, 0.0)
    speed = np.where((wait <= 0.0) & (turn == 0.0), config.speed, 0.0)
    ended = (memory.wait > 0.0) & (wait - senses.dt <= 0.0)
    after = BeeMemory(
        memory.key,
        memory.meetings + (met | blocked),
        np.maximum(wait - senses.dt, 0.0),
        _less(turn, turn_rate * senses.dt),
        np.where(ended, np.abs(turn) / config.turn_rate + DEAF, np.maximum(memory.deaf - senses.dt, 0.0)),
    )
    return Commands(speed, turn_rate), after


def waiting_time(cue: FloatArray, config: BeeclustConfig) -> FloatArray:
    """Return how long a robot waits (s) where the ground sensor reads ``cue`` ``(...)``."""
    wait: FloatArray = config.max_wait * cue**2 / (cue**2 + config.half_cue**2)
    return wait


def _less(turn: FloatArray, done: FloatArray) -> FloatArray:
    left: FloatArray = np.where(np.abs(turn - done) < 1e-9, 0.0, turn - done)
    return left


LAW = Law(BeeclustConfig, frozenset({"range", "bearing", "proximity", "cue"}), step, begin)
