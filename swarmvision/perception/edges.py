"""Range, bearing and heading of every marker in a picture, in closed form from its edges.

All edges are found to a fraction of a pixel by area integration on linear light: where a signal
steps from one plateau to another, the edge stands where a sharp step of the same area would.

* Bearing is the bisector of the two tangent *angles* (not of their pixels).
* Range: in each column the inner edges of top and bottom band are ``f h / x`` px apart at the depth
  ``x`` of the surface there; the ray, that depth and the radius give the distance of the axis
  exactly. Separations do not feel a lens that sits too high or looks a little up.
* Heading: every column of the pattern votes, see :mod:`swarmvision.perception.heading`.
* Where one tangent is hidden, both possibilities are tried against the sag of the band edges, which
  follow the curve of the cylinder.
* Where only one band is in the picture, the angle between the tangents gives the range.

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
    SIDE_FLOOR,
    VISIBLE,
    WHOLE,
    complete_edges,
    range_and_bearing,
    range_from_width,
    stands_right,
)
from swarmvision.perception.detect import P_FIRST, P_KIND, P_LAST, P_LEFT, P_MIDDLE, P_RIGHT, find
from swarmvision.perception.gaze import Gaze
from swarmvision.perception.heading import heading_of
from swarmvision.perception.order import median_in_place, median_of
from swarmvision.perception.pairs import BOTH, TOP_ONLY
from swarmvision.perception.plan import (
    COLUMNS,
    GAPS,
    HEIGHT,
    INNER_BOTTOM,
    INNER_TOP,
    LOWERS,
    MOST_COLUMNS,
    RADIUS,
    RAYS,
    SPARE_A,
    UPPERS,
    Scratch,
    Task,
)
from swarmvision.perception.rings import inner_edges, looks_right, step_in
from swarmvision.perception.segment import sample_white, weigh_codes
from swarmvision.perception.sides import SHARP, find_sides

ROW = 11  # numbers of one marker
MOST = 64  # markers that one picture tells
# What no averaging removes, measured on rendered pictures with noise, blur and compression (px).
EDGE_FLOOR = 0.04  # of an inner edge,
THIN_EDGE, THICK, THIN = 0.15, 7.0, 5.0  # and of a thin ring: from 7 px on, full at 5 px
HIDDEN, HIDDEN_TURN = 2.0, 1.5  # times as much where one tangent is hidden; the latter of the heading
WIDTH_ALONE = 2.5  # times as much for a range that the tangents alone tell
SMEARED_SIDE, SMEARED_TURN = 0.03, 0.045  # of what is wider: error of a tangent, and of a column's azimuth
CLEAR, CLEARER = 0.25, 0.5  # how clearly the pattern must be there; the latter where one band must do,
WELL_SEEN = 0.6  # or less of the width is seen
SLIVER = 0.15  # visible fraction below which nothing is told
TINTED = 0.8  # weakest channel of a picture's white over its strongest, below which that may be no white
BESIDE = 4.0  # px: an end as near to a nearer marker's side is hidden by it


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


@leaf
def measure(
    image: NDArray[np.uint8],
    task: Task,
    scratch: Scratch,
    piece: FloatArray,
    rows: FloatArray,
    found: int,
) -> float:
    """Measure one candidate at full resolution into ``rows[found]``.

    Returns:
        -1 where it is a marker, 0 where it is none after all, and where it is two the column (px) that
        parts them.
    """
    lines, heights, view, light = scratch.lines, task.heights, task.eye, scratch.light
    out = rows[found]
    out[:] = np.nan
    bands = int(piece[P_KIND])
    begin, end = int(piece[P_FIRST]), int(piece[P_LAST])
    coarse, coarse_rows = scratch.look.columns[begin:end], scratch.look.rows[begin:end]
    if not looks_right(image, light, coarse, coarse_rows, bands, task.expected, task.pale, lines):
        return 0.0
    first = max(math.ceil(coarse[0] - 1.0), 0)
    last = min(int(coarse[-1] + 1.0), image.shape[1] - 1)
    if last - first < 2:
        return 0.0
    count = min(last - first + 1, MOST_COLUMNS)
    for i in range(count):
        lines[COLUMNS, i] = first + (i * (last - first)) // (count - 1) + 0.5
    thick_top, thick_bottom = _thickness(coarse_rows, 0, scratch), _thickness(coarse_rows, 2, scratch)
    count = inner_edges(
        image, light, task.directions, bands, count, coarse, coarse_rows, thick_top, thick_bottom, lines
    )
    if count < 2:
        return 0.0
    if bands == BOTH:
        split = step_in(count, lines)
        if split > 0.0:
            return split
        # Ends without edges belong to something else.
        start, stop = 0, len(coarse)
        while stop - start > 2 and coarse[start] < lines[COLUMNS, 0] - 2.5:
            start += 1
        while stop - start > 2 and coarse[stop - 1] > lines[COLUMNS, count - 1] + 2.5:
            stop -= 1
        coarse, coarse_rows = coarse[start:stop], coarse_rows[start:stop]
    for i in range(count):
        lines[RAYS, i] = math.atan((view[1] - lines[COLUMNS, i]) / view[0])
        lines[GAPS, i] = lines[LOWERS, i] - lines[UPPERS, i]
    gap, tall = median_of(lines[GAPS], count, lines[SPARE_A]), heights[INNER_TOP] - heights[INNER_BOTTOM]
    left, right, cut, end_width = find_sides(
        image, light, task.directions, bands, coarse, coarse_rows, 2.0 * heights[RADIUS] / tall * gap
    )
    left, right, covered = _uncovered(left, right, coarse, rows, found, view, heights)
    cut |= covered
    doubt = 1.0
    thin = min(max((THICK - min(thick_top, thick_bottom)) / (THICK - THIN), 0.0), 1.0)
    if bands == BOTH:
        tangents = range_and_bearing(count, lines, left, right, cut, view, heights, out)
        if tangents == 0:
            return 0.0
        doubt = 1.0 if tangents == 2 else HIDDEN
        spread = math.hypot(out[RANGE_STD] / math.sqrt(count), (EDGE_FLOOR + THIN_EDGE * thin) * doubt)
        out[RANGE_STD] = out[RANGE] * spread / gap
    else:
        if cut != 0 or not range_from_width(left, right, view, heights, out):
            return 0.0
        out[RANGE_STD] *= WIDTH_ALONE
        complete_edges(count, lines, bands, view, heights, out)
        for i in range(count):
            lines[GAPS, i] = lines[LOWERS, i] - lines[UPPERS, i]
    smear = max(end_width - SHARP, 0.0)
    out[BEARING_STD] = math.hypot(SIDE_FLOOR * (1.0 + 0.5 * thin) * doubt, SMEARED_SIDE * smear) / view[0]
    adrift = 0.0
    if cut == 3:  # no tangent is seen: the axis is anywhere where what is seen is within the marker
        half = math.asin(heights[RADIUS] / out[RANGE])
        adrift = max(1.0 - out[VISIBLE], 0.0) * half / math.sqrt(3.0)
        out[BEARING_STD] = math.hypot(out[BEARING_STD], adrift)
        out[RANGE_STD] = math.hypot(out[RANGE_STD], 0.5 * (adrift * out[RANGE]) ** 2 / heights[RADIUS])
    out[LEFT], out[RIGHT], out[COVERED] = left, right, covered
    if out[VISIBLE] < SLIVER or not stands_right(count, lines, view, heights, out):
        return 0.0
    if bands != BOTH and not _has_proportion(count, lines, coarse_rows, bands, heights, scratch):
        return 0.0
    if len(task.knots) > 0:
        out[HEADING], out[HEADING_STD], clarity, slope = heading_of(
            image, task, count, out[RANGE], out[BEARING], scratch
        )
        # Columns in px are azimuths by way of the radius; the place of a ring out of the picture is a guess.
        turn = math.hypot(SMEARED_TURN * smear / view[0], adrift) * out[RANGE] / heights[RADIUS]
        if bands != BOTH:
            turn = math.hypot(turn, 0.5 * tall / max(slope, 1e-6) * out[RANGE_STD] / out[RANGE])
        out[HEADING_STD] = math.hypot(out[HEADING_STD] * (HIDDEN_TURN if doubt > 1.0 else 1.0), turn)
        sure = bands == BOTH and out[VISIBLE] > WELL_SEEN
        if not clarity > (CLEAR if sure else CLEARER):
            return 0.0
    return -1.0


@leaf
def _uncovered(
    left: float,
    right: float,
    coarse: FloatArray,
    rows: FloatArray,
    found: int,
    view: FloatArray,
    heights: FloatArray,
) -> tuple[float, float, int]:
    """Return the ends (px) of what nearer markers leave free, and which are theirs: 1 left, 2 right.

    Args:
        left: Where the rings end.
        right: Likewise.
        coarse: Columns in which the marker is seen (px).
        rows: Nearer markers.
        found: How many.
        view: Of the lens.
        heights: Of the marker.
    """
    ends = 0
    first, last = min(left, coarse[0]), max(right, coarse[-1])
    for i in range(found):
        half = math.asin(heights[RADIUS] / rows[i, RANGE])
        begin = view[1] - view[0] * math.tan(rows[i, BEARING] + half)
        end = view[1] - view[0] * math.tan(rows[i, BEARING] - half)
        if begin - BESIDE < first < end + BESIDE or begin - BESIDE < left < end + BESIDE:
            ends, left = ends | 1, end
        if begin - BESIDE < last < end + BESIDE or begin - BESIDE < right < end + BESIDE:
            ends, right = ends | 2, begin
    return left, right, ends


@leaf
def _thickness(rows: FloatArray, edge: int, scratch: Scratch) -> float:
    """Return the median thickness (px) of the band that begins at an edge of a candidate's rows."""
    spare = scratch.look.spare[0]
    for i in range(len(rows)):
        spare[i] = rows[i, edge + 1] - rows[i, edge]
    return median_in_place(spare, len(rows))


@leaf
def _has_proportion(
    count: int, lines: FloatArray, rows: FloatArray, bands: int, heights: FloatArray, scratch: Scratch
) -> bool:
    """Whether one band alone is as wide for its thickness as the marker's is."""
    thick = _thickness(rows, 0 if bands == TOP_ONLY else 2, scratch)
    ring = heights[HEIGHT] - heights[INNER_TOP] if bands == TOP_ONLY else heights[INNER_BOTTOM]
    wide = (lines[COLUMNS, count - 1] - lines[COLUMNS, 0] + 1.0) / thick * ring / (2.0 * heights[RADIUS])
    fits: bool = 0.7 < wide < 1.4
    return fits


_read_edges_into = steady(read_edges_into)
