"""Kernels that spoil a picture: blur, then light, then noise, row by row, so that a row stays in cache.

What makes it fast: arithmetic on 16 bits only, which processors do 32 at a time; no random number and no
table per pixel; that memory is asked for before it is needed; and that nothing is done twice. Codes are sRGB
in 1/64 (``FINE``). A row is kept *developed*: with its light, before its noise, and with the spread of that.
Where the row below it is the same, it need only be given other noise.

* **Blur** is of linear light (:mod:`swarmvision.rendering.blur`), but is done only where the picture changes
  within the kernel's reach: where all pixels under the kernel are equal, or ascend level by level, the
  blurred pixel is that pixel. The cost grows with what is in view. A rolling shutter shifts rows by whole
  16ths of a pixel.
* **Light** times a gain ``g`` is, above the toe of the sRGB curve (code 10.3), exactly
  ``(v + 14.025) g^(1/2.4) - 14.025`` in codes. In the toe the law is a line through 0; a code there is
  held between the lines of the picture's least and greatest gain. Errors: below half a level for gains
  of 0.5 to 2, below 1.5 levels for 0.1, and none above code 40. Rows share a gain until it has changed by
  a quarter of a level.
* **Noise** comes from one long stream of Gaussian numbers of 8 bits, two a word. Each row of each picture
  takes a window of it from a hashed place; its spread follows the level by a line with three bends. A pixel
  that is lit beyond white is white with a spread that is less by as much.
"""

from __future__ import annotations

import math

import numpy as np

from swarmvision.compiled import wide
from swarmvision.geometry import FloatArray
from swarmvision.rendering.blur import (
    BLURRED,
    DOWN,
    PHASES,
    WORD,
    Image,
    Longs,
    blur_along,
    blur_down,
    blur_taps,
    find_changes,
    go_on,
    list_pieces,
    plan_row,
)
from swarmvision.rendering.curve import OFFSET, PIECE, Levels, Places, Words, decode, encode
from swarmvision.rendering.sheet import as_above

SPREAD_ROWS = 32  # after which the spread is taken anew where the light changes, and not the picture alone
BRIGHTEST = 20000  # 1/64 codes: light beyond is clipped, so that it fits into 16 bits
WHITE, GREY = 16351, 8160  # 1/64 codes: half a code below 256 and half a code below 128
SHOWN_STD = 2048  # of a spread of 1 code
GAIN_ONE = 8192  # of a gain on codes, as 16-bit number
STARTS = 4096  # places where a row's window of noise may begin
STRIDE = 16  # numbers between them, so that loads are aligned
LEHMER, LEHMER_PRIME = 48271, 2147483647  # S. K. Park, K. W. Miller, CACM 31, 1988, as revised in 1993


# Loops of one kind each, for in one long function the compiler gives up on vectors; each goes over all pieces
# of a row, for a call with arrays has its cost. Starts are held at 0 or more only so that the compiler need
# not ask whether an index counts from the end.


@wide
def _widen(pieces: Places, codes: Levels, row: Words, shown: Words) -> None:
    """Take pieces of a row, two codes a word, as they are; see :func:`_light` for ``shown``."""
    half = len(codes)
    for k in range(len(pieces)):
        start = max(PIECE * pieces[k], 0)
        word, down = max(start if start < half else start - half, 0), np.uint16(0 if start < half else 8)
        for i in range(PIECE):
            code = np.uint16(np.uint16(codes[word + i] >> down) & np.uint16(255))
            row[start + i] = np.int16(np.uint16(code << np.uint16(6)))
            shown[start + i] = np.int16(np.uint16(np.uint16(code << np.uint16(8)) ^ np.uint16(0x8080)))


@wide
def _gain_of_row(factors: Words, columns: Words, gain: Levels) -> None:
    """Compose a row's gain on codes of two products of a row and a column factor, and a third number."""
    one, two, base = factors[0], factors[1], factors[2]
    for i in range(columns.shape[1]):
        part = np.int16(base + np.int16((np.int32(columns[0, i]) * np.int32(one)) >> 16))
        gain[i] = np.uint16(np.int16(part + np.int16((np.int32(columns[1, i]) * np.int32(two)) >> 16)))


@wide
def _light(
    pieces: Places, before: Words, gain: Levels, least: Levels, most: Levels, row: Words, shown: Words
) -> None:
    """Multiply light; where that matters hold it between the lines of least and greatest gain (1/4096).

    ``shown`` is the same with four times finer steps and with a sign, cut at white: black is the least that
    16 bits can hold, and 256 would be one more than the most. There is half a code in it for rounding.
    """
    for k in range(len(pieces)):
        start = max(PIECE * pieces[k], 0)
        for i in range(PIECE):
            doubled = np.uint16((np.uint16(before[start + i]) << 1) + 2 * OFFSET)
            raised = np.uint16(gain[start + i] << 2)
            product = np.uint16((np.uint32(doubled) * np.uint32(raised)) >> 16)
            value = np.int16(np.int32(product) - OFFSET)
            value = min(max(value, np.int16(0)), np.int16(BRIGHTEST))
            row[start + i] = value
            shown[start + i] = np.int16(np.int16(min(value, np.int16(WHITE)) - np.int16(GREY)) << 2)
        for i in range(start, min(start + PIECE, len(least))):
            low = min((np.int64(before[i]) * least[i]) >> 12, BRIGHTEST)
            high = (np.int64(before[i]) * most[i]) >> 12
            row[i] = np.int16(min(max(np.int64(row[i]), low), high))
            shown[i] = np.int16((np.int64(min(row[i], np.int16(WHITE))) - GREY) * 4)


@wide
def _spread(pieces: Places, row: Words, law: Words, step: int, out: Words) -> None:
    """Find the standard deviation of the noise of each level: a line with three bends, times ``step``.

    In the end a code is ``SHOWN_STD``.
    """
    base, c0, c1, c2, c3 = law[0], law[1], law[2], law[3], law[4]
    t1, t2, t3, times = law[5], law[6], law[7], np.int16(step)
    for k in range(len(pieces)):
        start = max(PIECE * pieces[k], 0)
        for i in range(PIECE):
            level = row[start + i]
            std = np.int16(base + np.int16((np.int32(level) * np.int32(c0)) >> 16))
            std = np.int16(std + np.int16((np.int32(np.int16(max(level, t1) - t1)) * np.int32(c1)) >> 16))
            std = np.int16(std + np.int16((np.int32(np.int16(max(level, t2) - t2)) * np.int32(c2)) >> 16))
            std = np.int16(std + np.int16((np.int32(np.int16(max(level, t3) - t3)) * np.int32(c3)) >> 16))
            beyond = np.int16(min(np.int16(max(level, np.int16(WHITE)) - np.int16(WHITE)), np.int16(1023)))
            less = np.int16(np.int16(std * times) - np.int16(beyond << np.int16(5)))
            out[start + i] = max(less, np.int16(0))


@wide
def _store(shown: Words, std: Words, stream: Words, begin: int, out: Levels) -> None:
    """Add noise, by sums that saturate, and store the upper halves of both planes, two codes a word.

    A word of the stream is the noise of the odd place in its lower half, and with that as its tiny end
    that of the even one.
    """
    half, begin = len(shown) // 2, max(begin, 0)
    even, odd, even_std, odd_std = shown[:half], shown[half:], std[:half], std[half:]
    least, most = np.int32(-32768), np.int32(32767)
    for i in range(len(out)):
        noise = stream[begin + i]
        error = np.int16((np.int32(noise) * np.int32(even_std[i])) >> 16)
        one = np.int16(min(max(np.int32(even[i]) + np.int32(error), least), most))
        error = np.int16((np.int32(np.int16(noise << np.int16(8))) * np.int32(odd_std[i])) >> 16)
        two = np.int16(min(max(np.int32(odd[i]) + np.int32(error), least), most))
        upper = np.uint16(np.uint16(np.uint16(two) & np.uint16(0xFF00)) ^ np.uint16(0x8080))
        out[i] = np.uint16(upper + np.uint16(np.int16(one >> np.int16(8))))


@wide
def _drop_bits(out: Image, bits: int) -> None:
    """Keep the upper bits and repeat them below, so that black stays black and white white."""
    mask, again = np.uint8(256 - (1 << (8 - bits))), np.uint16(256 >> bits)
    for i in range(len(out)):
        upper = np.uint8(out[i] & mask)
        out[i] = np.uint8(upper | np.uint8(np.uint16(np.uint16(upper) * again) >> 8))


@wide
def spoil(
    image: Image,
    psf: FloatArray,
    down: Levels,
    shear: float,
    length: float,
    rows: Words,
    columns: Words,
    least: Levels,
    most: Levels,
    law: Words,
    step: int,
    stream: Words,
    state: int,
    bits: int,
    curve: Levels,
    alike: Places,
    kept: Image,
    mask: Image,
    told: Image,
    changes: Longs,
    origin: Places,
    window: Longs,
    marks: Longs,
    light: Levels,
    level: Levels,
    total: Levels,
    words: Words,
    line: Levels,
    gain: Levels,
    box: FloatArray,
    taps: Places,
    weights: Levels,
    places: Places,
    lists: Places,
) -> None:
    """Spoil a picture in place.

    Args:
        image: sRGB, shape ``(h, 3 w)``.
        psf: Blur of the lens along a row, odd, sums to 1.
        down: The same down a column, as weights that sum to ``ONE``, see
            :func:`swarmvision.rendering.blur.blur_down`.
        shear: Shift of a row to the right over that of the row above (px); the middle row stays.
        length: Of the motion blur (px).
        rows: Two row factors of the gain, a 1 for rounding, and whether the gain is taken anew, ``(h, 4)``;
            none for a gain of 1.
        columns: Two column factors of the gain, ``(2, m)``, in planes; m is 3 w, filled up to whole blocks.
        least: Of all gains of a byte's channel (1/4096), ``(m,)``; empty where the toe needs no care.
        most: The greatest.
        law: Of the noise; empty for none; see :func:`_spread`.
        step: What the spread is multiplied with.
        stream: Gaussian numbers, two a word, ``STARTS * STRIDE + m / 2``; of no matter without a law.
        state: Of the generator that tells where each row's window begins, 1 to 2^31 - 2.
        bits: Of a stored channel.
        curve: See :func:`swarmvision.rendering.curve.encode`.
        alike: Tells which rows are as the one above; they are not looked at.
        kept: See :func:`swarmvision.rendering.blur.find_changes`.
        mask: Likewise, as the next three.
        told: Likewise.
        changes: Likewise.
        origin: Likewise.
        window: See :func:`swarmvision.rendering.blur.plan_row`.
        marks: Likewise.
        light: Scratch: ring of rows in linear light, ``(2 r + 2, m)`` for a kernel of radius r.
        level: Scratch, ``3 m + 4 PIECE``.
        total: Scratch, ``(m,)``.
        words: Scratch, ``(4, m)``; the last part zeros where there is no law.
        line: Scratch, ``(m / 2,)``.
        gain: Scratch, ``m``.
        box: Scratch, see :func:`swarmvision.rendering.blur.blur_taps`.
        taps: Likewise.
        weights: Scratch, ``(PHASES, t)`` with t ``TAPS`` more than there can be.
        places: Scratch, ``(4, max(PHASES, 2 r + 2))``.
        lists: Scratch, ``(3, m / PIECE)``; the last counts from 0.
    """
    height, n = image.shape
    radius, size, half = len(psf) // 2, light.shape[0], words.shape[1] // 2
    firsts, counts, held, pages = places[0], places[1], places[2], places[3, : len(down) // PIECE]
    plain, shown, std, pad, every = words[1], words[2], words[3], half + PIECE, lists[2]
    blurs = radius > 0 or length > 0.0 or shear != 0.0
    lights = blurs or len(rows) > 0
    row = words[0] if lights else plain
    for i in range(len(gain)):
        gain[i] = GAIN_ONE
    for i in range(len(counts)):
        counts[i] = 0
    for k in range(marks.shape[1]):
        marks[BLURRED, k] = 0
    codes = kept.view(np.uint16)
    pairs = image.view(np.uint16) if n % 2 == 0 else codes
    read, side, page, seen_shift, soft = 0, 0, 0, 0, False
    for y in range(height):
        above, below = max(y - radius, 0), min(y + radius + 1, height)
        while read < below:
            if as_above(read, alike):
                origin[read] = origin[read - 1]
            else:
                side = find_changes(image, read, side, blurs, kept, mask, told, changes, origin)
            # Rows that are the same share a page.
            if blurs and origin[read] == read:
                old, page = page, (page + 1) % size
                for i in range(light.shape[1]):
                    light[page, i] = light[old, i]
                new = list_pieces(changes[read, DOWN], lists[0])
                decode(every if read == 0 else lists[0, :new], codes[side], curve, light[page])
            held[read % size] = page
            read += 1
        news = y == 0
        for line_above in range(above, below):
            news = news or origin[line_above] == line_above
        shift = math.floor(shear * (y + 0.5 - height / 2.0) * PHASES + 0.5)
        moved, seen_shift = shift != seen_shift, shift
        bright, fresh = 0, 0
        if news and not blurs:
            fresh = len(every) if y == 0 else list_pieces(changes[y, DOWN], lists[1])
            _widen(every if y == 0 else lists[1, :fresh], codes[side], plain, shown)
        elif news or (moved and soft):
            phase = shift % PHASES
            if counts[phase] == 0:
                firsts[phase], counts[phase] = blur_taps(
                    psf, phase / PHASES, length, box, taps, weights[phase]
                )
            first, count = firsts[phase] + shift // PHASES, counts[phase]
            # A change is seen from its last tap to its first, and where it is, so that a piece which is left
            # alone may keep what it has.
            back, ahead = 3 * max(first + count - 1, 0), 3 * max(-first, 0)
            reach = (-ahead // WORD, (back + WORD - 1) // WORD)
            bright, fresh, soft = plan_row(changes, origin, above, below, reach, moved, window, marks, lists)
            if y == 0:
                bright = fresh = len(every)
            for j in range(len(pages)):
                pages[j] = held[min(max(y + j - radius, 0), height - 1) % size]
            blur_down(every if y == 0 else lists[0, :bright], light, pages, down, pad, level)
            go_on(level, pad, n, back, ahead)
            blurred = every if y == 0 else lists[1, :fresh]
            blur_along(blurred, first, weights[phase], count, level, pad, total)
            encode(blurred, total, curve, plain)
        some = every if fresh == len(every) else lists[1, :fresh]
        again = len(rows) > 0 and rows[y, 3] != 0
        if again:
            _gain_of_row(rows[y], columns, gain)
        if lights and (fresh > 0 or again):
            _light(every if again else some, plain, gain, least, most, row, shown)
        drifted = y % SPREAD_ROWS == 0 and len(rows) > 0
        if len(law) > 0 and (fresh > 0 or drifted):
            _spread(every if drifted else some, row, law, step, std)
        state = state * LEHMER % LEHMER_PRIME
        if n % 2 == 0:
            _store(shown, std, stream, STRIDE * (state % STARTS), pairs[y])
        else:
            _store(shown, std, stream, STRIDE * (state % STARTS), line)
            for i in range(n):
                image[y, i] = np.uint8(line[i >> 1] >> np.uint16(8 * (i & 1)))
        if bits < 8:
            _drop_bits(image[y], bits)
