"""Nonlinear least squares for a few dozen parameters, in NumPy alone.

Source: K. Levenberg (1944, doi:10.1090/qam/10666) and D. W. Marquardt (1963, doi:10.1137/0111030). The
Jacobian is taken by central differences, so a model is one function and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from swarmvision.geometry import FloatArray

ROUNDS = 80  # most steps that are tried
DONE = 1e-9  # relative change of the cost under which a step has converged
LOOSEST, STIFFEST = 1e-12, 1e12  # of the damping


@dataclass(frozen=True, eq=False, slots=True)
class Solution:
    """Where the sum of squares is least."""

    parameters: FloatArray
    """Shape ``(p,)``."""
    residuals: FloatArray
    """Shape ``(m,)``."""
    covariance: FloatArray
    """Of the parameters, for residuals of unit variance; infinite where they do not tell, ``(p, p)``."""

    @property
    def cost(self) -> float:
        """Sum of the squared residuals."""
        return float(self.residuals @ self.residuals)


def solve(residuals: Callable[[FloatArray], FloatArray], start: FloatArray, step: FloatArray) -> Solution:
    """Return the least squares solution near a start.

    Args:
        residuals: Of parameters ``(p,)``, each divided by its standard deviation, shape ``(m,)``.
        start: Shape ``(p,)``.
        step: Of the differences, in the unit of each parameter, shape ``(p,)``.
    """
    at, found = start.astype(np.float64), residuals(start)
    damping = 1e-3
    jacobian = _jacobian(residuals, at, step)
    for _ in range(ROUNDS):
        normal, slope = jacobian.T @ jacobian, jacobian.T @ found
        stiff = normal + damping * np.diag(np.maximum(np.diag(normal), 1e-12))
        trial = at - np.linalg.lstsq(stiff, slope, rcond=None)[0]
        with np.errstate(all="ignore"):  # a step too long may leave the finite numbers; it is not taken
            there = residuals(trial)
            gain = float(found @ found - there @ there)
        if not gain > 0.0:  # also where the trial is not finite
            damping *= 10.0
            if damping > STIFFEST:
                break
            continue
        settled = gain <= DONE * float(found @ found)
        at, found, damping = trial, there, max(damping / 10.0, LOOSEST)
        jacobian = _jacobian(residuals, at, step)
        if settled:
            break
    return Solution(at, found, _covariance(jacobian))


def _jacobian(residuals: Callable[[FloatArray], FloatArray], at: FloatArray, step: FloatArray) -> FloatArray:
    columns = []
    for i in range(len(at)):
        move = np.zeros(len(at))
        move[i] = step[i]
        columns.append((residuals(at + move) - residuals(at - move)) / (2.0 * step[i]))
    return np.stack(columns, axis=1)


def _covariance(jacobian: FloatArray) -> FloatArray:
    """Return the inverse of the normal matrix; infinite for parameters in its null space."""
    size = np.linalg.norm(jacobian, axis=0)
    size[size < 1e-100] = 1.0  # not seen at all: a zero singular value
    _, values, axes = np.linalg.svd(jacobian / size, full_matrices=False)
    told = values > 1e-9 * values[0]
    inverse: FloatArray = (axes[told].T / values[told] ** 2) @ axes[told] / np.outer(size, size)
    untold = (np.abs(axes[~told]) > 1e-6).any(axis=0)
    inverse[untold, untold] = np.inf
    return inverse
