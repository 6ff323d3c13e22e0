"""The neighbours that count for a law, as arrays that are safe to compute with.

Vectors of the plane are complex numbers in the robot's frame: ahead is real, left is imaginary. What does
not count has weight 0 and harmless values, so that a law is written once, for everybody, without masks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision.data import SECTOR_BEARINGS, BoolArray, Estimates, Senses
from swarmvision.geometry import FloatArray

ComplexArray = NDArray[np.complex128]

NEAREST, FARTHEST = 0.01, 1e3  # m: ranges are held within, so that no power of one overflows
CONTACT_RANGE = 0.08  # m, where an obstacle pushes most: a robot's half diagonal and a little
OBSTACLE_GAIN = 2.0  # of that push against a direction of length 1: ours


@dataclass(frozen=True, eq=False, slots=True)
class Crowd:
    """Who counts; built by :func:`crowd`."""

    weight: FloatArray
    """Of each neighbour, 0..1; 0 for who does not count, shape ``(..., k)``."""
    distance: FloatArray
    """m, shape ``(..., k)``."""
    towards: ComplexArray
    """Direction to the neighbour, of length 1, shape ``(..., k)``."""
    facing: ComplexArray
    """Where the neighbour faces, of length 1; 0 where it is not told, shape ``(..., k)``."""

    @property
    def counts(self) -> BoolArray:
        """Who counts, shape ``(..., k)``."""
        return np.asarray(self.weight > 0.0)

    @property
    def anybody(self) -> BoolArray:
        """Whether anybody counts, shape ``(...)``."""
        return np.asarray(np.any(self.counts, axis=-1))

    @property
    def offset(self) -> ComplexArray:
        """Place of each neighbour (m), shape ``(..., k)``."""
        return self.distance * self.towards

    def total(self, value: ComplexArray | FloatArray) -> ComplexArray:
        """Return the weighted sum over the neighbours of a value ``(..., k)``, shape ``(...)``."""
        return np.asarray(np.sum(self.weight * value, axis=-1), dtype=np.complex128)

    def mean(self, value: ComplexArray | FloatArray) -> ComplexArray:
        """Return the weighted mean of a value ``(..., k)``; less where all weigh little, 0 for nobody."""
        return np.asarray(self.total(value) / np.maximum(np.sum(self.weight, axis=-1), 1.0))

    def heading(self) -> ComplexArray:
        """Return the mean direction, of length 1, in which the robot itself and its neighbours face."""
        return unit(1.0 + self.total(self.facing))

    def within(self, reach: float | BoolArray) -> Crowd:
        """Return the crowd of those that are within ``reach`` (m), or that a mask ``(..., k)`` tells."""
        inside = reach if isinstance(reach, np.ndarray) else self.distance <= reach
        return Crowd(np.where(inside, self.weight, 0.0), self.distance, self.towards, self.facing)


def crowd(estimates: Estimates, reach: float, forget: float = 0.0) -> Crowd:
    """Return the neighbours within a range.

    Args:
        estimates: Robot frame, shape ``(..., k)``; may be empty.
        reach: Neighbours farther away do not count (m).
        forget: Time (s) in which what is not measured anew loses all but 1/e of its weight; 0 for never.
    """
    counts = estimates.seen & (estimates.range <= reach) & np.isfinite(estimates.bearing)
    age = np.maximum(np.nan_to_num(estimates.age, nan=0.0), 0.0)
    fresh = np.exp(-age / forget) if forget else np.ones_like(age)
    told = counts & np.isfinite(estimates.heading)
    heading = np.where(told, estimates.heading, 0.0)
    return Crowd(
        weight=np.where(counts, fresh, 0.0),
        distance=np.clip(np.where(counts, estimates.range, 1.0), NEAREST, FARTHEST),
        towards=np.exp(1j * np.where(counts, estimates.bearing, 0.0)),
        facing=np.where(told, np.exp(1j * heading), 0.0),
    )


def unit(vector: ComplexArray | FloatArray) -> ComplexArray:
    """Return a vector at length 1, or 0 where it is 0."""
    vector = np.asarray(vector, dtype=np.complex128)
    return np.asarray(vector / np.maximum(np.abs(vector), 1e-12))


def goal_offset(senses: Senses) -> tuple[ComplexArray, BoolArray]:
    """Return the place of the goal (m), 0 for who does not know it, and who knows it, ``(...)`` each."""
    return _offset(senses.goal)


def load_offset(senses: Senses) -> tuple[ComplexArray, BoolArray]:
    """Return the place of the load (m), 0 for who knows of none, and who knows of one, ``(...)`` each."""
    return _offset(np.asarray(senses.load))


def _offset(place: FloatArray) -> tuple[ComplexArray, BoolArray]:
    known: BoolArray = np.asarray(np.isfinite(place).all(axis=-1))
    place = np.where(known[..., None], place, 0.0)
    farther = np.max(np.abs(place), axis=-1, keepdims=True) / FARTHEST
    place = place / np.maximum(farther, 1.0)
    return place[..., 0] + 1j * place[..., 1], known


def push_of_obstacles(
    senses: Senses, obstacle_range: float, contact_range: float = CONTACT_RANGE
) -> ComplexArray:
    """Return the push away from what the proximity ring meets and is no robot, of length 1 at most.

    Each sector pushes with the square of how far its thing has come in between ``obstacle_range``, where it
    begins to be felt, and ``contact_range`` (m); the constants are ours.
    """
    thing = np.where(senses.proximity_robot, FARTHEST, np.minimum(senses.proximity, FARTHEST))
    share = np.clip((obstacle_range - thing) / (obstacle_range - contact_range), 0.0, 1.0)
    push = -np.sum(share**2 * np.exp(1j * SECTOR_BEARINGS), axis=-1)
    return np.asarray(push / np.maximum(np.abs(push), 1.0))
