"""The kernel that paints a *sheet*: one object as a stack of coloured bands over some columns of the picture.

A sheet is what an upright solid is seen as: edges of constant height, whose rows are straight lines of
what one over the depth is, and between two borders of a column that is a straight line too. An edge is
sampled twice in a column, at the middles of its two parts; where a pattern jumps inside a column the
parts are what is before and behind the jump, else they are halves. A pixel that edges cross is the
mean of the light under them, weighed by how much of it lies below the samples. All others are copies.

Columns that the solid covers whole are painted by blocks of ``LANES``, row by row, so that all loops are
of one known length and become vector instructions; the two at its silhouette one by one.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.colour import decode, encode
from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray

Image = NDArray[np.uint8]
Places = NDArray[np.int64]
Singles = NDArray[np.float32]
LANES = 16  # columns of a block
HALF_BLOCK = LANES // 2
STEP = 8  # numbers of a row that are computed together; rows have room for a multiple
NEAR, FAR, SHADE, SPLIT = range(4)  # rows of a profile, see paint_sheet
PROFILE = 4  # numbers
RISE, BASE, GAIN = 0, 1, 2  # rows of a plan
PLAN = 3  # numbers
SCALE = 16383  # of the table from light to sRGB: 0.2 grey levels where it is steepest
DECODE = decode(np.arange(256)).astype(np.float32)
ENCODE = np.rint(encode(np.arange(SCALE + 1) / SCALE)).astype(np.uint8)

ZERO, HALF, ONE, STEPS = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(SCALE)
# The curve of sRGB and its inverse, for vectors; light is in [0, 1], codes in [0, 255]. Below the knee both
# are lines; above it polynomials of ours, of the root of light and of the code over 255, with the least
# largest error (Chebyshev): 0.083 and 0.012 grey levels. A longer one would not become part of a loop.
KNEE, CODE_KNEE = np.float32(0.0031308), np.float32(255.0 * 0.04045)
LINEAR, UNLINEAR, UNIT = np.float32(255.0 * 12.92), np.float32(1.0 / (255.0 * 12.92)), np.float32(1.0 / 255.0)
E0, E1, E2 = np.float32(-10.227923737559411), np.float32(387.0770623332563), np.float32(-357.69602619590165)
E3, E4, E5 = np.float32(518.0483267020778), np.float32(-414.0303478192507), np.float32(131.9114786252348)
D0, D1, D2, D3, D4, D5 = (
    np.float32(value)
    for value in (0.0009168830840672155, 0.03274626301850789, 0.5193806467841586,
                  0.6671643604163923, -0.30738203328810854, 0.08728423528860166)
)  # fmt: skip


@leaf
def room(columns: int) -> int:
    """Return how many numbers a row of a profile has for so many columns."""
    return (columns + 1 + LANES + STEP - 1) // STEP * STEP


@leaf
def code_of(light: np.float32) -> np.uint8:
    """Return sRGB, rounded, of light in [0, 1]."""
    root = np.sqrt(light)
    # Not Horner's scheme, whose steps wait for each other.
    curve = (E0 + E1 * root) + light * ((E2 + E3 * root) + light * (E4 + E5 * root))
    line = LINEAR * light
    return np.uint8(np.int32((curve if light > KNEE else line) + HALF))


@leaf
def light_of(code: np.uint8) -> np.float32:
    """Return light in [0, 1] of sRGB."""
    value = np.float32(code)
    x = value * UNIT
    square = x * x
    curve = (D0 + D1 * x) + square * ((D2 + D3 * x) + square * (D4 + D5 * x))
    line = UNLINEAR * value
    return curve if value > CODE_KNEE else line


@leaf
def below(row: np.float32, end: np.float32) -> np.float32:
    """Return the share of a pixel that ends at a row (px) which lies below another row."""
    return min(max(end - row, ZERO), ONE)


@leaf
def _eight(source: Image, k: int, i: int) -> tuple[np.uint8, ...]:
    """Return eight bytes; loads that end before the first store become one."""
    return (source[k, i], source[k, i + 1], source[k, i + 2], source[k, i + 3],
            source[k, i + 4], source[k, i + 5], source[k, i + 6], source[k, i + 7])  # fmt: skip


@leaf
def _put(out: Image, y: int, x: int, eight: tuple[np.uint8, ...]) -> None:
    """Write eight bytes."""
    out[y, x], out[y, x + 1], out[y, x + 2], out[y, x + 3] = eight[0], eight[1], eight[2], eight[3]
    out[y, x + 4], out[y, x + 5], out[y, x + 6], out[y, x + 7] = eight[4], eight[5], eight[6], eight[7]


@leaf
def paint_sheet(
    image: Image,
    window: Places,
    first: int,
    left: float,
    right: float,
    bands: int,
    lid: int,
    carrier: int,
    flat: bool,
    middle: float,
    colours: FloatArray,
    plan: Singles,
    profile: Singles,
    rows: Singles,
    lights: Singles,
    inks: Image,
    spans: Places,
    decode: Singles,
    encode: Image,
) -> None:
    """Paint a sheet.

    Args:
        image: sRGB, ``(h, 3 w)``.
        window: First row that may be painted, and the row behind the last.
        first: Column of the picture where the sheet begins.
        left: Where the object begins (px), in that column; before it nothing is covered.
        right: And where it ends.
        bands: How many.
        lid: 1 where the first edge is of the far side, and its band of the first colour as the next, else 0.
        carrier: The first of the three bands that carry the pattern; -1 for none.
        flat: Whether columns with the same shade at both ends of a block have it in between.
        middle: The horizon (px).
        colours: Linear light of the bands, ``(bands - lid, 3)``.
        plan: For each edge its height above the lens (m); for each band what its shade is, ``base + gain *
            profile[SHADE]``.
        profile: At each border of the columns f / depth of the near side and of the far one; of each column
            the shade and the share of its first part; each a row, and the last number ``LANES`` times more.
        rows: Of each edge the row in the first part of each column, and in the second; those of the pattern
            are known, the others are filled in.
        lights: Scratch, light of what is under a block, of its bands, and two more.
        inks: Scratch, their sRGB, and three rows more.
        spans: Scratch, for each edge the rows that it crosses.
        decode: sRGB to light.
        encode: And back, from 1/``SCALE``.
    """
    upper, lower = window[0], window[1]
    horizon = np.float32(middle)
    columns = math.ceil(right) - first
    begin = 1 if left > first else 0
    end = columns - 1 if right < first + columns else columns
    for e in range(bands + 1):
        if carrier < 0 or e <= carrier or e > carrier + 2:
            source, rise = FAR if e == 0 and lid == 1 else NEAR, plan[RISE, e]
            for i in range(room(columns) - 1):
                here = profile[source, i]
                step = (profile[source, i + 1] - here) * HALF
                part = here + step * profile[SPLIT, i]
                rows[2 * e, i] = horizon - rise * part
                rows[2 * e + 1, i] = horizon - rise * (part + step)
    # The two columns at the silhouette, which may be one.
    for side in range(2):
        column = 0 if side == 0 else columns - 1
        if (side == 0 and begin == 1) or (side == 1 and end < columns and (begin == 0 or columns > 1)):
            cover = np.float32(min(right, first + column + 1.0) - max(left, float(first + column)))
            share = profile[SPLIT, column]
            for k in range(bands + 1):
                one, two = rows[2 * k, column], rows[2 * k + 1, column]
                high, low = max(one, two), min(one, two)
                spans[k, 0] = int(min(max(low, np.float32(upper)), np.float32(lower)))
                high = min(max(high, np.float32(upper)), np.float32(lower))
                spans[k, 1] = int(high) + (1 if high > np.float32(int(high)) else 0)
                if k < bands:
                    tone = plan[BASE, k] + plan[GAIN, k] * profile[SHADE, column]
                    for c in range(3):
                        lights[k + 1, c] = min(np.float32(colours[max(k - lid, 0), c]) * tone, ONE)
            x, k, y = max(3 * (first + column), 0), 0, spans[0, 0]
            rest = ONE - cover
            while k <= bands:
                if k > 0 and y < spans[k, 0]:
                    own0, own1, own2 = cover * lights[k, 0], cover * lights[k, 1], cover * lights[k, 2]
                    while y < spans[k, 0]:
                        value0 = own0 + rest * decode[image[y, x]]
                        value1 = own1 + rest * decode[image[y, x + 1]]
                        value2 = own2 + rest * decode[image[y, x + 2]]
                        image[y, x] = encode[int(value0 * STEPS + HALF)]
                        image[y, x + 1] = encode[int(value1 * STEPS + HALF)]
                        image[y, x + 2] = encode[int(value2 * STEPS + HALF)]
                        y += 1
                while y < spans[k, 1]:
                    for c in range(3):
                        lights[0, c] = decode[image[y, x + c]]
                        value = lights[k, c]
                        j, going = k, True
                        while going:
                            part = share * below(rows[2 * j, column], np.float32(y + 1))
                            part += (ONE - share) * below(rows[2 * j + 1, column], np.float32(y + 1))
                            value += part * (lights[0 if j == bands else j + 1, c] - lights[j, c])
                            j += 1
                            going = j <= bands and spans[j, 0] <= y
                        value = min(max(cover * value + rest * lights[0, c], ZERO), ONE)
                        image[y, x + c] = encode[int(value * STEPS + HALF)]
                    y += 1
                k += 1
    alike, before = False, ZERO
    for block in range(begin, end, LANES):
        size, o = 3 * min(end - block, LANES), max(block, 0)
        place = max(3 * (first + block), 0)
        # A block of one shade looks as the one before it, if that is of the same.
        shade = profile[SHADE, o]
        even = flat and shade == profile[SHADE, o + LANES - 1]
        fresh = not (even and alike and shade == before)
        alike, before = even, shade
        for e in range(bands + 1):
            # Chains that do not wait for each other.
            low0, low1, low2, low3 = (
                rows[2 * e, o],
                rows[2 * e, o + 8],
                rows[2 * e + 1, o],
                rows[2 * e + 1, o + 8],
            )
            high0, high1, high2, high3 = low0, low1, low2, low3
            for i in range(1, HALF_BLOCK):
                r0, r1 = rows[2 * e, o + i], rows[2 * e, o + 8 + i]
                r2, r3 = rows[2 * e + 1, o + i], rows[2 * e + 1, o + 8 + i]
                low0, low1, low2, low3 = min(low0, r0), min(low1, r1), min(low2, r2), min(low3, r3)
                high0, high1, high2, high3 = max(high0, r0), max(high1, r1), max(high2, r2), max(high3, r3)
            low, high = min(low0, low1, low2, low3), max(high0, high1, high2, high3)
            spans[e, 0] = int(min(max(low, np.float32(upper)), np.float32(lower)))
            high = min(max(high, np.float32(upper)), np.float32(lower))
            spans[e, 1] = int(high) + (1 if high > np.float32(int(high)) else 0)
            if e < bands and fresh:
                base, gain, print_ = plan[BASE, e], plan[GAIN, e], max(e - lid, 0)
                red, green = np.float32(colours[print_, 0]), np.float32(colours[print_, 1])
                blue = np.float32(colours[print_, 2])
                for i in range(LANES):
                    tone = base + gain * profile[SHADE, o + i]
                    light0, light1, light2 = (
                        min(red * tone, ONE),
                        min(green * tone, ONE),
                        min(blue * tone, ONE),
                    )
                    lights[e + 1, i], lights[e + 1, LANES + i] = light0, light1
                    lights[e + 1, 2 * LANES + i] = light2
                    inks[e, 3 * i] = encode[np.uint64(int(light0 * STEPS + HALF))]
                    inks[e, 3 * i + 1] = encode[np.uint64(int(light1 * STEPS + HALF))]
                    inks[e, 3 * i + 2] = encode[np.uint64(int(light2 * STEPS + HALF))]
        # A row waits for the next one before it is copied, for what has just been written is slow to read.
        waiting, wet = -1, bands
        k, y = 0, spans[0, 0]
        while k <= bands + 1:
            # From here on, so many rows are copied at the end.
            source, start, stop = 0, 0, 0
            if k > bands:
                source, start, stop = wet, max(waiting, 0), waiting + 1
                k += 1
            elif k > 0 and y < spans[k, 0]:
                source, start, stop = k - 1, y, spans[k, 0]
                y = stop
            elif y >= spans[k, 1]:
                k += 1
            else:
                source, start, stop = wet, max(waiting, 0), waiting + 1
                j, last, from_ = max(k, 0), max(k, 0), max(k, 0)
                while last < bands and spans[last + 1, 0] <= y:
                    last += 1
                line, bottom = max(y, 0), np.float32(y + 1)
                if (k == 0 or last == bands) and size == 3 * LANES:
                    for i in range(LANES):
                        lights[0, i] = light_of(image[line, place + 3 * i])
                        lights[0, LANES + i] = light_of(image[line, place + 3 * i + 1])
                        lights[0, 2 * LANES + i] = light_of(image[line, place + 3 * i + 2])
                elif k == 0 or last == bands:
                    for i in range(size // 3):
                        for c in range(3):
                            lights[0, c * LANES + i] = decode[image[line, place + 3 * i + c]]
                while j <= last:
                    beneath, out = 0 if j == bands else j + 1, bands + 1 + (j & 1)
                    for i in range(LANES):
                        share = profile[SPLIT, o + i]
                        part = share * below(rows[2 * j, o + i], bottom)
                        part += (ONE - share) * below(rows[2 * j + 1, o + i], bottom)
                        lights[out, i] = lights[from_, i] + part * (lights[beneath, i] - lights[j, i])
                        lights[out, LANES + i] = lights[from_, LANES + i] + part * (
                            lights[beneath, LANES + i] - lights[j, LANES + i]
                        )
                        lights[out, 2 * LANES + i] = lights[from_, 2 * LANES + i] + part * (
                            lights[beneath, 2 * LANES + i] - lights[j, 2 * LANES + i]
                        )
                    from_ = out
                    j += 1
                waiting, wet = y, bands if wet > bands else bands + 1
                for i in range(LANES):
                    inks[wet, 3 * i] = code_of(max(lights[from_, i], ZERO))
                    inks[wet, 3 * i + 1] = code_of(max(lights[from_, LANES + i], ZERO))
                    inks[wet, 3 * i + 2] = code_of(max(lights[from_, 2 * LANES + i], ZERO))
                y += 1
            ink, line = max(source, 0), max(start, 0)
            if size == 3 * LANES:
                while line < stop:
                    b0, b1, b2 = _eight(inks, ink, 0), _eight(inks, ink, 8), _eight(inks, ink, 16)
                    b3, b4, b5 = _eight(inks, ink, 24), _eight(inks, ink, 32), _eight(inks, ink, 40)
                    _put(image, line, place, b0)
                    _put(image, line, place + 8, b1)
                    _put(image, line, place + 16, b2)
                    _put(image, line, place + 24, b3)
                    _put(image, line, place + 32, b4)
                    _put(image, line, place + 40, b5)
                    line += 1
            elif size >= 8:
                while line < stop:
                    i = 0
                    while i < size:
                        at = max(min(i, size - 8), 0)
                        _put(image, line, place + at, _eight(inks, ink, at))
                        i += 8
                    line += 1
            else:
                while line < stop:
                    for i in range(size):
                        image[line, place + i] = inks[ink, i]
                    line += 1
