"""What the robots of the error model remember from one call to the next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray

Keys = NDArray[np.uint64]
PHANTOM = -2  # instead of a neighbour's number
MEASURED, REMEMBERED, GHOST = 0, 1, 2  # states of a slot


class Slots(NamedTuple):
    """Neighbours of robots ``r`` of worlds ``w``, the first ``used`` of ``k`` slots."""

    used: IntArray
    """Shape ``(w, r)``."""
    who: IntArray
    """Number of the neighbour, -2 for a phantom, ``(w, r, k)``."""
    state: IntArray
    """Whether the last picture measured it, or whether it is a ghost, ``(w, r, k)``."""
    age: FloatArray
    """Since it was measured (s), ``(w, r, k)``."""
    visible: FloatArray
    """Fraction in sight when it was measured, ``(w, r, k)``."""
    number: IntArray
    """Of the track, as a tracker counts them, ``(w, r, k)``."""
    deviate: FloatArray
    """Lasting normal deviates of range, bearing, heading, left positive, ``(w, r, k, 3)``."""
    place: FloatArray
    """Where it is believed to be: x, y (m), yaw (rad) in the world, ``(w, r, k, 3)``."""
    pace: FloatArray
    """How that is believed to change (m/s, rad/s), ``(w, r, k, 3)``."""

    @classmethod
    def of(cls, worlds: int, robots: int, slots: int) -> Slots:
        """Return slots in which nobody is."""
        shape = (worlds, robots, slots)
        return cls(
            used=np.zeros((worlds, robots), np.int64),
            who=np.empty(shape, np.int64),
            state=np.empty(shape, np.int64),
            age=np.empty(shape),
            visible=np.empty(shape),
            number=np.empty(shape, np.int64),
            deviate=np.empty((*shape, 3)),
            place=np.empty((*shape, 3)),
            pace=np.empty((*shape, 3)),
        )


class Minds(NamedTuple):
    """What is an observer's own, whomever it sees."""

    common: FloatArray
    """Lasting deviates that all of an observer's neighbours share, ``(w, r, 3)``."""
    pose: FloatArray
    """True pose at the last call, ``(w, r, 3)``."""
    way: FloatArray
    """Forward way (m) and turn (rad) by the encoders until then, ``(w, r, 2)``."""
    following: IntArray
    """Number of the observer's next track, ``(w, r)``."""
    picture: IntArray
    """Number of the next picture, ``(w,)``."""
    keys: Keys
    """Of the observers' chance, ``(w, r)``."""


@dataclass(eq=False, slots=True)
class ErrorMemory:
    """Memory of the robots of many worlds: each call reads ``slots``, fills ``spare`` and exchanges them."""

    slots: Slots
    """As of the last call."""
    spare: Slots
    """Room for the next."""
    minds: Minds
    """Of the observers."""

    @classmethod
    def blank(cls, keys: Keys, slots: int) -> ErrorMemory:
        """Return the memory of robots that have seen nothing, from their keys ``(w, r)``."""
        shape = (*keys.shape, slots)
        minds = Minds(
            common=np.zeros((*keys.shape, 3)),
            pose=np.zeros((*keys.shape, 3)),
            way=np.zeros((*keys.shape, 2)),
            following=np.zeros(keys.shape, np.int64),
            picture=np.zeros(len(keys), np.int64),
            keys=keys.astype(np.uint64),
        )
        return cls(Slots.of(*shape), Slots.of(*shape), minds)

    def forget(self, world: int, keys: Keys) -> None:
        """Begin anew in one world, with other keys ``(r,)``."""
        self.slots.used[world] = 0
        self.minds.common[world] = 0.0
        self.minds.following[world] = self.minds.picture[world] = 0
        self.minds.keys[world] = keys

    def exchange(self) -> None:
        """Let what the last call filled be what the next one reads."""
        self.slots, self.spare = self.spare, self.slots
