"""Couzin's three regimes with true sensing: swarm, torus, parallel group.

Points as in the paper, which pass through each other, driven by our law: sixteen bodies of a Zumo's size
on a circle of two metres run into each other, and then there is no torus.
"""

from __future__ import annotations

import numpy as np
import pytest

from swarmvision.config.arena import ArenaConfig
from swarmvision.config.controller.particles import COUZIN
from swarmvision.config.robot import RobotConfig
from swarmvision.controllers import controller
from swarmvision.data import Senses
from swarmvision.geometry import FloatArray, compose
from swarmvision.metrics import order
from swarmvision.sensing.sight import View
from swarmvision.sensing.truth import sight, truth_estimates

WORLDS, AGENTS, STEPS, DT = 4, 16, 900, 0.1


def last_third(regime: str) -> FloatArray:
    """Poses ``(steps, worlds, agents, 3)`` of agents that began at random within 0.8 m."""
    rng = np.random.default_rng(1)
    radius = 0.8 * np.sqrt(rng.random((WORLDS, AGENTS)))
    angle, yaw = rng.uniform(-np.pi, np.pi, (2, WORLDS, AGENTS))
    pose = np.stack([radius * np.cos(angle), radius * np.sin(angle), yaw], axis=-1)
    control = controller(COUZIN[regime])
    memory = control.begin(rng.integers(0, 2**63, (WORLDS, AGENTS), dtype=np.uint64))
    view = View.of(RobotConfig(), ArenaConfig(), 5.0, 2.0 * np.pi, occlusion=False)
    poses = []
    for _ in range(STEPS):
        estimates = truth_estimates(*sight(pose, np.zeros((WORLDS, 0, 3)), view, AGENTS - 1))
        commands, memory = control.step(Senses.of(estimates, DT), memory)
        way, turn = commands.speed * DT, commands.turn_rate * DT
        pose = compose(pose, np.stack([way, np.zeros_like(way), turn], axis=-1))
        poses.append(pose)
    return np.array(poses[2 * STEPS // 3 :])


def milling(pose: FloatArray) -> float:
    """Couzin's group angular momentum: 1 where all circle their centre the same way."""
    offset = pose[..., :2] - pose[..., :2].mean(axis=-2, keepdims=True)
    radius = np.maximum(np.hypot(offset[..., 0], offset[..., 1]), 1e-9)
    turning = offset[..., 0] * np.sin(pose[..., 2]) - offset[..., 1] * np.cos(pose[..., 2])
    return float(np.abs((turning / radius).mean(axis=-1)).mean())


@pytest.mark.parametrize(
    ("regime", "orders", "mills"),
    [
        ("swarm", (0.0, 0.35), (0.0, 0.35)),
        ("torus", (0.0, 0.35), (0.5, 1.0)),
        ("parallel", (0.95, 1.0), (0.0, 0.35)),
    ],
)
def test_the_width_of_the_zone_of_orientation_chooses_the_regime(
    regime: str, orders: tuple[float, float], mills: tuple[float, float]
) -> None:
    pose = last_third(regime)
    assert orders[0] <= order(pose[..., 2]).mean() <= orders[1]
    assert mills[0] <= milling(pose) <= mills[1]
