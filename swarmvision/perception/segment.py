"""Pixels into the marker's colours, whatever the light.

The picture is decoded to linear light, divided by the colour of its own bright and pale pixels (the
white of walls, floor and markers), and told apart by the direction of its chroma only. There are no
thresholds of hue or brightness to tune: a colour is compared with the marker's own colours.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.colour import decode
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker

Light = NDArray[np.float32]

DECODE = decode(np.arange(256)).astype(np.float32)
SAME_HUE = 0.85  # cosine of the largest angle between a pixel's chroma and its colour's
FADED = 0.38  # least chroma of a pixel, as a fraction of the printed colour's
DARK = 0.06  # brightest channel of a coloured pixel, as a fraction of the picture's white
PALE = 0.12  # largest chroma of a pixel that may tell the white
WHITE_PERCENTILE = 90.0  # of brightness: what counts as the picture's bright part
COLOURFUL = 0.10  # least chroma of a printed colour that hue can tell


@dataclass(frozen=True, eq=False, slots=True)
class Hues:
    """The marker's coloured bands as directions of chroma."""

    chroma: FloatArray
    """Chroma of each known colour, shape ``(colours, 3)``; sums to 0."""
    names: tuple[tuple[int, int, int], ...]
    """Their sRGB, in the same order."""

    @classmethod
    def of(cls, marker: Marker) -> Hues:
        """Return the hues of a marker's bands and pattern; greys are left out."""
        colours = [band.colour for band in marker.bands]
        if marker.patterned is not None and marker.patterned.pattern is not None:
            colours.append(marker.patterned.pattern.colour)
        distinct = tuple(dict.fromkeys(c for c in colours if np.linalg.norm(chroma_of(c)) >= COLOURFUL))
        return cls(np.array([chroma_of(c) for c in distinct]).reshape(-1, 3), distinct)

    def number(self, colour: tuple[int, int, int]) -> int | None:
        """Return the class of a colour, counted from 1; None for a grey."""
        return self.names.index(colour) + 1 if colour in self.names else None


def chroma_of(colour: tuple[int, int, int]) -> FloatArray:
    """Return the share of each channel in a colour's linear light, less a third: 0 for grey, ``(3,)``."""
    light = decode(colour)
    share: FloatArray = light / light.sum() - 1.0 / 3.0
    return share


def linear(image: NDArray[np.uint8]) -> Light:
    """Return the picture in linear light, shape ``(h, w, 3)``."""
    light: Light = cv2.LUT(np.ascontiguousarray(image), DECODE)
    return light.reshape(image.shape)


def white_of(light: Light) -> Light:
    """Return the light ``(3,)`` of what is white in the picture: its bright and pale pixels.

    A picture without any pale pixel is taken as lit by its own brightest.
    """
    pixels = light.reshape(-1, 3)[:: max(light.shape[0] * light.shape[1] // 8192, 1)]
    total = pixels.sum(axis=1)
    bright = pixels[total >= np.percentile(total, 50.0)]
    middle = np.median(bright, axis=0)
    balanced = bright / np.maximum(middle, 1e-6)
    share = balanced / np.maximum(balanced.sum(axis=1, keepdims=True), 1e-6) - 1.0 / 3.0
    pale = bright[np.linalg.norm(share, axis=1) < PALE]
    chosen = pale if len(pale) >= 16 else bright
    level = np.percentile(chosen.sum(axis=1), WHITE_PERCENTILE) / max(float(chosen.mean(axis=0).sum()), 1e-6)
    white: Light = np.maximum(np.median(chosen, axis=0) * level, 1e-5).astype(np.float32)
    return white


def classify(light: Light, white: Light, hues: Hues) -> NDArray[np.uint8]:
    """Return the class of every pixel: 0 for none, else 1 + the index of its hue, shape ``(h, w)``."""
    # Channel by channel: whole-picture passes over one channel are what NumPy does fastest.
    red, green, blue = (np.ascontiguousarray(light[..., c]) / white[c] for c in range(3))
    total = red + green + blue
    bright = np.maximum(np.maximum(red, green), blue) > DARK
    scale = 1.0 / np.maximum(total, 1e-6)
    third = np.float32(1.0 / 3.0)
    red, green, blue = red * scale - third, green * scale - third, blue * scale - third
    strength = np.sqrt(red * red + green * green + blue * blue)
    classes = np.zeros(total.shape, dtype=np.uint8)
    best = np.float32(SAME_HUE) * strength
    for i, chroma in enumerate(hues.chroma.astype(np.float32)):
        size = np.float32(np.linalg.norm(chroma))
        along = (red * chroma[0] + green * chroma[1] + blue * chroma[2]) / size
        mine = (along > best) & (strength > FADED * size) & bright
        classes[mine] = i + 1
        best = np.where(mine, along, best)
    return classes
