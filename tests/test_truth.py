"""Perfect sensing: line of sight, reach, field of view, and the mirror law."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sight_oracle import visible_fraction

from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import TruthSensorConfig
from swarmvision.data import Scene
from swarmvision.geometry import compose, inverse, polar
from swarmvision.sensing import sight
from swarmvision.sensing.abreast import look_abreast
from swarmvision.sensing.in_turn import look_in_turn
from swarmvision.sensing.sight import View
from swarmvision.sensing.truth import TruthSensor

ROBOT = RobotConfig()


def sensor(arena: ArenaConfig | None = None, **settings: object) -> TruthSensor:
    return TruthSensor(TruthSensorConfig.model_validate(settings), ROBOT, arena or ArenaConfig())


def test_tells_range_bearing_and_heading_of_a_neighbour() -> None:
    # The neighbour is 0.3 m to my left (I look north), and looks west: 90 deg left of me.
    estimates = sensor().sense(Scene.at_rest([[0, 0, np.pi / 2], [-0.3, 0, np.pi]]))
    assert estimates.seen[0, 0]
    assert estimates.range[0, 0] == pytest.approx(0.3)
    assert estimates.bearing[0, 0] == pytest.approx(np.pi / 2)
    assert estimates.heading[0, 0] == pytest.approx(np.pi / 2)
    assert estimates.track[:, 0].tolist() == [1, 0]


@pytest.mark.parametrize("robots", [0, 1])
def test_nobody_is_seen_by_nobody_or_by_one(robots: int) -> None:
    estimates = sensor().sense(Scene.at_rest(np.zeros((robots, 3))))
    assert estimates.seen.shape == (robots, 0)


def test_a_marker_hides_the_one_behind_it_and_not_the_one_beside_it() -> None:
    poses = [[0, 0, 0], [0.3, 0, 0], [0.8, 0, 0], [0.8, 0.4, 0]]
    seen = sensor().sense(Scene.at_rest(poses)).seen
    assert seen[0].tolist() == [True, False, True]
    assert sensor(occlusion=False).sense(Scene.at_rest(poses)).seen.all()


def test_half_hidden_is_half_visible() -> None:
    # A marker of half angle asin(.02/.8) whose middle lies on the edge of a nearer marker's shadow.
    edge = np.arcsin(0.02 / 0.3)
    estimates = sensor().sense(
        Scene.at_rest([[0, 0, 0], [0.3, 0, 0], [0.8 * np.cos(edge), 0.8 * np.sin(edge), 0]])
    )
    assert estimates.visible[0, 1] == pytest.approx(0.5, abs=0.11)


@pytest.mark.parametrize(
    ("thing", "hides"),
    [
        (BoxConfig(x=0.4, y=0, length=0.1, width=0.1, height=0.3), True),
        (BoxConfig(x=0.4, y=0.2, length=0.1, width=0.1, height=0.3), False),
        (BoxConfig(x=0.4, y=0, yaw_deg=45, length=0.1, width=0.1, height=0.04), False),
        (DiscConfig(x=0.4, y=0.05, radius=0.1, height=0.3), True),
        (DiscConfig(x=1.2, y=0, radius=0.1, height=0.3), False),
        (DiscConfig(x=-0.4, y=0, radius=0.1, height=0.3), False),
    ],
)
def test_objects_hide_what_stands_behind_them(thing: BoxConfig | DiscConfig, hides: bool) -> None:
    pose = [[thing.x, thing.y, np.radians(thing.yaw_deg)]]
    scene = Scene.at_rest([[0, 0, 0], [0.9, 0, 0]], pose)
    assert sensor(ArenaConfig(objects=(thing,))).sense(scene).seen[0, 0] != hides


def test_reach_and_field_of_view_are_limits() -> None:
    scene = Scene.at_rest([[0, 0, 0], [1.0, 0, 0], [0, 0.5, 0]])
    assert sensor(reach=0.7).sense(scene).seen[0].tolist() == [False, True]
    assert sensor(fov_deg=90).sense(scene).seen[0].tolist() == [True, False]


def test_a_mirrored_scene_gives_mirrored_estimates() -> None:
    pose = np.random.default_rng(1).uniform([-1, -1, -3], [1, 1, 3], (7, 3))
    here = sensor().sense(Scene.at_rest(pose))
    there = sensor().sense(Scene.at_rest(pose * [1, -1, -1]))
    np.testing.assert_array_equal(here.seen, there.seen)
    np.testing.assert_allclose(here.range, there.range)
    np.testing.assert_allclose(here.bearing, -there.bearing)
    np.testing.assert_allclose(here.heading, -there.heading)


THINGS = ArenaConfig(
    objects=(
        BoxConfig(x=0.4, y=0.2, yaw_deg=30, length=0.3, width=0.1, height=0.3),
        DiscConfig(x=-0.5, y=0.3, radius=0.1, height=0.2),
        BoxConfig(x=-0.4, y=-0.5, height=0.04),
    )
)


def crowd(seed: int, robots: int, half: float) -> Scene:
    pose = np.random.default_rng(seed).uniform([-half, -half, -np.pi], [half, half, np.pi], (robots, 3))
    return Scene.at_rest(pose, [[t.x, t.y, np.radians(t.yaw_deg)] for t in THINGS.objects])


@pytest.mark.parametrize(("seed", "robots", "half"), [(0, 2, 0.2), (1, 12, 0.5), (2, 40, 1.5), (3, 90, 6.0)])
def test_the_kernel_sees_what_a_plain_computation_sees(seed: int, robots: int, half: float) -> None:
    scene = crowd(seed, robots, half)
    estimates = sensor(THINGS, reach=1.7).sense(scene)
    distance, bearing, heading = polar(compose(inverse(scene.pose)[:, None], scene.pose[None]))
    visible = visible_fraction(scene, ROBOT, THINGS)
    others = ~np.eye(robots, dtype=bool)
    seen = (visible[others] >= sight.ENOUGH) & (distance[others] <= 1.7)
    np.testing.assert_array_equal(estimates.seen.ravel(), seen)
    for got, truth in (
        (estimates.range, distance),
        (estimates.bearing, bearing),
        (estimates.heading, heading),
        (estimates.visible, visible),
    ):
        np.testing.assert_allclose(got.ravel()[seen], truth[others][seen], atol=1e-12)


def test_limited_slots_hold_the_nearest_first_and_the_rest_is_empty() -> None:
    scene = crowd(4, 30, 0.8)
    everybody, few = sensor(THINGS).sense(scene), sensor(THINGS, neighbours=5).sense(scene)
    assert few.seen.shape == (30, 5)
    ordered = np.sort(np.where(everybody.seen, everybody.range, np.inf), axis=1)[:, :5]
    np.testing.assert_array_equal(np.where(few.seen, few.range, np.inf), ordered)
    wide = sensor(THINGS, neighbours=50).sense(scene)
    assert wide.seen.shape == (30, 50)
    assert wide.seen.sum() == everybody.seen.sum()


def test_the_order_of_the_robots_does_not_matter() -> None:
    scene = crowd(5, 20, 0.8)
    here = sensor(THINGS, neighbours=19).sense(scene)
    back = sensor(THINGS, neighbours=19).sense(Scene.at_rest(scene.pose[::-1], scene.object_pose))
    np.testing.assert_array_equal(here.range, back.range[::-1])
    np.testing.assert_array_equal(here.track[here.seen], 19 - back.track[::-1][here.seen])


def plain(kernel: Any) -> Any:
    return getattr(kernel, "py_func", kernel)


def looked(look: Any, scenes: list[Scene], view: View, slots: int) -> tuple[Any, Any]:
    pose = np.array([scene.pose for scene in scenes])
    objects = np.array([scene.object_pose for scene in scenes])
    n = pose.shape[0] * pose.shape[1] * slots
    who, seen = np.empty(n, np.int64), np.empty((4, n))
    limits = (view.reach, view.limit, view.radius, view.occlusion, view.ahead, 0.3)
    look(pose, objects, limits, view.things, slots, who, seen)
    return who.reshape(len(pose), -1, slots), seen


@pytest.mark.parametrize("fov", [360.0, 100.0])
@pytest.mark.parametrize("ahead", [0.0, 0.04])
def test_abreast_and_in_turn_see_alike(fov: float, ahead: float) -> None:
    scenes = [crowd(seed, 11, 0.5) for seed in range(70)]  # more worlds than are taken at once
    view = replace(sight.View.of(ROBOT, THINGS, 0.8, np.radians(fov)), ahead=ahead)
    for slots in (1, 4, 10, 12):
        one, two = looked(look_abreast, scenes, view, slots), looked(look_in_turn, scenes, view, slots)
        np.testing.assert_array_equal(one[0], two[0])
        np.testing.assert_allclose(one[1], two[1], atol=1e-12)


def test_a_world_is_seen_alike_in_any_company() -> None:
    scenes = [crowd(seed, 8, 0.4) for seed in range(67)]
    view = sight.View.of(ROBOT, THINGS, 2.0, 2 * np.pi)
    together = looked(look_abreast, scenes, view, 7)
    alone = looked(look_abreast, scenes[66:], view, 7)
    np.testing.assert_array_equal(together[0][66:], alone[0])
    np.testing.assert_array_equal(together[1].reshape(4, 67, -1)[:, 66], alone[1])


def test_of_equally_near_neighbours_the_lower_number_comes_first() -> None:
    poses = np.array([[0, 0, 0], [0, 0.5, 0], [0, -0.5, 0], [0.5, 0, 0], [-0.5, 0, 0]], float)
    view = sight.View.of(ROBOT, ArenaConfig(), 2.0, 2 * np.pi)
    for look in (look_abreast, look_in_turn):
        assert looked(look, [Scene.at_rest(poses)], view, 4)[0][0, 0].tolist() == [1, 2, 3, 4]


@pytest.mark.parametrize("look", [look_abreast, look_in_turn])
def test_the_same_lines_run_uncompiled(look: Any) -> None:
    view = sight.View.of(ROBOT, THINGS, 2.0, 2 * np.pi)
    one, two = (looked(way, [crowd(6, 5, 0.3)], view, 4) for way in (look, plain(look)))
    np.testing.assert_array_equal(one[0], two[0])
    np.testing.assert_allclose(one[1], two[1], atol=1e-12)
