"""Rows to columns at the least total cost."""

from __future__ import annotations

import math

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray


@compiled
def assignment(cost: FloatArray) -> IntArray:
    """Return for each row its column in the assignment of least total cost; -1 for a row without one.

    The shortest augmenting path method in O(n^3): R. Jonker, A. Volgenant, Computing 38, 1987,
    doi:10.1007/BF02278710, without their start heuristics.

    Args:
        cost: Finite, shape ``(rows, columns)``.
    """
    rows, columns = cost.shape
    if rows <= columns:
        return _augmented(cost)
    back, turned = np.full(rows, -1, np.int64), np.empty((columns, rows))
    for row in range(rows):
        for column in range(columns):
            turned[column, row] = cost[row, column]
    partner = _augmented(turned)
    for column in range(columns):
        back[partner[column]] = column
    return back


@compiled
def _augmented(cost: FloatArray) -> IntArray:
    """Return :func:`assignment` where no rows are more than columns."""
    rows, columns = cost.shape
    u, v = np.zeros(rows + 1), np.zeros(columns + 1)
    row_of = np.zeros(columns + 1, np.int64)  # 1-based; 0 is free
    came_from = np.zeros(columns + 1, np.int64)
    least, used = np.empty(columns + 1), np.empty(columns + 1, np.bool_)
    for row in range(1, rows + 1):
        row_of[0], column = row, 0
        least[:], used[:] = math.inf, False
        while row_of[column] != 0:
            used[column] = True
            i, step, after = row_of[column], math.inf, 0
            for j in range(1, columns + 1):
                if used[j]:
                    continue
                reduced = cost[i - 1, j - 1] - u[i] - v[j]
                if reduced < least[j]:
                    least[j], came_from[j] = reduced, column
                if least[j] < step:
                    step, after = least[j], j
            for j in range(columns + 1):
                if used[j]:
                    u[row_of[j]] += step
                    v[j] -= step
                else:
                    least[j] -= step
            column = after
        while column != 0:
            row_of[column] = row_of[came_from[column]]
            column = came_from[column]
    partner = np.full(rows, -1, np.int64)
    for column in range(1, columns + 1):
        if row_of[column] != 0:
            partner[row_of[column] - 1] = column - 1
    return partner
