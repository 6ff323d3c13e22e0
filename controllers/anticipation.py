"""Neighbours where they will be: forces between places to come damp, and so align, with no heading seen.

Sources: R. Shu, E. Tadmor, "Anticipation breeds alignment", Archive for Rational Mechanics and Analysis
240, 2021, arXiv:1905.00633: forces of attraction and repulsion between the places ``x + tau v``, which to
the first order in ``tau`` hold an alignment of velocities. P. Gerlee, K. Tunstrom, T. Lundh, B. Wennberg,
"Impact of anticipation in dynamical systems", Physical Review E 96, 2017, arXiv:1611.03637: it takes
energy out of the motion.

Where we differ: nobody tells its velocity. That of a neighbour relative to the robot is the difference of
tracked estimates, in axes that do not turn with the robot, smoothed; and nobody is expected to come nearer,
or go farther, than by half of its range.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from swarmvision.config.model import Settings
from swarmvision.controllers.crowd import ComplexArray, Crowd
from swarmvision.controllers.law import Keys
from swarmvision.controllers.recall import earlier_slot, recalled, smoothed, tracked
from swarmvision.data import IntArray, Senses

FARTHEST_SHIFT = 0.5  # of the range


class Motion(NamedTuple):
    """How neighbours move relative to a robot, by slot, shape ``(..., k)`` each; of no slot before a look."""

    track: IntArray
    """Track number."""
    place: ComplexArray
    """Robot frame (m)."""
    velocity: ComplexArray
    """Of the place, in axes that do not turn (m/s), smoothed."""


def at_rest(config: Settings, keys: Keys) -> Motion:
    """Return that nobody was seen, as a law begins."""
    nothing = np.zeros((*keys.shape, 0), dtype=np.complex128)
    return Motion(np.zeros(nothing.shape, dtype=np.int64), nothing, nothing)


def anticipated(
    others: Crowd, senses: Senses, before: Motion, ahead: float, smoothing: float
) -> tuple[Crowd, Motion]:
    """Return the neighbours where they will be, and how they move.

    Args:
        others: Where they are.
        senses: Of the same look.
        before: How they moved at the look before.
        ahead: Time (s); with 0 the neighbours are returned as they are, and nothing is remembered.
        smoothing: Time constant of the velocities (s).
    """
    if ahead == 0.0:
        return others, before
    track, place = tracked(senses, others), others.offset
    slot = earlier_slot(track, before.track)
    turned = np.exp(-1j * senses.turn_rate * senses.dt)[..., None]
    rate = (place - turned * recalled(before.place, slot)) / senses.dt
    velocity = smoothed(turned * recalled(before.velocity, slot), rate, senses, smoothing)
    velocity = np.where(np.isfinite(velocity), velocity, 0.0)
    shift = ahead * velocity
    share = np.minimum(1.0, FARTHEST_SHIFT * others.distance / np.maximum(np.abs(shift), 1e-12))
    to_come = place + share * shift
    distance = np.abs(to_come)
    moved = replace(others, distance=distance, towards=to_come / distance)
    return moved, Motion(track, place, velocity)
