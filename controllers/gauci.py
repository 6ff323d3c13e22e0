"""Aggregation by one bit: is a robot straight ahead?

Source: M. Gauci, J. Chen, W. Li, T. J. Dodd, R. Gross, "Self-organized aggregation without
computation", International Journal of Robotics Research 33(8), 2014, doi:10.1177/0278364914525244:
wheel speeds (-0.7, -1.0) with nobody ahead, (1.0, -1.0) with a robot ahead. No state, no arithmetic.

Where we differ: the line of sight is a narrow beam round straight ahead in the tracked neighbours.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import GauciConfig
from swarmvision.controllers.law import reflex
from swarmvision.data import Commands, Estimates

NOBODY = (-0.7, -1.0)  # left, right
SOMEBODY = (1.0, -1.0)


def aggregate(estimates: Estimates, config: GauciConfig) -> Commands:
    """Return the commands of robots from whether a neighbour is ahead.

    Args:
        estimates: Robot frame, shape ``(..., k)``; may be empty.
        config: Speed, beam and track width.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    bearing = np.where(estimates.seen, estimates.bearing, np.pi)
    ahead = (np.abs(bearing) <= np.radians(config.beam_deg)).any(axis=-1)
    left = config.speed * np.where(ahead, SOMEBODY[0], NOBODY[0])
    right = config.speed * np.where(ahead, SOMEBODY[1], NOBODY[1])
    return Commands((left + right) / 2.0, (right - left) / config.track)


LAW = reflex(aggregate, GauciConfig, {"bearing"})
