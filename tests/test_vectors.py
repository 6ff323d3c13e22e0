"""Bytes compared many at once tell the same as one by one, compiled and uncompiled."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.compiled.vectors import BLOCK, WORD, Image, differing, lowest, uneven

STEP = 3
TRIALS = 200


@compiled
def compare(lines: Image, place: int) -> tuple[int, int]:
    """Return what two rows tell from a place on."""
    return int(differing(lines, 0, 1, place)), int(uneven(lines, 0, place, STEP))


@compiled
def lowest_of(bits: int) -> int:
    return int(lowest(np.uint64(bits)))


def one_by_one(lines: Image, place: int) -> tuple[int, int]:
    down = along = 0
    for word in range(BLOCK // WORD):
        for i in range(place + WORD * word, place + WORD * (word + 1)):
            down |= int(lines[0, i] != lines[1, i]) << word
            along |= int(abs(int(lines[0, i]) - int(lines[0, i + STEP])) > 1) << word
    return down, along


def test_words_that_differ_are_those_with_a_byte_that_does() -> None:
    rng = np.random.default_rng(1)
    for _ in range(TRIALS):
        lines = np.full((2, 2 * BLOCK), rng.integers(256), np.uint8)
        at = rng.integers(0, lines.size, rng.integers(0, 5))
        lines.ravel()[at] = rng.integers(0, 256, len(at))
        place = int(rng.integers(0, BLOCK - STEP))
        assert compare(lines, place) == one_by_one(lines, place)


def test_a_step_of_one_is_let_pass_and_of_two_is_not_either_way_and_at_the_ends_of_the_scale() -> None:
    for base in (0, 1, 127, 128, 254, 255):
        for step in (-2, -1, 1, 2):
            if 0 <= base + step <= 255:
                lines = np.full((2, 2 * BLOCK), base, np.uint8)
                lines[0, 20] = base + step
                assert compare(lines, 0) == (1 << 2, 1 << 2 if abs(step) == 2 else 0)


def test_the_lowest_bit_is_found() -> None:
    for place in range(63):
        assert lowest_of(1 << place) == place
        assert lowest_of((1 << place) | (1 << 62)) == place


def test_uncompiled_it_is_the_same() -> None:
    result = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "not uncompiled", __file__],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "3 passed" in result.stdout, result.stdout
