"""How long a picture's horizontal motion blur is, by the sides of its markers."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray
from swarmvision.perception.edges import Reading
from swarmvision.perception.model import Skin

SMEARED = 4.5  # px: a motion blur shorter than this is left to the even blur
LONGEST_SMEAR = 40.0  # px


def smear_of(
    image: NDArray[np.uint8], light: FloatArray, lens: Lens, skin: Skin, found: list[Reading]
) -> float:
    """Return the length (px) of a picture's horizontal motion blur by its markers' sides; 0 for a short one.

    A step that is smeared over L px climbs by its height over L per px.
    """
    lengths = []
    for reading in found:
        depth = (reading.range - skin.radius) * math.cos(reading.bearing)
        horizon = lens.centre_px[1] + reading.drop
        top, under = (
            horizon - lens.focal_px * (height - lens.height) / depth for height in (skin.top, skin.heights[0])
        )
        inset = 0.3 * (under - top)
        first, last = math.ceil(top + inset), max(int(under - inset), math.ceil(top + inset) + 1)
        reach = int(min(0.45 * (reading.right - reading.left), 24.0))
        if first < 0 or last > lens.height_px or reach < 5:
            continue
        for side in (reading.left, reading.right):
            begin = math.floor(side) - reach
            if begin < 0 or begin + 2 * reach > lens.width_px:
                continue
            length = climb(image, light, begin, reach, first, last)
            if length > 0.0:
                lengths.append(length)
    length = float(np.median(lengths)) if lengths else 0.0
    return min(length, LONGEST_SMEAR) if length >= SMEARED else 0.0


@compiled
def climb(
    image: NDArray[np.uint8], light: FloatArray, begin: int, reach: int, first: int, last: int
) -> float:
    """Return over how many columns the light climbs at a marker's side; 0 where nothing stands out.

    Args:
        image: sRGB, ``(h, w, 3)``.
        light: Balanced linear light of every code of every channel, ``(3, 256)``.
        begin: First of the columns, ``2 reach`` of them.
        reach: Half of them.
        first: First row.
        last: Row behind the last.
    """
    profile, contrast = np.zeros((3, 2 * reach)), np.zeros(3)
    few, share, size = max(reach // 3, 2), 1.0 / (last - first), 0.0
    for channel in range(3):
        for i in range(2 * reach):
            for v in range(first, last):
                profile[channel, i] += share * light[channel, image[v, begin + i, channel]]
        for i in range(few):
            contrast[channel] += (profile[channel, 2 * reach - 1 - i] - profile[channel, i]) / few
        size += contrast[channel] * contrast[channel]
    if size <= 0.01:
        return 0.0
    steepest = 1e-3
    for i in range(2 * reach - 2):
        steep = 0.0
        for channel in range(3):
            steep += contrast[channel] * (profile[channel, i + 2] - profile[channel, i])
        steepest = max(steepest, steep / (2.0 * size))
    return 1.0 / steepest
