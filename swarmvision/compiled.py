"""``@compiled``: numba where it is installed, the very same Python function where it is not.

A robot has NumPy and OpenCV and often no numba; a workstation has numba. Kernels are therefore
written once, as plain loops. No ``fastmath``: the same seed gives the same bytes on every target.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

try:
    import numba
except ImportError:  # a robot: plain Python runs the same lines
    numba = None

HAS_NUMBA = numba is not None


def compiled(function: Function) -> Function:
    """Return the function compiled at its first call, without the interpreter lock, cached on disk."""
    if numba is None:
        return function
    kernel: Function = numba.njit(cache=True, nogil=True, fastmath=False, error_model="numpy")(function)
    return kernel


@contextmanager
def announced_compilation(announce: Callable[[], None]) -> Iterator[None]:
    """Call ``announce`` once if numba really compiles something inside the block.

    A kernel that comes from the cache on disk is silent.
    """
    if numba is None:
        yield
        return
    from numba.core import event

    class Listener(event.Listener):  # type: ignore[misc]  # numba is untyped
        said = False

        def on_start(self, event: Any) -> None:
            if not self.said:
                self.said = True
                announce()

        def on_end(self, event: Any) -> None:
            pass

    with event.install_listener("numba:compile", Listener()):
        yield
