"""Reference renderer: triangles through pyrender over EGL; the only importer of OpenGL.

It shares :mod:`swarmvision.rendering.appearance` with the ray caster and nothing else: true geometry
in fine facets, light baked per facet, depth by the graphics library's own buffer, anti-aliasing by
drawing several times larger and averaging in linear light. One off-screen context serves a process;
OpenGL belongs to the thread that began it.
"""

from __future__ import annotations

import os
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.colour import decode, encode, rgb
from swarmvision.config.arena import ArenaConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.errors import RenderingError
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.rendering.appearance import UP, Appearance

Image = NDArray[np.uint8]
FACETS = 360  # of a cylinder
SUPERSAMPLE = 4  # each way
NEAR, FAR = 0.004, 60.0  # m, clipping planes
INSTALL = (
    "the mesh renderer needs pyrender (pip install 'swarmvision[mesh]') and EGL from the "
    "distribution (on Debian: apt install libegl1 libgl1)"
)


class MeshRenderer:
    """Draws what one kind of lens sees, as :class:`swarmvision.rendering.raycast.Raycaster` does."""

    def __init__(
        self, lens: Lens, robot: RobotConfig, arena: ArenaConfig, appearance: Appearance | None = None
    ) -> None:
        """Prepare the shapes.

        Raises:
            RenderingError: If pyrender or EGL is missing; tells what to install.
        """
        self._lens = lens
        self._look = appearance or Appearance()
        self._robot = _robot_shape(robot, Marker.from_config(robot.marker), self._look)
        self._court = _court_shape(arena, self._look)
        self._objects = [_object_shape(thing) for thing in arena.objects]
        library()

    def render(
        self, scene: Scene, lens_pose: FloatArray, observer: int | None = None, out: Image | None = None
    ) -> Image:
        """Return the picture of a scene, sRGB ``(h, w, 3)``; arguments as for the ray caster."""
        pieces = [self._lit(self._court, np.zeros(3))]
        pieces += [self._lit(self._robot, pose) for i, pose in enumerate(scene.pose) if i != observer]
        pieces += [
            self._lit(shape, pose) for shape, pose in zip(self._objects, scene.object_pose, strict=True)
        ]
        large = self._drawn(np.concatenate(pieces), lens_pose)
        light = decode(np.arange(256)).astype(np.float32)[large]
        size = (self._lens.width_px, self._lens.height_px)
        small = cv2.resize(light, size, interpolation=cv2.INTER_AREA).reshape(size[1], size[0], 3)
        image = np.rint(encode(small)).astype(np.uint8)
        if out is None:
            return image
        out[:] = image
        return out

    def _lit(self, shape: FloatArray, pose: FloatArray) -> FloatArray:
        """Return triangles ``(n, 4, 3)`` of corners and sRGB, placed in the world and shaded."""
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        corners = shape[:, :3] @ turn.T + [pose[0], pose[1], 0.0]
        normals = shape[:, 3] @ turn.T
        colours = shape[:, 4] * self._look.light.shade(normals)[:, None]
        return np.concatenate([corners, encode(colours)[:, None]], axis=1)

    def _drawn(self, triangles: FloatArray, lens_pose: FloatArray) -> Image:
        pyrender = library()
        corners = triangles[:, :3].reshape(-1, 3)
        colours = np.repeat(triangles[:, 3], 3, axis=0) / 255.0
        primitive = pyrender.Primitive(
            positions=corners.astype(np.float32),
            color_0=np.column_stack([colours, np.ones(len(colours))]).astype(np.float32),
            material=pyrender.MetallicRoughnessMaterial(doubleSided=True),
        )
        beyond = encode(self._look.beyond) / 255.0
        scene = pyrender.Scene(bg_color=[*beyond, 1.0])
        scene.add(pyrender.Mesh([primitive]))
        lens, s = self._lens, SUPERSAMPLE
        camera = pyrender.IntrinsicsCamera(
            lens.focal_px * s, lens.focal_px * s, lens.centre_px[0] * s, lens.centre_px[1] * s, NEAR, FAR
        )
        scene.add(camera, pose=camera_pose(lens_pose, lens.height))
        renderer = offscreen()
        renderer.viewport_width, renderer.viewport_height = lens.width_px * s, lens.height_px * s
        flags = pyrender.RenderFlags.FLAT | pyrender.RenderFlags.SKIP_CULL_FACES
        colour: Image = renderer.render(scene, flags=flags)[0]
        return colour


def graphics() -> str:
    """Return the name of the graphics driver.

    Raises:
        RenderingError: If there is none.
    """
    offscreen()
    from OpenGL import GL

    return str(GL.glGetString(GL.GL_RENDERER).decode())


@lru_cache(maxsize=1)
def library() -> Any:
    """Return pyrender, told to draw through EGL.

    Raises:
        RenderingError: If it cannot be imported; tells what to install.
    """
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
    try:
        import pyrender
    except Exception as fault:  # PyOpenGL raises whatever its loader happens on
        raise RenderingError(f"{INSTALL}: {fault}") from None
    return pyrender


@lru_cache(maxsize=1)
def offscreen() -> Any:
    """Return the process's one off-screen renderer; deleting it would end every other one's display.

    Raises:
        RenderingError: If there is none.
    """
    try:
        return library().OffscreenRenderer(64, 64)
    except RenderingError:
        raise
    except Exception as fault:  # EGL fails in many ways, all of which mean the same here
        raise RenderingError(f"{INSTALL}: {fault}") from None


def camera_pose(lens_pose: FloatArray, height: float) -> FloatArray:
    """Return OpenGL's camera (x right, y up, looking along -z) for a level lens, ``(4, 4)``."""
    cos, sin = np.cos(lens_pose[2]), np.sin(lens_pose[2])
    pose = np.eye(4)
    pose[:3, 0] = (sin, -cos, 0.0)
    pose[:3, 1] = (0.0, 0.0, 1.0)
    pose[:3, 2] = (-cos, -sin, 0.0)
    pose[:3, 3] = (lens_pose[0], lens_pose[1], height)
    return pose


# A shape is triangles (n, 5, 3): three corners, the normal, the linear light of its print.


def _quad(a: Any, b: Any, c: Any, d: Any, normal: Any, light: FloatArray) -> list[list[Any]]:
    """Return two triangles of a flat quadrilateral."""
    return [[a, b, c, normal, light], [a, c, d, normal, light]]


def _box_shape(length: float, width: float, low: float, high: float, light: FloatArray) -> FloatArray:
    x, y = length / 2.0, width / 2.0
    ring = [(x, y), (-x, y), (-x, -y), (x, -y)]
    normals = [(0, 1, 0), (-1, 0, 0), (0, -1, 0), (1, 0, 0)]
    faces: list[list[Any]] = []
    for i, normal in enumerate(normals):
        (ax, ay), (bx, by) = ring[i], ring[(i + 1) % 4]
        faces += _quad((ax, ay, low), (bx, by, low), (bx, by, high), (ax, ay, high), normal, light)
    a, b, c, d = ((px, py, high) for px, py in ring)
    faces += _quad(a, b, c, d, UP, light)
    return np.array(faces, dtype=np.float64)


def _cylinder_shape(radius: float, bands: list[tuple[FloatArray, FloatArray, FloatArray]]) -> FloatArray:
    """Return a tube of bands: low and high edge at the facets' two sides ``(FACETS, 2)``, and light."""
    angle = np.linspace(0.0, 2.0 * np.pi, FACETS + 1)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    middle = (angle[:-1] + angle[1:]) / 2.0
    faces: list[list[Any]] = []
    for low, high, light in bands:
        for i in range(FACETS):
            left, right = (x[i], y[i]), (x[i + 1], y[i + 1])
            normal = (np.cos(middle[i]), np.sin(middle[i]), 0.0)
            faces += _quad(
                (*left, low[i, 0]),
                (*right, low[i, 1]),
                (*right, high[i, 1]),
                (*left, high[i, 0]),
                normal,
                light,
            )
    _, top, light = bands[0]
    for i in range(FACETS):
        faces.append([(0, 0, top[i, 0]), (x[i], y[i], top[i, 0]), (x[i + 1], y[i + 1], top[i, 1]), UP, light])
    return np.array(faces, dtype=np.float64)


def _level(height: float) -> FloatArray:
    return np.full((FACETS, 2), height)


def _marker_bands(marker: Marker) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    angle = np.linspace(0.0, 2.0 * np.pi, FACETS + 1)
    inset = 1e-9  # a facet's sides lie within it, so that a jump between facets is a jump
    sides = np.stack([angle[:-1] + inset, angle[1:] - inset], axis=1)
    bands = []
    for band in marker.bands:
        low, high, light = band.bottom + marker.base, band.top + marker.base, decode(band.colour)
        if band.pattern is None:
            bands.append((_level(low), _level(high), light))
            continue
        below, above = (edge + marker.base for edge in band.pattern.span(sides))
        bands.append((above, _level(high), light))
        bands.append((below, above, decode(band.pattern.colour)))
        bands.append((_level(low), below, light))
    return bands


def _robot_shape(robot: RobotConfig, marker: Marker, look: Appearance) -> FloatArray:
    body = _box_shape(robot.length, robot.width, 0.0, robot.body_height, decode(rgb(look.body_colour)))
    mast_band = (_level(robot.body_height), _level(marker.base), decode(rgb(look.mast_colour)))
    mast = _cylinder_shape(robot.mast_radius, [mast_band])
    return np.concatenate([body, mast, _cylinder_shape(marker.radius, _marker_bands(marker))])


def _object_shape(thing: Any) -> FloatArray:
    light = decode(rgb(thing.colour))
    if isinstance(thing, DiscConfig):
        return _cylinder_shape(thing.radius, [(_level(0.0), _level(thing.height), light)])
    return _box_shape(thing.length, thing.width, 0.0, thing.height, light)


def _court_shape(arena: ArenaConfig, look: Appearance) -> FloatArray:
    x, y, h = arena.width / 2.0, arena.depth / 2.0, arena.wall_height
    floor, wall = decode(rgb(look.floor_colour)), decode(rgb(look.wall_colour))
    ring = [(x, y), (-x, y), (-x, -y), (x, -y)]
    inward = [(0, -1, 0), (1, 0, 0), (0, 1, 0), (-1, 0, 0)]
    a, b, c, d = ((px, py, 0.0) for px, py in ring)
    faces = _quad(a, b, c, d, UP, floor)
    for i, normal in enumerate(inward):
        (ax, ay), (bx, by) = ring[i], ring[(i + 1) % 4]
        faces += _quad((ax, ay, 0), (bx, by, 0), (bx, by, h), (ax, ay, h), normal, wall)
    return np.array(faces, dtype=np.float64)
