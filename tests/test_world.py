"""The arena's physics: closed forms where there are any, and what must never happen."""

from __future__ import annotations

import numpy as np
import pytest

from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.scenario import ScenarioConfig, StartConfig
from swarmvision.data import Commands, Scene
from swarmvision.errors import ConfigError, PhysicsError
from swarmvision.placement import starting_scene
from swarmvision.world import World

ROBOT = RobotConfig()
ARENA = ArenaConfig(width=2.0, depth=2.0)


def driven(
    poses: object, commands: Commands, seconds: float, arena: ArenaConfig = ARENA
) -> tuple[World, Scene]:
    objects = [(thing.x, thing.y, 0.0) for thing in arena.objects]
    world = World(arena, ROBOT, Scene.at_rest(poses, objects))
    scene = world.scene
    for _ in range(round(seconds * 10)):
        scene = world.step(commands, 0.1, 12)
    return world, scene


def go(*speed: float) -> Commands:
    return Commands(np.array(speed), np.zeros(len(speed)))


def test_a_straight_drive_is_as_long_as_speed_and_lag_say() -> None:
    _, scene = driven([[-0.5, 0, 0]], go(0.2), 2.0)
    # A first-order lag costs speed * time constant of way: 0.2 * (2 - 0.06) = 0.388 m.
    assert scene.pose[0, 0] + 0.5 == pytest.approx(0.388, abs=0.003)
    assert scene.wheel_travel[0] == pytest.approx(0.388, abs=0.001)


def test_a_turn_on_the_spot_turns_as_commanded() -> None:
    _, scene = driven([[0, 0, 0]], Commands(np.zeros(1), np.array([1.0])), 1.0)
    assert scene.pose[0, 2] == pytest.approx(0.94, abs=0.01)
    np.testing.assert_allclose(scene.pose[0, :2], 0, atol=1e-6)


def test_walls_stop_robots_at_full_speed() -> None:
    world, scene = driven([[0.5, 0, 0]], go(5.0), 4.0)
    assert scene.pose[0, 0] == pytest.approx(1.0 - ROBOT.length / 2, abs=0.005)
    assert world.obstacle_contacts >= 1


def test_robots_head_on_do_not_pass_through_each_other() -> None:
    world, scene = driven([[-0.3, 0, 0], [0.3, 0, np.pi]], go(0.3, 0.3), 3.0)
    gap = np.hypot(*(scene.pose[0, :2] - scene.pose[1, :2]))
    assert gap > ROBOT.length - 0.002
    assert world.robot_contacts >= 1


def test_a_light_box_is_pushed_and_a_heavy_or_fixed_one_is_not() -> None:
    for mass, moves in ((0.05, True), (50.0, False), (None, False)):
        arena = ARENA.replace(objects=(BoxConfig(x=0.3, y=0, length=0.1, width=0.1, mass=mass),))
        _, scene = driven([[0, 0, 0]], go(0.2), 2.0, arena)
        assert (scene.object_pose[0, 0] > 0.32) == moves


def test_a_pushed_disc_comes_to_rest() -> None:
    arena = ARENA.replace(objects=(DiscConfig(x=0, y=0, radius=0.05, mass=0.2),))
    start = Scene.at_rest(np.zeros((0, 3)), [[0, 0, 0]])
    moving = Scene(
        time=0.0,
        pose=start.pose,
        velocity=start.velocity,
        wheel_speed=start.wheel_speed,
        wheel_travel=start.wheel_travel,
        object_pose=start.object_pose,
        object_velocity=np.array([[0.5, 0, 2.0]]),
    )
    world = World(arena, ROBOT, moving)
    for _ in range(20):
        scene = world.step(Commands.stop((0,)), 0.1, 12)
    # v^2 / (2 mu g) = 0.25 / (2 * 0.5 * 9.81) = 25.5 mm
    assert scene.object_pose[0, 0] == pytest.approx(0.0255, abs=0.003)
    np.testing.assert_allclose(scene.object_velocity, 0)


def test_a_mirrored_world_moves_mirrored() -> None:
    turn = Commands(np.array([0.2]), np.array([0.8]))
    back = Commands(np.array([0.2]), np.array([-0.8]))
    one, two = driven([[0, 0, 0.3]], turn, 2.0)[1], driven([[0, 0, -0.3]], back, 2.0)[1]
    np.testing.assert_allclose(one.pose, two.pose * [1, -1, -1], atol=1e-9)


def test_a_world_rebuilt_from_its_scene_goes_on_alike() -> None:
    world, scene = driven([[0, 0, 0], [0.5, 0.3, 2]], go(0.2, 0.1), 1.0)
    again = World(ARENA, ROBOT, scene)
    for _ in range(5):
        one, two = world.step(go(0.1, 0.2), 0.1, 12), again.step(go(0.1, 0.2), 0.1, 12)
    np.testing.assert_allclose(one.pose, two.pose, atol=1e-12)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_nothing_that_is_not_finite_gets_in(value: float) -> None:
    world = World(ARENA, ROBOT, Scene.at_rest([[0, 0, 0], [0.5, 0, 0]]))
    with pytest.raises(PhysicsError, match=r"command.turn_rate of robot 1 must be finite, got (nan|inf)"):
        world.step(Commands(np.zeros(2), np.array([0, value])), 0.1, 4)


@pytest.mark.parametrize("robots", [0, 1, 8, 60])
def test_robots_start_apart_inside_and_at_random(robots: int) -> None:
    scenario = ScenarioConfig(robots=robots, arena=ARENA)
    one = starting_scene(scenario, np.random.default_rng(1)).pose
    two = starting_scene(scenario, np.random.default_rng(2)).pose
    assert one.shape == (robots, 3)
    assert (np.abs(one[:, :2]) < 1.0 - ROBOT.length / 2).all()
    gaps = np.hypot(*np.moveaxis(one[:, None, :2] - one[None, :, :2], -1, 0))[~np.eye(robots, dtype=bool)]
    assert (gaps >= 0.16 - 1e-9).all()
    assert robots == 0 or not np.array_equal(one, two)


def test_too_many_robots_are_refused_with_how_many_fit() -> None:
    scenario = ScenarioConfig(robots=50, arena=ARENA, start=StartConfig(radius=0.3))
    with pytest.raises(ConfigError, match=r"50 robots do not fit the starting circle of 0.3 m.*about \d+ do"):
        starting_scene(scenario, np.random.default_rng(0))
