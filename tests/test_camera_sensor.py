"""The camera sensor: real pixels in, tracked neighbours out."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from swarmvision.config.arena import ARENAS
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import CameraSensorConfig, TruthSensorConfig
from swarmvision.data import Commands, Estimates, Scene
from swarmvision.geometry import wrap
from swarmvision.sensing.camera import CameraSensor, between
from swarmvision.sensing.truth import TruthSensor
from swarmvision.world import World

ROBOT = RobotConfig()
ARENA = ARENAS["open"]
CIRCLE = np.array([[0.35 * np.cos(a), 0.35 * np.sin(a), 2.5 * a + 1] for a in np.arange(5) * 2 * np.pi / 5])


def sensor(robots: int, workers: int = 1, keep: bool = False, **settings: object) -> CameraSensor:
    # Pictures that are lost or late have tests of their own.
    defaults = {"rig": "ring-7", "imperfections": {"dropped": 0, "late": 0}}
    config = CameraSensorConfig.model_validate({**defaults, **settings})
    return CameraSensor(config, ROBOT, ARENA, robots, seed=3, keep_pictures=keep, workers=workers)


def sorted_by_bearing(estimates: Estimates, robot: int) -> Estimates:
    row = estimates.select(robot)
    row = row.select(row.seen)
    return row.select(np.argsort(row.bearing))


def same(one: Estimates, two: Estimates) -> bool:
    return all(
        np.array_equal(getattr(one, f.name), getattr(two, f.name), equal_nan=f.name != "seen")
        for f in fields(Estimates)
        if f.name != "frame"
    )


def test_a_ring_of_cameras_sees_what_is_there() -> None:
    scene = Scene.at_rest(CIRCLE)
    truth = TruthSensor(TruthSensorConfig(), ROBOT, ARENA).sense(scene)
    estimates = sensor(5).sense(scene)
    for robot in range(5):
        true, got = sorted_by_bearing(truth, robot), sorted_by_bearing(estimates, robot)
        assert len(got.seen) == len(true.seen) == 4
        np.testing.assert_allclose(got.range, true.range, rtol=0.02)
        np.testing.assert_allclose(wrap(got.bearing - true.bearing), 0, atol=np.radians(0.5))
        np.testing.assert_allclose(wrap(got.heading - true.heading), 0, atol=np.radians(10))


def test_the_number_of_workers_changes_no_bit() -> None:
    scene = Scene.at_rest(CIRCLE)
    assert same(sensor(5, workers=1).sense(scene), sensor(5, workers=3).sense(scene))


@pytest.mark.parametrize("robots", [0, 1])
def test_nobody_is_seen_by_nobody_or_by_one(robots: int) -> None:
    estimates = sensor(robots).sense(Scene.at_rest(np.zeros((robots, 3))))
    assert estimates.seen.shape[0] == robots
    assert not estimates.seen.any()


def test_another_robot_far_away_shifts_nobody_elses_noise() -> None:
    one, two = sensor(2, keep=True, rig="single"), sensor(3, keep=True, rig="single")
    one.sense(Scene.at_rest([[0, 0, 0], [0.4, 0, 0]]))
    two.sense(Scene.at_rest([[0, 0, 0], [0.4, 0, 0], [-5, 0, 0]]))
    np.testing.assert_array_equal(one.pictures[0].image, two.pictures[0].image)


def test_pictures_are_kept_only_when_asked_for() -> None:
    scene = Scene.at_rest(CIRCLE)
    assert sensor(5).pictures == ()
    kept = sensor(5, keep=True)
    kept.sense(scene)
    assert [(p.robot, p.lens) for p in kept.pictures] == [(r, c) for r in range(5) for c in range(7)]


def test_estimates_come_late_by_the_latency() -> None:
    robots = [[0, 0, 0], [0.4, 0, 0]]
    late = sensor(2, latency=0.15)
    world = World(ARENA, ROBOT, Scene.at_rest(robots))
    scene = Scene.at_rest(robots)
    seen = []
    for _ in range(4):
        estimates = late.sense(scene)
        seen.append(bool(estimates.seen[0].any()))
        age = estimates.age[0][estimates.seen[0]]
        assert np.all(age > 0.1)
        scene = world.step(Commands.stop((2,)), 0.1, 4)
    assert seen == [False, False, True, True]  # the picture of time 0 arrives at 0.15


def test_ego_motion_does_not_move_a_still_neighbour_in_the_world() -> None:
    robots = [[0, 0, 0], [0.5, 0.1, 1.0]]
    turning = sensor(2, rate_hz=5)
    world = World(ARENA, ROBOT, Scene.at_rest(robots))
    scene = Scene.at_rest(robots)
    for _ in range(15):
        estimates = turning.sense(scene)
        me = scene.pose[0]
        place = estimates.positions[0][estimates.seen[0]]
        assert len(place) == 1
        world_bearing = wrap(me[2] + np.arctan2(place[0, 1], place[0, 0]))
        true = scene.pose[1] - me
        assert abs(wrap(world_bearing - np.arctan2(true[1], true[0]))) < np.radians(2.0)
        scene = world.step(Commands(np.array([0.0, 0.0]), np.array([1.5, 0.0])), 0.1, 12)


def test_between_two_scenes_yaw_takes_the_short_way() -> None:
    first = Scene.at_rest([[0, 0, 3.0]])
    last = Scene.at_rest([[1, 2, -3.0]])
    middle = between(first, last, 0.5).pose[0]
    np.testing.assert_allclose(middle, [0.5, 1.0, np.pi], atol=1e-12)


def glimpses(steps: int, robots: int = 3, workers: int = 1, **settings: Any) -> list[Estimates]:
    """What a ring of robots believes while everybody turns on the spot."""
    watching = sensor(robots, workers, rig="ring-4", **settings)
    world = World(ARENA, ROBOT, Scene.at_rest(CIRCLE[:robots]))
    turn, out = Commands(np.zeros(robots), np.ones(robots)), []
    for _ in range(steps):
        out.append(watching.sense(world.scene))
        world.step(turn, 0.1, 4)
    return out


def test_a_dead_robot_sees_nobody_and_shifts_nothing_of_others() -> None:
    clean, broken = glimpses(4), glimpses(4, faults={"dead": [1, 77]})
    for one, other in zip(clean, broken, strict=True):
        assert not other.seen[1].any()
        for robot in (0, 2):
            assert same(sorted_by_bearing(one, robot), sorted_by_bearing(other, robot))


def test_a_stuck_camera_goes_on_showing_its_first_picture() -> None:
    scene = Scene.at_rest(CIRCLE)
    stuck = sensor(5, keep=True, rig="single", faults={"stuck": [2]})
    well = sensor(5, keep=True, rig="single")
    world = World(ARENA, ROBOT, scene)
    for step in range(3):
        for one in (stuck, well):
            one.sense(world.scene)
        if step == 0:
            first = stuck.pictures[2]
        world.step(Commands(np.zeros(5), np.ones(5)), 0.1, 4)
    np.testing.assert_array_equal(stuck.pictures[2].image, first.image)
    np.testing.assert_array_equal(stuck.pictures[2].pose, first.pose)
    assert not np.array_equal(well.pictures[2].image, first.image)
    np.testing.assert_array_equal(stuck.pictures[0].image, well.pictures[0].image)


@pytest.mark.parametrize("workers", [2, 3])
def test_faults_losses_and_lateness_are_the_same_for_any_number_of_workers(workers: int) -> None:
    faults = {"dead": [0], "stuck": [1]}
    spoiled = {"dropped": 0.3, "late": 0.3, "lateness": 0.15}
    runs = [glimpses(5, 4, workers=w, faults=faults, imperfections=spoiled) for w in (1, workers)]
    assert all(same(one, two) for one, two in zip(*runs, strict=True))


def test_a_lost_picture_is_coasted_over_and_all_lost_is_blindness() -> None:
    assert not any(e.seen.any() for e in glimpses(3, imperfections={"dropped": 1.0}))
    some = glimpses(12, imperfections={"dropped": 0.4, "late": 0.0})
    ages = np.concatenate([e.age[e.seen] for e in some])
    assert (ages == 0.0).any()
    assert ((ages > 0.05) & (ages < 1.0)).any()


def test_a_camera_that_is_set_up_late_reads_no_pictures_of_the_past() -> None:
    watching = sensor(5, keep=True)
    scene = Scene.at_rest(CIRCLE)
    late = Scene(**{f.name: getattr(scene, f.name) for f in fields(Scene)} | {"time": 3.7})
    assert watching.sense(late).seen.any()
    assert len(watching.pictures) == 35


HARD = {
    "faults": {"dead": [0], "stuck": [2]},
    "imperfections": {"dropped": 0.2, "late": 0.3, "lateness": 0.15},
}


SWEEPING = {"rig": {"servo": {}}, "rate_hz": 20}
FAST = {"rate_hz": 40}  # most pictures are looked at only where neighbours should be


@pytest.mark.parametrize("settings", [{}, SWEEPING, HARD, FAST], ids=["ring", "pan", "hard", "fast"])
def test_one_kernel_and_one_by_one_say_the_same(settings: dict[str, Any]) -> None:
    by_kernel, by_hand = sensor(5, **settings), sensor(5, keep=True, **settings)
    world = World(ARENA, ROBOT, Scene.at_rest(CIRCLE))
    for _ in range(4):
        assert same(by_kernel.sense(world.scene), by_hand.sense(world.scene))
        world.step(Commands(np.full(5, 0.05), np.ones(5)), 0.1, 4)
    assert by_kernel.pictures == ()


@pytest.mark.parametrize("change", [{"jpeg_quality": 80}, {"bayer": True}, {"defocus": 0.0}])
def test_every_fault_goes_its_way(change: dict[str, Any]) -> None:
    estimates = sensor(5, imperfections={"dropped": 0, "late": 0, **change}).sense(Scene.at_rest(CIRCLE))
    assert estimates.count.min() >= 3


def test_nobody_beyond_sight_is_drawn() -> None:
    far = Scene.at_rest([[0, 0, 0], [3.0, 0.2, 0]])
    alone = sensor(1, keep=True, rig="single")
    drawn, hidden = (sensor(2, keep=True, rig="single", sight=sight) for sight in (4.0, 2.0))
    for one, scene in ((alone, Scene.at_rest([[0, 0, 0]])), (drawn, far), (hidden, far)):
        one.sense(scene)
    assert not np.array_equal(drawn.pictures[0].image, alone.pictures[0].image)
    np.testing.assert_array_equal(hidden.pictures[0].image, alone.pictures[0].image)


def test_a_turning_robot_trusts_its_bearings_less() -> None:
    def spread(turn: float) -> float:
        watching = sensor(2, rig="single", rate_hz=10)
        world = World(ARENA, ROBOT, Scene.at_rest([[0, 0, 0], [0.4, 0, 1.0]]))
        for _ in range(2):
            estimates = watching.sense(world.scene)
            world.step(Commands(np.zeros(2), np.array([turn, 0.0])), 0.1, 12)
        assert estimates.age[0, 0] == 0.0
        return float(estimates.covariance[0, 0, 1, 1])

    still, left, right = spread(0.0), spread(1.5), spread(-1.5)
    assert min(left, right) > 2.0 * still
