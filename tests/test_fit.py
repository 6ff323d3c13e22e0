"""Analysis by synthesis: its derivatives, its accuracy in hard pictures, and whether it knows its errors."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from grain import add_noise
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.colour import decode, encode
from swarmvision.config.arena import ARENAS, BoxConfig, DiscConfig
from swarmvision.config.camera import LENSES
from swarmvision.config.marker import PRESETS
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Estimates, Scene
from swarmvision.geometry import FloatArray, compose, wrap
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.perception.gaussnewton import cholesky, substitute
from swarmvision.perception.model import (
    BEARING,
    BLUR,
    DROP,
    FREE,
    GROUND,
    HEADING,
    LEAN,
    LOG_RANGE,
    ROW,
    SMEAR,
    SOFTNESS,
    Skin,
    model,
    smeared,
    soft_slope,
    soft_step,
)
from swarmvision.rendering.raycast import Raycaster

LENS, ROBOT = Lens.from_config(LENSES["pi-v1"]), RobotConfig()
MARKER = Marker.from_config(ROBOT.marker)
RAYCASTER = Raycaster(LENS, ROBOT, ARENAS["open"])
FIT = Reader(LENS, MARKER, "fit")
EDGES = Reader(LENS, MARKER, "edges")
Truth = tuple[float, float, float]


def scene_of(seed: int, nearest: float, farthest: float) -> tuple[NDArray[np.uint8], Truth]:
    """A sharp, clean picture of one marker somewhere, and range, bearing, heading."""
    rng = np.random.default_rng(seed)
    distance, bearing = rng.uniform(nearest, farthest), rng.uniform(-0.3, 0.3)
    heading = rng.uniform(-np.pi, np.pi)
    eye = np.array([*rng.uniform(-5, 5, 2), rng.uniform(-3, 3)])
    there = np.array([distance * np.cos(bearing), distance * np.sin(bearing), heading])
    image = RAYCASTER.render(Scene.at_rest(np.stack([eye, compose(eye, there)])), eye, 0)
    return image, (distance, bearing, heading)


def photographed(image: NDArray[np.uint8], seed: int, smear: int = 0, dim: float = 1.0) -> NDArray[np.uint8]:
    """The picture as a lens of 0.7 px blur and a noisy sensor would take it."""
    light = cv2.GaussianBlur(decode(image) * dim, (0, 0), 0.7)
    if smear:
        light = cv2.blur(light, (smear, 1))
    taken = np.rint(encode(light)).astype(np.uint8)
    add_noise(taken, 2.0, seed)
    return taken


def errors(estimates: Estimates, truth: Truth) -> FloatArray:
    """Relative range, bearing (rad) and heading (rad) of the one neighbour; nan where none is near it."""
    for i in range(len(estimates.seen)):
        if abs(estimates.bearing[i] - truth[1]) < 0.05 and abs(estimates.range[i] / truth[0] - 1) < 0.2:
            off = [
                estimates.range[i] / truth[0] - 1,
                estimates.bearing[i] - truth[1],
                wrap(estimates.heading[i] - truth[2]),
            ]
            return np.array(off, dtype=np.float64)
    return np.full(3, np.nan)


def test_the_soft_step_is_the_integral_of_its_slope() -> None:
    t = np.linspace(-1.2, 1.2, 2401)
    step = np.array([soft_step(x) for x in t])
    slope = np.array([soft_slope(x) for x in t])
    np.testing.assert_allclose(np.cumsum(slope) * 0.001, step, atol=3e-3)
    np.testing.assert_allclose(step + step[::-1], 1.0, atol=1e-9)
    # A Gaussian cut at 3.2 standard deviations lacks 2 % of its variance.
    assert (slope * t**2).sum() * 0.001 == pytest.approx(1.0 / SOFTNESS**2, rel=0.03)


@pytest.mark.parametrize("kind", ["helix-40x60", "pole-52x150"])
@pytest.mark.parametrize("heading", [0.3, 2.9])  # pi - 0.05 faces the lens near the seam
def test_every_derivative_is_the_difference_of_two_models(kind: str, heading: float) -> None:
    skin = Skin.of(Marker.from_config(PRESETS[kind]))
    rng = np.random.default_rng(3)
    width = skin.colours + GROUND
    colours = rng.uniform(0.1, 1.0, (3, width))
    view = np.array([LENS.focal_px, *LENS.centre_px, LENS.height])
    u, v = np.meshgrid(np.arange(262.5, 342.5), np.arange(190.5, 268.5), indexing="ij")
    columns, rows = u.ravel(), v.ravel()
    frame = np.array([228.0, 30.0, 1.0, 1.0])
    theta = np.array([np.log(0.41), 0.03, heading, 1.3, 0.02, 0.9, 0.1, 0.02, -0.05, 0.04, 0.06, 0.0])

    def drawn(at: FloatArray, *, moving: bool = True) -> tuple[FloatArray, FloatArray]:
        basis, change = np.empty((len(columns), width)), np.zeros((3, len(columns), ROW))
        used = np.empty(len(columns), dtype=np.int64)
        sizes = np.array([skin.radius, skin.top])
        count = model(
            at, colours, view, sizes, skin.heights, skin.kinds, skin.inks, skin.knots, skin.jumps, frame,
            columns, rows, 1, moving, basis, change, used,
        )  # fmt: skip
        assert count == len(columns)
        return np.einsum("nk,ck->cn", basis, colours), change[:, :, :FREE]

    value, slopes = drawn(theta)
    still, untouched = drawn(theta, moving=False)
    np.testing.assert_array_equal(still, value)
    assert not untouched.any()
    for j in range(SMEAR):
        step = np.zeros(FREE)
        step[j] = 1e-6
        difference = (drawn(theta + step)[0] - drawn(theta - step)[0]) / 2e-6
        scale = np.abs(difference).max() + 1e-9
        off = np.abs(slopes[:, :, j] - difference) / scale
        # Columns held at the rim move with it, and a lean turns the jump: told roughly, on few pixels.
        loose = j in (LOG_RANGE, BEARING, HEADING, LEAN, BLUR)
        assert np.quantile(off, 0.93 if loose else 1.0) < 0.02, (kind, j)
    assert np.abs(slopes[:, :, DROP]).max() > 0.1


def test_a_smear_keeps_the_light_and_knows_its_length() -> None:
    rng = np.random.default_rng(1)
    high, wide = 4, 60
    sharp, sharp_change = rng.uniform(0, 1, (high * wide, 3)), rng.uniform(0, 1, (3, high * wide, ROW))
    colours = rng.uniform(0, 1, (3, 3))
    kept = np.arange(20 * high, 40 * high)

    def mixed(grid: FloatArray, length: float) -> tuple[FloatArray, FloatArray]:
        basis, change = np.empty((len(kept), 3)), np.empty((3, len(kept), ROW))
        smeared(grid, sharp_change, kept, high, length, colours, True, basis, change)
        return basis, change

    np.testing.assert_allclose(mixed(np.ones_like(sharp), 7.3)[0], 1.0, atol=1e-12)
    value = [mixed(sharp, length)[0] @ colours.T for length in (7.3 - 1e-5, 7.3 + 1e-5)]
    np.testing.assert_allclose(mixed(sharp, 7.3)[1][:, :, SMEAR], (value[1] - value[0]).T / 2e-5, atol=1e-6)


def test_cholesky_solves_and_refuses() -> None:
    rng = np.random.default_rng(2)
    root = rng.normal(size=(7, 7))
    matrix, right = root @ root.T + np.eye(7), rng.normal(size=(7, 2))
    factor, solution = matrix.copy(), right.copy()
    assert cholesky(factor)
    substitute(factor, solution)
    np.testing.assert_allclose(matrix @ solution, right, atol=1e-9)
    assert not cholesky(np.diag([1.0, -1.0]))


@pytest.mark.parametrize(
    ("nearest", "farthest", "limits"),
    # Medians of relative range, bearing (deg), heading (deg): the floors of the accuracy table.
    [(0.15, 0.5, (0.0008, 0.01, 0.35)), (0.5, 1.0, (0.001, 0.01, 0.5)), (1.0, 1.5, (0.0015, 0.01, 0.8))],
)
def test_clean_pictures_are_read_to_the_table(
    nearest: float, farthest: float, limits: tuple[float, float, float]
) -> None:
    off = []
    for seed in range(24):
        image, truth = scene_of(seed, nearest, farthest)
        off.append(errors(FIT.read(photographed(image, seed)), truth))
    middle = np.median(np.abs(off), axis=0) * [1.0, 180 / np.pi, 180 / np.pi]
    assert np.isfinite(off).all()
    assert (middle < limits).all(), middle


def test_it_is_better_than_its_start() -> None:
    fit, edges = [], []
    for seed in range(20):
        image, truth = scene_of(seed, 0.8, 1.5)
        taken = photographed(image, seed)
        fit.append(np.abs(errors(FIT.read(taken), truth)))
        edges.append(np.abs(errors(EDGES.read(taken), truth)))
    assert (np.mean(fit, axis=0) < np.mean(edges, axis=0)).all()


def test_its_covariance_is_honest() -> None:
    normalised = []
    for seed in range(60):
        image, truth = scene_of(seed, 0.3, 1.8)
        estimates = FIT.read(photographed(image, seed))
        off = errors(estimates, truth) * [truth[0], 1.0, 1.0]
        normalised.append(off @ np.linalg.solve(estimates.covariance[0], off) / 3.0)
    # Of 60 draws with 3 degrees of freedom the mean has the standard deviation sqrt(2 / 180) = 0.11.
    assert 0.6 < np.mean(normalised) < 1.6


def test_motion_blur_is_part_of_the_model() -> None:
    off = []
    for seed in range(16):
        image, truth = scene_of(seed, 0.3, 0.6)
        off.append(errors(FIT.read(photographed(image, seed, smear=11)), truth))
    assert np.isfinite(off).all()
    assert np.quantile(np.abs(off), 0.95, axis=0)[0] < 0.005
    assert np.degrees(np.quantile(np.abs(off), 0.95, axis=0)[2]) < 2.0


def test_edges_read_through_motion_blur_and_know_what_it_costs() -> None:
    off, normalised = [], []
    for seed in range(20):
        image, truth = scene_of(seed, 0.3, 0.6)
        estimates = EDGES.read(photographed(image, seed, smear=11))
        off.append(errors(estimates, truth))
        scaled = off[-1] * [truth[0], 1.0, 1.0]
        normalised.append(scaled @ np.linalg.solve(estimates.covariance[0], scaled) / 3.0)
    # The floors of the accuracy table for this method up to 1 m, in sharp pictures.
    assert (np.quantile(np.abs(off), 0.95, axis=0) < [0.01, np.radians(0.1), np.radians(5.0)]).all()
    assert np.mean(normalised) < 1.6


def test_a_tenth_of_the_light_is_enough() -> None:
    off = []
    for seed in range(16):
        image, truth = scene_of(seed, 0.2, 0.6)
        off.append(errors(FIT.read(photographed(image, seed, dim=0.1)), truth))
    assert np.isfinite(off).all()
    assert np.degrees(np.quantile(np.abs(off), 0.95, axis=0)[2]) < 2.0


@pytest.mark.parametrize("side", ["left", "right"])
def test_half_a_marker_is_enough(side: str) -> None:
    off = []
    for seed in range(16):
        image, truth = scene_of(seed, 0.3, 0.6)
        half = np.arcsin(0.02 / truth[0])
        first, last = LENS.column_from_bearing([truth[1] + half, truth[1] - half])
        middle = round(float(first + last) / 2.0)
        if side == "left":
            image[:, max(int(first) - 30, 0) : middle] = (60, 60, 64)
        else:
            image[:, middle : int(last) + 30] = (60, 60, 64)
        off.append(errors(FIT.read(photographed(image, seed)), truth))
    assert np.isfinite(off).all()
    assert np.degrees(np.quantile(np.abs(off), 0.95, axis=0)[1:]).tolist() < [0.3, 3.0]
    assert np.degrees(np.quantile(np.abs(off), 0.95, axis=0)[2]) < 3.0


@pytest.mark.parametrize("lost", ["top", "bottom"])
@pytest.mark.parametrize("method", ["edges", "fit"])
def test_one_ring_is_enough(lost: str, method: str) -> None:
    for seed in range(10):
        image, truth = scene_of(seed, 0.13, 0.25)
        taken = photographed(image, seed)
        # Rings begin 20 mm above and below the lens: cut 3 px inside that.
        rows = 634.6 * 0.020 / (truth[0] - 0.02) - 3.0
        if lost == "bottom":
            taken, centre = taken[: int(230 + rows)], 230.0
        else:
            first = round(230 - rows)
            taken, centre = taken[first:], 230.0 - first
        lens = replace(LENS, height_px=len(taken), centre_px=(320.0, centre))
        off = np.abs(errors(Reader(lens, MARKER, method).read(taken), truth))
        assert off[0] < 0.02
        assert off[1] < np.radians(0.1)


def test_two_markers_side_by_side_are_two() -> None:
    for gap in (0.01, 0.03):
        near, far = np.array([1.2, 0.0, 0.4]), np.array([1.4, 0.04 + gap, 2.0])
        eye = np.zeros(3)
        image = RAYCASTER.render(Scene.at_rest(np.stack([eye, near, far])), eye, 0)
        estimates = FIT.read(photographed(image, 1))
        assert len(estimates.seen) == 2
        np.testing.assert_allclose(estimates.range, [1.2, np.hypot(1.4, 0.04 + gap)], rtol=0.01)


def test_brightness_and_warmth_change_little() -> None:
    image, _ = scene_of(4, 0.4, 0.4001)
    plain = FIT.read(photographed(image, 1))
    warm = np.rint(encode(decode(photographed(image, 1)) * 0.5 * [1.0, 0.9, 0.75])).astype(np.uint8)
    other = FIT.read(warm)
    assert other.range[0] == pytest.approx(plain.range[0], rel=5e-4)
    assert other.bearing[0] == pytest.approx(plain.bearing[0], abs=1e-4)
    assert other.heading[0] == pytest.approx(plain.heading[0], abs=np.radians(0.3))


@pytest.mark.parametrize("method", ["edges", "fit"])
def test_clutter_in_the_markers_colours_is_nobody(method: str) -> None:
    reader, told = Reader(LENS, MARKER, method), 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        things: list[BoxConfig | DiscConfig] = []
        for _ in range(6):
            distance, bearing = rng.uniform(0.3, 3.0), rng.uniform(-0.45, 0.45)
            place = {"x": distance * np.cos(bearing), "y": distance * np.sin(bearing)}
            colour = str(rng.choice(["red", "blue", "yellow", "white"]))
            height = float(rng.choice([0.065, 0.105, 0.115, 0.2]))
            size = float(rng.uniform(0.02, 0.2))
            if rng.random() < 0.5:
                things.append(BoxConfig(**place, length=size, width=0.1, height=height, colour=colour))
            else:
                things.append(DiscConfig(**place, radius=size / 3.0, height=height, colour=colour))
        arena = ARENAS["open"].model_copy(update={"objects": tuple(things)})
        scene = Scene.at_rest([[0.0, 0.0, 0.0]], [[thing.x, thing.y, 0.0] for thing in things])
        image = Raycaster(LENS, ROBOT, arena).render(scene, np.zeros(3), 0)
        told += len(reader.read(photographed(image, seed)).seen)
    assert told == 0


def test_a_bent_lens_is_straightened() -> None:
    bent = replace(LENS, distortion=(-0.2, 0.03, 0.0005, -0.0005, 0.0))
    off = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        distance, bearing, heading = rng.uniform(0.2, 0.5), rng.uniform(-0.3, 0.3), rng.uniform(-3, 3)
        there = np.array([distance * np.cos(bearing), distance * np.sin(bearing), heading])
        eye = np.zeros(3)
        image = Raycaster(bent, ROBOT, ARENAS["open"]).render(Scene.at_rest(np.stack([eye, there])), eye, 0)
        estimates = Reader(bent, MARKER, "fit").read(photographed(image, seed))
        off.append(errors(estimates, (distance, bearing, heading)))
    assert np.abs(off).max(axis=0)[0] < 0.004
    assert np.degrees(np.abs(off).max(axis=0)[1:]).max() < 1.0
