"""Threads that share work take every part of it once."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from swarmvision.compiled import compiled
from swarmvision.compiled.ticket import Counter, ticket
from swarmvision.data import IntArray

THREADS, TICKETS = 4, 20_000
UNCOMPILED = (
    "from test_ticket import shared\n"
    "print(sorted(number for taken in shared(4, 500) for number in taken) == [*range(500)])"
)


@compiled
def take_all(counter: Counter, taken: IntArray) -> int:
    """Note the tickets that one thread gets; return how many."""
    count, number = 0, ticket(counter)
    while number < len(taken):
        taken[count] = number
        count += 1
        number = ticket(counter)
    return count


def shared(threads: int, tickets: int) -> list[IntArray]:
    """Return what each thread got."""
    counter = np.zeros(1, np.int64)

    def work(_: int) -> IntArray:
        taken = np.empty(tickets, np.int64)
        return taken[: take_all(counter, taken)]

    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(work, range(threads)))


@pytest.mark.parametrize("threads", [1, THREADS])
def test_every_ticket_is_taken_once_and_in_its_turn(threads: int) -> None:
    each = shared(threads, TICKETS)
    assert sorted(np.concatenate(each)) == list(range(TICKETS))
    assert all((np.diff(taken) > 0).all() for taken in each)


def test_without_work_there_is_nothing_to_take() -> None:
    assert [len(taken) for taken in shared(THREADS, 0)] == [0] * THREADS


def test_tickets_are_the_same_uncompiled() -> None:
    result = subprocess.run(
        [sys.executable, "-c", UNCOMPILED],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.path.dirname(__file__)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert result.stdout.strip() == "True"
