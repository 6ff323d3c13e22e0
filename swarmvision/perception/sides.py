"""Where the rings of a marker end at its sides: the tangents."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.perception.order import middle_of
from swarmvision.perception.pairs import BOTH, TOP_ONLY
from swarmvision.perception.plan import TOP_RING
from swarmvision.perception.rings import signal

WINDOW = 1.2  # of a smeared end's width, to either side, that is integrated over
SHARP = 3.5  # px: as wide is the end of a ring without motion blur


@leaf
def find_sides(
    image: NDArray[np.uint8],
    light: FloatArray,
    directions: FloatArray,
    bands: int,
    columns: FloatArray,
    rows: FloatArray,
    widest: float,
) -> tuple[float, float, int, float]:
    """Return the columns (px) at which the rings end, what is cut, and how wide the ends are smeared (px).

    What is cut is 1 if the left end is not that of the rings: it is the picture's, or nothing there tells
    them from what stands beside them; 2 the right. A sharp end is 2 to 3 px wide. No ends are farther apart
    than about ``widest`` (px).
    """
    space = columns[1] - columns[0] if len(columns) > 1 else 1.0
    half = min(0.5 * space, 4.0)
    width = columns[-1] - columns[0] + 1.0
    room = max(widest - (columns[-1] - columns[0] + 2.0 * half), 0.0)
    left, left_weight, left_climb = one_side(
        image, light, directions, bands, columns[0] - half, rows, -1, width, room
    )
    right, right_weight, right_climb = one_side(
        image, light, directions, bands, columns[-1] + half, rows, 1, width, room
    )
    cut = 0
    if left < 1.5 or left_weight <= 0.0:
        cut += 1
    if right > image.shape[1] - 1.5 or right_weight <= 0.0:
        cut += 2
    smeared = 0.0
    if min(left_climb, right_climb) > 0.0:
        smeared = 2.0 / (left_climb + right_climb)
    elif max(left_climb, right_climb) > 0.0:
        smeared = 1.0 / max(left_climb, right_climb)
    return left, right, cut, smeared


@leaf
def one_side(
    image: NDArray[np.uint8],
    light: FloatArray,
    directions: FloatArray,
    bands: int,
    guess: float,
    rows: FloatArray,
    outward: int,
    width: float,
    room: float,
) -> tuple[float, float, float]:
    """Return the column (px) at which the rings end on one side: -1 the left, 1 the right.

    And the weight of that, 0 for none, and the steepest climb to it, as a share of the step per px. Where the
    rings go on at the guess their end is looked for farther out, by up to ``room`` (px).
    """
    least = min(max(width, 3.0), 5.0)
    wide = int(min(max(0.4 * width, least), 16.0))  # first for how smeared it is, then where
    smeared = ring_ends(image, light, directions, bands, guess, rows, outward, wide, width)[3]
    blurred = smeared > 0.0 and 1.0 / smeared > SHARP
    reach = int(min(max(0.16 * width, least), 14.0))
    if blurred:
        reach = int(max(float(reach), min(WINDOW / smeared + 2.0, 0.45 * width)))
    at, moved = guess, 0.0
    while True:
        mean, place, total, climb = ring_ends(
            image, light, directions, bands, at, rows, outward, reach, width
        )
        if total > 0.0 or moved >= room:
            break
        moved = min(moved + reach, room)
        at = guess + outward * moved
    if total > 0.0 and (blurred or moved > 0.0):  # centred once more
        _, place, total, climb = ring_ends(image, light, directions, bands, mean, rows, outward, reach, width)
    if total <= 0.0:
        return guess, 0.0, 0.0
    if moved > 0.0 and abs(place - guess) > room + 1.0:
        return guess, 0.0, 0.0  # that of another marker's rings
    return place, total, climb if moved > 0.0 else smeared


@leaf
def ring_ends(
    image: NDArray[np.uint8],
    light: FloatArray,
    directions: FloatArray,
    bands: int,
    guess: float,
    rows: FloatArray,
    outward: int,
    reach: int,
    width: float,
) -> tuple[float, float, float, float]:
    """Return where both rings end on the mean (px), and where the marker does, their weight and lesser climb.

    Of two that do not agree the upper one is the marker's: bodies stand beside the lower, nothing beside it.
    """
    upper = lower = guess
    upper_weight = lower_weight = climb = 0.0
    if bands in (BOTH, TOP_ONLY):
        top, bottom = end_rows(rows, outward, 0)
        upper, upper_weight, climb = ring_end(
            image, light, directions[TOP_RING], top, bottom, guess, outward, reach
        )
    if bands != TOP_ONLY:
        top, bottom = end_rows(rows, outward, 1)
        lower, lower_weight, steep = ring_end(
            image, light, directions[TOP_RING + 1], top, bottom, guess, outward, reach
        )
        climb = min(climb, steep) if climb > 0.0 and steep > 0.0 else max(climb, steep)
    total = upper_weight + lower_weight
    mean = (upper * upper_weight + lower * lower_weight) / total if total > 0.0 else guess
    agree = min(upper_weight, lower_weight) <= 0.0 or abs(upper - lower) <= 0.6 + 0.01 * width
    return mean, mean if agree else upper, total, climb


@leaf
def end_rows(rows: FloatArray, outward: int, ring: int) -> tuple[float, float]:
    """Return the rows of a ring at one end of a candidate: medians of its outermost three columns."""
    last = len(rows) - 1
    if last < 1:
        return float(rows[0, 2 * ring]), float(rows[0, 2 * ring + 1])
    one, two = (0, 1) if outward < 0 else (last, last - 1)
    if last == 1:
        return (
            0.5 * (rows[one, 2 * ring] + rows[two, 2 * ring]),
            0.5 * (rows[one, 2 * ring + 1] + rows[two, 2 * ring + 1]),
        )
    three = 2 if outward < 0 else last - 2
    return (
        middle_of(rows[one, 2 * ring], rows[two, 2 * ring], rows[three, 2 * ring]),
        middle_of(rows[one, 2 * ring + 1], rows[two, 2 * ring + 1], rows[three, 2 * ring + 1]),
    )


@leaf
def ring_end(
    image: NDArray[np.uint8],
    light: FloatArray,
    direction: FloatArray,
    top: float,
    bottom: float,
    guess: float,
    outward: int,
    reach: int,
) -> tuple[float, float, float]:
    """Return the column (px) at which a ring ends on one side, the weight of that, 0 for none, and the climb.

    The climb is the steepest, over 2 px, as a share of the whole step per px.
    """
    inset = 0.3 * (bottom - top)
    first = math.ceil(top + inset)
    last = max(int(bottom - inset), first + 1)
    if first < 0 or last > image.shape[0]:
        return guess, 0.0, 0.0
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
        return guess, 0.0, 0.0
    inner = max(reach // 2, 1)
    inside = outside = area = steepest = 0.0
    before = previous = -np.inf
    outer = max(min(size - 3 * reach // 2, inner), 1)
    for k in range(size):
        value = 0.0
        for row in range(first, last):
            value += signal(image, light, direction, row, start + outward * k)
        value /= last - first
        area += value
        steepest = max(steepest, before - value)
        before, previous = previous, value
        if k < inner:
            inside += value / inner
        if k >= size - outer:
            outside += value / outer
    if inside - outside < max(0.3 * inside, 1e-6):
        return guess, 0.0, 0.0
    reached = (area - size * outside) / (inside - outside)
    if not 0.0 < reached < size:
        return guess, 0.0, 0.0
    place = start + reached if outward > 0 else start + 1 - reached
    return place, (last - first) * (inside - outside), 0.5 * steepest / (inside - outside)
