"""The arena's physics: closed forms where there are any, and what must never happen."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pymunk
import pytest

from swarmvision import bodies
from swarmvision.bodies import BatchedBodies, LoopedBodies
from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.scenario import ScenarioConfig, StartConfig
from swarmvision.data import Commands, Scene
from swarmvision.drive import Drive, run_tracks
from swarmvision.errors import ConfigError, PhysicsError
from swarmvision.ground import GRAVITY, traction
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


def pulled(poses: np.ndarray, commands: list[Commands], substeps: int) -> np.ndarray:
    """The same robots without contacts, pulled by a callback inside pymunk's own velocity step."""
    drive, h = Drive.from_config(ROBOT), 0.1 / substeps
    space, twists = pymunk.Space(), np.zeros((len(poses), 2))
    lever = math.hypot(ROBOT.length, ROBOT.width) / 3.0

    def pull(index: int) -> Callable[[pymunk.Body, tuple[float, float], float, float], None]:
        def change(body: pymunk.Body, gravity: tuple[float, float], damping: float, dt: float) -> None:
            grip = ROBOT.traction * GRAVITY * dt
            speed, turn_rate = twists[index]
            x = speed * math.cos(body.angle) - body.velocity.x
            y = speed * math.sin(body.angle) - body.velocity.y
            share = min(1.0, grip / max(math.hypot(x, y), 1e-12))
            body.velocity = (body.velocity.x + share * x, body.velocity.y + share * y)
            limit = grip * body.mass * lever / body.moment
            body.angular_velocity += max(-limit, min(limit, turn_rate - body.angular_velocity))

        return change

    robots = []
    for index, (x, y, yaw) in enumerate(poses):
        body = pymunk.Body(ROBOT.mass, pymunk.moment_for_box(ROBOT.mass, (ROBOT.length, ROBOT.width)))
        body.position, body.angle, body.velocity_func = (x, y), yaw, pull(index)
        space.add(body)
        robots.append(body)
    wheels = np.zeros((len(poses), 2))
    for command in commands:
        wanted = drive.saturate(drive.wheel_speeds(command.speed, command.turn_rate))
        for _ in range(substeps):
            wheels = drive.lag(wheels, wanted, h)
            twists[:] = np.stack(drive.twist(wheels), axis=-1)
            space.step(h)
    return np.array([(*body.position, body.angle) for body in robots])


def test_forces_before_a_substep_do_what_a_callback_inside_it_does() -> None:
    rng = np.random.default_rng(3)
    poses = np.column_stack([np.linspace(-6, 6, 5), np.zeros(5), rng.uniform(-3, 3, 5)])
    commands = [Commands(rng.uniform(-0.4, 0.4, 5), rng.uniform(-4, 4, 5)) for _ in range(40)]
    free = World(ArenaConfig(), ROBOT, Scene.at_rest(poses))
    for command in commands:
        scene = free.step(command, 0.1, 12)
    inside = pulled(poses, commands, 12)
    assert np.abs(inside[:, :2] - poses[:, :2]).max() > 0.1
    np.testing.assert_allclose(scene.pose[:, :2], inside[:, :2], atol=1e-12)
    np.testing.assert_allclose(np.exp(1j * scene.pose[:, 2]), np.exp(1j * inside[:, 2]), atol=1e-12)


def test_batched_and_looped_access_are_the_same_world(monkeypatch: pytest.MonkeyPatch) -> None:
    arena = ArenaConfig(
        width=1.0,
        depth=1.0,
        objects=(BoxConfig(x=0.3, y=0, mass=0.1, length=0.1), DiscConfig(x=0, y=0.3, radius=0.05)),
    )
    start = Scene.at_rest([[-0.2, 0, 0], [0, 0, 0], [0, -0.3, 1]], [[0.3, 0, 0], [0, 0.3, 0]])
    batched = World(arena, ROBOT, start)
    assert isinstance(batched._bodies, BatchedBodies)
    with monkeypatch.context() as patch:
        patch.setattr(bodies, "batch", None)
        looped = World(arena, ROBOT, start)
    assert isinstance(looped._bodies, LoopedBodies)
    for turn in np.linspace(-3, 3, 40):
        commands = Commands(np.full(3, 0.3), np.array([0.0, turn, -turn]))
        one, two = batched.step(commands, 0.1, 12), looped.step(commands, 0.1, 12)
        np.testing.assert_array_equal(one.pose, two.pose)
        np.testing.assert_array_equal(one.object_pose, two.object_pose)
        assert (batched.robot_contacts, batched.obstacle_contacts) == (
            looped.robot_contacts,
            looped.obstacle_contacts,
        )
    assert batched.robot_contacts >= 1
    assert batched.obstacle_contacts >= 1


def test_a_contact_that_lasts_counts_once() -> None:
    pushed, _ = driven([[-0.2, 0, 0], [0, 0, 0]], go(0.2, 0.0), 3.0)
    assert pushed.robot_contacts == 1


def test_traction_is_the_same_uncompiled() -> None:
    plain = getattr(traction, "py_func", traction)
    rng = np.random.default_rng(0)
    state, (ahead, turning) = rng.normal(size=(6, 6)), rng.normal(size=(2, 5))
    grips = np.abs(rng.normal(size=(5, 4)))
    one, two = np.ones((6, 3)), np.ones((6, 3))
    traction(state, ahead, turning, grips, 0.01, 0.01, one)
    plain(state, ahead, turning, grips, 0.01, 0.01, two)
    np.testing.assert_allclose(one, two, rtol=1e-13)
    np.testing.assert_array_equal(one[5], 1.0)  # who has no tracks is not pulled


@pytest.mark.parametrize("lag", [0.0, 0.06])
def test_tracks_run_as_the_drive_says(lag: float) -> None:
    drive, h, rng = Drive.from_config(ROBOT.replace(motor_time_constant=lag)), 0.01, np.random.default_rng(1)
    speed, turn_rate, before = rng.uniform(-1, 1, 7), rng.uniform(-20, 20, 7), rng.uniform(-0.4, 0.4, (7, 2))
    wheels, travel = before.T.copy(), np.zeros((2, 7))
    ahead, turning = np.zeros((2, 3, 7))
    limits = (drive.track, drive.max_wheel_speed, drive.turn_slip)
    assert run_tracks(speed, turn_rate, limits, drive.kept(h, 3), h, wheels, travel, ahead, turning) == 0
    wanted = drive.saturate(drive.wheel_speeds(speed, turn_rate))
    after = drive.lag(before, wanted, h * np.arange(1, 4)[:, None, None])  # (3, 7, 2)
    np.testing.assert_allclose(wheels.T, after[-1], atol=1e-15)
    np.testing.assert_allclose(np.stack([ahead, turning]), np.stack(drive.twist(after)), atol=1e-14)
    trapezoid = h * (before / 2 + after[0] + after[1] + after[2] / 2)
    np.testing.assert_allclose(travel.T, trapezoid, atol=1e-15)
