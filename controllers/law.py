"""What a law is: senses and memory in, commands and memory out.

Most laws are reflexes, pure functions of the neighbours. A law with memory returns it: a ``NamedTuple`` of
arrays whose leading axes are the robots', so that one memory serves one robot, a swarm and many worlds.
Randomness comes from one key for each robot (:func:`swarmvision.randomness.draw`), kept in the memory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from swarmvision.config.model import Settings
from swarmvision.data import Commands, Estimates, Senses

Sense = Literal[
    "range", "bearing", "heading", "kind", "motion", "proximity", "goal", "cue", "silhouette", "load"
]
"""What a law may need. Range, bearing, heading and kind are a neighbour's; motion is the robot's own."""

Keys = NDArray[np.uint64]
"""One random key for each robot, shape ``(...)``."""

Memory = tuple[Any, ...]
"""Arrays ``(..., *)``; empty for a reflex."""

Begin = Callable[[Any, Keys], Memory]
Step = Callable[[Senses, Any, Any], tuple[Commands, Memory]]


@dataclass(frozen=True, slots=True)
class Law:
    """One control law, without its settings."""

    config: type[Settings]
    """Its settings; their ``law`` names it."""
    inputs: frozenset[Sense]
    """What it needs; the loop senses nothing that nobody asked for."""
    step: Step
    """``(senses, memory, config) -> (commands, memory)``, pure."""
    begin: Begin
    """``(config, keys) -> memory`` before the first step."""


@dataclass(frozen=True, slots=True)
class Layer:
    """What corrects the commands of any law."""

    inputs: frozenset[Sense]
    """What it needs."""
    correct: Callable[[Commands, Senses, Any], Commands]
    """``(commands, senses, config) -> commands``, pure."""


def reflex(function: Callable[[Estimates, Any], Commands], config: type[Settings], inputs: set[Sense]) -> Law:
    """Return the law of a pure function ``(estimates, config) -> commands``."""

    def step(senses: Senses, memory: Memory, config: Any) -> tuple[Commands, Memory]:
        return function(senses.neighbours, config), memory

    return Law(config, frozenset(inputs), step, _nothing)


def reflex_of_senses(
    function: Callable[[Senses, Any], Commands], config: type[Settings], inputs: set[Sense]
) -> Law:
    """Return the law of a pure function ``(senses, config) -> commands``."""

    def step(senses: Senses, memory: Memory, config: Any) -> tuple[Commands, Memory]:
        return function(senses, config), memory

    return Law(config, frozenset(inputs), step, _nothing)


def _nothing(config: Any, keys: Keys) -> Memory:
    return ()


@dataclass(frozen=True, slots=True)
class Controller:
    """A law with its settings, and the layers under it."""

    inputs: frozenset[Sense]
    """What law and layers need."""
    begin: Callable[[Keys], Memory]
    """``keys -> memory`` before the first step."""
    step: Callable[[Senses, Memory], tuple[Commands, Memory]]
    """``(senses, memory) -> (commands, memory)``."""

    def act(self, estimates: Estimates) -> Commands:
        """Return the first commands of robots that know their neighbours alone, shape ``(...)``."""
        senses = Senses.of(estimates)
        return self.step(senses, self.begin(np.zeros(senses.shape, dtype=np.uint64)))[0]
