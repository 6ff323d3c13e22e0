"""Silhouettes: where a marker is, how wide it is, what hides it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from swarmvision.config.model import validated
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.data import BoolArray, Estimates, Scene
from swarmvision.sensing.registry import sensor_of
from swarmvision.sensing.silhouette import SECTORS, Silhouettes, believed
from swarmvision.simulation import Simulation

DISC = {"kind": "disc", "x": 0.25, "y": 0.0, "radius": 0.1, "height": 0.2}


def silhouette(scene: Scene, **changes: Any) -> BoolArray:
    values = {"robots": scene.robots, "sensor": {"kind": "truth"}, **changes}
    scenario = validated(ScenarioConfig, values, "test")
    sensor = sensor_of(scenario.sensor, scenario, 0)
    return Silhouettes(sensor, scenario).of(scene, sensor.sense(scene))


def middles(seen: BoolArray) -> np.ndarray:
    return -np.pi + (np.nonzero(seen)[0] + 0.5) * 2.0 * np.pi / SECTORS


def test_a_marker_covers_its_angular_width_round_its_bearing() -> None:
    seen = silhouette(Scene.at_rest([[0, 0, 0.5], [0.3, 0.4, 2.0]]))
    half, bearing = np.arcsin(0.02 / 0.5), np.arctan2(0.4, 0.3) - 0.5
    width = 2.0 * np.pi / SECTORS
    found = middles(seen[0])
    assert abs(len(found) * width - 2.0 * half) <= width
    np.testing.assert_allclose(found.mean(), bearing, atol=width)


def test_a_marker_straight_behind_is_in_the_first_and_in_the_last_sector() -> None:
    seen = silhouette(Scene.at_rest([[0, 0, 0], [-0.3, 0, 0]]))[0]
    assert seen[0]
    assert seen[-1]
    assert not seen[SECTORS // 2]


def test_turning_the_world_turns_nothing_for_the_robots() -> None:
    pose = np.array([[0, 0, 0.2], [0.4, 0.1, 1.0], [-0.2, 0.5, -2.0]])
    turned = pose.copy()
    turned[:, :2] = pose[:, :2] @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    turned[:, 2] += np.pi / 2
    np.testing.assert_array_equal(silhouette(Scene.at_rest(turned)), silhouette(Scene.at_rest(pose)))


def test_what_stands_before_a_marker_hides_it_and_the_field_of_view_ends() -> None:
    scene = Scene.at_rest([[0, 0, 0], [0.5, 0, 0]], [[0.25, 0, 0]])
    assert not silhouette(scene, arena={"objects": [DISC]})[0].any()
    assert silhouette(scene, arena={"objects": [{**DISC, "height": 0.04}]})[0].any()
    assert not silhouette(
        Scene.at_rest([[0, 0, np.pi], [0.5, 0, 0]]), sensor={"kind": "truth", "fov_deg": 90}
    )[0].any()
    assert not silhouette(Scene.at_rest([[0, 0, 0], [2.5, 0, 0]]))[0].any()  # beyond the reach


def test_where_neighbours_are_known_exactly_what_is_believed_is_true() -> None:
    scene = Scene.at_rest([[0, 0, 0.3], [0.4, 0.1, 1.0], [-0.2, 0.5, -2.0]])
    scenario = validated(ScenarioConfig, {"robots": 3, "sensor": {"kind": "truth"}}, "test")
    estimates = sensor_of(scenario.sensor, scenario, 0).sense(scene)
    np.testing.assert_array_equal(believed(estimates, 0.02), silhouette(scene))
    assert believed(Estimates.empty((2, 0)), 0.02).shape == (2, SECTORS)
    assert not believed(Estimates.empty((2, 3)), 0.02).any()


def test_the_loop_shows_silhouettes_to_the_laws_that_ask_for_them_alone() -> None:
    values = {"robots": 3, "sensor": {"kind": "truth"}, "start": {"radius": 0.4}}
    for law, sectors in (("visual", SECTORS), ("kobot", 0)):
        scenario = validated(ScenarioConfig, {**values, "controller": {"law": law}}, "test")
        simulation = Simulation(scenario)
        senses = simulation.feel(simulation.sense())
        assert senses.silhouette.shape == (3, sectors)
        assert senses.silhouette.any() == (sectors > 0)


@pytest.mark.parametrize("rig", ["ring-7", "single"])
def test_a_cameras_pixels_show_the_silhouettes_that_are_there(rig: str) -> None:
    sensor = {"kind": "camera", "rig": rig, "imperfections": "pi-v1"}
    values = {"robots": 5, "sensor": sensor, "start": {"radius": 0.5}, "controller": {"law": "visual"}}
    simulation = Simulation(validated(ScenarioConfig, values, "test"), 3)
    senses = simulation.feel(simulation.sense())
    truth = silhouette(simulation.scene)
    if rig == "single":
        inside = np.abs(np.degrees(middles(np.ones(SECTORS, dtype=bool)))) < 20.0
        truth = truth[:, inside]
        found = senses.silhouette[:, inside]
    else:
        found = senses.silhouette
    # The lens stands 4 cm ahead of the axis: at 0.2 m a marker is seen up to 11 deg aside, 23 sectors.
    assert (np.count_nonzero(found, axis=-1) > 0).any()
    shift = 24
    near = np.zeros_like(truth)
    for offset in range(-shift, shift + 1):
        near |= np.roll(truth, offset, axis=-1)
    assert np.count_nonzero(found & ~near) <= 0.02 * np.count_nonzero(found)
