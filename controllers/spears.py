"""Hexagonal and square lattices by artificial physics.

Source: W. M. Spears, D. F. Spears, J. C. Hamann, R. Heil, "Distributed, physics-based control of swarms of
vehicles", Autonomous Robots 17, 2004, doi:10.1023/B:AURO.0000033970.96785.f2: between two robots a force
``G / r^p``, at most F_max, pushes within R, pulls from R to 1.5 R, and is nothing beyond. For a square
lattice every robot has one of two labels, and like robots stand at sqrt(2) R.

Where we differ: the force is a velocity (full friction instead of the paper's momentum with a little);
within a narrow band round R it passes evenly from push to pull, or robots that decide ten times a second
would tremble; the label is the team; G is given as a multiple of G_t; G = G_t and the other values are ours.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import SpearsConfig
from swarmvision.controllers.crowd import FARTHEST, crowd
from swarmvision.controllers.law import reflex
from swarmvision.controllers.motion import with_alone
from swarmvision.data import Commands, Estimates
from swarmvision.geometry import FloatArray


def transition_gain(greatest_force: float, spacing: float, power: float) -> float:
    """Return the paper's ``G_t = F_max R^p / (2 sqrt(3))``.

    With a stronger G the six neighbours of a site pull two robots on it together harder than the two can push
    each other apart.
    """
    return float(greatest_force * spacing**power / (2.0 * 3.0**0.5))


def arrange(estimates: Estimates, config: SpearsConfig) -> Commands:
    """Return the commands of robots from the neighbours that they see, ``(..., k)``, shape ``(...)``."""
    like = estimates.kind == config.own_kind
    wider = np.where(like & (config.lattice == "square"), 2.0**0.5, 1.0)
    near = crowd(estimates, FARTHEST)
    near = near.within(near.distance < config.reach * config.spacing * wider)
    wanted = near.total(pull(near.distance / wider, config) * near.towards)
    size = np.maximum(np.abs(wanted), 1.0)
    commands = Commands(config.speed * wanted.real / size, config.turn_gain * wanted.imag / size)
    return with_alone(commands, near.anybody, config.alone, config.speed)


def pull(distance: FloatArray, config: SpearsConfig) -> FloatArray:
    """Return the pull (positive) or push (negative) of a neighbour at a range (m); F_max is 1."""
    gain = config.strength * transition_gain(1.0, config.spacing, config.power)
    size = np.minimum(gain / distance**config.power, 1.0)
    side = np.clip((distance - config.spacing) / (config.band / 2.0), -1.0, 1.0)
    force: FloatArray = side * size
    return force


LAW = reflex(arrange, SpearsConfig, {"range", "bearing", "kind"})
