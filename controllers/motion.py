"""From a wanted direction to a unicycle command: shared by every law. The drive saturates, not we.

Source: A. E. Turgut, H. Celikkanat, F. Gokce, E. Sahin, "Self-organized flocking in mobile robot
swarms", Swarm Intelligence 2, 2008, doi:10.1007/s11721-008-0016-2 (heading-dependent motion control).
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import Alone
from swarmvision.data import BoolArray, Commands
from swarmvision.geometry import FloatArray

SCAN_RATE = 1.0  # rad/s: how fast a lone robot looks about


def turn_and_go(forward: FloatArray, left: FloatArray, speed: float, turn_gain: float) -> Commands:
    """Return the command that turns towards a direction and goes the faster the nearer it is to it.

    ``v = speed * max(0, cos(phi))``, ``w = turn_gain * phi`` with ``phi`` the angle of the direction.

    Args:
        forward: Of the wanted direction in the robot frame, shape ``(...)``; any length.
        left: The same.
        speed: Cruise speed (m/s).
        turn_gain: Proportional gain (1/s).
    """
    angle = np.arctan2(left, forward)
    return Commands(speed * np.maximum(np.cos(angle), 0.0), turn_gain * angle)


def with_alone(commands: Commands, seen_any: BoolArray | np.bool_, policy: Alone, speed: float) -> Commands:
    """Return the commands with the declared policy where a robot sees nobody, shape ``(...)``."""
    lone_speed = speed if policy == "keep" else 0.0
    lone_turn = SCAN_RATE if policy == "scan" else 0.0
    return Commands(
        np.where(seen_any, commands.speed, lone_speed),
        np.where(seen_any, commands.turn_rate, lone_turn),
    )
