"""Kernels that paint a *sheet*: one object as a stack of coloured bands over some columns of the picture.

A sheet is ``rows`` ``(bands + 1, columns + 1)``, where the edges of its bands cross the borders of its
columns (px, from the top down), and ``shades`` ``(bands, columns)``, what a band's own light is
multiplied with. Between two borders an edge is a straight line, and a pixel that edges cross is the mean
of the light under them, weighed by exact areas. All others are copies, by blocks of columns.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.colour import decode, encode
from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray

Image = NDArray[np.uint8]
Places = NDArray[np.int64]
SCALE = 16383  # of light, and of the table from light to sRGB: 0.2 grey levels where it is steepest
FAR_BELOW = 1e9  # px
BLOCK = 16  # columns that are copied together
DECODE = decode(np.arange(256)) * SCALE
ENCODE = np.rint(encode(np.arange(SCALE + 1) / SCALE)).astype(np.uint8)


@compiled
def _integral(x: float) -> float:
    """Return the integral up to x of ``min(max(t, 0), 1)``."""
    if x <= 0.0:
        return 0.0
    if x < 1.0:
        return 0.5 * x * x
    return x - 0.5


@compiled
def share_below(one: float, two: float, row: int) -> float:
    """Return the share of a pixel that lies below a straight edge from ``one`` to ``two`` (px)."""
    low, high = min(one, two), max(one, two)
    if low >= row and high <= row + 1:
        return row + 1.0 - 0.5 * (one + two)
    if high - low < 1e-9:
        return min(max(row + 1.0 - low, 0.0), 1.0)
    return (_integral(row + 1.0 - low) - _integral(row + 1.0 - high)) / (high - low)


@compiled
def copy_row(source: Image, out: Image) -> None:
    """Copy bytes."""
    for i in range(len(out)):
        out[i] = source[i]


@compiled
def _three(i: int) -> tuple[np.uint64, np.uint64, np.uint64]:
    """Return three places in a row, unsigned."""
    return np.uint64(i), np.uint64(i + 1), np.uint64(i + 2)


# One function without calls that take arrays: each such call would count references, which costs more than
# a column. Hence also a single way out of each loop.


@compiled
def paint_sheet(
    image: Image,
    window: Places,
    first: int,
    begin: int,
    end: int,
    lag: int,
    left: float,
    right: float,
    bands: int,
    lid: int,
    colours: FloatArray,
    rows: FloatArray,
    shades: FloatArray,
    lights: FloatArray,
    codes: Image,
    done: Places,
    skip: Image,
    decode: FloatArray,
    encode: Image,
) -> None:
    """Paint columns of a sheet.

    Args:
        image: sRGB, ``(h, 3 w)``.
        window: First row that may be painted, and the row behind the last.
        first: Column of the picture where the sheet begins.
        begin: First column of the sheet to paint. Lights and codes are taken from the whole sheet, which
            has to be painted first, from column 0.
        end: The one behind the last.
        lag: Which column's left border is the first in ``rows``.
        left: Where the object begins (px); before it nothing is covered.
        right: And where it ends.
        bands: How many.
        lid: 1 where the first two bands are of the first colour, else 0.
        colours: Linear light of the bands, ``(bands - lid, 3)``.
        rows: See above.
        shades: See above.
        lights: Scratch, shaded light of each band in 1/``SCALE``.
        codes: Scratch, the same in sRGB.
        done: Scratch, for each band the rows that a block has copied, ``(bands, 2)``.
        skip: Columns of the sheet that are left alone but for what a block copies.
        decode: sRGB to light, in 1/``SCALE``.
        encode: And back.
    """
    upper, lower = window[0], window[1]
    for k in range(bands if begin == 0 else 0):
        mine, print_, i = np.uint64(k), np.uint64(max(k - lid, 0)), 0
        while i < end:
            shade = shades[mine, np.uint64(i)]
            value0 = SCALE * min(colours[print_, 0] * shade, 1.0)
            value1 = SCALE * min(colours[print_, 1] * shade, 1.0)
            value2 = SCALE * min(colours[print_, 2] * shade, 1.0)
            code0, code1 = encode[np.uint64(int(value0 + 0.5))], encode[np.uint64(int(value1 + 0.5))]
            code2 = encode[np.uint64(int(value2 + 0.5))]
            same = True
            while same:
                c0, c1, c2 = _three(3 * i)
                lights[mine, c0], lights[mine, c1], lights[mine, c2] = value0, value1, value2
                codes[mine, c0], codes[mine, c1], codes[mine, c2] = code0, code1, code2
                i += 1
                same = i < end and shades[mine, np.uint64(i)] == shade
    start = begin
    while start < end:
        cover = min(right, first + start + 1.0) - max(left, float(first + start))
        stop = min(start + BLOCK, end)
        if cover < 1.0:
            stop = start + 1
        elif right < first + stop:
            stop -= 1
        rest = 1.0 - cover
        for k in range(bands):
            top, bottom = rows[k, start - lag], rows[k + 1, start - lag]
            for i in range(start + 1 - lag, stop + 1 - lag):
                top, bottom = max(top, rows[k, i]), min(bottom, rows[k + 1, i])
            one = min(max(math.ceil(top), upper), lower)
            two = min(math.floor(bottom), lower)
            if cover < 1.0 or two <= one:
                one = two = lower
            done[k, 0], done[k, 1] = one, two
            # No index counts from the end, which the compiler has to see, or it copies byte by byte.
            x, c, own, size = max(3 * (first + start), 0), max(3 * start, 0), max(k, 0), 3 * (stop - start)
            for y in range(max(one, 0), two):
                for b in range(size):
                    image[y, x + b] = codes[own, c + b]
        for column in range(start, stop):
            # Unsigned, for else the compiler asks of each index whether it counts from the end.
            x0, x1, x2 = _three(3 * (first + column))
            c0, c1, c2 = _three(3 * column)
            here, next_ = np.uint64(column - lag), np.uint64(column - lag + 1)
            # Loops over rows end by what memory says, so that the compiler does not make scatters of them,
            # which are too dear for so few rows.
            k = 0 if skip[column] == 0 else bands + 1
            y = upper
            while k <= bands:  # edge k is the next below, so this is band k - 1
                edge, band, line = np.uint64(k), np.uint64(max(k - 1, 0)), np.uint64(y)
                high, low = rows[edge, here], rows[edge, next_]
                if high > low:
                    high, low = low, high
                whole = min(max(math.floor(high), y), lower)
                if k == 0:
                    y = whole
                elif cover >= 1.0:
                    while y < done[band, 0] and y < whole:
                        line = np.uint64(y)
                        image[line, x0], image[line, x1] = codes[band, c0], codes[band, c1]
                        image[line, x2] = codes[band, c2]
                        y += 1
                    if y < whole:
                        y = max(y, done[band, 1])
                    while y < whole and y < window[1]:
                        line = np.uint64(y)
                        image[line, x0], image[line, x1] = codes[band, c0], codes[band, c1]
                        image[line, x2] = codes[band, c2]
                        y += 1
                else:
                    while y < whole and y < window[1]:
                        line = np.uint64(y)
                        value0 = cover * lights[band, c0] + rest * decode[image[line, x0]]
                        value1 = cover * lights[band, c1] + rest * decode[image[line, x1]]
                        value2 = cover * lights[band, c2] + rest * decode[image[line, x2]]
                        image[line, x0] = encode[np.uint64(int(value0 + 0.5))]
                        image[line, x1] = encode[np.uint64(int(value1 + 0.5))]
                        image[line, x2] = encode[np.uint64(int(value2 + 0.5))]
                        y += 1
                after = FAR_BELOW
                if k < bands:
                    after = min(rows[edge + np.uint64(1), here], rows[edge + np.uint64(1), next_])
                while low > y and y < lower:
                    line = np.uint64(y)
                    under0, under1 = decode[image[line, x0]], decode[image[line, x1]]
                    under2 = decode[image[line, x2]]
                    from0, from1, from2 = under0, under1, under2
                    if k > 0:
                        from0, from1, from2 = lights[band, c0], lights[band, c1], lights[band, c2]
                    value0, value1, value2 = from0, from1, from2
                    j, one, two = k, rows[edge, here], rows[edge, next_]
                    while j <= bands:
                        share = share_below(one, two, y)
                        to0, to1, to2 = under0, under1, under2
                        if j < bands:
                            other = np.uint64(j)
                            to0, to1, to2 = lights[other, c0], lights[other, c1], lights[other, c2]
                        value0 += share * (to0 - from0)
                        value1 += share * (to1 - from1)
                        value2 += share * (to2 - from2)
                        from0, from1, from2 = to0, to1, to2
                        j = j + 1 if after < y + 1.0 else bands + 1
                        if j <= bands:
                            other = np.uint64(j)
                            one, two = rows[other, here], rows[other, next_]
                            if min(one, two) >= y + 1:
                                j = bands + 1
                    if cover < 1.0:
                        value0 = cover * value0 + rest * under0
                        value1 = cover * value1 + rest * under1
                        value2 = cover * value2 + rest * under2
                    image[line, x0] = encode[np.uint64(int(max(value0, 0.0) + 0.5))]
                    image[line, x1] = encode[np.uint64(int(max(value1, 0.0) + 0.5))]
                    image[line, x2] = encode[np.uint64(int(max(value2, 0.0) + 0.5))]
                    y += 1
                k += 1
        start = stop
