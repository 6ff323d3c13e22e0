"""Calibration finds the lens that took the pictures, says how well, and refuses what does not tell it."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
from grain import add_noise
from numpy.typing import NDArray

from swarmvision.calibration import from_board, from_marker, ranges_from
from swarmvision.camera import Lens
from swarmvision.colour import decode, encode, rgb
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.board import BoardConfig
from swarmvision.config.camera import LENSES, RIGS, LensConfig
from swarmvision.config.marker import PRESETS
from swarmvision.config.model import Settings, validated
from swarmvision.config.robot import RobotConfig
from swarmvision.config.writing import as_toml
from swarmvision.data import Scene
from swarmvision.errors import CalibrationError, ConfigError, PictureError
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.perception.calibrate import calibrate, recoloured
from swarmvision.perception.charuco import BoardView, board_of, calibrate_board, view
from swarmvision.perception.leastsquares import solve
from swarmvision.perception.sighting import Sighting, sight
from swarmvision.rendering.appearance import Appearance, Light
from swarmvision.rendering.mesh import MeshRenderer
from swarmvision.rendering.raycast import Raycaster

Picture = NDArray[np.uint8]

ROBOT = RobotConfig()
MARKER = Marker.from_config(ROBOT.marker)
TRUE = Lens.from_config(LensConfig(focal_px=700.0, height=0.090))
BLIND = Lens.from_config(LensConfig(focal_px=500.0, height=0.05))  # what calibration starts from
POSES = (
    (0.14, 0.0, 1.0),
    (0.2, 0.05, -2.0),
    (0.3, -0.08, 0.3),
    (0.4, 0.1, 2.2),
    (0.5, -0.15, -1.0),
    (0.7, 0.1, 0.0),
)
RANGES = [float(np.hypot(x, y)) for x, y, _ in POSES]
EYE = np.zeros(3)


def pictures(
    lens: Lens = TRUE,
    robot: RobotConfig = ROBOT,
    poses: Sequence[tuple[float, float, float]] = POSES,
    look: Appearance | None = None,
    noise: float = 2.0,
) -> list[Picture]:
    raycaster = Raycaster(lens, robot, ArenaConfig(), look)
    images = [raycaster.render(Scene.at_rest([pose]), EYE) for pose in poses]
    for i, image in enumerate(images):
        add_noise(image, noise, i)
    return images


def relit(image: Picture, light: tuple[float, float, float]) -> Picture:
    lit: Picture = np.rint(encode(decode(image) * light)).astype(np.uint8)
    return lit


@cache
def sightings() -> tuple[Sighting, ...]:
    return tuple(sight(image, MARKER) for image in pictures())


def turned(pose: tuple[float, float, float], lens: Lens, pitch: float, roll: float) -> Picture:
    """A picture by a lens that looks up and leans: a large level one, resampled along the true rays."""
    fine = 3
    width, height = int(1.4 * fine * lens.width_px), int(1.6 * fine * lens.height_px)
    config = LensConfig(width_px=width, height_px=height, focal_px=fine * lens.focal_px, height=lens.height)
    level = Lens.from_config(config)
    light = decode(Raycaster(level, ROBOT, ArenaConfig()).render(Scene.at_rest([pose]), EYE))
    rows, columns = (np.mgrid[: fine * lens.height_px, : fine * lens.width_px] + 0.5) / fine
    straight = lens.undistort(np.stack([columns, rows], axis=-1))
    left = (lens.centre_px[0] - straight[..., 0]) / lens.focal_px
    up = (lens.centre_px[1] - straight[..., 1]) / lens.focal_px
    rays = np.stack([np.ones_like(left), left, up], axis=-1)
    cos, sin = np.cos(roll), np.sin(roll)
    leaning = np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])
    cos, sin = np.cos(pitch), np.sin(pitch)
    raised = np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])
    seen = rays @ (raised @ leaning).T
    from_column = level.centre_px[0] - level.focal_px * seen[..., 1] / seen[..., 0] - 0.5
    from_row = level.centre_px[1] - level.focal_px * seen[..., 2] / seen[..., 0] - 0.5
    large = cv2.remap(
        light.astype(np.float32),
        from_column.astype(np.float32),
        from_row.astype(np.float32),
        cv2.INTER_LINEAR,
    )
    small = cv2.resize(large, (lens.width_px, lens.height_px), interpolation=cv2.INTER_AREA)
    image: Picture = np.rint(encode(small)).astype(np.uint8)
    return image


# Laws of the solver.


def test_least_squares_solves_a_line_with_its_textbook_covariance() -> None:
    x = np.arange(10.0)
    y = 3.0 + 2.0 * x
    found = solve(lambda p: p[0] + p[1] * x - y, np.zeros(2), np.full(2, 1e-5))
    design = np.column_stack([np.ones(10), x])
    np.testing.assert_allclose(found.parameters, [3.0, 2.0], rtol=1e-6)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(design.T @ design), rtol=1e-4)


def test_least_squares_says_what_the_data_do_not_tell() -> None:
    # Only the sum of the first two is seen; the third is.
    found = solve(
        lambda p: np.array([p[0] + p[1] - 1.0, p[2] - 5.0, p[2] - 5.0]), np.zeros(3), np.full(3, 1e-5)
    )
    assert np.isinf(np.diag(found.covariance)[:2]).all()
    assert found.covariance[2, 2] == pytest.approx(0.5)


def test_least_squares_walks_a_curved_valley() -> None:
    # Rosenbrock's function, as residuals: least at (1, 1).
    found = solve(
        lambda p: np.array([10.0 * (p[1] - p[0] ** 2), 1.0 - p[0]]),
        np.array([-1.2, 1.0]),
        np.full(2, 1e-6),
    )
    np.testing.assert_allclose(found.parameters, [1.0, 1.0], rtol=1e-5)


# The lens comes back.


@pytest.mark.parametrize("ranges", [RANGES, None, [RANGES[0], None, None, None, None, None]])
def test_the_lens_comes_back_with_and_without_a_ruler(ranges: list[float | None] | None) -> None:
    found = calibrate(sightings(), MARKER, BLIND, ranges)
    assert found.focal_px[0] == pytest.approx(TRUE.focal_px, rel=0.005)
    assert found.height[0] == pytest.approx(TRUE.height, abs=0.0005)
    assert abs(found.pitch[0]) < np.radians(0.02)
    assert abs(found.roll[0]) < np.radians(0.05)
    np.testing.assert_allclose(found.ranges[:, 0], RANGES, rtol=0.005)
    np.testing.assert_allclose(found.bearings, [np.arctan2(y, x) for x, y, _ in POSES], atol=0.002)
    assert found.overall_rms_px < 0.1


def test_the_mesh_renderers_lens_comes_back() -> None:
    mesh = MeshRenderer(TRUE, ROBOT, ArenaConfig())
    seen = [sight(mesh.render(Scene.at_rest([pose]), EYE), MARKER) for pose in POSES[1:5]]
    found = calibrate(seen, MARKER, BLIND, RANGES[1:5])
    assert found.focal_px[0] == pytest.approx(TRUE.focal_px, rel=0.005)
    assert found.height[0] == pytest.approx(TRUE.height, abs=0.002)
    assert recoloured(found, MARKER).keys() == {(190, 38, 42), (228, 228, 224), (30, 62, 150), (226, 190, 32)}


def test_a_plain_pole_at_a_quarter_of_the_pixels_calibrates_too() -> None:
    lens = Lens.from_config(LensConfig(width_px=320, height_px=240, focal_px=265.0))
    pole = PRESETS["pole-52x150"]
    poses = [(0.3, 0.0, 0.0), (0.4, 0.1, 0.0), (0.6, -0.1, 0.0), (0.8, 0.2, 0.0)]
    seen = [
        sight(image, Marker.from_config(pole)) for image in pictures(lens, ROBOT.replace(marker=pole), poses)
    ]
    start = replace(lens, focal_px=400.0, height=0.0)
    found = calibrate(seen, Marker.from_config(pole), start, [float(np.hypot(x, y)) for x, y, _ in poses])
    assert found.focal_px[0] == pytest.approx(265.0, rel=0.005)
    assert found.height[0] == pytest.approx(lens.height, abs=0.002)


@pytest.mark.parametrize(
    ("pitch_deg", "roll_deg", "k1"), [(2.0, 1.0, 0.0), (-4.0, 0.0, 0.0), (1.5, 0.0, -0.2)]
)
def test_tilt_comes_back_also_through_a_bent_lens(pitch_deg: float, roll_deg: float, k1: float) -> None:
    lens = replace(TRUE, focal_px=600.0, distortion=(k1, 0.0, 0.0, 0.0, 0.0))
    poses = POSES[:1] + POSES[2:5]
    seen = [sight(turned(pose, lens, *np.radians([pitch_deg, roll_deg])), MARKER) for pose in poses]
    found = calibrate(
        seen, MARKER, replace(lens, focal_px=500.0), [float(np.hypot(x, y)) for x, y, _ in poses]
    )
    # A row is 0.1 deg; edges are placed to a twentieth of one.
    assert np.degrees(found.pitch[0]) == pytest.approx(pitch_deg, abs=0.02)
    assert np.degrees(found.roll[0]) == pytest.approx(roll_deg, abs=0.03)
    assert found.focal_px[0] == pytest.approx(600.0, rel=0.005)
    assert found.height[0] == pytest.approx(lens.height, abs=0.001)


def test_the_level_lens_puts_points_where_the_tilted_one_does() -> None:
    bent = replace(TRUE, distortion=(-0.2, 0.0, 0.0, 0.0, 0.0))
    found = calibrate(sightings(), MARKER, BLIND, RANGES)
    drop = np.radians(1.0)
    tilted = replace(found, start=bent, focal_px=(700.0, 1.0), pitch=(drop, 0.001))
    level = tilted.level_lens()
    # Straight points whose rows are counted from the horizon; the level lens shifts by f tan(pitch).
    points = np.stack(np.meshgrid([100.0, 320.0, 540.0], [100.0, 230.0, 360.0]), axis=-1)
    off = np.abs(level.distort(points) - bent.distort(points)).max()
    naive = replace(level, distortion=bent.distortion)
    assert off < 0.05
    assert np.abs(naive.distort(points) - bent.distort(points)).max() > 4.0 * off


def test_errors_are_as_large_as_they_are_said_to_be() -> None:
    # Twenty cameras, each with its own ruler (zero off by 3 mm, readings by 1 mm) and pictures.
    scores = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        lens = replace(TRUE, focal_px=float(rng.uniform(500, 800)), height=float(rng.uniform(0.07, 0.10)))
        far = np.geomspace(0.2, 0.6, 5)
        bearing = rng.uniform(-0.5, 0.5, 5) * lens.fov / 2.0
        poses = list(zip(far * np.cos(bearing), far * np.sin(bearing), rng.uniform(-3, 3, 5), strict=True))
        seen = [sight(image, MARKER) for image in pictures(lens, poses=poses)]
        ruler = far + 0.003 * rng.normal() + 0.001 * rng.normal(size=5)
        found = calibrate(seen, MARKER, BLIND, list(ruler))
        scores.append((found.focal_px[0] - lens.focal_px) / found.focal_px[1])
    # The print is perfect and the ray caster's edges are sharp, so somewhat less than 1 is expected.
    assert 0.3 < np.sqrt(np.mean(np.square(scores))) < 1.4


def test_a_known_focal_length_is_kept() -> None:
    found = calibrate(sightings()[3:], MARKER, replace(BLIND, focal_px=700.0), keep_focal=True)
    assert found.focal_px[0] == pytest.approx(700.0, rel=1e-4)
    assert found.height[0] == pytest.approx(TRUE.height, abs=0.001)


def test_the_order_of_the_pictures_does_not_matter() -> None:
    one = calibrate(sightings(), MARKER, BLIND, RANGES)
    two = calibrate(sightings()[::-1], MARKER, BLIND, RANGES[::-1])
    assert two.focal_px == pytest.approx(one.focal_px, rel=1e-6)
    np.testing.assert_allclose(two.ranges[::-1], one.ranges, rtol=1e-5)


# Colours.


@pytest.mark.parametrize(
    "light", [(1.0, 1.0, 1.0), (0.9, 0.7, 0.45), (0.1, 0.09, 0.07)], ids=["even", "warm", "dim"]
)
def test_colours_come_back_in_any_light(light: tuple[float, float, float]) -> None:
    printed = {"red": "#b0402c", "white": "#e4e4e0", "blue": "#20508c", "yellow": "#d8c030"}
    carrier = ROBOT.marker.bands[1].pattern
    assert carrier is not None
    bands = [band.replace(colour=printed[band.colour]) for band in ROBOT.marker.bands]
    bands[1] = bands[1].replace(pattern=carrier.replace(colour=printed["yellow"]))
    robot = ROBOT.replace(marker=ROBOT.marker.replace(bands=tuple(bands)))
    lamp = Appearance(Light(ambient=0.5, diffuse=0.5, azimuth=1.6, elevation=0.4))
    seen = [sight(relit(image, light), MARKER) for image in pictures(TRUE, robot, POSES[1:5], lamp)]
    codes = recoloured(calibrate(seen, MARKER, BLIND, RANGES[1:5]), MARKER)
    # Two grey levels of noise, 8 bits in a tenth of the light: a dark channel is told to some levels.
    allowed = 3 if light[0] > 0.5 else 8
    for name, code in printed.items():
        np.testing.assert_allclose(rgb(codes[rgb(name)]), rgb(code), atol=allowed)


def test_a_seam_that_faces_the_lens_leaves_enough_of_both_rings() -> None:
    # The stripe touches one ring left of the seam, which azimuth pi - heading = 0 shows, and the other right.
    poses = [(x, 0.0, np.pi) for x in (0.2, 0.35, 0.6)]
    seen = [sight(image, MARKER) for image in pictures(poses=poses)]
    found = calibrate(seen, MARKER, BLIND, [0.2, 0.35, 0.6])
    assert found.focal_px[0] == pytest.approx(TRUE.focal_px, rel=0.005)
    np.testing.assert_allclose(rgb(recoloured(found, MARKER)[(226, 190, 32)]), (226, 190, 32), atol=3)


def test_over_exposed_white_tells_no_colours() -> None:
    seen = [sight(relit(image, (2.0, 2.0, 2.0)), MARKER) for image in pictures(poses=POSES[1:4])]
    found = calibrate(seen, MARKER, BLIND, RANGES[1:4])
    assert recoloured(found, MARKER) == {}


# What does not tell the lens is refused.


def test_too_few_and_too_similar_pictures_are_refused() -> None:
    with pytest.raises(CalibrationError, match="2 pictures are too few: 3 are needed"):
        calibrate(sightings()[:2], MARKER, BLIND)
    alike = [sight(image, MARKER) for image in pictures(poses=[(0.3, y, 1.0) for y in (-0.05, 0.0, 0.05)])]
    with pytest.raises(
        CalibrationError, match=r"at about one distance .* height and tilt cannot be told apart"
    ):
        calibrate(alike, MARKER, BLIND, [0.304, 0.3, 0.304])


def test_far_pictures_without_a_ruler_are_refused_for_their_focal_length() -> None:
    far = [sight(image, MARKER) for image in pictures(poses=[(x, 0.0, 1.0) for x in (0.4, 0.55, 0.7)])]
    with pytest.raises(CalibrationError, match=r"focal length stays uncertain by \d+\.\d %: give --ranges"):
        calibrate(far, MARKER, BLIND)
    assert calibrate(far, MARKER, BLIND, [0.4, 0.55, 0.7]).focal_px[0] == pytest.approx(700.0, rel=0.005)


def test_ranges_that_contradict_the_pictures_are_refused_by_number() -> None:
    swapped = [RANGES[0], *RANGES[2:3], *RANGES[1:2], *RANGES[3:]]
    with pytest.raises(CalibrationError, match=r"range of picture [23], .* contradicts the others"):
        calibrate(sightings(), MARKER, BLIND, swapped)
    slip = [*RANGES[:3], RANGES[3] + 0.02, *RANGES[4:]]  # 2 cm in 0.41 m: 5 %, found after the fit
    with pytest.raises(CalibrationError, match=r"range of picture 4, 0\.432 m, .* about 0\.4[12] m"):
        calibrate(sightings(), MARKER, BLIND, slip)


@pytest.mark.parametrize(
    ("ranges", "line"),
    [
        ([0.2, 0.3], "6 pictures need as many ranges, got 2"),
        ([0.2, 0.3, -0.1, None, None, None], r"a range must be positive \(m\), got -0.1"),
        ([0.015, *RANGES[1:]], "must exceed its radius 0.02 m"),
    ],
)
def test_impossible_ranges_are_refused(ranges: list[float | None], line: str) -> None:
    with pytest.raises(CalibrationError, match=line):
        calibrate(sightings(), MARKER, BLIND, ranges)


@pytest.mark.parametrize("ranges", [RANGES, None])
def test_another_marker_is_refused(ranges: list[float] | None) -> None:
    bands = ROBOT.marker.bands
    taller = Marker.from_config(
        ROBOT.marker.replace(bands=(bands[0], bands[1].replace(height=0.044), bands[2]))
    )
    seen = [sight(image, taller) for image in pictures()]
    with pytest.raises(CalibrationError, match=r"is it this marker, and are the ranges right\?"):
        calibrate(seen, taller, BLIND, ranges)


def test_a_picture_must_show_one_whole_marker() -> None:
    raycaster = Raycaster(TRUE, ROBOT, ArenaConfig())
    with pytest.raises(PictureError, match="no marker 'helix-40x60' found"):
        sight(raycaster.render(Scene.at_rest(np.zeros((0, 3))), EYE), MARKER)
    two = raycaster.render(Scene.at_rest([[0.3, 0.05, 0.0], [0.4, -0.1, 0.0]]), EYE)
    with pytest.raises(PictureError, match="2 markers are in view"):
        sight(two, MARKER)
    border = TRUE.fov / 2.0
    cut = raycaster.render(Scene.at_rest([[0.3 * np.cos(border), 0.3 * np.sin(border), 0.0]]), EYE)
    with pytest.raises(PictureError, match="sides are not both free"):
        sight(cut, MARKER)
    far = raycaster.render(Scene.at_rest([[1.6, 0.0, 0.0]]), EYE)
    far[:, :, :] = cv2.GaussianBlur(far, (0, 0), 3.0)
    with pytest.raises(PictureError):
        sight(far, MARKER)


def test_a_marker_half_behind_something_is_refused() -> None:
    image = pictures(poses=[(0.3, 0.0, 1.0)])[0]
    image[:, 322:] = (90, 90, 90)
    with pytest.raises(PictureError, match="the marker is partly hidden"):
        sight(image, MARKER)


def test_a_dark_post_beside_a_ring_does_not_move_its_end() -> None:
    # Half angle asin(0.02 / 0.3) = 3.8 deg: the right side is at 320 + 700 tan(3.8 deg) = 366.8 px.
    plain = pictures(poses=[(0.3, 0.0, 1.0)], noise=0.0)[0]
    darkened = plain.copy()
    darkened[240:330, 367:369] = (40, 40, 40)  # beside the lower ring only
    side = sight(plain, MARKER)
    right = side.sides_px[side.signs < 0, 0]
    np.testing.assert_allclose(right, 366.77, atol=0.05)
    posted = sight(darkened, MARKER)
    np.testing.assert_allclose(posted.sides_px[posted.signs < 0, 0], 366.77, atol=0.05)
    assert len(posted.sides_px) < len(side.sides_px)


def test_a_picture_that_does_not_fit_is_named() -> None:
    odd = sightings()[1]
    shifted = odd.edges_px + np.where(odd.heights > 0.03, 6.0, 0.0)[:, None] * np.array([0.0, 1.0])
    wrong = [sightings()[0], replace(odd, edges_px=shifted), *sightings()[2:]]
    with pytest.raises(CalibrationError, match=r"picture 2 fits marker 'helix-40x60' to \d\.\d px only"):
        calibrate(wrong, MARKER, BLIND)


@pytest.mark.parametrize("seed", range(12))
def test_pictures_by_different_lenses_are_refused_not_averaged(seed: int) -> None:
    rng = np.random.default_rng(seed)
    seen = []
    for distance in rng.uniform(0.2, 0.6, 5):
        lens = replace(TRUE, focal_px=float(rng.uniform(400, 800)), height=float(rng.uniform(0.07, 0.11)))
        seen.append(sight(pictures(lens, poses=[(float(distance), 0.0, 1.0)])[0], MARKER))
    ranges = [None if rng.random() < 0.3 else float(r) for r in rng.uniform(0.01, 1.5, 5)]
    for given in (None, ranges):
        with pytest.raises(CalibrationError):
            calibrate(seen, MARKER, BLIND, given)


@pytest.mark.parametrize("shape", [(1, 1), (3, 700), (480, 2), (90, 120)])
def test_no_picture_breaks_a_sighting(shape: tuple[int, int]) -> None:
    for image in (
        np.random.default_rng(1).integers(0, 256, (*shape, 3)).astype(np.uint8),
        np.zeros((*shape, 3), np.uint8),
        np.full((*shape, 3), 255, np.uint8),
    ):
        with pytest.raises(PictureError):
            sight(image, MARKER)


# ChArUco.

BOARD = BoardConfig()
BENT = Lens.from_config(
    LensConfig(
        width_px=640,
        height_px=480,
        focal_px=500.0,
        centre_px=(326.0, 233.0),
        distortion=(-0.25, 0.08, 0.002, -0.001, 0.0),
    )
)
HELD = (
    ((0.5, 0.0, 0.0), (-0.12, -0.09, 0.30)),
    ((-0.5, 0.1, 0.1), (-0.12, -0.09, 0.28)),
    ((0.0, 0.6, 0.0), (-0.12, -0.09, 0.28)),
    ((0.1, -0.6, 0.1), (-0.12, -0.09, 0.30)),
    ((0.3, 0.3, 0.8), (0.02, -0.16, 0.30)),
    ((-0.3, -0.4, -0.5), (-0.16, 0.0, 0.30)),
)
FLAT = tuple(((0.0, 0.0, 0.0), (-0.12, -0.09, z)) for z in (0.22, 0.23, 0.24, 0.25))
Hold = tuple[tuple[float, float, float], tuple[float, float, float]]


@cache
def board_pictures(held: tuple[Hold, ...]) -> tuple[Picture, ...]:
    """Views of the printed board by our own lens model: turn (rad) and shift (m), x right, y down."""
    dots = 6000  # per m
    size = (int(BOARD.squares_x * BOARD.square * dots), int(BOARD.squares_y * BOARD.square * dots))
    printed = board_of(BOARD).generateImage(size, marginSize=0)
    fine = 3
    rows, columns = (np.mgrid[: fine * BENT.height_px, : fine * BENT.width_px] + 0.5) / fine
    straight = (BENT.undistort(np.stack([columns, rows], axis=-1)) - BENT.centre_px) / BENT.focal_px
    rays = np.concatenate([straight, np.ones((*straight.shape[:2], 1))], axis=-1)
    images = []
    for turn, shift in held:
        rotation = cv2.Rodrigues(np.array(turn))[0]
        eye, seen = -rotation.T @ np.array(shift), rays @ rotation
        reach = -eye[2] / seen[..., 2]
        at = ((eye[:2] + reach[..., None] * seen[..., :2]) * dots - 0.5).astype(np.float32)
        large = cv2.remap(printed, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderValue=255)
        small = cv2.resize(large, (BENT.width_px, BENT.height_px), interpolation=cv2.INTER_AREA)
        images.append(np.repeat(small[..., None], 3, axis=2))
    return tuple(images)


def views(held: tuple[Hold, ...]) -> list[BoardView]:
    board = board_of(BOARD)
    return [view(image, board) for image in board_pictures(held)]


def test_calibration_needs_numpy_and_opencv_alone() -> None:
    code = (
        "import sys\n"
        "for name in ('pydantic', 'numba', 'pymunk', 'scipy', 'pettingzoo', 'matplotlib', 'typer'):\n"
        "    sys.modules[name] = None\n"
        "from swarmvision.perception import bundle, calibrate, charuco, leastsquares, sighting\n"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr


def test_a_boards_lens_comes_back_with_its_distortion_and_centre() -> None:
    found = calibrate_board(views(HELD), replace(BENT, focal_px=300.0, distortion=(0.0,) * 5))
    assert found.lens.focal_px == pytest.approx(500.0, rel=0.005)
    np.testing.assert_allclose(found.lens.centre_px, BENT.centre_px, atol=1.5)
    # What counts is where points come out, all over the picture.
    corners = np.stack(np.meshgrid(np.linspace(60, 580, 9), np.linspace(60, 420, 7)), axis=-1)
    rays = (BENT.undistort(corners) - BENT.centre_px) / BENT.focal_px
    ours = found.lens.distort(rays * found.lens.focal_px + found.lens.centre_px)
    shift = np.median(ours - corners, axis=(0, 1))  # a turn of the camera cannot be told from a shift
    assert np.abs(ours - corners - shift).max() < 0.5
    assert found.overall_rms_px < 0.2
    for (value, std), true in zip(found.distortion[:2], BENT.distortion[:2], strict=True):
        assert abs(value - true) < 4.0 * std


def test_boards_that_tell_too_little_are_refused() -> None:
    with pytest.raises(CalibrationError, match="3 pictures of the board are too few: 4 are needed"):
        calibrate_board(views(HELD)[:3], BENT)
    with pytest.raises(CalibrationError, match=r"askew by \d deg at most: hold it askew"):
        calibrate_board(views(FLAT), BENT)
    with pytest.raises(CalibrationError, match="0 corners of the board are seen, 8 are needed"):
        view(np.full((480, 640, 3), 200, np.uint8), board_of(BOARD))
    with pytest.raises(CalibrationError, match="DICT_4X4_50 has 50 markers, the board needs 60"):
        board_of(BOARD.replace(squares_x=12, squares_y=10, dictionary="DICT_4X4_50"))


# Files and the command.


@pytest.mark.parametrize(
    "settings", [*LENSES.values(), *PRESETS.values(), *RIGS.values(), BOARD], ids=lambda s: type(s).__name__
)
def test_settings_written_as_toml_read_back_the_same(settings: Settings) -> None:
    text = as_toml(settings, "a remark\nof two lines")
    assert validated(type(settings), tomllib.loads(text), "text") == settings


def test_strings_survive_toml() -> None:
    odd = PRESETS["helix-40x60"].replace(name='a "quoted" \\ päper\t1')
    assert tomllib.loads(as_toml(odd))["name"] == odd.name


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("calibration")
    for i, image in enumerate(pictures()):
        cv2.imwrite(str(place / f"{i}.png"), image[..., ::-1])
    return place


def command(*arguments: object) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-c", "from swarmvision.cli import main; main()", *map(str, arguments)]
    return subprocess.run(line, capture_output=True, text=True, check=False)


def test_detect_reads_with_the_files_that_calibrate_writes(folder: Path) -> None:
    paths = [folder / f"{i}.png" for i in range(6)]
    ranges = ",".join(f"{r:.3f}" for r in RANGES[:5]) + ",?"
    result = command("calibrate", *paths, "--ranges", ranges, "--out", folder / "out", "--json")
    assert result.returncode == 0, result.stderr
    values = json.loads(result.stdout)
    assert values["focal_px"][0] == pytest.approx(700.0, rel=0.005)
    assert [row["range"] for row in values["pictures"]] == pytest.approx(RANGES, rel=0.005)
    assert (folder / "out" / "residuals.png").stat().st_size > 10_000
    made = ["--camera", folder / "out" / "camera.toml", "--marker", folder / "out" / "marker.toml"]
    read = command("detect", paths[2], *made, "--json")
    assert read.returncode == 0, read.stderr
    (neighbour,) = json.loads(read.stdout)["neighbours"]
    assert neighbour["range"] == pytest.approx(RANGES[2], rel=0.01)


def test_what_the_command_refuses_it_refuses_in_one_line(folder: Path, tmp_path: Path) -> None:
    paths = [folder / f"{i}.png" for i in range(6)]
    small = tmp_path / "small.png"
    cv2.imwrite(str(small), np.full((48, 64, 3), 200, np.uint8))
    for arguments, line in (
        (paths[:2], "2 pictures are too few"),
        ([*paths, "--ranges", "0.2,x"], "--ranges: 'x' is no range"),
        ([*paths, "--keep-focal"], "none is given"),
        ([*paths, "--ruler-mm", "0"], "--ruler-mm must be positive"),
        ([*paths, small], "small.png: the picture is 64 x 48 px"),
        ([small], "small.png: no marker 'helix-40x60' found"),
        ([*paths, "--charuco", tmp_path / "none.toml"], "none.toml: cannot be read"),
        ([*paths, "--charuco", "b.toml", "--ranges", "1"], "--charuco takes neither --ranges"),
    ):
        result = command("calibrate", *arguments, "--out", tmp_path / "out")
        assert result.returncode == 1, result.stdout
        assert len(result.stderr.strip().splitlines()) == 1, result.stderr
        assert line in result.stderr
    assert not (tmp_path / "out").exists()


def test_a_board_makes_a_camera_file(tmp_path: Path) -> None:
    paths = []
    for i, image in enumerate(board_pictures(HELD)):
        paths.append(tmp_path / f"{i}.png")
        cv2.imwrite(str(paths[-1]), image)
    report = from_board(paths, tmp_path / "out", BOARD)
    assert report.values["focal_px"][0] == pytest.approx(500.0, rel=0.005)
    written = tomllib.loads((tmp_path / "out" / "camera.toml").read_text())
    assert written["distortion"][0] == pytest.approx(-0.25, abs=0.02)
    # The same file is what pictures of the marker start from.
    lens = validated(LensConfig, written, "camera.toml")
    assert Lens.from_config(lens).is_distorted


def test_a_short_marker_and_a_tilted_lens_are_told(tmp_path: Path) -> None:
    two = PRESETS["pole-52x150"].replace(bands=PRESETS["pole-52x150"].bands[:2])
    with pytest.raises(CalibrationError, match="has 2 bands; calibration needs three"):
        from_marker([], tmp_path, two)
    paths = []
    for i, pose in enumerate(POSES[1:4]):
        paths.append(tmp_path / f"{i}.png")
        cv2.imwrite(str(paths[-1]), turned(pose, TRUE, np.radians(6.0), 0.0)[..., ::-1])
    report = from_marker(paths, tmp_path, ROBOT.marker, ranges=RANGES[1:4])
    assert report.notes == (
        "the lens is tilted by more than 5 deg; markers are read by a level lens: mount it straighter",
    )


def test_ranges_are_numbers_or_question_marks() -> None:
    assert ranges_from("0.2, ?,0.35") == [0.2, None, 0.35]
    with pytest.raises(ConfigError, match="'' is no range in m"):
        ranges_from("0.2,,0.3")


def test_the_written_camera_reads_a_tilted_lens_as_well_as_a_level_one(tmp_path: Path) -> None:
    pitch, errors = np.radians(1.5), []
    shots: list[Picture] = [turned(pose, TRUE, pitch, 0.0) for pose in POSES[1:5]]
    found = calibrate([sight(image, MARKER) for image in shots], MARKER, BLIND, RANGES[1:5])
    reader = Reader(found.level_lens(), MARKER, "edges")
    for image, distance in zip(shots, RANGES[1:5], strict=True):
        estimates = reader.read(image)
        errors.append(float(estimates.range[0]) / distance - 1.0)
    assert np.abs(errors).max() < 0.01
