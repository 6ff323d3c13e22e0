"""What several lenses of one robot see, as one list in the robot's frame."""

from __future__ import annotations

import math

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.data import Estimates, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.perception.kalman import improve
from swarmvision.perception.planar import NEAREST_AXES, plane_from_polar, polar_from_plane, take_over


def robot_frame(readings: list[Estimates], robot_from_lens: FloatArray) -> Estimates:
    """Return the neighbours of every lens in the frame of the robot that carries them.

    Range then starts at the robot's axis. A neighbour that two lenses see is told once, weighted by
    the inverse of its covariances.

    Args:
        readings: One per lens, lens frame, each ``(k_i,)``.
        robot_from_lens: Pose of every lens, shape ``(lenses, 3)``.

    Returns:
        Nearest first, robot frame, shape ``(k,)``.
    """
    counts = [len(reading.seen) for reading in readings]
    total = sum(counts)
    polar, covariance = np.empty((total, 4)), np.empty((total, 3, 3))
    for reading, end in zip(readings, np.cumsum(counts, dtype=int), strict=True):
        lens_rows(reading, polar[end - len(reading.seen) : end], covariance[end - len(reading.seen) : end])
    rows, spreads = np.empty((total, 4)), np.empty((total, 3, 3))
    lenses = np.repeat(np.arange(len(counts)), counts)
    mounts = np.ascontiguousarray(robot_from_lens, dtype=np.float64)
    k = fuse(polar, covariance, lenses, mounts, math.inf, rows, spreads)
    for i in range(k):
        polar_from_plane(rows[i], spreads[i], not math.isnan(rows[i, 2]), polar[i], covariance[i])
    return Estimates(
        seen=np.ones(k, dtype=bool),
        range=polar[:k, 0],
        bearing=polar[:k, 1],
        heading=polar[:k, 2],
        covariance=covariance[:k],
        age=np.zeros(k),
        track=np.full(k, -1),
        visible=rows[:k, 3],
    )


def lens_rows(reading: Estimates, polar: FloatArray, covariance: FloatArray) -> None:
    """Write a reading ``(k,)`` as :func:`fuse` takes it: ``(k, 4)`` and ``(k, 3, 3)``."""
    polar[:, 0], polar[:, 1], polar[:, 2] = reading.range, reading.bearing, reading.heading
    polar[:, 3], covariance[:] = reading.visible, reading.covariance


@compiled
def fuse(
    polar: FloatArray,
    covariance: FloatArray,
    lens: IntArray,
    mounts: FloatArray,
    reach: float,
    rows: FloatArray,
    spreads: FloatArray,
) -> int:
    """Write every neighbour once, in the plane of the robot, nearest first; return how many.

    Args:
        polar: Range (m), bearing, heading (rad; nan where not told), visible, by lens, ``(n, 4)``.
        covariance: Of the first three, ``(n, 3, 3)``.
        lens: Which lens saw each, ``(n,)``.
        mounts: x, y, yaw of the lenses on the robot, ``(lenses, 3)``.
        reach: Who is farther from the robot's axis is left out (m).
        rows: Out, x, y, psi, visible, room for ``n``.
        spreads: Out, covariances of x, y, psi, room for ``n``.
    """
    n = len(polar)
    far, order = np.empty(n), np.empty(n, np.int64)
    plane, plane_spread = np.empty((n, 4)), np.empty((n, 3, 3))
    for k in range(n):
        plane_from_polar(polar[k], covariance[k], mounts[lens[k]], plane[k], plane_spread[k])
        plane[k, 3] = polar[k, 3]
        far[k] = math.hypot(plane[k, 0], plane[k, 1])
        place = k
        while place > 0 and far[order[place - 1]] > far[k]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = k
    fused = 0
    used = np.zeros(n, np.bool_)
    for a in range(n):
        first = order[a]
        if used[first]:
            continue
        row, spread = rows[fused], spreads[fused]
        take_over(row, spread, plane[first], plane_spread[first])
        for b in range(a + 1, n):
            other = order[b]
            if far[other] >= far[first] + NEAREST_AXES:
                break
            away = math.hypot(plane[other, 0] - plane[first, 0], plane[other, 1] - plane[first, 1])
            if not used[other] and away < NEAREST_AXES:
                used[other] = True
                _join(row, spread, plane[other], plane_spread[other])
        if math.hypot(row[0], row[1]) <= reach:
            fused += 1
    return fused


@compiled
def _join(row: FloatArray, spread: FloatArray, other: FloatArray, other_spread: FloatArray) -> None:
    """Improve a row by another of its neighbour, which is lost; who tells no heading helps with the place."""
    told = 2 if math.isnan(other[2]) else 3
    most_visible = max(row[3], other[3])
    if math.isnan(row[2]) and told == 3:  # begin with the one that tells more
        improve(other[:3], other_spread, row, spread, 2)
        take_over(row, spread, other, other_spread)
    else:
        improve(row[:3], spread, other, other_spread, told)
    row[3] = most_visible
