"""The rings of a marker in one picture: whether it looks right between them, and their inner edges.

An edge is placed by area integration on linear light: where a signal steps from one plateau to another,
the edge stands where a sharp step of the same area would.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.perception.order import median_in_place, median_of
from swarmvision.perception.pairs import BOTH, TOP_ONLY
from swarmvision.perception.plan import (
    COLUMNS,
    GAPS,
    LOWERS,
    MOST_LOOKS,
    PROBES,
    SPARE_A,
    SPARE_B,
    SPARE_C,
    SPARE_D,
    UPPERS,
)
from swarmvision.perception.steps import step_at

NEARBY = 5  # px: how far off a coarse row may be
STEP_SLACK = 0.8  # px by which the separation may change between neighbouring columns of one marker,
STEP_SHARE = 0.05  # and by which share of itself
LEAST_SEPARATION = 2.0  # px between the inner edges; less tells nothing
PALE_ENOUGH = 0.55  # share of the middle zone that must look like the marker


@leaf
def signal(
    image: NDArray[np.uint8], light: FloatArray, direction: FloatArray, row: int, column: int
) -> float:
    """Return a pixel's balanced light along one direction of colour ``(3,)``."""
    value: float = (
        direction[0] * light[0, image[row, column, 0]]
        + direction[1] * light[1, image[row, column, 1]]
        + direction[2] * light[2, image[row, column, 2]]
    )
    return value


@leaf
def looks_right(
    image: NDArray[np.uint8],
    light: FloatArray,
    columns: FloatArray,
    rows: FloatArray,
    bands: int,
    expected: FloatArray,
    pale: bool,
    lines: FloatArray,
) -> bool:
    """Whether what lies between top and bottom band has the colours that the marker has there.

    Args:
        image: sRGB, ``(h, w, 3)``.
        light: Balanced linear light of every code, ``(3, 256)``.
        columns: Of the candidate (px).
        rows: Of the candidate (px), ``(n, 4)``.
        bands: Which are in the picture.
        expected: As in :class:`swarmvision.perception.plan.Plan`, like pale.
        pale: See there.
        lines: Room to work in.
    """
    height, width = image.shape[0], image.shape[1]
    totals, near, tops, bottoms = lines[SPARE_A], lines[SPARE_B], lines[SPARE_C], lines[SPARE_D]
    step = (len(columns) + MOST_LOOKS - 1) // MOST_LOOKS
    looks = seen = 0
    for i in range(0, len(columns), step):
        u = min(max(int(columns[i]), 0), width - 1)
        v = min(max(int((rows[i, 0] + rows[i, 1]) / 2.0), 0), height - 1)
        tops[looks] = light[0, image[v, u, 0]] + light[1, image[v, u, 1]] + light[2, image[v, u, 2]]
        v = min(max(int((rows[i, 2] + rows[i, 3]) / 2.0), 0), height - 1)
        bottoms[looks] = light[0, image[v, u, 0]] + light[1, image[v, u, 1]] + light[2, image[v, u, 2]]
        looks += 1
        start, end = rows[i, 1], rows[i, 2]
        for probe in range(PROBES):
            v = int(start + (0.08 + 0.84 * probe / (PROBES - 1)) * (end - start))
            if v < 0 or v >= height:
                continue
            red, green, blue = light[0, image[v, u, 0]], light[1, image[v, u, 1]], light[2, image[v, u, 2]]
            total = max(red + green + blue, 1e-6)
            third, scale = 1.0 / 3.0, 1.0 / total
            totals[seen], near[seen] = total, 0.0
            for option in range(2):
                want = expected[probe, option]
                off = (
                    (red * scale - third - want[0]) ** 2
                    + (green * scale - third - want[1]) ** 2
                    + (blue * scale - third - want[2]) ** 2
                )
                if off < want[3]:  # not where unused: nan
                    near[seen] = 1.0
                    break
            seen += 1
    if seen == 0:
        return False
    least = -np.inf
    if pale:
        # A white middle is brighter than both rings; dark grey is a body or a wall in shadow.
        top, bottom = median_in_place(tops, looks), median_in_place(bottoms, looks)
        if bands != BOTH:  # the other ring is out of the picture
            top = bottom = top if bands == TOP_ONLY else bottom
        middle = median_of(totals, seen, lines[SPARE_C])
        if middle < 1.2 * max(top, bottom):
            return False
        least = 0.35 * max(middle, 0.25 * (top + bottom) / 2.0)
    alike = 0.0
    for i in range(seen):
        if totals[i] > least:
            alike += near[i]
    return alike >= PALE_ENOUGH * seen


@leaf
def inner_edges(
    image: NDArray[np.uint8],
    light: FloatArray,
    directions: FloatArray,
    bands: int,
    count: int,
    coarse: FloatArray,
    coarse_rows: FloatArray,
    thick_top: float,
    thick_bottom: float,
    lines: FloatArray,
) -> int:
    """Find the inner edges of top and bottom band; keep the columns where both are; return how many.

    Args:
        image: sRGB, ``(h, w, 3)``.
        light: Balanced linear light of every code, ``(3, 256)``.
        directions: As in :class:`swarmvision.perception.plan.Plan`.
        bands: Which are in the picture.
        count: How many columns ``lines`` has; rewritten, with the rows of the edges beside them.
        coarse: Columns (px) where the rows are known about.
        coarse_rows: Those, ``(n, 4)``.
        thick_top: Of the top band (px).
        thick_bottom: Of the bottom band (px).
        lines: Of the scratch.
    """
    columns, upper, lower = lines[COLUMNS], lines[UPPERS], lines[LOWERS]
    for which in range(2):
        found, steps = lines[UPPERS + which], lines[SPARE_A + which]
        thick = thick_top if which == 0 else thick_bottom
        window = min(max(round(0.5 * thick), 2), 5)
        here = bands == BOTH or (bands == TOP_ONLY) == (which == 0)
        at = 0
        for i in range(count):
            while at < len(coarse) - 2 and coarse[at + 1] < columns[i]:
                at += 1
            guess = coarse_rows[0, 1 + which]
            if len(coarse) > 1:
                share = (columns[i] - coarse[at]) / max(coarse[at + 1] - coarse[at], 1e-9)
                share = min(max(share, 0.0), 1.0)
                guess = coarse_rows[at, 1 + which]
                guess += share * (coarse_rows[at + 1, 1 + which] - guess)
            if here:
                row, step = row_edge(
                    image, light, directions[which], int(columns[i]), guess, window, lines[SPARE_C]
                )
                if abs(row - guess) >= max(0.5 * thick, 2.5):
                    step = 0.0
                found[i], steps[i] = row, step
            else:
                found[i], steps[i] = guess, 1.0
    least_top = max(0.25 * median_of(lines[SPARE_A], count, lines[SPARE_C]), 1e-9)
    least_bottom = max(0.25 * median_of(lines[SPARE_B], count, lines[SPARE_C]), 1e-9)
    used = 0
    for i in range(count):
        good = lines[SPARE_A, i] > least_top and lines[SPARE_B, i] > least_bottom
        if good and lower[i] - upper[i] > LEAST_SEPARATION:
            columns[used], upper[used], lower[used] = columns[i], upper[i], lower[i]
            used += 1
    return used


@leaf
def step_in(count: int, lines: FloatArray) -> float:
    """Return the column (px) at which the separation steps: one marker beside another; 0 for none."""
    columns, gaps, spare = lines[COLUMNS], lines[GAPS], lines[SPARE_A]
    worst, where = 0.0, 0.0
    for k in range(2, count - 1):
        step, lower = step_at(gaps, 0, k, count, spare)
        step -= STEP_SLACK + STEP_SHARE * lower
        if step > worst:
            worst, where = step, (columns[k - 1] + columns[k]) / 2.0
    return where


@leaf
def row_edge(
    image: NDArray[np.uint8],
    light: FloatArray,
    direction: FloatArray,
    column: int,
    guess: float,
    window: int,
    strip: FloatArray,
) -> tuple[float, float]:
    """Return the row of a step up from above to below by area integration, and its size; 0 for none.

    ``strip`` is room for the signal of some rows, ``(4 * NEARBY,)`` or more.
    """
    flat = max(window // 2, 1)
    row, step = guess, 0.0
    # The steepest place near the guess; a coarse look is some px off.
    around = math.floor(guess + 0.5)
    steepest = 0.0
    first = around - NEARBY - 1
    known = 0  # rows from the first
    if around - NEARBY >= 1 and around + NEARBY < image.shape[0]:
        known = 2 * NEARBY + 2
        strip[0] = signal(image, light, direction, first, column)
        for k in range(1, known):
            strip[k] = signal(image, light, direction, first + k, column)
            rise = strip[k] - strip[k - 1]
            row = float(first + k) if rise > steepest else row  # no branch: it would be guessed wrong
            steepest = max(steepest, rise)
    last = -1
    for _ in range(2):  # the first round centres the window on the edge
        start = math.floor(row + 0.5) - window
        if start < 0 or start + 2 * window > image.shape[0]:
            return row, 0.0
        if start == last:
            break
        last = start
        above = below = area = 0.0
        for k in range(2 * window):
            v = start + k
            fresh = not first <= v < first + known
            value = signal(image, light, direction, v, column) if fresh else strip[v - first]
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
