"""Work that robots do on the world: a dog and its sheep, a load and those who push it."""

from __future__ import annotations

from typing import Any

import numpy as np
from neighbours import flock_at

from swarmvision.config.controller import DogConfig
from swarmvision.config.model import validated
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.controllers.crowd import crowd
from swarmvision.controllers.dog import post
from swarmvision.simulation import Frame, Simulation, run

SHEEP = {"name": "sheep", "count": 4, "controller": {"law": "sheep"}}


def scenario(**values: Any) -> ScenarioConfig:
    return validated(ScenarioConfig, {"sensor": {"kind": "truth", "reach": 12.0}, **values}, "test")


def test_true_eyes_tell_teams_apart() -> None:
    simulation = Simulation(scenario(robots=6, teams=[SHEEP], start={"radius": 1.0}))
    seen = simulation.sense()
    kind = np.asarray(seen.kind)[seen.seen]
    assert set(kind.tolist()) == {0, 1}
    np.testing.assert_array_equal(kind, seen.track[seen.seen] >= 2)


def test_a_team_with_a_sensor_of_its_own_does_not_share_the_common_one() -> None:
    own = {**SHEEP, "sensor": {"kind": "truth"}}
    assert scenario(robots=6, teams=[SHEEP]).with_common_sensor == (0, 1, 2, 3, 4, 5)
    assert scenario(robots=6, teams=[own]).with_common_sensor == (0, 1)


def test_a_dog_drives_a_close_flock_from_behind_and_fetches_a_stray() -> None:
    config = DogConfig(sheep_range=0.2)
    goal, known = np.array(10.0 + 0.0j), np.array(True)
    close = crowd(flock_at((2.0, 0.1), (2.0, -0.1), (2.2, 0.1), (2.2, -0.1)), 100.0)
    # The middle is at 2.1, the goal beyond: behind it by 0.2 sqrt(4) is 1.7.
    np.testing.assert_allclose(post(close, goal, known, config), 1.7)
    # The third is 1.33 from the middle (2, 0.67), more than 0.2 * 3^(2/3): 0.2 behind it is (2, 2.2).
    torn = crowd(flock_at((2.0, 0.0), (2.0, 0.0), (2.0, 2.0)), 100.0)
    np.testing.assert_allclose(post(torn, goal, known, config), 2.0 + 2.2j)


def test_a_dog_that_sees_no_sheep_crosses_the_arena_until_it_does() -> None:
    arena = {"width": 6.0, "depth": 6.0}
    blind = {"kind": "truth", "reach": 0.5}
    alone = {"robots": 1, "seconds": 90.0, "arena": arena, "proximity": {}, "sensor": blind}
    result = run(scenario(**alone, controller={"law": "dog"}, start={"x": 0, "y": 0, "radius": 0.1}), seed=3)
    place = result.pose[:, 0, :2]
    assert float(np.ptp(place, axis=0).max()) > 4.5  # m: to walls that face each other
    assert result.summary["contacts"] == 0


def test_sheep_flee_the_dog_and_else_stay() -> None:
    start = {"x": 0.0, "y": 0.0, "radius": 0.6}
    values = {"robots": 5, "teams": [{**SHEEP, "start": start}], "seconds": 8.0, "controller": {"law": "dog"}}

    def middle_moved(dog_at: float) -> float:
        result = run(scenario(**values, start={"x": dog_at, "y": 0.0, "radius": 0.2}))
        return float((result.pose[-1, 1:, 0] - result.pose[0, 1:, 0]).mean())

    assert middle_moved(1.1) < -0.2
    assert abs(middle_moved(7.0)) < 0.1


def pushed(robots: int, seconds: float) -> float:
    """How far (m) robots push a box of 2 kg, which rubs with 9.8 N, where one robot grips with 3.9 N."""
    box = {"kind": "box", "x": 0.0, "y": 0.0, "length": 0.4, "width": 0.4, "mass": 2.0}
    places: list[np.ndarray] = []

    def on_frame(frame: Frame) -> None:
        places.append(frame.scene.object_pose[0])

    run(
        scenario(
            robots=robots,
            seconds=seconds,
            arena={"width": 6.0, "depth": 6.0, "objects": [box]},
            goal={"x": 2.5, "y": 0.0, "occlusion": True},
            start={"x": -0.7, "y": 0.0, "radius": 0.4},
            controller={"law": "transport"},
        ),
        2,
        on_frame,
    )
    return float(np.hypot(*(places[-1] - places[0])[:2]))


def test_six_robots_carry_a_box_a_metre_that_one_cannot_move() -> None:
    assert pushed(6, 60.0) >= 1.0
    assert pushed(1, 30.0) < 0.001
