"""One candidate of a picture at full resolution: whether it is a marker, and where it stands.

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
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.perception.cylinder import (
    BEARING,
    BEARING_STD,
    COVERED,
    HEADING,
    HEADING_STD,
    LEFT,
    RANGE,
    RANGE_STD,
    RIGHT,
    SIDE_FLOOR,
    VISIBLE,
    complete_edges,
    range_and_bearing,
    range_from_width,
    stands_right,
)
from swarmvision.perception.detect import P_FIRST, P_KIND, P_LAST
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
from swarmvision.perception.sides import SHARP, find_sides

# What no averaging removes, measured on rendered pictures with noise, blur and compression (px).
EDGE_FLOOR = 0.04  # of an inner edge,
THIN_EDGE, THICK, THIN = 0.15, 7.0, 5.0  # and of a thin ring: from 7 px on, full at 5 px
HIDDEN, HIDDEN_TURN = 2.0, 1.5  # times as much where one tangent is hidden; the latter of the heading
WIDTH_ALONE = 2.5  # times as much for a range that the tangents alone tell
SMEARED_SIDE, SMEARED_TURN = 0.03, 0.045  # of what is wider: error of a tangent, and of a column's azimuth
CLEAR, CLEARER = 0.25, 0.5  # how clearly the pattern must be there; the latter where one band must do,
WELL_SEEN = 0.6  # or less of the width is seen
SLIVER = 0.15  # visible fraction below which nothing is told
BESIDE = 4.0  # px: an end as near to a nearer marker's side is hidden by it


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
    for i in range(count):
        lines[RAYS, i] = math.atan((view[1] - lines[COLUMNS, i]) / view[0])
        lines[GAPS, i] = lines[LOWERS, i] - lines[UPPERS, i]
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
