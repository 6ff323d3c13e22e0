"""How a swarm got on: ways, contacts, robots that are stuck. Series have ``t`` instants."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from swarmvision.data import BoolArray
from swarmvision.geometry import FloatArray

STUCK_WAY = 0.1  # m by the encoders in the time looked at, before a robot can be called stuck; ours
STUCK_SHARE = 0.25  # of that which its body really went; ours


def contacts_per_robot_minute(contacts: int, robots: int, seconds: float) -> float:
    """Return contacts per robot and minute; 0 for nobody or no time."""
    robot_minutes = robots * seconds / 60.0
    return contacts / robot_minutes if robot_minutes > 0.0 else 0.0


def displacement(position: ArrayLike) -> float:
    """Return how far the centroid came, first to last (m), from ``(t, r, 2)``; 0 for nobody."""
    centre = _centre(position)
    return float(np.hypot(*(centre[-1] - centre[0]))) if len(centre) else 0.0


def path_length(position: ArrayLike) -> FloatArray:
    """Return the way of each robot (m), the sum of its steps, shape ``(r,)``, from ``(t, r, 2)``."""
    steps = np.diff(np.asarray(position, dtype=np.float64), axis=0)
    way: FloatArray = np.hypot(steps[..., 0], steps[..., 1]).sum(axis=0)
    return way


def path_efficiency(position: ArrayLike) -> float:
    """Return the centroid's displacement over the mean way of a robot, 0..1, from ``(t, r, 2)``.

    1 is a swarm that went straight; a swarm that did not move has 0.
    """
    way = path_length(position)
    mean = float(way.mean()) if len(way) else 0.0
    return displacement(position) / mean if mean > 1e-9 else 0.0


def stuck(position: ArrayLike, wheel_travel: ArrayLike) -> BoolArray:
    """Return which robots drove without getting on, shape ``(r,)``: their tracks ran, their bodies did not.

    A robot that waits or turns on the spot is not stuck.

    Args:
        position: m, shape ``(t, r, 2)``.
        wheel_travel: Way of left and right track by the encoders (m), shape ``(t, r, 2)``.
    """
    driven = np.abs(np.diff(np.asarray(wheel_travel, dtype=np.float64).mean(axis=-1), axis=0)).sum(axis=0)
    blocked: BoolArray = (driven > STUCK_WAY) & (path_length(position) < STUCK_SHARE * driven)
    return blocked


def _centre(position: ArrayLike) -> FloatArray:
    place = np.asarray(position, dtype=np.float64)
    if place.shape[1] == 0:
        return np.zeros((0, 2))
    centre: FloatArray = place.mean(axis=1)
    return centre
