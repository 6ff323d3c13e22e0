"""Which pixels of a picture a fit looks at: those of one marker, on a grid of their own."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray
from swarmvision.perception.edges import Reading
from swarmvision.perception.model import Skin

FINE = 36.0  # px between the inner edges: a nearer marker is averaged down to about this
INSIDE = 1.5  # px from the marker's outline, within which light from beside it may fall
LEAST_INSIDE = 12  # pixels that may tell whether it is like a marker; with fewer all are asked
LEAST_PIXELS = 30  # for 12 parameters and the colours
PARTS, NARROW = 3, 16.0  # in a marker narrower than so many px a column is worked out in so many parts


@dataclass(frozen=True, eq=False, slots=True)
class Patch:
    """The pixels of one marker: a grid for the model, and which of its places are fitted."""

    columns: FloatArray
    """Of every place of the grid (px), ``(n,)``, column by column."""
    rows: FloatArray
    values: FloatArray
    """Balanced linear light of those that are fitted, ``(3, kept)``."""
    inside: NDArray[np.bool_]
    """Which of those surely show the marker and nothing beside it, ``(kept,)``."""
    kept: NDArray[np.int64]
    """Their places in the grid."""
    step: int
    """Picture pixels in one of the grid, each way."""
    high: int
    """Places in one column of the grid."""
    parts: int
    """Columns of the grid in one of the pixels that are fitted."""


def tangents(lens: Lens, skin: Skin, distance: float, bearing: float) -> tuple[float, float]:
    """Return the columns (px) between which a marker stands."""
    half = math.asin(min(skin.radius / distance, 0.999))
    limit = math.pi / 2.0 - 1e-3
    left, right = min(bearing + half, limit), max(bearing - half, -limit)
    centre = lens.centre_px[0]
    return centre - lens.focal_px * math.tan(left), centre - lens.focal_px * math.tan(right)


def cut_out(
    image: NDArray[np.uint8],
    light: FloatArray,
    lens: Lens,
    skin: Skin,
    start: Reading,
    hidden: NDArray[np.bool_],
    smear: float,
) -> Patch | None:
    """Return the pixels that show the marker or, above the horizon, what is beside it."""
    focal, (centre_u, centre_v) = lens.focal_px, lens.centre_px
    left, right = tangents(lens, skin, start.range, start.bearing)
    depth = (start.range - skin.radius) * math.cos(start.bearing)
    step = max(1, round(focal * skin.inner / depth / FINE))
    margin = 3 + step + math.ceil(smear / 2.0)
    horizon = centre_v + start.drop
    top = horizon - focal * (skin.top - lens.height) / depth
    foot = horizon - focal * (skin.base - lens.height) / depth
    first_u, last_u = max(math.floor(left) - margin, 0), min(math.ceil(right) + margin, lens.width_px)
    first_v, last_v = max(math.floor(top) - 3 - step, 0), min(math.ceil(foot), lens.height_px)
    wide, high = (last_u - first_u) // step, (last_v - first_v) // step
    if wide < 3 or high < 4:
        return None
    values = np.empty((3, wide, high))
    gather(image, light, first_u, first_v, step, wide, high, values)
    columns, rows, places = np.empty(wide * high), np.empty(wide * high), np.empty(wide * high, np.int64)
    picked, inside = np.empty((3, wide * high)), np.empty(wide * high, dtype=bool)
    soft = 2.5 + 0.5 * step
    count, owned = choose(
        np.array([focal, centre_u, lens.height]),
        np.array([start.range, start.bearing, skin.radius, skin.base]),
        np.array([left, right, top, horizon]),
        soft,
        soft + smear / 2.0,
        INSIDE + 0.5 * step + smear / 2.0,
        first_u,
        first_v,
        step,
        math.ceil(smear / 2.0),
        hidden,
        values,
        columns,
        rows,
        places,
        picked,
        inside,
    )
    if count < LEAST_PIXELS:
        return None
    columns, rows, places, picked, inside = (
        columns[:count],
        rows[:count],
        places[:count],
        picked[:, :count],
        inside[:count],
    )
    if owned < LEAST_INSIDE:
        inside[:] = True
    parts = PARTS if right - left < NARROW and smear < NARROW / 3.0 else 1
    if smear <= 0.0 and parts == 1:
        return Patch(columns, rows, picked, inside, np.arange(count), step, high, 1)
    # The model needs columns from which light is smeared in, too.
    more = math.ceil(0.75 * smear / step) + 2
    u = first_u + (np.arange(-more * parts, (wide + more) * parts, dtype=np.float64) + 0.5) * step / parts
    v = first_v + (np.arange(high, dtype=np.float64) + 0.5) * step
    i, j = places // high, places % high
    places = ((i + more) * parts + parts // 2) * high + j
    return Patch(np.repeat(u, high), np.tile(v, len(u)), picked, inside, places, step, high, parts)


@compiled
def choose(
    view: FloatArray,
    marker: FloatArray,
    outline: FloatArray,
    soft: float,
    side: float,
    within: float,
    first_u: int,
    first_v: int,
    step: int,
    spread: int,
    hidden: NDArray[np.bool_],
    values: FloatArray,
    columns: FloatArray,
    rows: FloatArray,
    places: NDArray[np.int64],
    picked: FloatArray,
    inside: NDArray[np.bool_],
) -> tuple[int, int]:
    """Write the places of a grid that show the marker or, above the horizon, what is beside it.

    Args:
        view: Focal length and principal column (px), height of the lens (m).
        marker: Range (m) and bearing (rad) of its axis, radius and base (m).
        outline: Tangents' columns, row of the top edge and of the horizon (px).
        soft: So far above the bottom edge (px) places still show it.
        side: So near a tangent (px) they show what is beside it.
        within: So far from the outline (px) they surely show nothing else.
        first_u: First column of the picture in the grid.
        first_v: First row.
        step: Picture pixels in one of the grid, each way.
        spread: So many columns to either side shine in.
        hidden: Columns of the picture that show something else, ``(w,)``.
        values: Light of the grid, ``(3, wide, high)``.
        columns: Out: of the places (px), column by column, ``(n,)``.
        rows: Out: of the places (px).
        places: Out: which they are in the grid.
        picked: Out: their light, ``(3, n)``.
        inside: Out: which surely show the marker.

    Returns:
        How many places, and how many of them are inside.
    """
    left, right, top, horizon = outline[0], outline[1], outline[2], outline[3]
    distance, radius = marker[0], marker[2]
    cos, sin = math.cos(marker[1]), math.sin(marker[1])
    inset, high, last = 0.03 * (right - left), values.shape[2], len(hidden) - 1
    count = owned = 0
    for i in range(values.shape[1]):
        begin = first_u + i * step
        dark = False
        for u in range(begin - spread, begin + step + spread):
            dark = dark or hidden[min(max(u, 0), last)]
        if dark:
            continue
        column = first_u + (i + 0.5) * step
        m = (view[1] - min(max(column, left + inset), right - inset)) / view[0]
        a, b = 1.0 + m * m, distance * (cos + m * sin)
        x = (b - math.sqrt(max(b * b - a * (distance * distance - radius * radius), 0.0))) / a
        lowest = horizon - view[0] * (marker[3] - view[2]) / x - soft
        if column < left + side or column > right - side:
            lowest = min(lowest, horizon - 1.0)
        for j in range(high):
            row = first_v + (j + 0.5) * step
            if row >= lowest:
                break
            columns[count], rows[count], places[count] = column, row, i * high + j
            for channel in range(3):
                picked[channel, count] = values[channel, i, j]
            inside[count] = left + within < column < right - within and row > top + within
            owned += inside[count]
            count += 1
    return count, owned


@compiled
def gather(
    image: NDArray[np.uint8],
    light: FloatArray,
    left: int,
    top: int,
    step: int,
    columns: int,
    rows: int,
    out: FloatArray,
) -> None:
    """Average ``step`` x ``step`` pixels in balanced linear light into ``out``, ``(3, columns, rows)``."""
    share = 1.0 / (step * step)
    out[:] = 0.0
    for j in range(rows * step):
        for i in range(columns * step):
            v, u = top + j, left + i
            for channel in range(3):
                out[channel, i // step, j // step] += share * light[channel, image[v, u, channel]]
