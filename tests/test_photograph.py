"""A picture drawn and spoiled at once is the picture drawn and then spoiled."""

from __future__ import annotations

import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.camera import LENSES
from swarmvision.config.imperfections import IMPERFECTIONS, ImperfectionsConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.errors import DataError, PictureError
from swarmvision.rendering.exposing import photograph
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.rendering.raycast import Raycaster

PI = Lens.from_config(LENSES["pi-v1"])
NOISE = {"white_electrons": 4000.0, "read_noise": 4.0}
FAULTS = {
    "pi-v1": IMPERFECTIONS["pi-v1"],
    "none": IMPERFECTIONS["none"],
    "noise": IMPERFECTIONS["none"].model_copy(update=NOISE),
    "file": IMPERFECTIONS["none"].model_copy(update={**NOISE, "jpeg_quality": 80}),
}
THINGS = ArenaConfig(
    width=4.0,
    depth=4.0,
    objects=(BoxConfig(x=0.8, y=0.3, height=0.5), DiscConfig(x=-0.7, y=0.5, height=0.02)),
)


def scattered(robots: int, seed: int, span: float) -> Scene:
    """Robots within a span (m) of the middle, and the arena's things."""
    poses = np.random.default_rng(seed).uniform(-1.0, 1.0, (robots, 3)) * (span, span, np.pi)
    return Scene.at_rest(poses, [(thing.x, thing.y, 0.0) for thing in THINGS.objects])


def both(
    lens: Lens, faults: ImperfectionsConfig, scene: Scene, eye: np.ndarray, turn_rate: float
) -> tuple[np.ndarray, np.ndarray]:
    """The picture at once, into memory that holds another one, and step by step."""
    raycaster, camera = Raycaster(lens, RobotConfig(), THINGS), Imperfections(faults, lens)
    once = np.random.default_rng(3).integers(0, 256, (lens.height_px, lens.width_px, 3), dtype=np.uint8)
    photograph(raycaster, camera, scene, eye, None, key=11, turn_rate=turn_rate, out=once)
    image = raycaster.render(scene, eye)
    camera.spoil(image, 11, turn_rate)
    return once, image


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("turn_rate", [0.0, 1.5])
def test_at_once_is_step_by_step(fault: str, turn_rate: float) -> None:
    for seed in range(6):
        rng = np.random.default_rng(seed)
        eye = rng.uniform(-1.0, 1.0, 3) * (1.9, 1.9, np.pi)
        scene = scattered((0, 1, 3, 8, 20, 60)[seed], seed, 1.8)
        once, steps = both(PI, FAULTS[fault], scene, eye, turn_rate)
        np.testing.assert_array_equal(once, steps)


@pytest.mark.parametrize("size", [(1, 1), (3, 2), (2, 7), (33, 31), (641, 9)])
def test_at_once_is_step_by_step_in_pictures_of_any_size(size: tuple[int, int]) -> None:
    lens = Lens(*size, 60.0, (size[0] / 2.0, size[1] / 3.0), 0.085)
    for fault in FAULTS.values():
        once, steps = both(lens, fault, scattered(12, 4, 0.4), np.array([0.0, 0.0, 0.4]), 0.7)
        np.testing.assert_array_equal(once, steps)


def test_a_lens_above_and_one_below_what_it_sees() -> None:
    for height in (0.01, 0.3):
        lens = Lens(160, 120, 150.0, (80.0, 60.0), height)
        for seed in range(4):
            once, steps = both(lens, FAULTS["noise"], scattered(30, seed, 1.0), np.zeros(3), 0.3)
            np.testing.assert_array_equal(once, steps)


def test_a_lens_that_bends_is_drawn_whole() -> None:
    bent = Lens.from_config(LENSES["pi-v1"].replace(distortion=(-0.1, 0, 0, 0, 0)))
    assert bent.is_distorted
    once, steps = both(bent, FAULTS["noise"], scattered(8, 1, 1.0), np.zeros(3), 0.3)
    np.testing.assert_array_equal(once, steps)


def test_rows_that_are_told_to_be_alike_are() -> None:
    raycaster, told = Raycaster(PI, RobotConfig(), THINGS), 0
    for seed in range(8):
        image = raycaster.render(scattered(4, seed, 1.8), np.array([0.0, 0.0, 0.3 * seed]))
        first, last = raycaster.brushes(4).alike
        assert (image[:first] == image[:1]).all()
        assert (image[last:] == image[-1:]).all()
        told += first + len(image) - last
    assert told > 8 * 100


def _read_only() -> np.ndarray:
    image = np.zeros((460, 640, 3), np.uint8)
    image.setflags(write=False)
    return image


@pytest.mark.parametrize(
    ("out", "told"),
    [
        (np.zeros((460, 639, 3), np.uint8), r"uint8 of shape \(460, 640, 3\), got uint8 of \(460, 639, 3\)"),
        (np.zeros((460, 640), np.uint8), "got uint8 of"),
        (np.zeros((460, 640, 3)), "got float64 of"),
        (_read_only(), "got read-only uint8 of"),
    ],
)
def test_what_cannot_be_drawn_into_is_told_in_one_line(out: np.ndarray, told: str) -> None:
    raycaster, camera = Raycaster(PI, RobotConfig(), THINGS), Imperfections(FAULTS["pi-v1"], PI)
    scene, before = scattered(2, 0, 1.0), out.copy()
    with pytest.raises(PictureError, match=told):
        raycaster.render(scene, np.zeros(3), out=out)
    with pytest.raises(PictureError, match=told):
        photograph(raycaster, camera, scene, np.zeros(3), key=1, out=out)
    with pytest.raises(PictureError, match="can be spoiled"):
        camera.spoil(out, 1)
    np.testing.assert_array_equal(out, before)


def test_a_pose_is_three_numbers() -> None:
    with pytest.raises(DataError, match=r"shape \(3,\), got shape \(2,\)"):
        Raycaster(PI, RobotConfig(), THINGS).render(scattered(1, 0, 1.0), np.zeros(2))


def test_every_other_column_is_drawn_into_but_not_spoiled() -> None:
    raycaster, camera = Raycaster(PI, RobotConfig(), THINGS), Imperfections(FAULTS["pi-v1"], PI)
    scene, wide = scattered(2, 0, 1.0), np.zeros((460, 1280, 3), np.uint8)
    out = wide[:, ::2]
    assert raycaster.render(scene, np.zeros(3), out=out) is out
    np.testing.assert_array_equal(out, raycaster.render(scene, np.zeros(3)))
    assert not wide[:, 1::2].any()
    with pytest.raises(PictureError, match="with strides"):
        camera.spoil(out, 1)
