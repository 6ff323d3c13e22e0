"""The active elastic sheet: springs to the neighbours, and nothing about where they face.

Source: E. Ferrante, A. E. Turgut, M. Dorigo, C. Huepe, "Elasticity-based mechanism for the collective
motion of self-propelled particles with springlike interactions", Physical Review Letters 111, 268302,
2013, doi:10.1103/PhysRevLett.111.268302: ``v = v0 + alpha F.n``, ``w = beta F.n_perp`` with
``F = sum k/l (r - l)``.

Where we differ: the paper ties each agent to the neighbours that it began with, each at the range that it
had then. A marker without a number cannot be told from another for long, so the springs reach to whoever
is near now and have one length at rest; their mean is taken. The gains are ours.
"""

from __future__ import annotations

from swarmvision.config.controller import ElasticConfig
from swarmvision.controllers.crowd import crowd
from swarmvision.controllers.law import reflex
from swarmvision.controllers.motion import glide, with_alone
from swarmvision.data import Commands, Estimates


def pull(estimates: Estimates, config: ElasticConfig) -> Commands:
    """Return the commands of robots from ranges and bearings of the neighbours that they see.

    Args:
        estimates: Robot frame, shape ``(..., k)``; may be empty.
        config: Gains and ranges.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    others = crowd(estimates, config.reach)
    stretch = (others.distance - config.desired_range) / config.desired_range
    force = others.mean(config.stiffness * stretch * others.towards)
    gains = (config.speed_gain, config.turn_gain)
    commands = glide(force.real, force.imag, config.speed, config.top_speed, gains)
    return with_alone(commands, others.anybody, config.alone, config.speed)


LAW = reflex(pull, ElasticConfig, {"range", "bearing"})
