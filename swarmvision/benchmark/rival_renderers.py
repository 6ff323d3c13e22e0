"""Renderers of others: each a call that draws one picture."""

from __future__ import annotations

import os
import tempfile
from contextlib import ExitStack, chdir
from pathlib import Path
from typing import Any

import numpy as np

from swarmvision.benchmark.stage import ARENA, LENS, LENS_POSE, MARKER, ROBOT, Image
from swarmvision.benchmark.timing import Call
from swarmvision.camera import Lens
from swarmvision.colour import rgb
from swarmvision.data import Scene


def vizdoom(closing: ExitStack) -> Call:
    """Return one tic of a Doom level with monsters in view, drawn at 640x480 without a window."""
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
    os.environ.setdefault("SDL_AUDIODRIVER", "dummy")
    import vizdoom as doom

    game = doom.DoomGame()
    game.load_config(str(Path(doom.scenarios_path) / "defend_the_center.cfg"))
    folder = closing.enter_context(tempfile.TemporaryDirectory())  # for what the engine writes, else here
    closing.enter_context(chdir(folder))
    game.set_doom_config_path(str(Path(folder) / "settings.ini"))
    game.set_window_visible(False)
    game.set_sound_enabled(False)
    game.set_screen_resolution(doom.ScreenResolution.RES_640X480)
    game.set_screen_format(doom.ScreenFormat.RGB24)
    game.set_episode_timeout(0)
    game.set_seed(1)
    game.init()
    closing.callback(game.close)

    def tic() -> Any:
        if game.is_episode_finished():
            game.new_episode()
        game.advance_action(1)
        state = game.get_state()
        return None if state is None else state.screen_buffer

    return tic


def pybullet(closing: ExitStack, scene: Scene) -> Call:
    """Return a picture by the software renderer (TinyRenderer), each robot a box and a cylinder."""
    import pybullet as bullet

    client = bullet.connect(bullet.DIRECT)
    closing.callback(bullet.disconnect, client)
    height = MARKER.height
    pole = bullet.createVisualShape(
        bullet.GEOM_CYLINDER, radius=MARKER.radius, length=height, rgbaColor=[1, 0, 0, 1]
    )
    half = [ROBOT.length / 2.0, ROBOT.width / 2.0, ROBOT.body_height / 2.0]
    body = bullet.createVisualShape(bullet.GEOM_BOX, halfExtents=half, rgbaColor=[0.2, 0.2, 0.2, 1])
    floor = bullet.createVisualShape(
        bullet.GEOM_BOX, halfExtents=[ARENA.width / 2.0, ARENA.depth / 2.0, 0.001]
    )
    bullet.createMultiBody(0, -1, floor, [0, 0, 0])
    for x, y, yaw in scene.pose[1:]:
        turn = bullet.getQuaternionFromEuler([0.0, 0.0, float(yaw)])
        bullet.createMultiBody(0, -1, body, [x, y, half[2]], turn)
        bullet.createMultiBody(0, -1, pole, [x, y, MARKER.base + height / 2.0], turn)
    eye = [LENS_POSE[0], LENS_POSE[1], LENS.height]
    view = bullet.computeViewMatrix(eye, [eye[0] + 1.0, eye[1], eye[2]], [0, 0, 1])
    fov = np.degrees(2.0 * np.arctan2(LENS.height_px / 2.0, LENS.focal_px))
    lens = bullet.computeProjectionMatrixFOV(float(fov), LENS.width_px / LENS.height_px, 0.01, 30.0)

    def picture() -> Any:
        return bullet.getCameraImage(
            LENS.width_px, LENS.height_px, view, lens, shadow=0, renderer=bullet.ER_TINY_RENDERER
        )

    return picture


class PlainPyrender:
    """What a program gets that calls pyrender plainly: meshes uploaded once, one sample a pixel.

    Coarser than our reference renderer (which draws 16 samples a pixel): cylinders of 32 facets, no shading
    unless asked for.
    """

    def __init__(self, lens: Lens, robots: int, *, shaded: bool = False) -> None:
        """Build a scene of so many robots.

        Raises:
            Exception: Whatever pyrender, trimesh or the graphics library raises where something is missing.
        """
        os.environ.setdefault("LP_NUM_THREADS", "1")  # of Mesa's software rasteriser; the others have one
        from swarmvision.rendering.mesh import library, offscreen

        pyrender = library()
        self._lens, self._renderer = lens, offscreen()
        self._flags = pyrender.RenderFlags.NONE if shaded else pyrender.RenderFlags.FLAT
        self._scene = pyrender.Scene(
            bg_color=[*(np.array(rgb("#c3c3c3")) / 255.0), 1.0], ambient_light=[0.5, 0.5, 0.5]
        )
        self._scene.add(pyrender.Mesh.from_trimesh(_court(), smooth=False))
        shape = pyrender.Mesh.from_trimesh(_robot(), smooth=False)
        self._robots = [self._scene.add(shape) for _ in range(robots)]
        focal, (column, row) = lens.focal_px, lens.centre_px
        self._camera = self._scene.add(pyrender.IntrinsicsCamera(focal, focal, column, row, 0.01, 60.0))
        if shaded:
            self._scene.add(pyrender.DirectionalLight(intensity=3.0), pose=np.eye(4))

    def render(self, scene: Scene, lens_pose: Any, observer: int) -> Image:
        """Return the picture of a scene, as our renderers do."""
        from swarmvision.rendering.mesh import camera_pose

        others = [pose for i, pose in enumerate(scene.pose) if i != observer]
        for node, (x, y, yaw) in zip(self._robots, others, strict=True):
            place = np.eye(4)
            place[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
            place[:2, 3] = x, y
            self._scene.set_pose(node, place)
        self._scene.set_pose(self._camera, camera_pose(lens_pose, self._lens.height))
        self._renderer.viewport_width = self._lens.width_px
        self._renderer.viewport_height = self._lens.height_px
        image: Image = self._renderer.render(self._scene, flags=self._flags)[0]
        return image


def _robot() -> Any:
    """Return one robot as a trimesh: chassis, mast, and the marker's bands, its pattern as a stripe."""
    import trimesh

    body = trimesh.creation.box((ROBOT.length, ROBOT.width, ROBOT.body_height))
    body.apply_translation((0, 0, ROBOT.body_height / 2.0))
    body.visual.vertex_colors = (44, 44, 48, 255)
    parts = [body, _tube(ROBOT.mast_radius, ROBOT.body_height, MARKER.base, (58, 58, 60))]
    for band in MARKER.bands:
        parts.append(_tube(MARKER.radius, MARKER.base + band.bottom, MARKER.base + band.top, band.colour))
        if band.pattern is not None:
            parts.append(_stripe(MARKER.radius * 1.002, band.pattern))
    return trimesh.util.concatenate(parts)


def _tube(radius: float, low: float, high: float, colour: tuple[int, int, int]) -> Any:
    import trimesh

    tube = trimesh.creation.cylinder(radius, high - low, sections=32)
    tube.apply_translation((0, 0, (low + high) / 2.0))
    tube.visual.vertex_colors = (*colour, 255)
    return tube


def _stripe(radius: float, pattern: Any) -> Any:
    import trimesh

    angle = np.linspace(1e-6, 2.0 * np.pi - 1e-6, 33)
    edges = np.stack(pattern.span(angle)) + MARKER.base  # (2, 33)
    round_ = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    corners = np.concatenate([np.column_stack([round_, edge]) for edge in edges])
    i = np.arange(32)
    faces = np.concatenate([np.stack([i, i + 1, i + 34], -1), np.stack([i, i + 34, i + 33], -1)])
    stripe = trimesh.Trimesh(corners, faces, process=False)
    stripe.visual.vertex_colors = (*pattern.colour, 255)
    return stripe


def _court() -> Any:
    import trimesh

    floor = trimesh.creation.box((ARENA.width, ARENA.depth, 0.01))
    floor.apply_translation((0, 0, -0.005))
    floor.visual.vertex_colors = (*rgb("#dcdcd8"), 255)
    parts = [floor]
    for x, y, length, width in (
        (ARENA.width / 2, 0, 0.02, ARENA.depth),
        (-ARENA.width / 2, 0, 0.02, ARENA.depth),
        (0, ARENA.depth / 2, ARENA.width, 0.02),
        (0, -ARENA.depth / 2, ARENA.width, 0.02),
    ):
        wall = trimesh.creation.box((length, width, ARENA.wall_height))
        wall.apply_translation((x, y, ARENA.wall_height / 2))
        wall.visual.vertex_colors = (*rgb("#cfcfca"), 255)
        parts.append(wall)
    return trimesh.util.concatenate(parts)
