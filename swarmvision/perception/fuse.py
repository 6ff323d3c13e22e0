"""What several lenses of one robot see, as one list in the robot's frame."""

from __future__ import annotations

import numpy as np

from swarmvision.data import Estimates
from swarmvision.geometry import FloatArray, wrap

NEAREST_AXES = 0.08  # m: two robots' axes cannot be nearer, so what is nearer is one robot


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
    if sum(counts) == 0:
        return Estimates.empty((0,))
    pose = np.repeat(robot_from_lens, counts, axis=0)
    lens_range = np.concatenate([reading.range for reading in readings])
    direction = np.concatenate([reading.bearing for reading in readings]) + pose[:, 2]
    heading = wrap(np.concatenate([reading.heading for reading in readings]) + pose[:, 2])
    visible = np.concatenate([reading.visible for reading in readings])
    x = pose[:, 0] + lens_range * np.cos(direction)
    y = pose[:, 1] + lens_range * np.sin(direction)
    distance, bearing = np.hypot(x, y), np.arctan2(y, x)
    # Jacobian of (range, bearing) at the robot by (range, bearing) at the lens.
    turn = direction - bearing
    change = np.zeros((len(x), 3, 3))
    change[:, 0, 0], change[:, 0, 1] = np.cos(turn), -lens_range * np.sin(turn)
    change[:, 1, 0], change[:, 1, 1] = np.sin(turn) / distance, lens_range * np.cos(turn) / distance
    change[:, 2, 2] = 1.0
    blind = np.isnan(heading)
    covariance = np.concatenate([reading.covariance for reading in readings])
    covariance[blind, 2, :] = covariance[blind, :, 2] = 0.0
    covariance = change @ covariance @ np.swapaxes(change, -1, -2)
    rows = np.column_stack([distance, bearing, heading])
    if len(rows) > 1:
        rows, covariance, visible = _merged(rows, covariance, visible)
    blind = np.isnan(rows[:, 2])
    covariance[blind, 2, :] = covariance[blind, :, 2] = np.nan
    k = len(rows)
    return Estimates(
        seen=np.ones(k, dtype=bool),
        range=rows[:, 0],
        bearing=wrap(rows[:, 1]),
        heading=rows[:, 2],
        covariance=covariance,
        age=np.zeros(k),
        track=np.full(k, -1),
        visible=visible,
    )


def _merged(
    rows: FloatArray, covariance: FloatArray, visible: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Join rows ``(n, 3)`` whose places are nearer than two robots can be; nearest first."""
    places = rows[:, 0] * np.exp(1j * rows[:, 1])
    left = list(np.lexsort((rows[:, 1], rows[:, 0])))
    out_rows, out_covariance, out_visible = [], [], []
    while left:
        first = left.pop(0)
        same = [first] + [i for i in left if abs(places[i] - places[first]) < NEAREST_AXES]
        left = [i for i in left if i not in same]
        row, spread = rows[first], covariance[first]
        for other in same[1:]:
            row, spread = _weighted(row, spread, rows[other], covariance[other])
        out_rows.append(row)
        out_covariance.append(spread)
        out_visible.append(visible[same].max())
    return np.array(out_rows), np.array(out_covariance), np.array(out_visible)


def _weighted(
    one: FloatArray, one_covariance: FloatArray, two: FloatArray, two_covariance: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the information-weighted mean of two estimates and its covariance."""
    if np.isnan(two[2]) or np.isnan(one[2]):
        blind_one = np.isnan(one[2])
        keep, keep_covariance = (two, two_covariance) if blind_one else (one, one_covariance)
        return keep, keep_covariance
    difference = two - one
    difference[1:] = wrap(difference[1:])
    gain = one_covariance @ np.linalg.inv(one_covariance + two_covariance)
    mean = one + gain @ difference
    mean[1:] = wrap(mean[1:])
    rest = np.eye(3) - gain
    joined = rest @ one_covariance @ rest.T + gain @ two_covariance @ gain.T
    return mean, joined
