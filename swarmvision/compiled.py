"""``@compiled``: numba where it is installed, the very same Python function where it is not.

A robot has NumPy and OpenCV and often no numba; a workstation has numba. Kernels are therefore
written once, as plain loops. No ``fastmath``: the same seed gives the same bytes on every target.

What numba keeps on disk it knows by the kernel's own file alone, but a kernel holds the code of all that it
calls. Ours are known by all those files.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

try:
    import numba
except ImportError:  # a robot: plain Python runs the same lines
    numba = None

HAS_NUMBA = numba is not None


def compiled(function: Function) -> Function:
    """Return the function compiled at its first call, without the interpreter lock, cached on disk."""
    return _compiled(function)


def leaf(function: Function) -> Function:
    """Return the same of a function that makes no array and returns none, whose references are not counted.

    Counting them costs some 5 ns an array and call, more than many a small function does.
    """
    return _compiled(function, _nrt=False)


def _compiled(function: Function, **options: Any) -> Function:
    if numba is None:
        return function
    kernel: Function = numba.njit(cache=True, nogil=True, fastmath=False, error_model="numpy", **options)(
        function
    )
    file: Any = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    if hasattr(file, "_source_stamp"):  # numba's own, and not promised
        file._source_stamp = _Stamp(function.__module__)
    return kernel


class _Stamp:
    """Tells whether kept code is still that of its sources; asked first when all of them are imported."""

    def __init__(self, module: str) -> None:
        self._module = module

    def __eq__(self, other: object) -> bool:
        return str(self) == str(other)

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        return _digest(self._module)

    def __reduce__(self) -> tuple[type[str], tuple[str]]:
        return str, (str(self),)  # what is kept beside the code


@cache
def _digest(module: str) -> str:
    """Return the digest of the files of a module and of all modules whose kernels it may call."""
    files: dict[str, Path] = {}
    _gather(module, module.partition(".")[0], files)
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(_content(files[name]))
    return digest.hexdigest()


@cache
def _content(file: Path) -> bytes:
    return hashlib.sha256(file.read_bytes()).digest()


def _gather(name: str, package: str, files: dict[str, Path]) -> None:
    """Note the file of a module, and those of its package that its kernels, tuples and modules are from."""
    path = getattr(sys.modules.get(name), "__file__", None)
    if name in files or path is None or name.partition(".")[0] != package:
        return
    files[name] = Path(path)
    for value in list(vars(sys.modules[name]).values()):
        if isinstance(value, ModuleType):
            _gather(value.__name__, package, files)
        elif hasattr(value, "py_func") or (isinstance(value, type) and issubclass(value, tuple)):
            _gather(value.__module__, package, files)


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
