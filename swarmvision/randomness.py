"""One integer seeds a run; every subsystem of every robot draws from a stream of its own.

Streams are keyed, not drawn in turn, so that adding a robot, a sensor or a renderer shifts nobody
else's numbers (``numpy.random.SeedSequence``'s spawn key).
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class Subsystem(IntEnum):
    """Who draws; the numbers are part of what a seed means, so they never change."""

    START = 0
    SENSOR = 1
    CONTROLLER = 2
    TASK = 3


def stream(seed: int, subsystem: Subsystem, *key: int) -> np.random.Generator:
    """Return the generator of a subsystem; ``key`` tells robots, lenses and the like apart."""
    sequence = np.random.SeedSequence(entropy=seed, spawn_key=(int(subsystem), *key))
    return np.random.Generator(np.random.PCG64(sequence))


def hashed(seed: int, subsystem: Subsystem, *key: int) -> int:
    """Return one number in 0..2**63 - 1 for a key, for kernels that hash instead of drawing."""
    sequence = np.random.SeedSequence(entropy=seed, spawn_key=(int(subsystem), *key))
    return int(sequence.generate_state(1, np.uint64)[0] >> np.uint64(1))
