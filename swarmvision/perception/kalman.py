"""The filter of one neighbour: carry on, compare, improve. Kernels on the arrays of one state.

Updates are in Joseph's form (R. S. Bucy, P. D. Joseph, "Filtering for Stochastic Processes", 1968),
``(I - K H) P (I - K H)^T + K R K^T``: a sum of two squares, so covariances stay positive definite.
``H`` picks the first two or three of the state, so its products are mere slices.
"""

from __future__ import annotations

import math

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray
from swarmvision.perception.planar import wrapped

STATE = 6  # x, y, psi and their rates, in the observer's frame
TINY = 1e-18  # least pivot: a covariance of measurements that tell nothing new


@compiled
def carry_on(
    state: FloatArray,
    covariance: FloatArray,
    speed: float,
    turn_rate: float,
    dt: float,
    acceleration: float,
    turn_acceleration: float,
) -> None:
    """Move a state of constant velocity on by ``dt`` (s), into the frame of an observer who moves too.

    The observer's way is an arc. The neighbour's unknown acceleration is white and constant over a
    step (Y. Bar-Shalom et al., "Estimation with Applications to Tracking and Navigation", 2001, 6.3.2).

    Args:
        state: x, y, psi, vx, vy, psi rate ``(6,)``; velocities are over ground, along the observer's axes.
        covariance: ``(6, 6)``.
        speed: The observer's (m/s).
        turn_rate: The observer's (rad/s).
        dt: s; nothing happens at 0.
        acceleration: Spread of the neighbour's (m/s^2).
        turn_acceleration: Likewise (rad/s^2).
    """
    if dt <= 0.0:
        return
    turn = turn_rate * dt
    chord = speed * dt
    if abs(turn) > 1e-9:
        chord *= math.sin(turn / 2.0) / (turn / 2.0)
    cos, sin = math.cos(turn), math.sin(turn)
    x = state[0] + dt * state[3] - chord * math.cos(turn / 2.0)
    y = state[1] + dt * state[4] - chord * math.sin(turn / 2.0)
    state[0], state[1] = cos * x + sin * y, cos * y - sin * x
    state[2] = wrapped(state[2] + dt * state[5] - turn)
    vx, vy = state[3], state[4]
    state[3], state[4] = cos * vx + sin * vy, cos * vy - sin * vx
    for j in range(STATE):  # rows of F P
        for i in range(3):
            covariance[i, j] += dt * covariance[i + 3, j]
        for i in range(0, STATE, 3):
            x, y = covariance[i, j], covariance[i + 1, j]
            covariance[i, j], covariance[i + 1, j] = cos * x + sin * y, cos * y - sin * x
    for i in range(STATE):  # columns of (F P) F^T
        for j in range(3):
            covariance[i, j] += dt * covariance[i, j + 3]
        for j in range(0, STATE, 3):
            x, y = covariance[i, j], covariance[i, j + 1]
            covariance[i, j], covariance[i, j + 1] = cos * x + sin * y, cos * y - sin * x
    for i in range(3):
        spread = turn_acceleration if i == 2 else acceleration
        variance = spread * spread * dt * dt
        covariance[i, i] += variance * dt * dt / 4.0
        covariance[i, i + 3] += variance * dt / 2.0
        covariance[i + 3, i] += variance * dt / 2.0
        covariance[i + 3, i + 3] += variance
    _level(covariance)


@compiled
def squared_distance(
    state: FloatArray, covariance: FloatArray, row: FloatArray, spread: FloatArray, told: int, limit: float
) -> float:
    """Return the squared Mahalanobis distance of a measurement; infinite where it is beyond ``limit``.

    Args:
        state: Begins with x, y, psi.
        covariance: Of the state.
        row: x, y, psi of the measurement.
        spread: Its covariance, ``(3, 3)``.
        told: How many of them are told, 2 or 3.
        limit: Largest that is of interest.
    """
    x, y = row[0] - state[0], row[1] - state[1]
    # No direction is more uncertain than all of them together: cheap, and refuses most.
    widest = covariance[0, 0] + spread[0, 0] + covariance[1, 1] + spread[1, 1]
    if x * x + y * y > limit * widest:
        return math.inf
    factor, off = np.empty((3, 3)), np.empty(3)
    off[0], off[1] = x, y
    if told == 3:
        off[2] = wrapped(row[2] - state[2])
    _factor(covariance, spread, told, factor)
    square = 0.0
    for i in range(told):
        value = off[i]
        for j in range(i):
            value -= factor[i, j] * off[j]
        off[i] = value / factor[i, i]
        square += off[i] * off[i]
    return square if square <= limit else math.inf


@compiled
def improve(
    state: FloatArray, covariance: FloatArray, row: FloatArray, spread: FloatArray, told: int
) -> None:
    """Take a measurement into a state ``(n,)`` that begins with x, y, psi; arguments as above."""
    n = len(state)
    off, gain, rest = np.empty(3), np.empty((n, 3)), np.empty((n, n))
    _write_gain(covariance, spread, told, gain)
    for i in range(told):
        off[i] = row[i] - state[i]
    if told == 3:
        off[2] = wrapped(off[2])
    for i in range(n):
        for j in range(told):
            state[i] += gain[i, j] * off[j]
    state[2] = wrapped(state[2])
    for i in range(n):  # (I - K H) P
        for j in range(n):
            value = covariance[i, j]
            for k in range(told):
                value -= gain[i, k] * covariance[k, j]
            rest[i, j] = value
    for i in range(n):
        for j in range(i + 1):
            value = rest[i, j]
            for k in range(told):
                noise = 0.0
                for m in range(told):
                    noise += gain[i, m] * spread[m, k]
                value += (noise - rest[i, k]) * gain[j, k]
            covariance[i, j] = covariance[j, i] = value


@compiled
def _write_gain(covariance: FloatArray, spread: FloatArray, told: int, gain: FloatArray) -> None:
    """Write ``K = P H^T S^-1``, ``(n, told)``."""
    factor = np.empty((3, 3))
    _factor(covariance, spread, told, factor)
    for i in range(len(gain)):
        for j in range(told):  # forward: L z = P H^T
            value = covariance[i, j]
            for k in range(j):
                value -= factor[j, k] * gain[i, k]
            gain[i, j] = value / factor[j, j]
        for j in range(told - 1, -1, -1):  # backward: L^T K^T = z
            value = gain[i, j]
            for k in range(j + 1, told):
                value -= factor[k, j] * gain[i, k]
            gain[i, j] = value / factor[j, j]


@compiled
def _factor(covariance: FloatArray, spread: FloatArray, size: int, out: FloatArray) -> None:
    """Write the lower Cholesky factor of the innovation's covariance."""
    for i in range(size):
        for j in range(i + 1):
            value = covariance[i, j] + spread[i, j]
            for k in range(j):
                value -= out[i, k] * out[j, k]
            out[i, j] = math.sqrt(max(value, TINY)) if i == j else value / out[j, j]


@compiled
def _level(matrix: FloatArray) -> None:
    """Take out what rounding leaves of asymmetry."""
    for i in range(len(matrix)):
        for j in range(i):
            matrix[i, j] = matrix[j, i] = (matrix[i, j] + matrix[j, i]) / 2.0
