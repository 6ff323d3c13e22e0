"""The environments keep PettingZoo's contract and ours: one seed, the same bytes."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from typing import Any

import numpy as np
import pettingzoo
import pytest
from pettingzoo.test import api_test, parallel_api_test

from swarmvision.envs import aggregation_v0, flocking_v0
from swarmvision.envs.vector import VectorEnv
from swarmvision.errors import ConfigError
from swarmvision.simulation import Simulation

TASKS = {"flocking": flocking_v0, "aggregation": aggregation_v0}
CAMERA = {"sensor": "camera", "robots": 2, "overrides": ('sensor.rig="single"', "start.radius=0.4")}


def digest(task: str, steps: int, **settings: Any) -> str:
    env = TASKS[task].parallel_env(max_cycles=steps, **settings)
    rng = np.random.default_rng(7)
    total = hashlib.sha256()
    observations, _ = env.reset(seed=11)
    while env.agents:
        for agent in env.agents:
            total.update(observations[agent].tobytes())
        actions = {agent: rng.uniform(-1, 1, 2).astype(np.float32) for agent in env.agents}
        observations, rewards, _, _, _ = env.step(actions)
        total.update(np.array(list(rewards.values())).tobytes())
    total.update(env.state().tobytes())
    return total.hexdigest()


@pytest.mark.parametrize("task", TASKS)
def test_keeps_the_parallel_contract(task: str) -> None:
    parallel_api_test(TASKS[task].parallel_env(robots=4), num_cycles=200)


@pytest.mark.parametrize("task", TASKS)
def test_keeps_the_turn_by_turn_contract(task: str) -> None:
    api_test(TASKS[task].env(robots=3, max_cycles=60), num_cycles=40)


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize(
    "settings", [{}, {"sensor": "error_model"}, CAMERA], ids=["truth", "error_model", "camera"]
)
def test_300_steps_of_one_seed_are_the_same_here_and_in_another_process(
    task: str, settings: dict[str, Any]
) -> None:
    here = digest(task, 300, **settings)
    assert digest(task, 300, **settings) == here
    code = f"from test_envs import *; print(digest({task!r}, 300, **{settings!r}))"
    there = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=__file__.rpartition("/")[0],
    )
    assert there.stdout.strip() == here


@pytest.mark.parametrize("task", TASKS)
def test_two_environments_side_by_side_do_not_disturb_each_other(task: str) -> None:
    one, two = TASKS[task].parallel_env(robots=3), TASKS[task].parallel_env(robots=3)
    first, _ = one.reset(seed=3)
    second, _ = two.reset(seed=3)
    for _ in range(20):
        for agent in one.agents:
            np.testing.assert_array_equal(first[agent], second[agent])
        actions = {agent: np.array([0.5, 0.3], dtype=np.float32) for agent in one.agents}
        first, *_ = one.step(actions)
        second, *_ = two.step(actions)


@pytest.mark.parametrize("task", TASKS)
def test_other_seeds_and_later_episodes_differ(task: str) -> None:
    env = TASKS[task].parallel_env(robots=3)
    starts = [env.reset(seed=seed)[0]["robot_0"] for seed in (1, 2, None)]
    assert not np.array_equal(starts[0], starts[1])
    assert not np.array_equal(starts[1], starts[2])
    np.testing.assert_array_equal(env.reset(seed=1)[0]["robot_0"], starts[0])


def test_all_are_truncated_together_and_observations_stay_in_their_space() -> None:
    env = flocking_v0.parallel_env(robots=3, max_cycles=5)
    env.reset(seed=0)
    for cycle in range(5):
        actions = {agent: env.action_space(agent).low for agent in env.agents}
        observations, _, terminations, truncations, infos = env.step(actions)
        assert not any(terminations.values())
        assert set(truncations.values()) == {cycle == 4}
        assert all(env.observation_space(a).contains(o) for a, o in observations.items())
        assert set(infos["robot_0"]) == {"alignment", "spacing", "contact", "effort"}
    assert env.agents == []


def test_a_flock_that_flies_together_is_rewarded_more_than_one_that_stands() -> None:
    def total(action: list[float]) -> float:
        env = flocking_v0.parallel_env(robots=4, overrides=("start.heading_spread_deg=5",))
        env.reset(seed=2)
        gain = 0.0
        for _ in range(20):
            _, rewards, *_ = env.step({agent: np.array(action) for agent in env.agents})
            gain += sum(rewards.values())
        return gain

    assert total([1.0, 0.0]) > total([-1.0, 0.0])


def test_is_known_by_its_registered_name_and_draws() -> None:
    env = pettingzoo.make("parallel", "swarmvision/flocking-v0", robots=2, render_mode="rgb_array")
    env.reset(seed=0)
    image = env.render()
    assert image.dtype == np.uint8
    assert image.ndim == 3
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 3
    env.close()


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("sensor", ["truth", "error_model"])
def test_many_worlds_show_and_reward_what_one_environment_does(task: str, sensor: str) -> None:
    # Far apart, so that nobody touches anybody: contacts are where the two differ.
    apart = ("start.radius=6", "start.spacing=2.5", "sensor.reach=4", "arena.width=16", "arena.depth=16")
    many = VectorEnv(task, 3, robots=3, sensor=sensor, overrides=(*apart, "physics_substeps=4"))
    shown = many.reset(seed=5)
    assert shown.shape == many.shape
    one = TASKS[task].parallel_env(robots=3, sensor=sensor, overrides=(*apart, "physics_substeps=4"))
    one.reset(seed=0)
    assert many._worlds is not None
    one._simulation = Simulation(one.scenario, int(many._worlds.seeds[1]))
    rows = one._observed(one._simulation.sense())
    rng = np.random.default_rng(3)
    for _ in range(20):
        np.testing.assert_allclose(shown[1], rows, atol=1e-6)
        actions = rng.uniform(-1, 1, (3, 3, 2)).astype(np.float32)
        shown, reward, over, _ = many.step(actions)
        observed, rewards, *_ = one.step({f"robot_{i}": actions[1, i] for i in range(3)})
        rows = np.array([observed[f"robot_{i}"] for i in range(3)])
        np.testing.assert_allclose(reward[1], list(rewards.values()), atol=1e-9)
        assert not over


def test_episodes_of_many_worlds_end_together_and_new_ones_have_begun() -> None:
    env = VectorEnv("flocking", 4, robots=2, max_cycles=3)
    first = env.reset(seed=1)
    steps = [env.step(np.zeros((4, 2, 2))) for _ in range(6)]
    assert [step.over for step in steps] == [False, False, True] * 2
    assert steps[2].last is not None
    assert not np.array_equal(steps[2].observation, first)
    np.testing.assert_array_equal(env.reset(seed=1), first)
    with pytest.raises(ConfigError, match=r"unknown task 'flokking'"):
        VectorEnv("flokking", 2)
