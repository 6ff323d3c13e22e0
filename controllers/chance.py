"""Chance in a law: a key for each robot and a count of its decisions are all that it remembers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from swarmvision.controllers.law import Keys
from swarmvision.data import BoolArray, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.randomness import draw


class Chance(NamedTuple):
    """Where a robot's chance stands."""

    keys: Keys
    """One for each robot, shape ``(...)``."""
    steps: IntArray
    """Decisions so far, shape ``(...)``."""

    def even(self, stream: int = 0) -> FloatArray:
        """Return numbers in [0, 1), ``(...)``; streams are independent of each other."""
        return draw(self.keys, self.steps, stream)

    def normal(self, stream: int = 0) -> FloatArray:
        """Return normal numbers of mean 0 and variance 1, ``(...)``, by Box and Muller's transform."""
        size = np.sqrt(-2.0 * np.log(1.0 - self.even(2 * stream)))
        return np.asarray(size * np.cos(2.0 * np.pi * self.even(2 * stream + 1)))

    def happens(self, rate: FloatArray | float, dt: float, stream: int = 0) -> BoolArray:
        """Return whether an event of a rate (1/s) happens within ``dt`` (s): with ``1 - exp(-rate dt)``."""
        return np.asarray(self.even(stream) < 1.0 - np.exp(-rate * dt))

    def after(self) -> Chance:
        """Return where it stands after a decision."""
        return Chance(self.keys, self.steps + 1)


class Switch(NamedTuple):
    """A state that is on or off, and the chance that changes it, shape ``(...)``."""

    chance: Chance
    on: BoolArray


def begin(config: Any, keys: Keys) -> Chance:
    """Return the chance before the first decision."""
    return Chance(keys, np.zeros(keys.shape, dtype=np.int64))


def begin_off(config: Any, keys: Keys) -> Switch:
    """Return switches that are off, before the first decision."""
    return Switch(begin(config, keys), np.zeros(keys.shape, dtype=bool))
