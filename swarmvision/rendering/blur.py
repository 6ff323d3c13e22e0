"""Kernels that move light about: the lens's blur, motion blur and the rolling shutter, where pictures change.

A row is worked on in blocks of ``BLOCK`` bytes that are named by lists: loops over a block are all vectors.
They take their length from an array, for what the compiler knows the length of it unrolls and then finds no
vectors in; and weights are as wide as a block, for of a single one it does not see that it has 16 bits. Words
of ``WORD`` bytes in which a row changes are told by bits, 64 words at a time.

Light is linear, in 16 bits; through tables it is true to 0.2 codes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.colour import decode
from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray

Image = NDArray[np.uint8]
Words = NDArray[np.int16]
Levels = NDArray[np.uint16]
Places = NDArray[np.int64]
Longs = NDArray[np.uint64]

FINE = 64  # steps of one code
ONE = 1 << 16  # the sum of a kernel's weights; but one alone is 1 less
FAINT = 200  # a weight that, at an end, is given to the next: 0.003
WORD = 8  # bytes whose changes are told by one bit
BLOCK = 32  # bytes that are worked on together
BITS = BLOCK // WORD  # that tell of them
TAPS, LINES = 8, 5  # weights along a row and down a column that are added at once
PHASES = 16  # places within a pixel that a row's shift is rounded to
ALONG, DOWN = 0, 1  # where a row is not as it is a pixel to the right; where not as the row above
LIGHT, BLURRED, FRESH = (
    0,
    1,
    2,
)  # words whose light is new, that the kernel blurs, whose value is new; see plan_row

DECODE = np.rint(decode(np.arange(256)) * 65535.0).astype(np.uint16)
# Straight between neighbouring codes, so that encoding what was decoded gives the same code.
# By every eighth level, so that it fits into the first cache: 0.2 levels off where the curve is steepest.
COARSE = 3
_LEVELS = np.arange(65536 >> COARSE) * float(1 << COARSE) + (1 << COARSE) / 2.0 - 0.5
ENCODE = np.rint(np.interp(_LEVELS, DECODE, np.arange(256) * float(FINE))).astype(np.int16)


@leaf
def blur_taps(
    psf: FloatArray, shift: float, length: float, box: FloatArray, taps: Places, weights: Levels
) -> tuple[int, int]:
    """Fill in the weights of one row's horizontal kernel: the lens's blur, moved and smeared.

    The row is taken as straight lines between pixel centres and averaged over displacements from
    ``shift - length / 2`` to ``shift + length / 2``; whole and broken lengths are treated alike.

    Args:
        psf: The lens's blur, odd, sums to 1.
        shift: By which the picture moves to the right (px).
        length: Of the smear (px).
        box: Scratch, at least ``length + 4`` long.
        taps: Scratch, likewise.
        weights: Out: ``weights[t]`` weigh the pixel ``first + t`` to the left; they sum to ``ONE``; behind
            the last there are ``TAPS`` zeros. All ``BLOCK`` of a row are the same.

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
    number = count + 2 * radius
    for t in range(number):
        weight = 0.0
        for r in range(len(psf)):
            i = t - r
            if 0 <= i < count:
                weight += psf[r] * box[i]
        taps[t] = math.floor(weight * ONE + 0.5)
    begin = 0
    while number - begin > 1 and taps[begin] < FAINT:
        taps[begin + 1] += taps[begin]
        begin += 1
    while number - begin > 1 and taps[number - 1] < FAINT:
        taps[number - 2] += taps[number - 1]
        number -= 1
    total, largest = 0, begin
    for t in range(begin, number):
        total += taps[t]
        if taps[t] > taps[largest]:
            largest = t
    taps[largest] += ONE - total
    for t in range(number - begin + TAPS):
        each = np.uint16(min(taps[begin + t], ONE - 1) if begin + t < number else 0)
        for i in range(weights.shape[1]):
            weights[t, i] = each
    return start - radius + begin, number - begin


@leaf
def _tent_integral(x: float) -> float:
    """Return the integral up to x of ``max(1 - |x|, 0)``."""
    x = min(max(x, -1.0), 1.0)
    if x < 0.0:
        return (x + 1.0) * (x + 1.0) / 2.0
    return 1.0 - (1.0 - x) * (1.0 - x) / 2.0


@leaf
def find_changes(
    image: Image,
    blurs: bool,
    mask: Image,
    mask_words: Longs,
    told: Image,
    told_words: Longs,
    bits: Longs,
    origin: Places,
) -> None:
    """Tell in which words a row has a pixel that is not as the one to its right, or as the one above.

    A step of one level to the right is let pass: blurred, it is still one.

    Args:
        image: sRGB, ``(h, 3 w)``.
        blurs: Whether to tell more than which rows are the same.
        mask: Zeros, a byte for each of a row, ``(2, 512 longs)``; longs are 64 words.
        mask_words: The same memory, ``WORD`` bytes at a time.
        told: Scratch, a byte for each word, ``(2, 64 longs)``.
        told_words: The same memory, ``WORD`` bytes at a time.
        bits: Out: words that differ ``ALONG`` and ``DOWN``, ``(h, 2, longs)``; not of rows as the one above.
        origin: Out: the first of the rows without a change that each row is one of, ``(h,)``.
    """
    height, n = image.shape
    for y in range(height):
        over = max(y - 1, 0)
        change = np.uint8(0)
        for i in range(n):
            change = np.uint8(change | (image[y, i] ^ image[over, i]))
        origin[y] = y if y == 0 or change != 0 else origin[over]
        if blurs and origin[y] == y:
            for i in range(n - 3):
                one, two = image[y, i], image[y, i + 3]
                mask[ALONG, i] = np.uint8(np.uint8(max(one, two) - min(one, two)) & np.uint8(254))
            for i in range(n):
                mask[DOWN, i] = image[y, i] ^ image[over, i]
            for kind in range(2):
                for w in range(told.shape[1]):
                    told[kind, w] = np.uint8(mask_words[kind, w] != 0)
                for k in range(bits.shape[2]):
                    gathered = np.uint64(0)
                    for part in range(8):
                        # Eight bytes of 0 or 1, to eight bits in the uppermost byte.
                        eight = np.uint64(told_words[kind, 8 * k + part] * np.uint64(0x0102040810204080))
                        gathered |= np.uint64(eight >> np.uint64(56)) << np.uint64(8 * part)
                    bits[y, kind, k] = gathered


@leaf
def plan_row(
    bits: Longs,
    origin: Places,
    above: int,
    below: int,
    reach: tuple[int, int],
    moved: bool,
    window: Longs,
    marks: Longs,
    lists: Places,
) -> tuple[int, int, bool]:
    """List the blocks of a row whose light, blurred down, is new, and those whose value is.

    Args:
        bits: See :func:`find_changes`.
        origin: Likewise.
        above: The topmost row under the kernel.
        below: The one behind the lowest.
        reach: Words by which a change is seen to the left (negative) and to the right.
        moved: Whether the row above had another kernel.
        window: Zeros, ``(2, 3 longs)``.
        marks: In and out: ``LIGHT``, ``BLURRED`` and ``FRESH`` words of the row above and of this one.
        lists: Out: blocks; the last list stays, ``(3, blocks)``.

    Returns:
        The lengths of both, and whether the kernel blurs anything here.
    """
    longs, blurred = marks.shape[1], np.uint64(0)
    for k in range(longs):
        uneven, new, old = np.uint64(0), np.uint64(0), marks[BLURRED, k]
        for y in range(max(above, 0), below):
            row = max(origin[y], 0)
            uneven |= bits[row, ALONG, k]
            if row == y:
                new |= bits[row, DOWN, k]
                if y > above:  # the topmost is not as the row above it, but that is out of the kernel's sight
                    uneven |= bits[row, DOWN, k]
        window[0, longs + k], window[1, longs + k] = uneven, new
        marks[LIGHT, k], marks[BLURRED, k] = new, np.uint64(0)
        marks[FRESH, k] = old if moved else np.uint64(0)
    for step in range(max(reach[0], 1 - 64 * longs), min(reach[1], 64 * longs - 1) + 1):
        far, near, rest = step // 64, np.uint64(step % 64), np.uint64(63 - step % 64)
        for k in range(longs):
            at = max(longs + k - far, 1)
            marks[BLURRED, k] |= (window[0, at] << near) | ((window[0, at - 1] >> np.uint64(1)) >> rest)
            marks[FRESH, k] |= (window[1, at] << near) | ((window[1, at - 1] >> np.uint64(1)) >> rest)
    if moved:
        for k in range(longs):
            marks[FRESH, k] |= marks[BLURRED, k]
    light, fresh, some, each = 0, 0, np.uint64((1 << BITS) - 1), 64 // BITS
    for k in range(longs):
        if marks[LIGHT, k] | marks[FRESH, k] != 0:
            for b in range(each * k, min(each * (k + 1), lists.shape[1])):
                shift = np.uint64(BITS * (b - each * k))
                lists[0, light] = b
                lists[1, fresh] = b
                if (marks[LIGHT, k] >> shift) & some != 0:
                    light += 1
                if (marks[FRESH, k] >> shift) & some != 0:
                    fresh += 1
    for k in range(longs):
        blurred |= marks[BLURRED, k]
    return light, fresh, bool(blurred != 0)


@leaf
def bring_to_light(image: Image, y: int, bits: Longs, above: int, page: int, light: Levels) -> None:
    """Decode a row onto a page; where it is as the row above, copy that one's page."""
    page, above, y = max(page, 0), max(above, 0), max(y, 0)
    n, every = image.shape[1], np.uint64((1 << BITS) - 1)
    for i in range(light.shape[1]):
        light[page, i] = light[above, i]
    whole = n // BLOCK
    for b in range(whole):
        k, shift = max(b // (64 // BITS), 0), np.uint64(BITS * (b % (64 // BITS)))
        if y == 0 or (bits[y, DOWN, k] >> shift) & every != 0:
            start = max(BLOCK * b, 0)
            for i in range(BLOCK):
                light[page, start + i] = DECODE[image[y, start + i]]
    for i in range(BLOCK * whole, n):
        light[page, i] = DECODE[image[y, i]]
    for i in range(n, light.shape[1]):
        light[page, i] = light[page, i - 3]


@leaf
def blur_down(blocks: Places, light: Levels, pages: Places, down: Levels, pad: int, level: Levels) -> None:
    """Blur blocks down their columns; products are cut to 16 bits, which half a unit each makes good."""
    for j in range(0, len(down), LINES):
        each = down[j : j + LINES]
        page0, page1 = light[max(pages[j], 0)], light[max(pages[j + 1], 0)]
        page2, page3 = light[max(pages[j + 2], 0)], light[max(pages[j + 3], 0)]
        page4 = light[max(pages[j + 4], 0)]
        half, old = np.uint16(LINES // 2), np.uint16(0 if j == 0 else ONE - 1)
        for k in range(len(blocks)):
            start = max(BLOCK * blocks[k], 0)
            place = max(pad + start, 0)
            for i in range(each.shape[1]):
                value = np.uint16(np.uint16(level[place + i] & old) + half)
                one = np.uint16((np.uint32(page0[start + i]) * np.uint32(each[0, i])) >> 16)
                two = np.uint16((np.uint32(page1[start + i]) * np.uint32(each[1, i])) >> 16)
                value = np.uint16(value + np.uint16(one + two))
                one = np.uint16((np.uint32(page2[start + i]) * np.uint32(each[2, i])) >> 16)
                two = np.uint16((np.uint32(page3[start + i]) * np.uint32(each[3, i])) >> 16)
                value = np.uint16(value + np.uint16(one + two))
                one = np.uint16((np.uint32(page4[start + i]) * np.uint32(each[4, i])) >> 16)
                level[place + i] = np.uint16(value + one)


@leaf
def go_on(level: Levels, pad: int, n: int, back: int, ahead: int) -> None:
    """Let a row go on beyond the picture's borders as it ends."""
    for i in range(back):
        level[pad - 1 - i] = level[pad + 2 - i % 3]
    for i in range(ahead):
        level[pad + n + i] = level[pad + n - 3 + i % 3]


@leaf
def blur_along(
    blocks: Places,
    first: int,
    weights: Levels,
    number: int,
    level: Levels,
    pad: int,
    total: Levels,
    out: Words,
) -> None:
    """Blur blocks along the row and encode them."""
    for t in range(0, number, TAPS):
        each = weights[t : t + TAPS]
        half, old = np.uint16(number // 2 if t == 0 else 0), np.uint16(0 if t == 0 else ONE - 1)
        for k in range(len(blocks)):
            start = max(BLOCK * blocks[k], 0)
            at = max(pad + start - 3 * (first + t + TAPS - 1), 0)
            for i in range(each.shape[1]):
                light = np.uint16(np.uint16(total[start + i] & old) + half)
                one = np.uint16((np.uint32(level[at + 21 + i]) * np.uint32(each[0, i])) >> 16)
                two = np.uint16((np.uint32(level[at + 18 + i]) * np.uint32(each[1, i])) >> 16)
                light = np.uint16(light + np.uint16(one + two))
                one = np.uint16((np.uint32(level[at + 15 + i]) * np.uint32(each[2, i])) >> 16)
                two = np.uint16((np.uint32(level[at + 12 + i]) * np.uint32(each[3, i])) >> 16)
                light = np.uint16(light + np.uint16(one + two))
                one = np.uint16((np.uint32(level[at + 9 + i]) * np.uint32(each[4, i])) >> 16)
                two = np.uint16((np.uint32(level[at + 6 + i]) * np.uint32(each[5, i])) >> 16)
                light = np.uint16(light + np.uint16(one + two))
                one = np.uint16((np.uint32(level[at + 3 + i]) * np.uint32(each[6, i])) >> 16)
                two = np.uint16((np.uint32(level[at + i]) * np.uint32(each[7, i])) >> 16)
                total[start + i] = np.uint16(light + np.uint16(one + two))
    # Not at once behind the blur, for single numbers of what is just stored are not there to be read.
    for k in range(len(blocks)):
        start = max(BLOCK * blocks[k], 0)
        for i in range(BLOCK):
            out[start + i] = ENCODE[total[start + i] >> COARSE]
