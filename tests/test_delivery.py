"""How readings reach the robot: late, lost, from broken sensors, and carried on by odometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import TruthSensorConfig, UltrasonicSensorConfig
from swarmvision.data import Estimates, Scene
from swarmvision.drive import Drive
from swarmvision.geometry import compose
from swarmvision.sensing.delivery import DRIFT, Delivery
from swarmvision.sensing.truth import TruthSensor
from swarmvision.sensing.ultrasonic import UltrasonicSensor

ROBOT, ARENA = RobotConfig(), ArenaConfig()
DT, SPEED, TURN_RATE = 0.1, 0.2, 1.5


def delivery(seed: int = 0, **settings: object) -> Delivery:
    config = TruthSensorConfig.model_validate({"reach": 5.0, **settings})
    return Delivery(TruthSensor(config, ROBOT, ARENA), config, ROBOT, seed)


def scene(step: int, robots: int = 3) -> Scene:
    """Robot 0 drives along an arc; the others stand. Its encoders tell the same arc."""
    place = [[0, 0, 0], [0.8, 0.3, 1.0], [-0.5, 0.9, -2.0], [4.0, 4.0, 0.0]][:robots]
    turn, radius = TURN_RATE * DT * step, SPEED / TURN_RATE
    pose = np.array(place, dtype=np.float64)
    pose[0] = [radius * np.sin(turn), radius * (1 - np.cos(turn)), turn]
    travel = np.zeros((robots, 2))
    travel[0] = Drive.from_config(ROBOT).wheel_speeds(SPEED, TURN_RATE) * DT * step
    return replace(Scene.at_rest(pose), time=DT * step, wheel_travel=travel)


def assert_alike(one: Estimates, two: Estimates) -> None:
    np.testing.assert_array_equal(one.seen, two.seen)
    np.testing.assert_array_equal(one.track, two.track)
    for name in ("range", "bearing", "heading"):
        np.testing.assert_allclose(getattr(one, name), getattr(two, name), atol=1e-9)


def test_a_perfect_way_changes_nothing() -> None:
    here = delivery()
    for step in range(3):
        assert_alike(here.sense(scene(step)), delivery().sense(scene(step)))


def test_a_late_reading_is_carried_on_by_the_encoders() -> None:
    # The neighbours stand, so what was true three steps ago, moved by the own way, is true now.
    late = delivery(latency=0.3)
    for step in range(3):
        assert late.sense(scene(step)).count.tolist() == [0, 0, 0]
    for step in range(3, 6):
        believed, true = late.sense(scene(step)).select([0]), delivery().sense(scene(step)).select([0])
        assert_alike(believed, true)
        np.testing.assert_allclose(believed.age, 0.3)
        grown = believed.covariance[0, :, 0, 0] - true.covariance[0, :, 0, 0]
        np.testing.assert_allclose(grown, (DRIFT * 0.3) ** 2)


def test_a_neighbour_that_moved_meanwhile_is_believed_where_it_was() -> None:
    late = delivery(latency=0.1)
    late.sense(scene(0))
    assert late.sense(scene(1)).range[1, 0] == pytest.approx(np.hypot(0.8, 0.3))  # robot 1 of robot 0


def test_the_given_share_of_readings_is_lost() -> None:
    lossy, n = delivery(lost=0.3), 1000
    seen = np.array([lossy.sense(scene(step)).seen for step in range(n)])
    # 6 readings a step; a share of m readings is known to sqrt(p (1 - p) / m); four of that.
    assert seen.mean() == pytest.approx(0.7, abs=4 * np.sqrt(0.3 * 0.7 / (6 * n)))
    assert (delivery(lost=1.0).sense(scene(0)).count == 0).all()


def test_losses_follow_the_seed_and_a_further_robot_shifts_nobody() -> None:
    one, two, other = (delivery(lost=0.5, seed=seed) for seed in (0, 0, 1))
    differs = False
    for step in range(8):
        seen = one.sense(scene(step)).seen
        np.testing.assert_array_equal(seen, two.sense(scene(step, robots=4)).seen[:3, :2])
        differs |= not np.array_equal(seen, other.sense(scene(step)).seen)
    assert differs


def test_memory_bridges_losses_and_forgets_in_time() -> None:
    class Blink(TruthSensor):
        def sense(self, scene: Scene) -> Estimates:
            seen = super().sense(scene)
            return seen if scene.time < 0.05 else Estimates.empty(seen.seen.shape)

    config = TruthSensorConfig(reach=5.0, memory=0.25)
    blink = Delivery(Blink(config, ROBOT, ARENA), config, ROBOT)
    for step in range(3):
        believed = blink.sense(scene(step)).select([0])
        assert_alike(believed, delivery().sense(scene(step)).select([0]))
        np.testing.assert_allclose(believed.age, DT * step)
    assert blink.sense(scene(3)).count.tolist() == [0, 0, 0]


def test_ultrasound_is_whole_after_a_round_of_turns() -> None:
    config = UltrasonicSensorConfig(range_noise=0, bearing_noise_deg=0, turn=DT)
    sensor = Delivery(UltrasonicSensor(config, ROBOT, ARENA), config, ROBOT)
    seen = [sensor.sense(scene(step)) for step in range(5)]
    assert [int(s.count[0]) for s in seen] == [0, 1, 2, 2, 2]
    assert sorted(seen[4].track[0].tolist()) == [1, 2]
    np.testing.assert_allclose(sorted(seen[4].age[0]), [0.0, DT * 2], atol=1e-9)  # heard in steps 4 and 2
    true = delivery().sense(scene(4))
    np.testing.assert_allclose(sorted(seen[4].bearing[0]), sorted(true.bearing[0]), atol=1e-9)


def test_a_dead_sensor_sees_nobody_and_a_stuck_one_always_the_same() -> None:
    broken = delivery(faults={"dead": [1, 99], "stuck": [0]})
    first = broken.sense(scene(0))
    assert first.count.tolist() == [2, 0, 2]
    later = broken.sense(scene(5))
    assert_alike(later.select([0]), first.select([0]))
    assert_alike(later.select([2]), delivery().sense(scene(5)).select([2]))


def test_a_mirrored_way_gives_mirrored_beliefs() -> None:
    def mirrored(s: Scene) -> Scene:
        return replace(s, pose=s.pose * [1, -1, -1], wheel_travel=s.wheel_travel[:, ::-1])

    here, there = delivery(latency=0.2), delivery(latency=0.2)
    for step in range(5):
        one, two = here.sense(scene(step)), there.sense(mirrored(scene(step)))
    np.testing.assert_allclose(one.range, two.range)
    np.testing.assert_allclose(one.bearing, -two.bearing)
    np.testing.assert_allclose(one.heading, -two.heading)


def test_everybody_may_be_nobody() -> None:
    nobody = Scene.at_rest(np.zeros((0, 3)))
    way = delivery(latency=0.1, lost=0.5, memory=1.0, faults={"dead": [0], "stuck": [1]})
    for step in range(3):
        assert way.sense(replace(nobody, time=DT * step)).seen.shape == (0, 0)


def test_an_arc_of_the_encoders_is_the_arc_of_the_pose() -> None:
    # The premise of these tests: composing ten small arcs ends where the scene has the robot.
    pose = np.zeros(3)
    turn = TURN_RATE * DT
    radius = SPEED / TURN_RATE
    for _ in range(10):
        pose = compose(pose, [radius * np.sin(turn), radius * (1 - np.cos(turn)), turn])
    np.testing.assert_allclose(pose, scene(10).pose[0], atol=1e-12)
