"""The ray caster against brute force, and its laws."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.colour import decode, encode, rgb
from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.camera import LENSES, LensConfig
from swarmvision.config.marker import PRESETS
from swarmvision.config.robot import RobotConfig
from swarmvision.data import BoolArray, Scene
from swarmvision.geometry import FloatArray, compose
from swarmvision.marker import Marker
from swarmvision.rendering import columns
from swarmvision.rendering.appearance import Appearance, Light
from swarmvision.rendering.raycast import Raycaster

SMALL = Lens.from_config(LensConfig(width_px=128, height_px=92, focal_px=126.9))
LENS = Lens.from_config(LENSES["pi-v1"])
ROBOT, ARENA = RobotConfig(), ArenaConfig(width=3.0, depth=3.0)
EYE = np.array([0.0, 0.0, 0.0])
SAMPLES = 6  # each way


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

    def hit(depth: FloatArray, where: BoolArray, print_: FloatArray, normal: FloatArray) -> None:
        nearer = where & (depth > 1e-6) & (depth < best)
        best[nearer] = depth[nearer]
        shaded = (
            np.broadcast_to(print_, step.shape) * light.shade(np.broadcast_to(normal, step.shape))[..., None]
        )
        colour[nearer] = shaded[nearer]

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
            cos, sin = np.cos(yaw), np.sin(yaw)
            turn = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1.0]])  # robot from world
            o, s = turn @ (eye - [x, y, 0]), step @ turn.T
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
                    hit(depth, inside, decode(rgb(look.body_colour)), normal @ turn)
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
                hit(depth, inside, prints, normal @ turn)
    shape = (SMALL.height_px, SAMPLES, SMALL.width_px, SAMPLES, 3)
    return np.rint(encode(colour.reshape(shape).mean(axis=(1, 3))))


@pytest.mark.parametrize("seed", range(4))
def test_agrees_with_brute_force(seed: int) -> None:
    poses = random_poses(seed)
    difference = np.abs(Raycaster(SMALL, ROBOT, ARENA).render(Scene.at_rest(poses), EYE) - brute_force(poses))
    assert difference.mean() < 0.35  # 36 samples a pixel are themselves uncertain by as much at edges
    assert np.percentile(difference, 99.5) < 16


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


def test_compiled_and_plain_kernels_agree() -> None:
    knots = Marker.from_config(ROBOT.marker).bands[1].pattern
    assert knots is not None
    for phi in np.linspace(-7, 7, 41):
        plain = getattr(columns.pattern_span, "py_func", columns.pattern_span)(knots.knots, phi)
        np.testing.assert_allclose(columns.pattern_span(knots.knots, phi), plain, rtol=0, atol=1e-15)
        np.testing.assert_allclose(plain, [float(edge) for edge in knots.span(phi)], atol=1e-12)
