"""Kernels that paint the columns which a solid covers whole, by blocks of ``LANES``, row by row.

So all loops are of one known length and become vector instructions.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import inner
from swarmvision.geometry import FloatArray
from swarmvision.rendering.ink import (
    DARKEST,
    ONE,
    ZERO,
    code_of,
    pixel_of,
    power,
    rough_code_of,
    rough_light_of,
)
from swarmvision.rendering.sheet import (
    BASE,
    FAR,
    GAIN,
    GLOW,
    LANES,
    NEAR,
    RISE,
    SHADE,
    Image,
    Pixels,
    Places,
    Singles,
    note_span,
    share_below,
)


@inner
def dip(
    o: int,
    bands: int,
    lid: int,
    colours: FloatArray,
    pigments: Singles,
    plan: Singles,
    profile: Singles,
    lights: Singles,
    inks: Image,
    pixels: Pixels,
) -> None:
    """Fill in light and sRGB of the bands of a block."""
    for k in range(bands):
        base, gain, print_ = plan[BASE, k], plan[GAIN, k], max(k - lid, 0)
        lit = power(base) if base > ZERO else ZERO  # one of base and gain is 0
        red, green = np.float32(colours[print_, 0]), np.float32(colours[print_, 1])
        blue = np.float32(colours[print_, 2])
        red1, green1, blue1 = pigments[print_, 0], pigments[print_, 1], pigments[print_, 2]
        for i in range(LANES):
            tone = base + gain * profile[SHADE, o + i]
            glow = lit + gain * profile[GLOW, o + i]
            pixels[i] = pixel_of(
                code_of(red1, tone, glow), code_of(green1, tone, glow), code_of(blue1, tone, glow)
            )
            lights[k + 1, 0, i] = max(DARKEST, min(ONE, red * tone))
            lights[k + 1, 1, i] = max(DARKEST, min(ONE, green * tone))
            lights[k + 1, 2, i] = max(DARKEST, min(ONE, blue * tone))
        _put_pixels(inks, k, 0, pixels, LANES)


@inner
def span_edges(
    o: int,
    bands: int,
    lid: int,
    carrier: int,
    horizon: np.float32,
    window: Places,
    plan: Singles,
    profile: Singles,
    rows: Singles,
    spans: Places,
) -> None:
    """Fill in which rows the edges cross in a block."""
    least, most = _bounds(profile, NEAR, o, LANES + 1)
    for e in range(bands + 1):
        if carrier >= 0 and carrier < e <= carrier + 2:
            low, high = _bounds(rows, 2 * e, o, LANES)
            low1, high1 = _bounds(rows, 2 * e + 1, o, LANES)
            low, high = min(low, low1), max(high, high1)
        else:
            rise = plan[RISE, e]
            one, two = horizon - rise * least, horizon - rise * most
            if e == 0 and lid == 1:
                far0, far1 = _bounds(profile, FAR, o, LANES + 1)
                one, two = horizon - rise * far0, horizon - rise * far1
            low, high = min(one, two), max(one, two)
        note_span(spans, e, low, high, window)


@inner
def _bounds(table: Singles, k: int, o: int, count: int) -> tuple[np.float32, np.float32]:
    """Return least and greatest of so many numbers of a row, ``LANES`` or one more."""
    # Chains that do not wait for each other.
    low0, low1, low2, low3 = table[k, o], table[k, o + 4], table[k, o + 8], table[k, o + 12]
    high0, high1, high2, high3 = low0, low1, low2, low3
    for i in range(1, LANES // 4):
        r0, r1, r2, r3 = table[k, o + i], table[k, o + 4 + i], table[k, o + 8 + i], table[k, o + 12 + i]
        low0, low1, low2, low3 = min(low0, r0), min(low1, r1), min(low2, r2), min(low3, r3)
        high0, high1, high2, high3 = max(high0, r0), max(high1, r1), max(high2, r2), max(high3, r3)
    last = table[k, o + count - 1]
    return min(low0, low1, low2, low3, last), max(high0, high1, high2, high3, last)


@inner
def paint_block(
    image: Image,
    place: int,
    count: int,
    o: int,
    bands: int,
    profile: Singles,
    rows: Singles,
    lights: Singles,
    inks: Image,
    pixels: Pixels,
    spans: Places,
) -> None:
    """Paint so many columns of a block, from the top down."""
    y = max(spans[0, 0], 0)
    for k in range(bands + 1):
        while y < spans[k, 1]:
            last = k
            while last < bands and spans[last + 1, 0] <= y:
                last += 1
            if k == 0 or last == bands:
                _see(image, y, place, count, lights)
            under, bottom = last + 1 if last < bands else 0, np.float32(y + 1)
            if last == k:
                _mix_two(k, under, o, bottom, profile, rows, lights, pixels)
            elif last == k + 1:
                _mix_three(k, under, o, bottom, profile, rows, lights, pixels)
            else:
                _mix_many(k, last, bands, o, bottom, profile, rows, lights, pixels)
            if count == LANES:
                _put_pixels(image, y, place, pixels, LANES)
            else:
                _put_pixels(inks, bands, 0, pixels, LANES)
                _copy_rows(image, y, y + 1, place, 3 * count, inks, bands)
            y += 1
        if k < bands and y < spans[k + 1, 0]:
            _copy_rows(image, y, spans[k + 1, 0], place, 3 * count, inks, k)
            y = max(spans[k + 1, 0], 0)


@inner
def _see(image: Image, y: int, place: int, count: int, lights: Singles) -> None:
    """Fill in the light of what is under a row of a block."""
    if place + 3 * LANES <= image.shape[1]:
        for i in range(LANES):
            lights[0, 0, i] = rough_light_of(image[y, place + 3 * i])
            lights[0, 1, i] = rough_light_of(image[y, place + 3 * i + 1])
            lights[0, 2, i] = rough_light_of(image[y, place + 3 * i + 2])
    else:
        for i in range(count):
            lights[0, 0, i] = rough_light_of(image[y, place + 3 * i])
            lights[0, 1, i] = rough_light_of(image[y, place + 3 * i + 1])
            lights[0, 2, i] = rough_light_of(image[y, place + 3 * i + 2])


@inner
def _mix_two(
    above: int,
    under: int,
    o: int,
    bottom: np.float32,
    profile: Singles,
    rows: Singles,
    lights: Singles,
    pixels: Pixels,
) -> None:
    """Mix the row of a block that one edge crosses."""
    for i in range(LANES):
        share = share_below(profile, rows, above, o + i, bottom)
        red, green, blue = lights[above, 0, i], lights[above, 1, i], lights[above, 2, i]
        red += share * (lights[under, 0, i] - red)
        green += share * (lights[under, 1, i] - green)
        blue += share * (lights[under, 2, i] - blue)
        pixels[i] = pixel_of(rough_code_of(red), rough_code_of(green), rough_code_of(blue))


@inner
def _mix_three(
    above: int,
    under: int,
    o: int,
    bottom: np.float32,
    profile: Singles,
    rows: Singles,
    lights: Singles,
    pixels: Pixels,
) -> None:
    """Mix the row of a block that two edges cross."""
    for i in range(LANES):
        share = share_below(profile, rows, above, o + i, bottom)
        other = share_below(profile, rows, above + 1, o + i, bottom)
        red, green, blue = lights[above, 0, i], lights[above, 1, i], lights[above, 2, i]
        red1, green1, blue1 = lights[above + 1, 0, i], lights[above + 1, 1, i], lights[above + 1, 2, i]
        red += share * (red1 - red) + other * (lights[under, 0, i] - red1)
        green += share * (green1 - green) + other * (lights[under, 1, i] - green1)
        blue += share * (blue1 - blue) + other * (lights[under, 2, i] - blue1)
        red, green, blue = max(DARKEST, red), max(DARKEST, green), max(DARKEST, blue)
        pixels[i] = pixel_of(rough_code_of(red), rough_code_of(green), rough_code_of(blue))


@inner
def _mix_many(
    above: int,
    last: int,
    bands: int,
    o: int,
    bottom: np.float32,
    profile: Singles,
    rows: Singles,
    lights: Singles,
    pixels: Pixels,
) -> None:
    """Mix the row of a block that more edges cross."""
    for i in range(LANES):
        red, green, blue = lights[above, 0, i], lights[above, 1, i], lights[above, 2, i]
        for j in range(above, last + 1):
            share, under = share_below(profile, rows, j, o + i, bottom), j + 1 if j < bands else 0
            red += share * (lights[under, 0, i] - lights[j, 0, i])
            green += share * (lights[under, 1, i] - lights[j, 1, i])
            blue += share * (lights[under, 2, i] - lights[j, 2, i])
        red, green, blue = max(DARKEST, red), max(DARKEST, green), max(DARKEST, blue)
        pixels[i] = pixel_of(rough_code_of(red), rough_code_of(green), rough_code_of(blue))


@inner
def _copy_rows(image: Image, start: int, stop: int, place: int, size: int, inks: Image, ink: int) -> None:
    """Copy a band's bytes into rows."""
    line = max(start, 0)
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
    elif size >= 24:
        behind = max(size - 24, 0)  # what the halves share is written twice
        while line < stop:
            b0, b1, b2 = _eight(inks, ink, 0), _eight(inks, ink, 8), _eight(inks, ink, 16)
            b3, b4, b5 = (
                _eight(inks, ink, behind),
                _eight(inks, ink, behind + 8),
                _eight(inks, ink, behind + 16),
            )
            _put(image, line, place, b0)
            _put(image, line, place + 8, b1)
            _put(image, line, place + 16, b2)
            _put(image, line, place + behind, b3)
            _put(image, line, place + behind + 8, b4)
            _put(image, line, place + behind + 16, b5)
            line += 1
    elif size >= 8:
        middle, behind = max(min(8, size - 8), 0), max(size - 8, 0)
        while line < stop:
            b0, b1, b2 = _eight(inks, ink, 0), _eight(inks, ink, middle), _eight(inks, ink, behind)
            _put(image, line, place, b0)
            _put(image, line, place + middle, b1)
            _put(image, line, place + behind, b2)
            line += 1
    else:
        while line < stop:
            for i in range(size):
                image[line, place + i] = inks[ink, i]
            line += 1


@inner
def _put_pixels(image: Image, y: int, x: int, pixels: Pixels, count: int) -> None:
    """Write so many pixels; each but the last with a byte of the next, for four bytes are one store.

    The number is always ``LANES``, but where the compiler knows it at once it stores single bytes, and where
    it never does, it scatters.
    """
    for i in range(count - 1):
        pixel, at = pixels[i], x + 3 * i
        image[y, at], image[y, at + 1] = np.uint8(pixel), np.uint8(pixel >> 8)
        image[y, at + 2], image[y, at + 3] = np.uint8(pixel >> 16), np.uint8(pixel >> 24)
    pixel, at = pixels[count - 1], x + 3 * (count - 1)
    image[y, at], image[y, at + 1] = np.uint8(pixel), np.uint8(pixel >> 8)
    image[y, at + 2] = np.uint8(pixel >> 16)


@inner
def _eight(source: Image, k: int, i: int) -> tuple[np.uint8, ...]:
    """Return eight bytes; loads that end before the first store become one."""
    return (source[k, i], source[k, i + 1], source[k, i + 2], source[k, i + 3],
            source[k, i + 4], source[k, i + 5], source[k, i + 6], source[k, i + 7])  # fmt: skip


@inner
def _put(out: Image, y: int, x: int, eight: tuple[np.uint8, ...]) -> None:
    """Write eight bytes."""
    out[y, x], out[y, x + 1], out[y, x + 2], out[y, x + 3] = eight[0], eight[1], eight[2], eight[3]
    out[y, x + 4], out[y, x + 5], out[y, x + 6], out[y, x + 7] = eight[4], eight[5], eight[6], eight[7]
