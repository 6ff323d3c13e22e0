"""One neighbour's place and its covariance: from a lens's polar view to the robot's plane and back.

Kernels. A *plane row* is x (m), y (m) and psi (rad) of a neighbour in the observer's frame, with its
covariance ``(3, 3)``; psi is nan, and its covariances 0, where the heading is not told.
"""

from __future__ import annotations

import math

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray

NEAREST_AXES = 0.08  # m: two robots' axes cannot be nearer, so what is nearer is one robot


@compiled
def wrapped(angle: float) -> float:
    """Return the same direction (rad) in (-pi, pi]; the twin of :func:`swarmvision.geometry.wrap`."""
    return math.pi - (math.pi - angle) % (2.0 * math.pi)


@compiled
def take_over(row: FloatArray, spread: FloatArray, new_row: FloatArray, new_spread: FloatArray) -> None:
    """Write a row ``(n,)`` or more and its covariance ``(n, n)`` over others.

    Not by slices: for what it says where these do not fit, numba would compile its strings, for seconds.
    """
    for i in range(len(row)):
        row[i] = new_row[i]
    for i in range(len(spread)):
        for j in range(len(spread)):
            spread[i, j] = new_spread[i, j]


@compiled
def congruent(change: FloatArray, covariance: FloatArray, out: FloatArray) -> None:
    """Write ``J C J^T`` of 3 x 3 matrices, exactly symmetric."""
    half = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            half[i, j] = (
                change[i, 0] * covariance[0, j]
                + change[i, 1] * covariance[1, j]
                + change[i, 2] * covariance[2, j]
            )
    for i in range(3):
        for j in range(i + 1):
            value = half[i, 0] * change[j, 0] + half[i, 1] * change[j, 1] + half[i, 2] * change[j, 2]
            out[i, j] = out[j, i] = value


@compiled
def plane_from_polar(
    polar: FloatArray, covariance: FloatArray, mount: FloatArray, row: FloatArray, spread: FloatArray
) -> None:
    """Write the plane row of what a lens measured.

    Args:
        polar: Range (m), bearing and heading (rad; nan where not told) from the lens; more is ignored.
        covariance: Of those, ``(3, 3)``.
        mount: x, y, yaw of the lens on the robot.
        row: Out, x, y, psi in the robot's frame.
        spread: Out, their covariance.
    """
    distance, direction = polar[0], polar[1] + mount[2]
    cos, sin = math.cos(direction), math.sin(direction)
    row[0], row[1] = mount[0] + distance * cos, mount[1] + distance * sin
    change = np.zeros((3, 3))
    change[0, 0], change[0, 1] = cos, -distance * sin
    change[1, 0], change[1, 1] = sin, distance * cos
    change[2, 2] = 1.0
    told = not math.isnan(polar[2])
    row[2] = wrapped(polar[2] + mount[2]) if told else math.nan
    known = np.zeros((3, 3))
    for i in range(3 if told else 2):
        for j in range(3 if told else 2):
            known[i, j] = covariance[i, j]
    congruent(change, known, spread)


@compiled
def polar_from_plane(
    row: FloatArray, spread: FloatArray, told: bool, polar: FloatArray, covariance: FloatArray
) -> None:
    """Write range, bearing, heading and their covariance of a plane row; nan where heading is not told."""
    distance = max(math.hypot(row[0], row[1]), 1e-12)
    cos, sin = row[0] / distance, row[1] / distance
    change = np.zeros((3, 3))
    change[0, 0], change[0, 1] = cos, sin
    change[1, 0], change[1, 1] = -sin / distance, cos / distance
    change[2, 2] = 1.0
    congruent(change, spread, covariance)
    polar[0], polar[1] = distance, wrapped(math.atan2(row[1], row[0]))
    polar[2] = wrapped(row[2]) if told else math.nan
    if not told:
        for i in range(3):
            covariance[i, 2] = covariance[2, i] = math.nan
