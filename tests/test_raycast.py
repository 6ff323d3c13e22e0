"""The ray caster against brute force, and its laws."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.colour import decode, encode, rgb
from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.camera import LENSES, LensConfig
from swarmvision.config.marker import PRESETS, MarkerConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import BoolArray, Scene
from swarmvision.geometry import FloatArray, compose
from swarmvision.marker import SHAPES, Marker
from swarmvision.rendering import cylinders
from swarmvision.rendering.appearance import Appearance, Light
from swarmvision.rendering.raycast import Raycaster

SMALL = Lens.from_config(LensConfig(width_px=128, height_px=92, focal_px=126.9))
LENS = Lens.from_config(LENSES["pi-v1"])
ROBOT, ARENA = RobotConfig(), ArenaConfig(width=3.0, depth=3.0)
EYE = np.array([0.0, 0.0, 0.0])
ALL = slice(None)
SAMPLES = 8  # each way


def random_poses(seed: int, robots: int = 4) -> FloatArray:
    rng = np.random.default_rng(seed)
    distance = np.linspace(0.2, 1.2, robots) + rng.uniform(-0.05, 0.05, robots)
    bearing = rng.uniform(-0.45, 0.45, robots)
    return np.column_stack(
        [distance * np.cos(bearing), distance * np.sin(bearing), rng.uniform(-np.pi, np.pi, robots)]
    )


def brute_force(poses: FloatArray) -> FloatArray:
    """Shoot many rays a pixel against every surface, written without a thought to speed, in linear light."""
    look, marker, light = Appearance(), Marker.from_config(ROBOT.marker), Light()
    steps = (np.arange(SAMPLES) + 0.5) / SAMPLES
    rows = (np.arange(SMALL.height_px)[:, None] + steps).ravel()
    cols = (np.arange(SMALL.width_px)[:, None] + steps).ravel()
    rise, slope = (SMALL.centre_px[1] - rows) / SMALL.focal_px, (SMALL.centre_px[0] - cols) / SMALL.focal_px
    v, u = np.meshgrid(rise, slope, indexing="ij")
    step = np.stack([np.ones_like(u), u, v], axis=-1)  # depth 1
    best = np.full(u.shape, np.inf)
    colour = np.broadcast_to(look.beyond, step.shape).copy()

    def hit(
        depth: FloatArray, where: BoolArray, print_: FloatArray, normal: FloatArray, columns: slice = ALL
    ) -> None:
        nearer = where & (depth > 1e-6) & (depth < best[:, columns])
        best[:, columns][nearer] = depth[nearer]
        shape = (*depth.shape, 3)
        print_, normal = np.broadcast_to(print_, shape)[nearer], np.broadcast_to(normal, shape)[nearer]
        colour[:, columns][nearer] = print_ * light.shade(normal)[:, None]

    eye = np.array([0.0, 0.0, SMALL.height])
    with np.errstate(all="ignore"):
        floor = -eye[2] / step[..., 2]
        hit(floor, np.isfinite(floor), decode(rgb(look.floor_colour)), np.array([0, 0, 1.0]))
        for axis, side in ((0, 1), (1, 1), (1, -1)):
            depth = side * 1.5 / step[..., axis]
            height = eye[2] + depth * step[..., 2]
            normal = np.zeros(3)
            normal[axis] = -side
            hit(depth, (height >= 0) & (height <= ARENA.wall_height), decode(rgb(look.wall_colour)), normal)
        for x, y, yaw in poses:
            # Where a ball round the robot could be seen; behind the lens nowhere.
            near = np.flatnonzero(np.abs(y - slope * x) < 0.1 * np.sqrt(1.0 + slope**2))
            if x < -0.1 or len(near) == 0:
                continue
            these = slice(near[0], near[-1] + 1)
            cos, sin = np.cos(yaw), np.sin(yaw)
            turn = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1.0]])  # robot from world
            o, s = turn @ (eye - [x, y, 0]), step[:, these] @ turn.T
            for axis, half in ((0, ROBOT.length / 2), (1, ROBOT.width / 2), (2, 0.0)):
                for side in (-1, 1):
                    wall = side * half if axis < 2 else ROBOT.body_height
                    depth = (wall - o[axis]) / s[..., axis]
                    p = o + depth[..., None] * s
                    inside = (
                        (np.abs(p[..., 0]) <= ROBOT.length / 2 + 1e-9)
                        & (np.abs(p[..., 1]) <= ROBOT.width / 2 + 1e-9)
                        & (p[..., 2] >= 0)
                        & (p[..., 2] <= ROBOT.body_height + 1e-9)
                    )
                    normal = np.zeros(3)
                    normal[axis] = side if axis < 2 else 1
                    hit(depth, inside, decode(rgb(look.body_colour)), normal @ turn, these)
            for radius, low, high in (
                (ROBOT.mast_radius, ROBOT.body_height, marker.base),
                (marker.radius, marker.base, marker.base + marker.height),
            ):
                a = s[..., 0] ** 2 + s[..., 1] ** 2
                b = o[0] * s[..., 0] + o[1] * s[..., 1]
                depth = (-b - np.sqrt(b**2 - a * (o[0] ** 2 + o[1] ** 2 - radius**2))) / a
                p = o + depth[..., None] * s
                inside = np.isfinite(depth) & (p[..., 2] >= low) & (p[..., 2] <= high)
                prints = decode(rgb(look.mast_colour))
                if radius == marker.radius:
                    prints = decode(
                        marker.colour_at(np.arctan2(p[..., 1], p[..., 0]), p[..., 2] - marker.base)
                    )
                normal = np.nan_to_num(p / radius)
                normal[..., 2] = 0
                hit(depth, inside, prints, normal @ turn, these)
    shape = (SMALL.height_px, SAMPLES, SMALL.width_px, SAMPLES, 3)
    return np.rint(encode(colour.reshape(shape).mean(axis=(1, 3))))


def test_agrees_with_brute_force() -> None:
    raycaster = Raycaster(SMALL, ROBOT, ARENA)
    differences = []
    for seed in range(24):
        poses = random_poses(seed, 1 + seed % 6)
        # 64 samples a pixel are themselves uncertain by as much at edges.
        differences.append(np.abs(raycaster.render(Scene.at_rest(poses), EYE) - brute_force(poses)))
    assert np.mean(differences) <= 0.15
    assert np.percentile(differences, 99.9) <= 16


def test_a_mirrored_scene_gives_a_mirrored_picture() -> None:
    look = Appearance(light=Light(azimuth=0.0))  # the lamp stands in the mirror's plane
    robot = ROBOT.replace(marker=PRESETS["pole-52x150"])
    raycaster = Raycaster(LENS, robot, ARENA, look)
    poses = random_poses(3)
    here = raycaster.render(Scene.at_rest(poses), EYE).astype(int)
    there = raycaster.render(Scene.at_rest(poses * [1, -1, -1]), EYE)[:, ::-1]
    assert np.abs(here - there).max() <= 1


def test_turning_the_world_about_the_lens_changes_nothing_under_an_even_sky() -> None:
    raycaster = Raycaster(LENS, ROBOT, ArenaConfig(wall_height=0.0), Appearance(light=Light(diffuse=0.0)))
    poses = random_poses(1)
    turned = compose([0.0, 0.0, 1.1], poses)
    here = raycaster.render(Scene.at_rest(poses), EYE).astype(int)
    there = raycaster.render(Scene.at_rest(turned), np.array([0.0, 0.0, 1.1]))
    assert np.mean(np.abs(here - there) > 1) < 2e-3  # the floor's horizon row and nothing else


def test_a_nearer_robot_hides_a_farther_one_whatever_their_order() -> None:
    raycaster = Raycaster(LENS, ROBOT, ARENA)
    poses = np.array([[0.3, 0, 1.0], [0.9, 0.0, 2.0]])
    both = raycaster.render(Scene.at_rest(poses), EYE)
    np.testing.assert_array_equal(both, raycaster.render(Scene.at_rest(poses[::-1]), EYE))
    alone = raycaster.render(Scene.at_rest(poses[:1]), EYE)
    np.testing.assert_array_equal(both[150:300, 310:330], alone[150:300, 310:330])


def test_what_nearer_markers_hide_changes_no_byte() -> None:
    raycaster = Raycaster(LENS, ROBOT, ARENA)
    # 0.15 m ahead a marker covers 98 columns and 146 rows to either side of the middle; at 1.4 m the floor
    # under a robot is 41 rows below it, and its corners are 33 columns from its middle.
    near = np.array([[0.15, 0.0, 1.0]])
    for y in np.linspace(-0.1, 0.1, 5):
        behind = np.array([[1.4, y, 0.3], [1.3 + abs(y), -y, 2.0]])
        hidden = raycaster.render(Scene.at_rest(np.vstack([behind, near])), EYE)
        np.testing.assert_array_equal(hidden, raycaster.render(Scene.at_rest(near), EYE))
    beside = raycaster.render(Scene.at_rest(np.vstack([[[1.4, 0.25, 0.3]], near])), EYE)
    assert (beside != raycaster.render(Scene.at_rest(near), EYE)).any()


def test_a_crowd_is_what_its_robots_are_painted_one_over_the_other() -> None:
    # Robots that hide nothing of each other, painted in any number, are the sum of their differences.
    raycaster = Raycaster(LENS, ROBOT, ARENA)
    apart = np.array([[0.5, 0.18, 0.2], [0.6, -0.02, 1.0], [0.5, -0.17, 2.0]])
    empty = raycaster.render(Scene.at_rest(apart[:0]), EYE).astype(int)
    together = raycaster.render(Scene.at_rest(apart), EYE).astype(int) - empty
    alone = sum(raycaster.render(Scene.at_rest(apart[[i]]), EYE).astype(int) - empty for i in range(3))
    np.testing.assert_array_equal(together, alone)


def test_threads_share_a_raycaster() -> None:
    raycaster = Raycaster(LENS, ROBOT, ARENA)
    scenes = [Scene.at_rest(random_poses(seed)) for seed in range(8)]
    alone = [raycaster.render(scene, EYE) for scene in scenes]
    with ThreadPoolExecutor(4) as pool:
        for one, two in zip(alone, pool.map(lambda scene: raycaster.render(scene, EYE), scenes), strict=True):
            np.testing.assert_array_equal(one, two)


def test_objects_stand_in_the_picture_where_they_stand_in_the_arena() -> None:
    arena = ARENA.replace(
        objects=(
            BoxConfig(x=0.6, y=0.2, length=0.1, width=0.1, height=0.2, colour="#00ff00"),
            DiscConfig(x=0.6, y=-0.2, radius=0.05, height=0.03, colour="#ff00ff"),
        )
    )
    image = Raycaster(LENS, ROBOT, arena).render(Scene.at_rest([], [[0.6, 0.2, 0], [0.6, -0.2, 0]]), EYE)
    green = np.argwhere((image[..., 1] > 200) & (image[..., 0] < 60))
    magenta = np.argwhere((image[..., 0] > 150) & (image[..., 1] < 60))
    # Left is left, and the middle of the near face stands at column 320 - 634.6 * 0.2 / 0.55.
    assert abs(green[:, 1].mean() - (320 - 634.6 * 0.2 / 0.55)) < 12
    assert green[:, 0].min() < 230 < magenta[:, 0].min()  # one rises over the horizon, one lies below it
    assert magenta[:, 1].mean() > 320


@pytest.mark.parametrize("size", [(1, 1), (3, 1), (1, 7)])
def test_the_smallest_pictures_are_pictures(size: tuple[int, int]) -> None:
    lens = Lens.from_config(LensConfig(width_px=size[0], height_px=size[1], focal_px=5.0))
    image = Raycaster(lens, ROBOT, ARENA).render(Scene.at_rest(random_poses(0)), EYE)
    assert image.shape == (size[1], size[0], 3)


def test_a_distorted_lens_bends_the_same_picture() -> None:
    bent = Lens.from_config(LENSES["pi-v1"].replace(distortion=(-0.1, 0, 0, 0, 0)))
    scene = Scene.at_rest([[0.5, 0.15, 1.0]])
    straight, curved = (Raycaster(lens, ROBOT, ARENA).render(scene, EYE) for lens in (LENS, bent))
    middles = [
        np.argwhere((i[..., 2] > 100) & (i[..., 0] < 70)).mean(axis=0)[::-1] + 0.5 for i in (straight, curved)
    ]
    np.testing.assert_allclose(bent.distort(middles[0]), middles[1], atol=0.7)  # masks are whole pixels


@pytest.mark.parametrize("kind", [*SHAPES])
def test_a_pattern_is_drawn_where_it_is_printed(kind: str) -> None:
    pattern = {"kind": kind, "colour": "black", "thickness": 0.01}
    bands = [{"colour": "white", "height": 0.04, "pattern": pattern}, {"colour": "red", "height": 0.01}]
    config = MarkerConfig.model_validate({"name": kind, "radius": 0.02, "bands": bands})
    printed = Marker.from_config(config).bands[0].pattern
    assert printed is not None
    for phi in np.linspace(-7, 7, 41):
        edges = cylinders.piece_edges(printed.knots, cylinders.piece_of(printed.knots, phi), phi)
        np.testing.assert_allclose(edges, [float(edge) for edge in printed.span(phi)], atol=1e-12)


def test_the_arc_sine_is_one() -> None:
    for x in np.linspace(-1.0, 1.0, 101):
        assert cylinders.arcsine(np.float32(x)) == pytest.approx(np.arcsin(x), abs=7e-5)


def picture_bytes() -> str:
    """A small picture with all kinds of things, and its fingerprint; also called in other processes."""
    lens = Lens.from_config(LensConfig(width_px=48, height_px=32, focal_px=40.0))
    arena = ARENA.replace(objects=(BoxConfig(x=0.9, y=0.4), DiscConfig(x=0.8, y=-0.3, height=0.05)))
    scene = Scene.at_rest(random_poses(5), [[0.9, 0.4, 0.5], [0.8, -0.3, 0.0]])
    return hashlib.sha256(Raycaster(lens, ROBOT, arena).render(scene, EYE).tobytes()).hexdigest()


@pytest.mark.parametrize("setting", ["NUMBA_DISABLE_JIT=1", "NUMBA_CPU_NAME=generic"])
def test_the_same_bytes_uncompiled_and_for_any_processor(setting: str, tmp_path: Path) -> None:
    name, value = setting.split("=")
    settings = {**os.environ, name: value, "NUMBA_CACHE_DIR": str(tmp_path)}
    code = f"import runpy; print(runpy.run_path({str(Path(__file__))!r})['picture_bytes']())"
    there = subprocess.run(
        [sys.executable, "-c", code], env=settings, capture_output=True, text=True, check=True
    )
    assert there.stdout.strip() == picture_bytes()
