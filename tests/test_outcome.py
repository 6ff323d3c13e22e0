"""What a run came to: every measure has its figures, whoever ran and however few."""

from __future__ import annotations

import json

import numpy as np
import pytest

from swarmvision.config.model import validated
from swarmvision.config.scenario import ScenarioConfig, packaged_scenario, packaged_scenarios
from swarmvision.data import Scene
from swarmvision.outcome import outcome
from swarmvision.simulation import run

MEASURES = ["flocking", "aggregation", "milling", "lattice", "chain", "herding", "transport"]


def scenario(measure: str, **values: object) -> ScenarioConfig:
    return validated(ScenarioConfig, {"measure": measure, "sensor": {"kind": "truth"}, **values}, "test")


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("robots", [0, 1, 3])
def test_every_measure_has_figures_for_any_number_of_robots(measure: str, robots: int) -> None:
    figures = run(scenario(measure, robots=robots, seconds=0.5)).summary["outcome"]
    assert figures
    json.dumps(figures, allow_nan=False)


def test_a_flock_is_home_when_its_last_sheep_is() -> None:
    goal = {"x": 0.0, "y": 0.0, "radius": 1.0}
    sheep = {"name": "sheep", "count": 2, "controller": {"law": "sheep"}}
    herd = scenario("herding", robots=3, teams=[sheep], goal=goal)
    dog = [5.0, 0.0, 0.0]
    course = [[dog, [0.5, 0, 0], [x, 0, 0]] for x in (2.0, 1.5, 0.9, 1.2)]
    figures = outcome(herd, [Scene.at_rest(pose) for pose in course])
    assert figures == {"herding_success": True, "home_at": 0.2, "gathered_share_final": 0.5}


def test_a_load_is_the_first_thing_that_can_be_pushed() -> None:
    things = [
        {"kind": "disc", "x": 1.0, "y": 1.0},
        {"kind": "box", "x": 0.0, "y": 0.0, "mass": 1.0},
    ]
    work = scenario("transport", robots=0, arena={"objects": things}, goal={"x": 3.0, "y": 4.0})
    scenes = [Scene.at_rest([], [[1, 1, 0], [x, y, 0]]) for x, y in ((0.0, 0.0), (0.6, 0.8))]
    figures = outcome(work, scenes)
    assert figures["transport_distance"] == pytest.approx(1.0)
    assert figures["transport_progress"] == pytest.approx(1.0)  # 5 m to go, then 4


@pytest.mark.parametrize("name", sorted(packaged_scenarios()))
def test_every_packaged_scenario_runs_and_says_what_it_came_to(name: str) -> None:
    changes = ["seconds=0.3", 'sensor={kind="truth"}']
    result = run(packaged_scenario(name, changes), 3)
    assert np.isfinite(result.pose).all()
    json.dumps(result.summary, allow_nan=False)
