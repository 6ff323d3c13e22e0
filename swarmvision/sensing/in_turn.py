"""Whom the robots of one crowd see, one after the other, nearest first.

Neighbours are taken nearest first, so only who came before can hide, and a robot with a limited number of
slots looks no farther than it must.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled, leaf
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray
from swarmvision.sensing.nearest import gather, measure, ring_of, sort_into_cells, take_nearest
from swarmvision.sensing.shadows import (
    LANES,
    arc_sine,
    half_width,
    marker_shadows,
    may_hide,
    share_in_sight,
    thing_shadows,
)
from swarmvision.sensing.sight import BEARING, HEADING, RANGE, VISIBLE
from swarmvision.trigonometry import direction, sine_cosine, wrapped


@compiled
def look_in_turn(
    pose: FloatArray,
    objects: FloatArray,
    view: tuple[float, float, float, bool, float, float],
    things: FloatArray,
    slots: int,
    who: IntArray,
    seen: FloatArray,
) -> None:
    """Fill in whom every robot of every world sees, nearest first, until its slots are full.

    Args:
        pose: Of the robots, shape ``(w, r, 3)``.
        objects: Poses, shape ``(w, m, 3)``.
        view: Reach, largest bearing, radius, whether anything hides anything, and ``ahead`` of :class:`View`;
            fraction of a marker's width that must be in sight.
        things: As in :class:`View`.
        slots: ``k`` of each robot.
        who: Out: numbers of those seen, -1 where nobody is, shape ``(w * r * k,)``.
        seen: Out: range, bearing, heading, visible fraction; three nan and 0 where nobody is,
            ``(4, w * r * k)``.
    """
    reach, limit, radius, occlusion, ahead, least = view
    worlds, r = pose.shape[0], pose.shape[1]
    grid, begin, filled = np.empty(5), np.empty(r + 2, np.int64), np.empty(r + 2, np.int64)
    number, place = np.zeros(r, np.int64), np.empty(r, np.int64)
    x, y, yaw, sine, cosine = np.empty(r), np.empty(r), np.empty(r), np.empty(r), np.empty(r)
    square, key, order = np.empty(r), np.empty(r, np.int64), np.empty(r, np.int64)
    offset, hiders, bits = np.empty((3, r)), np.zeros((3, r + LANES)), np.empty(r + LANES, np.int64)
    forward, left = np.empty(r * slots), np.empty(r * slots)
    far = reach * reach
    for w in range(worlds):
        sort_into_cells(pose[w], reach, grid, begin, filled, number)
        line_up(pose[w], number, x, y, yaw, sine, cosine)
        base = w * r * slots
        for p in range(r):
            me, my_x, my_y, my_yaw = number[p], x[p], y[p], yaw[p]
            count = measure(p, x, y, grid, begin, square, place)
            step = ring_of(square, count, far, 2 * slots + 4)
            low, high, known, taken, found, first = -1.0, step, 0, 0, 0, me * slots
            while found < slots:
                if taken == known:
                    if low >= far:
                        break
                    known = gather(square, place, count, low, high, known, key, order)
                    low, high = high, min(high + step, far)
                    continue
                other = order[take_nearest(key, known)]
                dx, dy = x[other] - my_x, y[other] - my_y
                gap = np.sqrt(dx * dx + dy * dy)
                ahead_of_me = cosine[p] * dx + sine[p] * dy
                beside_me = cosine[p] * dy - sine[p] * dx
                visible = 1.0
                if occlusion:
                    ux, uy = dx / max(gap, 1e-9), dy / max(gap, 1e-9)
                    size = half_width(gap, radius, ahead)
                    hidden = shadow(taken, ux, uy, size, radius, ahead, offset, hiders, bits)
                    if len(things) > 0:
                        half, bearing = arc_sine(size), direction(beside_me, ahead_of_me)
                        eye = (my_x + ahead * ux, my_y + ahead * uy, my_yaw)
                        hidden |= thing_shadows(bearing, half, gap - ahead, *eye, objects[w], things)
                    offset[0, taken], offset[1, taken], offset[2, taken] = dx, dy, gap
                    visible = share_in_sight(hidden) if hidden else 1.0
                taken += 1
                if visible < least or (limit < np.inf and abs(direction(beside_me, ahead_of_me)) > limit):
                    continue
                slot = first + found
                forward[slot], left[slot] = ahead_of_me, beside_me
                tell(base + slot, number[other], gap, yaw[other] - my_yaw, visible, who, seen)
                found += 1
            for slot in range(first + found, first + slots):
                forward[slot] = left[slot] = np.nan
            clear(base + first + found, base + first + slots, who, seen)
        for slot in range(r * slots):
            seen[BEARING, base + slot] = direction(left[slot], forward[slot])


@leaf
def shadow(
    count: int,
    x: float,
    y: float,
    sine: float,
    radius: float,
    ahead: float,
    offset: FloatArray,
    hiders: FloatArray,
    bits: IntArray,
) -> int:
    """Return the bits of the rays of a marker that any nearer marker covers.

    Args:
        count: Of the nearer ones.
        x: Of the marker's direction, of length 1.
        y: Of the same.
        sine: Of half the marker's width, as the eye sees it.
        radius: Of all markers (m).
        ahead: Of the eye, towards the marker (m).
        offset: Place of the nearer markers from the observer, and their range (m), shape ``(3, n)``.
        hiders: Room to work in, numbers, shape ``(3, n + LANES)``.
        bits: Likewise, shape ``(n + LANES,)``.
    """
    some = 0
    for m in range(count):
        # From the eye to the nearer marker, along the direction of the farther one and across it.
        along = offset[0, m] * x + offset[1, m] * y - ahead
        across = offset[0, m] * y - offset[1, m] * x
        hiders[0, some], hiders[1, some], hiders[2, some] = across, along, sine
        some += 1 if may_hide(across, along, offset[2, m] + ahead, sine, radius) else 0
    hidden = 0
    if some > 0:
        marker_shadows(some, hiders[0], hiders[1], hiders[2], radius, bits)
    for m in range(some):
        hidden |= bits[m]
    return hidden


@leaf
def line_up(
    pose: FloatArray,
    number: IntArray,
    x: FloatArray,
    y: FloatArray,
    yaw: FloatArray,
    sine: FloatArray,
    cosine: FloatArray,
) -> None:
    """Fill in the robots' places and directions in the order of their cells, ``(r,)`` each."""
    for p in range(len(pose)):
        me = number[p]
        x[p], y[p], yaw[p] = pose[me, 0], pose[me, 1], pose[me, 2]
    for p in range(len(pose)):
        sine[p], cosine[p] = sine_cosine(yaw[p])


@leaf
def tell(
    slot: int, number: int, gap: float, heading: float, visible: float, who: IntArray, seen: FloatArray
) -> None:
    """Fill in a neighbour, all but its bearing."""
    who[slot] = number
    seen[RANGE, slot], seen[HEADING, slot], seen[VISIBLE, slot] = gap, wrapped(heading), visible


@leaf
def clear(first: int, last: int, who: IntArray, seen: FloatArray) -> None:
    """Fill in that there is nobody in some slots."""
    for slot in range(first, last):
        who[slot], seen[VISIBLE, slot] = -1, 0.0
        seen[RANGE, slot] = seen[HEADING, slot] = np.nan
