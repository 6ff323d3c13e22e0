"""Aggregation by cohesion: go towards the robots in sight, and stand clear of the nearest.

Source: the cohesion and separation rules of C. W. Reynolds, "Flocks, herds and schools: a distributed
behavioral model", SIGGRAPH 1987, doi:10.1145/37401.37406, without alignment. Where we differ: the pull
is towards the middle of all that is in sight and never more than 1, while each near neighbour pushes for
itself, so that a robot rests where its own push and pull balance and a cluster is not pressed together by
those outside; and a robot drives backwards where it is pushed from ahead, instead of turning round, because
square robots touch when they turn beside each other. Speed and turn rate are the two components of the force
(magnitude-dependent motion: E. Ferrante et al., Adaptive Behavior 20(6), 2012,
doi:10.1177/1059712312462248). Gains are ours.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import CohesionConfig
from swarmvision.controllers.crowd import FARTHEST, crowd
from swarmvision.controllers.law import reflex
from swarmvision.controllers.motion import with_alone
from swarmvision.data import Commands, Estimates


def gather(estimates: Estimates, config: CohesionConfig) -> Commands:
    """Return the commands of robots from the neighbours that they see.

    Args:
        estimates: Robot frame, shape ``(..., k)``; may be empty.
        config: Speed, gains and ranges.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    others = crowd(estimates, FARTHEST, config.forget)
    middle = others.mean(others.offset)
    # Nearly in the middle the pull fades, or the innermost would spin.
    pull = middle / np.maximum(np.abs(middle), config.desired_range)
    near = (config.slow_range - others.distance) / (config.slow_range - config.desired_range)
    force = pull - others.total(np.clip(near, 0.0, 2.0) * others.towards)
    force = force / np.maximum(np.abs(force), 1.0)
    commands = Commands(config.speed * force.real, config.turn_gain * force.imag)
    return with_alone(commands, others.anybody, config.alone, config.speed)


LAW = reflex(gather, CohesionConfig, {"range", "bearing"})
