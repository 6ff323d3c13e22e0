"""Flocking by alignment and proximal control.

Source: A. E. Turgut, H. Celikkanat, F. Gokce, E. Sahin, "Self-organized flocking in mobile robot
swarms", Swarm Intelligence 2, 2008, doi:10.1007/s11721-008-0016-2.

Where we differ: the paper's eight infrared sectors become the ranges of tracked neighbours, so the
proximal force is a function of range and is averaged over neighbours; the mean heading includes the
robot's own; neighbours whose heading is not told count for proximal control alone. The gains are
ours, for robots of a Zumo's size.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import KobotConfig
from swarmvision.controllers.law import reflex
from swarmvision.controllers.motion import turn_and_go, with_alone
from swarmvision.data import Commands, Estimates
from swarmvision.geometry import FloatArray


def flock(estimates: Estimates, config: KobotConfig) -> Commands:
    """Return the commands of robots from the neighbours that they see.

    Args:
        estimates: Robot frame, shape ``(..., k)``; may be empty.
        config: Gains and ranges.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    counted = estimates.seen & (estimates.range <= config.reach)
    told = counted & np.isfinite(estimates.heading)
    heading = np.where(told, estimates.heading, 0.0)
    aligned = 1.0 + np.sum(np.where(told, np.exp(1j * heading), 0.0), axis=-1)  # itself faces ahead
    aligned = aligned / np.maximum(np.abs(aligned), 1e-9)
    distance = np.where(counted, estimates.range, config.desired_range)
    bearing = np.where(counted, estimates.bearing, 0.0)
    force = np.where(counted, proximal_force(distance, config), 0.0)
    number = np.maximum(np.count_nonzero(counted, axis=-1), 1)
    proximal = np.sum(force * np.exp(1j * bearing), axis=-1) / number
    wanted = aligned + config.proximal_gain * proximal
    commands = turn_and_go(wanted.real, wanted.imag, config.speed, config.turn_gain)
    return with_alone(commands, np.any(counted, axis=-1), config.alone, config.speed)


def proximal_force(distance: FloatArray, config: KobotConfig) -> FloatArray:
    """Return the pull (positive) or push towards a neighbour at a range (m), in -1..1.

    The paper's signed square of the deviation, here scaled to reach 1 at the end of its reach and -1
    where two robots nearly touch.
    """
    off = distance - config.desired_range
    span = np.where(
        off > 0.0, config.reach - config.desired_range, config.desired_range - config.contact_range
    )
    return np.clip(np.sign(off) * (off / span) ** 2, -1.0, 1.0)


LAW = reflex(flock, KobotConfig, {"range", "bearing", "heading"})
