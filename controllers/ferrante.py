"""Flocking without alignment: the size of the force sets the speed, its sideways part the turn rate.

Source: E. Ferrante, A. E. Turgut, C. Huepe, A. Stranieri, C. Pinciroli, M. Dorigo, "Self-organized
flocking with a mobile robot swarm: a novel motion control method", Adaptive Behavior 20(6), 2012,
doi:10.1177/1059712312462248: a Lennard-Jones force with its zero at the desired range, and
magnitude-dependent motion control. ``f = alpha h + beta p + gamma g``.

Where we differ: the force is that between the places where neighbours will be
(:mod:`swarmvision.controllers.anticipation`), averaged over them, and each one's is bounded; what a proximity
ring meets, and is no robot, pushes. All gains are ours, for robots of a Zumo's size.

Why places to come: sideways the law is a spring without a damper. A robot that is off by ``y`` turns by
``w = -k y`` and so moves by ``y'' = -k v y``: it swings, and what it sees late makes it swing more.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import FerranteConfig
from swarmvision.controllers.anticipation import Motion, anticipated, at_rest
from swarmvision.controllers.crowd import crowd, goal_offset, push_of_obstacles, unit
from swarmvision.controllers.law import Law
from swarmvision.controllers.motion import glide, with_alone
from swarmvision.data import Commands, Senses
from swarmvision.geometry import FloatArray


def flock(senses: Senses, motion: Motion, config: FerranteConfig) -> tuple[Commands, Motion]:
    """Return the commands of robots from ranges and bearings of the neighbours that they see.

    Args:
        senses: Shape ``(..., k)``; may be empty.
        motion: How the neighbours moved.
        config: Gains and ranges.

    Returns:
        Before the limits of the drive, shape ``(...)``, and how the neighbours move.
    """
    others = crowd(senses.neighbours, config.reach_factor * config.desired_range, config.forget)
    goal, informed = goal_offset(senses)
    others, motion = anticipated(others, senses, motion, config.anticipation, config.smoothing)
    force = (
        config.alignment_gain * others.heading()
        + config.proximal_gain * others.mean(lennard_jones(others.distance, config) * others.towards)
        + config.goal_gain * unit(goal)
        + config.obstacle_gain * push_of_obstacles(senses, config.obstacle_range, config.contact_range)
    )
    gains = (config.speed_gain, config.turn_gain)
    commands = glide(force.real, force.imag, config.speed, config.top_speed, gains)
    obstacle = np.any(senses.proximity < config.obstacle_range, axis=-1)
    return with_alone(commands, others.anybody | obstacle | informed, config.alone, config.speed), motion


def lennard_jones(distance: FloatArray, config: FerranteConfig) -> FloatArray:
    """Return the pull (positive) or push towards a neighbour at a range (m), within the limit.

    ``F = -4 a eps / r (2 (sigma/r)^(2a) - (sigma/r)^a)`` with ``sigma = d / 2^(1/a)``, so that ``F(d) = 0``.
    """
    a = config.exponent
    ratio = 0.5 * (config.desired_range / distance) ** a  # (sigma / r) ** a
    force = -4.0 * a * config.strength / distance * (2.0 * ratio**2 - ratio)
    return np.clip(force, -config.force_limit, config.force_limit)


LAW = Law(
    FerranteConfig,
    frozenset({"range", "bearing", "heading", "proximity", "goal", "motion"}),
    flock,
    at_rest,
)
