"""The loop: same seed same bytes, and every frame holds what belongs together."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from swarmvision.config.model import validated
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.data import Commands
from swarmvision.errors import ConfigError, PhysicsError
from swarmvision.geometry import compose
from swarmvision.simulation import Frame, Simulation, run


def scenario(**changes: object) -> ScenarioConfig:
    values = {"robots": 4, "seconds": 2.0, "sensor": {"kind": "truth"}, "start": {"radius": 0.5}}
    return validated(ScenarioConfig, {**values, **changes}, "test")


CAMERA = {"kind": "camera", "rig": "ring-2"}


@pytest.mark.parametrize("sensor", [{"kind": "truth"}, CAMERA], ids=["truth", "camera"])
def test_one_seed_gives_one_outcome_whatever_the_workers(sensor: dict[str, object]) -> None:
    one = run(scenario(sensor=sensor), seed=5, workers=1)
    two = run(scenario(sensor=sensor), seed=5, workers=3)
    assert json.dumps(one.summary) == json.dumps(two.summary)
    np.testing.assert_array_equal(one.pose, two.pose)


def test_another_seed_gives_another_outcome() -> None:
    assert run(scenario(), 1).summary["state_sha256"] != run(scenario(), 2).summary["state_sha256"]


def test_another_process_gives_the_same_bytes() -> None:
    code = (
        "from swarmvision.config.scenario import ScenarioConfig as S; from swarmvision.simulation import run;"
        "print(run(S(robots=4, seconds=2.0, sensor={'kind': 'camera', 'rig': 'ring-2'},"
        "start={'radius': 0.5}), 5).summary['state_sha256'])"
    )
    there = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    here = run(scenario(sensor=CAMERA), seed=5).summary["state_sha256"]
    assert there.stdout.strip() == here


def test_keeping_pictures_changes_nothing_else() -> None:
    kept = run(scenario(sensor=CAMERA), 4, keep_pictures=True)
    assert kept.summary == run(scenario(sensor=CAMERA), 4).summary


def test_every_frame_is_told_in_order() -> None:
    frames: list[Frame] = []
    result = run(scenario(), 0, frames.append)
    assert [frame.step for frame in frames] == list(range(20))
    np.testing.assert_allclose(result.time, np.arange(20) * 0.1, atol=1e-9)
    np.testing.assert_array_equal(result.pose, [frame.scene.pose for frame in frames])


@pytest.mark.parametrize("robots", [0, 1])
@pytest.mark.parametrize("sensor", [{"kind": "truth"}, CAMERA], ids=["truth", "camera"])
def test_no_robots_and_one_robot_are_normal(robots: int, sensor: dict[str, object]) -> None:
    result = run(scenario(robots=robots, seconds=0.5, sensor=sensor))
    assert result.pose.shape == (5, robots, 3)
    assert np.isfinite(result.pose).all()
    json.dumps(result.summary, allow_nan=False)


def test_a_command_that_is_not_finite_is_refused_by_name() -> None:
    simulation = Simulation(scenario())
    speed = np.array([0.1, np.nan, 0.1, 0.1])
    with pytest.raises(PhysicsError, match=r"speed.*robot 1.*nan"):
        simulation.act(Commands(speed, np.zeros(4)))


SHEEP = {"name": "sheep", "count": 3, "controller": {"law": "cohesion", "alone": "stop"}}


def test_teams_keep_their_own_laws_senses_and_places() -> None:
    own = {"sensor": {"kind": "truth", "reach": 0.01}, "start": {"x": 3.0, "y": 1.0, "radius": 0.5}}
    simulation = Simulation(scenario(robots=5, teams=[{**SHEEP, **own}]), 3)
    assert (np.hypot(*(simulation.scene.pose[2:, :2] - (3.0, 1.0)).T) <= 0.5).all()
    assert (np.hypot(*simulation.scene.pose[:2, :2].T) <= 0.5).all()
    estimates = simulation.sense()
    assert estimates.count.tolist() == [1, 1, 0, 0, 0]  # the sheep see no farther than their noses
    commands = simulation.decide(simulation.feel(estimates))
    assert (commands.speed[2:] == 0.0).all()
    assert (commands.speed[:2] > 0.0).any()


def test_nobody_takes_pictures_that_nobody_asks_for() -> None:
    watched = [{**SHEEP, "sensor": {"kind": "truth"}}]
    simulation = Simulation(scenario(robots=5, sensor=CAMERA, teams=watched), 3, keep_pictures=True)
    common = Simulation(scenario(robots=5, sensor=CAMERA, teams=[SHEEP]), 3)
    estimates, everybody = simulation.sense(), common.sense()
    assert {picture.robot for picture in simulation.pictures} == {0, 1}
    for robot in (0, 1):
        seen = estimates.range[robot][estimates.seen[robot]]
        assert seen.tolist() == everybody.range[robot][everybody.seen[robot]].tolist()
    assert (estimates.count[2:] > 0).any()


def test_more_robots_in_teams_than_robots_is_refused() -> None:
    with pytest.raises(ConfigError, match="robots must be at least those of its teams, 3, got 2"):
        scenario(robots=2, teams=[SHEEP])


def test_some_robots_know_the_goal_and_the_ground_tells_its_cue() -> None:
    changes = {
        "goal": {"x": 1.0, "y": 2.0, "informed": 0.5},
        "arena": {"cues": [{"x": 0.0, "y": 0.0, "radius": 2.0}]},
    }
    simulation = Simulation(scenario(**changes), 2)
    senses = simulation.feel(simulation.sense())
    pose = simulation.scene.pose
    found = compose(pose[:2], np.column_stack([senses.goal[:2], [0, 0]]))[:, :2]
    np.testing.assert_allclose(found, [[1.0, 2.0]] * 2, atol=1e-12)
    assert np.isnan(senses.goal[2:]).all()
    np.testing.assert_allclose(senses.cue, 1.0 - np.hypot(*pose[:, :2].T) / 2.0)
