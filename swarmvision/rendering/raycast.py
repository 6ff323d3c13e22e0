"""Analytic column ray caster, the default renderer: needs no graphics library.

The world is boxes, upright cylinders, a floor and four walls, and the lens is level, so a column of
the picture is one vertical plane: background row by row, then in each column the solids that it
meets, far to near. What is out of sight is culled by its tangents and costs nothing. A distorted
lens is drawn straight and bent afterwards.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.colour import decode, encode, rgb
from swarmvision.compiled import compiled
from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.geometry import FloatArray, compose, inverse
from swarmvision.marker import Marker
from swarmvision.rendering.appearance import Appearance
from swarmvision.rendering.columns import (
    CODES,
    NEAREST,
    SPANS,
    SUB,
    Image,
    box_hit,
    box_reach,
    box_spans,
    cylinder_reach,
    cylinder_spans,
    paint,
    row_of,
    shade,
)

DECODE = decode(np.arange(256)).astype(np.float32)
ENCODE = np.rint(encode(np.arange(CODES) / (CODES - 1))).astype(np.uint8)
NO_KNOTS = np.zeros((2, 3))
BOX, CYLINDER, CARRIER = 0, 1, 2  # kinds of solid; a carrier is a box with mast and marker


class Raycaster:
    """Draws what one kind of lens sees in one arena of equal robots; threads may share it."""

    def __init__(
        self, lens: Lens, robot: RobotConfig, arena: ArenaConfig, appearance: Appearance | None = None
    ) -> None:
        """Prepare colours and tables."""
        look = appearance or Appearance()
        marker = Marker.from_config(robot.marker)
        self._lens = lens
        self._light = look.light
        self._view = np.array([lens.focal_px, *lens.centre_px, lens.height])
        self._body = np.array([robot.length / 2, robot.width / 2, robot.body_height, marker.radius])
        self._mast = np.array([robot.mast_radius, marker.base, robot.body_height])
        self._paints = decode([rgb(look.body_colour), rgb(look.mast_colour)])
        self._heights, self._colours, self._knots, self._patterned = _skin(marker)
        self._objects = [_object_row(thing) for thing in arena.objects]
        self._court = np.array([arena.width / 2.0, arena.depth / 2.0, arena.wall_height])
        self._ground = np.array([look.beyond, decode(rgb(look.wall_colour)), look.floor])
        self._maps = _bending_maps(lens) if lens.is_distorted else None

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
        if out is None:
            out = np.empty((self._lens.height_px, self._lens.width_px, 3), dtype=np.uint8)
        lens_from_world = inverse(lens_pose)
        robots = compose(lens_from_world, scene.pose)
        if observer is not None:
            robots = np.delete(robots, observer, axis=0)
        objects = np.zeros((len(self._objects), 10))
        for i, row in enumerate(self._objects):
            objects[i] = row
            objects[i, 1:4] = compose(lens_from_world, scene.object_pose[i])
        direction = self._light.direction
        yaw = float(lens_pose[2])
        cos, sin = math.cos(yaw), math.sin(yaw)
        light = np.array(
            [
                self._light.ambient,
                self._light.diffuse,
                cos * direction[0] + sin * direction[1],
                -sin * direction[0] + cos * direction[1],
                direction[2],
            ]
        )
        pose = np.array(lens_pose, dtype=np.float64)
        _draw_background(out, self._view, light, pose, self._court, self._ground, DECODE, ENCODE)
        _draw_solids(
            out,
            self._view,
            light,
            robots,
            objects,
            self._body,
            self._mast,
            self._paints,
            self._heights,
            self._colours,
            self._knots,
            self._patterned,
            DECODE,
            ENCODE,
        )
        if self._maps is not None:
            straight = out.copy()
            cv2.remap(straight, *self._maps, cv2.INTER_LINEAR, out, cv2.BORDER_REPLICATE)
        return out


def _skin(marker: Marker) -> tuple[FloatArray, FloatArray, FloatArray, int]:
    """Return band edges above the ground, colours, knots and the patterned band's number."""
    heights = np.array([marker.height, *(band.bottom for band in marker.bands)]) + marker.base
    colours = [band.colour for band in marker.bands]
    carrier = marker.patterned
    if carrier is None or carrier.pattern is None:
        return heights, decode([*colours, colours[0]]), NO_KNOTS, -1
    knots = carrier.pattern.knots + np.array([0.0, marker.base, marker.base])
    return heights, decode([*colours, carrier.pattern.colour]), knots, marker.bands.index(carrier)


def _object_row(thing: BoxConfig | DiscConfig) -> FloatArray:
    """Return kind, pose (filled in later), half length or radius, half width, height, linear colour."""
    if isinstance(thing, DiscConfig):
        sizes = (CYLINDER, 0, 0, 0, thing.radius, thing.radius, thing.height)
    else:
        sizes = (BOX, 0, 0, 0, thing.length / 2, thing.width / 2, thing.height)
    return np.array([*sizes, *decode(rgb(thing.colour))])


def _bending_maps(lens: Lens) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return where each pixel of the distorted picture comes from, as OpenCV's remap wants it."""
    rows, columns = np.mgrid[: lens.height_px, : lens.width_px] + 0.5
    straight = lens.undistort(np.stack([columns, rows], axis=-1)) - 0.5  # OpenCV counts centres from 0
    return straight[..., 0].astype(np.float32), straight[..., 1].astype(np.float32)


@compiled
def _draw_background(
    image: Image,
    view: FloatArray,
    light: FloatArray,
    pose: FloatArray,
    court: FloatArray,
    ground: FloatArray,
    decode: NDArray[np.float32],
    encode: Image,
) -> None:
    """Fill the picture with sky, walls and floor, row by row; ``pose`` is of the lens in the world."""
    height, width = image.shape[0], image.shape[1]
    tops, bottoms = np.empty(width), np.empty(width)
    wall = np.empty((width, 3))
    template = np.empty((3, width, 3), dtype=np.uint8)
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for column in range(width):
        slope = (view[1] - column - 0.5) / view[0]
        step_x, step_y = cos - sin * slope, sin + cos * slope
        # Depth at which the ray leaves the court through a wall across x or across y.
        across_x = (math.copysign(court[0], step_x) - pose[0]) / (step_x if abs(step_x) > 1e-12 else 1e-12)
        across_y = (math.copysign(court[1], step_y) - pose[1]) / (step_y if abs(step_y) > 1e-12 else 1e-12)
        depth = max(min(across_x, across_y), NEAREST)
        if across_x < across_y:
            out_x, out_y = math.copysign(1.0, step_x), 0.0
        else:
            out_x, out_y = 0.0, math.copysign(1.0, step_y)
        # The inner face looks back; its normal in the lens frame.
        factor = shade(light, -(cos * out_x + sin * out_y), -(-sin * out_x + cos * out_y), 0.0)
        tops[column] = row_of(view, court[2], depth)
        bottoms[column] = row_of(view, 0.0, depth)
        for channel in range(3):
            wall[column, channel] = ground[1, channel] * factor
            for part in range(3):
                value = wall[column, channel] if part == 1 else ground[part, channel]
                template[part, column, channel] = encode[int(min(value, 1.0) * (CODES - 1) + 0.5)]
    top_first, top_last = tops.min(), tops.max()
    bottom_first, bottom_last = bottoms.min(), bottoms.max()
    for row in range(height):
        if row + 1 <= top_first:
            image[row] = template[0]
        elif row >= bottom_last:
            image[row] = template[2]
        elif row >= top_last and row + 1 <= bottom_first:
            image[row] = template[1]
        else:
            for column in range(width):
                above = min(max(tops[column] - row, 0.0), 1.0)
                below = min(max(row + 1.0 - bottoms[column], 0.0), 1.0)
                for channel in range(3):
                    value = (
                        above * ground[0, channel]
                        + below * ground[2, channel]
                        + (1.0 - above - below) * wall[column, channel]
                    )
                    image[row, column, channel] = encode[int(min(max(value, 0.0), 1.0) * (CODES - 1) + 0.5)]


@compiled
def _draw_solids(
    image: Image,
    view: FloatArray,
    light: FloatArray,
    robots: FloatArray,
    objects: FloatArray,
    body: FloatArray,
    mast: FloatArray,
    paints: FloatArray,
    heights: FloatArray,
    colours: FloatArray,
    knots: FloatArray,
    patterned: int,
    decode: NDArray[np.float32],
    encode: Image,
) -> None:
    """Paint robots and objects, in every column far to near."""
    count = len(robots) + len(objects)
    solids, tints = np.empty((count, 6)), np.empty((count, 3))
    reaches, kinds = np.empty((count, 2)), np.empty(count, dtype=np.int64)
    used = _cull(view, image.shape[1], robots, objects, body, paints, solids, tints, reaches, kinds)
    edges, lights = np.empty((SUB, SPANS + 1)), np.empty((SUB, SPANS, 3))
    order, depths = np.empty(used, dtype=np.int64), np.empty(used)
    plain, plain_colours = np.empty(2), np.empty((2, 3))
    pole = np.empty(4)
    for column in range(image.shape[1]):
        for j in range(_order(view, column, solids, reaches, kinds, used, order, depths)):
            i = order[j]
            solid, reach = solids[i], (reaches[i, 0], reaches[i, 1])
            pole[:3] = solid[:3]
            if kinds[i] == CYLINDER:
                pole[3], plain[0], plain[1] = solid[3], solid[5], 0.0
                plain_colours[:] = tints[i]
                spans, hits, cover = cylinder_spans(
                    view, light, pole, plain, plain_colours, knots, -1, reach, column, edges, lights
                )
            else:
                spans, hits, cover = box_spans(view, light, solid, tints[i], reach, column, edges, lights)
            if hits > 0:
                paint(image, column, spans, hits, cover, edges, lights, decode, encode)
            if kinds[i] != CARRIER:
                continue
            pole[3], plain[0], plain[1] = mast[0], mast[1], mast[2]
            plain_colours[:] = paints[1]
            reach = cylinder_reach(view, pole[0], pole[1], pole[3])
            spans, hits, cover = cylinder_spans(
                view, light, pole, plain, plain_colours, knots, -1, reach, column, edges, lights
            )
            if hits > 0:
                paint(image, column, spans, hits, cover, edges, lights, decode, encode)
            pole[3] = body[3]
            reach = cylinder_reach(view, pole[0], pole[1], pole[3])
            spans, hits, cover = cylinder_spans(
                view, light, pole, heights, colours, knots, patterned, reach, column, edges, lights
            )
            if hits > 0:
                paint(image, column, spans, hits, cover, edges, lights, decode, encode)


@compiled
def _cull(
    view: FloatArray,
    width: int,
    robots: FloatArray,
    objects: FloatArray,
    body: FloatArray,
    paints: FloatArray,
    solids: FloatArray,
    tints: FloatArray,
    reaches: FloatArray,
    kinds: NDArray[np.int64],
) -> int:
    """List what can be in view: shape, colour, columns and kind of each; return how many."""
    used = 0
    for i in range(len(robots) + len(objects)):
        if i < len(robots):
            kinds[used] = CARRIER
            solids[used, :3] = robots[i]
            solids[used, 3:] = body[:3]
            tints[used] = paints[0]
        else:
            thing = objects[i - len(robots)]
            kinds[used] = int(thing[0])
            solids[used] = thing[1:7]
            tints[used] = thing[7:10]
        if kinds[used] == CYLINDER:
            left, right = cylinder_reach(view, solids[used, 0], solids[used, 1], solids[used, 3])
        else:
            left, right = box_reach(view, solids[used])
        if right > 0.0 and left < width and right > left:
            reaches[used, 0], reaches[used, 1] = left, right
            used += 1
    return used


@compiled
def _order(
    view: FloatArray,
    column: int,
    solids: FloatArray,
    reaches: FloatArray,
    kinds: NDArray[np.int64],
    used: int,
    order: NDArray[np.int64],
    depths: FloatArray,
) -> int:
    """Sort the solids that a column meets, far to near; return how many."""
    met = 0
    for i in range(used):
        if reaches[i, 1] <= column or reaches[i, 0] >= column + 1.0:
            continue
        middle = (max(reaches[i, 0], float(column)) + min(reaches[i, 1], column + 1.0)) / 2.0
        depth = _depth(view, solids[i], kinds[i], middle)
        place = met
        while place > 0 and depths[place - 1] < depth:
            depths[place], order[place] = depths[place - 1], order[place - 1]
            place -= 1
        depths[place], order[place] = depth, i
        met += 1
    return met


@compiled
def _depth(view: FloatArray, solid: FloatArray, kind: int, column: float) -> float:
    """Return the depth (m) at which a column (px) meets a solid; disjoint convex solids order by it."""
    slope = (view[1] - column) / view[0]
    a: float = 1.0 + slope * slope
    b: float = solid[0] + slope * solid[1]
    if kind == CYLINDER:
        under: float = b * b - a * (solid[0] * solid[0] + solid[1] * solid[1] - solid[3] * solid[3])
        return (b - math.sqrt(max(under, 0.0))) / a
    near, far, _, _ = box_hit(view, solid, column)
    return near if near < far else b / a
