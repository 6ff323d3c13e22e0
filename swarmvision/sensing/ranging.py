"""Range and bearing between robots by a signal from one to the other: what infrared and sound share.

Whom a signal reaches is line of sight (:mod:`swarmvision.sensing.sight`); what is measured has errors that
are normal, independent and without bias. A message names its sender, so a track is a robot's number and a
kind its team, and it may carry the sender's compass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision.data import BoolArray, Estimates, IntArray
from swarmvision.geometry import FloatArray, wrap
from swarmvision.randomness import normal
from swarmvision.sensing.sight import BEARING, HEADING, RANGE, VISIBLE

NEAREST = 1e-3  # m; no reading is nearer


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviations of a reading."""

    range: float
    """m"""
    range_share: float
    """Of the range; the greater of the two counts."""
    bearing: float
    """rad"""
    heading: float | None
    """rad; None where no heading is told."""


def measured(
    who: IntArray, seen: FloatArray, kind: IntArray, spread: Spread, keys: NDArray[np.uint64], reading: int
) -> Estimates:
    """Return what robots read of the neighbours in their line of sight.

    Args:
        who: Numbers, -1 where a slot is empty, shape ``(r, k)``.
        seen: Range, bearing, heading and visible fraction, shape ``(r, k, 4)``.
        kind: Their teams, shape ``(r, k)``.
        spread: Of the errors.
        keys: Of the observers, shape ``(r,)``; errors depend on observer, neighbour and reading alone.
        reading: Its number.
    """
    there = who >= 0
    chance = [normal(keys[:, None], reading, who, channel) for channel in range(3)]
    true_range = seen[..., RANGE]
    deviation = np.maximum(spread.range, spread.range_share * true_range)
    covariance = np.full((*who.shape, 3, 3), np.nan)
    covariance[there] = 0.0
    covariance[there, 0, 0] = np.maximum(deviation[there], NEAREST) ** 2
    covariance[there, 1, 1] = max(spread.bearing, NEAREST) ** 2
    heading = np.full(who.shape, np.nan)
    if spread.heading is None:
        covariance[there, 2] = np.nan
        covariance[there, :, 2] = np.nan
    else:
        heading = wrap(seen[..., HEADING] + spread.heading * chance[2])
        covariance[there, 2, 2] = max(spread.heading, NEAREST) ** 2
    return Estimates(
        seen=there,
        range=np.maximum(true_range + deviation * chance[0], NEAREST),
        bearing=wrap(seen[..., BEARING] + spread.bearing * chance[1]),
        heading=heading,
        covariance=covariance,
        age=np.where(there, 0.0, np.nan),
        track=who,
        visible=np.where(there, seen[..., VISIBLE], 0.0),
        kind=kind,
    )


def only(who: IntArray, seen: FloatArray, kept: BoolArray) -> tuple[IntArray, FloatArray]:
    """Return whom to keep ``(r, k)`` and what is seen of them, in the first slots of each robot."""
    kept = kept & (who >= 0)
    width = int(kept.sum(axis=1).max(initial=0))
    first = np.argsort(~kept, axis=1, kind="stable")[:, :width]
    chosen = np.take_along_axis(kept, first, axis=1)
    who = np.where(chosen, np.take_along_axis(who, first, axis=1), -1)
    seen = np.take_along_axis(seen, first[..., None], axis=1)
    return who, np.where(chosen[..., None], seen, np.nan)
