"""Kernels that spoil a picture: blur, then light, then noise, row by row, so that a row stays in cache.

What makes it fast: arithmetic on 16 bits only, which processors do 32 at a time; no random number and,
over most of the picture, no table per pixel. Codes are sRGB in 1/64 (``FINE``).

* **Blur** is exact in linear light, through tables, but is done only where the picture changes within the
  kernel's reach: where all pixels under the kernel are equal, the blurred pixel is that pixel, to the
  bit, because the weights sum to exactly one. The cost grows with what is in view.
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
Ring = tuple[Image, Levels, Image, Levels]
"""Some rows as codes and as linear light, which blocks are decoded, and the table that decodes."""

FINE = 64  # steps of one code
ONE = 1 << 14  # the sum of a kernel's weights
BLOCK = 16  # px that are looked at together for a change; 48 bytes are six words
GAP = 2  # blocks without a change that cost less than a new start
MARGIN = 32  # numbers at each end of a row that only weights of 0 reach
OFFSET = 898  # FINE * 255 * 0.055: where the sRGB curve's power law has its zero
BRIGHTEST = 20000  # 1/64 codes: light beyond is clipped, so that noise of NOISIEST fits into 16 bits
GAIN_ONE = 8192  # of a gain on codes, as 16-bit number
STARTS = 1 << 18  # places where a row's window of noise may begin
LEHMER, LEHMER_PRIME = 48271, 2147483647  # S. K. Park, K. W. Miller, CACM 31, 1988, as revised in 1993

DECODE = np.rint(decode(np.arange(256)) * 65535.0).astype(np.uint16)
# Straight between neighbouring codes, so that encoding what was decoded gives the same code to the bit.
ENCODE = np.rint(np.interp(np.arange(65536), DECODE, np.arange(256) * float(FINE))).astype(np.int16)


@compiled
def blur_taps(psf: FloatArray, shift: float, length: float, box: FloatArray, taps: Sums) -> tuple[int, int]:
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
        taps[t] = math.floor(weight * ONE + 0.5)
        total += taps[t]
        if taps[t] > taps[largest]:
            largest = t
    taps[largest] += ONE - total
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
def _find_changes(row: Image, above: Image, mask: Image, words: NDArray[np.uint64], blocks: Image) -> None:
    """Mark the blocks of a row with a pixel that differs from the one to its right or from the one above.

    ``words`` is ``mask``, eight bytes at a time; what of it lies beyond the row is 0.
    """
    last = len(row) - 3
    here, right, over, out = row[:last], row[3:], above[:last], mask[:last]
    for i in range(len(out)):
        out[i] = (here[i] ^ right[i]) | (here[i] ^ over[i])
    for c in range(last, last + 3):
        mask[c] = row[c] ^ above[c]
    per_block = len(words) // len(blocks)
    for b in range(len(blocks)):
        change = words[b * per_block]
        for i in range(b * per_block + 1, (b + 1) * per_block):
            change |= words[i]
        blocks[b] = change != 0


@compiled
def _linear_run(ring: Ring, lines: Places, low: int, high: int) -> None:
    """Decode the pixels ``low`` to ``high`` of some rows of the ring, block by block, unless they are."""
    codes, linear, known, decode = ring
    n = codes.shape[1]
    for line in lines:
        for b in range(low // BLOCK, (high - 1) // BLOCK + 1):
            if known[line, b] == 0:
                known[line, b] = 1
                start = max(3 * BLOCK * b, 0)
                for i in range(min(3 * BLOCK, n - start)):
                    linear[line, start + i] = decode[codes[line, start + i]]


@compiled
def _blur_run(
    ring: Ring,
    lines: Places,
    down: Sums,
    taps: Sums,
    first: int,
    count: int,
    begin: int,
    end: int,
    level: Levels,
    total: Sums,
    out: Words,
    encode: Words,
) -> None:
    """Blur the pixels ``begin`` to ``end`` of a row; ``lines`` are the places in the ring of its rows."""
    linear = ring[1]
    width = linear.shape[1] // 3
    low, high = begin - first - count + 1, end - first
    inner_low = min(max(low, 0), width - 1)
    inner_high = max(min(high, width), inner_low + 1)
    _linear_run(ring, lines, inner_low, inner_high)
    pad = 3 * width + MARGIN
    start, size = 3 * inner_low, 3 * (inner_high - inner_low)
    inner = pad + start
    radius = len(down) // 2
    if radius <= 2:
        _down_five(linear, lines, down, start, size, level, inner)
    else:
        _down_any(linear, lines, down, start, size, total, level, inner)
    # Beyond the borders the picture goes on as it ends.
    for x in range(low, inner_low):
        for c in range(3):
            level[pad + 3 * x + c] = level[inner + c]
    for x in range(inner_high, high):
        for c in range(3):
            level[pad + 3 * x + c] = level[inner + size - 3 + c]
    # Along the row, eight taps at a time; behind the last tap there are zeros.
    size = 3 * (end - begin)
    for t in range(0, count, 8):
        _along_eight(level, pad + 3 * (begin - first - t), taps, t, size, total)
    _encode_run(total, encode, out, 3 * begin, size)


# Loops of one kind each, for in one long function the compiler gives up on vectors. Starts are held at 0
# or more only so that it need not ask whether an index counts from the end.


@compiled
def _down_five(
    linear: Levels,
    lines: Places,
    down: Sums,
    start: int,
    size: int,
    level: Levels,
    inner: int,
) -> None:
    start, inner = max(start, 0), max(inner, 0)
    radius = len(down) // 2
    middle, w0, w1, w2 = lines[radius], np.int32(down[radius]), np.int32(0), np.int32(0)
    up1, up2, under1, under2 = middle, middle, middle, middle
    if radius >= 1:
        up1, under1, w1 = lines[radius - 1], lines[radius + 1], np.int32(down[radius - 1])
    if radius >= 2:
        up2, under2, w2 = lines[radius - 2], lines[radius + 2], np.int32(down[radius - 2])
    for i in range(size):
        one = np.int32(np.int32(linear[up1, start + i]) + np.int32(linear[under1, start + i]))
        two = np.int32(np.int32(linear[up2, start + i]) + np.int32(linear[under2, start + i]))
        near = np.int32(np.int32(w0 * np.int32(linear[middle, start + i])) + np.int32(w1 * one))
        level[inner + i] = np.uint16(np.int32(np.int32(near + np.int32(w2 * two)) + ONE // 2) >> 14)


@compiled
def _down_any(
    linear: Levels,
    lines: Places,
    down: Sums,
    start: int,
    size: int,
    total: Sums,
    level: Levels,
    inner: int,
) -> None:
    start, inner = max(start, 0), max(inner, 0)
    for i in range(size):
        total[i] = ONE // 2
    for j in range(len(down)):
        line, weight = lines[j], np.int32(down[j])
        for i in range(size):
            total[i] = np.int32(total[i] + np.int32(weight * np.int32(linear[line, start + i])))
    for i in range(size):
        level[inner + i] = np.uint16(total[i] >> 14)


@compiled
def _along_eight(level: Levels, at: int, taps: Sums, t: int, size: int, total: Sums) -> None:
    """Add eight taps, from the one at ``t`` on; the first eight begin the sum."""
    w0, w1, w2, w3 = np.int32(taps[t]), np.int32(taps[t + 1]), np.int32(taps[t + 2]), np.int32(taps[t + 3])
    w4, w5, w6, w7 = (
        np.int32(taps[t + 4]),
        np.int32(taps[t + 5]),
        np.int32(taps[t + 6]),
        np.int32(taps[t + 7]),
    )
    at = max(at - 21, 0)
    if t == 0:
        for i in range(size):
            total[i] = ONE // 2
    for i in range(size):
        one = np.int32(
            np.int32(w0 * np.int32(level[at + 21 + i])) + np.int32(w1 * np.int32(level[at + 18 + i]))
        )
        two = np.int32(
            np.int32(w2 * np.int32(level[at + 15 + i])) + np.int32(w3 * np.int32(level[at + 12 + i]))
        )
        three = np.int32(
            np.int32(w4 * np.int32(level[at + 9 + i])) + np.int32(w5 * np.int32(level[at + 6 + i]))
        )
        four = np.int32(np.int32(w6 * np.int32(level[at + 3 + i])) + np.int32(w7 * np.int32(level[at + i])))
        total[i] = np.int32(total[i] + np.int32(np.int32(one + two) + np.int32(three + four)))


@compiled
def _encode_run(total: Sums, encode: Words, out: Words, start: int, size: int) -> None:
    start = max(start, 0)
    for i in range(size):
        out[start + i] = encode[np.uint16(total[i] >> 14)]


@compiled
def _blur_row(
    ring: Ring,
    changes: Image,
    y: int,
    height: int,
    down: Sums,
    taps: Sums,
    first: int,
    count: int,
    changed: Image,
    lines: Places,
    level: Levels,
    total: Sums,
    out: Words,
    encode: Words,
) -> None:
    """Blur one row where it changes within the kernel's reach; elsewhere ``out`` stays as it is."""
    size, blocks = changes.shape
    radius, width = len(down) // 2, ring[0].shape[1] // 3
    for b in range(blocks):
        changed[b] = 0
    for j in range(len(down)):
        line = min(max(y + j - radius, 0), height - 1) % size
        lines[j] = line
        for b in range(blocks):
            changed[b] |= changes[line, b]
    # A change is seen by every block that looks at it, from its last tap to its first, and by its own, so
    # that a block which is left alone may keep what it has.
    before, behind = (max(-first, 0) + BLOCK - 1) // BLOCK, (max(first + count - 1, 0) + BLOCK - 1) // BLOCK
    run, end = -1, -1
    for b in range(blocks):
        if changed[b] == 0:
            continue
        start = max(b - before, 0)
        if run >= 0 and start > end + GAP:
            last = min(end * BLOCK, width)
            _blur_run(ring, lines, down, taps, first, count, run * BLOCK, last, level, total, out, encode)
            run = -1
        if run < 0:
            run = start
        end = min(b + behind + 1, blocks)
    if run >= 0:
        last = min(end * BLOCK, width)
        _blur_run(ring, lines, down, taps, first, count, run * BLOCK, last, level, total, out, encode)


@compiled
def _copy(source: Image, out: Image) -> None:
    for i in range(len(out)):
        out[i] = source[i]


@compiled
def _widen(source: Image, out: Words) -> None:
    for i in range(len(out)):
        out[i] = np.int16(np.int16(source[i]) << 6)


@compiled
def _gain_of_row(factors: Words, columns: Words, gain: Levels) -> None:
    """Compose a row's gain on codes of two products of a row and a column factor, and a third number."""
    one, two, base = factors[0], factors[1], factors[2]
    for i in range(len(gain)):
        part = np.int16(base + np.int16((np.int32(columns[0, i]) * np.int32(one)) >> 16))
        gain[i] = np.uint16(np.int16(part + np.int16((np.int32(columns[1, i]) * np.int32(two)) >> 16)))


@compiled
def _light(row: Words, gain: Levels) -> None:
    for i in range(len(row)):
        doubled = np.uint16((np.uint16(row[i]) << 1) + 2 * OFFSET)
        raised = np.uint16(gain[i] << 2)
        product = np.uint16((np.uint32(doubled) * np.uint32(raised)) >> 16)
        value = np.int16(np.int32(product) - OFFSET)
        row[i] = min(max(value, np.int16(0)), np.int16(BRIGHTEST))


@compiled
def _hold(source: Words, row: Words, least: Levels, most: Levels) -> None:
    """Hold light between the lines of the least and the greatest gain, in 1/4096."""
    for i in range(len(row)):
        low = min((np.int64(source[i]) * least[i]) >> 12, BRIGHTEST)
        high = (np.int64(source[i]) * most[i]) >> 12
        row[i] = np.int16(min(max(np.int64(row[i]), low), high))


@compiled
def _spread(row: Words, law: Words, out: Words) -> None:
    """Return the standard deviation of the noise of each level: a line with three bends."""
    base, c0, c1, c2, c3 = law[0], law[1], law[2], law[3], law[4]
    t1, t2, t3 = law[5], law[6], law[7]
    for i in range(len(row)):
        level = row[i]
        std = np.int16(base + np.int16((np.int32(level) * np.int32(c0)) >> 16))
        std = np.int16(std + np.int16((np.int32(np.int16(max(level, t1) - t1)) * np.int32(c1)) >> 16))
        std = np.int16(std + np.int16((np.int32(np.int16(max(level, t2) - t2)) * np.int32(c2)) >> 16))
        out[i] = np.int16(std + np.int16((np.int32(np.int16(max(level, t3) - t3)) * np.int32(c3)) >> 16))


@compiled
def _store_noisy(row: Words, std: Words, noise: Words, step: int, out: Image) -> None:
    for i in range(len(out)):
        part = np.int16((np.int32(noise[i]) * np.int32(std[i])) >> 16)
        error = np.int16(np.int16(part) * np.int16(step))
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
    lost = 8 - bits
    for i in range(len(out)):
        upper = np.int64(out[i]) >> lost
        out[i] = np.uint8((upper << lost) | (upper >> (bits - lost)))


@compiled
def spoil(
    image: Image,
    psf: FloatArray,
    down: Sums,
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
    linear: Levels,
    blocks: Image,
    mask: Image,
    mask_words: NDArray[np.uint64],
    level: Levels,
    total: Sums,
    words: Words,
    gain: Levels,
    box: FloatArray,
    taps: Sums,
) -> None:
    """Spoil a picture in place.

    Args:
        image: sRGB, shape ``(h, 3 w)``.
        psf: Blur of the lens along a row, odd, sums to 1.
        down: The same down a column, as weights that sum to ``ONE``.
        shear: Shift of a row to the right over that of the row above (px); the middle row stays.
        length: Of the motion blur (px).
        rows: Two row factors of the gain, and 1 for rounding, ``(h, 3)``; every other row is used; none for
            a gain of 1.
        columns: Two column factors of the gain, ``(2, 3 w)``.
        least: Of all gains of a byte's channel (1/4096), ``(3 w,)``; empty where the toe needs no care.
        most: The greatest.
        law: Of the noise; empty for none; see :func:`_spread`.
        step: What the noise is multiplied with.
        stream: Gaussian numbers, ``STARTS + 3 w``.
        state: Of the generator that tells where each row's window begins, 1 to 2^31 - 2.
        bits: Of a stored channel.
        decode: Code to linear light, 256.
        encode: Linear light to 1/64 codes, 65536.
        kept: Scratch ring of rows, ``(2 r + 2, 3 w)`` for a kernel of radius r.
        linear: Scratch ring of the same rows in linear light.
        blocks: Scratch, ``(2, 2 r + 2, blocks)``.
        mask: Zeros, three bytes for every pixel of every block.
        mask_words: The same memory.
        level: Scratch, ``9 w + 2 MARGIN``.
        total: Scratch, ``3 w``.
        words: Scratch, ``(3, 3 w)``.
        gain: Scratch, ``3 w``.
        box: Scratch, see :func:`blur_taps`.
        taps: Scratch, seven more than there can be taps.
    """
    height, n = image.shape
    radius, size = len(down) // 2, kept.shape[0]
    changes, known = blocks[0], blocks[1]
    ring = (kept, linear, known, decode)
    changed = np.empty(blocks.shape[2], dtype=np.uint8)
    lines = np.empty(len(down), dtype=np.int64)
    codes, before, std = words[0], words[1], words[2]
    blurred = radius > 0 or length > 0.0 or shear != 0.0
    first, count = 0, 0
    read, alike = 0, 0
    for y in range(height):
        source = image[y]
        _widen(source, codes)
        if blurred:
            while read < min(y + radius + 1, height):
                here = read % size
                _copy(image[read], kept[here])
                for b in range(known.shape[1]):
                    known[here, b] = 0
                above = (read + size - 1) % size if read > 0 else here
                alike = 0 if _differ(kept[here], kept[above]) else alike + 1
                if alike < 2 or read < 2:
                    _find_changes(kept[here], kept[above], mask, mask_words, changes[here])
                else:  # the third of equal rows changes where the second does
                    _copy(changes[above], changes[here])
                read += 1
            if y == 0 or shear != 0.0:
                shift = shear * (y + 0.5 - height / 2.0)
                first, count = blur_taps(psf, shift, length, box, taps)
                taps[count : count + 7] = 0
            _blur_row(
                ring,
                changes,
                y,
                height,
                down,
                taps,
                first,
                count,
                changed,
                lines,
                level,
                total,
                codes,
                encode,
            )
        if len(rows) > 0:
            if y % 2 == 0:
                _gain_of_row(rows[y], columns, gain)
            if len(least) > 0:
                for i in range(n):
                    before[i] = codes[i]
            _light(codes, gain)
            if len(least) > 0:
                _hold(before, codes, least, most)
        if len(law) > 0:
            state = state * LEHMER % LEHMER_PRIME
            begin = state % STARTS
            _spread(codes, law, std)
            _store_noisy(codes, std, stream[begin : begin + n], step, source)
        else:
            _store(codes, source)
        if bits < 8:
            _drop_bits(source, bits)
