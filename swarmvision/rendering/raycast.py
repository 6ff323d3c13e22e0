"""Analytic column ray caster, the default renderer: needs no graphics library.

The world is boxes, upright cylinders, a floor and four walls, and the lens is level, so a column of
the picture is one vertical plane. What is out of sight is culled by its tangents and costs nothing.
The rest is painted part by part, far to near, each as a sheet of bands over its columns
(:mod:`swarmvision.rendering.columns`, :mod:`swarmvision.rendering.painting`). A distorted lens is
drawn straight and bent afterwards.

:func:`draw` is the whole of it as one compiled function of arrays, for loops over many cameras.
"""

from __future__ import annotations

import math
import threading

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.compiled import leaf
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.geometry import FloatArray
from swarmvision.rendering.appearance import Appearance
from swarmvision.rendering.boxes import box_hit, box_reach, box_sheet
from swarmvision.rendering.columns import NEAREST
from swarmvision.rendering.cylinders import circle_hit, circle_reach, cylinder_sheet
from swarmvision.rendering.painting import paint_sheet
from swarmvision.rendering.sheet import NEAR, RISE, Singles
from swarmvision.rendering.stage import (
    BODY,
    BOX,
    COURT,
    CYLINDER,
    MARKER,
    OBJECTS,
    Image,
    Places,
    Scratch,
    Stage,
)

X, Y, YAW, SIZE, WIDTH, LEFT, RIGHT, FAR, ROUND = range(9)  # of a solid, see _cull
ROOM = 16  # robots that fit at first
TRIES = 8  # columns at which two solids are compared
SURE = 0.01  # px; by so much what hides is taken as smaller, and what is hidden as larger
GAP = 133  # between solids that are sorted first; 57, 24, 10, 4, 1 follow


class Raycaster:
    """Draws what one kind of lens sees in one arena of equal robots; threads may share it."""

    def __init__(
        self, lens: Lens, robot: RobotConfig, arena: ArenaConfig, appearance: Appearance | None = None
    ) -> None:
        """Prepare colours and tables."""
        self._lens = lens
        self.stage = Stage.of(lens, robot, arena, appearance or Appearance())
        """What :func:`draw` needs to know."""
        self._maps = _bending_maps(lens) if lens.is_distorted else None
        self._memory = threading.local()

    @property
    def shape(self) -> tuple[int, int, int]:
        """Of a picture."""
        return (self._lens.height_px, self._lens.width_px, 3)

    @property
    def by_kernel(self) -> bool:
        """Whether :func:`draw` is the whole of it."""
        return self._maps is None

    def scratch(self, robots: int) -> Scratch:
        """Return memory for :func:`draw` with up to so many robots, for one thread."""
        return Scratch.of(self._lens, self.stage, robots)

    def render(
        self, scene: Scene, lens_pose: FloatArray, observer: int | None = None, out: Image | None = None
    ) -> Image:
        """Return the picture of a scene.

        Args:
            scene: What there is.
            lens_pose: x (m), y (m), yaw (rad) of the lens in the world.
            observer: The robot that carries the lens; it is not drawn.
            out: Written and returned where given, shape ``(h, w, 3)``, uint8.

        Returns:
            sRGB, shape ``(h, w, 3)``.
        """
        shape = self.shape
        image = out if out is not None and out.flags.c_contiguous else np.empty(shape, dtype=np.uint8)
        draw(
            image.reshape(shape[0], -1),
            np.array(lens_pose, dtype=np.float64),
            scene.pose,
            -1 if observer is None else observer,
            scene.object_pose,
            self.stage,
            self.brushes(scene.robots),
            True,
        )
        if self._maps is not None:
            image = cv2.remap(image, *self._maps, cv2.INTER_LINEAR, None, cv2.BORDER_REPLICATE)
        if out is None or out is image:
            return image
        out[:] = image
        return out

    def brushes(self, robots: int) -> Scratch:
        """Return this thread's own memory for pictures with up to so many robots."""
        memory = self._memory
        if getattr(memory, "robots", -1) < robots:
            memory.robots = max(robots, ROOM)
            memory.scratch = self.scratch(memory.robots)
        scratch: Scratch = memory.scratch
        return scratch


def _bending_maps(lens: Lens) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return where each pixel of the distorted picture comes from, as OpenCV's remap wants it."""
    rows, columns = np.mgrid[: lens.height_px, : lens.width_px] + 0.5
    straight = lens.undistort(np.stack([columns, rows], axis=-1)) - 0.5  # OpenCV counts centres from 0
    return straight[..., 0].astype(np.float32), straight[..., 1].astype(np.float32)


@leaf
def draw(
    image: Image,
    lens_pose: FloatArray,
    robots: FloatArray,
    observer: int,
    objects: FloatArray,
    stage: Stage,
    scratch: Scratch,
    whole: bool,
) -> None:
    """Draw one picture; allocates nothing, needs no interpreter, and may be called by compiled code.

    Args:
        image: Out: sRGB, ``(h, 3 w)``, contiguous, of an undistorted lens.
        lens_pose: x (m), y (m), yaw (rad) of the lens in the world.
        robots: Poses of all robots in the world, ``(r, 3)``.
        observer: Which robot is not drawn; -1 for none.
        objects: Poses of the arena's objects in the world, ``(n, 3)``.
        stage: Of the :class:`Raycaster`.
        scratch: Of :meth:`Raycaster.scratch`, for as many robots or more.
        whole: Whether to write all rows; else only the first of each run that ``scratch.alike`` tells of.
    """
    height, width = image.shape[0], image.shape[1] // 3
    view, light, solid, window = stage.optics, scratch.light, scratch.solid, scratch.window
    cos, sin = math.cos(lens_pose[2]), math.sin(lens_pose[2])
    light[0], light[1], light[4] = stage.lamp[0], stage.lamp[1], stage.lamp[4]
    light[2] = cos * stage.lamp[2] + sin * stage.lamp[3]
    light[3] = cos * stage.lamp[3] - sin * stage.lamp[2]
    used = _cull(width, lens_pose, robots, observer, objects, stage, scratch.solids, scratch.parts)
    _sort(used, view, scratch.solids, scratch.order)
    _hide(used, stage, scratch)
    _bound(used, height, stage, scratch)
    # All in one loop, for handing over the arrays of a sheet at several places costs compile time.
    for j in range(-1, used):
        if j < 0:
            solid[X] = -cos * lens_pose[0] - sin * lens_pose[1]
            solid[Y] = sin * lens_pose[0] - cos * lens_pose[1]
            solid[YAW] = -lens_pose[2]
            part = last = COURT
        else:
            i = scratch.order[j]
            solid[X], solid[Y], solid[YAW] = (
                scratch.solids[i, X],
                scratch.solids[i, Y],
                scratch.solids[i, YAW],
            )
            part = scratch.parts[i]
            last = MARKER if part == BODY else part
        while part <= last:
            if j >= 0 and last == MARKER and scratch.hidden[scratch.order[j], part - BODY]:
                part += 1
                continue
            kind, bands, patterned = stage.kinds[part, 0], stage.kinds[part, 1], stage.kinds[part, 2]
            solid[SIZE], solid[WIDTH] = stage.sizes[part, 0], stage.sizes[part, 1]
            if part == COURT:
                left, right = 0.0, float(width)
            elif kind == CYLINDER:
                left, right = circle_reach(view, solid[X], solid[Y], solid[SIZE])
            else:
                left, right = box_reach(view, solid)
            left, right = max(left, 0.0), min(right, float(width))
            spans, sides, carrier = 0, 1, -1
            if right > left and kind == CYLINDER:
                spans = cylinder_sheet(
                    view,
                    light,
                    solid,
                    stage.heights[part],
                    bands,
                    patterned,
                    stage.knots,
                    left,
                    right,
                    scratch.azimuths,
                    scratch.profile,
                    scratch.plan,
                    scratch.rows,
                )
                sides = bands if patterned < 0 else bands + 2
                carrier = patterned if patterned < 0 else patterned + spans - sides
            elif right > left:
                spans = box_sheet(
                    view,
                    light,
                    solid,
                    stage.heights[part, 0],
                    part == COURT,
                    left,
                    right,
                    scratch.profile,
                    scratch.plan,
                )
            window[0], window[1] = 0, height
            if part == COURT:
                sides = spans
                _fill_rows(
                    image,
                    window,
                    scratch.alike,
                    whole,
                    view[2],
                    scratch.plan,
                    scratch.profile,
                    stage.backdrop,
                )
            if spans > 0:
                paint_sheet(
                    image,
                    window,
                    math.floor(left),
                    left,
                    right,
                    spans,
                    spans - sides,
                    carrier,
                    kind == BOX,
                    view[2],
                    stage.colours[part],
                    stage.pigments[part],
                    scratch.plan,
                    scratch.profile,
                    scratch.rows,
                    scratch.lights,
                    scratch.inks,
                    scratch.pixels,
                    scratch.spans,
                )
            part += 1


@leaf
def _fill_rows(
    image: Image,
    window: Places,
    alike: Places,
    whole: bool,
    horizon: float,
    plan: Singles,
    profile: Singles,
    backdrop: Image,
) -> None:
    """Paint whole rows of what is beyond the walls and of floor; leave those between in the window.

    ``alike`` tells which of them nothing stands before, and is told which of those the court leaves whole.
    """
    height, width = image.shape[0], image.shape[1] // 3
    near = profile[NEAR]
    least = most = near[0]
    for i in range(1, width + 1):
        least, most = min(least, near[i]), max(most, near[i])
    top = horizon - plan[RISE, 1] * (most if plan[RISE, 1] > 0.0 else least)
    bottom = horizon - plan[RISE, 2] * most
    first = min(max(math.floor(top), 0), height)
    last = max(min(math.ceil(bottom), height), first)
    alike[0], alike[1] = min(alike[0], first), max(alike[1], last)
    for y in range(height):
        as_above = 0 < y < alike[0] or y > alike[1]
        if (y < first or y >= last) and (whole or not as_above):
            band = 0 if y < first else 1
            for i in range(3 * width):
                image[y, i] = backdrop[band, i]
    window[0], window[1] = first, last


@leaf
def _cull(
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
def _sort(used: int, view: FloatArray, solids: FloatArray, order: Places) -> None:
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
def _hide(used: int, stage: Stage, scratch: Scratch) -> None:
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
            over = stage.heights[part, 0] - view[3]
            under = stage.heights[part, stage.kinds[part, 1]] - view[3]
            near, far = focal / max(x - radius, NEAREST), focal / max(x + radius, NEAREST)
            top = math.floor(horizon - over * (near if over > 0.0 else far) - SURE)
            bottom = math.ceil(horizon - under * (near if under < 0.0 else far) + SURE)
            hidden[i, part - BODY] = True
            for c in range(math.floor(left), math.ceil(right)):
                if top < covered[0, c] or bottom > covered[1, c]:
                    hidden[i, part - BODY] = False
                    break
            if part == MARKER and not hidden[i, part - BODY] and x - radius > NEAREST:
                # What is seen of it is not farther than its outline.
                far = focal / (x + radius * abs(y) / solids[i, FAR])
                top = math.ceil(horizon - over * (far if over > 0.0 else near) + SURE)
                bottom = math.floor(horizon - under * (far if under < 0.0 else near) - SURE)
                for c in range(math.ceil(left), math.floor(right)):
                    if top <= covered[1, c] and bottom >= covered[0, c]:
                        covered[0, c], covered[1, c] = min(top, covered[0, c]), max(bottom, covered[1, c])
                    elif bottom - top > covered[1, c] - covered[0, c]:
                        covered[0, c], covered[1, c] = top, bottom


@leaf
def _bound(used: int, height: int, stage: Stage, scratch: Scratch) -> None:
    """Tell which rows, from the top and from the bottom, no solid can stand before."""
    focal, horizon, level = stage.optics[0], stage.optics[2], stage.optics[3]
    first, last = height, 0
    for i in range(used):
        x, radius, part = scratch.solids[i, X], scratch.solids[i, ROUND], scratch.parts[i]
        near, far = focal / max(x - radius, NEAREST), focal / max(x + radius, NEAREST)
        for p in range(part, (MARKER if part == BODY else part) + 1):
            over, under = stage.heights[p, 0] - level, stage.heights[p, stage.kinds[p, 1]] - level
            first = min(first, math.floor(horizon - over * (near if over > 0.0 else far) - SURE))
            last = max(last, math.ceil(horizon - under * (near if under < 0.0 else far) + SURE))
    scratch.alike[0], scratch.alike[1] = max(first, 0), min(last, height)


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
