"""One integer seeds a run; every subsystem of every robot draws from a stream of its own.

Streams are keyed, not drawn in turn, so that adding a robot, a sensor or a renderer shifts nobody
else's numbers (``numpy.random.SeedSequence``'s spawn key).
"""

from __future__ import annotations

from enum import IntEnum
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
"""Between the counts of SplitMix64."""
Bits = TypeVar("Bits", np.uint64, NDArray[np.uint64])


class Subsystem(IntEnum):
    """Who draws; the numbers are part of what a seed means, so they never change."""

    START = 0
    SENSOR = 1
    CONTROLLER = 2
    TASK = 3
    PROXIMITY = 4


def stream(seed: int, subsystem: Subsystem, *key: int) -> np.random.Generator:
    """Return the generator of a subsystem; ``key`` tells robots, lenses and the like apart."""
    sequence = np.random.SeedSequence(entropy=seed, spawn_key=(int(subsystem), *key))
    return np.random.Generator(np.random.PCG64(sequence))


def hashed(seed: int, subsystem: Subsystem, *key: int) -> int:
    """Return one number in 0..2**63 - 1 for a key, for kernels that hash instead of drawing."""
    sequence = np.random.SeedSequence(entropy=seed, spawn_key=(int(subsystem), *key))
    return int(sequence.generate_state(1, np.uint64)[0] >> np.uint64(1))


def mixed(value: Bits) -> Bits:
    """Return a hash of 64 bits; a kernel compiles the same lines for one number."""
    one = (value ^ (value >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    two = (one ^ (one >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return two ^ (two >> np.uint64(31))


def numbered(keys: ArrayLike, number: ArrayLike) -> NDArray[np.int64]:
    """Return one number in 0..2**63 - 1 for keys of :func:`hashed` and counts that broadcast, as hashed.

    The ``number``-th of SplitMix64 begun at the key, see :func:`draw`.
    """
    steps = np.asarray(number, dtype=np.uint64) + np.uint64(1)
    with np.errstate(over="ignore"):  # it is meant to wrap
        bits = mixed(np.asarray(keys, dtype=np.uint64) + steps * GOLDEN)
    return np.asarray((bits >> np.uint64(1)).astype(np.int64))


def draw(keys: NDArray[np.uint64], *count: int | NDArray[np.int64]) -> NDArray[np.float64]:
    """Return one number in [0, 1) for each key and count, evenly distributed, shape ``(...)``.

    The same key and count give the same number in any company, so a swarm draws as its robots would alone.
    SplitMix64: G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014, doi:10.1145/2660193.2660195.
    """
    bits = np.asarray(keys, dtype=np.uint64)
    with np.errstate(over="ignore"):  # it is meant to wrap
        for part in (*count, 1):
            bits = mixed(bits + np.asarray(part).astype(np.uint64) * GOLDEN)
    return np.asarray((bits >> np.uint64(11)).astype(np.float64) * 2.0**-53)


def normal(keys: NDArray[np.uint64], *count: int | NDArray[np.int64]) -> NDArray[np.float64]:
    """Return one normally distributed number (mean 0, variance 1) for each key and count, as :func:`draw`.

    G. E. P. Box, M. E. Muller, Ann. Math. Stat. 29, 1958, doi:10.1214/aoms/1177706645.
    """
    radius = np.sqrt(-2.0 * np.log1p(-draw(keys, *count, 0)))
    return np.asarray(radius * np.cos(2.0 * np.pi * draw(keys, *count, 1)))


class RobotKeys:
    """The keys of a subsystem's robots for :func:`draw`, made when they are first asked for."""

    def __init__(self, seed: int, subsystem: Subsystem) -> None:
        self._seed, self._subsystem = seed, subsystem
        self._keys = np.zeros(0, dtype=np.uint64)

    def of(self, robots: int) -> NDArray[np.uint64]:
        """Return the keys of the first robots, shape ``(robots,)``."""
        known = len(self._keys)
        if known < robots:
            more = [hashed(self._seed, self._subsystem, robot) for robot in range(known, robots)]
            self._keys = np.concatenate([self._keys, np.array(more, dtype=np.uint64)])
        return self._keys[:robots]
