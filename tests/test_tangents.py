"""A marker whose tangents are out of the picture, hidden or beside other rings, by both renderers."""

from __future__ import annotations

import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.camera import LENSES
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Estimates, Scene
from swarmvision.geometry import FloatArray, wrap
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.perception.steps import COMPARED, step_at
from swarmvision.rendering.mesh import MeshRenderer
from swarmvision.rendering.raycast import Raycaster

LENS, ROBOT = Lens.from_config(LENSES["pi-v1"]), RobotConfig()
MARKER = Marker.from_config(ROBOT.marker)
RADIUS = ROBOT.marker.radius
RENDERERS: dict[str, Raycaster | MeshRenderer] = {
    "raycast": Raycaster(LENS, ROBOT, ArenaConfig()),
    "mesh": MeshRenderer(LENS, ROBOT, ArenaConfig()),
}
BOTH = pytest.mark.parametrize("renderer", RENDERERS)


def read(renderer: str, *polar: tuple[float, float, float], method: str = "edges") -> Estimates:
    """What is read of robots at ranges, bearings and headings."""
    poses = [(d * np.cos(b), d * np.sin(b), psi) for d, b, psi in polar]
    return Reader(LENS, MARKER, method).read(RENDERERS[renderer].render(Scene.at_rest(poses), np.zeros(3)))


def off(estimates: Estimates, n: int, true: tuple[float, float, float]) -> FloatArray:
    """By how many standard deviations an estimate is wrong, ``(3,)``."""
    errors = [estimates.range[n] - true[0], estimates.bearing[n] - true[1], estimates.heading[n] - true[2]]
    errors[2] = wrap(errors[2])
    return np.abs(errors) / np.sqrt(np.diag(estimates.covariance[n]))


@BOTH
@pytest.mark.parametrize("method", ["edges", "fit"])
@pytest.mark.parametrize("distance", [0.09, 0.105, 0.12, 0.14, 0.2])
def test_a_near_marker_is_read_wherever_it_stands(renderer: str, method: str, distance: float) -> None:
    # Its rims recede steeply; the farthest bearing has half of it beyond the picture's side.
    for bearing in LENS.fov / 2.0 * np.array([0.0, 0.3, 0.6, 0.75, 0.9, 1.0]):
        left = read(renderer, (distance, bearing, 0.4), method=method)
        right = read(renderer, (distance, -bearing, -0.4), method=method)
        assert len(left.seen) == len(right.seen) == 1
        for side, found in ((1.0, left), (-1.0, right)):
            assert found.range[0] == pytest.approx(distance, rel=1e-3)
            assert side * found.bearing[0] == pytest.approx(bearing, abs=1e-3)
            assert side * found.heading[0] == pytest.approx(0.4, abs=0.02)


def test_in_a_crowd_the_bearings_doubts_are_honest() -> None:
    rng, wrong = np.random.default_rng(5), []
    for _ in range(80):
        crowd: list[tuple[float, float, float]] = []
        while len(crowd) < 8:
            d, b = rng.uniform(0.13, 1.2), rng.uniform(-0.4, 0.4)
            if all(np.abs(d * np.exp(1j * b) - e * np.exp(1j * c)) > 0.11 for e, c, _ in crowd):
                crowd.append((d, b, rng.uniform(-3, 3)))
        found = read("raycast", *crowd)
        for true in crowd:
            near = np.abs(found.range / true[0] - 1.0) < 0.1
            near &= np.abs(found.bearing - true[1]) < RADIUS / true[0]
            wrong += [off(found, int(n), true)[1] for n in np.flatnonzero(near)]
    assert len(wrong) > 200
    assert np.sqrt(np.mean(np.square(wrong))) < 1.0
    assert np.quantile(wrong, 0.99) < 4.0


@BOTH
def test_who_stands_between_two_nearer_ones_is_told_with_its_doubt(renderer: str) -> None:
    far, doubts = 0.55, []
    half = np.arcsin(RADIUS / far)
    for left, right in ((0.7, 0.7), (0.8, 0.4), (0.3, 0.8), (0.5, 0.6)):
        beside = [
            (0.25, left * half + np.arcsin(RADIUS / 0.25), 1.0),
            (0.37, -right * half - np.arcsin(RADIUS / 0.37), 2.0),
        ]
        found = read(renderer, (far, 0.0, -1.0), *beside)
        assert len(found.seen) == 3
        assert (off(found, 2, (far, 0.0, -1.0)) < 4.0).all()
        assert all((off(found, n, beside[n]) < 4.0).all() for n in (0, 1))
        doubts.append(found.covariance[2, 1, 1] / found.covariance[0, 1, 1])
    assert min(doubts) > 10.0


def step(heights: list[float], place: int) -> float:
    return step_at(np.array(heights), 0, place, len(heights), np.empty(2 * COMPARED))[0]


def test_what_goes_on_evenly_is_no_step() -> None:
    assert step([5.0] * 8, 4) == 0.0
    assert step([9.0, 8.0, 7.0, 6.0, 5.0, 4.0], 3) == pytest.approx(0.0)
    rim = [100.0 - 30.0 * np.sqrt(1.0 - x) for x in np.linspace(0.9, 0.0, 10)][::-1]
    assert max(step(rim, k) for k in range(3, 8)) < 0.4 * (rim[-1] - rim[-4])


def test_a_step_is_as_large_from_either_side() -> None:
    heights = [30.0, 30.0, 29.0, 21.0, 20.0, 20.0]
    assert step(heights, 3) == pytest.approx(10.0 - 3.0 * 0.5)
    assert step(heights[::-1], 3) == step(heights, 3)
    assert step(heights[:4], 3) == pytest.approx(9.0)  # a column is too few to tell how it goes on
