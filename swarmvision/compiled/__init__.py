"""``@compiled``: numba where it is installed, the very same Python function where it is not.

A robot has NumPy and OpenCV and often no numba; a workstation has numba. Kernels are therefore
written once, as plain loops. No ``fastmath``: the same seed gives the same bytes on every target.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from swarmvision.compiled.stamp import Stamp

Function = TypeVar("Function", bound=Callable[..., Any])

try:
    from numba.core import config
except ImportError:  # a robot: plain Python runs the same lines
    HAS_NUMBA = False
else:
    from swarmvision.compiled.kernel import Door, Kernel

    HAS_NUMBA = not config.DISABLE_JIT

OPTIONS = {"nopython": True, "_nrt": True, "nogil": True, "fastmath": False, "error_model": "numpy"}


def compiled(function: Function) -> Function:
    """Return the function compiled at its first call, without the interpreter lock, cached on disk."""
    return _compiled(function)


def leaf(function: Function) -> Function:
    """Return the same of a function that makes no array and returns none, whose references are not counted.

    Counting them costs some 5 ns an array and call, more than many a small function does. What such a
    function calls must return no array either.
    """
    return _compiled(function, _nrt=False)


def apart(function: Function) -> Function:
    """Return the same as :func:`leaf` of a function that is handed arrays of which no two overlap.

    A loop over many arrays becomes vector code only where none of them can be a piece of another that is
    written; a compiler cannot know, and asks at run time about a few at most. Here it is promised.
    """
    return _compiled(function, apart=True, _nrt=False)


def inner(function: Function) -> Function:
    """Return the same as :func:`apart` of a function that becomes part of all that calls it.

    A large one is not taken in by itself, and handing over an array costs some ns. Each place that calls it
    is compiled with it.
    """
    return _compiled(function, apart=True, _nrt=False, forceinline=True)


def wide(function: Function) -> Function:
    """Return the same as :func:`apart` that works with the widest vectors that the processor has.

    LLVM prefers 256 bits where there are 512, as the first such processors slowed down; long loops gain up to
    a quarter by all of them, short ones lose. What a kernel is built into has its own width, so a wide one is
    not built into others, and what it calls is only as wide as it says itself.
    """
    return _compiled(function, ("noinline", '"prefer-vector-width"="512"'), apart=True, _nrt=False)


def steady(kernel: Function) -> Function:
    """Return a kernel for Python to call with named tuples whose members have the same types in every one.

    They are asked for them once, so 60 arrays cost 1 us at a call, not 7; all other arguments are asked
    always. A class whose array is of bytes here and of floats there, or one piece of memory here and every
    other column of one there, would be read as what it is not.
    """
    return Door(kernel) if HAS_NUMBA else kernel  # type: ignore[arg-type, return-value]


def _compiled(
    function: Function, attributes: Iterable[str] = (), *, apart: bool = False, **options: Any
) -> Function:
    if not HAS_NUMBA:
        return function
    kernel: Any = Kernel(function, apart=apart, attributes=attributes, targetoptions={**OPTIONS, **options})
    if function.__module__ in sys.modules:  # what is kept is found again by the name of its module
        kernel.enable_caching()
    file: Any = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    if hasattr(file, "_source_stamp"):  # numba's own, and not promised
        file._source_stamp = Stamp(function.__module__)
    return kernel  # type: ignore[no-any-return]


@contextmanager
def announced_compilation(announce: Callable[[], None]) -> Iterator[None]:
    """Call ``announce`` once if numba really compiles something inside the block.

    A kernel that comes from the cache on disk is silent.
    """
    if not HAS_NUMBA:
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
