"""Kept kernels are known by the sources of all that they hold.

What numba keeps on disk it knows by the kernel's own file alone, but a kernel holds the code of all that it
calls. Ours are known by all those files, and by how they are compiled.
"""

from __future__ import annotations

import hashlib
import sys
from functools import cache
from pathlib import Path
from types import ModuleType


class Stamp:
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
    files = {path.name: path for path in Path(__file__).parent.glob("*.py")}
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
