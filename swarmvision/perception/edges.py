"""Range, bearing and heading of every marker in a picture, in closed form from its edges.

How one marker is measured tells :mod:`swarmvision.perception.measure`. Here a white is found, candidates wait
for their turn, the nearest first, and each marker is told once.

A whole picture is one call of :func:`read_edges_into`, which needs no interpreter and takes no memory, so
that threads of one process read at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import leaf, steady
from swarmvision.data import Estimates
from swarmvision.geometry import FloatArray
from swarmvision.perception.cylinder import (
    BEARING,
    BEARING_STD,
    COVERED,
    DROP,
    HEADING,
    HEADING_STD,
    LEFT,
    RANGE,
    RANGE_STD,
    RIGHT,
    VISIBLE,
    WHOLE,
)
from swarmvision.perception.detect import P_FIRST, P_KIND, P_LAST, P_LEFT, P_MIDDLE, P_RIGHT, find
from swarmvision.perception.gaze import Gaze
from swarmvision.perception.measure import measure
from swarmvision.perception.order import median_in_place
from swarmvision.perception.pairs import BOTH
from swarmvision.perception.plan import (
    RADIUS,
    Scratch,
    Task,
)
from swarmvision.perception.segment import sample_white, weigh_codes

ROW = 11  # numbers of one marker
MOST = 64  # markers that one picture tells
TINTED = 0.8  # weakest channel of a picture's white over its strongest, below which that may be no white


@dataclass(frozen=True, eq=False, slots=True)
class Reading:
    """One marker, measured."""

    range: float
    bearing: float
    heading: float
    covariance: FloatArray
    """Of range (m), bearing and heading (rad), ``(3, 3)``; nan where heading is not told."""
    visible: float
    drop: float
    """Rows (px) by which the marker stands lower in the picture than a level lens would show it."""
    left: float
    right: float
    """Columns (px) between which it is seen."""
    whole: bool
    """Whether both tangents are seen."""
    covered: int
    """Which ends stand at a nearer marker: 1 the left, 2 the right."""


def read(image: NDArray[np.uint8], task: Task, gaze: Gaze, scratch: Scratch) -> Estimates:
    """Return the neighbours in a picture ``(h, w, 3)``, nearest first, lens frame, shape ``(k,)``."""
    rows = np.empty((MOST, ROW))
    return estimates(rows[: _read_edges_into(image, task, gaze, scratch, rows)])


def readings(image: NDArray[np.uint8], task: Task, gaze: Gaze, scratch: Scratch) -> list[Reading]:
    """Return every marker in a picture, nearest first."""
    rows = np.empty((MOST, ROW))
    found = rows[: _read_edges_into(image, task, gaze, scratch, rows)]
    return [
        Reading(
            float(row[RANGE]),
            float(row[BEARING]),
            float(row[HEADING]),
            covariance,
            min(float(row[VISIBLE]), 1.0),
            float(row[DROP]),
            float(row[LEFT]),
            float(row[RIGHT]),
            bool(row[VISIBLE] >= WHOLE),
            int(row[COVERED]),
        )
        for row, covariance in zip(found, _covariances(found), strict=True)
    ]


def estimates(rows: FloatArray) -> Estimates:
    """Return what :func:`read_edges_into` wrote, ``(k, ROW)``, as estimates in the lens frame, ``(k,)``."""
    k = len(rows)
    return Estimates.given(
        seen=np.ones(k, dtype=bool),
        range=rows[:, RANGE].copy(),
        bearing=rows[:, BEARING].copy(),
        heading=rows[:, HEADING].copy(),
        covariance=_covariances(rows),
        age=np.zeros(k),
        track=np.full(k, -1),
        visible=np.minimum(rows[:, VISIBLE], 1.0),
        frame="lens",
    )


def _covariances(rows: FloatArray) -> FloatArray:
    covariance = np.zeros((len(rows), 3, 3))
    for i, column in enumerate((RANGE_STD, BEARING_STD, HEADING_STD)):
        covariance[:, i, i] = rows[:, column] ** 2
    blind = np.isnan(rows[:, HEADING])
    covariance[blind, 2, :] = covariance[blind, :, 2] = np.nan
    return covariance


@leaf
def read_edges_into(
    image: NDArray[np.uint8], task: Task, gaze: Gaze, scratch: Scratch, out: FloatArray
) -> int:
    """Write every marker of a picture, nearest first; return how many there are.

    Args:
        image: sRGB, ``(h, w, 3)``, C-contiguous, of the size that task and scratch were made for.
        task: What is looked for, and by which lens.
        gaze: Where it is looked for, and what is left out; ``Gaze.at_all(task)`` is everywhere and nothing.
        scratch: Room to work in, of this thread alone.
        out: Shape ``(MOST, ROW)``; a row is range (m), bearing, heading (rad), their standard deviations,
            visible fraction, drop, left and right side (px), which ends stand at a nearer marker.
    """
    sample_white(image, task.decode, scratch.white, scratch.samples, scratch.counts)
    found = _read_under(scratch.white, image, task, gaze, scratch, out)
    red, green, blue = scratch.white
    brightest = max(red, green, blue)
    if min(red, green, blue) < TINTED * brightest:
        # Where nothing white is in sight, as over a wooden floor, the camera's own white may be right.
        scratch.white[:] = brightest
        found += _read_under(scratch.white, image, task, gaze, scratch, out[found:])
        scratch.white[0], scratch.white[1], scratch.white[2] = red, green, blue
        weigh_codes(task.decode, scratch.white, scratch.light, scratch.address)
    return _distinct(out, found, task.heights[RADIUS])


@leaf
def _read_under(
    white: FloatArray, image: NDArray[np.uint8], task: Task, gaze: Gaze, scratch: Scratch, out: FloatArray
) -> int:
    """Write the markers that are found under a white ``(3,)``; return how many."""
    weigh_codes(task.decode, white, scratch.light, scratch.address)
    pieces = find(image, scratch.address, task.look, gaze.windows, scratch.look)
    if pieces == 0:
        return 0
    # A stack, the tallest on top: what hides is measured before what it hides.
    waiting = scratch.waiting
    left = min(pieces, len(waiting) // 2)
    for i in range(left):
        _copy(scratch.look.pieces[scratch.look.order[0, i]], waiting[left - 1 - i])
    found = 0
    while left > 0 and found < len(out):
        left -= 1
        if waiting[left, P_KIND] == BOTH and waiting[left, P_MIDDLE] < gaze.least:
            continue
        split = measure(image, task, scratch, waiting[left], out, found)
        if split < 0.0:
            found += 1
        elif split > 0.0 and left + 2 <= len(waiting):
            left = _halve(waiting, left, split, scratch)
    return found


@leaf
def _halve(waiting: FloatArray, place: int, column: float, scratch: Scratch) -> int:
    """Put the two markers that a candidate is when cut at a column (px) in its place, the taller on top.

    Returns how many candidates are waiting then.
    """
    look = scratch.look
    first, last = int(waiting[place, P_FIRST]), int(waiting[place, P_LAST])
    cut = first
    while cut < last and look.columns[cut] < column:
        cut += 1
    if cut in (first, last):
        return place
    here, there = waiting[place], waiting[place + 1]
    _copy(here, there)
    here[P_RIGHT] = there[P_LEFT] = column
    here[P_LAST] = there[P_FIRST] = cut
    kept = 0
    for piece in (here, there):
        start, end = int(piece[P_FIRST]), int(piece[P_LAST])
        for k in range(start, end):
            look.spare[0, k - start] = look.rows[k, 2] - look.rows[k, 1]
        piece[P_MIDDLE] = median_in_place(look.spare[0], end - start)
        kept += 1 if end - start >= 2 else 0
    if kept < 2:
        if there[P_LAST] - there[P_FIRST] >= 2:
            _copy(there, here)
        return place + kept
    if here[P_MIDDLE] > there[P_MIDDLE]:
        _swap(here, there)
    return place + 2


@leaf
def _distinct(rows: FloatArray, found: int, radius: float) -> int:
    """Keep one reading a marker, the nearest first: two axes cannot be nearer than two radii."""
    _sort(rows, found, True)
    kept = 0
    for i in range(found):
        x, y = rows[i, RANGE] * math.cos(rows[i, BEARING]), rows[i, RANGE] * math.sin(rows[i, BEARING])
        new = True
        for j in range(kept):
            dx = x - rows[j, RANGE] * math.cos(rows[j, BEARING])
            dy = y - rows[j, RANGE] * math.sin(rows[j, BEARING])
            new = new and math.hypot(dx, dy) > 2.0 * radius
        if new:
            _copy(rows[i], rows[kept])
            kept += 1
    _sort(rows, kept, False)
    return kept


@leaf
def _sort(rows: FloatArray, count: int, by_visible: bool) -> None:
    """Sort rows by range, or by what is visible, most first, and then by range."""
    for i in range(1, count):
        j = i
        while j > 0:
            one, two = rows[j - 1], rows[j]
            before = two[RANGE] < one[RANGE]
            if by_visible:
                a, b = min(one[VISIBLE], 1.0), min(two[VISIBLE], 1.0)
                before = b > a or (b == a and before)
            if not before:
                break
            _swap(one, two)
            j -= 1


@leaf
def _copy(source: FloatArray, target: FloatArray) -> None:
    # Not by a slice: numba copies rows of one array by way of memory of its own.
    for k in range(len(source)):
        target[k] = source[k]


@leaf
def _swap(one: FloatArray, two: FloatArray) -> None:
    for k in range(len(one)):
        held = one[k]
        one[k] = two[k]
        two[k] = held


_read_edges_into = steady(read_edges_into)
