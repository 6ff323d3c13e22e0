"""The kernel that paints a sheet (:mod:`swarmvision.rendering.sheet`): its sides, and the blocks between."""

from __future__ import annotations

import math

import numpy as np

from swarmvision.compiled import inner, leaf
from swarmvision.geometry import FloatArray
from swarmvision.rendering.blocks import dip, paint_block, span_edges
from swarmvision.rendering.ink import HALF, ZERO, power
from swarmvision.rendering.sheet import (
    FAR,
    GLOW,
    LANES,
    NEAR,
    RISE,
    SHADE,
    SPLIT,
    Image,
    Pixels,
    Places,
    Singles,
    room,
)
from swarmvision.rendering.sides import paint_side


@leaf
def paint_sheet(
    image: Image,
    window: Places,
    first: int,
    left: float,
    right: float,
    bands: int,
    lid: int,
    carrier: int,
    flat: bool,
    middle: float,
    colours: FloatArray,
    pigments: Singles,
    plan: Singles,
    profile: Singles,
    rows: Singles,
    lights: Singles,
    inks: Image,
    pixels: Pixels,
    spans: Places,
) -> None:
    """Paint a sheet.

    Args:
        image: sRGB, ``(h, 3 w)``.
        window: First row that may be painted, and the row behind the last.
        first: Column of the picture where the sheet begins.
        left: Where the object begins (px), in that column; before it nothing is covered.
        right: And where it ends.
        bands: How many.
        lid: 1 where the first edge is of the far side, and its band of the first colour as the next, else 0.
        carrier: The first of the three bands that carry the pattern; -1 for none.
        flat: Whether columns with the same shade at both ends of a block have it in between.
        middle: The horizon (px).
        colours: Linear light of the bands, ``(bands - lid, 3)``.
        pigments: The same as pigments, see :mod:`swarmvision.rendering.ink`, ``(bands - lid, 3, 3)``.
        plan: For each edge its height above the lens (m); for each band what its shade is, ``base + gain *
            profile[SHADE]``.
        profile: At each border of the columns f / depth of the near side and of the far one; of each column
            the shade, a power of it and the share of its first part; each a row, and the last number
            ``LANES`` times more. The power is filled in.
        rows: Of each edge the row in the first part of each column, and in the second; those of the pattern
            are known, the others are filled in.
        lights: Scratch, light of what is under a block and of its bands.
        inks: Scratch, sRGB of the bands, and one row more.
        pixels: Scratch, a row of a block.
        spans: Scratch, for each edge the rows that it crosses.
    """
    horizon = np.float32(middle)
    columns = math.ceil(right) - first
    begin = 1 if left > first else 0
    end = columns - 1 if right < first + columns else columns
    for i in range(room(columns)):
        profile[GLOW, i] = power(profile[SHADE, i])
    _trace(columns, bands, lid, carrier, horizon, plan, profile, rows)
    # The two columns at the silhouette, which may be one.
    for side in range(2):
        column = 0 if side == 0 else columns - 1
        if (side == 0 and begin == 1) or (side == 1 and end < columns and (begin == 0 or columns > 1)):
            cover = min(right, first + column + 1.0) - max(left, float(first + column))
            paint_side(
                image, window, first, column, cover, bands, lid, colours, plan, profile, rows, lights, spans
            )
    alike, before = False, ZERO
    for block in range(begin, end, LANES):
        o, count = max(block, 0), min(end - block, LANES)
        # A block of one shade looks as the one before it, if that is of the same.
        shade = profile[SHADE, o]
        even = flat and shade == profile[SHADE, o + LANES - 1]
        if not (even and alike and shade == before):
            dip(o, bands, lid, colours, pigments, plan, profile, lights, inks, pixels)
        alike, before = even, shade
        span_edges(o, bands, lid, carrier, horizon, window, plan, profile, rows, spans)
        paint_block(
            image, max(3 * (first + block), 0), count, o, bands, profile, rows, lights, inks, pixels, spans
        )


@inner
def _trace(
    columns: int,
    bands: int,
    lid: int,
    carrier: int,
    horizon: np.float32,
    plan: Singles,
    profile: Singles,
    rows: Singles,
) -> None:
    """Fill in the rows of all edges but the pattern's."""
    for e in range(bands + 1):
        if carrier < 0 or e <= carrier or e > carrier + 2:
            source, rise = FAR if e == 0 and lid == 1 else NEAR, plan[RISE, e]
            for i in range(room(columns) - 1):
                here = profile[source, i]
                step = (profile[source, i + 1] - here) * HALF
                part = here + step * profile[SPLIT, i]
                rows[2 * e, i] = horizon - rise * part
                rows[2 * e + 1, i] = horizon - rise * (part + step)
