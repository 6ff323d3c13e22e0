"""Match velocities, and descend a potential of the ranges.

Sources: H. G. Tanner, A. Jadbabaie, G. J. Pappas, "Stable flocking of mobile agents", part I: fixed topology,
and part II: dynamic topology, 42nd IEEE Conference on Decision and Control, 2003,
doi:10.1109/CDC.2003.1272910 and doi:10.1109/CDC.2003.1272911: ``u = -sum(v_i - v_j) - sum grad V`` with
``V = 1/r^2 + log r^2``, constant beyond the reach in part II.

Where we differ: ``r`` is in units of the desired range; means instead of sums; each neighbour's force is
bounded; a neighbour's velocity is its heading at the cruise speed, and the own speed returns to that speed;
the acceleration drives a point ahead of the axle. A fixed topology is who is within reach when a robot first
sees somebody, told apart by track number: a neighbour that is lost, or whose number changes, is no longer
tied. The gains are ours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from swarmvision.config.controller import TannerConfig
from swarmvision.controllers.crowd import ComplexArray, Crowd, crowd
from swarmvision.controllers.law import Keys, Law
from swarmvision.controllers.motion import accelerated, own_velocity, with_alone
from swarmvision.controllers.recall import NOWHERE, earlier_slot
from swarmvision.data import BoolArray, Commands, IntArray, Senses
from swarmvision.geometry import FloatArray


class Links(NamedTuple):
    """To whom a robot is tied in a fixed topology."""

    tracks: IntArray
    """Track numbers, -1 where there is none, shape ``(..., m)``."""


def flock(senses: Senses, links: Links, config: TannerConfig) -> tuple[Commands, Links]:
    """Return the commands of robots from the neighbours that count.

    Args:
        senses: Shape ``(..., k)``; may be empty.
        links: Of each robot; they do not matter where the topology is dynamic.
        config: Gains, ranges and topology.

    Returns:
        Before the limits of the drive, shape ``(...)``, and the links after.
    """
    others = crowd(senses.neighbours, np.inf)
    near = others.within(config.reach)
    if config.topology == "fixed":
        links = _adopted(links, senses.neighbours.track, near.counts)
        others = others.within(_tied(links, senses.neighbours.track))
    else:
        others = near
    acceleration = _acceleration(senses, others, config)
    commands = accelerated(acceleration, senses, config)
    return with_alone(commands, others.anybody, config.alone, config.speed), links


def _acceleration(senses: Senses, others: Crowd, config: TannerConfig) -> ComplexArray:
    velocity = own_velocity(senses, config)
    told = np.abs(others.facing) > 0.0
    match = np.where(told, config.speed * others.facing - velocity[..., None], 0.0)
    force = potential_force(others.distance, config) * others.towards
    return np.asarray(config.velocity_gain * others.mean(match) + others.mean(force))


def potential_force(distance: FloatArray, config: TannerConfig) -> FloatArray:
    """Return the pull (positive) or push towards a neighbour at a range (m), m/s^2: the slope of V."""
    share = config.desired_range / distance
    slope = 2.0 / distance * (1.0 - share**2)
    return np.clip(config.potential_gain * slope, -config.force_limit, config.force_limit)


def _tied(links: Links, track: IntArray) -> BoolArray:
    """Return which slots ``(..., k)`` hold somebody to whom the robot is tied."""
    return np.asarray(earlier_slot(track, links.tracks) != NOWHERE)


def _adopted(links: Links, track: IntArray, near: BoolArray) -> Links:
    """Return the links, taken anew where a robot has none yet."""
    without = ~np.any(links.tracks >= 0, axis=-1)
    found = np.where(near & without[..., None], track, -1)
    width = max(found.shape[-1], links.tracks.shape[-1])

    def padded(tracks: IntArray) -> IntArray:
        room = [(0, 0)] * (tracks.ndim - 1) + [(0, width - tracks.shape[-1])]
        return np.pad(tracks, room, constant_values=-1)

    return Links(np.maximum(padded(links.tracks), padded(found)))


def begin(config: TannerConfig, keys: Keys) -> Links:
    """Return no links."""
    return Links(np.full((*keys.shape, 0), -1))


LAW = Law(TannerConfig, frozenset({"range", "bearing", "heading", "motion"}), flock, begin)
