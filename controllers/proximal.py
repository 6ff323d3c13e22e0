"""A pull or push of a neighbour as a signed square of how far it is from its place.

Source: proximal control in A. E. Turgut, H. Celikkanat, F. Gokce, E. Sahin, "Self-organized flocking in
mobile robot swarms", Swarm Intelligence 2, 2008, doi:10.1007/s11721-008-0016-2. Where we differ: a
function of range, not of the level of an infrared sensor, scaled at both ends.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from swarmvision import recycling
from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray


class Ranges(Protocol):
    """What the force needs to know; settings of several laws have it."""

    @property
    def contact_range(self) -> float:
        """Where the push is full (m)."""

    @property
    def desired_range(self) -> float:
        """Where there is no force (m)."""

    @property
    def reach(self) -> float:
        """Where the pull is full (m)."""


def proximal_force(distance: FloatArray, ranges: Ranges) -> FloatArray:
    """Return the pull (positive) or push towards a neighbour at a range (m), in -1..1."""
    distance = np.ascontiguousarray(distance, dtype=np.float64)
    force: FloatArray = recycling.empty(distance.shape)
    inner, outer = ranges.desired_range - ranges.contact_range, ranges.reach - ranges.desired_range
    _pull(distance.reshape(-1), ranges.desired_range, inner, outer, force.reshape(-1))
    return force


@leaf
def _pull(distance: FloatArray, desired: float, inner: float, outer: float, force: FloatArray) -> None:
    """Fill in the force at ranges ``(n,)``; it is full ``inner`` or ``outer`` (m) from the desired one."""
    for n in range(len(distance)):
        off = distance[n] - desired
        share = off / (outer if off > 0.0 else inner)
        force[n] = min(share * share, 1.0) * (1.0 if off > 0.0 else -1.0)
