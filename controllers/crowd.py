"""The neighbours that count for a law, as arrays that are safe to compute with.

Vectors of the plane are complex numbers in the robot's frame: ahead is real, left is imaginary. What does
not count has weight 0 and harmless values, so that a law is written once, for everybody, without masks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision import recycling
from swarmvision.compiled import leaf
from swarmvision.data import SECTOR_BEARINGS, BoolArray, Estimates, Senses
from swarmvision.geometry import FloatArray
from swarmvision.trigonometry import sine_cosine

ComplexArray = NDArray[np.complex128]

NEAREST, FARTHEST = 0.01, 1e3  # m: ranges are held within, so that no power of one overflows
WIDEST = 1e5  # rad: what is told to be beyond is not told at all
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
        return np.asarray(self._weights() > 0.0)

    @property
    def offset(self) -> ComplexArray:
        """Place of each neighbour (m), shape ``(..., k)``."""
        return self.distance * self.towards

    def total(self, value: ComplexArray | FloatArray) -> ComplexArray:
        """Return the weighted sum over the neighbours of a value ``(..., k)``, shape ``(...)``."""
        shape = self.weight.shape
        value = np.ascontiguousarray(value, dtype=np.complex128)
        if value.shape != shape:
            value = np.ascontiguousarray(np.broadcast_to(value, shape))
        total = np.empty(shape[:-1], dtype=np.complex128)
        rows = (total.size, shape[-1])
        _sum(self.weight.reshape(rows), value.reshape(rows), total.reshape(-1))
        return total

    def mean(self, value: ComplexArray | FloatArray) -> ComplexArray:
        """Return the weighted mean of a value ``(..., k)``; less where all weigh little, 0 for nobody."""
        return np.asarray(self.total(value) / np.maximum(self._weights(), 1.0))

    def _weights(self) -> FloatArray:
        """Return the sum of the weights, shape ``(...)``."""
        total = np.empty(self.weight.shape[:-1])
        _weigh(self.weight.reshape(total.size, self.weight.shape[-1]), total.reshape(-1))
        return total

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
    shape = estimates.seen.shape
    weight, distance = recycling.empty(shape), recycling.empty(shape)
    towards, facing = recycling.empty(shape, np.complex128), recycling.empty(shape, np.complex128)
    _count(
        estimates.seen.reshape(-1),
        estimates.range.reshape(-1),
        estimates.bearing.reshape(-1),
        estimates.heading.reshape(-1),
        estimates.age.reshape(-1),
        reach,
        forget,
        weight.reshape(-1),
        distance.reshape(-1),
        towards.reshape(-1),
        facing.reshape(-1),
    )
    return Crowd(weight=weight, distance=distance, towards=towards, facing=facing)


@leaf
def _count(
    seen: BoolArray,
    reached: FloatArray,
    bearing: FloatArray,
    heading: FloatArray,
    age: FloatArray,
    reach: float,
    forget: float,
    weight: FloatArray,
    distance: FloatArray,
    towards: ComplexArray,
    facing: ComplexArray,
) -> None:
    """Fill in the four of :class:`Crowd` from those of :class:`Estimates`, ``(n,)`` each."""
    for n in range(len(seen)):
        counts = seen[n] & (reached[n] <= reach) & (abs(bearing[n]) <= WIDEST)
        told = counts & (abs(heading[n]) <= WIDEST)
        sine, cosine = sine_cosine(bearing[n] if counts else 0.0)
        across, along = sine_cosine(heading[n] if told else 0.0)
        weight[n] = 1.0 if counts else 0.0
        distance[n] = min(max(reached[n], NEAREST), FARTHEST) if counts else 1.0
        towards[n] = complex(cosine, sine)
        facing[n] = complex(along, across) if told else 0j
    if forget > 0.0:
        for n in range(len(seen)):
            weight[n] *= np.exp(-(age[n] if age[n] > 0.0 else 0.0) / forget)


@leaf
def _weigh(weight: FloatArray, total: FloatArray) -> None:
    """Fill in the sums ``(n,)`` of weights ``(n, k)``."""
    for n in range(len(weight)):
        whole = 0.0
        for k in range(weight.shape[1]):
            whole += weight[n, k]
        total[n] = whole


@leaf
def _sum(weight: FloatArray, value: ComplexArray, total: ComplexArray) -> None:
    """Fill in the weighted sums ``(n,)`` of values ``(n, k)``."""
    for n in range(len(weight)):
        real, imaginary = 0.0, 0.0
        for k in range(weight.shape[1]):
            real += weight[n, k] * value[n, k].real
            imaginary += weight[n, k] * value[n, k].imag
        total[n] = complex(real, imaginary)


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


def obstacle_near(senses: Senses, obstacle_range: float) -> BoolArray:
    """Return whether the proximity ring meets anything within a range (m), shape ``(...)``."""
    near = senses.proximity < obstacle_range
    return np.asarray(near.any(axis=-1)) if near.any() else np.zeros(senses.shape, dtype=bool)


def push_of_obstacles(
    senses: Senses, obstacle_range: float, contact_range: float = CONTACT_RANGE
) -> ComplexArray:
    """Return the push away from what the proximity ring meets and is no robot, of length 1 at most.

    Each sector pushes with the square of how far its thing has come in between ``obstacle_range``, where it
    begins to be felt, and ``contact_range`` (m); the constants are ours.
    """
    if not (senses.proximity < obstacle_range).any():
        return np.zeros(senses.shape, dtype=np.complex128)
    thing = np.where(senses.proximity_robot, FARTHEST, np.minimum(senses.proximity, FARTHEST))
    share = np.clip((obstacle_range - thing) / (obstacle_range - contact_range), 0.0, 1.0)
    push = -np.sum(share**2 * np.exp(1j * SECTOR_BEARINGS), axis=-1)
    return np.asarray(push / np.maximum(np.abs(push), 1.0))
