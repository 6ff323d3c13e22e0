"""Flocking: go the same way as those near you, keep your distance, touch nobody."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from pettingzoo.utils.conversions import parallel_to_aec

from swarmvision.data import Scene
from swarmvision.envs.observation import TOP_SPEED
from swarmvision.envs.swarm import Rewarded, SwarmEnv, task_scenario
from swarmvision.geometry import FloatArray

NEAR = 0.6  # m: whose heading counts
SPACING = 0.25  # m: wanted distance to neighbours
SPACING_WEIGHT, CONTACT_WEIGHT, EFFORT_WEIGHT = 0.5, 1.0, 0.01


class FlockingEnv(SwarmEnv):
    """Reward: alignment times speed, less bad spacing, contacts and jerky actions."""

    metadata: ClassVar[dict[str, Any]] = {**SwarmEnv.metadata, "name": "flocking_v0"}

    def reward(
        self, scene: Scene, change: FloatArray, contacts: int
    ) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Return each robot's reward and its parts, from the truth."""
        return reward_of(scene.pose, scene.velocity, change, contacts)


def reward_of(pose: FloatArray, velocity: FloatArray, change: FloatArray, contacts: Any) -> Rewarded:
    """Return each robot's reward and its parts, ``(..., r)``, as :data:`swarmvision.envs.swarm.Reward`."""
    r = pose.shape[-2]
    offset = pose[..., None, :, :2] - pose[..., :, None, :2]
    distance = np.hypot(offset[..., 0], offset[..., 1])
    near = (distance < NEAR) & ~np.eye(r, dtype=bool)
    number = near.sum(axis=-1)
    turned = np.cos(pose[..., None, :, 2] - pose[..., :, None, 2])
    alignment = np.where(near, turned, 0.0).sum(axis=-1) / np.maximum(number, 1)
    speed = np.hypot(velocity[..., 0], velocity[..., 1]) / TOP_SPEED
    off = np.clip(((distance - SPACING) / SPACING) ** 2, 0.0, 1.0)
    spacing = np.where(number > 0, np.where(near, off, 0.0).sum(axis=-1) / np.maximum(number, 1), 1.0)
    effort = np.square(change).sum(axis=-1)
    touched = np.broadcast_to(np.asarray(contacts)[..., None] / r, effort.shape)
    parts = {"alignment": alignment * speed, "spacing": spacing, "contact": touched, "effort": effort}
    total = parts["alignment"] - SPACING_WEIGHT * spacing - CONTACT_WEIGHT * touched - EFFORT_WEIGHT * effort
    return total, parts


def parallel_env(
    *,
    robots: int = 8,
    sensor: str = "truth",
    max_cycles: int = 600,
    render_mode: str | None = None,
    overrides: tuple[str, ...] = (),
) -> FlockingEnv:
    """Return the environment; ``sensor`` is truth, error_model or camera; ``overrides`` as for ``--set``."""
    scenario = task_scenario("flocking", robots, sensor, overrides)
    return FlockingEnv(scenario, max_cycles=max_cycles, render_mode=render_mode)


def env(**settings: Any) -> Any:
    """Return the environment in PettingZoo's turn-by-turn form."""
    return parallel_to_aec(parallel_env(**settings))


raw_env = env
