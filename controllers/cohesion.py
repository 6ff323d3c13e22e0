"""Aggregation by cohesion: go towards the neighbours in sight until they are near.

Source: the cohesion and separation rules of C. W. Reynolds, "Flocks, herds and schools: a distributed
behavioral model", SIGGRAPH 1987, doi:10.1145/37401.37406, without alignment. Where we differ: both
are one force of range with its zero at the wanted range, averaged over the neighbours, and a robot
slows down as the force fades, so that a cluster comes to rest.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import CohesionConfig
from swarmvision.controllers.law import reflex
from swarmvision.controllers.motion import turn_and_go, with_alone
from swarmvision.data import Commands, Estimates


def gather(estimates: Estimates, config: CohesionConfig) -> Commands:
    """Return the commands of robots from the neighbours that they see.

    Args:
        estimates: Robot frame, shape ``(..., k)``; may be empty.
        config: Speed, gains and ranges.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    distance = np.where(estimates.seen, estimates.range, config.desired_range)
    bearing = np.where(estimates.seen, estimates.bearing, 0.0)
    force = np.tanh((distance - config.desired_range) / config.softness)
    # Near neighbours weigh more, so that a touch is felt in a crowd.
    weight = np.where(estimates.seen, 1.0 / np.maximum(distance, 1e-3), 0.0)
    total = np.maximum(weight.sum(axis=-1), 1e-9)
    wanted = np.sum(weight * force * np.exp(1j * bearing), axis=-1) / total
    eager = np.minimum(np.abs(wanted) / config.rest, 1.0)
    commands = turn_and_go(wanted.real, wanted.imag, config.speed, config.turn_gain)
    commands = Commands(commands.speed * eager, commands.turn_rate * eager)
    return with_alone(commands, np.any(estimates.seen, axis=-1), config.alone, config.speed)


LAW = reflex(gather, CohesionConfig, {"range", "bearing"})
