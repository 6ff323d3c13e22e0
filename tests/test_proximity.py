"""The ring of eight infrared sectors: exact wedges, walls and objects, noise of one's own."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.model import validated
from swarmvision.config.robot import RobotConfig
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.config.sensor import ProximityConfig
from swarmvision.data import SECTOR_BEARINGS, Estimates, Scene
from swarmvision.geometry import compose
from swarmvision.sensing.body import Body
from swarmvision.sensing.proximity import ProximityRing

ROBOT = RobotConfig(length=0.1, width=0.1)
EXACT = ProximityConfig(noise=0, levels=0)
AHEAD, LEFT, BEHIND = 0, 2, 4


def ring(arena: ArenaConfig | None = None, config: ProximityConfig = EXACT, seed: int = 0) -> ProximityRing:
    return ProximityRing(config, ROBOT, arena or ArenaConfig(), seed)


def crowd(seed: int, robots: int = 30) -> Scene:
    rng = np.random.default_rng(seed)
    return Scene.at_rest(
        rng.uniform([-0.7, -0.7, -3], [0.7, 0.7, 3], (robots, 3)), [[0.2, 0.1, 0.5], [-0.4, 0, 0]]
    )


THINGS = ArenaConfig(
    objects=(BoxConfig(x=0, y=0, length=0.2, width=0.1), DiscConfig(x=0, y=0, radius=0.1)),
    width=1.5,
    depth=1.5,
)


def test_reads_the_near_face_of_a_neighbour_ahead_and_nothing_elsewhere() -> None:
    # Axes 0.2 m apart, half a body of 0.05 m between: 0.15 m. Its corners stand at atan(.05/.15) = 18.4 deg.
    gap, is_robot = ring().sense(Scene.at_rest([[0, 0, 0], [0.2, 0, 0]]))
    assert gap[0, AHEAD] == pytest.approx(0.15)
    assert np.isinf(gap[0, 1:]).all()
    assert gap[1, BEHIND] == pytest.approx(0.15)
    assert is_robot[0].tolist() == [True] + 7 * [False]


def test_a_wall_is_near_in_three_sectors_and_no_robot() -> None:
    # 0.1 m from the wall ahead: the wedges beside begin at 22.5 deg, where it is 0.1/cos(22.5 deg) away.
    gap, is_robot = ring(ArenaConfig(width=2, depth=2)).sense(Scene.at_rest([[0.9, 0, 0]]))
    assert gap[0, AHEAD] == pytest.approx(0.1)
    np.testing.assert_allclose(gap[0, [1, 7]], 0.1 / np.cos(np.pi / 8))
    assert np.isinf(gap[0, 2:7]).all()
    assert not is_robot.any()


def test_a_disc_beside_a_wedge_is_met_on_its_border() -> None:
    # Centre 0.2 m ahead, radius 0.1: ahead 0.1. The border at 22.5 deg passes .2 sin = .0765 from the centre.
    arena = ArenaConfig(objects=(DiscConfig(x=0, y=0, radius=0.1),))
    gap, _ = ring(arena).sense(Scene.at_rest([[0, 0, 0]], [[0.2, 0, 0]]))
    beside = 0.2 * np.cos(np.pi / 8) - np.sqrt(0.01 - (0.2 * np.sin(np.pi / 8)) ** 2)
    np.testing.assert_allclose(gap[0, [0, 1, 7]], [0.1, beside, beside])
    assert np.isinf(gap[0, 2:7]).all()


def test_the_nearer_of_robot_and_box_is_told() -> None:
    arena = ArenaConfig(objects=(BoxConfig(x=0, y=0, length=0.02, width=0.02),))
    scene = Scene.at_rest([[0, 0, 0], [0.2, 0, 0]], [[0.1, 0, 0]])
    gap, is_robot = ring(arena).sense(scene)
    assert gap[0, AHEAD] == pytest.approx(0.09)
    assert not is_robot[0, AHEAD]


def test_agrees_with_points_sampled_on_every_outline() -> None:
    scene = crowd(3)
    gap, is_robot = ring(THINGS).measure(scene)
    share = np.linspace(0, 1, 2001)
    square = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]])
    around = np.concatenate([a + share[:, None] * (b - a) for a, b in pairwise(square)])
    circle = np.stack([np.cos(2 * np.pi * share), np.sin(2 * np.pi * share)], axis=1)
    outlines = [(pose, around * 0.05, True) for pose in scene.pose]
    outlines += [
        (scene.object_pose[0], around * [0.1, 0.05], False),
        (scene.object_pose[1], circle * 0.1, False),
    ]
    outlines += [(np.zeros(3), around * 0.75, False)]
    for me, pose in enumerate(scene.pose):
        nearest, robot = np.full(8, np.inf), np.zeros(8, bool)
        for n, (place, outline, body) in enumerate(outlines):
            if n == me:
                continue
            points = compose(place, np.pad(outline, ((0, 0), (0, 1))))[:, :2] - pose[:2]
            distance = np.hypot(*points.T)
            bearing = np.arctan2(points[:, 1], points[:, 0]) - pose[2]
            sector = np.round(bearing / (np.pi / 4)).astype(int) % 8
            for k in range(8):
                found = distance[sector == k].min(initial=np.inf)
                if found < nearest[k]:
                    nearest[k], robot[k] = found, body
        near = (nearest < 0.25) & (gap[me] < 0.25)
        # 2001 points a side are 0.8 mm apart on the wall, the longest line.
        np.testing.assert_allclose(gap[me, near], nearest[near], atol=1e-3)
        assert (nearest[~near] > 0.249).all()
        assert (is_robot[me] == (robot & (gap[me] < np.inf)))[near].all()


def test_a_mirrored_scene_gives_mirrored_sectors() -> None:
    mirrored = [int(np.argmin(np.abs(np.cos(SECTOR_BEARINGS + b) - 1))) for b in SECTOR_BEARINGS]
    here, there = crowd(5), crowd(5)
    there = replace(there, pose=here.pose * [1, -1, -1], object_pose=here.object_pose * [1, -1, -1])
    np.testing.assert_allclose(ring(THINGS).measure(here)[0], ring(THINGS).measure(there)[0][:, mirrored])


def test_a_turn_by_a_sector_moves_readings_by_one() -> None:
    one = crowd(6, robots=9)
    pose = one.pose.copy()
    pose[0, 2] += np.pi / 4
    turned, _ = ring(THINGS).measure(replace(one, pose=pose))
    np.testing.assert_allclose(turned[0], np.roll(ring(THINGS).measure(one)[0][0], -1))


def test_noise_has_its_size_and_levels_their_steps() -> None:
    scene = Scene.at_rest([[0, 0, 0], [0.2, 0, 0]])
    noisy = ring(config=ProximityConfig(noise=0.005, levels=0))
    readings = np.array([noisy.sense(scene)[0][0, AHEAD] for _ in range(1000)])
    # The standard deviation of 1000 readings is known to 1/sqrt(2000) = 2.2 %; four of that.
    assert readings.std() == pytest.approx(0.005, rel=0.09)
    assert readings.mean() == pytest.approx(0.15, abs=4 * 0.005 / np.sqrt(1000))
    # Seven steps of (0.25 - 0.05)/7 = 2.86 cm from the body: 0.15 m is in the fourth, whose middle is 0.15 m.
    stepped = ring(config=ProximityConfig(noise=0)).sense(scene)[0]
    assert stepped[0, AHEAD] == pytest.approx(0.05 + 3.5 * 0.2 / 7)


def test_one_seed_gives_one_noise_and_a_further_robot_shifts_nobody() -> None:
    scene = Scene.at_rest([[0, 0, 0], [0.2, 0, 0]])
    more = Scene.at_rest([[0, 0, 0], [0.2, 0, 0], [3, 3, 0]])
    config = ProximityConfig(levels=0)
    one, two, other = ring(config=config), ring(config=config), ring(config=config, seed=1)
    for _ in range(3):
        gap = one.sense(scene)[0]
        np.testing.assert_array_equal(gap, two.sense(more)[0][:2])
        assert gap[0, AHEAD] != other.sense(scene)[0][0, AHEAD]


@pytest.mark.parametrize("robots", [0, 1])
def test_nothing_is_near_nobody_or_one_in_an_open_arena(robots: int) -> None:
    gap, is_robot = ring(config=ProximityConfig()).sense(Scene.at_rest(np.zeros((robots, 3))))
    assert gap.shape == (robots, 8)
    assert np.isinf(gap).all()
    assert not is_robot.any()


def test_a_body_feels_its_ring() -> None:
    scene = Scene.at_rest([[0, 0, 0], [0.2, 0, 0]])
    values = {"robots": 2, "proximity": {"noise": 0.0, "levels": 0}}
    senses = Body(validated(ScenarioConfig, values, "test")).feel(scene, Estimates.empty((2, 0)))
    assert senses.proximity[0, AHEAD] == pytest.approx(0.2 - 0.049)
    assert senses.proximity_robot[0, AHEAD]
    without = Body(ScenarioConfig(robots=2)).feel(scene, Estimates.empty((2, 0)))
    assert np.isinf(without.proximity).all()
