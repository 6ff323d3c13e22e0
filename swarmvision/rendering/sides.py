"""The kernel that paints a column which a solid's silhouette crosses, and which it covers in part."""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import inner
from swarmvision.geometry import FloatArray
from swarmvision.rendering.ink import DARKEST, ONE, pixel_of, rough_code_of, rough_light_of
from swarmvision.rendering.sheet import (
    BASE,
    GAIN,
    SHADE,
    Image,
    Places,
    Singles,
    note_span,
    share_below,
)


@inner
def paint_side(
    image: Image,
    window: Places,
    first: int,
    column: int,
    covered: float,
    bands: int,
    lid: int,
    colours: FloatArray,
    plan: Singles,
    profile: Singles,
    rows: Singles,
    lights: Singles,
    spans: Places,
) -> None:
    """Paint a column of which a share is covered."""
    cover, x, at = np.float32(covered), max(3 * (first + column), 0), max(column, 0)
    rest = ONE - cover
    for k in range(bands + 1):
        one, two = rows[2 * k, at], rows[2 * k + 1, at]
        note_span(spans, k, min(one, two), max(one, two), window)
        if k < bands:
            tone = plan[BASE, k] + plan[GAIN, k] * profile[SHADE, at]
            for c in range(3):
                lights[k + 1, c, 0] = max(DARKEST, min(np.float32(colours[max(k - lid, 0), c]) * tone, ONE))
    y = max(spans[0, 0], 0)
    for k in range(bands + 1):
        while y < spans[k, 1]:
            under0, under1, under2 = (
                rough_light_of(image[y, x]),
                rough_light_of(image[y, x + 1]),
                rough_light_of(image[y, x + 2]),
            )
            lights[0, 0, 0], lights[0, 1, 0], lights[0, 2, 0] = under0, under1, under2
            red, green, blue = lights[k, 0, 0], lights[k, 1, 0], lights[k, 2, 0]
            bottom = np.float32(y + 1)
            j = k
            while j <= bands and (j == k or spans[j, 0] <= y):
                part = share_below(profile, rows, j, at, bottom)
                under = j + 1 if j < bands else 0
                red += part * (lights[under, 0, 0] - lights[j, 0, 0])
                green += part * (lights[under, 1, 0] - lights[j, 1, 0])
                blue += part * (lights[under, 2, 0] - lights[j, 2, 0])
                j += 1
            image[y, x] = np.uint8(rough_code_of(max(cover * red + rest * under0, DARKEST)))
            image[y, x + 1] = np.uint8(rough_code_of(max(cover * green + rest * under1, DARKEST)))
            image[y, x + 2] = np.uint8(rough_code_of(max(cover * blue + rest * under2, DARKEST)))
            y += 1
        if k < bands and y < spans[k + 1, 0]:
            own0, own1, own2 = (
                cover * lights[k + 1, 0, 0],
                cover * lights[k + 1, 1, 0],
                cover * lights[k + 1, 2, 0],
            )
            # What is as above is painted as above.
            seen = pixel_of(np.int32(-1), np.int32(0), np.int32(0))
            red8 = green8 = blue8 = np.uint8(0)
            while y < spans[k + 1, 0]:
                here = pixel_of(np.int32(image[y, x]), np.int32(image[y, x + 1]), np.int32(image[y, x + 2]))
                if here != seen:
                    seen = here
                    red8 = np.uint8(rough_code_of(own0 + rest * rough_light_of(image[y, x])))
                    green8 = np.uint8(rough_code_of(own1 + rest * rough_light_of(image[y, x + 1])))
                    blue8 = np.uint8(rough_code_of(own2 + rest * rough_light_of(image[y, x + 2])))
                image[y, x], image[y, x + 1], image[y, x + 2] = red8, green8, blue8
                y += 1
