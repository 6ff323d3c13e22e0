"""Arrays are handed out again only when nobody can see them any more."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from swarmvision.recycling import KEPT, LEAST, SHAPES, empty

SHAPE = (LEAST, 3)


def address(array: np.ndarray) -> int:
    return int(array.__array_interface__["data"][0])


def test_what_is_let_go_comes_again_and_can_be_written() -> None:
    first = empty(SHAPE)
    first.setflags(write=False)
    where = address(first)
    del first
    again = empty(SHAPE)
    assert address(again) == where
    again[:] = 1.0


@pytest.mark.parametrize("hold", [lambda a: a, lambda a: a[5:, 1], lambda a: a.reshape(-1).T, memoryview])
def test_what_somebody_holds_or_views_stays_theirs(hold: object) -> None:
    held = hold(empty((LEAST, 4)))  # type: ignore[operator]
    first = np.asarray(held).copy()
    for _ in range(3):
        empty((LEAST, 4))[:] = 7.5
    other = empty((LEAST, 4))
    other[:] = first.flat[0] + 1.0 if np.isfinite(first.flat[0]) else 1.0
    np.testing.assert_array_equal(np.asarray(held), first)


def test_shapes_and_types_do_not_mix_and_small_ones_are_new() -> None:
    numbers, flags = empty(SHAPE, np.int64), empty(SHAPE, bool)
    assert numbers.dtype == np.int64
    assert flags.dtype == bool
    assert numbers.shape == flags.shape == SHAPE
    assert empty((3,)).shape == (3,)
    assert empty((0, 5)).shape == (0, 5)


def test_many_at_once_are_all_different() -> None:
    held = [empty(SHAPE) for _ in range(2 * KEPT)]
    assert len({address(array) for array in held}) == 2 * KEPT
    for length in range(2 * SHAPES):
        assert empty((LEAST + length,)).shape == (LEAST + length,)


def test_each_thread_has_its_own() -> None:
    mine, theirs = empty(SHAPE), []
    where = address(mine)
    del mine
    thread = threading.Thread(target=lambda: theirs.append(empty(SHAPE)))
    thread.start()
    thread.join()
    assert address(theirs[0]) != where
