"""Kernels that cut solids by the columns of a level camera: what one over the depth is at their borders.

Seen along a border of a column, a vertical plane, an upright solid is a stack of bands. Each kernel
fills in the profile and the plan of a sheet (see :mod:`swarmvision.rendering.painting`) for the columns
that its solid reaches. Functions that take arrays call none that loop: each such call would count
references, atomically, and threads that share the stage would wait for each other.

``view`` is focal length, principal column and row (px), lens height (m). ``light`` is ambient, diffuse
and the lamp's direction in the lens frame, see :class:`swarmvision.rendering.appearance.Light`.
"""

from __future__ import annotations

import math

import numpy as np

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.rendering.painting import (
    BASE,
    FAR,
    GAIN,
    HALF,
    NEAR,
    ONE,
    RISE,
    SHADE,
    SPLIT,
    ZERO,
    Singles,
    room,
)

NEAREST = 1e-3  # m; surfaces nearer than this to the lens plane are drawn as if there
FAR_ROW = 1e6  # px; beyond every picture
SKY = np.float32(1e6)  # m; the height of what has no upper edge
LEAST = 1e-12  # of a step that is divided by
# M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 1964, 4.4.46: 2e-8 rad.
ARC = (1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046,
       0.0308918810, -0.0170881256, 0.0066700901, -0.0012624911)  # fmt: skip


@leaf
def shade(light: FloatArray, x: float, y: float, z: float) -> float:
    """Return Lambert's factor for a unit normal."""
    towards = light[2] * x + light[3] * y + light[4] * z
    factor: float = light[0] + light[1] * max(towards, 0.0)
    return factor


@leaf
def arcsine(x: float) -> float:
    """Return the arc sine, to 2e-8 rad and the same to the bit on every machine."""
    a = min(abs(x), 1.0)
    value = ARC[7]
    for i in range(6, -1, -1):
        value = value * a + ARC[i]
    angle = math.pi / 2.0 - math.sqrt(1.0 - a) * value
    return angle if x >= 0.0 else -angle


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


@leaf
def _corner(box: FloatArray, i: int) -> tuple[float, float]:
    """Return a corner of a box, counter-clockwise from the front left one."""
    dx = box[3] if i in (0, 3) else -box[3]
    dy = box[4] if i < 2 else -box[4]
    cos, sin = math.cos(box[2]), math.sin(box[2])
    return box[0] + cos * dx - sin * dy, box[1] + sin * dx + cos * dy


@leaf
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
def box_sheet(
    view: FloatArray,
    light: FloatArray,
    box: FloatArray,
    height: float,
    inside: bool,
    left: float,
    right: float,
    profile: Singles,
    plan: Singles,
) -> int:
    """Fill in a box that stands on the ground; return the bands.

    From outside these are its lid, if seen, and its faces; from inside what is beyond, faces, floor.
    One over the depth of a face is linear in the column, and which face is met first or last tells the
    least or the greatest.

    Args:
        view: See above.
        light: See above.
        box: x, y, yaw in the lens frame, half length, half width.
        height: m.
        inside: Whether the lens is inside, and the box is the court.
        left: Where the part of it begins that is in the picture (px).
        right: And where it ends.
        profile: Out, for the columns from ``floor(left)`` to ``ceil(right)``.
        plan: Out.
    """
    first = math.floor(left)
    columns = math.ceil(right) - first
    size = room(columns)
    lid = 1 if inside or view[3] > height else 0
    cos, sin = math.cos(box[2]), math.sin(box[2])
    x, y = cos * box[0] + sin * box[1], cos * box[1] - sin * box[0]
    ahead, behind = _one_over(x + box[3]), _one_over(x - box[3])
    beside, across = _one_over(y + box[4]), _one_over(y - box[4])
    centre, focal, most = view[1], view[0], 1.0 / NEAREST
    near, far, split, shades = profile[NEAR], profile[FAR], profile[SPLIT], profile[SHADE]
    for i in range(size):
        slope = (centre - min(max(float(first + i), left), right)) / focal
        step_x, step_y = cos + sin * slope, cos * slope - sin
        leave_x = step_x * (ahead if step_x > 0.0 else behind)
        leave_y = step_y * (beside if step_y > 0.0 else across)
        enter_x = step_x * (behind if step_x > 0.0 else ahead)
        enter_y = step_y * (across if step_y > 0.0 else beside)
        leave = min(max(leave_x, leave_y, LEAST), most)
        enter = min(enter_x if enter_x > 0.0 else most, enter_y if enter_y > 0.0 else most)
        enter = max(min(enter, most), leave)
        near[i] = np.float32(focal * (leave if inside else enter))
        far[i] = np.float32(focal * leave)
        split[i], shades[i] = HALF, ZERO
    for k in range(4):
        plan[BASE, k], plan[GAIN, k] = ZERO, ONE
    plan[RISE, lid], plan[RISE, lid + 1] = np.float32(height - view[3]), np.float32(-view[3])
    if inside:
        plan[RISE, 0], plan[RISE, 3] = SKY, -SKY
        plan[BASE, 0], plan[GAIN, 0], plan[BASE, 2], plan[GAIN, 2] = ONE, ZERO, ONE, ZERO
    elif lid:
        plan[RISE, 0] = plan[RISE, 1]
        plan[BASE, 0], plan[GAIN, 0] = np.float32(shade(light, 0.0, 0.0, 1.0)), ZERO
    # Face by face, from corner to corner; a column where two meet has its share of both.
    begin = left
    while begin < right:
        end = right
        for i in range(4):
            corner_x, corner_y = _corner(box, i)
            u = view[1] - view[0] * corner_y / corner_x if corner_x > NEAREST else right
            if begin + 1e-9 < u < end:
                end = u
        factor = _face_shade(view, light, box, inside, 0.5 * (begin + end))
        for i in range(math.floor(begin) - first, math.ceil(end) - first):
            wide = min(right, first + i + 1.0) - max(left, float(first + i))
            part = (min(end, first + i + 1.0) - max(begin, float(first + i))) / wide
            shades[i] = np.float32(shades[i] + factor * part)
        begin = end
    return 3 if inside else 1 + lid


@leaf
def _one_over(x: float) -> float:
    return 1.0 / (x if abs(x) > LEAST else LEAST)


@leaf
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
    azimuths: FloatArray,
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
    size = room(columns)
    lid = 1 if view[3] > heights[0] else 0
    x, y, radius = solid[0], solid[1], solid[3]
    near, far, split, shades = profile[NEAR], profile[FAR], profile[SPLIT], profile[SHADE]
    centre, focal, turn = view[1], view[0], math.pi - solid[2]
    ambient, diffuse, ahead, aside = light[0], light[1] / radius, light[2], light[3]
    for i in range(size):
        slope = (centre - min(max(float(first + i), left), right)) / focal
        scale = 1.0 / math.sqrt(1.0 + slope * slope)
        t = (x + slope * y) * scale
        p = min(max((y - slope * x) * scale, -radius), radius)
        root = math.sqrt(radius * radius - p * p)
        near[i] = np.float32(focal / max((t - root) * scale, NEAREST))
        far[i] = np.float32(focal / max((t + root) * scale, NEAREST))
        towards = -ahead * (root - slope * p) - aside * (slope * root + p)
        shades[i] = np.float32(ambient + diffuse * max(towards * scale, 0.0))
        split[i] = HALF
        azimuths[i] = turn + arcsine(p / radius) + arcsine(slope * scale)
    for i in range(columns):
        shades[i] = HALF * (shades[i] + shades[i + 1])
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
        pieces, upper = len(knots) - 1, 2 * (lid + patterned + 1)
        for i in range(columns):
            begin, end = azimuths[i], azimuths[i + 1]
            piece = piece_of(knots, begin)
            knot = 2.0 * math.pi * (piece // pieces) + knots[piece % pieces + 1, 0]
            part = 0.5
            if begin < knot < end:
                part = (knot - begin) / (end - begin)
                split[i] = np.float32(part)
            for side in range(2):
                middle = 0.5 * (part + side)
                azimuth = begin + middle * (end - begin)
                low, high = piece_edges(knots, piece_of(knots, azimuth), azimuth)
                scale = near[i] + middle * (near[i + 1] - near[i])
                rows[upper + side, i] = np.float32(view[2] - (high - view[3]) * scale)
                rows[upper + 2 + side, i] = np.float32(view[2] - (low - view[3]) * scale)
        for j in range(upper, upper + 4):
            for i in range(columns, size):
                rows[j, i] = rows[j, columns - 1]
    return k - 1
