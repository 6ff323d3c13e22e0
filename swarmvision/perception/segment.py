"""Pixels into the marker's colours, whatever the light.

A picture is decoded to linear light, divided by the colour of its own bright and pale pixels (the
white of walls, floor and markers), and told apart by the direction of its chroma only. There are no
thresholds of hue or brightness to tune: a colour is compared with the marker's own colours.

Nothing is computed per pixel. What a code of one channel means under the picture's white is a table
of 256 entries; the three steps that a pixel falls into are an address in a table of classes that the
marker alone decides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision.colour import decode
from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker

DECODE = decode(np.arange(256))
SAME_HUE = 0.85  # cosine of the largest angle between a pixel's chroma and its colour's
FADED = 0.38  # least chroma of a pixel, as a fraction of the printed colour's
DARK = 0.06  # brightest channel of a coloured pixel, as a fraction of the picture's white
PALE = 0.12  # largest chroma of a pixel that may tell the white
COLOURFUL = 0.10  # least chroma of a printed colour that hue can tell
LEVELS = 32  # steps of one channel in the table of classes
BRIGHTEST = 1.5  # of white: light at and above which is the last step
SAMPLES = 32  # about so many pixels of one row, and of one column, that tell the white
LEAST_PALE = 16  # pixels; fewer tell no white


@dataclass(frozen=True, eq=False, slots=True)
class Hues:
    """The marker's coloured bands as directions of chroma."""

    chroma: FloatArray
    """Chroma of each known colour, shape ``(colours, 3)``; sums to 0."""
    names: tuple[tuple[int, int, int], ...]
    """Their sRGB, in the same order."""
    classes: NDArray[np.uint8]
    """Class of every address: 0 for none, else 1 + the number of the colour, ``(LEVELS ** 3,)``."""

    @classmethod
    def of(cls, marker: Marker) -> Hues:
        """Return the hues of a marker's bands and pattern; greys are left out."""
        colours = [band.colour for band in marker.bands]
        if marker.patterned is not None and marker.patterned.pattern is not None:
            colours.append(marker.patterned.pattern.colour)
        distinct = tuple(dict.fromkeys(c for c in colours if np.linalg.norm(chroma_of(c)) >= COLOURFUL))
        chroma = np.array([chroma_of(c) for c in distinct]).reshape(-1, 3)
        step = (np.arange(LEVELS) + 0.5) / LEVELS
        light = BRIGHTEST * step * step
        cube = np.stack(np.meshgrid(light, light, light, indexing="ij"), axis=-1).reshape(-1, 3)
        return cls(chroma, distinct, classify(cube, chroma))

    def number(self, colour: tuple[int, int, int]) -> int | None:
        """Return the class of a colour, counted from 1; None for a grey."""
        return self.names.index(colour) + 1 if colour in self.names else None


@dataclass(frozen=True, eq=False, slots=True)
class Balance:
    """What the codes of one picture mean under its own white."""

    white: FloatArray
    """Linear light of what is white, ``(3,)``."""
    light: FloatArray
    """Linear light of every code of every channel, of white, ``(3, 256)``."""
    address: NDArray[np.uint16]
    """What every code of every channel adds to the address in the table of classes, ``(3, 256)``."""

    @classmethod
    def of(cls, image: NDArray[np.uint8]) -> Balance:
        """Return the balance of a picture ``(h, w, 3)``."""
        white, light, address = np.empty(3), np.empty((3, 256)), np.empty((3, 256), np.uint16)
        sample_white(image, DECODE, white, *white_scratch())
        weigh_codes(DECODE, white, light, address)
        return cls(white, light, address)


def white_scratch() -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """Return room for the samples of the white and for counts of their codes."""
    return np.empty((4 * SAMPLES * SAMPLES, 5), np.uint8), np.empty((4, 256), np.int64)


def chroma_of(colour: tuple[int, int, int]) -> FloatArray:
    """Return the share of each channel in a colour's linear light, less a third: 0 for grey, ``(3,)``."""
    light = decode(colour)
    share: FloatArray = light / light.sum() - 1.0 / 3.0
    return share


def classify(light: FloatArray, chroma: FloatArray) -> NDArray[np.uint8]:
    """Return the class of balanced linear light ``(..., 3)``: 0 for none, else 1 + the index of its hue."""
    total = light.sum(axis=-1)
    share = light / np.maximum(total, 1e-6)[..., None] - 1.0 / 3.0
    strength = np.linalg.norm(share, axis=-1)
    classes = np.zeros(total.shape, dtype=np.uint8)
    best = SAME_HUE * strength
    for i, direction in enumerate(chroma):
        size = float(np.linalg.norm(direction))
        along = share @ direction / size
        mine = (along > best) & (strength > FADED * size) & (light.max(axis=-1) > DARK)
        classes[mine] = i + 1
        best = np.where(mine, along, best)
    return classes


@leaf
def weigh_codes(
    decode: FloatArray, white: FloatArray, light: FloatArray, address: NDArray[np.uint16]
) -> None:
    """Write light and address of every code under a white; see :class:`Balance`."""
    place = LEVELS * LEVELS
    for channel in range(3):
        scale = 1.0 / white[channel]
        for code in range(256):
            value = decode[code] * scale
            light[channel, code] = value
            step = int(min(math.sqrt(value * (LEVELS * LEVELS / BRIGHTEST)), LEVELS - 1.0))
            address[channel, code] = step * place
        place //= LEVELS


@leaf
def sample_white(
    image: NDArray[np.uint8],
    decode: FloatArray,
    white: FloatArray,
    samples: NDArray[np.uint8],
    counts: NDArray[np.int64],
) -> None:
    """Write the light ``(3,)`` of what is white in a picture: the brighter of its bright, pale pixels.

    A picture without any pale pixel is taken as lit by its own brightest. ``samples`` (red, green, blue,
    grey, whether pale) and ``counts`` are room to work in, see :func:`white_scratch`.
    """
    down = max(image.shape[0] // SAMPLES, 1)
    across = max(image.shape[1] // SAMPLES, 1)
    counts[:] = 0
    taken = 0
    for v in range(down // 2, image.shape[0], down):
        for u in range(across // 2, image.shape[1], across):
            for channel in range(3):
                samples[taken, channel] = image[v, u, channel]
            grey = (int(image[v, u, 0]) + 2 * int(image[v, u, 1]) + int(image[v, u, 2])) >> 2
            samples[taken, 3] = grey
            counts[3, grey] += 1
            taken += 1
    bright = _quantile(counts[3], 0.5)
    for i in range(taken):
        if samples[i, 3] >= bright:
            for channel in range(3):
                counts[channel, samples[i, channel]] += 1
    red = 1.0 / max(decode[_quantile(counts[0], 0.5)], 1e-6)
    green = 1.0 / max(decode[_quantile(counts[1], 0.5)], 1e-6)
    blue = 1.0 / max(decode[_quantile(counts[2], 0.5)], 1e-6)
    counts[3, :] = 0
    pale = 0
    for i in range(taken):
        samples[i, 4] = 0
        if samples[i, 3] >= bright and _is_pale(
            red * decode[samples[i, 0]], green * decode[samples[i, 1]], blue * decode[samples[i, 2]]
        ):
            samples[i, 4] = 1
            counts[3, samples[i, 3]] += 1
            pale += 1
    least = _quantile(counts[3], 0.75) if pale >= LEAST_PALE else bright
    white[:] = 0.0
    used = 0
    for i in range(taken):
        if samples[i, 3] >= least and (pale < LEAST_PALE or samples[i, 4] == 1):
            used += 1
            for channel in range(3):
                white[channel] += decode[samples[i, channel]]
    for channel in range(3):
        white[channel] = max(white[channel] / max(used, 1), 1e-5)


@leaf
def _is_pale(red: float, green: float, blue: float) -> bool:
    total = max(red + green + blue, 1e-6)
    third = total / 3.0
    off = (red - third) ** 2 + (green - third) ** 2 + (blue - third) ** 2
    pale: bool = off < (PALE * total) ** 2
    return pale


@leaf
def _quantile(counts: NDArray[np.int64], share: float) -> int:
    """Return the first code at which a histogram has passed a share of its total."""
    total = 0
    for code in range(256):
        total += counts[code]
    wanted = share * total
    passed = 0
    for code in range(256):
        passed += counts[code]
        if passed > wanted:
            return code
    return 255
