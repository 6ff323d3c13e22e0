"""Robots and their candidates as the error model takes them: many at once, a row a number.

A processor takes several robots in one instruction where each of their numbers stands in a row of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray
from swarmvision.sensing.error_memory import Keys


class Observers(NamedTuple):
    """Robots that look together, ``(b,)`` each."""

    home: IntArray
    """The first robot of its world."""
    picture: IntArray
    """Number of the picture."""
    turn: IntArray
    """Bin of the turn rate."""
    odd: IntArray
    """1 for who sees a phantom."""
    seed: Keys
    """Of its chance in this picture."""
    side: FloatArray
    """1 for who turns left, else -1; tables are of left turns."""
    shared_range: FloatArray
    """What its neighbours have in common of their deviates, of what lasts and of what is new."""
    shared_bearing: FloatArray
    shared_heading: FloatArray
    x: FloatArray
    """Where it is (m, m, rad)."""
    y: FloatArray
    yaw: FloatArray
    from_x: FloatArray
    """Where its encoders say that it is (m)."""
    from_y: FloatArray
    slip: FloatArray
    """Its turn that its encoders did not tell (rad), and that turn's cosine and sine."""
    cosine: FloatArray
    sine: FloatArray


class Candidates(NamedTuple):
    """Who may be measured: the nearest of each observer, the second of each, ..., ``(m, b)`` each."""

    who: IntArray
    """Number in its world, -1 for nobody."""
    past: IntArray
    """Slot of its track, -1 without."""
    found: IntArray
    """1 where it is measured."""
    follows: IntArray
    """1 where its track goes on."""
    cell: IntArray
    """Of the tables."""
    range: FloatArray
    """In, true; out, as measured (m, rad, rad)."""
    bearing: FloatArray
    heading: FloatArray
    share: FloatArray
    """That nobody hides; and what follows, as :data:`swarmvision.sensing.error_memory.AGE` has it."""
    x: FloatArray
    y: FloatArray
    yaw: FloatArray
    vx: FloatArray
    vy: FloatArray
    spin: FloatArray
    lasting_range: FloatArray
    lasting_bearing: FloatArray
    lasting_heading: FloatArray


WHOM, PAST, FOUND, FOLLOWS, CELL = range(5)  # the same rows in one array
RANGE, BEARING, HEADING, AS_TOLD = range(4)  # and these: as told, then a slot's numbers from its share on


@compiled
def room_for_observers(room: int) -> Observers:
    """Return rows for so many."""
    n, keys, f = np.empty((4, room), np.int64), np.empty(room, np.uint64), np.empty((12, room))
    shared, places, paths = (f[1], f[2], f[3]), (f[4], f[5], f[6]), (f[7], f[8], f[9])
    return Observers(n[0], n[1], n[2], n[3], keys, f[0], *shared, *places, *paths, f[10], f[11])


@compiled
def rows_of(n: IntArray, f: FloatArray) -> Candidates:
    """Return the candidates in arrays ``(5, m, b)`` and ``(13, m, b)``."""
    places, paces, lasting = (f[4], f[5], f[6]), (f[7], f[8], f[9]), (f[10], f[11], f[12])
    return Candidates(n[0], n[1], n[2], n[3], n[4], f[0], f[1], f[2], f[3], *places, *paces, *lasting)
