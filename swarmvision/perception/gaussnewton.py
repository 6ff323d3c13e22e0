"""One Gauss-Newton step with the colours projected out, robustly weighted.

Colours enter the model linearly, so in every step they are eliminated and then follow (variable
projection: G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10, 1973, doi:10.1137/0710036, in L. Kaufman's
simplification, BIT 15, 1975, doi:10.1007/BF01932995).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import apart, compiled
from swarmvision.geometry import FloatArray
from swarmvision.perception.model import FREE, HEADING

NOISE = 0.012  # of white: least residual that counts as one standard deviation
STRANGE = 0.1  # of white: a residual as large is not of the marker
TAIL = 3.0  # standard deviations from which on a pixel's pull declines


@compiled
def weigh(
    basis: FloatArray,
    change: FloatArray,
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
        basis: From :func:`swarmvision.perception.model.model`, ``(n, colours + 3)``.
        change: From there, too; residuals are written behind the derivatives, ``(3, n, ROW)``.
        count: Pixels that are written.
        used: Which they are.
        values: What the picture has, ``(3, all)``.
        inside: Which pixels surely show the marker and nothing beside it, ``(all,)``.
        colours: Light of each, then of the background's basis, ``(3, colours + 3)``.
        misfit: Of the step before.

    Returns:
        The new misfit: one standard deviation of the residuals of the pixels that fit; the loss, the
        root of the mean of ``r^2 / (1 + (r / STRANGE)^2)`` over all pixels, which no weight can hide; and
        the same over the pixels inside, which does not feel what stands behind the marker.
    """
    width = colours.shape[1]
    residual = np.empty(3)
    heavy = total = loss = own = 0.0
    owned = 0
    for n in range(count):
        square = 0.0
        for channel in range(3):
            value = values[channel, used[n]]
            for k in range(width):
                value -= colours[channel, k] * basis[n, k]
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
            for k in range(width):
                basis[n, k] *= root
            for channel in range(3):
                for j in range(FREE):
                    change[channel, n, j] *= root
        for channel in range(3):
            change[channel, n, FREE] = root * residual[channel]
        heavy += root * root * min(square, (TAIL * misfit) ** 2 if misfit > 0.0 else square)
        total += root * root
    misfit = max(math.sqrt(heavy / max(total, 1e-9)), NOISE)
    return misfit, math.sqrt(loss / max(count, 1)), math.sqrt(own / max(owned, 1))


@compiled
def products(
    basis: FloatArray,
    change: FloatArray,
    count: int,
    moving: bool,
    own: FloatArray,
    mixed: FloatArray,
    normal: FloatArray,
) -> None:
    """Write the products of all columns of every channel's rows with each other.

    Not by a matrix product: the libraries behind that start threads, and these are small matrices
    inside threads of ours.

    Args:
        basis: Of ``count`` pixels, ``(n, colours + 3)``.
        change: Of each channel, ``(3, n, ROW)``.
        count: How many pixels.
        moving: Whether more of ``change`` is looked at than the residuals.
        own: Out: of the basis with itself, ``(colours + 3, colours + 3)``.
        mixed: Out: of the basis with each channel's change, ``(3, colours + 3, ROW)``.
        normal: Out: of each channel's change with itself, ``(3, ROW, ROW)``.
    """
    own[:] = 0.0
    mixed[:] = 0.0
    normal[:] = 0.0
    width = basis.shape[1]
    for n in range(count):
        for i in range(width):
            for j in range(i + 1):
                own[i, j] += basis[n, i] * basis[n, j]
        for channel in range(0 if moving else 3):
            for i in range(width):
                mixed[channel, i, FREE] += basis[n, i] * change[channel, n, FREE]
    for i in range(width):
        for j in range(i):
            own[j, i] = own[i, j]
    for channel in range(3 if moving else 0):
        _multiply(basis, change[channel], count, width, mixed[channel])
        _multiply(change[channel], change[channel], count, FREE, normal[channel])


@apart
def _multiply(left: FloatArray, right: FloatArray, count: int, columns: int, out: FloatArray) -> None:
    """Add the products of so many columns on the left with all on the right, ``ROW``, over so many rows.

    Where the compiler knows that number at once it makes no vectors.
    """
    by_four = count - count % 4
    for n in range(0, by_four, 4):  # four rows at a time: the sums are fetched and stored once
        one, two, three, four = right[n], right[n + 1], right[n + 2], right[n + 3]
        for i in range(columns):
            a, b, c, d = left[n, i], left[n + 1, i], left[n + 2, i], left[n + 3, i]
            for j in range(right.shape[1]):
                out[i, j] += a * one[j] + b * two[j] + c * three[j] + d * four[j]
    for n in range(by_four, count):
        for i in range(columns):
            for j in range(right.shape[1]):
                out[i, j] += left[n, i] * right[n, j]


@compiled
def repaint(own: FloatArray, mixed: FloatArray, colours: FloatArray) -> bool:
    """Change the colours to the best ones, ``(3, colours + 3)``; return whether that was possible.

    The products are those of :func:`products`, of which only the residuals' are looked at.
    """
    width = len(own)
    basis = own.copy()
    if not _factor(basis):
        return False
    for channel in range(3):
        solved = np.empty((width, 1))
        for k in range(width):
            solved[k, 0] = mixed[channel, k, FREE]
        substitute(basis, solved)
        for k in range(width):
            colours[channel, k] += solved[k, 0]
    return True


@compiled
def advance(
    own: FloatArray,
    mixed: FloatArray,
    normals: FloatArray,
    free: NDArray[np.bool_],
    theta: FloatArray,
    usual: FloatArray,
    loose: FloatArray,
    misfit: float,
    colours: FloatArray,
    delta: FloatArray,
    covariance: FloatArray,
) -> bool:
    """Take one step from the products of all rows with each other; return whether that was possible.

    Args:
        own: As :func:`products` writes them, like the next two.
        mixed: See there.
        normals: See there.
        free: Which parameters may move, ``(12,)``.
        theta: The parameters.
        usual: Their means before.
        loose: Their standard deviations before.
        misfit: One standard deviation of a residual.
        colours: Changed to the best ones, ``(3, width)``.
        delta: Out: the step, ``(12,)``.
        covariance: Out: of the parameters, over misfit squared, ``(12, 12)``; 0 where not free.
    """
    width = len(own)
    chosen = np.empty(FREE, dtype=np.int64)
    count = 0
    for j in range(FREE):
        if free[j]:
            chosen[count] = j
            count += 1
    basis = own.copy()
    if not _factor(basis):
        return False
    normal, pull = np.zeros((count, count)), np.zeros((count, 1))
    coupling = np.empty((3, width, count + 1))
    for channel in range(3):
        right = np.empty((width, count + 1))
        for i in range(width):
            for j in range(count):
                right[i, j] = mixed[channel, i, chosen[j]]
            right[i, count] = mixed[channel, i, FREE]
        solved = right.copy()
        substitute(basis, solved)
        coupling[channel] = solved
        for i in range(count):
            for j in range(count):
                value = normals[channel, chosen[i], chosen[j]]
                for k in range(width):
                    value -= right[k, i] * solved[k, j]
                normal[i, j] += value
            value = normals[channel, chosen[i], FREE]
            for k in range(width):
                value -= right[k, i] * solved[k, count]
            pull[i, 0] += value
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
            shift = coupling[channel, k, count]
            for j in range(count):
                shift -= coupling[channel, k, j] * pull[j, 0]
            colours[channel, k] += shift
    return True


@compiled
def _factor(basis: FloatArray) -> bool:
    """Replace the basis's products by their lower factor, a colour that nothing shows held where it is."""
    weight = 1e-9
    for i in range(len(basis)):
        weight = max(weight, basis[i, i])
    for i in range(len(basis)):
        basis[i, i] += 1e-6 * weight
    return cholesky(basis)


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
