"""What can go wrong, as one tree.

::

    SwarmVisionError
    ├── ConfigError     (ValueError)        a setting is wrong: names file, field, rule and value
    ├── DataError       (ValueError)        an array that travels through the loop is wrong
    ├── ControllerError (RuntimeError)      a law that is not ours failed: names the line
    ├── PhysicsError    (ArithmeticError)   the world left the finite numbers
    ├── PictureError    (ValueError)        a picture that cannot be read
    ├── CalibrationError (ValueError)       pictures that do not determine the camera
    ├── OutputError     (OSError)           a result that cannot be written
    └── RenderingError  (RuntimeError)      a renderer that this machine cannot run

Every error is ours *and* the built-in that it refines, so callers may catch either. The command
line turns each into one line on stderr and exit code 1.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class SwarmVisionError(Exception):
    """Base of every error that this package raises on purpose."""


class ConfigError(SwarmVisionError, ValueError):
    """A setting is missing, unknown or out of its bounds."""


class DataError(SwarmVisionError, ValueError):
    """An array has the wrong shape, type or interval."""


class ControllerError(SwarmVisionError, RuntimeError):
    """A law from somebody's own module raised, or returned what is no command."""


class PhysicsError(SwarmVisionError, ArithmeticError):
    """A position, velocity or command is not a finite number."""


class PictureError(SwarmVisionError, ValueError):
    """A picture is missing, broken, or not of the shape that a camera gives."""


class CalibrationError(SwarmVisionError, ValueError):
    """Pictures are too few, too much alike or contradictory to tell what camera took them."""


class OutputError(SwarmVisionError, OSError):
    """A result cannot be written where it was asked for."""


class RenderingError(SwarmVisionError, RuntimeError):
    """A renderer cannot run on this machine; the text says what to install."""


def unknown_name(kind: str, name: str, known: Iterable[str]) -> str:
    """Return the text for a name that nobody knows, with the nearest known name.

    >>> unknown_name("controller", "floking", ["aggregation", "flocking"])
    "unknown controller 'floking'; did you mean 'flocking'? known: aggregation, flocking"
    """
    names = sorted(known)
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    hint = f"; did you mean {close[0]!r}?" if close else ";"
    return f"unknown {kind} {name!r}{hint} known: {', '.join(names)}"
