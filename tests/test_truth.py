"""Perfect sensing: line of sight, reach, field of view, and the mirror law."""

from __future__ import annotations

import numpy as np
import pytest

from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import TruthSensorConfig
from swarmvision.data import Scene
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
