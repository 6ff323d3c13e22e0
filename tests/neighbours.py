"""Neighbours by their places, for tests of laws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from swarmvision.data import Estimates
from swarmvision.geometry import polar


def flock_at(*places: tuple[float, float]) -> Estimates:
    """Estimates ``(k,)`` of neighbours at places (m) in the robot's frame."""
    distance, bearing, heading = polar(np.column_stack([np.array(places), np.zeros(len(places))]))
    empty = Estimates.empty((len(places),))
    return replace(empty, seen=np.full(len(places), True), range=distance, bearing=bearing, heading=heading)
