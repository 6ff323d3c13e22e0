"""Flocking in a lattice, round obstacles, to a goal.

Source: R. Olfati-Saber, "Flocking for multi-agent dynamic systems: algorithms and theory", IEEE Transactions
on Automatic Control 51(3), 2006, doi:10.1109/TAC.2005.864190: alpha agents (neighbours), beta agents
(obstacles) and the gamma agent (goal).

Where we differ: the sums over alpha and beta agents are means, since at ten decisions a second with motor
lag the sums do not settle; a neighbour's velocity is its heading at the cruise speed; a beta agent is what a
sector of the proximity ring meets, taken as a piece of wall; without a goal the own speed returns to the
cruise speed; the acceleration drives a point ahead of the axle. Lengths are the paper's, scaled by
``desired_range / 7``, times are its own.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import OlfatiSaberConfig
from swarmvision.controllers.crowd import FARTHEST, NEAREST, ComplexArray, crowd, goal_offset
from swarmvision.controllers.law import reflex_of_senses
from swarmvision.controllers.motion import accelerated, own_velocity, with_alone
from swarmvision.data import SECTOR_BEARINGS, BoolArray, Commands, Senses
from swarmvision.geometry import FloatArray

SPACING = 7.0  # d: the paper's unit of length is a seventh of it
REACH = 1.2 * SPACING  # r
CLEARANCE = 0.6 * SPACING  # d'
EPSILON = 0.1  # of the sigma norm
STRENGTH = 5.0  # a = b of the action function
FULL_ALPHA, FULL_BETA = 0.2, 0.9  # h: share of the reach within which the bump function is 1


def flock(senses: Senses, config: OlfatiSaberConfig) -> Commands:
    """Return the commands of robots from neighbours, obstacles and goal.

    Args:
        senses: Shape ``(..., k)``; may be empty.
        config: Gains and the spacing.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    metre = SPACING / config.desired_range
    velocity = own_velocity(senses, config) * metre
    obstacle, near = _beta(senses, velocity, metre, config)
    goal, informed = _gamma(senses, velocity, metre, config)
    alpha, anybody = _alpha(senses, velocity, metre, config)
    commands = accelerated((alpha + obstacle + goal) / metre, senses, config)
    return with_alone(commands, anybody | near | informed, config.alone, config.speed)


def _alpha(
    senses: Senses, velocity: ComplexArray, metre: float, config: OlfatiSaberConfig
) -> tuple[ComplexArray, BoolArray]:
    others = crowd(senses.neighbours, REACH / metre)
    offset = others.offset * metre
    size = np.abs(offset)
    adjacency = bump(sigma_norm(size) / sigma_norm(REACH), FULL_ALPHA)
    gradient = phi_alpha(size) * sigma_direction(offset)
    theirs = config.speed * metre * others.facing
    told = np.abs(others.facing) > 0.0
    match = np.where(told, adjacency * (theirs - velocity[..., None]), 0.0)
    pull = config.position_gain * others.mean(gradient) + config.velocity_gain * others.mean(match)
    return pull, others.anybody


def _beta(
    senses: Senses, velocity: ComplexArray, metre: float, config: OlfatiSaberConfig
) -> tuple[ComplexArray, BoolArray]:
    thing = np.where(senses.proximity_robot, np.inf, senses.proximity)
    distance = np.clip(thing, NEAREST, FARTHEST) * metre
    near = distance < CLEARANCE
    towards = np.exp(1j * SECTOR_BEARINGS)
    adjacency = np.where(near, bump(sigma_norm(distance) / sigma_norm(CLEARANCE), FULL_BETA), 0.0)
    gap = sigma_norm(distance) - sigma_norm(CLEARANCE)
    push = adjacency * (_s1(gap) - 1.0) * sigma_direction(distance * towards)
    # A wall's agent has the part of the own velocity that runs along the wall.
    approach = -np.real(velocity[..., None] * np.conj(towards)) * towards
    number = np.maximum(np.count_nonzero(near, axis=-1), 1)
    total = config.obstacle_gain * push + config.obstacle_damping * adjacency * approach
    return np.sum(total, axis=-1) / number, np.asarray(np.any(near, axis=-1))


def _gamma(
    senses: Senses, velocity: ComplexArray, metre: float, config: OlfatiSaberConfig
) -> tuple[ComplexArray, BoolArray]:
    place, informed = goal_offset(senses)
    offset = place * metre
    pull = config.goal_gain * offset / np.sqrt(1.0 + np.abs(offset) ** 2)
    cruise = config.speed * metre
    # The paper's goal stands still; a robot that is damped fully would creep, so only what is too fast is.
    size = np.abs(velocity)
    damping = config.goal_damping * velocity * np.maximum(1.0 - cruise / np.maximum(size, cruise), 0.0)
    return np.where(informed, pull - damping, 0.0), informed


def sigma_norm(size: FloatArray | float) -> FloatArray:
    """Return ``(sqrt(1 + eps |z|^2) - 1) / eps`` of a length."""
    return np.asarray((np.sqrt(1.0 + EPSILON * np.square(size)) - 1.0) / EPSILON)


def sigma_direction(offset: ComplexArray) -> ComplexArray:
    """Return the gradient of the sigma norm: nearly a unit vector."""
    return np.asarray(offset / np.sqrt(1.0 + EPSILON * np.abs(offset) ** 2))


def bump(share: FloatArray, full: float) -> FloatArray:
    """Return 1 up to ``full``, 0 from 1 on, and half a cosine between."""
    falling = 0.5 * (1.0 + np.cos(np.pi * (share - full) / (1.0 - full)))
    return np.where(share < full, 1.0, np.where(share < 1.0, falling, 0.0))


def phi_alpha(size: FloatArray) -> FloatArray:
    """Return the pull (positive) or push of an alpha agent at a distance, in the paper's unit."""
    z = sigma_norm(size)
    # With a = b the paper's c = |a - b| / sqrt(4 a b) is 0, and its phi(z) is a s1(z).
    return np.asarray(bump(z / sigma_norm(REACH), FULL_ALPHA) * STRENGTH * _s1(z - sigma_norm(SPACING)))


def _s1(z: FloatArray) -> FloatArray:
    return np.asarray(z / np.sqrt(1.0 + z**2))


LAW = reflex_of_senses(
    flock, OlfatiSaberConfig, {"range", "bearing", "heading", "motion", "proximity", "goal"}
)
