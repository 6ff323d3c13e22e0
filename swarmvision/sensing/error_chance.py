"""Chance of the error model: hashed bits, normal deviates from a table, quantiles by deviate.

Bits are hashed from the observer's key, the picture's number and the neighbour's, so nothing that happens
to one pair shifts another's chance, and no order of robots or worlds matters. SplitMix64, as
:func:`swarmvision.randomness.draw`.
"""

from __future__ import annotations

import numpy as np

from swarmvision import randomness
from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.sensing.error_table import DEVIATES

DEVIATE_BITS = 10
NORMALS = 1 << DEVIATE_BITS
"""Equal shares of the normal distribution, each by its middle."""
PER_DEVIATE = 1.0 / (DEVIATES[1] - DEVIATES[0])
FIRST, LAST = DEVIATES[0], len(DEVIATES) - 1
QUANTILES = len(DEVIATES)


def normal_table() -> FloatArray:
    """Return :data:`NORMALS` normal deviates of mean 0 and variance 1, shape ``(NORMALS,)``."""
    from scipy.special import ndtri

    middles = ndtri((np.arange(NORMALS) + 0.5) / NORMALS)
    table: FloatArray = middles / middles.std()
    return table


mixed = leaf(randomness.mixed)


@leaf
def of_picture(key: np.uint64, picture: int) -> np.uint64:
    """Return 64 random bits of an observer for a picture, to be taken :func:`of_other`."""
    return mixed(key + np.uint64(picture + 1) * randomness.GOLDEN)


@leaf
def of_other(bits: np.uint64, other: int) -> np.uint64:
    """Return 64 random bits for a neighbour, of those of the picture."""
    return mixed(bits + np.uint64(other + 3) * randomness.GOLDEN)


@leaf
def share(bits: np.uint64) -> float:
    """Return the upper 28 of 64 random bits as a number in [0, 1)."""
    return float(bits >> np.uint64(36)) * 2.0**-28


@leaf
def normal(bits: np.uint64, number: int, normals: FloatArray) -> float:
    """Return one of three normal deviates that 64 random bits hold beside their :func:`share`."""
    return float(normals[entry(bits, number)])


@leaf
def entry(bits: np.uint64, number: int) -> int:
    """Return the place of that deviate in the table; a call with numbers alone costs a kernel nothing."""
    return int((bits >> np.uint64(DEVIATE_BITS * number)) & np.uint64(NORMALS - 1))


@leaf
def bin_of(edges: FloatArray, value: float) -> int:
    """Return the bin of a value: how many edges are at or below it."""
    below = 0
    for n in range(len(edges)):
        below += 1 if value >= edges[n] else 0
    return below


@leaf
def picked(quantiles: FloatArray, first: int, deviate: float) -> float:
    """Return the quantile at a normal deviate, of those from ``first`` on; beyond the last, the last."""
    n, part = between(deviate)
    low, high = quantiles[first + n], quantiles[first + n + 1]
    return low + part * (high - low)  # type: ignore[no-any-return]  # of an array


@leaf
def between(deviate: float) -> tuple[int, float]:
    """Return behind which quantile a deviate is, and which part of the way to the next."""
    place = min(max((deviate - FIRST) * PER_DEVIATE, 0.0), LAST - 1e-9)
    n = int(place)
    return n, place - n
