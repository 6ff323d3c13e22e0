"""Angles, planar poses and changes of frame.

A pose is an array ``(..., 3)`` of x (m), y (m) and yaw (rad); yaw grows counter-clockwise from x
(REP-103: x forward, y left). All functions broadcast over the leading axes. Transforms read like
fractions that cancel: ``compose(world_from_robot, robot_from_lens)`` is ``world_from_lens``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


def wrap(angle: ArrayLike) -> FloatArray:
    """Return the same direction (rad) in the half-open interval (-pi, pi]."""
    return np.pi - np.mod(np.pi - np.asarray(angle, dtype=np.float64), 2.0 * np.pi)


def rotate(vector: ArrayLike, angle: ArrayLike) -> FloatArray:
    """Return ``vector`` ``(..., 2)`` turned counter-clockwise by ``angle`` (rad) ``(...)``."""
    vector = np.asarray(vector, dtype=np.float64)
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def compose(a_from_b: ArrayLike, b_from_c: ArrayLike) -> FloatArray:
    """Return the pose ``a_from_c`` ``(..., 3)``: first ``b_from_c``, then ``a_from_b``."""
    outer = np.asarray(a_from_b, dtype=np.float64)
    inner = np.asarray(b_from_c, dtype=np.float64)
    place = outer[..., :2] + rotate(inner[..., :2], outer[..., 2])
    yaw = wrap(outer[..., 2] + inner[..., 2])
    return np.concatenate([place, yaw[..., None]], axis=-1)


def inverse(a_from_b: ArrayLike) -> FloatArray:
    """Return the pose ``b_from_a`` ``(..., 3)``."""
    pose = np.asarray(a_from_b, dtype=np.float64)
    place = rotate(-pose[..., :2], -pose[..., 2])
    return np.concatenate([place, wrap(-pose[..., 2])[..., None]], axis=-1)


def polar(pose: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return range (m), bearing (rad) and heading (rad) of a pose ``(..., 3)`` seen from its frame."""
    pose = np.asarray(pose, dtype=np.float64)
    distance = np.hypot(pose[..., 0], pose[..., 1])
    bearing = np.arctan2(pose[..., 1], pose[..., 0])
    return distance, bearing, wrap(pose[..., 2])


def cartesian(distance: ArrayLike, bearing: ArrayLike) -> FloatArray:
    """Return the place ``(..., 2)`` (m, x forward, y left) at a range (m) and bearing (rad)."""
    distance = np.asarray(distance, dtype=np.float64)
    return np.stack([distance * np.cos(bearing), distance * np.sin(bearing)], axis=-1)
