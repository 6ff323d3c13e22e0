"""What the error model's kernels are handed and fill in: tables as rows of numbers, and what is told."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from swarmvision import recycling
from swarmvision.compiled import compiled
from swarmvision.config.sensor import TrackerConfig
from swarmvision.data import BoolArray, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.sensing.error_memory import Slots
from swarmvision.sensing.error_table import ErrorTable

TRACKER = TrackerConfig()  # the tables are of its defaults


class Tables(NamedTuple):
    """The tables of :class:`ErrorTable` in a row each, with what follows from them."""

    again: FloatArray
    anew: FloatArray
    fresh: FloatArray
    variance: FloatArray
    """Of a fresh measurement, as the tracker states it, ``(d * t * v * 3,)``."""
    aged_variance: FloatArray
    grip: FloatArray
    """Share of a jump, over its time, that becomes pace: of place and of heading, ``(d * t * v * 2,)``."""
    place: FloatArray
    weights: FloatArray
    """Of range, bearing and heading: correlation of what lasts and weight of what is new in it; weights of a
    neighbour's own lasting and new deviates; of those that an observer's neighbours share, ``(3, 6)``."""
    normals: FloatArray

    @classmethod
    def of(cls, table: ErrorTable, normals: FloatArray, period: float) -> Tables:
        """Return them as the kernels take them, for pictures every ``period`` (s)."""
        keep, lasting, common = table.memory, table.lasting, table.common
        own = 1.0 - common
        weights = (keep, 1.0 - keep**2, own * lasting, own * (1.0 - lasting))
        shared = (common * lasting, common * (1.0 - lasting))
        spread = np.array([TRACKER.acceleration, TRACKER.turn_acceleration])
        return cls(
            again=table.again.ravel(),
            anew=table.anew.ravel(),
            fresh=table.fresh.ravel(),
            variance=table.fresh_std.ravel() ** 2,
            aged_variance=table.aged_std.ravel() ** 2,
            grip=grips(table.fresh_std[..., [0, 2]], spread, period).ravel(),
            place=table.phantom_place.ravel(),
            weights=np.column_stack([weights[0], *np.sqrt((*weights[1:], *shared))]),
            normals=normals,
        )


def grips(std: FloatArray, acceleration: FloatArray, period: float) -> FloatArray:
    """Return the gain beta of a steady filter of place and pace, for spreads of both, ``(...)``.

    P. R. Kalata, "The tracking index: a generalized parameter for alpha-beta and alpha-beta-gamma
    target trackers", IEEE Trans. AES 20, 1984, doi:10.1109/TAES.1984.310438.

    Args:
        std: Of what is measured.
        acceleration: Of what is tracked.
        period: Between measurements (s).
    """
    index = acceleration * period**2 / np.maximum(std, 1e-9)
    root = (4.0 + index - np.sqrt(8.0 * index + index**2)) / 4.0
    beta: FloatArray = 2.0 * (1.0 + root**2) - 4.0 * root
    return beta


class Told(NamedTuple):
    """As :class:`swarmvision.data.Estimates`, ``(w, r, k)``."""

    range: FloatArray
    bearing: FloatArray
    heading: FloatArray
    covariance: FloatArray
    """Shape ``(w, r, k, 9)``."""

    @classmethod
    def of(cls, shape: tuple[int, ...]) -> Told:
        """Return room for what is told."""
        new = recycling.empty
        return cls(new(shape), new(shape), new(shape), new((*shape, 9)))


@compiled
def spread(covariance: FloatArray, w: int, i: int, n: int, variance: FloatArray, first: int) -> None:
    """Fill in a diagonal covariance."""
    for c in range(9):
        covariance[w, i, n, c] = 0.0
    covariance[w, i, n, 0] = variance[first]
    covariance[w, i, n, 4] = variance[first + 1]
    covariance[w, i, n, 8] = variance[first + 2]


@compiled
def tell(
    slots: Slots, told: Told, seen: BoolArray, age: FloatArray, track: IntArray, visible: FloatArray
) -> None:
    """Write down whom the slots hold, ``(w, r, k)`` each, and nan into those that hold nobody."""
    used, old_age, old_visible, number = slots.used, slots.age, slots.visible, slots.number
    told_range, told_bearing, told_heading, covariance = told
    worlds, robots, most = seen.shape
    for w in range(worlds):
        for i in range(robots):
            count = used[w, i]
            for n in range(count):
                seen[w, i, n], age[w, i, n] = True, old_age[w, i, n]
                track[w, i, n], visible[w, i, n] = number[w, i, n], old_visible[w, i, n]
            for n in range(count, most):
                seen[w, i, n], age[w, i, n], track[w, i, n], visible[w, i, n] = False, np.nan, -1, 0.0
                told_range[w, i, n] = told_bearing[w, i, n] = told_heading[w, i, n] = np.nan
                for c in range(9):
                    covariance[w, i, n, c] = np.nan
