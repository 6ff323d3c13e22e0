"""Durations of calls that take turns, so that a machine's moods fall on all of them alike.

What runs in this process on one core is told in the process's CPU time: on a quiet machine that is the
time on the wall, and on a busy one waiting for a core would lengthen long calls and spare short ones.
What runs on several cores or in a process of its own is told by the clock on the wall.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass

Call = Callable[[], object]
Clock = Callable[[], int]
"""Tells ns."""

CPU: Clock = time.process_time_ns
WALL: Clock = time.perf_counter_ns

BURST, LONGEST = 0.02, 100  # s, calls: a turn lasts so long that most calls find their own data in the caches
LEAST = 3  # turns of each call, however long it takes


@dataclass(frozen=True, slots=True)
class Absent:
    """A figure that this machine cannot give."""

    reason: str
    """In one line."""


Figure = float | Absent


class LostError(Exception):
    """A rival came to an end of its own; the text is the reason, in one line."""


@dataclass(frozen=True, slots=True)
class Effort:
    """How much is measured, and for how long."""

    seconds: float
    """That one comparison may take, about (s)."""
    robots: tuple[int, ...]
    """Sizes of the swarms whose cost is measured."""
    neighbours: tuple[int, ...]
    """Numbers of neighbours in view."""
    widths_px: tuple[int, ...]
    """Widths of the pictures; they all see the same."""
    swarm: int
    """Robots of the swarms that are held against real time."""
    worlds: int
    """That are stepped at once, with eight robots each."""
    pictures: int
    """Over which memory is watched."""
    fresh: bool
    """Whether everything is compiled once more, as after installing."""


FULL = Effort(
    seconds=3.0,
    robots=(1, 3, 10, 32, 100, 316, 1000),
    neighbours=(0, 1, 2, 4, 8, 16, 32),
    widths_px=(80, 160, 320, 640, 1280),
    swarm=100,
    worlds=256,
    pictures=100_000,
    fresh=True,
)
QUICK = Effort(
    seconds=0.05,
    robots=(1, 10),
    neighbours=(0, 2),
    widths_px=(80, 640),
    swarm=100,
    worlds=16,
    pictures=100,
    fresh=False,
)


def ratio(above: Figure, below: Figure) -> Figure:
    """Return one figure over another, or why there is none."""
    for figure in (above, below):
        if isinstance(figure, Absent):
            return figure
    assert isinstance(above, float) and isinstance(below, float)
    return above / below


def difference(whole: Figure, part: Figure) -> Figure:
    """Return what is left of one figure without another, or why there is none."""
    for figure in (whole, part):
        if isinstance(figure, Absent):
            return figure
    assert isinstance(whole, float) and isinstance(part, float)
    return whole - part


def medians(
    calls: Mapping[str, Call | Absent], seconds: float, elsewhere: Container[str] = ()
) -> dict[str, Figure]:
    """Return the median duration (ms) of every call; they take turns until the time is up.

    Each is called twice to warm up. A turn is a burst of some 20 ms, every call of which is a
    sample of its own. What is absent stays so, and what comes to an end is absent.

    Args:
        calls: By name.
        seconds: To spend on all of them together, about (s).
        elsewhere: Names of those that work in a process of their own: the wall's clock times them.
    """
    samples: dict[str, list[float]] = {name: [] for name in calls}
    lost = {name: call for name, call in calls.items() if isinstance(call, Absent)}
    bursts: dict[str, int] = {}
    end, turns = time.perf_counter() + seconds, 0
    while turns < LEAST or time.perf_counter() < end:
        for name, call in calls.items():
            if isinstance(call, Absent) or name in lost:
                continue
            try:
                if name not in bursts:
                    bursts[name] = _burst(call)
                clock = WALL if name in elsewhere else CPU
                samples[name] += [duration(call, clock) for _ in range(bursts[name])]
            except LostError as end_of_it:
                lost[name] = Absent(str(end_of_it))
        turns += 1
    return {name: lost[name] if name in lost else 1e3 * statistics.median(samples[name]) for name in calls}


def _burst(call: Call) -> int:
    """Return how many calls make a turn."""
    call()
    return max(1, min(LONGEST, int(BURST / max(duration(call), 1e-7))))


def duration(call: Call, clock: Clock = CPU) -> float:
    """Return how long one call takes (s); what runs elsewhere tells it itself."""
    elsewhere: Callable[[Clock], float] | None = getattr(call, "duration", None)
    if elsewhere is not None:
        return elsewhere(clock)
    start = clock()
    call()
    return 1e-9 * (clock() - start)
