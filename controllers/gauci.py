"""Four behaviours from one bit, is a robot straight ahead?, and four wheel speeds.

Sources: aggregation from M. Gauci, J. Chen, W. Li, T. J. Dodd, R. Gross, "Self-organized aggregation
without computation", International Journal of Robotics Research 33(8), 2014, doi:10.1177/0278364914525244;
that dispersal, milling and cyclic pursuit are other points of the same space of four numbers, and the
dispersal's, from D. S. Brown, R. Turner, O. Hennigh, S. Loscalzo, "Discovery and exploration of novel swarm
behaviors given limited robot capabilities", DARS 2016, doi:10.1007/978-3-319-73008-0_31. No state, no
arithmetic.

Where we differ: the line of sight is a beam that meets the bodies of the tracked neighbours. Milling and
pursuit are points of our own, because the published ones, found for round robots of other size, jam square
ones of 10 cm: who sees nobody turns right, towards the swarm, who sees somebody turns left, so that each
robot keeps the next one's edge at the edge of its beam; ``n`` robots then stand ``2 pi / n`` apart on a
circle on which the next one is ``pi / n`` to the right. The law turns one way by design, so it has no
mirror image. With nobody in sight it does what the bit says.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import GauciConfig
from swarmvision.controllers.law import reflex
from swarmvision.data import Commands, Estimates

WHEELS = {
    "aggregation": (-0.7, -1.0, 1.0, -1.0),
    "dispersal": (0.2, 0.7, -0.5, -0.1),
    "milling": (1.0, 0.8, 0.5, 1.0),
    "pursuit": (1.0, 0.4, 0.2, 1.0),
}
"""Left and right with nobody ahead, left and right with a robot ahead; 1 is ``config.speed``."""

BEAM_DEG = {"aggregation": 6.0, "dispersal": 2.0, "milling": 12.0, "pursuit": 10.0}
"""Half width of the line of sight (deg); for an even ring of ten, the next one is 18 deg to the right."""


def one_bit(estimates: Estimates, config: GauciConfig) -> Commands:
    """Return the commands of robots from whether a neighbour is ahead.

    Args:
        estimates: Robot frame, shape ``(..., k)``; may be empty.
        config: Wheel speeds, beam and track width.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    bearing = np.where(estimates.seen, estimates.bearing, np.pi)
    distance = np.where(estimates.seen, estimates.range, np.inf)
    body = np.arcsin(np.minimum(config.body_radius / np.maximum(distance, 1e-9), 1.0))
    beam = np.radians(BEAM_DEG[config.behaviour] if config.beam_deg is None else config.beam_deg)
    ahead = (np.abs(bearing) <= beam + body).any(axis=-1)
    wheels = config.speed * np.array(config.wheels or WHEELS[config.behaviour])
    left, right = np.where(ahead, wheels[2], wheels[0]), np.where(ahead, wheels[3], wheels[1])
    return Commands((left + right) / 2.0, (right - left) / config.track)


LAW = reflex(one_bit, GauciConfig, {"range", "bearing"})
