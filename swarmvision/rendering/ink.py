"""The curve of sRGB and its inverse in kernels; light is in [0, 1], codes in [0, 255].

Above its knee the curve is a power, ``PEAK light^(5/12) - FOOT``, so a colour in any shade is its own part of
that, its *pigment*, times the shade's (:func:`power`), to 1/500 of a level. What an edge mixes takes
:func:`rough_code_of` and :func:`rough_light_of`, short polynomials of ours, of the root of light and of the
code over 255, with the least largest error (Chebyshev).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray

Singles = NDArray[np.float32]

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
UNIT = np.float32(1.0 / 255.0)
PEAK, FOOT = 255.0 * 1.055, 255.0 * 0.055
LEAST_CODE, LAST_CODE = HALF, np.float32(255.5)
KNEE = 0.0031308  # light, and where the curve begins to be no line
# x^(5/12) for x in [0.003, 1], to 0.13 %.
P0, P1, P2 = np.float32(0.012277046259818654), np.float32(1.481786638133378), np.float32(-1.6241129448202127)
P3, P4, P5 = np.float32(2.721746650646547), np.float32(-2.447455076499545), np.float32(0.8570161251339767)
FOURTH, FOURFOLD = np.float32(0.25), np.float32(4.0 ** (5.0 / 12.0))
LOW = np.float32(0.003)
TWELFTH = np.float32(1.0 / 12.0)
# 0.2 levels above code 10, 2 below it; negative below the darkest light.
RH, R1, R2 = (
    np.float32(-9.508768502662855 + 0.5),
    np.float32(370.0886436020652),
    np.float32(-244.01805181007737),
)
R3, R4 = np.float32(219.00794830199746), np.float32(-80.76842450368588)
DARKEST = np.float32(0.0007)
# 0.05 levels above code 10, 3 below it.
L0, L1 = np.float32(0.001040239732934941), np.float32(0.028518893084894567)
L2, L3, L4 = np.float32(0.5598036942819783), np.float32(0.5274679519933029), np.float32(-0.11729499207711794)


@leaf
def power(x: np.float32) -> np.float32:
    """Return x^(5/12) to 1e-5 of it, for x in [0.012, 4]."""
    y = max(LOW, x * FOURTH)
    root = np.sqrt(y)
    # Not Horner's scheme, whose steps wait for each other.
    u = (P0 + P1 * root) + y * ((P2 + P3 * root) + y * (P4 + P5 * root))
    u4 = (u * u) * (u * u)
    # Newton's step for u^12 = y^5.
    u -= u * (ONE - (y * y) * (y * y) * y / (u4 * u4 * u4)) * TWELFTH
    result: np.float32 = u * FOURFOLD
    return result


@leaf
def code_of(pigment: Singles, tone: np.float32, glow: np.float32) -> np.int32:
    """Return sRGB, rounded, of a colour in a shade; 2 levels off where a shade makes it darker than code 10.

    Args:
        pigment: Of the colour, see :func:`pigments`.
        tone: The shade.
        glow: Its :func:`power`.
    """
    return np.int32(
        min(LAST_CODE, max(LEAST_CODE, pigment[0] * glow + pigment[1] * tone + (HALF - pigment[2])))
    )


@leaf
def rough_code_of(light: np.float32) -> np.int32:
    """Return sRGB, rounded, of light from about ``DARKEST`` to 1."""
    root = np.sqrt(light)
    return np.int32((RH + R1 * root) + light * ((R2 + R3 * root) + light * R4))


@leaf
def rough_light_of(code: np.uint8) -> np.float32:
    """Return light in [``DARKEST``, 1] of sRGB."""
    x = np.float32(code) * UNIT
    square = x * x
    return (L0 + L1 * x) + square * ((L2 + L3 * x) + square * L4)


@leaf
def pixel_of(red: np.int32, green: np.int32, blue: np.int32) -> np.int32:
    """Return three codes in one number."""
    return np.int32(red | (green << np.int32(8)) | (blue << np.int32(16)))


def pigments(light: FloatArray) -> Singles:
    """Return how light becomes a code: times a power of the shade, times the shade, less, ``(..., 3)``."""
    dark = light <= KNEE
    power_of = np.where(dark, 0.0, PEAK * np.asarray(light) ** (5.0 / 12.0))
    line = np.where(dark, 255.0 * 12.92 * np.asarray(light), 0.0)
    return np.stack([power_of, line, np.where(dark, 0.0, FOOT)], axis=-1).astype(np.float32)
