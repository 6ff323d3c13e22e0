"""Colours: the sRGB transfer curve and the names that a marker file may use.

Light adds up linearly; pictures store it encoded (IEC 61966-2-1). A renderer that blends and an
estimator that integrates edges both do so in linear light, hence both need this one curve.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import ArrayLike, NDArray

from swarmvision.errors import ConfigError, unknown_name

NAMED: dict[str, tuple[int, int, int]] = {
    "red": (190, 38, 42),
    "blue": (30, 62, 150),
    "yellow": (226, 190, 32),
    "white": (228, 228, 224),
    "black": (32, 32, 34),
    "green": (36, 134, 68),
    "orange": (222, 112, 28),
    "purple": (104, 50, 134),
}
"""sRGB (8 bit) of matt print in even light; measured colours come from calibration, as ``#rrggbb``."""


def rgb(colour: str) -> tuple[int, int, int]:
    """Return the sRGB triple (8 bit) of a colour's name or of ``#rrggbb``.

    Raises:
        ConfigError: If the name is unknown or the code is malformed.
    """
    if re.fullmatch(r"#[0-9a-fA-F]{6}", colour):
        return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
    if colour not in NAMED:
        raise ConfigError(unknown_name("colour", colour, NAMED) + ", or '#rrggbb'")
    return NAMED[colour]


def decode(encoded: ArrayLike) -> NDArray[np.float64]:
    """Return linear light in [0, 1] of sRGB values in 0..255."""
    value = np.asarray(encoded, dtype=np.float64) / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def encode(light: ArrayLike) -> NDArray[np.float64]:
    """Return sRGB values in 0..255 (not rounded) of linear light; light is clipped to [0, 1]."""
    value = np.clip(np.asarray(light, dtype=np.float64), 0.0, 1.0)
    curve = np.where(value <= 0.0031308, value * 12.92, 1.055 * value ** (1 / 2.4) - 0.055)
    return 255.0 * curve
