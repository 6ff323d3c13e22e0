"""The sRGB curve by arithmetic on 16 bits, which processors do 32 at a time; a table is asked one by one.

The curve's numbers travel as an array, for with numbers that it knows the compiler reckons in 64 bits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import wide

Words = NDArray[np.int16]
Levels = NDArray[np.uint16]
Places = NDArray[np.int64]

FINE = 64  # steps of one code
PIECE = 32  # numbers that are worked on together
OFFSET = 898  # FINE * 255 * 0.055: where the power law has its zero
NEVER = (
    40  # a piece's number shifted by that is 0, which the compiler does not know, so it keeps what does not
)
# change where it is used, and there it sees that it has 16 bits
TOE, TOE_CODE = 256, 11 << 8  # light (1/65536) and code (1/256) below which the curve is a line
GAMMA = 2.4  # of the power law
DARKEST = (0.04045 + 0.055) / 1.055  # of w, see CURVE
W_ZERO = 3416  # 65535 * 0.055 / 1.055
ROOT_ONE = 8189  # of w^0.4, so that eight times it, and a bit for what is cut, fits into 16 bits


def _curve() -> Levels:
    """Return the numbers of :func:`encode` and :func:`decode`, each as often as a piece is long.

    To encode: the sizes of a polynomial that is the power law from a quarter of the light to all of it, 0.07
    codes off at most; the signs of its square and fourth power are negative. What it is multiplied with for a
    quarter and a sixteenth of the light, and the line below the toe.

    To decode: a code's step in ``w``, which is the code from the power law's zero on, over the whole; the
    sizes of a polynomial that is ``w^0.4``, 0.07 codes off at most, with signs that alternate from the second
    on; the line below the toe; and where the codes begin in ``w``.
    """
    nodes = np.cos(np.pi * (np.arange(64) + 0.5) / 64.0)
    light, w = (5.0 + 3.0 * nodes) / 8.0, (1.0 + DARKEST + (1.0 - DARKEST) * nodes) / 2.0
    fit = np.polynomial.polynomial.polyfit
    power = fit(light, FINE * 255.0 * 1.055 * light ** (1.0 / GAMMA), 4)
    shares = 65536.0 * np.array([4.0, 16.0]) ** (-1.0 / GAMMA)
    root = fit(w, ROOT_ONE * w ** (GAMMA - 2.0), 5, w=w ** (GAMMA - 2.0))
    numbers = [*np.abs(power), *shares, FINE * 255.0 * 12.92 / 256.0]
    numbers += [65535.0 / 1.055 / 255.0 * 256.0, *np.abs(root), 65536.0 / 12.92, W_ZERO]
    return np.repeat(np.rint(numbers).astype(np.uint16), PIECE)


CURVE = _curve()


@wide
def decode(pieces: Places, codes: Levels, curve: Levels, out: Levels) -> None:
    """Decode pieces of a row, true to 0.1 codes.

    The power law is ``w^2 w^0.4``, for the square keeps dark codes apart where a polynomial would not.

    Args:
        pieces: Which.
        codes: sRGB, two a word, that of the even place below; half as many as ``out``.
        curve: ``CURVE``.
        out: Linear light (1/65536), in planes.
    """
    half = len(codes)
    for k in range(len(pieces)):
        start, same = max(PIECE * pieces[k], 0), max(pieces[k] >> NEVER, 0)
        word, up = max(start if start < half else start - half, 0), np.uint16(8 if start < half else 0)
        for i in range(PIECE):
            j = same + i
            code = np.uint16(np.uint16(codes[word + i] << up) & np.uint16(0xFF00))
            w = np.uint16((np.uint32(code) * np.uint32(curve[8 * PIECE + j])) >> 16)
            w = np.uint16(w + curve[16 * PIECE + j])
            square = np.uint16((np.uint32(w) * np.uint32(w)) >> 16)
            value = np.uint16((np.uint32(w) * np.uint32(curve[14 * PIECE + j])) >> 16)
            value = np.uint16(curve[13 * PIECE + j] - value)
            value = np.uint16(curve[12 * PIECE + j] - np.uint16((np.uint32(w) * np.uint32(value)) >> 16))
            value = np.uint16(curve[11 * PIECE + j] - np.uint16((np.uint32(w) * np.uint32(value)) >> 16))
            value = np.uint16(curve[10 * PIECE + j] - np.uint16((np.uint32(w) * np.uint32(value)) >> 16))
            value = np.uint16(curve[9 * PIECE + j] + np.uint16((np.uint32(w) * np.uint32(value)) >> 16))
            value = min(value, np.uint16(ROOT_ONE))
            value = np.uint16(np.uint16(value << np.uint16(3)) + np.uint16(16))
            slope = curve[15 * PIECE + j]
            toe = code < np.uint16(TOE_CODE)
            one, two = code if toe else square, slope if toe else value
            out[start + i] = np.uint16((np.uint32(one) * np.uint32(two)) >> 16)


@wide
def encode(pieces: Places, light: Levels, curve: Levels, out: Words) -> None:
    """Encode pieces of a row, to the nearest quarter of a code; true to 0.2 codes without that.

    Light is brought into the uppermost of its quarters, where the power law is nearly a polynomial. Quarters
    take up what that is off, and what light is that was summed up of products cut to 16 bits, so that even
    pixels keep their code however they were blurred.

    Args:
        pieces: Which.
        light: Linear (1/65536).
        curve: ``CURVE``.
        out: sRGB codes (1/64).
    """
    for k in range(len(pieces)):
        start, same = max(PIECE * pieces[k], 0), max(pieces[k] >> NEVER, 0)
        for i in range(PIECE):
            j, level = same + i, light[start + i]
            dark = level < np.uint16(4096)
            x = np.uint16(level << np.uint16(4)) if dark else level
            dim = x < np.uint16(16384)
            x = np.uint16(x << np.uint16(2)) if dim else x
            value = np.uint16(
                curve[3 * PIECE + j] - np.uint16((np.uint32(x) * np.uint32(curve[4 * PIECE + j])) >> 16)
            )
            value = np.uint16(curve[2 * PIECE + j] - np.uint16((np.uint32(x) * np.uint32(value)) >> 16))
            value = np.uint16(curve[PIECE + j] - np.uint16((np.uint32(x) * np.uint32(value)) >> 16))
            value = np.uint16(curve[j] + np.uint16((np.uint32(x) * np.uint32(value)) >> 16))
            less = np.uint16((np.uint32(value) * np.uint32(curve[5 * PIECE + j])) >> 16)
            value = less if dim else value
            less = np.uint16((np.uint32(value) * np.uint32(curve[6 * PIECE + j])) >> 16)
            value = less if dark else value
            line = np.uint16(
                (np.uint32(np.uint16(level << np.uint16(8))) * np.uint32(curve[7 * PIECE + j])) >> 16
            )
            code = line if level < np.uint16(TOE) else np.uint16(value - np.uint16(OFFSET))
            out[start + i] = np.int16(np.uint16(code + np.uint16(FINE // 8)) & np.uint16(65536 - FINE // 4))
