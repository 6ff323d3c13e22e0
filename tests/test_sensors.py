"""Infrared, ultrasonic and ring: the figures that the paper quotes, who hides whom, chance of one's own."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from swarmvision.config.arena import ArenaConfig, BoxConfig
from swarmvision.config.model import validated
from swarmvision.config.robot import RobotConfig
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.config.sensor import (
    InfraredRingSensorConfig,
    InfraredSensorConfig,
    TruthSensorConfig,
    UltrasonicSensorConfig,
)
from swarmvision.data import Scene
from swarmvision.geometry import FloatArray, wrap
from swarmvision.sensing import Sensor
from swarmvision.sensing.infrared import InfraredSensor
from swarmvision.sensing.infrared_ring import InfraredRingSensor
from swarmvision.sensing.truth import TruthSensor
from swarmvision.sensing.ultrasonic import UltrasonicSensor
from swarmvision.simulation import run

ROBOT, ARENA = RobotConfig(), ArenaConfig()
READINGS = 2000
# The standard deviation of n readings is known to 1/sqrt(2 n), their mean to 1/sqrt(n) of it; four of each.
SPREAD_TOLERANCE, MEAN_TOLERANCE = 4 / np.sqrt(2 * READINGS), 4 / np.sqrt(READINGS)

Make = Callable[..., Sensor]


def infrared(arena: ArenaConfig = ARENA, seed: int = 0, **settings: object) -> Sensor:
    quiet = {"airtime": 0.0, **settings}  # no message is lost
    return InfraredSensor(InfraredSensorConfig.model_validate(quiet), ROBOT, arena, seed)


def ultrasonic(arena: ArenaConfig = ARENA, seed: int = 0, **settings: object) -> Sensor:
    everybody = {"turn": 1e-3, **settings}  # so short that all sound between two calls
    return UltrasonicSensor(UltrasonicSensorConfig.model_validate(everybody), ROBOT, arena, seed)


def infrared_ring(arena: ArenaConfig = ARENA, seed: int = 0, **settings: object) -> Sensor:
    return InfraredRingSensor(InfraredRingSensorConfig.model_validate(settings), ROBOT, arena, seed)


RANGING = pytest.mark.parametrize("make", [infrared, ultrasonic])
EVERY = pytest.mark.parametrize("make", [infrared, ultrasonic, infrared_ring])


def at(time: float, scene: Scene) -> Scene:
    return replace(scene, time=time)


def standing(pose: Any, objects: Any = ()) -> Scene:
    """A scene some time into a run, when everybody has had a turn."""
    return at(10.0, Scene.at_rest(pose, objects))


def errors(make: Make, distance: float) -> tuple[FloatArray, FloatArray]:
    """Range and bearing errors of one robot's readings of one other, 60 deg to its left."""
    towards = np.radians(60.0)
    scene = standing([[0, 0, 0], [distance * np.cos(towards), distance * np.sin(towards), 1.0]])
    sensor = make()
    read = [sensor.sense(at(10 + 0.1 * n, scene)) for n in range(READINGS)]
    ranges, bearings = (np.array([getattr(r, name)[0, 0] for r in read]) for name in ("range", "bearing"))
    assert all(r.track[0, 0] == 1 and np.isnan(r.heading[0, 0]) for r in read)
    return ranges - distance, wrap(bearings - towards)


def test_infrared_has_the_errors_that_the_paper_quotes() -> None:
    off_range, off_bearing = errors(infrared, 0.20)
    assert off_range.std() == pytest.approx(0.065 * 0.20, rel=SPREAD_TOLERANCE)
    assert np.degrees(off_bearing.std()) == pytest.approx(9.4, rel=SPREAD_TOLERANCE)
    assert abs(off_range.mean()) < MEAN_TOLERANCE * off_range.std()
    assert abs(off_bearing.mean()) < MEAN_TOLERANCE * off_bearing.std()
    # Range and bearing err independently: their correlation is known to 1/sqrt(n).
    assert abs(np.corrcoef(off_range, off_bearing)[0, 1]) < MEAN_TOLERANCE


def test_ultrasound_has_the_errors_that_the_paper_quotes() -> None:
    off_range, off_bearing = errors(ultrasonic, 6.69)
    assert off_range.std() == pytest.approx(0.008, rel=SPREAD_TOLERANCE)
    assert np.degrees(off_bearing.std()) == pytest.approx(3.0, rel=SPREAD_TOLERANCE)
    assert abs(off_range.mean()) < MEAN_TOLERANCE * off_range.std()
    assert abs(off_bearing.mean()) < MEAN_TOLERANCE * off_bearing.std()


def test_infrared_reaches_no_farther_than_its_reach() -> None:
    scene = standing([[0, 0, 0], [1.4, 0, 0], [0, 1.6, 0]])
    assert infrared().sense(scene).track[0].tolist() == [1]
    assert infrared(reach=1.7).sense(scene).count[0] == 2


@pytest.mark.parametrize("robots", [2, 6, 21])
def test_infrared_messages_meet_in_a_crowd(robots: int) -> None:
    # A ring of robots that all see the one in its middle; a message arrives with (1 - a)^(n - 1).
    around = 2 * np.pi * np.arange(robots - 1) / (robots - 1)
    ring = np.stack([np.cos(around), np.sin(around), around], axis=1)
    sensor = infrared(airtime=0.05)
    scene = standing([[0, 0, 0], *ring])
    arrived = sum(int(sensor.sense(scene).count[0]) for _ in range(500))
    chance, messages = 0.95 ** (robots - 2), 500 * (robots - 1)
    assert arrived / messages == pytest.approx(chance, abs=4 * np.sqrt(0.25 / messages) * (robots > 2))


def test_ultrasound_reads_one_robot_a_turn() -> None:
    sensor = ultrasonic(turn=0.05)
    scene = standing([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    heard = [sorted(sensor.sense(at(0.05 * n, scene)).track.max(axis=1, initial=-1)) for n in range(8)]
    # Everybody but the one that sounds hears it: robot n mod 4.
    assert heard == [sorted([-1] + 3 * [n % 4]) for n in range(8)]
    # Two turns pass in a step of 0.1 s.
    assert ultrasonic(turn=0.05).sense(at(0.05, scene)).count.tolist() == [1, 1, 2, 2]


@RANGING
def test_without_errors_everyone_reads_the_truth(make: Make) -> None:
    silent = {"bearing_noise_deg": 0, "heading": True, "heading_noise_deg": 0, "reach": 3.0}
    silent |= {"range_noise_percent": 0} if make is infrared else {"range_noise": 0}
    pose = np.random.default_rng(2).uniform([-1, -1, -3], [1, 1, 3], (6, 3))
    true = TruthSensor(TruthSensorConfig(reach=3.0, occlusion=False), ROBOT, ARENA).sense(standing(pose))
    read = make(occlusion=False, **silent).sense(standing(pose))
    for robot in range(6):
        order = np.argsort(true.range[robot])
        np.testing.assert_array_equal(read.track[robot], true.track[robot, order])
        for name in ("range", "bearing", "heading"):
            np.testing.assert_allclose(
                getattr(read, name)[robot], getattr(true, name)[robot, order], atol=1e-9
            )


@RANGING
def test_robots_and_objects_hide_who_stands_behind(make: Make) -> None:
    poses = [[0, 0, 0], [0.4, 0, 0], [0.8, 0, 0]]
    assert make().sense(standing(poses)).track[0].max() == 1
    assert make(occlusion=False).sense(standing(poses)).track[0].max() == 2
    box = ArenaConfig(objects=(BoxConfig(x=0.6, y=0, length=0.02, width=0.3, height=0.2),))
    scene = standing([[0, 0, 0], [0.9, 0, 0]], [[0.6, 0, 0]])
    assert make(box).sense(scene).count.tolist() == [0, 0]


def test_a_low_box_hides_infrared_but_not_ultrasound() -> None:
    # 5 cm is above the chassis (4.4 cm) and below the markers (5.5 cm).
    box = ArenaConfig(objects=(BoxConfig(x=0.6, y=0, length=0.02, width=0.3, height=0.05),))
    scene = standing([[0, 0, 0], [0.9, 0, 0]], [[0.6, 0, 0]])
    assert infrared(box).sense(scene).count[0] == 0
    assert ultrasonic(box).sense(scene).count[0] == 1


def test_a_ring_feels_the_sector_of_a_robot_and_not_a_wall() -> None:
    read = infrared_ring(ArenaConfig(width=2, depth=2), noise=0, levels=0).sense(
        standing([[0.9, 0, 0], [0.9, 0.2, 0]])
    )
    assert read.seen[0].tolist() == [k == 2 for k in range(8)]
    assert read.range[0, 2] == pytest.approx(0.2)
    assert read.bearing[0, 2] == pytest.approx(np.pi / 2)
    assert np.isnan(read.heading[0, 2])


@RANGING
def test_a_told_compass_has_its_own_noise(make: Make) -> None:
    sensor = make(heading=True, heading_noise_deg=10)
    scene = standing([[0, 0, 0], [0.5, 0, 2.0]])
    told = np.array([sensor.sense(at(10 + 0.1 * n, scene)).heading[0, 0] for n in range(1000)])
    assert np.degrees(np.std(told)) == pytest.approx(10, rel=4 / np.sqrt(2000))
    assert np.mean(told) == pytest.approx(2.0, abs=4 * np.radians(10) / np.sqrt(1000))


@pytest.mark.parametrize("sensor", [InfraredSensor, UltrasonicSensor])
def test_a_message_tells_the_sender_s_team(sensor: type[InfraredSensor] | type[UltrasonicSensor]) -> None:
    config: Any = InfraredSensorConfig(airtime=0) if sensor is InfraredSensor else UltrasonicSensorConfig()
    read = sensor(config, ROBOT, ARENA, 0, (1, 1)).sense(standing([[0, 0, 0], [0.5, 0, 0], [0, 0.5, 0]]))
    assert read.kind is not None
    for slot in np.flatnonzero(read.seen[0]):
        assert read.kind[0, slot] == (1 if read.track[0, slot] == 1 else -1)


@RANGING
def test_only_the_nearest_are_read_where_slots_are_few(make: Make) -> None:
    scene = standing([[0, 0, 0], [0, 0.9, 0], [0.5, 0, 0], [-0.7, 0, 0]])
    assert (
        make(neighbours=2, airtime=0).sense(scene).track[0].tolist() == [2, 3] if make is infrared else True
    )


@EVERY
def test_one_seed_gives_one_reading_and_a_further_robot_shifts_nobody(make: Make) -> None:
    scene = standing([[0, 0, 0], [0.2, 0, 0]])
    more = standing([[0, 0, 0], [0.2, 0, 0], [7.5, 7.5, 0]])
    one, two, other = make(), make(), make(seed=1)
    differs = False
    for n in range(5):
        here, there = one.sense(at(10 + 0.1 * n, scene)), two.sense(at(10 + 0.1 * n, more)).select(slice(2))
        k = here.seen.shape[1]
        np.testing.assert_array_equal(here.range, there.range[:, :k])
        np.testing.assert_array_equal(here.bearing, there.bearing[:, :k])
        differs |= not np.array_equal(here.range, other.sense(at(10 + 0.1 * n, scene)).range, equal_nan=True)
    assert differs or make is infrared_ring  # whose steps may swallow so little noise


@EVERY
@pytest.mark.parametrize("robots", [0, 1])
def test_nobody_is_read_by_nobody_or_by_one(make: Make, robots: int) -> None:
    read = make().sense(standing(np.zeros((robots, 3))))
    assert read.seen.shape[0] == robots
    assert not read.seen.any()


@pytest.mark.parametrize("kind", ["infrared", "ultrasonic", "infrared-ring"])
def test_a_scenario_runs_with_it_and_repeats_itself(kind: str) -> None:
    values = {"robots": 5, "seconds": 2.0, "sensor": {"kind": kind, "lost": 0.1, "latency": 0.1}}
    scenario = validated(ScenarioConfig, {**values, "start": {"radius": 0.5}}, "test")
    one, two = run(scenario, 3), run(scenario, 3)
    assert json.dumps(one.summary) == json.dumps(two.summary)
    assert one.summary["sensor"] == kind
