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
from swarmvision.compiled import leaf, steady
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.errors import DataError, PictureError
from swarmvision.geometry import FloatArray
from swarmvision.rendering.appearance import Appearance
from swarmvision.rendering.boxes import box_reach, box_sheet
from swarmvision.rendering.culling import SIZE, WIDTH, YAW, X, Y, bound, cull, hide, sort
from swarmvision.rendering.cylinders import circle_reach, cylinder_sheet
from swarmvision.rendering.painting import paint_sheet
from swarmvision.rendering.sheet import NEAR, RISE, Singles, as_above
from swarmvision.rendering.stage import (
    BODY,
    BOX,
    COURT,
    CYLINDER,
    MARKER,
    Image,
    Places,
    Scratch,
    Stage,
)

ROOM = 16  # robots that fit at first


Inputs = tuple[FloatArray, FloatArray, int, FloatArray, Stage, Scratch]


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

        Raises:
            DataError: If the pose is not three numbers.
            PictureError: If ``out`` cannot be drawn into.
        """
        image = self.canvas(out)
        _draw(flat(image), *self.inputs(scene, lens_pose, observer), True)
        if self._maps is not None:
            image = cv2.remap(image, *self._maps, cv2.INTER_LINEAR, None, cv2.BORDER_REPLICATE)
        return handed_over(image, out)

    def canvas(self, out: Image | None) -> Image:
        """Return what is drawn into: ``out`` where that is one piece of memory, else a new picture.

        Raises:
            PictureError: If ``out`` is not of this lens's shape, or not of bytes that may be written.
        """
        if out is None:
            return np.empty(self.shape, dtype=np.uint8)
        if out.shape != self.shape or out.dtype != np.uint8 or not out.flags.writeable:
            kind = "" if out.flags.writeable else "read-only "
            raise PictureError(
                f"a picture is drawn into uint8 of shape {self.shape}, got {kind}{out.dtype} of {out.shape}"
            )
        return out if out.flags.c_contiguous else np.empty(self.shape, dtype=np.uint8)

    def inputs(self, scene: Scene, lens_pose: FloatArray, observer: int | None) -> Inputs:
        """Return what :func:`draw` is told between the picture and whether to write all rows.

        Raises:
            DataError: If the pose is not three numbers.
        """
        pose = np.array(lens_pose, dtype=np.float64)
        if pose.shape != (3,):
            raise DataError(f"the pose of a lens is x, y, yaw, shape (3,), got shape {pose.shape}")
        who = -1 if observer is None else observer
        return pose, scene.pose, who, scene.object_pose, self.stage, self.brushes(scene.robots)

    def brushes(self, robots: int) -> Scratch:
        """Return this thread's own memory for pictures with up to so many robots."""
        memory = self._memory
        if getattr(memory, "robots", -1) < robots:
            memory.robots = max(robots, ROOM)
            memory.scratch = self.scratch(memory.robots)
        scratch: Scratch = memory.scratch
        return scratch


def flat(image: Image) -> Image:
    """Return a picture as kernels take it, ``(h, 3 w)``."""
    return image.reshape(image.shape[0], -1)


def handed_over(image: Image, out: Image | None) -> Image:
    """Return a picture in ``out`` where that is given."""
    if out is None or out is image:
        return image
    out[:] = image
    return out


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
    used = cull(width, lens_pose, robots, observer, objects, stage, scratch.solids, scratch.parts)
    sort(used, view, scratch.solids, scratch.order)
    hide(used, stage, scratch)
    bound(used, height, stage, scratch)
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
        if (y < first or y >= last) and (whole or not as_above(y, alike)):
            band = 0 if y < first else 1
            for i in range(3 * width):
                image[y, i] = backdrop[band, i]
    window[0], window[1] = first, last


_draw = steady(draw)
