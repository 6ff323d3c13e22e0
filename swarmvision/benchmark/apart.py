"""A rival in a process of its own: whatever it does there, the bench goes on.

Foreign libraries bring their own threads, allocators and graphics, and some of them end the process that they
are in. A turn of such a rival is asked for through a pipe, and it is timed where it runs.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from contextlib import ExitStack
from importlib.util import find_spec
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

from swarmvision.benchmark.timing import CPU, WALL, Absent, Call, Clock, LostError, duration

Build = Callable[..., Call]
"""Makes a rival ready, from a stack for what is to be closed at the end and arguments that can be pickled."""
LINGER = 5.0  # s, to close what is to be closed


class Apart:
    """A rival that waits in another process; calling it is one turn."""

    def __init__(self, name: str, build: Build, *arguments: Any) -> None:
        """Start the process and wait until the rival has been tried once.

        Args:
            name: Of the rival, told with every reason.
            build: A function of a module, that the other process can import.
            arguments: For ``build``, after the stack.

        Raises:
            LostError: If it cannot be built, or the process ends.
        """
        context = get_context("spawn")
        self._name = name
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, build, arguments), daemon=True)
        self._process.start()
        theirs.close()
        if reason := self._answer():
            self._process.join(LINGER)
            raise LostError(f"{name}: {reason}")

    def __call__(self) -> None:
        """Take one turn."""
        self.duration(CPU)

    def duration(self, clock: Clock) -> float:
        """Take one turn and return how long it took over there (s).

        Raises:
            LostError: If the process has ended.
        """
        try:
            self._pipe.send(clock is WALL)
        except OSError:
            self._lost()
        seconds: float = self._answer()
        return seconds

    def close(self) -> None:
        """Let the rival close what it opened, and end its process."""
        self._pipe.close()
        self._process.join(LINGER)
        self._process.kill()
        self._process.join()

    def _answer(self) -> Any:
        try:
            return self._pipe.recv()
        except (EOFError, OSError):
            return self._lost()

    def _lost(self) -> None:
        self._process.join(LINGER)
        code = self._process.exitcode
        how = f"with exit status {code}" if code is None or code >= 0 else f"by {signal.Signals(-code).name}"
        raise LostError(f"{self._name}: its process was ended {how}")


def apart(name: str, module: str, build: Build, *arguments: Any) -> Apart | Absent:
    """Return a rival in a process of its own, tried once, or why it is absent.

    Args:
        name: Of the rival.
        module: What it is imported as; without it no process is started.
        build: See :class:`Apart`.
        arguments: For ``build``.
    """
    if find_spec(module) is None:
        return Absent(f"{name}: No module named {module!r}")
    try:
        return Apart(name, build, *arguments)
    except LostError as lost:
        return Absent(str(lost))


def _serve(pipe: Connection, build: Build, arguments: tuple[Any, ...]) -> None:
    """Build a rival, tell what went wrong, if anything, and take turns until nobody asks any more."""
    os.dup2(2, 1)  # stdout is for results, and this process has none
    with ExitStack() as closing:
        try:
            call = build(closing, *arguments)
            call()
        except Exception as fault:  # foreign code on a foreign machine: whatever it raises means the same
            first = str(fault).strip().splitlines()
            pipe.send(first[0] if first else type(fault).__name__)
            return
        pipe.send("")
        while True:
            try:
                wall = pipe.recv()
            except EOFError:
                return
            pipe.send(duration(call, WALL if wall else CPU))
