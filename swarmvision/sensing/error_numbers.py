"""What the error model's kernels are handed and fill in: tables as rows of numbers, and what is told."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from swarmvision import recycling
from swarmvision.compiled import leaf
from swarmvision.config.sensor import TrackerConfig
from swarmvision.data import BoolArray, Estimates, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.sensing.error_memory import AGE, NUMBER, SHARE
from swarmvision.sensing.error_table import ErrorTable

TRACKER = TrackerConfig()  # the tables are of its defaults


class Tables(NamedTuple):
    """The tables of :class:`ErrorTable` in a row each, with what follows from them."""

    chance: FloatArray
    """Of being measured: who was not in the last picture, then who was, ``(2 * d * t * v,)``."""
    fresh: FloatArray
    variance: FloatArray
    """Of a fresh measurement, as the tracker states it, ``(d * t * v * 3,)``."""
    aged_variance: FloatArray
    grip: FloatArray
    """Share of a jump, over its time, that becomes pace: of place and of heading, ``(d * t * v * 2,)``."""
    place: FloatArray
    weights: FloatArray
    """Of range, bearing and heading: correlation of what lasts and weight of what is new in it; weights of a
    neighbour's own lasting and new deviates; of those that an observer's neighbours share, ``(3 * 6,)``."""
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
            chance=np.concatenate([table.anew.ravel(), table.again.ravel()]),
            fresh=table.fresh.ravel(),
            variance=table.fresh_std.ravel() ** 2,
            aged_variance=table.aged_std.ravel() ** 2,
            grip=grips(table.fresh_std[..., [0, 2]], spread, period).ravel(),
            place=table.phantom_place.ravel(),
            weights=np.column_stack([weights[0], *np.sqrt((*weights[1:], *shared))]).ravel(),
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
    """As :class:`swarmvision.data.Estimates`, of robots ``o``, ``(o * k,)`` each."""

    seen: BoolArray
    range: FloatArray
    bearing: FloatArray
    heading: FloatArray
    covariance: FloatArray
    """Shape ``(o * k, 9)``."""
    age: FloatArray
    track: IntArray
    visible: FloatArray

    @classmethod
    def of(cls, size: int) -> Told:
        """Return room for what is told by so many slots."""
        new = recycling.empty
        gap, bearing, heading, age, visible = new((5, size))
        seen, track = new((size,), bool), new((size,), np.int64)
        return cls(seen, gap, bearing, heading, new((size, 9)), age, track, visible)

    def estimates(self, shape: tuple[int, ...]) -> Estimates:
        """Return them as estimates of a shape."""
        arrays = {
            name: array.reshape(shape) for name, array in self._asdict().items() if name != "covariance"
        }
        return Estimates.given(**arrays, covariance=self.covariance.reshape(*shape, 3, 3))


@leaf
def tell(
    s: int,
    gap: float,
    bearing: float,
    heading: float,
    marks: IntArray,
    numbers: FloatArray,
    told: Told,
) -> None:
    """Fill in what a slot tells, from its row of marks and of numbers; all but the covariance."""
    told.seen[s], told.range[s], told.bearing[s], told.heading[s] = True, gap, bearing, heading
    told.age[s], told.track[s], told.visible[s] = numbers[AGE], marks[NUMBER], numbers[SHARE]


@leaf
def spread(covariance: FloatArray, variance: FloatArray, first: int) -> None:
    """Fill in a diagonal covariance ``(9,)``."""
    for c in range(9):
        covariance[c] = variance[first + c // 4] if c % 4 == 0 else 0.0


@leaf
def tell_nobody(first: int, last: int, told: Told) -> None:
    """Fill in that slots hold nobody."""
    for s in range(first, last):
        told.seen[s], told.age[s], told.track[s], told.visible[s] = False, np.nan, -1, 0.0
        told.range[s] = told.bearing[s] = told.heading[s] = np.nan
        for c in range(9):
            told.covariance[s, c] = np.nan
