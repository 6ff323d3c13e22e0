"""Large arrays that are made in every step, out of memory that nobody holds any more.

Memory of some hundred kilobytes that is given back and asked for again comes from the operating system anew,
page by page, which costs more than filling it. Here such arrays are kept: one that nobody but this shelf
refers to, neither itself nor a view of it, is handed out again. Each thread has a shelf of its own.
"""

from __future__ import annotations

import sys
import threading
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

LEAST = 1 << 14  # bytes; smaller ones are cheap anyway
KEPT = 8  # arrays of each shape and type
SHAPES = 32  # shapes and types; beyond, all are let go


class _Shelf(threading.local):
    def __init__(self) -> None:
        self.arrays: dict[tuple[tuple[int, ...], np.dtype[Any]], list[NDArray[Any]]] = {}


def empty(shape: tuple[int, ...], dtype: DTypeLike = np.float64) -> NDArray[Any]:
    """Return an array that is ours to fill, as :func:`numpy.empty`; its content is anything."""
    kind = np.dtype(dtype)
    size = kind.itemsize
    for length in shape:
        size *= length
    if size < LEAST or _FREE is None:
        return np.empty(shape, kind)
    key = (shape, kind)
    kept = _SHELF.arrays.get(key)
    if kept is None:
        if len(_SHELF.arrays) == SHAPES:
            _SHELF.arrays.clear()
        kept = _SHELF.arrays[key] = []
    for n in range(len(kept)):
        if _references(kept, n) == _FREE:
            kept[n].setflags(write=True)
            return kept[n]
    array = np.empty(shape, kind)
    if len(kept) < KEPT:
        kept.append(array)
    return array


def _references(kept: list[NDArray[Any]], n: int) -> int:
    return sys.getrefcount(kept[n])


_SHELF = _Shelf()
# How many references an array has that only a list holds, as this Python counts them.
_FREE = _references([np.empty(1)], 0) if hasattr(sys, "getrefcount") else None
