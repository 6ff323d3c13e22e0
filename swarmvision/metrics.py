"""What a swarm did and how well it saw: pure functions of arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from swarmvision.data import BoolArray, Estimates
from swarmvision.geometry import FloatArray, compose, inverse, polar, wrap

MATCH_BEARING = np.radians(3.0)  # an estimate farther off is not of that neighbour
MATCH_RANGE = 0.25  # of the true range
BINS = (0.0, 0.25, 0.5, 1.0, 1.5, np.inf)  # m: rows of the perception table


def order(yaw: ArrayLike) -> FloatArray:
    """Return the polar order ``|mean(exp(i yaw))|`` of headings ``(..., r)``: 1 is aligned.

    Random headings give about ``1/sqrt(r)``; a swarm of nobody is aligned. T. Vicsek et al., Phys. Rev.
    Lett. 75, 1995, doi:10.1103/PhysRevLett.75.1226.
    """
    yaw = np.asarray(yaw, dtype=np.float64)
    if yaw.shape[-1] == 0:
        return np.ones(yaw.shape[:-1])
    aligned: FloatArray = np.abs(np.exp(1j * yaw).mean(axis=-1))
    return aligned


def cluster_labels(position: ArrayLike, link: float) -> NDArray[np.int64]:
    """Return for each place ``(r, 2)`` (m) the number of its cluster, shape ``(r,)``.

    Two places within ``link`` (m) are of one cluster, and so is whoever is linked to either.
    """
    place = np.asarray(position, dtype=np.float64).reshape(-1, 2)
    linked = np.hypot(*np.moveaxis(place[:, None] - place[None], -1, 0)) <= link
    labels = np.arange(len(place))
    while True:  # the least label spreads; a chain of r needs at most r rounds
        spread = np.min(np.where(linked, labels[None], len(place)), axis=1, initial=len(place))
        if np.array_equal(spread, labels):
            return np.unique(labels, return_inverse=True)[1].astype(np.int64)
        labels = spread


def largest_cluster(position: ArrayLike, link: float) -> float:
    """Return the fraction of places ``(r, 2)`` (m) that are in the largest cluster; 1 for nobody."""
    labels = cluster_labels(position, link)
    return float(np.bincount(labels).max() / len(labels)) if len(labels) else 1.0


@dataclass(frozen=True, eq=False, slots=True)
class PerceptionErrors:
    """What robots believed against what was true, for every neighbour within reach."""

    true_range: FloatArray
    """m, shape ``(n,)``."""
    found: BoolArray
    """Whether an estimate matches, shape ``(n,)``."""
    range_error: FloatArray
    """Estimate minus truth (m); nan where not found, shape ``(n,)``."""
    bearing_error: FloatArray
    """rad, likewise."""
    heading_error: FloatArray
    """rad, likewise, and nan where not told."""
    phantoms: int
    """Fresh estimates that match nobody."""


def perception_errors(pose: FloatArray, estimates: Estimates, reach: float) -> PerceptionErrors:
    """Compare fresh estimates (age 0) with the truth at one instant.

    Args:
        pose: Of the robots, shape ``(r, 3)``.
        estimates: Robot frame, shape ``(r, k)``.
        reach: Neighbours farther away are not expected (m).
    """
    r = len(pose)
    distance, bearing, heading = polar(compose(inverse(pose)[:, None], pose[None]))  # (r, r)
    wanted = (distance <= reach) & ~np.eye(r, dtype=bool)
    fresh = estimates.seen & (np.nan_to_num(estimates.age, nan=1.0) < 1e-9)
    off_bearing = np.abs(wrap(estimates.bearing[:, :, None] - bearing[:, None, :]))  # (r, k, r)
    off_range = np.abs(estimates.range[:, :, None] / np.maximum(distance, 1e-9)[:, None, :] - 1.0)
    near = fresh[..., None] & (off_bearing < MATCH_BEARING) & (off_range < MATCH_RANGE)
    near &= ~np.eye(r, dtype=bool)[:, None, :]
    score = np.where(near, off_bearing / MATCH_BEARING + off_range / MATCH_RANGE, np.inf)
    match = np.full((r, r), -1)
    phantoms = int(np.count_nonzero(fresh))
    rows, slots, others = np.nonzero(np.isfinite(score))
    taken: set[tuple[int, int]] = set()
    for n in np.argsort(score[rows, slots, others], kind="stable"):
        row, slot, other = int(rows[n]), int(slots[n]), int(others[n])
        if match[row, other] < 0 and (row, slot) not in taken:
            match[row, other] = slot
            taken.add((row, slot))
            phantoms -= 1
    observer, neighbour = np.nonzero(wanted)
    slot_of = match[observer, neighbour]
    found = slot_of >= 0

    def error(estimate: FloatArray, truth: FloatArray) -> FloatArray:
        if estimate.shape[1] == 0:
            return np.full(len(observer), np.nan)
        return np.where(found, estimate[observer, slot_of] - truth[observer, neighbour], np.nan)

    return PerceptionErrors(
        true_range=distance[wanted],
        found=found,
        range_error=error(estimates.range, distance),
        bearing_error=wrap(error(estimates.bearing, bearing)),
        heading_error=wrap(error(estimates.heading, heading)),
        phantoms=phantoms,
    )


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
