"""Looks into tracks: what a robot's lenses read is fused, tracked and believed. Kernels, robot by robot."""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray
from swarmvision.perception.fuse import fuse
from swarmvision.perception.track import Beliefs, Law, Tracks, believe, forget, predict, take_in


@compiled
def anticipate(tracks: Tracks, robot: int, motion: FloatArray, law: Law) -> None:
    """Carry a robot's tracks on to its next look; ``motion`` is speed, turn rate and time ``(3,)``."""
    predict(tracks, robot, motion[0], motion[1], motion[2], law)


@compiled
def follow(
    tracks: Tracks,
    robot: int,
    polar: FloatArray,
    covariance: FloatArray,
    lens: IntArray,
    mount: FloatArray,
    reach: float,
    law: Law,
) -> None:
    """Take in what all lenses of a robot read at once; arguments as for :func:`fuse`."""
    rows, spreads = np.empty((len(polar), 4)), np.empty((len(polar), 3, 3))
    count = fuse(polar, covariance, lens, mount, reach, rows, spreads)
    take_in(tracks, robot, rows[:count], spreads[:count], law)
    forget(tracks, robot, law)


@compiled
def settle(tracks: Tracks, first: int, last: int, motion: FloatArray, law: Law, beliefs: Beliefs) -> None:
    """Write what robots from first to before last believe; ``motion`` ``(r, 3)`` is since their last look."""
    for robot in range(first, last):
        believe(tracks, robot, motion[robot, 0], motion[robot, 1], motion[robot, 2], law, beliefs)
