"""The heading of a marker by the vote of every column of its pattern.

The surface seen in a column faces azimuth ``a`` in the lens frame; a stripe at the height that the
pattern has at azimuth ``phi`` means a heading of ``a - phi``. There is no seam to cut and no dead zone.
A coarse look correlates the unrolled pattern with a few dozen headings; then each column's stripe is
compared with the pattern's edges there, whose slope turns a height into an angle.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.marker import pattern_edges
from swarmvision.perception.order import median_of, weighted_median
from swarmvision.perception.plan import (
    AZIMUTHS,
    BAND_HIGH,
    BAND_LOW,
    COLUMNS,
    FACING,
    GAPS,
    GROUND,
    HEIGHTS,
    INNER_BOTTOM,
    INNER_TOP,
    LOWERS,
    RADIUS,
    RAYS,
    SPARE_A,
    SPARE_B,
    SPARE_C,
    SPARE_D,
    SPARE_E,
    STRIPE,
    UPPERS,
    Scratch,
    Task,
)

BRIGHT_ROWS = 32  # of one column, at most, that tell how bright the band is there
TRIALS = 72  # headings of the coarse look
VOTERS = 16  # columns, about, of the coarse look
ROUNDS, SETTLED = 4, 3e-4  # of the vote; rad: a change that no further round is worth
RIM = 0.93  # of the radius: columns farther out see the surface too slantwise
JUMP, JUMP_HEIGHT = 0.02, 0.004  # rad; m: a pattern that climbs so much within it jumps, and has no vote
HEADING_FLOOR = 0.0015  # rad: error that no averaging removes,
STRIPE_FLOOR, THIN_STRIPE = 0.042, 0.2  # px, and px over the stripe's thickness in px: that of its height
UNSURE = 0.5  # rad: spread of a heading that only the coarse look tells


@leaf
def heading_of(
    image: NDArray[np.uint8],
    task: Task,
    count: int,
    distance: float,
    bearing: float,
    scratch: Scratch,
) -> tuple[float, float, float, float]:
    """Return heading (rad), its spread, how clearly the pattern is there, about 0..1, and its slope (m/rad).

    All are nan where fewer than two columns can show the pattern.

    Args:
        image: sRGB, ``(h, w, 3)``.
        task: What is looked for.
        count: Of the columns in the scratch's lines: with rays, and rows of the inner edges.
        distance: Of the axis (m).
        bearing: Of the axis (rad).
        scratch: Room.
    """
    lines, heights = scratch.lines, task.heights
    used = 0
    for i in range(count):
        across = distance * math.sin(lines[RAYS, i] - bearing) / heights[RADIUS]
        if abs(across) >= RIM:
            continue
        # The normal of the near surface: back along the ray, turned by the angle of incidence.
        lines[FACING, used] = lines[RAYS, i] + math.pi - math.asin(across)
        unroll(
            image, scratch.light, task.directions[STRIPE], task.directions[GROUND], int(lines[COLUMNS, i]),
            lines[UPPERS, i], lines[LOWERS, i], heights, scratch.strip, lines[SPARE_A], scratch.signals[used],
        )  # fmt: skip
        used += 1
    if used < 2:
        return np.nan, np.nan, np.nan, np.nan
    heading, clarity = coarse_heading(
        scratch.signals, lines[FACING], used, task.stripe, lines[SPARE_A], lines[SPARE_B], lines[SPARE_C]
    )
    heading, spread, slope, tall = voted_heading(
        scratch.signals, lines[FACING], used, heading, heights, task.knots, lines
    )
    gap = median_of(lines[GAPS], count, lines[SPARE_A])
    scale = gap / (heights[INNER_TOP] - heights[INNER_BOTTOM])  # px per m
    floor = math.hypot(STRIPE_FLOOR, THIN_STRIPE / max(scale * tall, 1.0))
    return heading, math.hypot(spread, floor / max(scale * slope, 1e-6)), clarity, slope


@leaf
def unroll(
    image: NDArray[np.uint8],
    light: FloatArray,
    stripe: FloatArray,
    ground: FloatArray,
    column: int,
    upper: float,
    lower: float,
    heights: FloatArray,
    strip: FloatArray,
    spare: FloatArray,
    out: FloatArray,
) -> None:
    """Write how much of the pattern's colour stands at each height of a column, from the bottom up.

    Args:
        image: sRGB, ``(h, w, 3)``.
        light: Balanced linear light of every code, ``(3, 256)``.
        stripe: Direction from the band's own colour to the pattern's, ``(3,)``.
        ground: Direction of the band's own colour, ``(3,)``.
        column: Which.
        upper: Row (px) of the top band's inner edge.
        lower: Of the bottom band's.
        heights: As in :class:`swarmvision.perception.plan.Plan`.
        strip: Room, ``(h + 2,)``.
        spare: Room, ``(BRIGHT_ROWS,)`` or more.
        out: Shape ``(HEIGHTS,)``.
    """
    last = image.shape[0] - 1
    scale = (upper - lower) / (heights[INNER_TOP] - heights[INNER_BOTTOM])  # px up per m, negative
    start = lower + (heights[BAND_LOW] - heights[INNER_BOTTOM]) * scale - 0.5
    step = (heights[BAND_HIGH] - heights[BAND_LOW]) / HEIGHTS * scale
    ends = min(max(start + HEIGHTS * step, 0.0), float(last)), min(max(start, 0.0), float(last))
    top, bottom = int(min(ends)), min(int(max(ends)) + 1, last)
    every, count, due = (bottom - top) // BRIGHT_ROWS + 1, 0, 0
    for v in range(top, bottom + 1):
        red = light[0, image[v, column, 0]]
        green, blue = light[1, image[v, column, 1]], light[2, image[v, column, 2]]
        strip[v - top] = stripe[0] * red + stripe[1] * green + stripe[2] * blue
        if v - top == due:
            spare[count] = ground[0] * red + ground[1] * green + ground[2] * blue
            count += 1
            due += every
    # The band's own colour is what is brighter than the mean; an order of rows would cost more than all else.
    mean = above = 0.0
    for k in range(count):
        mean += spare[k]
    mean /= count
    own = 0
    for k in range(count):
        above += spare[k] if spare[k] >= mean else 0.0
        own += 1 if spare[k] >= mean else 0
    bright = own / max(above, 1e-6)
    strip[bottom + 1 - top] = strip[bottom - top]
    high, first = float(bottom - top), start + 0.5 * step - top
    for k in range(HEIGHTS):
        row = min(max(first + k * step, 0.0), high)
        v = int(row)
        value = strip[v] + (row - v) * (strip[v + 1] - strip[v])
        out[k] = min(max(value * bright, -0.3), 1.5)


@leaf
def coarse_heading(
    signals: FloatArray,
    facing: FloatArray,
    count: int,
    stripe: FloatArray,
    scores: FloatArray,
    insides: FloatArray,
    sums: FloatArray,
) -> tuple[float, float]:
    """Return the heading (rad), of a few dozen, whose pattern correlates best with the stripes.

    And how much more of its colour there is inside the pattern than outside, per sample.

    Args:
        signals: Columns unrolled, ``(count or more, HEIGHTS)``.
        facing: Azimuths (rad, lens frame) that they face.
        count: How many.
        stripe: As in :class:`swarmvision.perception.plan.Task`.
        scores: Room, ``(TRIALS,)`` or more.
        insides: Room, ``(TRIALS,)`` or more.
        sums: Room, ``(HEIGHTS + 2,)`` or more.
    """
    step = (count + VOTERS - 1) // VOTERS
    turn = 2.0 * math.pi
    total = looks = 0.0
    for trial in range(TRIALS):
        scores[trial] = insides[trial] = 0.0
    for i in range(0, count, step):
        sums[0] = 0.0
        for k in range(HEIGHTS):
            sums[k + 1] = sums[k] + signals[i, k]
        sums[HEIGHTS + 1] = sums[HEIGHTS]
        total += sums[HEIGHTS]
        looks += HEIGHTS
        share = (facing[i] + math.pi) / turn  # at a heading of -pi
        place = int((share - math.floor(share)) * AZIMUTHS) % AZIMUTHS
        for trial in range(TRIALS):
            first, last = stripe[place, 0], stripe[place, 1]
            k = int(first)
            below = sums[k] + (first - k) * (sums[k + 1] - sums[k])
            k = int(last)
            scores[trial] += sums[k] + (last - k) * (sums[k + 1] - sums[k]) - below
            insides[trial] += last - first
            place -= AZIMUTHS // TRIALS
            if place < 0:
                place += AZIMUTHS
    best, best_score = 0, -np.inf
    for trial in range(TRIALS):
        score = scores[trial] - insides[trial] / looks * total
        if score > best_score:
            best, best_score = trial, score
    held, inside = scores[best], insides[best]
    clarity = held / max(inside, 1e-9) - (total - held) / max(looks - inside, 1e-9)
    return -math.pi + turn * best / TRIALS, clarity


@leaf
def jumps(knots: FloatArray, azimuth: float) -> bool:
    """Return whether a pattern jumps near an azimuth (rad)."""
    turn = 2.0 * math.pi
    phi = azimuth - turn * math.floor(azimuth / turn)
    near = phi <= JUMP or phi >= turn - JUMP
    for i in range(len(knots)):
        near = near or abs(knots[i, 0] - phi) <= JUMP
    if not near:  # between two knots it is straight
        return False
    before_low, before_high, _, _ = pattern_edges(knots, azimuth - JUMP)
    after_low, after_high, _, _ = pattern_edges(knots, azimuth + JUMP)
    return max(abs(after_low - before_low), abs(after_high - before_high)) > JUMP_HEIGHT


@leaf
def voted_heading(
    signals: FloatArray,
    facing: FloatArray,
    count: int,
    heading: float,
    heights: FloatArray,
    knots: FloatArray,
    lines: FloatArray,
) -> tuple[float, float, float, float]:
    """Return heading (rad) from every column's vote near a coarse one, spread, and the pattern in the middle.

    That is its slope (m/rad) and its thickness (m).

    In each column the height of the stripe's middle is compared with that of the pattern; the
    pattern's slope there turns the difference into an angle (one Gauss-Newton step, repeated).
    """
    size = (heights[BAND_HIGH] - heights[BAND_LOW]) / HEIGHTS
    votes, weights, spare, loads = lines[SPARE_A], lines[SPARE_B], lines[SPARE_C], lines[SPARE_D]
    spread, kept, steepness, tall = UNSURE, 1, 0.0, 0.0
    for _ in range(ROUNDS):
        used = 0
        steepness = tall = 0.0
        for i in range(count):
            azimuth = facing[i] - heading
            low, high, low_slope, high_slope = pattern_edges(knots, azimuth)
            slope = (low_slope + high_slope) / 2.0
            if abs(slope) < 1e-4 or jumps(knots, azimuth):
                continue
            # The stripe's own middle, in a window a little wider than the stripe.
            slack = 0.35 * (high - low) + 1.5 * size
            first = max(math.floor((low - slack - heights[BAND_LOW]) / size - 0.5) + 1, 0)
            last = min(math.ceil((high + slack - heights[BAND_LOW]) / size - 0.5), HEIGHTS)
            area = moment = 0.0
            for k in range(first, last):
                value = max(signals[i, k], 0.0)
                area += value
                moment += value * (k + 0.5)
            if area * size <= 0.4 * (high - low):
                continue
            # A stripe higher than expected, where the pattern climbs, means a larger azimuth: less heading.
            middle = heights[BAND_LOW] + moment / area * size
            votes[used] = -(middle - (low + high) / 2.0) / slope
            weights[used] = abs(slope) * area * size
            steepness += abs(slope)
            tall += high - low
            used += 1
        if used < 2:
            return heading, UNSURE, 1.0, 1.0
        steepness /= used
        tall /= used
        centre = weighted_median(votes, weights, used, spare, loads)
        total = change = 0.0
        for i in range(used):
            lines[SPARE_E, i] = abs(votes[i] - centre)
        spread = 1.4826 * weighted_median(lines[SPARE_E], weights, used, spare, loads) + 1e-6
        kept = 0
        for i in range(used):
            if abs(votes[i] - centre) <= 2.5 * spread:
                total += weights[i]
                change += weights[i] * votes[i]
                kept += 1
        change = min(max(change / max(total, 1e-12), -0.6), 0.6)
        heading += change
        if abs(change) < SETTLED:
            break
    turn = 2.0 * math.pi
    heading = math.pi - (math.pi - heading) % turn  # into (-pi, pi]
    return heading, math.hypot(spread / math.sqrt(max(kept, 1)), HEADING_FLOOR), steepness, tall
