"""One Gauss-Newton step with the colours projected out, robustly weighted.

Colours enter the model linearly, so in every step they are eliminated and then follow (variable
projection: G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10, 1973, doi:10.1137/0710036, in L. Kaufman's
simplification, BIT 15, 1975, doi:10.1007/BF01932995).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray
from swarmvision.perception.model import FREE, HEADING

NOISE = 0.012  # of white: least residual that counts as one standard deviation
STRANGE = 0.1  # of white: a residual as large is not of the marker
TAIL = 3.0  # standard deviations from which on a pixel's pull declines


@compiled
def weigh(
    out: FloatArray,
    count: int,
    used: NDArray[np.int64],
    values: FloatArray,
    inside: NDArray[np.bool_],
    colours: FloatArray,
    misfit: float,
) -> tuple[float, float, float]:
    """Write the residuals and scale every pixel's rows by the root of its weight.

    The weight is ``1 / (1 + (r / (TAIL * misfit))^2)^2``, all 1 at a misfit of 0.

    Args:
        out: From :func:`model`, ``(3, n, colours + 3 + 12 + 1)``.
        count: Pixels that are written.
        used: Which they are.
        values: What the picture has, ``(3, all)``.
        inside: Which pixels surely show the marker and nothing beside it, ``(all,)``.
        colours: See :func:`model`.
        misfit: Of the step before.

    Returns:
        The new misfit: one standard deviation of the residuals of the pixels that fit; the loss, the
        root of the mean of ``r^2 / (1 + (r / STRANGE)^2)`` over all pixels, which no weight can hide; and
        the same over the pixels inside, which does not feel what stands behind the marker.
    """
    width, last = colours.shape[1], out.shape[2] - 1
    residual = np.empty(3)
    heavy = total = loss = own = 0.0
    owned = 0
    for n in range(count):
        square = 0.0
        for channel in range(3):
            value = values[channel, used[n]]
            for k in range(width):
                value -= colours[channel, k] * out[channel, n, k]
            residual[channel] = value
            square += value * value / 3.0
        bounded = square / (1.0 + square / STRANGE**2)
        loss += bounded
        if inside[used[n]]:
            own += bounded
            owned += 1
        root = 1.0
        if misfit > 0.0:
            root = 1.0 / (1.0 + square / (TAIL * misfit) ** 2)
        for channel in range(3):
            for k in range(last):
                out[channel, n, k] *= root
            out[channel, n, last] = root * residual[channel]
        heavy += root * root * min(square, (TAIL * misfit) ** 2 if misfit > 0.0 else square)
        total += root * root
    misfit = max(math.sqrt(heavy / max(total, 1e-9)), NOISE)
    return misfit, math.sqrt(loss / max(count, 1)), math.sqrt(own / max(owned, 1))


@compiled
def products(out: FloatArray, count: int, grams: FloatArray) -> None:
    """Write the products of all columns of every channel's rows with each other, ``(3, t, t)``.

    Not by a matrix product: the libraries behind that start threads, and these are small matrices
    inside threads of ours.
    """
    grams[:] = 0.0
    size = out.shape[2]
    by_four = count - count % 4
    for channel in range(3):
        gram = grams[channel]
        for n in range(0, by_four, 4):  # four rows at a time: the sums are fetched and stored once
            one, two, three, four = (
                out[channel, n],
                out[channel, n + 1],
                out[channel, n + 2],
                out[channel, n + 3],
            )
            for i in range(size):
                a, b, c, d = one[i], two[i], three[i], four[i]
                for j in range(size):
                    gram[i, j] += a * one[j] + b * two[j] + c * three[j] + d * four[j]
        for n in range(by_four, count):
            one = out[channel, n]
            for i in range(size):
                for j in range(size):
                    gram[i, j] += one[i] * one[j]


@compiled
def advance(
    grams: FloatArray,
    width: int,
    free: NDArray[np.bool_],
    theta: FloatArray,
    usual: FloatArray,
    loose: FloatArray,
    misfit: float,
    first: bool,
    colours: FloatArray,
    delta: FloatArray,
    covariance: FloatArray,
) -> bool:
    """Take one step from the products of all rows with each other; return whether that was possible.

    Args:
        grams: Of each channel, ``(3, t, t)`` with ``t = colours + 3 + 12 + 1``.
        width: How many colours, the background's included.
        free: Which parameters may move, ``(12,)``.
        theta: The parameters.
        usual: Their means before.
        loose: Their standard deviations before.
        misfit: One standard deviation of a residual.
        first: Whether only the colours are to be found.
        colours: Changed to the best ones, ``(3, width)``.
        delta: Out: the step, ``(12,)``.
        covariance: Out: of the parameters, over misfit squared, ``(12, 12)``; 0 where not free.
    """
    last = grams.shape[1] - 1
    chosen = np.empty(FREE, dtype=np.int64)
    count = 0
    for j in range(FREE):
        if free[j]:
            chosen[count] = j
            count += 1
    basis = np.empty((width, width))
    weight = 1e-9
    for i in range(width):
        weight = max(weight, grams[0, i, i])
    basis[:] = grams[0, :width, :width]
    for i in range(width):
        basis[i, i] += 1e-6 * weight
    if not cholesky(basis):
        return False
    normal, pull = np.zeros((count, count)), np.zeros((count, 1))
    coupling = np.empty((3, width, count + 1))
    for channel in range(3):
        gram = grams[channel]
        right = np.empty((width, count + 1))
        for i in range(width):
            for j in range(count):
                right[i, j] = gram[i, width + chosen[j]]
            right[i, count] = gram[i, last]
        solved = right.copy()
        substitute(basis, solved)
        coupling[channel] = solved
        for i in range(count):
            row = width + chosen[i]
            for j in range(count):
                value = gram[row, width + chosen[j]]
                for k in range(width):
                    value -= right[k, i] * solved[k, j]
                normal[i, j] += value
            value = gram[row, last]
            for k in range(width):
                value -= right[k, i] * solved[k, count]
            pull[i, 0] += value
    if first:
        for channel in range(3):
            for k in range(width):
                colours[channel, k] += coupling[channel, k, count]
        return True
    for i in range(count):
        if chosen[i] > HEADING:
            prior = (misfit / loose[chosen[i]]) ** 2
            normal[i, i] += prior
            pull[i, 0] += prior * (usual[chosen[i]] - theta[chosen[i]])
        normal[i, i] *= 1.0 + 1e-9
    if not cholesky(normal):
        return False
    substitute(normal, pull)
    inverse = np.eye(count)
    substitute(normal, inverse)
    delta[:] = 0.0
    covariance[:] = 0.0
    for i in range(count):
        delta[chosen[i]] = pull[i, 0]
        for j in range(count):
            covariance[chosen[i], chosen[j]] = inverse[i, j]
    for channel in range(3):
        for k in range(width):
            change = coupling[channel, k, count]
            for j in range(count):
                change -= coupling[channel, k, j] * pull[j, 0]
            colours[channel, k] += change
    return True


@compiled
def cholesky(matrix: FloatArray) -> bool:
    """Replace a symmetric matrix ``(n, n)`` by its lower factor; return whether it is positive definite."""
    for j in range(len(matrix)):
        for i in range(j, len(matrix)):
            value = matrix[i, j]
            for k in range(j):
                value -= matrix[i, k] * matrix[j, k]
            if i == j:
                if not value > 0.0:
                    return False
                matrix[j, j] = math.sqrt(value)
            else:
                matrix[i, j] = value / matrix[j, j]
    return True


@compiled
def substitute(factor: FloatArray, right: FloatArray) -> None:
    """Replace the right sides ``(n, m)`` by the solutions, given the lower factor ``(n, n)``."""
    n = len(factor)
    for c in range(right.shape[1]):
        for i in range(n):
            value = right[i, c]
            for k in range(i):
                value -= factor[i, k] * right[k, c]
            right[i, c] = value / factor[i, i]
        for i in range(n - 1, -1, -1):
            value = right[i, c]
            for k in range(i + 1, n):
                value -= factor[k, i] * right[k, c]
            right[i, c] = value / factor[i, i]
