"""Kernels that cut solids by the columns of a level camera: where edges cross the borders of columns.

Seen along a border of a column, a vertical plane, an upright solid is a stack of bands. Each kernel
fills in rows and shades of a sheet (see :mod:`swarmvision.rendering.painting`) for the columns that its
solid reaches. Functions that take arrays call none that loop: each such call would count references,
atomically, and threads that share the stage would wait for each other.

``view`` is focal length, principal column and row (px), lens height (m). ``light`` is ambient, diffuse
and the lamp's direction in the lens frame, see :class:`swarmvision.rendering.appearance.Light`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray

Image = NDArray[np.uint8]
NEAREST = 1e-3  # m; surfaces nearer than this to the lens plane are drawn as if there
FAR_ROW = 1e6  # px; beyond every picture
NEAR, AZIMUTH, SHADE = 0, 1, 2  # what is kept of each border of a column
BORDERS = 3  # numbers
PIECES = 16  # most pieces of a pattern that are told apart in one column
LEAST = 1e-12  # of a step that is divided by
# M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 1964, 4.4.46: 2e-8 rad.
ARC = (1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046,
       0.0308918810, -0.0170881256, 0.0066700901, -0.0012624911)  # fmt: skip


@compiled
def shade(light: FloatArray, x: float, y: float, z: float) -> float:
    """Return Lambert's factor for a unit normal."""
    towards = light[2] * x + light[3] * y + light[4] * z
    factor: float = light[0] + light[1] * max(towards, 0.0)
    return factor


@compiled
def arcsine(x: float) -> float:
    """Return the arc sine, to 2e-8 rad and the same to the bit on every machine."""
    a = min(abs(x), 1.0)
    value = ARC[7]
    for i in range(6, -1, -1):
        value = value * a + ARC[i]
    angle = math.pi / 2.0 - math.sqrt(1.0 - a) * value
    return angle if x >= 0.0 else -angle


@compiled
def piece_of(knots: FloatArray, azimuth: float) -> int:
    """Return which straight piece of a pattern is at an azimuth (rad); whole turns count on."""
    turn = 2.0 * math.pi
    turns = math.floor(azimuth / turn)
    phi = azimuth - turn * turns
    i = len(knots) - 2
    while i > 0 and knots[i, 0] > phi:
        i -= 1
    return int(turns * (len(knots) - 1) + i)


@compiled
def piece_edges(knots: FloatArray, piece: int, azimuth: float) -> tuple[float, float]:
    """Return low and high edge (m) of a pattern, on one of its pieces, which may be drawn out."""
    turns, i = piece // (len(knots) - 1), piece % (len(knots) - 1)
    phi = azimuth - 2.0 * math.pi * turns
    width = max(knots[i + 1, 0] - knots[i, 0], 1e-12)
    share = min(max((phi - knots[i, 0]) / width, 0.0), 1.0)
    low = knots[i, 1] + share * (knots[i + 1, 1] - knots[i, 1])
    high = knots[i, 2] + share * (knots[i + 1, 2] - knots[i, 2])
    return low, high


@compiled
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


@compiled
def box_reach(view: FloatArray, box: FloatArray) -> tuple[float, float]:
    """Return the columns (px) of a box's silhouette; box is x, y, yaw, half length, half width."""
    left, right = FAR_ROW, -FAR_ROW
    for i in range(4):
        x, y = _corner(box, i)
        if x > NEAREST:
            u = view[1] - view[0] * y / x
            left, right = min(left, u), max(right, u)
        next_x, next_y = _corner(box, (i + 1) % 4)
        if (x > NEAREST) != (next_x > NEAREST):  # the lens plane cuts this side
            y += (NEAREST - x) / (next_x - x) * (next_y - y)
            u = view[1] - view[0] * y / NEAREST
            left, right = min(left, u), max(right, u)
    if left > right:
        return 0.0, 0.0
    return left, right


@compiled
def _corner(box: FloatArray, i: int) -> tuple[float, float]:
    """Return a corner of a box, counter-clockwise from the front left one."""
    dx = box[3] if i in (0, 3) else -box[3]
    dy = box[4] if i < 2 else -box[4]
    cos, sin = math.cos(box[2]), math.sin(box[2])
    return box[0] + cos * dx - sin * dy, box[1] + sin * dx + cos * dy


@compiled
def box_hit(view: FloatArray, box: FloatArray, column: float) -> tuple[float, float]:
    """Return near and far depth (m) of a box along a column (px)."""
    slope = (view[1] - column) / view[0]
    cos, sin = math.cos(box[2]), math.sin(box[2])
    # The lens and the ray's step in the box's frame.
    step_x, step_y = cos + sin * slope, -sin + cos * slope
    inverse_x = 1.0 / (step_x if abs(step_x) > LEAST else LEAST)
    inverse_y = 1.0 / (step_y if abs(step_y) > LEAST else LEAST)
    middle_x, middle_y = (cos * box[0] + sin * box[1]) * inverse_x, (cos * box[1] - sin * box[0]) * inverse_y
    half_x, half_y = box[3] * abs(inverse_x), box[4] * abs(inverse_y)
    return max(middle_x - half_x, middle_y - half_y), min(middle_x + half_x, middle_y + half_y)


@compiled
def circle_hit(view: FloatArray, solid: FloatArray, column: float) -> float:
    """Return the depth (m) of an upright cylinder's near side along a column (px)."""
    slope = (view[1] - column) / view[0]
    a = 1.0 + slope * slope
    b = solid[0] + slope * solid[1]
    under = b * b - a * (solid[0] * solid[0] + solid[1] * solid[1] - solid[3] * solid[3])
    depth: float = (b - math.sqrt(max(under, 0.0))) / a
    return depth


@compiled
def box_sheet(
    view: FloatArray,
    light: FloatArray,
    box: FloatArray,
    height: float,
    inside: bool,
    left: float,
    right: float,
    rows: FloatArray,
    shades: FloatArray,
) -> int:
    """Fill in a box that stands on the ground; return the bands.

    From outside these are its lid, if seen, and its faces; from inside what is beyond, faces, floor.

    Args:
        view: See above.
        light: See above.
        box: x, y, yaw in the lens frame, half length, half width.
        height: m.
        inside: Whether the lens is inside, and the box is the court.
        left: Where the part of it begins that is in the picture (px).
        right: And where it ends.
        rows: Out, for the columns from ``floor(left)`` to ``ceil(right)``.
        shades: Out.
    """
    first = math.floor(left)
    columns = math.ceil(right) - first
    lid = 1 if inside or view[3] > height else 0
    rise = height - view[3]
    if inside:
        _court_rows(view, box, rise, left, right, rows)
    for i in range(0 if inside else columns + 1):
        near, far = box_hit(view, box, min(max(float(first + i), left), right))
        near = min(near, far)
        rows[0, i] = view[2] - rise * view[0] / max(far, NEAREST)
        scale = view[0] / max(near, NEAREST)
        rows[lid, i] = view[2] - rise * scale
        rows[lid + 1, i] = view[2] + view[3] * scale
    top = 1.0 if inside else shade(light, 0.0, 0.0, 1.0)
    for i in range(columns):
        shades[lid, i] = 0.0
    if lid:
        for i in range(columns):
            shades[0, i] = top
    if inside:
        for i in range(columns):
            shades[2, i] = 1.0
    # Face by face, from corner to corner; a column where two meet has its share of both.
    begin = left
    while begin < right:
        end = right
        for i in range(4):
            x, y = _corner(box, i)
            u = view[1] - view[0] * y / x if x > NEAREST else right
            if begin + 1e-9 < u < end:
                end = u
        factor = _face_shade(view, light, box, inside, 0.5 * (begin + end))
        for i in range(math.floor(begin) - first, math.ceil(end) - first):
            wide = min(right, first + i + 1.0) - max(left, float(first + i))
            shades[lid, i] += factor * (min(end, first + i + 1.0) - max(begin, float(first + i))) / wide
        begin = end
    return 3 if inside else 1 + lid


@compiled
def _court_rows(
    view: FloatArray, box: FloatArray, rise: float, left: float, right: float, rows: FloatArray
) -> None:
    """Fill in the rows of a box seen from inside; one over the depth of each wall is linear in the column."""
    cos, sin = math.cos(box[2]), math.sin(box[2])
    x, y = cos * box[0] + sin * box[1], cos * box[1] - sin * box[0]
    ahead, behind = _one_over(x + box[3]), _one_over(x - box[3])
    beside, across = _one_over(y + box[4]), _one_over(y - box[4])
    centre, focal, middle = view[1], view[0], view[2]
    up, down, most, first = rise * focal, view[3] * focal, 1.0 / NEAREST, math.floor(left)
    for i in range(math.ceil(right) - first + 1):
        slope = (centre - min(max(float(first + i), left), right)) / focal
        step_x, step_y = cos + sin * slope, cos * slope - sin
        leave_x = step_x * (ahead if step_x > 0.0 else behind)
        leave_y = step_y * (beside if step_y > 0.0 else across)
        inverse = min(max(leave_x, leave_y, LEAST), most)
        rows[0, i] = -FAR_ROW
        rows[1, i] = middle - up * inverse
        rows[2, i] = middle + down * inverse
        rows[3, i] = FAR_ROW


@compiled
def _one_over(x: float) -> float:
    return 1.0 / (x if abs(x) > LEAST else LEAST)


@compiled
def _face_shade(view: FloatArray, light: FloatArray, box: FloatArray, inside: bool, column: float) -> float:
    """Return the shade of the face that a column (px) meets; seen from inside it is the far one's."""
    slope = (view[1] - column) / view[0]
    cos, sin = math.cos(box[2]), math.sin(box[2])
    step_x, step_y = cos + sin * slope, -sin + cos * slope
    inverse_x = 1.0 / (step_x if abs(step_x) > LEAST else LEAST)
    inverse_y = 1.0 / (step_y if abs(step_y) > LEAST else LEAST)
    middle_x, middle_y = (cos * box[0] + sin * box[1]) * inverse_x, (cos * box[1] - sin * box[0]) * inverse_y
    half_x, half_y = box[3] * abs(inverse_x), box[4] * abs(inverse_y)
    across = middle_x + half_x < middle_y + half_y if inside else middle_x - half_x > middle_y - half_y
    # Either way the normal looks against the ray.
    side = -math.copysign(1.0, step_x if across else step_y)
    return shade(light, cos * side if across else -sin * side, sin * side if across else cos * side, 0.0)


@compiled
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
    borders: FloatArray,
    rows: FloatArray,
    shades: FloatArray,
    skip: Image,
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
        borders: Out: f / depth, azimuth (rad) and shade at each border.
        rows: Out, for the columns from ``floor(left)`` to ``ceil(right)``.
        shades: Out.
        skip: Out: set for columns, but the first and the last, with two or more pieces of the pattern.
    """
    first = math.floor(left)
    columns = math.ceil(right) - first
    lid = 1 if view[3] > heights[0] else 0
    x, y, yaw, radius = solid[0], solid[1], solid[2], solid[3]
    for i in range(columns + 1):
        slope = (view[1] - min(max(float(first + i), left), right)) / view[0]
        scale = 1.0 / math.sqrt(1.0 + slope * slope)
        t = (x + slope * y) * scale
        p = min(max((y - slope * x) * scale, -radius), radius)
        root = math.sqrt(radius * radius - p * p)
        near = view[0] / max((t - root) * scale, NEAREST)
        borders[NEAR, i] = near
        towards = -light[2] * (root - slope * p) - light[3] * (slope * root + p)
        borders[SHADE, i] = light[0] + light[1] * max(towards * scale / radius, 0.0)
        if lid:
            rows[0, i] = view[2] - (heights[0] - view[3]) * view[0] / max((t + root) * scale, NEAREST)
        if patterned >= 0:
            borders[AZIMUTH, i] = math.pi + arcsine(p / radius) - yaw + math.atan(slope)
    k = lid
    for band in range(bands + 1):
        for i in range(columns + 1):
            rows[k, i] = view[2] - (heights[band] - view[3]) * borders[NEAR, i]
        k += 1
        if band == patterned:
            before = 0
            for i in range(columns + 1):
                piece = piece_of(knots, borders[AZIMUTH, i])
                low, high = piece_edges(knots, piece, borders[AZIMUTH, i])
                rows[k, i] = view[2] - (high - view[3]) * borders[NEAR, i]
                rows[k + 1, i] = view[2] - (low - view[3]) * borders[NEAR, i]
                if i > 1:
                    skip[i - 1] = 1 if piece != before and i < columns else 0
                before = piece
            k += 2
    for band in range(k - 1):
        for i in range(columns):
            shades[band, i] = 0.5 * (borders[SHADE, i] + borders[SHADE, i + 1])
    if lid:
        top = shade(light, 0.0, 0.0, 1.0)
        for i in range(columns):
            shades[0, i] = top
    return k - 1


@compiled
def cut_column(
    view: FloatArray,
    knots: FloatArray,
    i: int,
    bands: int,
    carrier: int,
    borders: FloatArray,
    rows: FloatArray,
    cuts: FloatArray,
    shares: FloatArray,
) -> int:
    """Cut a column at the knots of the pattern; return how many pieces.

    Args:
        view: See above.
        knots: Of the pattern, heights above the ground.
        i: Which column of the sheet.
        bands: Of the sheet.
        carrier: The first of the three that the patterned one has become.
        borders: Of :func:`cylinder_sheet`.
        rows: Of the sheet.
        cuts: Out: rows at both ends of each piece, ``(bands + 1, 2 pieces)``.
        shares: Out: of the column's width, of each piece.
    """
    begin, end = borders[AZIMUTH, i], borders[AZIMUTH, i + 1]
    from_ = begin
    pieces = len(knots) - 1
    last = piece_of(knots, end)
    used = 0
    for piece in range(piece_of(knots, begin), last + 1):
        to = end
        if piece < last:
            to = 2.0 * math.pi * (piece // pieces) + knots[piece % pieces + 1, 0]
        if to > from_ and used < PIECES:
            for side in range(2):
                azimuth = from_ if side == 0 else to
                share = (azimuth - begin) / (end - begin)
                near = borders[NEAR, i] + share * (borders[NEAR, i + 1] - borders[NEAR, i])
                place = 2 * used + side
                for k in range(bands + 1):
                    cuts[k, place] = rows[k, i] + share * (rows[k, i + 1] - rows[k, i])
                low, high = piece_edges(knots, piece, azimuth)
                cuts[carrier + 1, place] = view[2] - (high - view[3]) * near
                cuts[carrier + 2, place] = view[2] - (low - view[3]) * near
            shares[used] = (to - from_) / (end - begin)
            used += 1
            from_ = to
    return used
