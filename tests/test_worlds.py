"""Many worlds at once: the same motion as one world's, each on its own, with contacts that hold."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.scenario import ScenarioConfig, StartConfig
from swarmvision.config.sensor import CameraSensorConfig, ErrorModelSensorConfig, TruthSensorConfig
from swarmvision.data import Commands, Scene
from swarmvision.errors import ConfigError, PhysicsError
from swarmvision.metrics import order
from swarmvision.simulation import Simulation
from swarmvision.world import World
from swarmvision.worlds import Worlds

TRUTH = TruthSensorConfig(neighbours=6)
ERRORS = ErrorModelSensorConfig(neighbours=6)
SPARSE = ScenarioConfig(robots=5, sensor=TRUTH, start=StartConfig(radius=5.0, spacing=2.0))
DENSE = ScenarioConfig(robots=8, sensor=TRUTH, arena=ArenaConfig(width=1.2, depth=1.2))


def wishes(seed: int, *shape: int) -> list[Commands]:
    rng = np.random.default_rng(seed)
    return [Commands(rng.uniform(0, 0.3, shape), rng.uniform(-2, 2, shape)) for _ in range(30)]


def placed(poses: object, arena: ArenaConfig) -> Worlds:
    """One world with robots where they are wanted."""
    pose = np.asarray(poses, dtype=float)
    scenario = ScenarioConfig(robots=len(pose), sensor=TRUTH, arena=arena)
    one = Worlds(scenario, 1)
    one._place(0, Scene.at_rest(pose, [(t.x, t.y, np.radians(t.yaw_deg)) for t in arena.objects]))
    return one


def test_without_contacts_worlds_move_as_pymunk_moves_them() -> None:
    many = Worlds(SPARSE, 3, seed=4, substeps=SPARSE.physics_substeps)
    alone = [World(SPARSE.arena, SPARSE.robot, many.scene(w)) for w in range(3)]
    for commands in wishes(0, 3, 5):
        many.act(commands)
        for w, world in enumerate(alone):
            world.step(Commands(commands.speed[w], commands.turn_rate[w]), 0.1, SPARSE.physics_substeps)
    assert many.contacts.sum() == 0
    for w, world in enumerate(alone):
        np.testing.assert_allclose(many.scene(w).pose, world.scene.pose, atol=1e-12)
        np.testing.assert_allclose(many.scene(w).velocity, world.scene.velocity, atol=1e-12)
        np.testing.assert_allclose(many.scene(w).wheel_travel, world.scene.wheel_travel, atol=1e-12)


def test_fewer_substeps_move_alike() -> None:
    fine, coarse = Worlds(SPARSE, 2, substeps=12), Worlds(SPARSE, 2)
    for commands in wishes(1, 2, 5):
        fine.act(commands)
        coarse.act(commands)
    # 3 s at up to 0.3 m/s are 0.5 m; traction's limit of 0.8 g acts within a substep of 25 ms.
    np.testing.assert_allclose(coarse.pose[..., :2], fine.pose[..., :2], atol=0.01)


@pytest.mark.parametrize("sensor", [TRUTH, ERRORS])
def test_a_world_is_what_a_simulation_of_its_seed_is(
    sensor: TruthSensorConfig | ErrorModelSensorConfig,
) -> None:
    scenario = SPARSE.replace(sensor=sensor, start=StartConfig(radius=1.2, spacing=0.5))
    many = Worlds(scenario, 2, seed=9, substeps=scenario.physics_substeps)
    simulation = Simulation(scenario, int(many.seeds[1]))
    for _ in range(15):
        estimates, frame = many.step(), simulation.step()
        mine = estimates.select(1)
        k = frame.estimates.seen.shape[1]
        np.testing.assert_array_equal(mine.seen[:, :k], frame.estimates.seen)
        np.testing.assert_allclose(mine.range[:, :k], frame.estimates.range, atol=1e-9)
        np.testing.assert_allclose(mine.heading[:, :k], frame.estimates.heading, atol=1e-9)
    np.testing.assert_allclose(many.pose[1], simulation.scene.pose, atol=1e-9)


@pytest.mark.parametrize("sensor", [TRUTH, ERRORS])
def test_a_world_does_not_depend_on_the_others(sensor: TruthSensorConfig | ErrorModelSensorConfig) -> None:
    scenario = DENSE.replace(sensor=sensor)
    few, many = Worlds(scenario, 2, seed=3), Worlds(scenario, 5, seed=3)
    for step in range(25):
        one, two = few.step(), many.step()
        np.testing.assert_array_equal(one.range, two.range[:2])
        if step == 10:
            few.reset(np.array([False, True]))
            many.reset(np.array([False, True, False, True, True]))
    np.testing.assert_array_equal(few.pose, many.pose[:2])
    np.testing.assert_array_equal(few.contacts, many.contacts[:2])


def test_a_new_episode_is_another_one_and_leaves_the_others_alone() -> None:
    many = Worlds(DENSE, 3, seed=1)
    for _ in range(5):
        many.step()
    before, seeds = many.pose, many.seeds.copy()
    many.reset(np.array([False, True, False]))
    np.testing.assert_array_equal(many.pose[[0, 2]], before[[0, 2]])
    assert many.time.tolist() == pytest.approx([0.5, 0.0, 0.5])
    assert many.seeds[1] != seeds[1]
    assert many.contacts[1] == 0
    assert not np.allclose(many.pose[1], Worlds(DENSE, 3, seed=1).pose[1])


def test_robots_stay_apart_and_inside() -> None:
    many = Worlds(DENSE, 6, seed=2)
    apart = ~np.eye(8, dtype=bool)
    for commands in wishes(5, 6, 8) * 3:
        many.act(commands)
        gaps = np.hypot(*np.moveaxis(many.pose[:, :, None, :2] - many.pose[:, None, :, :2], -1, 0))
        assert gaps[:, apart].min() > 0.098
        assert np.abs(many.pose[..., :2]).max() < 0.6 - 0.049 + 0.005
    assert many.robot_contacts.min() > 0
    assert many.obstacle_contacts.min() > 0


def test_a_wall_stops_a_robot_where_pymunk_stops_it() -> None:
    arena = ArenaConfig(width=2.0, depth=2.0)
    one = placed([[0.5, 0, 0.3]], arena)
    world = World(arena, one.scenario.robot, one.scene(0))
    for _ in range(40):
        one.act(Commands(np.full((1, 1), 0.3), np.zeros((1, 1))))
        world.step(Commands(np.full(1, 0.3), np.zeros(1)), 0.1, 12)
    assert one.pose[0, 0, 0] == pytest.approx(world.scene.pose[0, 0], abs=0.01)
    assert one.obstacle_contacts[0] >= 1


@pytest.mark.parametrize(("mass", "moves"), [(0.05, True), (50.0, False), (None, False)])
@pytest.mark.parametrize("kind", ["box", "disc"])
def test_a_light_thing_is_pushed_and_a_heavy_or_fixed_one_is_not(
    kind: str, mass: float | None, moves: bool
) -> None:
    thing = (
        BoxConfig(x=0.3, y=0, length=0.1, width=0.1, mass=mass)
        if kind == "box"
        else DiscConfig(x=0.3, y=0, radius=0.05, mass=mass)
    )
    one = placed([[0, 0, 0]], ArenaConfig(width=2.0, depth=2.0, objects=(thing,)))
    for _ in range(20):
        one.act(Commands(np.full((1, 1), 0.2), np.zeros((1, 1))))
    assert (one.scene(0).object_pose[0, 0] > 0.32) == moves
    assert one.obstacle_contacts[0] == 1


def test_a_mirrored_world_moves_mirrored() -> None:
    # Clear of the walls: a box's corners are solved in an order, which a mirror turns round.
    arena = ArenaConfig(width=9.0, depth=9.0, objects=(DiscConfig(x=0.3, y=0, radius=0.08),))
    poses = np.array([[-0.2, 0.02, 0.1], [0.05, 0.0, 3.0], [0.3, 0.25, -1.0]])
    here, there = placed(poses, arena), placed(poses * [1, -1, -1], arena)
    for commands in wishes(7, 1, 3):
        here.act(commands)
        there.act(Commands(commands.speed, -commands.turn_rate))
    assert here.contacts[0] > 0
    np.testing.assert_allclose(here.pose, there.pose * [1, -1, -1], atol=1e-6)


def test_many_worlds_flock() -> None:
    scenario = ScenarioConfig(robots=6, sensor=ERRORS, start=StartConfig(radius=0.5))
    many = Worlds(scenario, 8, seed=0)
    first = order(many.pose[..., 2]).mean()
    for _ in range(200):
        many.step()
    assert order(many.pose[..., 2]).mean() > max(0.9, first)


@pytest.mark.parametrize("robots", [0, 1])
def test_nobody_and_one_are_worlds_too(robots: int) -> None:
    for sensor in (TRUTH, ERRORS):
        many = Worlds(ScenarioConfig(robots=robots, sensor=sensor), 2)
        assert not many.step().seen.any()
        assert many.pose.shape == (2, robots, 3)


def test_what_many_worlds_do_not_have_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"many worlds sense by truth or error_model, not by camera"):
        Worlds(ScenarioConfig(sensor=CameraSensorConfig()), 2)
    for way in ({"latency": 0.1}, {"lost": 0.2}, {"memory": 1.0}, {"faults": {"dead": [0]}}):
        late = TruthSensorConfig.model_validate(way)
        with pytest.raises(ConfigError, match=r"do not have sensors that are late, lossy, broken"):
            Worlds(ScenarioConfig(sensor=late), 2)
    many = Worlds(SPARSE, 2)
    speed = np.zeros((2, 5))
    speed[1, 3] = np.nan
    with pytest.raises(PhysicsError, match=r"command of robot 3 in world 1 must be finite"):
        many.act(Commands(speed, np.zeros((2, 5))))


def trace(steps: int) -> str:
    """What happens in a small crowded world, to the last digit but three."""
    scenario = DENSE.replace(
        sensor=ERRORS,
        robots=5,
        arena=ArenaConfig(width=0.7, depth=0.7, objects=(BoxConfig(x=0, y=0, length=0.1),)),
    )
    many = Worlds(scenario, 1, seed=6)
    for _ in range(steps):
        estimates = many.sense()
        many.act(Commands(np.full((1, 5), 0.3), np.zeros((1, 5))))  # everybody straight on, into a wall
    numbers = np.concatenate([many.pose.ravel(), np.nan_to_num(estimates.range).ravel(), many.contacts])
    return " ".join(f"{number:.12g}" for number in numbers)


def test_the_same_lines_run_uncompiled() -> None:
    plain = subprocess.run(
        [sys.executable, "-c", "from test_worlds import trace; print(trace(12))"],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parent,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    here, there = trace(12).split(), plain.stdout.split()
    assert float(here[-1]) > 0
    np.testing.assert_allclose(np.array(here, float), np.array(there, float), rtol=1e-9, atol=1e-9)
