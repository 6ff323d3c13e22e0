"""Kernels that move light about: the lens's blur, motion blur and the rolling shutter, where pictures change.

A row's bytes stand in two planes, those of even and those of odd places, as numbers of 16 bits: so two bytes
come from one word of the picture and go into one without being shuffled. A row is worked on in *pieces* of
``PIECE`` numbers of one plane, which are named by lists: loops over a piece are all vectors. A block of
``BLOCK`` bytes is two pieces. Words of ``WORD`` bytes in which a row changes are told by bits, 64 words at a
time.

Light is linear, in 16 bits; it is true to 0.2 codes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import leaf, wide
from swarmvision.compiled.prefetch import prefetch
from swarmvision.geometry import FloatArray
from swarmvision.rendering.curve import NEVER, PIECE, Levels, Places

Image = NDArray[np.uint8]
Longs = NDArray[np.uint64]

ONE = 1 << 16  # the sum of a kernel's weights; but one alone is 1 less
FAINT = 200  # a weight that, at an end, is given to the next: 0.003
BLOCK = 2 * PIECE  # bytes that they are of
WORD = BLOCK // 8  # bytes whose changes are told by one bit, so that a block's are told by a byte
LINE = 64  # bytes of a line of the cache
AHEAD = 3  # rows that memory is asked for before they are looked at
TAPS, LINES = 6, 3  # weights along a row and down a column that are added at once
PHASES = 16  # places within a pixel that a row's shift is rounded to
ALONG, DOWN = 0, 1  # where a row is not as it is a pixel to the right; where not as the row above
LIGHT, BLURRED, FRESH = range(3)  # words whose light is new, that the kernel blurs, whose value is new


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
            the last there are ``TAPS`` zeros.

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
        for i in range(PIECE):
            weights[t * PIECE + i] = each
    return start - radius + begin, number - begin


@leaf
def _tent_integral(x: float) -> float:
    """Return the integral up to x of ``max(1 - |x|, 0)``."""
    x = min(max(x, -1.0), 1.0)
    if x < 0.0:
        return (x + 1.0) * (x + 1.0) / 2.0
    return 1.0 - (1.0 - x) * (1.0 - x) / 2.0


@wide
def find_changes(
    image: Image,
    y: int,
    side: int,
    blurs: bool,
    kept: Image,
    mask: Image,
    told: Image,
    bits: Longs,
    origin: Places,
) -> int:
    """Tell in which words a row has a pixel that is not as the one to its right, or as the one above.

    A step of one level to the right is let pass: blurred, it is still one.

    Args:
        image: sRGB, ``(h, 3 w)``.
        y: Which row; rows are asked for in their order.
        side: Where in ``kept`` the row above is.
        blurs: Whether to ask to the right, too.
        kept: In and out: rows without spoil, ``(2, m)``; m is 3 w, filled up to whole blocks.
        mask: Zeros, a byte for each of a row, ``(m,)``.
        told: Zeros, a byte for each word, ``(2, 64 longs)``; longs are 64 words.
        bits: Out: words that differ ``ALONG``, if that is asked, and ``DOWN``, ``(h, 2, longs)``; not of rows
            as the one above.
        origin: Out: the first of the rows without a change that each row is one of, ``(h,)``.

    Returns:
        Where in ``kept`` this row is.
    """
    y, above, n = max(y, 0), max(side, 0), image.shape[1]
    coming = min(y + AHEAD, image.shape[0] - 1)
    for i in range(0, n, LINE):
        prefetch(image, coming, i)
    change = np.uint8(0)
    for i in range(n):
        change = np.uint8(change | (image[y, i] ^ kept[above, i]))
    origin[y] = y if y == 0 or change != 0 else origin[max(y - 1, 0)]
    if origin[y] != y:
        return above
    here = 1 - above
    for i in range(n):
        kept[here, i] = image[y, i]
    if y == 0:  # there is none above
        for i in range(n):
            kept[above, i] = image[y, i]
    words, spots, eights = kept.view(np.uint64), mask.view(np.uint64), told.view(np.uint64)
    for w in range(words.shape[1]):
        told[DOWN, w] = np.uint8(words[here, w] != words[above, w])
    if blurs:
        for i in range(n - 3):
            one, two = kept[here, i], kept[here, i + 3]
            mask[i] = np.uint8(np.uint8(max(one, two) - min(one, two)) & np.uint8(254))
        for w in range(len(spots)):
            told[ALONG, w] = np.uint8(spots[w] != 0)
    for kind in range(ALONG if blurs else DOWN, 2):
        for k in range(bits.shape[2]):
            gathered = np.uint64(0)
            for j in range(8):
                # Eight bytes of 0 or 1, to eight bits in the uppermost byte.
                eight = np.uint64(eights[kind, 8 * k + j] * np.uint64(0x0102040810204080))
                gathered |= (eight >> np.uint64(56)) << np.uint64(8 * j)
            bits[y, kind, k] = gathered
    return here


@leaf
def list_pieces(words: Longs, pieces: Places) -> int:
    """List the pieces of the blocks in which words are marked, block by block, and return how many.

    ``pieces`` has room for all of them: it is as long as a row has pieces. A block's marks are a byte.
    """
    count, half = 0, len(pieces) // 2
    for k in range(len(words)):
        marks = words[k]
        if marks != 0:
            for b in range(8 * k, min(8 * (k + 1), half)):
                # Written in any case, and kept where the count goes on: that is cheaper than to branch.
                place = min(count, len(pieces) - 2)
                pieces[place], pieces[place + 1] = b, half + b
                count += 2 if (marks & np.uint64(255)) != 0 else 0
                marks >>= np.uint64(8)
    return count


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
    """List the pieces of a row whose light, blurred down, is new, and those whose value is.

    Args:
        bits: See :func:`find_changes`.
        origin: Likewise.
        above: The topmost row under the kernel.
        below: The one behind the lowest.
        reach: Words by which a change is seen to the left (negative) and to the right.
        moved: Whether the row above had another kernel.
        window: Zeros, ``(2, 3 longs)``.
        marks: In and out: ``LIGHT``, ``BLURRED`` and ``FRESH`` words of the row above and of this one.
        lists: Out: pieces; the last list stays, ``(3, pieces)``.

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
    for k in range(longs):
        blurred |= marks[BLURRED, k]
    return list_pieces(marks[LIGHT], lists[0]), list_pieces(marks[FRESH], lists[1]), bool(blurred != 0)


@wide
def blur_down(pieces: Places, light: Levels, pages: Places, down: Levels, pad: int, level: Levels) -> None:
    """Blur pieces down their columns; products are cut to 16 bits, which half a unit each makes good.

    Args:
        pieces: Which.
        light: Pages, ``(., m)``.
        pages: Those under the kernel, from above, in groups of ``LINES``.
        down: Their weights.
        pad: Room to both sides of a plane of ``level``.
        level: Out: both planes, each with its room, ``m + 4 pad``.
    """
    half = light.shape[1] // 2
    for t in range(0, len(pages), LINES):
        each = down[t * PIECE : (t + LINES) * PIECE]
        page0, page1 = light[max(pages[t], 0)], light[max(pages[t + 1], 0)]
        page2 = light[max(pages[t + 2], 0)]
        rest, old = np.uint16(LINES // 2), np.uint16(0 if t == 0 else ONE - 1)
        for k in range(len(pieces)):
            start, same = max(PIECE * pieces[k], 0), max(pieces[k] >> NEVER, 0)
            place = max(start + (pad if start < half else 3 * pad), 0)
            for i in range(PIECE):
                j = same + i
                value = np.uint16(np.uint16(level[place + i] & old) + rest)
                one = np.uint16((np.uint32(page0[start + i]) * np.uint32(each[j])) >> 16)
                two = np.uint16((np.uint32(page1[start + i]) * np.uint32(each[PIECE + j])) >> 16)
                value = np.uint16(value + np.uint16(one + two))
                one = np.uint16((np.uint32(page2[start + i]) * np.uint32(each[2 * PIECE + j])) >> 16)
                level[place + i] = np.uint16(value + one)


@leaf
def go_on(level: Levels, pad: int, n: int, back: int, ahead: int) -> None:
    """Let a row of ``n`` bytes go on beyond the picture's borders as it ends, by so many bytes."""
    plane = len(level) // 2
    for i in range(-back, 0):
        level[(i & 1) * plane + pad + (i >> 1)] = level[(i % 3 & 1) * plane + pad + (i % 3 >> 1)]
    for i in range(n, n + ahead):
        last = n - 3 + (i - n) % 3
        level[(i & 1) * plane + pad + (i >> 1)] = level[(last & 1) * plane + pad + (last >> 1)]


@leaf
def place_of(plane: int, tap: int, pad: int, half: int) -> int:
    """Return where in ``level`` the pixel ``tap`` to the left is, less the place in the row of who looks.

    A pixel is three bytes, so odd steps lead to the other plane.
    """
    other = (plane + tap) & 1
    return other * (half + 2 * pad) + pad + (plane - 3 * tap - other) // 2 - plane * half


@wide
def blur_along(
    pieces: Places,
    first: int,
    weights: Levels,
    number: int,
    level: Levels,
    pad: int,
    total: Levels,
) -> None:
    """Blur pieces along the row; see :func:`blur_taps` and :func:`blur_down`."""
    half = len(total) // 2
    for t in range(0, number, TAPS):
        each = weights[t * PIECE : (t + TAPS) * PIECE]
        rest, old = np.uint16(number // 2 if t == 0 else 0), np.uint16(0 if t == 0 else ONE - 1)
        # Of the taps at even places, from the farthest on, and of those at odd ones, in either plane.
        even0, odd0 = place_of(0, first + t + 4, pad, half), place_of(0, first + t + 5, pad, half)
        even1, odd1 = place_of(1, first + t + 4, pad, half), place_of(1, first + t + 5, pad, half)
        for k in range(len(pieces)):
            start, same = max(PIECE * pieces[k], 0), max(pieces[k] >> NEVER, 0)
            a = max(start + (even0 if start < half else even1), 0)
            b = max(start + (odd0 if start < half else odd1), 0)
            for i in range(PIECE):
                j = same + i
                light = np.uint16(np.uint16(total[start + i] & old) + rest)
                one = np.uint16((np.uint32(level[a + 6 + i]) * np.uint32(each[j])) >> 16)
                two = np.uint16((np.uint32(level[b + 6 + i]) * np.uint32(each[PIECE + j])) >> 16)
                light = np.uint16(light + np.uint16(one + two))
                one = np.uint16((np.uint32(level[a + 3 + i]) * np.uint32(each[2 * PIECE + j])) >> 16)
                two = np.uint16((np.uint32(level[b + 3 + i]) * np.uint32(each[3 * PIECE + j])) >> 16)
                light = np.uint16(light + np.uint16(one + two))
                one = np.uint16((np.uint32(level[a + i]) * np.uint32(each[4 * PIECE + j])) >> 16)
                two = np.uint16((np.uint32(level[b + i]) * np.uint32(each[5 * PIECE + j])) >> 16)
                total[start + i] = np.uint16(light + np.uint16(one + two))
