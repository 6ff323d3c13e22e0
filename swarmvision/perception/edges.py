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

Source of the geometry: our own; the paper (Majidi Balanji et al.) uses centroids of regions instead,
see :mod:`swarmvision.perception.moments`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.colour import decode
from swarmvision.compiled import compiled
from swarmvision.data import Estimates
from swarmvision.geometry import FloatArray
from swarmvision.marker import Band, Marker
from swarmvision.perception.detect import BOTH, TOP_ONLY, Candidate, Proportions, candidates
from swarmvision.perception.heading import heading_of
from swarmvision.perception.segment import Balance, Hues, chroma_of

MOST_COLUMNS = 32  # of one marker that are measured
WHOLE = 0.955  # measured over expected width from which both tangents are taken as real
# What no averaging removes, measured on rendered pictures with noise, blur and compression (px).
EDGE_FLOOR = 0.03  # of an inner edge,
THIN_EDGE, THICK, THIN = (
    0.15,
    7.0,
    5.0,
)  # and of a thin ring: from 7 px on, full at 5 px
SIDE_FLOOR = 0.11  # of a tangent
HIDDEN = 4.0  # times as much where one tangent is hidden
NEARBY = 5  # px: how far off a coarse row may be
STEP_SLACK = 0.8  # px by which the separation may change between neighbouring columns of one marker,
STEP_SHARE = 0.05  # and by which share of itself
TILT = 0.07  # rad: more than the 3 deg that a camera may look up or down
LEAST_SEPARATION = 2.0  # px between the inner edges; less tells nothing
CLEAR, CLEARER = 0.25, 0.5  # how clearly the pattern must be there; the latter where one band must do,
WELL_SEEN = 0.6  # or less of the width is seen
SLIVER = 0.15  # visible fraction below which nothing is told
PALE_ENOUGH = 0.55  # share of the middle zone that must look like the marker
BESIDE = 4.0  # px: an end as near to a nearer marker's side is hidden by it
HORIZON_SLACK = 0.012  # m: by which a marker may stand higher or lower than it should
PROBES = 15  # heights of the middle zone that are looked at
UPPER, LOWER, TOP_RING, BOTTOM_RING, STRIPE, GROUND, TOTAL = range(7)  # directions of colour
# What the kernel writes of a marker.
RANGE, BEARING, HEADING, RANGE_STD, BEARING_STD, HEADING_STD, VISIBLE, DROP, LEFT, RIGHT, SPLIT = range(11)


@dataclass(frozen=True, eq=False, slots=True)
class Plan:
    """Everything about one kind of marker that reading needs, worked out once."""

    hues: Hues
    proportions: Proportions | None
    directions: FloatArray
    """Weights of the channels for each direction of colour, ``(7, 3)``."""
    heights: FloatArray
    """Of the inner edges of top and bottom band, of bottom and top of the patterned band, of marker,
    all above the marker's bottom edge; the radius; height of the marker's base above the ground (m)."""
    knots: FloatArray
    """Of the pattern; empty where the marker tells no heading."""
    expected: FloatArray
    """Chroma that each probe of the middle zone may have, nan where unused, ``(PROBES, 2, 3)``."""
    pale: bool
    """Whether the largest middle band is white or grey."""

    @classmethod
    def of(cls, marker: Marker) -> Plan:
        """Return the plan for a marker."""
        hues = Hues.of(marker)
        directions = np.zeros((7, 3))
        directions[UPPER] = _inner_direction(marker.bands[0], marker.bands[1])
        directions[LOWER] = -_inner_direction(marker.bands[-1], marker.bands[-2])
        for place, band in ((TOP_RING, marker.bands[0]), (BOTTOM_RING, marker.bands[-1])):
            chroma = chroma_of(band.colour)
            directions[place] = chroma / max(float(np.linalg.norm(chroma)), 1e-9)
        directions[TOTAL] = 1.0
        knots = np.empty((0, 3))
        low = high = 0.0
        carrier = marker.patterned
        if carrier is not None and carrier.pattern is not None and not carrier.pattern.symmetric:
            knots, low, high = carrier.pattern.knots, carrier.bottom, carrier.top
            ground, ink = decode(carrier.colour), decode(carrier.pattern.colour)
            # Blind to brightness: what the band's own colour gives is nothing.
            weights = _towards(carrier.colour, carrier.pattern.colour)
            weights = weights - ground * (weights @ ground) / (ground @ ground)
            directions[STRIPE] = weights / (ink @ weights)
            directions[GROUND] = ground / (ground @ ground)
        heights = np.array(
            [
                marker.bands[0].bottom,
                marker.bands[-1].top,
                low,
                high,
                marker.height,
                marker.radius,
                marker.base,
            ]
        )
        middle = max(marker.bands[1:-1] or marker.bands, key=lambda band: band.top - band.bottom)
        pale = bool(np.linalg.norm(chroma_of(middle.colour)) < 0.1)
        return cls(
            hues, Proportions.of(marker, hues), directions, heights, knots, _expected_chroma(marker), pale
        )


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


def read(image: NDArray[np.uint8], lens: Lens, plan: Plan) -> Estimates:
    """Return the neighbours in a picture ``(h, w, 3)``, nearest first, lens frame, shape ``(k,)``."""
    return estimates(readings(image, Balance.of(image), lens, plan))


def readings(image: NDArray[np.uint8], balance: Balance, lens: Lens, plan: Plan) -> list[Reading]:
    """Return every marker in a picture, nearest first."""
    if plan.proportions is None or min(image.shape[0], image.shape[1]) < 4:
        return []
    found = candidates(image, balance, plan.hues, plan.proportions)
    if not found:
        return []
    tables = plan.directions[:, :, None] * balance.light
    measured: list[Reading] = []
    found.reverse()
    while found:  # the tallest first: what hides is measured before what it hides
        candidate = found.pop()
        reading = measure(image, tables, candidate, lens, plan, _covered(candidate, measured))
        if isinstance(reading, Reading):
            measured.append(reading)
        elif reading is not None:
            found.extend(_halves(candidate, reading))
    return _distinct(measured, plan.heights[5])


def _halves(candidate: Candidate, column: float) -> list[Candidate]:
    """Return the two markers that a candidate is when cut at a column (px), the taller one last."""
    split = int(np.searchsorted(candidate.columns, column))
    pieces = []
    for part in (slice(0, split), slice(split, None)):
        columns, rows = candidate.columns[part], candidate.rows[part]
        if 2 <= len(columns) < len(candidate.columns):
            middle = float(np.median(rows[:, 2] - rows[:, 1]))
            left = candidate.left if part.start == 0 else column
            right = column if part.start == 0 else candidate.right
            pieces.append(
                replace(candidate, left=left, right=right, middle=middle, columns=columns, rows=rows)
            )
    return sorted(pieces, key=lambda piece: piece.middle)


def _covered(candidate: Candidate, nearer: list[Reading]) -> int:
    """Return which ends of a candidate stand at a nearer marker and are no tangents: 1 left, 2 right."""
    ends = 0
    for other in nearer:
        if other.left - BESIDE < candidate.left < other.right + BESIDE:
            ends |= 1
        if other.left - BESIDE < candidate.right < other.right + BESIDE:
            ends |= 2
    return ends


def measure(
    image: NDArray[np.uint8],
    tables: FloatArray,
    candidate: Candidate,
    lens: Lens,
    plan: Plan,
    covered: int = 0,
) -> Reading | float | None:
    """Return what a candidate measures at full resolution.

    None where it is no marker after all, and where it is two, the column (px) that parts them.

    Args:
        image: sRGB, ``(h, w, 3)``.
        tables: What each code of each channel adds along each direction of colour, ``(7, 3, 256)``.
        candidate: From :mod:`swarmvision.perception.detect`.
        lens: That took the picture.
        plan: Of the marker.
        covered: Which ends are known to be no tangents: 1 the left, 2 the right.
    """
    view = np.array([lens.focal_px, lens.centre_px[0], lens.centre_px[1], lens.height])
    out = np.full(11, np.nan)
    if not measure_marker(
        image, tables, candidate.columns, candidate.rows, candidate.bands, covered, view,
        plan.heights, plan.knots,
        plan.expected, plan.pale, out,
    ):  # fmt: skip
        return float(out[SPLIT]) if out[SPLIT] > 0.0 else None
    covariance = np.diag(np.square(out[[RANGE_STD, BEARING_STD, HEADING_STD]]))
    if np.isnan(out[HEADING]):
        covariance[2, :] = covariance[:, 2] = np.nan
    visible = float(out[VISIBLE])
    return Reading(
        float(out[RANGE]),
        float(out[BEARING]),
        float(out[HEADING]),
        covariance,
        min(visible, 1.0),
        float(out[DROP]),
        float(out[LEFT]),
        float(out[RIGHT]),
        visible >= WHOLE,
        covered,
    )


def estimates(found: list[Reading]) -> Estimates:
    """Return readings as estimates in the lens frame, shape ``(k,)``."""
    k = len(found)
    return Estimates(
        seen=np.ones(k, dtype=bool),
        range=np.array([r.range for r in found]),
        bearing=np.array([r.bearing for r in found]),
        heading=np.array([r.heading for r in found]),
        covariance=np.array([r.covariance for r in found]).reshape(k, 3, 3),
        age=np.zeros(k),
        track=np.full(k, -1),
        visible=np.array([r.visible for r in found]),
        frame="lens",
    )


def _distinct(found: list[Reading], radius: float) -> list[Reading]:
    """Drop readings of a marker that is already read: two axes cannot be nearer than two radii."""
    kept: list[Reading] = []
    for reading in sorted(found, key=lambda r: (-r.visible, r.range)):
        place = reading.range * np.exp(1j * reading.bearing)
        if all(abs(place - r.range * np.exp(1j * r.bearing)) > 2.0 * radius for r in kept):
            kept.append(reading)
    return sorted(kept, key=lambda r: r.range)


def _towards(start: tuple[int, int, int], end: tuple[int, int, int]) -> FloatArray:
    """Return the direction of colour along which a step from one print to another is largest."""
    difference = decode(end) - decode(start)
    return difference / max(float(np.linalg.norm(difference)), 1e-9)


def _inner_direction(ring: Band, middle: Band) -> FloatArray:
    """Return the direction of colour from a ring to what lies inside, blind to the pattern on that."""
    direction = _towards(ring.colour, middle.colour)
    if middle.pattern is not None:
        stripe = _towards(middle.colour, middle.pattern.colour)
        blind = direction - stripe * (stripe @ direction)
        if np.linalg.norm(blind) > 0.3:  # else the stripe has the ring's own colour
            return blind / float(np.linalg.norm(blind))
    return direction


def _expected_chroma(marker: Marker) -> FloatArray:
    expected = np.full((PROBES, 2, 3), np.nan)
    middle = marker.bands[0].bottom - marker.bands[-1].top
    for i, share in enumerate(np.linspace(0.08, 0.92, PROBES)):
        height = marker.bands[0].bottom - share * middle
        for band in marker.bands:
            if band.bottom < height < band.top:
                expected[i, 0] = chroma_of(band.colour)
                if band.pattern is not None:
                    expected[i, 1] = chroma_of(band.pattern.colour)
    return expected


@compiled
def measure_marker(
    image: NDArray[np.uint8],
    tables: FloatArray,
    coarse: FloatArray,
    coarse_rows: FloatArray,
    bands: int,
    covered: int,
    view: FloatArray,
    heights: FloatArray,
    knots: FloatArray,
    expected: FloatArray,
    pale: bool,
    out: FloatArray,
) -> bool:
    """Measure one candidate into ``out``; return whether it is a marker."""
    if not looks_right(image, tables, coarse, coarse_rows, bands, expected, pale):
        return False
    first = max(math.ceil(coarse[0] - 1.0), 0)
    last = min(int(coarse[-1] + 1.0), image.shape[1] - 1)
    if last - first < 2:
        return False
    count = min(last - first + 1, MOST_COLUMNS)
    columns, rows = np.empty(count), np.empty((4, count))
    for i in range(count):
        columns[i] = first + (i * (last - first)) // (count - 1) + 0.5
    for k in range(4):
        rows[k] = np.interp(columns, coarse, coarse_rows[:, k])
    upper, lower = np.empty(count), np.empty(count)
    thick_top = np.median(coarse_rows[:, 1] - coarse_rows[:, 0])
    thick_bottom = np.median(coarse_rows[:, 3] - coarse_rows[:, 2])
    used = inner_edges(image, tables, bands, columns, rows, thick_top, thick_bottom, upper, lower)
    if used < 2:
        return False
    columns, upper, lower = columns[:used], upper[:used], lower[:used]
    if bands == BOTH:
        out[SPLIT] = step_in(columns, lower - upper)
        if out[SPLIT] > 0.0:
            return False
    # Ends without edges belong to something else.
    begin, end = 0, len(coarse)
    while bands == BOTH and end - begin > 2 and coarse[begin] < columns[0] - 2.5:
        begin += 1
    while bands == BOTH and end - begin > 2 and coarse[end - 1] > columns[-1] + 2.5:
        end -= 1
    coarse, coarse_rows = coarse[begin:end], coarse_rows[begin:end]
    sides = np.empty(2)
    cut = find_sides(image, tables, bands, coarse, coarse_rows, sides) | covered
    rays = np.arctan((view[1] - columns) / view[0])
    doubt = 1.0
    if bands == BOTH:
        separation = lower - upper
        if not range_and_bearing(rays, separation, sides, cut, view, heights, out):
            return False
        doubt = 1.0 if out[VISIBLE] >= WHOLE else HIDDEN
        thin = min(max((THICK - min(thick_top, thick_bottom)) / (THICK - THIN), 0.0), 1.0)
        spread = math.hypot(out[RANGE_STD] / math.sqrt(used), (EDGE_FLOOR + THIN_EDGE * thin) * doubt)
        out[RANGE_STD] = out[RANGE] * spread / np.median(separation)
    else:
        if cut != 0 or not range_from_width(sides, view, heights, out):
            return False
        complete_edges(rays, bands, view, heights, out, upper, lower)
    out[BEARING_STD] = SIDE_FLOOR * doubt / view[0]
    out[LEFT], out[RIGHT] = sides[0], sides[1]
    if out[VISIBLE] < SLIVER or not stands_right(rays, upper, lower, view, heights, out):
        return False
    if bands != BOTH and not has_proportion(columns, coarse_rows, bands, heights):
        return False
    if len(knots) > 0:
        out[HEADING], out[HEADING_STD], clarity = heading_of(
            image, tables[STRIPE], tables[GROUND], columns, rays, upper, lower,
            out[RANGE], out[BEARING], heights, knots,
        )  # fmt: skip
        sure = bands == BOTH and out[VISIBLE] > WELL_SEEN
        if not clarity > (CLEAR if sure else CLEARER):
            return False
    return True


@compiled
def has_proportion(columns: FloatArray, rows: FloatArray, bands: int, heights: FloatArray) -> bool:
    """Whether one band alone is as wide for its thickness as the marker's is."""
    which = 0 if bands == TOP_ONLY else 2
    thick = np.median(rows[:, which + 1] - rows[:, which])
    ring = heights[4] - heights[0] if bands == TOP_ONLY else heights[1]
    wide = (columns[-1] - columns[0] + 1.0) / thick * ring / (2.0 * heights[5])
    fits: bool = 0.7 < wide < 1.4
    return fits


@compiled
def signal(image: NDArray[np.uint8], table: FloatArray, row: int, column: int) -> float:
    """Return a pixel along one direction of colour."""
    value: float = (
        table[0, image[row, column, 0]] + table[1, image[row, column, 1]] + table[2, image[row, column, 2]]
    )
    return value


@compiled
def looks_right(
    image: NDArray[np.uint8],
    tables: FloatArray,
    columns: FloatArray,
    rows: FloatArray,
    bands: int,
    expected: FloatArray,
    pale: bool,
) -> bool:
    """Whether what lies between top and bottom band has the colours that the marker has there."""
    height, width = image.shape[0], image.shape[1]
    light = tables[TOTAL]
    step = max(len(columns) // 12, 1)
    looks = (len(columns) + step - 1) // step
    totals, near = np.empty(looks * PROBES), np.zeros(looks * PROBES)
    rings = np.empty((2, looks))
    seen = 0
    for i in range(looks):
        u = min(max(int(columns[i * step]), 0), width - 1)
        for ring in range(2):
            v = min(max(int((rows[i * step, 2 * ring] + rows[i * step, 2 * ring + 1]) / 2.0), 0), height - 1)
            rings[ring, i] = signal(image, light, v, u)
        start, end = rows[i * step, 1], rows[i * step, 2]
        for probe in range(PROBES):
            v = int(start + (0.08 + 0.84 * probe / (PROBES - 1)) * (end - start))
            if v < 0 or v >= height:
                continue
            red, green, blue = light[0, image[v, u, 0]], light[1, image[v, u, 1]], light[2, image[v, u, 2]]
            total = max(red + green + blue, 1e-6)
            totals[seen] = total
            for option in range(2):
                want = expected[probe, option]
                if np.isnan(want[0]):
                    continue
                off = math.sqrt(
                    (red / total - 1.0 / 3.0 - want[0]) ** 2
                    + (green / total - 1.0 / 3.0 - want[1]) ** 2
                    + (blue / total - 1.0 / 3.0 - want[2]) ** 2
                )
                size = math.sqrt(want[0] ** 2 + want[1] ** 2 + want[2] ** 2)
                if off < 0.16 + 0.35 * size:
                    near[seen] = 1.0
            seen += 1
    if seen == 0:
        return False
    totals, near = totals[:seen], near[:seen]
    if pale:
        # A white middle is brighter than both rings; dark grey is a body or a wall in shadow.
        middle = np.median(totals)
        top, bottom = np.median(rings[0]), np.median(rings[1])
        if bands != BOTH:  # the other ring is out of the picture
            top = bottom = top if bands == TOP_ONLY else bottom
        if middle < 1.2 * max(top, bottom):
            return False
        least = 0.35 * max(middle, 0.25 * (top + bottom) / 2.0)
        for i in range(seen):
            if totals[i] <= least:
                near[i] = 0.0
    enough: bool = near.sum() >= PALE_ENOUGH * seen
    return enough


@compiled
def inner_edges(
    image: NDArray[np.uint8],
    tables: FloatArray,
    bands: int,
    columns: FloatArray,
    rows: FloatArray,
    thick_top: float,
    thick_bottom: float,
    upper: FloatArray,
    lower: FloatArray,
) -> int:
    """Find the inner edges of top and bottom band; keep the columns where both are; return how many."""
    count = len(columns)
    found = np.empty((2, count))
    steps = np.zeros((2, count))
    for which in range(2):
        thick = thick_top if which == 0 else thick_bottom
        window = min(max(round(0.5 * thick), 2), 5)
        for i in range(count):
            guess = rows[1 + which, i]
            row, step = row_edge(image, tables[which], int(columns[i]), guess, window)
            if abs(row - guess) >= max(0.5 * thick, 2.5):
                step = 0.0
            found[which, i], steps[which, i] = row, step
    good = np.ones(count, dtype=np.bool_)
    for which in range(2):
        if bands == BOTH or (bands == TOP_ONLY) == (which == 0):
            least = 0.25 * np.median(steps[which])
            for i in range(count):
                if steps[which, i] <= max(least, 1e-9):
                    good[i] = False
        else:
            found[which] = rows[1 + which]
    used = 0
    for i in range(count):
        if good[i] and found[1, i] - found[0, i] > LEAST_SEPARATION:
            columns[used], upper[used], lower[used] = columns[i], found[0, i], found[1, i]
            used += 1
    return used


@compiled
def step_in(columns: FloatArray, separation: FloatArray) -> float:
    """Return the column (px) at which the separation steps: one marker beside another; 0 for none."""
    worst, where = 0.0, 0.0
    for k in range(2, len(columns) - 1):
        first, last = max(k - 3, 0), min(k + 3, len(columns))
        before, after = np.median(separation[first:k]), np.median(separation[k:last])
        step = abs(after - before) - STEP_SLACK - STEP_SHARE * min(before, after)
        if step > worst:
            worst, where = step, (columns[k - 1] + columns[k]) / 2.0
    return where


@compiled
def row_edge(
    image: NDArray[np.uint8], table: FloatArray, column: int, guess: float, window: int
) -> tuple[float, float]:
    """Return the row of a step up from above to below by area integration, and its size; 0 for none."""
    flat = max(window // 2, 1)
    row, step = guess, 0.0
    # The steepest place near the guess; a coarse look is some px off.
    around = math.floor(guess + 0.5)
    steepest = 0.0
    if around - NEARBY >= 1 and around + NEARBY < image.shape[0]:
        before = signal(image, table, around - NEARBY - 1, column)
        for v in range(around - NEARBY, around + NEARBY + 1):
            value = signal(image, table, v, column)
            if value - before > steepest:
                steepest, row = value - before, float(v)
            before = value
    for _ in range(2):  # the first round centres the window on the edge
        start = math.floor(row + 0.5) - window
        if start < 0 or start + 2 * window > image.shape[0]:
            return row, 0.0
        above = below = area = 0.0
        for k in range(2 * window):
            value = signal(image, table, start + k, column)
            area += value
            if k < flat:
                above += value
            if k >= 2 * window - flat:
                below += value
        above, below = above / flat, below / flat
        step = below - above
        if step < 1e-6:
            return row, 0.0
        row = start + 2 * window - (area - 2 * window * above) / step
    return row, step


@compiled
def find_sides(
    image: NDArray[np.uint8],
    tables: FloatArray,
    bands: int,
    columns: FloatArray,
    rows: FloatArray,
    sides: FloatArray,
) -> int:
    """Write the columns (px) at which the rings end; return 1 if the left is the picture's, 2 the right."""
    width = columns[-1] - columns[0] + 1.0
    half = (columns[1] - columns[0]) / 2.0 if len(columns) > 1 else 0.5
    half = min(half, 2.0)
    places, weights = np.zeros(2), np.zeros(2)
    for side in range(2):
        outward = -1 if side == 0 else 1
        guess = columns[0] - half if side == 0 else columns[-1] + half
        places[:], weights[:] = guess, 0.0
        for ring in range(2):
            if bands != BOTH and (bands == TOP_ONLY) != (ring == 0):
                continue
            top, bottom = end_rows(rows, side, ring)
            place, weight = ring_end(image, tables[TOP_RING + ring], top, bottom, guess, outward, width)
            places[ring], weights[ring] = place, weight
        total = weights[0] + weights[1]
        if total <= 0.0:
            sides[side] = guess
        elif min(weights[0], weights[1]) > 0.0 and abs(places[0] - places[1]) > 0.6 + 0.01 * width:
            # Bodies stand beside the lower ring, nothing beside the upper one.
            sides[side] = places[0]
        else:
            sides[side] = (places[0] * weights[0] + places[1] * weights[1]) / total
    cut = 1 if sides[0] < 1.5 else 0
    if sides[1] > image.shape[1] - 1.5:
        cut += 2
    return cut


@compiled
def end_rows(rows: FloatArray, side: int, ring: int) -> tuple[float, float]:
    """Return the rows of a ring at one end of a candidate: medians of its outermost three columns."""
    few = min(len(rows), 3)
    piece = rows[:few] if side == 0 else rows[len(rows) - few :]
    return np.median(piece[:, 2 * ring]), np.median(piece[:, 2 * ring + 1])


@compiled
def ring_end(
    image: NDArray[np.uint8],
    table: FloatArray,
    top: float,
    bottom: float,
    guess: float,
    outward: int,
    width: float,
) -> tuple[float, float]:
    """Return the column (px) at which a ring ends on one side, and the weight of that; 0 for none."""
    inset = 0.3 * (bottom - top)
    first = math.ceil(top + inset)
    last = max(int(bottom - inset), first + 1)
    if first < 0 or last > image.shape[0]:
        return guess, 0.0
    reach = int(min(max(0.16 * width, 5.0), 14.0))
    # Count pixels outward from well inside; beyond the picture's side there are none.
    start = math.floor(guess) - outward * reach
    size = 2 * reach
    if outward > 0:
        start = max(start, 0)
        size = min(size, image.shape[1] - start)
    else:
        start = min(start, image.shape[1] - 1)
        size = min(size, start + 1)
    if size < 3:
        return guess, 0.0
    inner = max(reach // 2, 1)
    inside = outside = area = 0.0
    outer = max(min(size - 3 * reach // 2, inner), 1)
    for k in range(size):
        value = 0.0
        for row in range(first, last):
            value += signal(image, table, row, start + outward * k)
        value /= last - first
        area += value
        if k < inner:
            inside += value / inner
        if k >= size - outer:
            outside += value / outer
    if inside - outside < max(0.3 * inside, 1e-6):
        return guess, 0.0
    reached = (area - size * outside) / (inside - outside)
    place = start + reached if outward > 0 else start + 1 - reached
    return place, (last - first) * (inside - outside)


@compiled
def range_and_bearing(
    rays: FloatArray,
    separation: FloatArray,
    sides: FloatArray,
    cut: int,
    view: FloatArray,
    heights: FloatArray,
    out: FloatArray,
) -> bool:
    """Write range (m), bearing (rad), visible fraction and, as RANGE_STD, the spread of the edges (px)."""
    radius = heights[5]
    left = math.atan((view[1] - sides[0]) / view[0])
    right = math.atan((view[1] - sides[1]) / view[0])
    if left - right <= 1e-4:
        return False
    bearing = (left + right) / 2.0
    distance, noise = axis_distance(rays, separation, bearing, view, heights)
    if not distance > radius:
        return False
    half = math.asin(radius / distance)
    visible = (left - right) / (2.0 * half)
    if visible > 1.25:
        return False
    if visible < WHOLE or cut != 0:
        best = np.inf
        for side in range(2):
            if cut & (1 << side):
                continue
            edge, sign = (left, -1.0) if side == 0 else (right, 1.0)
            trial_bearing, trial_noise, trial = edge + sign * half, np.inf, distance
            for _ in range(3):
                trial, trial_noise = axis_distance(rays, separation, trial_bearing, view, heights)
                if not trial > radius:
                    trial_noise = np.inf
                    break
                trial_bearing = edge + sign * math.asin(radius / trial)
            if trial_noise < best:
                best, distance, bearing, noise = trial_noise, trial, trial_bearing, trial_noise
        visible = (left - right) / (2.0 * math.asin(radius / distance))
    out[RANGE], out[BEARING], out[VISIBLE], out[RANGE_STD] = distance, bearing, visible, noise
    return True


@compiled
def axis_distance(
    rays: FloatArray, separation: FloatArray, bearing: float, view: FloatArray, heights: FloatArray
) -> tuple[float, float]:
    """Return the range (m) of the axis at a bearing (rad), and the spread of the separations (px).

    With ``rho`` the way of the ray to the surface, ``delta`` its angle off the axis and R the radius,
    ``d = rho cos(delta) + sqrt(R^2 - rho^2 sin^2(delta))``.
    """
    radius = heights[5]
    rho = view[0] * (heights[0] - heights[1]) / separation / np.cos(rays)
    across = np.abs(rho * np.sin(rays - bearing))
    for rim in (0.86, 1.0):  # near the rim the sag is too steep to be told well
        within = across < rim * radius
        if within.sum() >= 2:
            break
    if within.sum() < 2:
        return np.nan, np.nan
    inner = np.sqrt(np.maximum(radius * radius - across[within] ** 2, 0.0))
    distances = rho[within] * np.cos(rays[within] - bearing) + inner
    middle = np.median(distances)
    spread = 1.4826 * np.median(np.abs(distances - middle))
    kept = distances[np.abs(distances - middle) <= 3.0 * spread + 1e-9]
    return kept.mean(), kept.std() * np.median(separation) / middle


@compiled
def range_from_width(sides: FloatArray, view: FloatArray, heights: FloatArray, out: FloatArray) -> bool:
    """Write range and bearing from the two tangents alone."""
    left = math.atan((view[1] - sides[0]) / view[0])
    right = math.atan((view[1] - sides[1]) / view[0])
    half = (left - right) / 2.0
    if half <= 1e-3:
        return False
    out[RANGE], out[BEARING], out[VISIBLE] = heights[5] / math.sin(half), (left + right) / 2.0, 1.0
    out[RANGE_STD] = out[RANGE] * SIDE_FLOOR / (view[0] * half)
    return True


@compiled
def complete_edges(
    rays: FloatArray,
    bands: int,
    view: FloatArray,
    heights: FloatArray,
    out: FloatArray,
    upper: FloatArray,
    lower: FloatArray,
) -> None:
    """Write where the inner edge of the band that the picture lacks would be."""
    for i in range(len(rays)):
        delta = rays[i] - out[BEARING]
        across = min(abs(out[RANGE] * math.sin(delta)), heights[5])
        rho = out[RANGE] * math.cos(delta) - math.sqrt(heights[5] ** 2 - across * across)
        gap = view[0] * (heights[0] - heights[1]) / max(rho * math.cos(rays[i]), 1e-3)
        if bands == TOP_ONLY:
            lower[i] = upper[i] + gap
        else:
            upper[i] = lower[i] - gap


@compiled
def stands_right(
    rays: FloatArray,
    upper: FloatArray,
    lower: FloatArray,
    view: FloatArray,
    heights: FloatArray,
    out: FloatArray,
) -> bool:
    """Write the drop (px); return whether it stands at its height, give or take the tilt of a camera."""
    middle = heights[6] + (heights[0] + heights[1]) / 2.0
    drops = np.empty(len(rays))
    for i in range(len(rays)):
        delta = rays[i] - out[BEARING]
        across = min(abs(out[RANGE] * math.sin(delta)), heights[5])
        rho = out[RANGE] * math.cos(delta) - math.sqrt(heights[5] ** 2 - across * across)
        depth = max(rho * math.cos(rays[i]), 1e-3)
        drops[i] = (upper[i] + lower[i]) / 2.0 - (view[2] - view[0] * (middle - view[3]) / depth)
    out[DROP] = np.median(drops)
    depth = max((out[RANGE] - heights[5]) * math.cos(out[BEARING]), 1e-3)
    right: bool = abs(out[DROP]) / view[0] < TILT + HORIZON_SLACK / depth
    return right
