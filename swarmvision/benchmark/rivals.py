"""Rivals are libraries of their own, and none is needed: one that is not there is absent, with the reason.

They come with ``pip install 'swarmvision[bench]'``; VMAS, which brings torch, only by itself. Every
rival gets what it is made for: detectors get tags of their own family, all of which they must find; game
engines draw a scene of their own.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version

from swarmvision.benchmark.timing import Absent, Call

PACKAGES = (
    "pyrender2",
    "vizdoom",
    "pybullet",
    "opencv-python-headless",
    "pupil-apriltags",
    "locus-tag",
    "vmas",
    "torch",
)
"""Which the rivals come in."""


def versions() -> dict[str, str | None]:
    """Return the version of each of the rivals' packages, None where it is not installed."""
    found: dict[str, str | None] = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = None
    return found


def attempt(name: str, build: Callable[[], Call]) -> Call | Absent:
    """Return a rival, ready and tried once, or why it is absent."""
    try:
        with _quiet():
            call = build()
            call()
    except Exception as fault:  # foreign code on a foreign machine: whatever it raises means the same
        first = str(fault).strip().splitlines()
        return Absent(f"{name}: {first[0] if first else type(fault).__name__}")
    return call


@contextmanager
def _quiet() -> Iterator[None]:
    """Send what foreign code writes to stdout, even from C, to stderr: stdout is for results."""
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        os.dup2(2, 1)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
