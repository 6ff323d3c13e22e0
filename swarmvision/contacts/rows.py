"""The bodies of many worlds, moved a period on: rows of them at once, and one world where bodies touch."""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled, leaf
from swarmvision.contacts.impulses import resolve
from swarmvision.contacts.meeting import meet_all
from swarmvision.contacts.shapes import WALLS
from swarmvision.data import BoolArray, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.ground import ANGLE, SPIN, VX, VY, X, Y, pull, pull_round
from swarmvision.trigonometry import wrapped

REST = np.zeros(1)  # of what has no tracks
ABREAST = 32  # worlds that are moved together: they fit the nearest cache
PER_BODY = 8  # contacts that there is room for, for each body


@compiled
def advance(
    state: FloatArray,
    ahead: FloatArray,
    turning: FloatArray,
    shapes: FloatArray,
    bounds: FloatArray,
    grips: FloatArray,
    room: FloatArray,
    steps: tuple[float, float, float],
    touching: BoolArray,
    busy: BoolArray,
    begun: IntArray,
) -> int:
    """Move the bodies of all worlds through the substeps of a period.

    Args:
        state: In and out: columns of :mod:`swarmvision.ground` of the bodies ``n`` of each world, robots
            first, world after world, shape ``(6, w * n)``.
        ahead: Speed of the tracks at the end of each substep (m/s), shape ``(s, w * r)``.
        turning: Their turn rate (rad/s), likewise.
        shapes: From :func:`swarmvision.contacts.shapes.shapes_of`, shape ``(n, 4)``.
        bounds: From :func:`swarmvision.contacts.shapes.bounds_of`, shape ``(2, n)``.
        grips: From :func:`swarmvision.contacts.shapes.shapes_of`, shape ``(n, 4)``.
        room: Half width and half depth of the arena (m) and the root of its walls' friction, shape ``(3,)``.
        steps: Duration of a substep (s); ``lead`` as in :func:`swarmvision.ground.traction`; how much nearer
            two bodies can come to each other in the period (m).
        touching: In and out: whether a body touches another (with a higher number) or a wall in the period,
            ``(w, n, n + 4)``.
        busy: In and out: whether any does, ``(w,)``.
        begun: In and out: contacts of robots begun, with robots, and with walls and things, shape ``(w, 2)``.

    Returns:
        How many numbers of the new state are not finite.
    """
    dt, lead, margin = steps
    worlds, n = len(busy), len(shapes)
    r = ahead.shape[1] // max(worlds, 1)
    pairs = np.empty((ABREAST, max(n * (n - 1) // 2, 1), 2), np.int64)
    near, walled = np.empty(ABREAST, np.int64), np.empty(ABREAST, np.bool_)
    most = PER_BODY * n + WALLS
    who, contacts = np.empty((most, 2), np.int64), np.empty((most, 16))
    world, ease = np.zeros((n + WALLS, 6)), np.zeros((n + WALLS, 2))
    for i in range(n):
        if grips[i, 0] > 0.0:
            ease[i, 0], ease[i, 1] = 1.0 / grips[i, 0], 1.0 / grips[i, 1]
    now = np.empty((ABREAST, n, n + WALLS), np.bool_)
    bad = 0
    for first in range(0, worlds, ABREAST):
        last = min(first + ABREAST, worlds)
        for w in range(first, last):
            near[w - first] = _pair_up(state, w * n, bounds[0], grips, margin, pairs[w - first])
            walled[w - first] = _near_walls(state, w * n, bounds[1], grips, room, margin)
            now[w - first] = False
        for s in range(len(ahead)):
            _roll_all(state, first, last, ahead[s], turning[s], grips, dt, lead)
            for w in range(first, last):
                close = pairs[w - first, : near[w - first]]
                if not walled[w - first] and _near(state, w * n, bounds[0], close) == 0:
                    continue
                _fetch(state, w * n, world)
                count = meet_all(
                    world, shapes, bounds[1], grips, room, r, close, walled[w - first], who, contacts
                )
                if count > 0:
                    resolve(world, ease, count, who, contacts, dt)
                    _put_back(world, state, w * n)
                    for c in range(count):
                        now[w - first, who[c, 0], who[c, 1]] = True
        for w in range(first, last):
            if busy[w] or near[w - first] > 0 or walled[w - first]:
                busy[w] = _count(now[w - first], r, touching[w], begun[w])
        bad += _settle(state, first * n, last * n)
    return bad


@leaf
def _roll_all(
    state: FloatArray,
    first: int,
    last: int,
    ahead: FloatArray,
    turning: FloatArray,
    grips: FloatArray,
    dt: float,
    lead: float,
) -> None:
    """Move the bodies of some worlds through a substep; robots without things in one go."""
    n, worlds = len(grips), state.shape[1] // max(len(grips), 1)
    r = len(ahead) // max(worlds, 1)
    if n == r:
        _roll(
            state, first * n, ahead[first * r : last * r], turning[first * r : last * r], grips, 0, dt, lead
        )
        return
    for w in range(first, last):
        _roll(state, w * n, ahead[w * r : (w + 1) * r], turning[w * r : (w + 1) * r], grips, 0, dt, lead)
        for i in range(r, n):
            _roll(state, w * n + i, REST, REST, grips, i, dt, lead)


@leaf
def _roll(
    state: FloatArray,
    first: int,
    ahead: FloatArray,
    turning: FloatArray,
    grips: FloatArray,
    kind: int,
    dt: float,
    lead: float,
) -> None:
    """Move bodies by their velocity, and let the floor pull them; all have the grip of row ``kind``."""
    last = first + len(ahead)
    x, y, angle = state[X][first:last], state[Y][first:last], state[ANGLE][first:last]
    vx, vy, spin = state[VX][first:last], state[VY][first:last], state[SPIN][first:last]
    if len(ahead) == 0:
        return
    most, most_round = grips[kind, 2] * dt, grips[kind, 3] * dt
    for i in range(len(ahead)):
        x[i] += vx[i] * dt
        y[i] += vy[i] * dt
        angle[i] += spin[i] * dt
        change_x, change_y = pull(angle[i] + spin[i] * lead, vx[i], vy[i], ahead[i], most)
        vx[i] += change_x
        vy[i] += change_y
        spin[i] += pull_round(spin[i], turning[i], most_round)


@leaf
def _fetch(state: FloatArray, first: int, world: FloatArray) -> None:
    """Copy one world's bodies into the first rows of ``(n + 4, 6)``."""
    for c in range(6):
        row = state[c][first : first + len(world) - WALLS]
        for i in range(len(row)):
            world[i, c] = row[i]


@leaf
def _put_back(world: FloatArray, state: FloatArray, first: int) -> None:
    """Copy them back."""
    for c in range(6):
        row = state[c][first : first + len(world) - WALLS]
        for i in range(len(row)):
            row[i] = world[i, c]


@leaf
def _count(now: BoolArray, robots: int, touching: BoolArray, begun: IntArray) -> bool:
    """Note who touches whom, ``(n, n + 4)``, and count what has begun; return whether anybody does."""
    some = False
    for i in range(len(now)):
        for j in range(now.shape[1]):
            if i < robots and now[i, j] and not touching[i, j]:
                begun[0 if j < robots else 1] += 1
            touching[i, j] = now[i, j]
            some = some or now[i, j]
    return some


@leaf
def _settle(state: FloatArray, first: int, last: int) -> int:
    """Wrap the angles of some bodies; return how many of their numbers are not finite."""
    bad, angle = 0, state[ANGLE][first:last]
    for i in range(len(angle)):
        angle[i] = wrapped(angle[i])
    for c in range(6):
        row = state[c][first:last]
        for i in range(len(row)):
            bad += 0 if abs(row[i]) < np.inf else 1
    return bad


@leaf
def _near(state: FloatArray, first: int, bound: FloatArray, pairs: IntArray) -> int:
    """Return how many pairs are so near now that they may touch."""
    x, y, near = state[X][first:], state[Y][first:], 0
    for p in range(len(pairs)):
        i, j = pairs[p, 0], pairs[p, 1]
        dx, dy, reach = x[j] - x[i], y[j] - y[i], bound[i] + bound[j]
        near += 1 if dx * dx + dy * dy < reach * reach else 0
    return near


@leaf
def _pair_up(
    state: FloatArray, first: int, bound: FloatArray, grips: FloatArray, margin: float, pairs: IntArray
) -> int:
    """Fill in the pairs of bodies that can touch in this period, of which one can move; return how many."""
    x, y, count = state[X][first:], state[Y][first:], 0
    for i in range(len(bound)):
        for j in range(i):
            dx, dy = x[j] - x[i], y[j] - y[i]
            reach = bound[i] + bound[j] + margin
            if dx * dx + dy * dy < reach * reach and grips[i, 0] + grips[j, 0] > 0.0:
                pairs[count, 0], pairs[count, 1] = j, i
                count += 1
    return count


@leaf
def _near_walls(
    state: FloatArray, first: int, bound: FloatArray, grips: FloatArray, room: FloatArray, margin: float
) -> bool:
    """Return whether a body that can move can touch a wall in this period."""
    x, y, near = state[X][first:], state[Y][first:], 0
    for i in range(len(bound)):
        reach = bound[i] + margin
        beyond = (abs(x[i]) + reach >= room[0]) | (abs(y[i]) + reach >= room[1])
        near += 1 if beyond & (grips[i, 0] > 0.0) else 0
    return near > 0
