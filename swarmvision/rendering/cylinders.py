"""Kernels that cut an upright cylinder by a camera's columns, see :mod:`swarmvision.rendering.columns`."""

from __future__ import annotations

import math

import numpy as np

from swarmvision.compiled import inner, leaf
from swarmvision.geometry import FloatArray
from swarmvision.rendering.columns import FAR_ROW, LEAST, NEAREST, shade
from swarmvision.rendering.ink import HALF, ONE, ZERO
from swarmvision.rendering.sheet import BASE, FAR, GAIN, NEAR, RISE, SHADE, SPLIT, Singles, room

NARROW = np.float32(NEAREST)
# M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 1964, 4.4.45: 7e-5 rad, which moves the
# stripe of a helix by less than 1/1000 px.
QUARTER = np.float32(math.pi / 2.0)
ARC0, ARC1 = np.float32(1.5707288), np.float32(-0.2121144)
ARC2, ARC3 = np.float32(0.0742610), np.float32(-0.0187293)


@leaf
def circle_reach(view: FloatArray, x: float, y: float, radius: float) -> tuple[float, float]:
    """Return the columns (px) of the tangents to a circle in the lens frame; empty when it is behind.

    A tangent's slope ``s`` solves ``(y - s x)^2 = R^2 (1 + s^2)``.
    """
    if x <= -radius:
        return 0.0, 0.0
    under = x * x + y * y - radius * radius
    if under <= 0.0:  # the lens is inside
        return -FAR_ROW, FAR_ROW
    root = radius * math.sqrt(under)
    across = x * x - radius * radius
    if x > radius and across > 0.0:
        return view[1] - view[0] * (x * y + root) / across, view[1] - view[0] * (x * y - root) / across
    # The lens plane cuts it: to one side it goes on for ever.
    if y > 0.0:
        other = (y * y - radius * radius) / (x * y + root)
        return -FAR_ROW, view[1] - view[0] * other
    other = (y * y - radius * radius) / (x * y - root)
    return view[1] - view[0] * other, FAR_ROW


@leaf
def circle_hit(view: FloatArray, solid: FloatArray, column: float) -> float:
    """Return the depth (m) of an upright cylinder's near side along a column (px)."""
    slope = (view[1] - column) / view[0]
    a = 1.0 + slope * slope
    b = solid[0] + slope * solid[1]
    under = b * b - a * (solid[0] * solid[0] + solid[1] * solid[1] - solid[3] * solid[3])
    depth: float = (b - math.sqrt(max(under, 0.0))) / a
    return depth


@leaf
def cylinder_sheet(
    view: FloatArray,
    light: FloatArray,
    solid: FloatArray,
    heights: FloatArray,
    bands: int,
    patterned: int,
    knots: FloatArray,
    left: float,
    right: float,
    azimuths: Singles,
    profile: Singles,
    plan: Singles,
    rows: Singles,
) -> int:
    """Fill in an upright cylinder; return the bands: a lid, if seen, and those of its side.

    In a frame along the ray the circle's middle is at ``(t, p)``; the normal where the ray meets it is
    ``(-sqrt(R^2 - p^2), -p) / R``, so its azimuth is the ray's plus ``pi + asin(p / R)``.

    Args:
        view: See above.
        light: See above.
        solid: x, y, yaw in the lens frame, radius.
        heights: Of the band edges above the ground from the top down (m), one more than bands.
        bands: How many, not counting what a pattern adds.
        patterned: Which band carries the pattern, and becomes three; -1 for none.
        knots: Of the pattern, heights above the ground.
        left: Where the part of it begins that is in the picture (px).
        right: And where it ends.
        azimuths: Scratch, of the normal at each border (rad).
        profile: Out, for the columns from ``floor(left)`` to ``ceil(right)``.
        plan: Out.
        rows: Out: those of the edges of the pattern.
    """
    first = math.floor(left)
    columns = math.ceil(right) - first
    lid = 1 if view[3] > heights[0] else 0
    _cut_cylinder(view, light, solid, first, columns, left, right, profile)
    k = 0
    for j in range(lid + bands + 1):
        band = max(j - lid, 0)
        plan[RISE, k], plan[BASE, k], plan[GAIN, k] = np.float32(heights[band] - view[3]), ZERO, ONE
        k += 1
        if j - lid == patterned and patterned >= 0:
            for _ in range(2):
                plan[RISE, k], plan[BASE, k], plan[GAIN, k] = ZERO, ZERO, ONE
                k += 1
    if lid:
        plan[BASE, 0], plan[GAIN, 0] = np.float32(shade(light, 0.0, 0.0, 1.0)), ZERO
    if patterned >= 0:
        _wind(view, solid, first, columns, left, right, azimuths, profile)
        _draw_pattern(view, knots, columns, 2 * (lid + patterned + 1), azimuths, profile, rows)
    return k - 1


@inner
def _cut_cylinder(
    view: FloatArray,
    light: FloatArray,
    solid: FloatArray,
    first: int,
    columns: int,
    left: float,
    right: float,
    profile: Singles,
) -> None:
    """Fill in the profile of a cylinder, with halves for the shares."""
    x, y, radius = np.float32(solid[0]), np.float32(solid[1]), np.float32(solid[3])
    centre, focal, inverse = np.float32(view[1]), np.float32(view[0]), np.float32(1.0 / view[0])
    start, end = np.float32(left), np.float32(right)
    ambient, diffuse = np.float32(light[0]), np.float32(light[1] / solid[3])
    ahead, aside = np.float32(light[2]), np.float32(light[3])
    for i in range(room(columns)):
        slope = (centre - min(end, max(start, np.float32(first + i)))) * inverse
        scale = ONE / np.sqrt(ONE + slope * slope)
        t = (x + slope * y) * scale
        p = min(radius, max(-radius, (y - slope * x) * scale))
        root = np.sqrt(radius * radius - p * p)
        profile[NEAR, i] = focal / max(NARROW, (t - root) * scale)
        profile[FAR, i] = focal / max(NARROW, (t + root) * scale)
        towards = -ahead * (root - slope * p) - aside * (slope * root + p)
        profile[SHADE, i] = ambient + diffuse * max(ZERO, towards * scale)
        profile[SPLIT, i] = HALF
    for i in range(columns):
        profile[SHADE, i] = HALF * (profile[SHADE, i] + profile[SHADE, i + 1])


@inner
def _wind(
    view: FloatArray,
    solid: FloatArray,
    first: int,
    columns: int,
    left: float,
    right: float,
    azimuths: Singles,
    profile: Singles,
) -> None:
    """Fill in the azimuth of a cylinder's normal at each border."""
    x, y, per_radius = np.float32(solid[0]), np.float32(solid[1]), np.float32(1.0 / solid[3])
    centre, inverse = np.float32(view[1]), np.float32(1.0 / view[0])
    start, end, turn = np.float32(left), np.float32(right), np.float32(math.pi - solid[2])
    for i in range(room(columns)):
        slope = (centre - min(end, max(start, np.float32(first + i)))) * inverse
        scale = ONE / np.sqrt(ONE + slope * slope)
        p = min(ONE, max(-ONE, (y - slope * x) * scale * per_radius))
        azimuths[i] = turn + arcsine(p) + arcsine(slope * scale)


@inner
def _draw_pattern(
    view: FloatArray,
    knots: FloatArray,
    columns: int,
    upper: int,
    azimuths: Singles,
    profile: Singles,
    rows: Singles,
) -> None:
    """Fill in the rows of a pattern's two edges, run by run of columns that show one of its pieces."""
    pieces, horizon, height = len(knots) - 1, np.float32(view[2]), np.float32(view[3])
    i = 0
    while i < columns:
        piece = piece_of(knots, azimuths[i])
        knot = np.float32(2.0 * math.pi * (piece // pieces) + knots[piece % pieces + 1, 0])
        stop = i
        while stop < columns and azimuths[stop + 1] <= knot:
            stop += 1
        low0, high0 = piece_edges(knots, piece, azimuths[i])
        low1, high1 = piece_edges(knots, piece, float(knot))
        width = max(knot - azimuths[i], np.float32(LEAST))
        begin, low, high = azimuths[i], np.float32(low0), np.float32(high0)
        low_slope, high_slope = np.float32(low1 - low0) / width, np.float32(high1 - high0) / width
        for side in range(2):
            middle = np.float32(0.25 + 0.5 * side)
            for j in range(i, stop):
                along = azimuths[j] + middle * (azimuths[j + 1] - azimuths[j]) - begin
                scale = profile[NEAR, j] + middle * (profile[NEAR, j + 1] - profile[NEAR, j])
                rows[upper + side, j] = horizon - (high + high_slope * along - height) * scale
                rows[upper + 2 + side, j] = horizon - (low + low_slope * along - height) * scale
        if stop < columns:  # where one piece ends and the next begins
            here, step = azimuths[stop], azimuths[stop + 1] - azimuths[stop]
            part = min(ONE, max(ZERO, (knot - here) / step)) if step > ZERO else HALF
            profile[SPLIT, stop] = part
            for side in range(2):
                middle = HALF * (part + np.float32(side))
                azimuth = here + middle * step
                low2, high2 = piece_edges(knots, piece_of(knots, azimuth), azimuth)
                scale = profile[NEAR, stop] + middle * (profile[NEAR, stop + 1] - profile[NEAR, stop])
                rows[upper + side, stop] = horizon - (np.float32(high2) - height) * scale
                rows[upper + 2 + side, stop] = horizon - (np.float32(low2) - height) * scale
        i = stop + 1
    for k in range(upper, upper + 4):
        for i in range(columns, room(columns)):
            rows[k, i] = rows[k, columns - 1]


@leaf
def piece_of(knots: FloatArray, azimuth: float) -> int:
    """Return which straight piece of a pattern is at an azimuth (rad); whole turns count on."""
    turn = 2.0 * math.pi
    turns = math.floor(azimuth / turn)
    phi = azimuth - turn * turns
    i = len(knots) - 2
    while i > 0 and knots[i, 0] > phi:
        i -= 1
    return int(turns * (len(knots) - 1) + i)


@leaf
def piece_edges(knots: FloatArray, piece: int, azimuth: float) -> tuple[float, float]:
    """Return low and high edge (m) of a pattern, on one of its pieces, which may be drawn out."""
    turns, i = piece // (len(knots) - 1), piece % (len(knots) - 1)
    phi = azimuth - 2.0 * math.pi * turns
    width = max(knots[i + 1, 0] - knots[i, 0], 1e-12)
    share = min(max((phi - knots[i, 0]) / width, 0.0), 1.0)
    low = knots[i, 1] + share * (knots[i + 1, 1] - knots[i, 1])
    high = knots[i, 2] + share * (knots[i + 1, 2] - knots[i, 2])
    return low, high


@leaf
def arcsine(x: np.float32) -> np.float32:
    """Return the arc sine, to 7e-5 rad and the same to the bit on every machine."""
    a = min(ONE, abs(x))
    angle: np.float32 = QUARTER - np.sqrt(ONE - a) * ((ARC0 + ARC1 * a) + a * a * (ARC2 + ARC3 * a))
    return angle if x >= ZERO else -angle
