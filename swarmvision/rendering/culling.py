"""What is in view of a lens, far to near, and what of it nearer markers hide. Kernels."""

from __future__ import annotations

import math

from swarmvision.compiled import inner, leaf
from swarmvision.geometry import FloatArray
from swarmvision.rendering.boxes import box_hit
from swarmvision.rendering.columns import NEAREST
from swarmvision.rendering.cylinders import circle_hit, circle_reach
from swarmvision.rendering.stage import BODY, CYLINDER, MARKER, OBJECTS, Places, Scratch, Stage

X, Y, YAW, SIZE, WIDTH, LEFT, RIGHT, FAR, ROUND = range(9)  # of a solid, see cull
TRIES = 8  # columns at which two solids are compared
SURE = 0.01  # px; by so much what hides is taken as smaller, and what is hidden as larger
GAP = 133  # between solids that are sorted first; 57, 24, 10, 4, 1 follow


@leaf
def cull(
    width: int,
    lens_pose: FloatArray,
    robots: FloatArray,
    observer: int,
    objects: FloatArray,
    stage: Stage,
    solids: FloatArray,
    parts: Places,
) -> int:
    """List what is in view, in the lens frame, with the first part of each; return how many.

    Of each: x, y, yaw, half length or radius, half width, left and right column, distance, and radius of
    the circle round it.
    """
    cos, sin = math.cos(lens_pose[2]), math.sin(lens_pose[2])
    used = 0
    for i in range(len(robots) + len(objects)):
        part, pose = BODY, robots[0] if len(robots) > 0 else lens_pose
        if i < len(robots):
            pose = robots[i]
        else:
            part, pose = OBJECTS + i - len(robots), objects[i - len(robots)]
        east, north = pose[0] - lens_pose[0], pose[1] - lens_pose[1]
        x, y = cos * east + sin * north, cos * north - sin * east
        one, two = stage.sizes[part, 0], stage.sizes[part, 1]
        radius = one if stage.kinds[part, 0] == CYLINDER else math.sqrt(one * one + two * two)
        if part == BODY:
            radius = max(radius, stage.sizes[MARKER, 0])
        if x <= -radius:  # half of them, mostly
            continue
        left, right = circle_reach(stage.optics, x, y, radius)
        if i != observer and right > 0.0 and left < width and right > left:
            solids[used, X], solids[used, Y], solids[used, YAW] = x, y, pose[2] - lens_pose[2]
            solids[used, SIZE], solids[used, WIDTH] = one, two
            solids[used, LEFT], solids[used, RIGHT] = left, right
            solids[used, FAR], solids[used, ROUND] = math.sqrt(x * x + y * y), radius
            parts[used] = part
            used += 1
    return used


@leaf
def sort(used: int, view: FloatArray, solids: FloatArray, order: Places) -> None:
    """Order what is in view far to near: by the middles, and where those do not tell, by what hides what.

    Only solids that are no farther apart than both are wide are asked, so the cost grows as the number in
    view, not as its square.
    """
    widest = 0.0
    for i in range(used):
        order[i] = i
        widest = max(widest, solids[i, ROUND])
    gap = GAP  # Shell's sort
    while gap > 0:
        for i in range(gap, used):
            moved, place = order[i], i
            while place >= gap and solids[order[place - gap], FAR] < solids[moved, FAR]:
                order[place] = order[place - gap]
                place -= gap
            order[place] = moved
        gap = gap * 3 // 7
    for place in range(used):
        i, moves = place + 1, 0
        while i < used and solids[order[place], FAR] - solids[order[i], FAR] < 2.0 * widest:
            moved = order[i]
            if moves < used and _is_hidden(view, solids[moved], solids[order[place]]):
                for j in range(i, place, -1):
                    order[j] = order[j - 1]
                order[place] = moved
                moves += 1
                i = place
            i += 1


@leaf
def hide(used: int, stage: Stage, scratch: Scratch) -> None:
    """Note which parts of robots are behind markers of nearer ones, whole pixels of them, and need no paint.

    In each column one run of rows is known to be covered by nearer markers.
    """
    view, solids, covered, hidden = stage.optics, scratch.solids, scratch.covered, scratch.hidden
    width, focal, horizon = covered.shape[1], view[0], view[2]
    for c in range(width):
        covered[0, c] = covered[1, c] = 0
    for j in range(used - 1, -1, -1):
        i = scratch.order[j]
        for part in range(BODY, MARKER + 1 if scratch.parts[i] == BODY else BODY):
            x, y, radius = solids[i, X], solids[i, Y], stage.sizes[part, 0]
            radius = solids[i, ROUND] if part == BODY else radius
            left, right = circle_reach(view, x, y, radius)
            left, right = max(left, 0.0), min(right, float(width))
            crown, base = stage.heights[part, 0], stage.heights[part, stage.kinds[part, 1]]
            top, bottom = _outer_rows(view, crown, base, x, radius)
            hidden[i, part - BODY] = True
            for c in range(math.floor(left), math.ceil(right)):
                if top < covered[0, c] or bottom > covered[1, c]:
                    hidden[i, part - BODY] = False
                    break
            if part == MARKER and not hidden[i, part - BODY] and x - radius > NEAREST:
                over, under = crown - view[3], base - view[3]
                # What is seen of it is not farther than its outline.
                near, far = focal / (x - radius), focal / (x + radius * abs(y) / solids[i, FAR])
                top = math.ceil(horizon - over * (far if over > 0.0 else near) + SURE)
                bottom = math.floor(horizon - under * (far if under < 0.0 else near) - SURE)
                for c in range(math.ceil(left), math.floor(right)):
                    if top <= covered[1, c] and bottom >= covered[0, c]:
                        covered[0, c], covered[1, c] = min(top, covered[0, c]), max(bottom, covered[1, c])
                    elif bottom - top > covered[1, c] - covered[0, c]:
                        covered[0, c], covered[1, c] = top, bottom


@leaf
def bound(used: int, height: int, stage: Stage, scratch: Scratch) -> None:
    """Tell which rows, from the top and from the bottom, no solid can stand before."""
    first, last = height, 0
    for i in range(used):
        part = scratch.parts[i]
        crown, base = stage.heights[part, 0], stage.heights[part, stage.kinds[part, 1]]
        for p in range(part + 1, MARKER + 1 if part == BODY else part):
            crown, base = max(crown, stage.heights[p, 0]), min(base, stage.heights[p, stage.kinds[p, 1]])
        x, radius = scratch.solids[i, X], scratch.solids[i, ROUND]
        top, bottom = _outer_rows(stage.optics, crown, base, x, radius)
        first, last = min(first, top), max(last, bottom)
    scratch.alike[0], scratch.alike[1] = max(first, 0), min(last, height)


@inner
def _outer_rows(view: FloatArray, crown: float, base: float, x: float, radius: float) -> tuple[int, int]:
    """Return between which rows a solid stays that reaches from one height to another (m) at a depth (m)."""
    over, under = crown - view[3], base - view[3]
    near, far = view[0] / max(x - radius, NEAREST), view[0] / max(x + radius, NEAREST)
    top = math.floor(view[2] - over * (near if over > 0.0 else far) - SURE)
    return top, math.ceil(view[2] - under * (near if under < 0.0 else far) + SURE)


@leaf
def _is_hidden(view: FloatArray, one: FloatArray, two: FloatArray) -> bool:
    """Return whether a solid is hidden by one whose middle is farther; both are convex and disjoint."""
    left, right = max(one[LEFT], two[LEFT]), min(one[RIGHT], two[RIGHT])
    hidden = False
    if two[FAR] - one[FAR] < one[ROUND] + two[ROUND] and right > left:
        # Any column that meets both tells.
        for j in range(TRIES):
            column = left + (right - left) * (j + 0.5) / TRIES
            near, far = _depths(view, one, column)
            other, beyond = _depths(view, two, column)
            if near < far and other < beyond:
                hidden = near > other
    return hidden


@leaf
def _depths(view: FloatArray, solid: FloatArray, column: float) -> tuple[float, float]:
    """Return at which depths (m) a column (px) enters and leaves a solid; nowhere if not in this order."""
    if solid[ROUND] == solid[SIZE]:  # a cylinder
        near = circle_hit(view, solid, column)
        return near, near + solid[SIZE]
    near, far = box_hit(view, solid, column)
    return max(near, 0.0), far
