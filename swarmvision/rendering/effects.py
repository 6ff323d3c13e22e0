"""Kernels that spoil a picture: blur, then light, then noise, row by row, so that a row stays in cache.

What makes it fast: arithmetic on 16 bits only, which processors do 32 at a time; no random number and,
over most of the picture, no table per pixel; and that little is done twice. Codes are sRGB in 1/64
(``FINE``). A row is kept *developed*: with its light, before its noise, and with the spread of that. Where
the row below it is the same, it need only be given other noise.

* **Blur** is of linear light, through tables, to 0.2 levels, but is done only where the picture changes
  within the kernel's reach: where all pixels under the kernel are equal, or ascend level by level, the
  blurred pixel is that pixel. The cost grows with what is in view. A rolling shutter shifts rows by whole
  32nds of a pixel.
* **Light** times a gain ``g`` is, above the toe of the sRGB curve (code 10.3), exactly
  ``(v + 14.025) g^(1/2.4) - 14.025`` in codes. In the toe the law is a line through 0; a code there is
  held between the lines of the picture's least and greatest gain. Errors: below half a level for gains
  of 0.5 to 2, below 1.5 levels for 0.1, and none above code 40.
* **Noise** comes from one long stream of Gaussian numbers. Each row of each picture takes a window of it
  from a hashed place; its spread follows the level by a line with three bends.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.colour import decode
from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray

Image = NDArray[np.uint8]
Words = NDArray[np.int16]
Levels = NDArray[np.uint16]
Places = NDArray[np.int64]
Sums = NDArray[np.int32]

FINE = 64  # steps of one code
ONE = 1 << 16  # the sum of a kernel's weights; but one alone is 1 less
BLOCK = 16  # bytes that are looked at and worked on together
GAP = 4  # blocks without a change that cost less than a new start
BLURRED, FRESH = np.uint8(1), np.uint8(2)  # what is known of a block
WORD = 8  # blocks; rows in scratch are filled up to whole words of blocks
PHASES = 32  # places within a pixel that a row's shift is rounded to
GAIN_ROWS = 4  # that share one gain: 0.04 levels from row to row in a corner of the Pi camera
SPREAD_ROWS = 32  # after which the spread is taken anew, whether the picture changes or not
MARGIN = 32  # numbers at each end of a row that only weights of 0 reach
TAPS = 4  # that are added at once
OFFSET = 898  # FINE * 255 * 0.055: where the sRGB curve's power law has its zero
BRIGHTEST = 20000  # 1/64 codes: light beyond is clipped, so that noise of NOISIEST fits into 16 bits
GAIN_ONE = 8192  # of a gain on codes, as 16-bit number
STARTS = 1 << 16  # places where a row's window of noise may begin
LEHMER, LEHMER_PRIME = 48271, 2147483647  # S. K. Park, K. W. Miller, CACM 31, 1988, as revised in 1993

DECODE = np.rint(decode(np.arange(256)) * 65535.0).astype(np.uint16)
# Straight between neighbouring codes, so that encoding what was decoded gives the same code.
# By every eighth level, so that it fits into the first cache: 0.2 levels off where the curve is steepest.
COARSE = 3
_LEVELS = np.arange(65536 >> COARSE) * float(1 << COARSE) + (1 << COARSE) / 2.0 - 0.5
ENCODE = np.rint(np.interp(_LEVELS, DECODE, np.arange(256) * float(FINE))).astype(np.int16)


@compiled
def blur_taps(psf: FloatArray, shift: float, length: float, box: FloatArray, taps: Levels) -> tuple[int, int]:
    """Fill in the weights of one row's horizontal kernel: the lens's blur, moved and smeared.

    The row is taken as straight lines between pixel centres and averaged over displacements from
    ``shift - length / 2`` to ``shift + length / 2``; whole and broken lengths are treated alike.

    Args:
        psf: The lens's blur, odd, sums to 1.
        shift: By which the picture moves to the right (px).
        length: Of the smear (px).
        box: Scratch, at least ``length + 4`` long.
        taps: Out: ``taps[t]`` weighs the pixel ``first + t`` to the left; they sum to ``ONE``.

    Returns:
        first, and how many.
    """
    near, far = shift - length / 2.0, shift + length / 2.0
    start, end = math.floor(near), math.ceil(far)
    count = end - start + 1
    for i in range(count):
        if length > 1e-3:
            box[i] = (_tent_integral(start + i - near) - _tent_integral(start + i - far)) / length
        else:
            box[i] = max(1.0 - abs(start + i - shift), 0.0)
    radius = len(psf) // 2
    total, largest = 0, 0
    for t in range(count + 2 * radius):
        weight = 0.0
        for r in range(len(psf)):
            i = t - r
            if 0 <= i < count:
                weight += psf[r] * box[i]
        taps[t] = min(math.floor(weight * ONE + 0.5), ONE - 1)
        total += int(taps[t])
        if taps[t] > taps[largest]:
            largest = t
    taps[largest] = min(int(taps[largest]) + ONE - total, ONE - 1)
    return start - radius, count + 2 * radius


@compiled
def _tent_integral(x: float) -> float:
    """Return the integral up to x of ``max(1 - |x|, 0)``."""
    x = min(max(x, -1.0), 1.0)
    if x < 0.0:
        return (x + 1.0) * (x + 1.0) / 2.0
    return 1.0 - (1.0 - x) * (1.0 - x) / 2.0


@compiled
def _differ(one: Image, two: Image) -> bool:
    change = np.uint8(0)
    for i in range(len(one)):
        change = np.uint8(change | (one[i] ^ two[i]))
    return bool(change != 0)


@compiled
def _find_changes(
    row: Image,
    mask: Image,
    mask_words: NDArray[np.uint64],
    page: NDArray[np.uint64],
    above: NDArray[np.uint64],
    blocks: Image,
) -> None:
    """Mark the blocks of a row with a pixel that is not as the one to its right (1), as the one above (2).

    A step of one level to the right is let pass: blurred, it is still one. ``mask_words`` is ``mask``, eight
    bytes at a time, as ``page`` and ``above`` are this row and the one above; what lies beyond is 0.
    """
    last = len(row) - 3
    here, right, out = row[:last], row[3:], mask[:last]
    for i in range(len(out)):
        out[i] = np.uint8(np.uint8(max(here[i], right[i]) - min(here[i], right[i])) & np.uint8(254))
    for b in range(len(blocks)):
        one, two = max(2 * b, 0), max(2 * b + 1, 0)
        along = (mask_words[one] | mask_words[two]) != 0
        down = ((page[one] ^ above[one]) | (page[two] ^ above[two])) != 0
        blocks[b] = np.uint8(along) | np.uint8(np.uint8(down) << 1)


@compiled
def _find_runs(
    changes: Image,
    lines: Places,
    before: int,
    behind: int,
    anew: bool,
    moved: bool,
    active: Image,
    active_words: NDArray[np.uint64],
    hot: Image,
    runs: Places,
) -> tuple[int, int]:
    """Find what has to be blurred, and what to be developed anew.

    Args:
        changes: Blocks of each row of the ring in which it changes, see :func:`_find_changes`.
        lines: Places in the ring of the rows under the kernel.
        before: Blocks to the left of a change that see it.
        behind: And to its right.
        anew: Whether nothing is known of the row above.
        moved: Whether its kernel was another.
        active: In and out: ``BLURRED`` and ``FRESH`` blocks, of the row above and of this one.
        active_words: The same memory.
        hot: Zeros, three times as long; scratch.
        runs: Out: first block and the one behind the last, of runs with blocks to be blurred and to be
            developed.

    Returns:
        How many of both.
    """
    blocks = len(active)
    middle = hot[blocks : 2 * blocks]
    for b in range(len(middle)):
        middle[b] = 0
    for j in range(len(lines)):
        line = changes[max(lines[j], 0)]
        for b in range(len(middle)):
            middle[b] |= line[b]
    for b in range(len(active)):
        active[b] = np.uint8(np.uint8(active[b] & BLURRED) << np.uint8(2))
    for step in range(-min(behind, blocks), min(before, blocks) + 1):
        part = hot[blocks + step : 2 * blocks + step]
        for b in range(len(active)):
            active[b] |= part[b]
    # What the kernel sees changed from the row above to this one; what is no longer blurred; and if the
    # kernel moved all that is blurred.
    always = FRESH if anew else np.uint8(0)
    either = np.uint8(7) if moved else np.uint8(2)
    for b in range(len(active)):
        blurred = BLURRED if np.uint8(active[b] & np.uint8(3)) != 0 else np.uint8(0)
        fresh = FRESH if np.uint8(active[b] & either) != 0 or active[b] == 4 else always
        active[b] = blurred | fresh
    blurs, developed = 0, 0
    blur_end, end = -GAP - 1, -GAP - 1
    for w in range(len(active_words)):
        if active_words[w] != 0:
            for b in range(WORD * w, WORD * w + WORD):
                if active[b] & FRESH:
                    if b > end + GAP:
                        runs[1, developed, 0] = b
                        developed += 1
                    end = b + 1
                    runs[1, developed - 1, 1] = end
                    if active[b] & BLURRED:
                        if b > blur_end + GAP:
                            runs[0, blurs, 0] = b
                            blurs += 1
                        blur_end = b + 1
                        runs[0, blurs - 1, 1] = blur_end
    return blurs, developed


@compiled
def _find_new(page: NDArray[np.uint64], above: NDArray[np.uint64], anew: bool, runs: Places) -> int:
    """Find runs of blocks in which a row is not as the one above; return how many."""
    count, end = 0, -GAP - 1
    for b in range(len(page) // 2):
        one, two = max(2 * b, 0), max(2 * b + 1, 0)
        if anew or ((page[one] ^ above[one]) | (page[two] ^ above[two])) != 0:
            if b > end + GAP:
                runs[count, 0] = b
                count += 1
            end = b + 1
            runs[count - 1, 1] = end
    return count


# Loops of one kind each, for in one long function the compiler gives up on vectors; each goes over all
# runs of a row, for a call with arrays costs more than most runs. Starts are held at 0 or more only so
# that the compiler need not ask whether an index counts from the end.


@compiled
def _linear_runs(
    runs: Places,
    count: int,
    back: int,
    ahead: int,
    pages: Places,
    codes: Image,
    linear: Levels,
    known: Image,
    table: Levels,
) -> None:
    """Decode what lies under the kernel, up to some blocks back and ahead, unless it is decoded."""
    blocks = known.shape[1]
    for r in range(count):
        low, high = max(runs[0, r, 0] - back, 0), min(runs[0, r, 1] + ahead, blocks)
        for j in range(len(pages)):
            page = max(pages[j], 0)
            if j == 0 or page != pages[j - 1]:
                for b in range(low, high):
                    if known[page, b] == 0:
                        known[page, b] = 1
                        start = max(BLOCK * b, 0)
                        for i in range(BLOCK):
                            linear[page, start + i] = table[codes[page, start + i]]


@compiled
def _down_runs(
    runs: Places,
    count: int,
    back: int,
    ahead: int,
    pages: Places,
    linear: Levels,
    down: Levels,
    level: Levels,
) -> None:
    """Blur runs down their columns; products are cut to 16 bits, which half a unit each makes good."""
    blocks = linear.shape[1] // BLOCK
    pad = max(linear.shape[1] + MARGIN, 0)
    middle = len(down) // 2
    for r in range(count):
        low, high = max(runs[0, r, 0] - back, 0), min(runs[0, r, 1] + ahead, blocks)
        start, size = max(BLOCK * low, 0), max(BLOCK * (high - low), 0)
        page, place = max(pages[middle], 0), max(pad + start, 0)
        rest, near, far = np.uint32(ONE - int(down[middle])), np.uint32(0), np.uint32(0)
        up1, up2, under1, under2 = page, page, page, page
        if middle >= 1:
            up1, under1 = max(pages[middle - 1], 0), max(pages[middle + 1], 0)
            near = np.uint32(down[middle - 1])
        if middle >= 2:
            up2, under2 = max(pages[middle - 2], 0), max(pages[middle + 2], 0)
            far = np.uint32(down[middle - 2])
        for i in range(size):
            light = linear[page, start + i]
            light = np.uint16(light - np.uint16((np.uint32(light) * rest) >> 16))
            light = np.uint16(light + np.uint16((np.uint32(linear[up1, start + i]) * near) >> 16))
            light = np.uint16(light + np.uint16((np.uint32(linear[under1, start + i]) * near) >> 16))
            light = np.uint16(light + np.uint16((np.uint32(linear[up2, start + i]) * far) >> 16))
            light = np.uint16(light + np.uint16((np.uint32(linear[under2, start + i]) * far) >> 16))
            level[place + i] = np.uint16(light + np.uint16(middle))
        for j in range(middle - 2):
            one_page, two_page = max(pages[j], 0), max(pages[len(down) - 1 - j], 0)
            weight = np.uint32(down[j])
            for i in range(size):
                light = np.uint16(
                    level[place + i] + np.uint16((np.uint32(linear[one_page, start + i]) * weight) >> 16)
                )
                level[place + i] = np.uint16(
                    light + np.uint16((np.uint32(linear[two_page, start + i]) * weight) >> 16)
                )


@compiled
def _go_on(level: Levels, pad: int, n: int, back: int, ahead: int) -> None:
    """Let a row go on beyond the picture's borders as it ends."""
    for i in range(back):
        level[pad - 1 - i] = level[pad + 2 - i % 3]
    for i in range(ahead):
        level[pad + n + i] = level[pad + n - 3 + i % 3]


@compiled
def _along_runs(
    runs: Places,
    count: int,
    first: int,
    taps: Levels,
    number: int,
    level: Levels,
    total: Levels,
    active: Image,
    out: Words,
    table: Words,
) -> None:
    """Blur runs along the row, four taps at a time (behind the last there are zeros); encode fresh blocks."""
    pad = len(out) + MARGIN
    half = np.uint16(number // 2)
    for r in range(count):
        start, size = max(BLOCK * runs[0, r, 0], 0), max(BLOCK * (runs[0, r, 1] - runs[0, r, 0]), 0)
        for i in range(size):
            total[i] = half
        for t in range(0, number, TAPS):
            at = max(pad + start - 3 * (first + t) - 9, 0)
            w0, w1 = np.uint32(taps[t]), np.uint32(taps[t + 1])
            w2, w3 = np.uint32(taps[t + 2]), np.uint32(taps[t + 3])
            for i in range(size):
                light = np.uint16(total[i] + np.uint16((np.uint32(level[at + 9 + i]) * w0) >> 16))
                light = np.uint16(light + np.uint16((np.uint32(level[at + 6 + i]) * w1) >> 16))
                light = np.uint16(light + np.uint16((np.uint32(level[at + 3 + i]) * w2) >> 16))
                total[i] = np.uint16(light + np.uint16((np.uint32(level[at + i]) * w3) >> 16))
        for b in range(runs[0, r, 0], runs[0, r, 1]):
            start, at = max(BLOCK * b, 0), max(BLOCK * (b - runs[0, r, 0]), 0)
            if active[b] == BLURRED | FRESH:
                for i in range(BLOCK):
                    out[start + i] = table[total[at + i] >> COARSE]


@compiled
def _copy(source: Image, out: Image) -> None:
    for i in range(len(out)):
        out[i] = source[i]


@compiled
def _widen_runs(runs: Places, count: int, source: Image, active: Image, out: Words) -> None:
    """Take fresh blocks that are not blurred as they are."""
    for r in range(count):
        for b in range(runs[1, r, 0], runs[1, r, 1]):
            start = max(BLOCK * b, 0)
            if active[b] == FRESH:
                for i in range(BLOCK):
                    out[start + i] = np.int16(np.int16(source[start + i]) << 6)


@compiled
def _widen(runs: Places, count: int, source: Image, out: Words) -> None:
    for r in range(count):
        start, size = max(BLOCK * runs[r, 0], 0), max(BLOCK * (runs[r, 1] - runs[r, 0]), 0)
        for i in range(size):
            out[start + i] = np.int16(np.int16(source[start + i]) << 6)


@compiled
def _gain_of_row(factors: Words, columns: Words, gain: Levels) -> None:
    """Compose a row's gain on codes of two products of a row and a column factor, and a third number."""
    one, two, base = factors[0], factors[1], factors[2]
    for i in range(columns.shape[1]):
        part = np.int16(base + np.int16((np.int32(columns[0, i]) * np.int32(one)) >> 16))
        gain[i] = np.uint16(np.int16(part + np.int16((np.int32(columns[1, i]) * np.int32(two)) >> 16)))


@compiled
def _light_runs(
    runs: Places, count: int, before: Words, gain: Levels, least: Levels, most: Levels, row: Words
) -> None:
    """Multiply light; where that matters hold it between the lines of least and greatest gain (1/4096)."""
    for r in range(count):
        start, size = max(BLOCK * runs[r, 0], 0), max(BLOCK * (runs[r, 1] - runs[r, 0]), 0)
        for i in range(size):
            doubled = np.uint16((np.uint16(before[start + i]) << 1) + 2 * OFFSET)
            raised = np.uint16(gain[start + i] << 2)
            product = np.uint16((np.uint32(doubled) * np.uint32(raised)) >> 16)
            value = np.int16(np.int32(product) - OFFSET)
            row[start + i] = min(max(value, np.int16(0)), np.int16(BRIGHTEST))
        if len(least) > 0:
            for i in range(BLOCK * runs[r, 0], min(BLOCK * runs[r, 1], len(least))):
                low = min((np.int64(before[i]) * least[i]) >> 12, BRIGHTEST)
                high = (np.int64(before[i]) * most[i]) >> 12
                row[i] = np.int16(min(max(np.int64(row[i]), low), high))


@compiled
def _spread_runs(runs: Places, count: int, row: Words, law: Words, step: int, out: Words) -> None:
    """Find the standard deviation of the noise of each level: a line with three bends, times ``step``."""
    base, c0, c1, c2, c3 = law[0], law[1], law[2], law[3], law[4]
    t1, t2, t3, times = law[5], law[6], law[7], np.int16(step)
    for r in range(count):
        start, size = max(BLOCK * runs[r, 0], 0), max(BLOCK * (runs[r, 1] - runs[r, 0]), 0)
        for i in range(size):
            level = row[start + i]
            std = np.int16(base + np.int16((np.int32(level) * np.int32(c0)) >> 16))
            std = np.int16(std + np.int16((np.int32(np.int16(max(level, t1) - t1)) * np.int32(c1)) >> 16))
            std = np.int16(std + np.int16((np.int32(np.int16(max(level, t2) - t2)) * np.int32(c2)) >> 16))
            std = np.int16(std + np.int16((np.int32(np.int16(max(level, t3) - t3)) * np.int32(c3)) >> 16))
            out[start + i] = np.int16(std * times)


@compiled
def _store_noisy(row: Words, std: Words, noise: Words, out: Image) -> None:
    for i in range(len(out)):
        error = np.int16((np.int32(noise[i]) * np.int32(std[i])) >> 16)
        code = np.int16(np.int16(np.int16(row[i] + error) + np.int16(FINE // 2)) >> 6)
        out[i] = np.uint8(max(min(code, np.int16(255)), np.int16(0)))


@compiled
def _store(row: Words, out: Image) -> None:
    for i in range(len(out)):
        code = np.int16(np.int16(row[i] + np.int16(FINE // 2)) >> 6)
        out[i] = np.uint8(min(code, np.int16(255)))


@compiled
def _drop_bits(out: Image, bits: int) -> None:
    """Keep the upper bits and repeat them below, so that black stays black and white white."""
    mask, again = np.uint8(256 - (1 << (8 - bits))), np.uint16(256 >> bits)
    for i in range(len(out)):
        upper = np.uint8(out[i] & mask)
        out[i] = np.uint8(upper | np.uint8(np.uint16(np.uint16(upper) * again) >> 8))


@compiled
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
    decode: Levels,
    encode: Words,
    kept: Image,
    kept_words: NDArray[np.uint64],
    linear: Levels,
    blocks: Image,
    active_words: NDArray[np.uint64],
    mask: Image,
    mask_words: NDArray[np.uint64],
    level: Levels,
    total: Levels,
    words: Words,
    gain: Levels,
    box: FloatArray,
    taps: Levels,
    places: Places,
    hot: Image,
    runs: Places,
) -> None:
    """Spoil a picture in place.

    Args:
        image: sRGB, shape ``(h, 3 w)``.
        psf: Blur of the lens along a row, odd, sums to 1.
        down: The same down a column, as weights that sum to ``ONE``.
        shear: Shift of a row to the right over that of the row above (px); the middle row stays.
        length: Of the motion blur (px).
        rows: Two row factors of the gain, and 1 for rounding, ``(h, 3)``; one row in ``GAIN_ROWS`` is used;
            none for a gain of 1.
        columns: Two column factors of the gain, ``(2, 3 w)``.
        least: Of all gains of a byte's channel (1/4096), ``(3 w,)``; empty where the toe needs no care.
        most: The greatest.
        law: Of the noise; empty for none; see :func:`_spread_runs`.
        step: What the spread is multiplied with.
        stream: Gaussian numbers, ``STARTS + 3 w``.
        state: Of the generator that tells where each row's window begins, 1 to 2^31 - 2.
        bits: Of a stored channel.
        decode: Code to linear light, 256.
        encode: Linear light to 1/64 codes.
        kept: Zeros: ring of rows, ``(2 r + 2, m)`` for a kernel of radius r; m is 3 w, filled up to words.
        kept_words: The same memory, eight bytes at a time.
        linear: Scratch ring of the same rows in linear light.
        blocks: Scratch, ``(3, 2 r + 2, m / BLOCK)``.
        active_words: Its last part's first row, eight blocks at a time.
        mask: Zeros, ``(m,)``.
        mask_words: The same memory.
        level: Scratch, ``3 m + 2 MARGIN``.
        total: Scratch, ``m``.
        words: Scratch, ``(3, m)``.
        gain: Scratch, ``m``.
        box: Scratch, see :func:`blur_taps`.
        taps: Scratch, ``(PHASES, n)`` with n ``TAPS`` more than there can be.
        places: Scratch, ``(6, max(PHASES, 2 r + 2))``.
        hot: Zeros, ``3 m / BLOCK``.
        runs: Scratch, ``(3, m / BLOCK, 2)``.
    """
    height, n = image.shape
    radius, size = len(down) // 2, kept.shape[0]
    changes, known, active = blocks[0], blocks[1], blocks[2, 0]
    firsts, counts, slots, fresh = places[0], places[1], places[2], places[3]
    lines, pages = places[4, : len(down)], places[5, : len(down)]
    plain, std = words[1], words[2]
    row = words[0] if len(rows) > 0 else plain
    inner, inner_std = row[:n], std[:n]
    some, whole = runs[1], runs[2]
    blurs = radius > 0 or length > 0.0 or shear != 0.0
    for i in range(len(counts)):
        counts[i] = 0
    for b in range(len(active)):
        active[b] = 0
    whole[0, 0], whole[0, 1] = 0, len(active)
    read, slot, last, ahead, back, seen_shift = 0, size - 1, size - 1, 0, 0, 0
    seen_all, seen_ahead, seen_back, all_blurred, all_developed = False, 0, 0, 0, 0
    for y in range(height):
        while read < min(y + radius + 1, height):
            # Rows that are the same share a page; of such, changes from above end at the second.
            here, above = read % size, (read + size - 1) % size
            fresh[here] = 1 if read > 0 and fresh[above] == 2 else 0
            if read == 0 or _differ(image[read], kept[slot, :n]):
                last = slot
                slot = (slot + 1) % size
                fresh[here] = 2
                _copy(image[read], kept[slot, :n])
                if blurs:
                    for b in range(known.shape[1]):
                        known[slot, b] = 0
                    over = kept_words[slot if read == 0 else last]
                    _find_changes(kept[slot, :n], mask, mask_words, kept_words[slot], over, changes[here])
            elif blurs:
                for b in range(changes.shape[1]):
                    changes[here, b] = changes[above, b] & np.uint8(1)
            slots[here] = slot
            read += 1
        shift = math.floor(shear * (y + 0.5 - height / 2.0) * PHASES + 0.5)
        moved, seen_shift = shift != seen_shift, shift
        phase = shift % PHASES
        if blurs and counts[phase] == 0:
            firsts[phase], counts[phase] = blur_taps(psf, phase / PHASES, length, box, taps[phase])
            for i in range(counts[phase], counts[phase] + TAPS):
                taps[phase, i] = 0
        first, count = firsts[phase] + shift // PHASES, counts[phase]
        # A change is seen by every block that looks at it, from its last tap to its first, and by its own,
        # so that a block which is left alone may keep what it has.
        if blurs:
            ahead = (3 * max(-first, 0) + BLOCK - 1) // BLOCK
            back = (3 * max(first + count - 1, 0) + BLOCK - 1) // BLOCK
        news = y == 0
        for j in range(len(down)):
            lines[j] = min(max(y + j - radius, 0), height - 1) % size
            pages[j] = slots[lines[j]]
            news = news or fresh[lines[j]] >= (1 if blurs else 2)
        seen_all = seen_all and not news and ahead == seen_ahead and back == seen_back
        seen_ahead, seen_back = ahead, back
        if blurs and (news or (moved and not seen_all)):
            all_blurred, all_developed = _find_runs(
                changes, lines, ahead, back, y == 0, moved, active, active_words, hot, runs
            )
            seen_all = moved
        elif blurs and moved:  # what was blurred in the row above is blurred anew
            all_developed = all_blurred
            for r in range(all_blurred):
                some[r, 0], some[r, 1] = runs[0, r, 0], runs[0, r, 1]
        blurred, developed = 0, 0
        if blurs and (news or moved):
            blurred, developed = all_blurred, all_developed
            _widen_runs(runs, developed, kept[slots[y % size]], active, plain)
        elif news:
            developed = _find_new(kept_words[slot], kept_words[last], y == 0, some)
            _widen(some, developed, kept[slot], plain)
        if blurred > 0:
            _linear_runs(runs, blurred, back, ahead, pages, kept, linear, known, decode)
            _down_runs(runs, blurred, back, ahead, pages, linear, down, level)
            before_first = BLOCK * back if runs[0, 0, 0] < back else 0
            behind_last = BLOCK * (ahead + WORD) if runs[0, blurred - 1, 1] + ahead >= n // BLOCK else 0
            _go_on(level, len(row) + MARGIN, n, min(before_first, n), min(behind_last, n))
            _along_runs(runs, blurred, first, taps[phase], count, level, total, active, plain, encode)
        if len(rows) > 0:
            if y % GAIN_ROWS == 0:
                _gain_of_row(rows[y], columns, gain)
                _light_runs(whole, 1, plain, gain, least, most, row)
            elif developed > 0:
                _light_runs(some, developed, plain, gain, least, most, row)
        if len(law) > 0:
            if y % SPREAD_ROWS == 0:
                _spread_runs(whole, 1, row, law, step, std)
            elif developed > 0:
                _spread_runs(some, developed, row, law, step, std)
            state = state * LEHMER % LEHMER_PRIME
            begin = state % STARTS
            _store_noisy(inner, inner_std, stream[begin : begin + n], image[y])
        else:
            _store(inner, image[y])
        if bits < 8:
            _drop_bits(image[y], bits)
