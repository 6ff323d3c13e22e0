"""Kernels that cut a box by a camera's columns, see :mod:`swarmvision.rendering.columns`."""

from __future__ import annotations

import math

import numpy as np

from swarmvision.compiled import inner, leaf
from swarmvision.geometry import FloatArray
from swarmvision.rendering.columns import FAR_ROW, LEAST, NEAREST, shade
from swarmvision.rendering.ink import HALF, ONE, ZERO
from swarmvision.rendering.sheet import BASE, FAR, GAIN, NEAR, RISE, SHADE, SPLIT, Singles, room

SKY = np.float32(1e6)  # m; the height of what has no upper edge


@leaf
def box_reach(view: FloatArray, box: FloatArray) -> tuple[float, float]:
    """Return the columns (px) of a box's silhouette; box is x, y, yaw, half length, half width."""
    left, right = FAR_ROW, -FAR_ROW
    cos, sin = math.cos(box[2]), math.sin(box[2])
    for i in range(4):
        x, y = _corner(box, cos, sin, i)
        if x > NEAREST:
            u = view[1] - view[0] * y / x
            left, right = min(left, u), max(right, u)
        next_x, next_y = _corner(box, cos, sin, (i + 1) % 4)
        if (x > NEAREST) != (next_x > NEAREST):  # the lens plane cuts this side
            y += (NEAREST - x) / (next_x - x) * (next_y - y)
            u = view[1] - view[0] * y / NEAREST
            left, right = min(left, u), max(right, u)
    if left > right:
        return 0.0, 0.0
    return left, right


@leaf
def _corner(box: FloatArray, cos: float, sin: float, i: int) -> tuple[float, float]:
    """Return a corner of a box, counter-clockwise from the front left one."""
    dx = box[3] if i in (0, 3) else -box[3]
    dy = box[4] if i < 2 else -box[4]
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
    lid = 1 if inside or view[3] > height else 0
    cos, sin = math.cos(box[2]), math.sin(box[2])
    _cut_box(view, box, cos, sin, inside, first, columns, left, right, profile)
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
            corner_x, corner_y = _corner(box, cos, sin, i)
            u = view[1] - view[0] * corner_y / corner_x if corner_x > NEAREST else right
            if begin + 1e-9 < u < end:
                end = u
        factor = _face_shade(view, light, box, cos, sin, inside, 0.5 * (begin + end))
        _shade_face(factor, begin, end, left, right, first, profile)
        begin = end
    return 3 if inside else 1 + lid


@inner
def _cut_box(
    view: FloatArray,
    box: FloatArray,
    cos: float,
    sin: float,
    inside: bool,
    first: int,
    columns: int,
    left: float,
    right: float,
    profile: Singles,
) -> None:
    """Fill in the profile of a box without its shade."""
    x, y = cos * box[0] + sin * box[1], cos * box[1] - sin * box[0]
    ahead, behind = _one_over(x + box[3]), _one_over(x - box[3])
    beside, across = _one_over(y + box[4]), _one_over(y - box[4])
    c, s, most, least = np.float32(cos), np.float32(sin), np.float32(1.0 / NEAREST), np.float32(LEAST)
    centre, focal, inverse = np.float32(view[1]), np.float32(view[0]), np.float32(1.0 / view[0])
    start, stop = np.float32(left), np.float32(right)
    for i in range(room(columns)):
        slope = (centre - min(stop, max(start, np.float32(first + i)))) * inverse
        step_x, step_y = c + s * slope, c * slope - s
        leave_x = step_x * (ahead if step_x > ZERO else behind)
        leave_y = step_y * (beside if step_y > ZERO else across)
        enter_x = step_x * (behind if step_x > ZERO else ahead)
        enter_y = step_y * (across if step_y > ZERO else beside)
        leave = min(most, max(least, leave_x, leave_y))
        enter = min(enter_x if enter_x > ZERO else most, enter_y if enter_y > ZERO else most)
        enter = max(leave, min(most, enter))
        profile[NEAR, i] = focal * (leave if inside else enter)
        profile[FAR, i] = focal * leave
        profile[SPLIT, i], profile[SHADE, i] = HALF, ZERO


@inner
def _shade_face(
    factor: float, begin: float, end: float, left: float, right: float, first: int, profile: Singles
) -> None:
    """Add a face's shade to the columns from one corner to the next, by its share of each."""
    start, stop = math.floor(begin), math.ceil(end)
    for i in range(start + 1, stop - 1):
        profile[SHADE, i - first] = np.float32(factor)
    for side in range(2 if stop - 1 > start else 1):
        i = start if side == 0 else stop - 1
        wide = min(right, i + 1.0) - max(left, float(i))
        part = (min(end, i + 1.0) - max(begin, float(i))) / wide
        profile[SHADE, i - first] += np.float32(factor * part)


@leaf
def _one_over(x: float) -> np.float32:
    return np.float32(1.0 / (x if abs(x) > LEAST else LEAST))


@leaf
def _face_shade(
    view: FloatArray,
    light: FloatArray,
    box: FloatArray,
    cos: float,
    sin: float,
    inside: bool,
    column: float,
) -> float:
    """Return the shade of the face that a column (px) meets; seen from inside it is the far one's."""
    slope = (view[1] - column) / view[0]
    step_x, step_y = cos + sin * slope, -sin + cos * slope
    inverse_x = 1.0 / (step_x if abs(step_x) > LEAST else LEAST)
    inverse_y = 1.0 / (step_y if abs(step_y) > LEAST else LEAST)
    middle_x, middle_y = (cos * box[0] + sin * box[1]) * inverse_x, (cos * box[1] - sin * box[0]) * inverse_y
    half_x, half_y = box[3] * abs(inverse_x), box[4] * abs(inverse_y)
    across = middle_x + half_x < middle_y + half_y if inside else middle_x - half_x > middle_y - half_y
    # Either way the normal looks against the ray.
    side = -math.copysign(1.0, step_x if across else step_y)
    return shade(light, cos * side if across else -sin * side, sin * side if across else cos * side, 0.0)
