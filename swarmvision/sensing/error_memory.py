"""What the robots of the error model remember from one call to the next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import compiled
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray

Keys = NDArray[np.uint64]
NOBODY, PHANTOM = -1, -2  # instead of a neighbour's number; the former in the chance of what all share
WHO, STATE, NUMBER = range(3)
"""Marks of a slot: the neighbour's number, or -2 for a phantom; whether the last picture measured it, or
whether it is a ghost; the number of the track, as a tracker counts them."""
MEASURED, REMEMBERED, GHOST = 0, 1, 2  # its states
AGE, SHARE, X, Y, YAW, VX, VY, SPIN, LASTING_RANGE, LASTING_BEARING, LASTING_HEADING = range(11)
"""Numbers of a slot: since it was measured (s); fraction in sight then; where it is believed to be in the
world (m, m, rad), and how that is believed to change (m/s, m/s, rad/s); lasting normal deviates of range,
bearing and heading, left positive."""


class Slots(NamedTuple):
    """Neighbours of robots ``o``, one world's after another's: the first ``used`` of each one's ``k``."""

    used: IntArray
    """Shape ``(o,)``."""
    marks: IntArray
    """Columns :data:`WHO` to :data:`NUMBER`, ``(o * k, 3)``."""
    numbers: FloatArray
    """Columns :data:`AGE` to :data:`LASTING_HEADING`, ``(o * k, 11)``."""

    @classmethod
    def of(cls, robots: int, slots: int) -> Slots:
        """Return slots in which nobody is."""
        size = robots * slots
        return cls(
            used=np.zeros(robots, np.int64), marks=np.zeros((size, 3), np.int64), numbers=np.zeros((size, 11))
        )


class Minds(NamedTuple):
    """What is an observer's own, whomever it sees, ``(o,)`` each but for ``picture``."""

    common_range: FloatArray
    """Lasting deviates that all of an observer's neighbours share."""
    common_bearing: FloatArray
    common_heading: FloatArray
    x: FloatArray
    """True pose at the last call (m, m, rad)."""
    y: FloatArray
    yaw: FloatArray
    forward: FloatArray
    """Way by the encoders until then (m)."""
    turn: FloatArray
    """And turn (rad)."""
    following: IntArray
    """Number of the observer's next track."""
    keys: Keys
    """Of the observers' chance."""
    picture: IntArray
    """Number of the next picture, ``(w,)``."""


@compiled
def minds_from(minds: Minds, first: int) -> Minds:
    """Return the minds of the observers from some robot on."""
    return Minds(
        minds.common_range[first:],
        minds.common_bearing[first:],
        minds.common_heading[first:],
        minds.x[first:],
        minds.y[first:],
        minds.yaw[first:],
        minds.forward[first:],
        minds.turn[first:],
        minds.following[first:],
        minds.keys[first:],
        minds.picture,
    )


@dataclass(eq=False, slots=True)
class ErrorMemory:
    """Memory of the robots of many worlds: each call reads ``slots``, fills ``spare`` and exchanges them."""

    slots: Slots
    """As of the last call."""
    spare: Slots
    """Room for the next."""
    minds: Minds
    """Of the observers."""
    each: int
    """How many slots a robot has, ``k``."""

    @classmethod
    def blank(cls, keys: Keys, slots: int) -> ErrorMemory:
        """Return the memory of robots that have seen nothing, from their keys ``(w, r)``."""
        robots = keys.size
        n = np.zeros((8, robots))
        following, picture = np.zeros(robots, np.int64), np.zeros(len(keys), np.int64)
        minds = Minds(
            n[0],
            n[1],
            n[2],
            n[3],
            n[4],
            n[5],
            n[6],
            n[7],
            following,
            keys.astype(np.uint64).reshape(-1),
            picture,
        )
        return cls(Slots.of(robots, slots), Slots.of(robots, slots), minds, slots)

    def forget(self, world: int, keys: Keys) -> None:
        """Begin anew in one world, with other keys ``(r,)``."""
        robots = slice(world * len(keys), (world + 1) * len(keys))
        self.slots.used[robots] = self.minds.following[robots] = self.minds.picture[world] = 0
        for common in self.minds[:3]:
            common[robots] = 0.0
        self.minds.keys[robots] = keys

    def exchange(self) -> None:
        """Let what the last call filled be what the next one reads."""
        self.slots, self.spare = self.spare, self.slots
