"""Kernels of the ray caster: one column of one solid as spans of constant light, and their painting.

A column of a level camera is one vertical plane. Where it cuts a solid, the solid is a stack of
spans; each is cut by a few *sub-columns*, so that slanted edges, silhouettes and the seam of a
pattern are anti-aliased exactly along the rows and by sub-columns across. Light is mixed linearly
and encoded by table when it is stored.

Spans of a column: ``edges`` ``(SUB, spans + 1)`` rows from the top down, ``lights`` ``(SUB, spans, 3)``.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray

Image = NDArray[np.uint8]
SUB = 4  # sub-columns of one column
SPANS = 40  # most spans of one solid: 16 bands, one of them cut in three, and a lid
NEAREST = 1e-3  # m; surfaces nearer than this to the lens plane are drawn as if there
FAR_ROW = 1e6  # px; rows beyond are clipped, so that they stay whole numbers
CODES = 16384  # steps of the table from light to sRGB: 0.2 grey levels where it is steepest


@compiled
def shade(light: FloatArray, x: float, y: float, z: float) -> float:
    """Return Lambert's factor for a unit normal; ``light`` is ambient, diffuse and the lamp's direction."""
    towards = light[2] * x + light[3] * y + light[4] * z
    factor: float = light[0] + light[1] * max(towards, 0.0)
    return factor


@compiled
def row_of(view: FloatArray, height: float, depth: float) -> float:
    """Return the row (px) of a height (m) at a depth (m); ``view`` as in :func:`cylinder_spans`."""
    row: float = view[2] - view[0] * (height - view[3]) / max(depth, NEAREST)
    return min(max(row, -FAR_ROW), FAR_ROW)


@compiled
def pattern_span(knots: FloatArray, azimuth: float) -> tuple[float, float]:
    """Return low and high edge (m) of a pattern; the compiled twin of ``Pattern.span``."""
    turn = 2.0 * math.pi
    phi = azimuth - turn * math.floor(azimuth / turn)
    i = len(knots) - 2
    while i > 0 and knots[i, 0] > phi:
        i -= 1
    width = max(knots[i + 1, 0] - knots[i, 0], 1e-12)
    share = (phi - knots[i, 0]) / width
    low = knots[i, 1] + share * (knots[i + 1, 1] - knots[i, 1])
    high = knots[i, 2] + share * (knots[i + 1, 2] - knots[i, 2])
    return low, high


@compiled
def cylinder_reach(view: FloatArray, x: float, y: float, radius: float) -> tuple[float, float]:
    """Return the columns (px) of the tangents to a circle in the lens frame; empty when it is behind."""
    distance = math.hypot(x, y)
    if distance <= radius or x <= 0.0:
        return 0.0, 0.0
    bearing, half = math.atan2(y, x), math.asin(radius / distance)
    limit = math.pi / 2.0 - 1e-3
    left, right = min(bearing + half, limit), max(bearing - half, -limit)
    if left <= right:
        return 0.0, 0.0
    return view[1] - view[0] * math.tan(left), view[1] - view[0] * math.tan(right)


@compiled
def cylinder_spans(
    view: FloatArray,
    light: FloatArray,
    solid: FloatArray,
    heights: FloatArray,
    colours: FloatArray,
    knots: FloatArray,
    patterned: int,
    reach: tuple[float, float],
    column: int,
    edges: FloatArray,
    lights: FloatArray,
) -> tuple[int, int, float]:
    """Cut an upright cylinder by one column.

    Args:
        view: Focal, principal column and row (px), lens height (m).
        light: See :func:`shade`, in the lens frame.
        solid: x, y, yaw in the lens frame, radius.
        heights: Of the band edges above the ground from the top down (m), one more than bands.
        colours: Linear light of the bands, then of the pattern, ``(bands + 1, 3)``.
        knots: Of the pattern, heights above the ground.
        patterned: Which band carries the pattern; -1 for none.
        reach: From :func:`cylinder_reach`.
        column: Which.
        edges: Out.
        lights: Out.

    Returns:
        Spans, sub-columns that hit, and the fraction of the column's width that the solid covers.
    """
    start, end = max(float(column), reach[0]), min(column + 1.0, reach[1])
    if end <= start:
        return 0, 0, 0.0
    bands = len(heights) - 1
    lid = 1 if view[3] > heights[0] else 0
    spans = bands + lid + (2 if patterned >= 0 else 0)
    hits = 0
    for sub in range(SUB):
        u = start + (end - start) * (sub + 0.5) / SUB
        slope = (view[1] - u) / view[0]
        a = 1.0 + slope * slope
        b = solid[0] + slope * solid[1]
        under = b * b - a * (solid[0] * solid[0] + solid[1] * solid[1] - solid[3] * solid[3])
        root = math.sqrt(max(under, 0.0))
        near, far = (b - root) / a, (b + root) / a
        if near <= 0.0:
            continue
        normal_x, normal_y = (near - solid[0]) / solid[3], (slope * near - solid[1]) / solid[3]
        factor = shade(light, normal_x, normal_y, 0.0)
        k = 0
        edges[hits, 0] = row_of(view, heights[0], far if lid else near)
        if lid:
            top = shade(light, 0.0, 0.0, 1.0)
            for channel in range(3):
                lights[hits, 0, channel] = colours[0, channel] * top
            edges[hits, 1] = row_of(view, heights[0], near)
            k = 1
        for band in range(bands):
            if band == patterned:
                azimuth = math.atan2(normal_y, normal_x) - solid[2]
                low, high = pattern_span(knots, azimuth)
                edges[hits, k + 1] = row_of(view, high, near)
                edges[hits, k + 2] = row_of(view, low, near)
                for channel in range(3):
                    lights[hits, k, channel] = colours[band, channel] * factor
                    lights[hits, k + 1, channel] = colours[bands, channel] * factor
                k += 2
            for channel in range(3):
                lights[hits, k, channel] = colours[band, channel] * factor
            edges[hits, k + 1] = row_of(view, heights[band + 1], near)
            k += 1
        hits += 1
    return spans, hits, (end - start) * hits / SUB


@compiled
def box_reach(view: FloatArray, box: FloatArray) -> tuple[float, float]:
    """Return the columns (px) that a box can touch; box is x, y, yaw, half length, half width, height."""
    cos, sin = math.cos(box[2]), math.sin(box[2])
    left, right = FAR_ROW, -FAR_ROW
    behind = 0
    for i in range(4):
        dx = box[3] if i < 2 else -box[3]
        dy = box[4] if i % 2 == 0 else -box[4]
        x, y = box[0] + cos * dx - sin * dy, box[1] + sin * dx + cos * dy
        if x <= NEAREST:
            behind += 1
            continue
        u = view[1] - view[0] * y / x
        left, right = min(left, u), max(right, u)
    if behind == 4:
        return 0.0, 0.0
    if behind > 0:  # the picture's plane cuts it: any column may meet it
        return -FAR_ROW, FAR_ROW
    return left, right


@compiled
def box_hit(view: FloatArray, box: FloatArray, column: float) -> tuple[float, float, float, float]:
    """Return near and far depth (m) of a box along a column (px), and the near face's normal in its frame."""
    slope = (view[1] - column) / view[0]
    cos, sin = math.cos(box[2]), math.sin(box[2])
    near, far = -1e30, 1e30
    face_x, face_y = 0.0, 0.0
    for axis in range(2):
        # The lens and the ray's step in the box's frame.
        origin = -cos * box[0] - sin * box[1] if axis == 0 else sin * box[0] - cos * box[1]
        step = cos + sin * slope if axis == 0 else -sin + cos * slope
        half = box[3] if axis == 0 else box[4]
        if abs(step) < 1e-12:
            step = 1e-12
        one, two = (-half - origin) / step, (half - origin) / step
        side = -1.0
        if one > two:
            one, two = two, one
            side = 1.0
        if one > near:
            near = one
            face_x, face_y = (side, 0.0) if axis == 0 else (0.0, side)
        far = min(far, two)
    return near, far, face_x, face_y


@compiled
def box_spans(
    view: FloatArray,
    light: FloatArray,
    box: FloatArray,
    colour: FloatArray,
    reach: tuple[float, float],
    column: int,
    edges: FloatArray,
    lights: FloatArray,
) -> tuple[int, int, float]:
    """Cut a box that stands on the ground by one column: its lid, if seen, over the face that is hit."""
    start, end = max(float(column), reach[0]), min(column + 1.0, reach[1])
    if end <= start:
        return 0, 0, 0.0
    cos, sin = math.cos(box[2]), math.sin(box[2])
    lid = 1 if view[3] > box[5] else 0
    top = shade(light, 0.0, 0.0, 1.0)
    hits = 0
    for sub in range(SUB):
        u = start + (end - start) * (sub + 0.5) / SUB
        near, far, face_x, face_y = box_hit(view, box, u)
        if near >= far or far <= NEAREST:
            continue
        near = max(near, NEAREST)
        factor = shade(light, cos * face_x - sin * face_y, sin * face_x + cos * face_y, 0.0)
        edges[hits, 0] = row_of(view, box[5], far if lid else near)
        edges[hits, lid] = row_of(view, box[5], near)
        edges[hits, lid + 1] = row_of(view, 0.0, near)
        for channel in range(3):
            lights[hits, 0, channel] = colour[channel] * top
            lights[hits, lid, channel] = colour[channel] * factor
        hits += 1
    return 1 + lid, hits, (end - start) * hits / SUB


@compiled
def paint(
    image: Image,
    column: int,
    spans: int,
    hits: int,
    cover: float,
    edges: FloatArray,
    lights: FloatArray,
    decode: NDArray[np.float32],
    encode: Image,
) -> None:
    """Lay the spans of one column over what is there already."""
    height = image.shape[0]
    top, bottom = edges[0, 0], edges[0, spans]
    for sub in range(1, hits):
        top, bottom = min(top, edges[sub, 0]), max(bottom, edges[sub, spans])
    first = max(math.floor(top), 0)
    last = min(math.ceil(bottom), height)
    row = first
    for k in range(spans):
        begin, end = edges[0, k], edges[0, k + 1]
        for sub in range(1, hits):
            begin, end = max(begin, edges[sub, k]), min(end, edges[sub, k + 1])
        inner = min(max(math.ceil(begin), row), last)
        outer = min(math.floor(end), last)
        if outer <= inner:
            continue
        _mix(image, column, row, inner, spans, hits, cover, edges, lights, decode, encode)
        for channel in range(3):
            value = 0.0
            for sub in range(hits):
                value += lights[sub, k, channel]
            value *= cover / hits
            if cover >= 1.0:
                code = encode[_code(value)]
                for i in range(inner, outer):
                    image[i, column, channel] = code
            else:
                for i in range(inner, outer):
                    behind = decode[image[i, column, channel]] * (1.0 - cover)
                    image[i, column, channel] = encode[_code(value + behind)]
        row = outer
    _mix(image, column, row, last, spans, hits, cover, edges, lights, decode, encode)


@compiled
def _code(light: float) -> int:
    return int(min(max(light, 0.0), 1.0) * (CODES - 1) + 0.5)


@compiled
def _mix(
    image: Image,
    column: int,
    first: int,
    last: int,
    spans: int,
    hits: int,
    cover: float,
    edges: FloatArray,
    lights: FloatArray,
    decode: NDArray[np.float32],
    encode: Image,
) -> None:
    """Paint rows that some edge crosses: every sub-column's spans by their share of the row."""
    for row in range(first, last):
        red = green = blue = covered = 0.0
        for sub in range(hits):
            for k in range(spans):
                share = min(edges[sub, k + 1], row + 1.0) - max(edges[sub, k], float(row))
                if share > 0.0:
                    red += share * lights[sub, k, 0]
                    green += share * lights[sub, k, 1]
                    blue += share * lights[sub, k, 2]
                    covered += share
        weight = cover / hits
        behind = 1.0 - covered * weight
        image[row, column, 0] = encode[_code(red * weight + behind * decode[image[row, column, 0]])]
        image[row, column, 1] = encode[_code(green * weight + behind * decode[image[row, column, 1]])]
        image[row, column, 2] = encode[_code(blue * weight + behind * decode[image[row, column, 2]])]
