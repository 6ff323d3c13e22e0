"""Aggregation: bring everybody together.

Reward after M. Huttenrauch, A. Sosic, G. Neumann, "Deep Reinforcement Learning for Swarm Systems",
Journal of Machine Learning Research 20, 2019: the mean of all distances, cut off, shared by all.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from pettingzoo.utils.conversions import parallel_to_aec

from swarmvision.data import Scene
from swarmvision.envs.swarm import Rewarded, SwarmEnv, task_scenario
from swarmvision.geometry import FloatArray

CUT_OFF = 1.2  # m: distances beyond count as this
EFFORT_WEIGHT = 0.001


class AggregationEnv(SwarmEnv):
    """Reward: less the mean distance of all pairs, less effort."""

    metadata: ClassVar[dict[str, Any]] = {**SwarmEnv.metadata, "name": "aggregation_v0"}

    def reward(
        self, scene: Scene, change: FloatArray, contacts: int
    ) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Return each robot's reward and its parts, from the truth."""
        return reward_of(scene.pose, scene.velocity, change, contacts)


def reward_of(pose: FloatArray, velocity: FloatArray, change: FloatArray, contacts: Any) -> Rewarded:
    """Return each robot's reward and its parts, ``(..., r)``, as :data:`swarmvision.envs.swarm.Reward`."""
    r = pose.shape[-2]
    offset = pose[..., None, :, :2] - pose[..., :, None, :2]
    distance = np.minimum(np.hypot(offset[..., 0], offset[..., 1]), CUT_OFF) / CUT_OFF
    effort = np.square(change).sum(axis=-1)
    mean = distance.sum(axis=(-2, -1)) / max(r * (r - 1), 1)
    parts = {"spread": np.broadcast_to(mean[..., None], effort.shape), "effort": effort}
    return -parts["spread"] - EFFORT_WEIGHT * effort, parts


def parallel_env(
    *,
    robots: int = 8,
    sensor: str = "truth",
    max_cycles: int = 600,
    render_mode: str | None = None,
    overrides: tuple[str, ...] = (),
) -> AggregationEnv:
    """Return the environment; ``sensor`` is truth, error_model or camera; ``overrides`` as for ``--set``."""
    scenario = task_scenario("aggregation", robots, sensor, overrides)
    return AggregationEnv(scenario, max_cycles=max_cycles, render_mode=render_mode)


def env(**settings: Any) -> Any:
    """Return the environment in PettingZoo's turn-by-turn form."""
    return parallel_to_aec(parallel_env(**settings))


raw_env = env
