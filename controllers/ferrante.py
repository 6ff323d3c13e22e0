"""Flocking without alignment: the size of the force sets the speed, its sideways part the turn rate.

Source: E. Ferrante, A. E. Turgut, C. Huepe, A. Stranieri, C. Pinciroli, M. Dorigo, "Self-organized
flocking with a mobile robot swarm: a novel motion control method", Adaptive Behavior 20(6), 2012,
doi:10.1177/1059712312462248: a Lennard-Jones force with its zero at the desired range, and
magnitude-dependent motion control. ``f = alpha h + beta p + gamma g``.

Where we differ: the force is averaged over the neighbours and each one's is bounded; what a proximity
ring meets, and is no robot, pushes. All gains are ours, for robots of a Zumo's size.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import FerranteConfig
from swarmvision.controllers.crowd import crowd, goal_offset, push_of_obstacles, unit
from swarmvision.controllers.law import reflex_of_senses
from swarmvision.controllers.motion import glide, with_alone
from swarmvision.data import Commands, Senses
from swarmvision.geometry import FloatArray


def flock(senses: Senses, config: FerranteConfig) -> Commands:
    """Return the commands of robots from ranges and bearings of the neighbours that they see.

    Args:
        senses: Shape ``(..., k)``; may be empty.
        config: Gains and ranges.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    others = crowd(senses.neighbours, config.reach_factor * config.desired_range, config.forget)
    goal, informed = goal_offset(senses)
    force = (
        config.alignment_gain * others.heading()
        + config.proximal_gain * others.mean(lennard_jones(others.distance, config) * others.towards)
        + config.goal_gain * unit(goal)
        + config.obstacle_gain * push_of_obstacles(senses, config.obstacle_range, config.contact_range)
    )
    gains = (config.speed_gain, config.turn_gain)
    commands = glide(force.real, force.imag, config.speed, config.top_speed, gains)
    obstacle = np.any(senses.proximity < config.obstacle_range, axis=-1)
    return with_alone(commands, others.anybody | obstacle | informed, config.alone, config.speed)


def lennard_jones(distance: FloatArray, config: FerranteConfig) -> FloatArray:
    """Return the pull (positive) or push towards a neighbour at a range (m), within the limit.

    ``F = -4 a eps / r (2 (sigma/r)^(2a) - (sigma/r)^a)`` with ``sigma = d / 2^(1/a)``, so that ``F(d) = 0``.
    """
    a = config.exponent
    ratio = 0.5 * (config.desired_range / distance) ** a  # (sigma / r) ** a
    force = -4.0 * a * config.strength / distance * (2.0 * ratio**2 - ratio)
    return np.clip(force, -config.force_limit, config.force_limit)


LAW = reflex_of_senses(flock, FerranteConfig, {"range", "bearing", "heading", "proximity", "goal"})
