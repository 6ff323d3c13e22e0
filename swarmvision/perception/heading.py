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

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray
from swarmvision.marker import pattern_edges

HEIGHTS = 48  # samples of the patterned band from its bottom to its top
TRIALS = 72  # headings of the coarse look
ROUNDS = 4  # of the vote
RIM = 0.93  # of the radius: columns farther out see the surface too slantwise
JUMP = 0.02  # rad: a pattern that jumps within so much is not voted on
HEADING_FLOOR = 0.003  # rad: error that no averaging removes,
STRIPE_FLOOR = 0.06  # px: and that of the stripe's height
UNSURE = 0.5  # rad: spread of a heading that only the coarse look tells


@compiled
def heading_of(
    image: NDArray[np.uint8],
    stripe: FloatArray,
    ground: FloatArray,
    columns: FloatArray,
    rays: FloatArray,
    upper: FloatArray,
    lower: FloatArray,
    distance: float,
    bearing: float,
    heights: FloatArray,
    knots: FloatArray,
) -> tuple[float, float, float]:
    """Return heading (rad), its spread, and how clearly the pattern is there, about 0..1.

    All are nan where fewer than two columns can show the pattern.

    Args:
        image: sRGB, ``(h, w, 3)``.
        stripe: Tables of the direction from the band's own colour to the pattern's, ``(3, 256)``.
        ground: Tables of the band's own colour.
        columns: That are measured (px), ``(n,)``.
        rays: Their bearings (rad).
        upper: Rows (px) of the top band's inner edge in them.
        lower: Of the bottom band's.
        distance: Of the axis (m).
        bearing: Of the axis (rad).
        heights: As in :class:`swarmvision.perception.edges.Plan`.
        knots: Of the pattern.
    """
    count = len(columns)
    signals, facing = np.empty((count, HEIGHTS)), np.empty(count)
    used = 0
    for i in range(count):
        across = distance * math.sin(rays[i] - bearing) / heights[5]
        if abs(across) >= RIM:
            continue
        # The normal of the near surface: back along the ray, turned by the angle of incidence.
        facing[used] = rays[i] + math.pi - math.asin(across)
        unroll(image, stripe, ground, int(columns[i]), upper[i], lower[i], heights, signals[used])
        used += 1
    if used < 2:
        return np.nan, np.nan, np.nan
    signals, facing = signals[:used], facing[:used]
    heading, clarity = coarse_heading(signals, facing, heights, knots)
    heading, spread, slope = voted_heading(signals, facing, heading, heights, knots)
    rows = np.median(lower - upper) / (heights[0] - heights[1]) * slope  # that the stripe climbs per rad
    return heading, math.hypot(spread, STRIPE_FLOOR / max(rows, 1e-6)), clarity


@compiled
def unroll(
    image: NDArray[np.uint8],
    stripe: FloatArray,
    ground: FloatArray,
    column: int,
    upper: float,
    lower: float,
    heights: FloatArray,
    out: FloatArray,
) -> None:
    """Write how much of the pattern's colour stands at each height of a column, from the bottom up."""
    rows = image.shape[0]
    levels = np.empty(HEIGHTS)
    for k in range(HEIGHTS):
        height = heights[2] + (k + 0.5) / HEIGHTS * (heights[3] - heights[2])
        row = lower + (height - heights[1]) / (heights[0] - heights[1]) * (upper - lower) - 0.5
        row = min(max(row, 0.0), rows - 1.0)
        v = min(int(row), max(rows - 2, 0))
        share = row - v
        w = min(v + 1, rows - 1)
        value = level = 0.0
        for channel in range(3):
            one, two = image[v, column, channel], image[w, column, channel]
            value += (1.0 - share) * stripe[channel, one] + share * stripe[channel, two]
            level += (1.0 - share) * ground[channel, one] + share * ground[channel, two]
        out[k], levels[k] = value, level
    bright = max(np.sort(levels)[(3 * HEIGHTS) // 4], 1e-6)
    for k in range(HEIGHTS):
        out[k] = min(max(out[k] / bright, -0.3), 1.5)


@compiled
def coarse_heading(
    signals: FloatArray, facing: FloatArray, heights: FloatArray, knots: FloatArray
) -> tuple[float, float]:
    """Return the heading (rad), of a few dozen, whose pattern correlates best with the stripes.

    And how much more of its colour there is inside the pattern than outside, per sample.
    """
    step = max(len(facing) // 16, 1)  # a coarse look needs few columns
    sums = np.zeros((len(facing), HEIGHTS + 1))
    total = 0.0
    for i in range(0, len(facing), step):
        for k in range(HEIGHTS):
            sums[i, k + 1] = sums[i, k] + signals[i, k]
        total += sums[i, HEIGHTS]
    scale = HEIGHTS / (heights[3] - heights[2])
    best, best_score, clarity = 0.0, -np.inf, 0.0
    for trial in range(TRIALS):
        heading = -math.pi + 2.0 * math.pi * trial / TRIALS
        score = inside = looks = 0.0
        for i in range(0, len(facing), step):
            low, high, _, _ = pattern_edges(knots, facing[i] - heading)
            first = min(max((low - heights[2]) * scale, 0.0), float(HEIGHTS))
            last = min(max((high - heights[2]) * scale, 0.0), float(HEIGHTS))
            score += _sum_to(sums[i], last) - _sum_to(sums[i], first)
            inside += last - first
            looks += HEIGHTS
        held = score
        score -= inside / looks * total
        if score > best_score:
            best, best_score = heading, score
            clarity = held / max(inside, 1e-9) - (total - held) / max(looks - inside, 1e-9)
    return best, clarity


@compiled
def _sum_to(sums: FloatArray, place: float) -> float:
    k = min(int(place), HEIGHTS - 1)
    reached: float = sums[k] + (place - k) * (sums[k + 1] - sums[k])
    return reached


@compiled
def voted_heading(
    signals: FloatArray, facing: FloatArray, heading: float, heights: FloatArray, knots: FloatArray
) -> tuple[float, float, float]:
    """Return heading (rad), spread and mean slope (m/rad) from every column's vote near a coarse heading.

    In each column the height of the stripe's middle is compared with that of the pattern; the
    pattern's slope there turns the difference into an angle (one Gauss-Newton step, repeated).
    """
    count = len(facing)
    size = (heights[3] - heights[2]) / HEIGHTS
    votes, weights = np.empty(count), np.empty(count)
    spread, kept, steepness = UNSURE, 1, 0.0
    for _ in range(ROUNDS):
        used = 0
        steepness = 0.0
        for i in range(count):
            azimuth = facing[i] - heading
            low, high, low_slope, high_slope = pattern_edges(knots, azimuth)
            before_low, before_high, _, _ = pattern_edges(knots, azimuth - JUMP)
            after_low, after_high, _, _ = pattern_edges(knots, azimuth + JUMP)
            slope = (low_slope + high_slope) / 2.0
            if max(abs(after_low - before_low), abs(after_high - before_high)) > 0.004 or abs(slope) < 1e-4:
                continue
            # The stripe's own middle, in a window a little wider than the stripe.
            slack = 0.35 * (high - low) + 1.5 * size
            area = moment = 0.0
            for k in range(HEIGHTS):
                height = heights[2] + (k + 0.5) * size
                if low - slack < height < high + slack and signals[i, k] > 0.0:
                    area += signals[i, k] * size
                    moment += signals[i, k] * size * height
            if area <= 0.4 * (high - low):
                continue
            # A stripe higher than expected, where the pattern climbs, means a larger azimuth: less heading.
            votes[used] = -(moment / area - (low + high) / 2.0) / slope
            weights[used] = abs(slope) * area
            steepness += abs(slope)
            used += 1
        if used < 2:
            return heading, UNSURE, 1.0
        steepness /= used
        centre = weighted_median(votes[:used], weights[:used])
        spread = 1.4826 * weighted_median(np.abs(votes[:used] - centre), weights[:used]) + 1e-6
        total = change = 0.0
        kept = 0
        for i in range(used):
            if abs(votes[i] - centre) <= 2.5 * spread:
                total += weights[i]
                change += weights[i] * votes[i]
                kept += 1
        change = min(max(change / max(total, 1e-12), -0.6), 0.6)
        heading += change
        if abs(change) < 1e-4:
            break
    turn = 2.0 * math.pi
    heading = math.pi - (math.pi - heading) % turn  # into (-pi, pi]
    return heading, math.hypot(spread / math.sqrt(max(kept, 1)), HEADING_FLOOR), steepness


@compiled
def weighted_median(values: FloatArray, weights: FloatArray) -> float:
    """Return the value at which half of the weight is passed."""
    order = np.argsort(values)
    half = weights.sum() / 2.0
    passed = 0.0
    middle: float = values[order[-1]]
    for i in order:
        passed += weights[i]
        if passed >= half:
            middle = values[i]
            break
    return middle
