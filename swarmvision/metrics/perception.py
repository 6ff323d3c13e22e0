"""How well robots saw: every neighbour in reach against what was believed of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.data import BoolArray, Estimates, IntArray
from swarmvision.geometry import FloatArray

MATCH_BEARING = np.radians(3.0)  # an estimate farther off is not of that neighbour,
MATCH_RANGE = 0.25  # nor one farther off by this share of the true range,
MATCH_SIGMA = 3.0  # unless it says itself that it is no better: this many of its standard deviations
BINS = (0.0, 0.25, 0.5, 1.0, 1.5, np.inf)  # m: rows of the perception table
FRESH = 1e-9  # s
KEPT = 10.0  # a track that stays goes before every other pair, whose scores are below 2
UNKNOWN: IntArray = np.full((1, 1), -1)
"""Stands for the tracks of all pairs where none is known."""


@dataclass(frozen=True, eq=False, slots=True)
class PerceptionErrors:
    """What robots believed against what was true, for every neighbour within reach, observer by observer."""

    observer: IntArray
    """Shape ``(n,)``."""
    neighbour: IntArray
    """Shape ``(n,)``."""
    true_range: FloatArray
    """m, shape ``(n,)``."""
    found: BoolArray
    """Whether an estimate matches, shape ``(n,)``."""
    track: IntArray
    """Of the estimate that matches; -1 without, shape ``(n,)``."""
    range_error: FloatArray
    """Estimate minus truth (m); nan where not found, shape ``(n,)``."""
    bearing_error: FloatArray
    """rad, likewise."""
    heading_error: FloatArray
    """rad, likewise, and nan where not told."""
    phantoms_of: IntArray
    """Fresh estimates that match nobody, by observer, shape ``(r,)``."""
    fresh_of: IntArray
    """Fresh estimates, likewise."""

    @property
    def phantoms(self) -> int:
        """How many fresh estimates match nobody."""
        return int(self.phantoms_of.sum())

    @property
    def fresh(self) -> int:
        """How many estimates are fresh."""
        return int(self.fresh_of.sum())

    @property
    def missed(self) -> int:
        """How many neighbours within reach nobody's estimate matches, those that are hidden among them."""
        return int(np.count_nonzero(~self.found))

    def by(self, observers: BoolArray) -> PerceptionErrors:
        """Return what these robots believed alone, mask ``(r,)``; robots keep their numbers."""
        theirs = observers[self.observer]
        return PerceptionErrors(
            observer=self.observer[theirs],
            neighbour=self.neighbour[theirs],
            true_range=self.true_range[theirs],
            found=self.found[theirs],
            track=self.track[theirs],
            range_error=self.range_error[theirs],
            bearing_error=self.bearing_error[theirs],
            heading_error=self.heading_error[theirs],
            phantoms_of=np.where(observers, self.phantoms_of, 0),
            fresh_of=np.where(observers, self.fresh_of, 0),
        )


def perception_errors(
    pose: FloatArray,
    estimates: Estimates,
    reach: float,
    oldest: float = 0.0,
    last_track: IntArray = UNKNOWN,
) -> PerceptionErrors:
    """Compare fresh estimates with the truth at one instant.

    Each estimate belongs to one neighbour at most. A track stays with its neighbour as long as it may; then
    come the likeliest pairs: those with the least sum of bearing and range error, each over the error at
    which a match ends.

    Args:
        pose: Of the robots, shape ``(r, 3)``.
        estimates: Robot frame, shape ``(r, k)``.
        reach: Neighbours farther away are not expected (m).
        oldest: Age to which an estimate is fresh (s): the sensor's latency.
        last_track: Which track each observer last had of each robot, -1 for none, shape ``(r, r)``.
    """
    told = estimates.seen & (np.nan_to_num(estimates.age, nan=np.inf) <= oldest + FRESH)
    variance = np.nan_to_num(estimates.covariance[..., (0, 1), (0, 1)])
    spread = MATCH_SIGMA * np.sqrt(np.maximum(variance, 0.0))
    columns = np.stack([estimates.range, estimates.bearing, estimates.heading], axis=-1)
    numbers, values, phantoms = _matched(pose, told, columns, spread, estimates.track, last_track, reach)
    observer, neighbour, slot = numbers.T
    found = slot >= 0
    track = np.full(len(slot), -1)
    track[found] = estimates.track[observer[found], slot[found]]
    return PerceptionErrors(
        observer=observer,
        neighbour=neighbour,
        true_range=values[:, 0],
        found=found,
        track=track,
        range_error=values[:, 1],
        bearing_error=values[:, 2],
        heading_error=values[:, 3],
        phantoms_of=phantoms,
        fresh_of=np.count_nonzero(told, axis=-1),
    )


@compiled
def _matched(
    pose: FloatArray,
    told: BoolArray,
    columns: FloatArray,
    spread: FloatArray,
    tracks: IntArray,
    last: IntArray,
    reach: float,
) -> tuple[IntArray, FloatArray, IntArray]:
    """Return observer, neighbour and slot of every neighbour within reach; its range and errors; phantoms."""
    r = len(pose)
    wanted = 0
    for me in range(r):
        for other in range(r):
            wanted += other != me and _distance(pose, me, other) <= reach
    numbers = np.empty((wanted, 3), np.int64)
    values = np.full((wanted, 4), np.nan)
    slot_of = np.empty(r, np.int64)
    phantoms = np.empty(r, np.int64)
    row = 0
    for me in range(r):
        phantoms[me] = told[me].sum() - _assign(
            pose, me, told[me], columns[me], spread[me], tracks[me], last[me % len(last)], slot_of
        )
        for other in range(r):
            distance = _distance(pose, me, other)
            if other == me or distance > reach:
                continue
            slot = slot_of[other]
            numbers[row, 0], numbers[row, 1], numbers[row, 2] = me, other, slot
            values[row, 0] = distance
            if slot >= 0:
                values[row, 1] = columns[me, slot, 0] - distance
                values[row, 2] = _turned(columns[me, slot, 1] - _bearing(pose, me, other))
                values[row, 3] = _turned(columns[me, slot, 2] - (pose[other, 2] - pose[me, 2]))
            row += 1
    return numbers, values, phantoms


@compiled
def _assign(
    pose: FloatArray,
    me: int,
    told: BoolArray,
    columns: FloatArray,
    spread: FloatArray,
    tracks: IntArray,
    last: IntArray,
    slot_of: IntArray,
) -> int:
    """Fill in which slot of an observer is of whom, -1 for none; return how many slots are somebody's."""
    slot_of[:] = -1
    slots, others, scores = [0], [0], [np.inf]  # likely pairs; the first is none, so that types are known
    asked = np.nonzero(told)[0]
    farthest = 0.0  # that any slot may be of
    for slot in asked:
        off = max(columns[slot, 0] / (1.0 - MATCH_RANGE), columns[slot, 0] + spread[slot, 0])
        farthest = max(farthest, off)
    for other in range(len(pose)):
        distance = _distance(pose, me, other)
        if other == me or distance > farthest:
            continue
        bearing = _bearing(pose, me, other)
        for slot in asked:
            gate = max(MATCH_RANGE * distance, spread[slot, 0])
            off_range = abs(columns[slot, 0] - distance)
            if not off_range < gate:
                continue
            gate_bearing = max(MATCH_BEARING, spread[slot, 1])
            off = abs(_turned(columns[slot, 1] - bearing))
            if off < gate_bearing:
                slots.append(int(slot))
                others.append(other)
                stays = tracks[slot] >= 0 and tracks[slot] == last[other % len(last)]
                scores.append(off / gate_bearing + off_range / gate - (KEPT if stays else 0.0))
    taken = np.zeros(len(told), np.bool_)
    for n in np.argsort(np.array(scores), kind="mergesort"):
        if n > 0 and slot_of[others[n]] < 0 and not taken[slots[n]]:
            slot_of[others[n]] = slots[n]
            taken[slots[n]] = True
    return int(taken.sum())


@compiled
def _distance(pose: FloatArray, me: int, other: int) -> float:
    dx, dy = pose[other, 0] - pose[me, 0], pose[other, 1] - pose[me, 1]
    return float(np.sqrt(dx * dx + dy * dy))


@compiled
def _bearing(pose: FloatArray, me: int, other: int) -> float:
    dx, dy = pose[other, 0] - pose[me, 0], pose[other, 1] - pose[me, 1]
    return _turned(float(np.arctan2(dy, dx) - pose[me, 2]))


@compiled
def _turned(angle: float) -> float:
    """Return the same direction (rad) in (-pi, pi]; most are there already or a turn off."""
    if angle > np.pi:
        angle -= 2.0 * np.pi
    elif angle <= -np.pi:
        angle += 2.0 * np.pi
    if -np.pi < angle <= np.pi:
        return angle
    return float(np.pi - (np.pi - angle) % (2.0 * np.pi))


class TrackSwitches:
    """Counts how often an observer's track of a neighbour became another.

    The identity switches of K. Bernardin, R. Stiefelhagen, "Evaluating multiple object tracking performance:
    the CLEAR MOT metrics", EURASIP J. Image Video Process. 2008, doi:10.1155/2008/246309: a neighbour that is
    found again after a gap under another number counts too. Estimates without a track are left out.
    """

    def __init__(self, robots: int) -> None:
        self.count = 0
        self.last = np.full((robots, robots), -1)
        """The newest track of each robot by each observer, -1 before there was one, shape ``(r, r)``."""

    def note(self, errors: PerceptionErrors) -> None:
        """Take in what was found at one instant, in order of time."""
        tracked = errors.track >= 0
        pair = errors.observer[tracked], errors.neighbour[tracked]
        track = errors.track[tracked]
        self.count += int(np.count_nonzero((self.last[pair] >= 0) & (self.last[pair] != track)))
        self.last[pair] = track


def perception_table(errors: Sequence[PerceptionErrors]) -> list[dict[str, Any]]:
    """Return one row per range bin, and one over all, of how well neighbours were seen.

    Median and 95th percentile of the absolute errors; None where nothing was found.
    """
    if not errors:
        return []
    true_range = np.concatenate([e.true_range for e in errors])
    found = np.concatenate([e.found for e in errors])
    columns = {
        "range_percent": 100.0
        * np.concatenate([e.range_error for e in errors])
        / np.maximum(true_range, 1e-9),
        "bearing_deg": np.degrees(np.concatenate([e.bearing_error for e in errors])),
        "heading_deg": np.degrees(np.concatenate([e.heading_error for e in errors])),
    }
    rows = []
    for low, high in [*pairwise(BINS), (0.0, np.inf)]:
        inside = (true_range >= low) & (true_range < high)
        if not inside.any() and (low, high) != (0.0, np.inf):
            continue
        row: dict[str, Any] = {
            "from_m": low,
            "to_m": high if np.isfinite(high) else None,
            "neighbours": int(np.count_nonzero(inside)),
            "found": int(np.count_nonzero(inside & found)),
        }
        for name, error in columns.items():
            values = np.abs(error[inside & np.isfinite(error)])
            for label, share in (("median", 50), ("p95", 95)):
                row[f"{name}_{label}"] = float(np.percentile(values, share)) if len(values) else None
        rows.append(row)
    rows[-1]["phantoms"] = sum(e.phantoms for e in errors)
    return rows
