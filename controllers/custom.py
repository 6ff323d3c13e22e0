"""Laws that are not ours: somebody's own function, or what another package registers.

A package registers laws in the entry point group ``swarmvision.controllers``. What the name leads to is
either a :class:`~swarmvision.controllers.law.Law`, or a plain function ``law(estimates, **settings)`` that
returns :class:`~swarmvision.data.Commands` of the shape of the swarm.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any

import numpy as np

from swarmvision.config.controller import CustomConfig
from swarmvision.controllers.law import Law, Memory
from swarmvision.data import Commands, Senses
from swarmvision.errors import ConfigError, ControllerError, unknown_name

GROUP = "swarmvision.controllers"


def custom_law(config: CustomConfig) -> Law:
    """Return the law that ``config.target`` names.

    Raises:
        ConfigError: If there is none, or what is there is neither a law nor a function.
    """
    found = _found(config.target)
    if isinstance(found, Law):
        law = found
        settings = law.config(**config.settings)

        def step(senses: Senses, memory: Memory, config: Any) -> tuple[Commands, Memory]:
            commands, after = _fenced(target, lambda: law.step(senses, memory, settings))
            return _checked(target, commands, senses), after

        target = config.target
        return Law(CustomConfig, law.inputs, step, lambda _, keys: law.begin(settings, keys))
    if callable(found):
        return _of_function(config.target, found)
    raise ConfigError(f"controller {config.target!r} is neither a function nor a Law, got {type(found)}")


def registered_laws() -> list[str]:
    """Return the names in the entry point group."""
    return sorted(point.name for point in entry_points(group=GROUP))


def _of_function(target: str, function: Callable[..., Any]) -> Law:
    def step(senses: Senses, memory: Memory, config: CustomConfig) -> tuple[Commands, Memory]:
        commands = _fenced(target, lambda: function(senses.neighbours, **config.settings))
        return _checked(target, commands, senses), memory

    return Law(CustomConfig, frozenset({"range", "bearing", "heading"}), step, lambda _, keys: ())


def _found(target: str) -> Any:
    module, colon, name = target.partition(":")
    if not colon:
        known = registered_laws()
        if target not in known:
            raise ConfigError(
                unknown_name("registered controller", target, known) + "; or write package.module:law"
            )
        return next(iter(entry_points(group=GROUP, name=target))).load()
    try:
        home = import_module(module)
    except Exception as fault:  # whatever a stranger's module does when it is imported
        raise ConfigError(f"controller {target!r}: cannot import {module!r}: {_said(fault)}") from fault
    if not hasattr(home, name):
        functions = [key for key, value in vars(home).items() if callable(value) and key[0] != "_"]
        raise ConfigError(f"controller {target!r}: {unknown_name('function', name, functions)}")
    return getattr(home, name)


def _fenced(target: str, call: Callable[[], Any]) -> Any:
    """Return what a stranger's law returns; its exceptions become one line that says where."""
    try:
        return call()
    except Exception as fault:  # a stranger's code may raise anything
        place = traceback.extract_tb(fault.__traceback__)[-1]
        raise ControllerError(
            f"controller {target!r} failed: {_said(fault)} ({place.filename}, line {place.lineno})"
        ) from fault


def _checked(target: str, commands: Any, senses: Senses) -> Commands:
    if not isinstance(commands, Commands):
        raise ControllerError(f"controller {target!r} must return Commands, got {type(commands).__name__}")
    if commands.speed.shape != senses.shape:
        raise ControllerError(
            f"controller {target!r} must return commands of shape {senses.shape}, got {commands.speed.shape}"
        )
    if not (np.isfinite(commands.speed).all() and np.isfinite(commands.turn_rate).all()):
        raise ControllerError(f"controller {target!r} returned a command that is not finite")
    return commands


def _said(fault: Exception) -> str:
    return f"{type(fault).__name__}: {fault}"
