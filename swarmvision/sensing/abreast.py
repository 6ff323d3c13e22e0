"""Whom the robots of many small worlds see: the same robot of all worlds at once.

Every number of this computation is a row with an entry for each world, so that a processor takes several
worlds in one instruction. All pairs are computed; in worlds of up to ``FEW`` robots that is less than
finding out which to leave out. Only where two markers come near each other in bearing is one world looked
at for itself.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import apart, compiled, leaf
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray
from swarmvision.sensing.shadows import (
    arc_sine,
    half_width,
    marker_shadows,
    share_in_sight,
    thing_shadows,
)
from swarmvision.sensing.sight import BEARING, HEADING, RANGE, VISIBLE
from swarmvision.trigonometry import direction, sine_cosine, wrapped

FEW = 16  # robots
ABREAST = 64  # worlds: their rows fit the nearest cache
ROOM = 256  # pairs of markers, of which one may hide the other, that are looked at together
X, Y, YAW, SINE, COSINE = range(5)  # of a robot in the world
DX, DY, GAP, SIZE, IN_SIGHT, AT, FACING = range(
    7
)  # of a neighbour: place, range, sine of its half width, ...


@compiled
def look_abreast(
    pose: FloatArray,
    objects: FloatArray,
    view: tuple[float, float, float, bool, float, float],
    things: FloatArray,
    slots: int,
    who: IntArray,
    seen: FloatArray,
) -> None:
    """Fill in whom every robot of every world sees; as :func:`swarmvision.sensing.in_turn.look_in_turn`."""
    reach, limit, radius, occlusion, ahead, least = view
    worlds, r = pose.shape[0], pose.shape[1]
    robot, other = np.empty((r, 5, ABREAST)), np.empty((r, 7, ABREAST))
    close, counts = np.empty((r, ABREAST), np.int64), np.empty((r, ABREAST), np.int64)
    rank = np.empty((r, ABREAST), np.int64)
    hiders, spot, bits = np.zeros((3, ROOM)), np.empty(ROOM, np.int64), np.empty(ROOM, np.int64)
    dark = np.empty((r, ABREAST), np.int64)
    for first in range(0, worlds, ABREAST):
        lanes = min(ABREAST, worlds - first)
        place_robots(pose[first:], lanes, robot)
        for me in range(r):
            measure_all(me, lanes, radius, ahead, robot, other)
            if occlusion:
                compare_all(me, lanes, reach, radius, ahead, other, close)
                dark[:] = 0
                hide(me, lanes, close, other, radius, ahead, hiders, spot, bits, dark)
                if len(things) > 0:
                    hide_behind_things(me, lanes, robot, other, reach, ahead, objects[first:], things, dark)
            # Here, where the arrays are made and known to be apart: elsewhere these loops are no vector code.
            for j in range(r):
                if j != me:
                    mine, theirs = robot[me, YAW], robot[j, YAW]
                    find(mine, theirs, lanes, reach, limit, least, other[j], counts[j], rank[j])
            for j in range(r):
                for k in range(j):
                    if me not in (j, k):
                        line_up(other[k, GAP], other[j, GAP], lanes, counts[k], counts[j], rank[k], rank[j])
            tell((first * r + me) * slots, r * slots, lanes, me, slots, other, counts, rank, who, seen)


@leaf
def measure_all(
    me: int, lanes: int, radius: float, ahead: float, robot: FloatArray, other: FloatArray
) -> None:
    """Fill in where a robot's neighbours are, ``(r, 7, lanes)``."""
    for j in range(len(other)):
        if j != me:
            measure(robot[me], robot[j], lanes, radius, ahead, other[j])


@apart
def compare_all(
    me: int, lanes: int, reach: float, radius: float, ahead: float, other: FloatArray, close: IntArray
) -> None:
    """Fill in, for each neighbour, the bits of those before it by number that it may hide, or they it."""
    close[:] = 0
    for j in range(len(other)):
        for k in range(j):
            if me not in (j, k):
                compare(other[k], other[j], 1 << k, lanes, reach, radius, ahead, close[j])


@leaf
def place_robots(pose: FloatArray, lanes: int, robot: FloatArray) -> None:
    """Fill in the robots' rows ``(r, 5, lanes)`` from poses ``(w, r, 3)``."""
    for j in range(len(robot)):
        x, y, yaw, sine, cosine = robot[j, X], robot[j, Y], robot[j, YAW], robot[j, SINE], robot[j, COSINE]
        for w in range(lanes):
            x[w], y[w], yaw[w] = pose[w, j, 0], pose[w, j, 1], pose[w, j, 2]
        for w in range(lanes):
            sine[w], cosine[w] = sine_cosine(yaw[w])


@leaf
def measure(
    mine: FloatArray, theirs: FloatArray, lanes: int, radius: float, ahead: float, other: FloatArray
) -> None:
    """Fill in where a neighbour is in the robot's frame, how far, and how wide it looks, ``(7, lanes)``."""
    x, y, sine, cosine = mine[X], mine[Y], mine[SINE], mine[COSINE]
    to_x, to_y = theirs[X], theirs[Y]
    dx, dy, gap, size, in_sight = other[DX], other[DY], other[GAP], other[SIZE], other[IN_SIGHT]
    for w in range(lanes):
        off_x, off_y = to_x[w] - x[w], to_y[w] - y[w]
        dx[w] = cosine[w] * off_x + sine[w] * off_y
        dy[w] = cosine[w] * off_y - sine[w] * off_x
        gap[w] = np.sqrt(off_x * off_x + off_y * off_y)
        size[w] = half_width(gap[w], radius, ahead)
        in_sight[w] = 1.0


@leaf
def compare(
    one: FloatArray,
    two: FloatArray,
    bit: int,
    lanes: int,
    reach: float,
    radius: float,
    ahead: float,
    close: IntArray,
) -> None:
    """Set a bit where the nearer of two markers may hide some of the farther, if that is within reach."""
    x1, y1, gap1, size1 = one[DX], one[DY], one[GAP], one[SIZE]
    x2, y2, gap2, size2 = two[DX], two[DY], two[GAP], two[SIZE]
    for w in range(lanes):
        behind = gap1[w] > gap2[w]
        far, near = (gap1[w], gap2[w]) if behind else (gap2[w], gap1[w])
        size = size1[w] if behind else size2[w]
        # Both times the farther one's range: no division.
        across = abs(x1[w] * y2[w] - y1[w] * x2[w])
        along = x1[w] * x2[w] + y1[w] * y2[w]
        wide = far * (radius + size * (near + ahead))
        meet = ((across < wide) & (along > far * (ahead - 2.0 * radius))) | (size >= 0.5)
        close[w] |= bit if meet & (near < far) & (far <= reach) else 0


@leaf
def hide(
    me: int,
    lanes: int,
    close: IntArray,
    other: FloatArray,
    radius: float,
    ahead: float,
    hiders: FloatArray,
    spot: IntArray,
    bits: IntArray,
    dark: IntArray,
) -> None:
    """Fill in how much markers leave in sight of those that are near others in bearing.

    Args:
        me: The observer.
        lanes: How many worlds.
        close: From :func:`compare_all`, shape ``(r, lanes)``.
        other: In and out, shape ``(r, 7, lanes)``.
        radius: Of all markers (m).
        ahead: Of the eye (m).
        hiders: Room to work in, shape ``(3, ROOM)``.
        spot: Likewise, shape ``(ROOM,)``.
        bits: Likewise.
        dark: Out: rays that are covered, of those that are near another, ``(r, lanes)``.
    """
    some = 0
    for j in range(len(other)):
        for w in range(lanes):
            if close[j, w] == 0:
                continue
            if some + j > ROOM:
                darken(some, other, radius, hiders, spot, bits, dark)
                some = 0
            for k in range(j):
                if (close[j, w] >> k) & 1 == 0:
                    continue
                behind = other[k, GAP, w] > other[j, GAP, w]
                far, near = (k, j) if behind else (j, k)
                per_gap = 1.0 / max(other[far, GAP, w], 1e-9)
                ux, uy = other[far, DX, w] * per_gap, other[far, DY, w] * per_gap
                hiders[0, some] = other[near, DX, w] * uy - other[near, DY, w] * ux
                hiders[1, some] = other[near, DX, w] * ux + other[near, DY, w] * uy - ahead
                hiders[2, some] = other[far, SIZE, w]
                spot[some] = far * ABREAST + w
                some += 1
    darken(some, other, radius, hiders, spot, bits, dark)


@leaf
def darken(
    some: int,
    other: FloatArray,
    radius: float,
    hiders: FloatArray,
    spot: IntArray,
    bits: IntArray,
    dark: IntArray,
) -> None:
    """Add what some markers hide of others."""
    marker_shadows(some, hiders[0], hiders[1], hiders[2], radius, bits)
    for n in range(some):
        j, w = spot[n] // ABREAST, spot[n] % ABREAST
        dark[j, w] |= bits[n]
        other[j, IN_SIGHT, w] = share_in_sight(dark[j, w])


@leaf
def hide_behind_things(
    me: int,
    lanes: int,
    robot: FloatArray,
    other: FloatArray,
    reach: float,
    ahead: float,
    objects: FloatArray,
    things: FloatArray,
    dark: IntArray,
) -> None:
    """Fill in how much markers and things leave in sight of everybody, ``(r, 7, lanes)``."""
    for w in range(lanes):
        cosine, sine = robot[me, COSINE, w], robot[me, SINE, w]
        for j in range(len(other)):
            gap = other[j, GAP, w]
            if j == me or gap > reach:
                continue
            far = max(gap, 1e-9)
            ux, uy = other[j, DX, w] / far, other[j, DY, w] / far
            eye_x = robot[me, X, w] + ahead * (cosine * ux - sine * uy)
            eye_y = robot[me, Y, w] + ahead * (sine * ux + cosine * uy)
            half, bearing = arc_sine(other[j, SIZE, w]), direction(uy, ux)
            dark[j, w] |= thing_shadows(
                bearing, half, gap - ahead, eye_x, eye_y, robot[me, YAW, w], objects[w], things
            )
            other[j, IN_SIGHT, w] = share_in_sight(dark[j, w])


@leaf
def find(
    mine: FloatArray,
    theirs: FloatArray,
    lanes: int,
    reach: float,
    limit: float,
    least: float,
    other: FloatArray,
    counts: IntArray,
    rank: IntArray,
) -> None:
    """Fill in bearing and heading of a neighbour, and whether it counts; nobody is ranked before it yet."""
    dx, dy, gap, in_sight = other[DX], other[DY], other[GAP], other[IN_SIGHT]
    at, facing = other[AT], other[FACING]
    for w in range(lanes):
        at[w] = direction(dy[w], dx[w])
        facing[w] = wrapped(theirs[w] - mine[w])
        there = (gap[w] <= reach) & (in_sight[w] >= least) & (abs(at[w]) <= limit)
        counts[w] = 1 if there else 0
        rank[w] = 0


@leaf
def line_up(
    one: FloatArray,
    two: FloatArray,
    lanes: int,
    counts_one: IntArray,
    counts_two: IntArray,
    rank_one: IntArray,
    rank_two: IntArray,
) -> None:
    """Rank the nearer of two neighbours before the other; of equals the first."""
    for w in range(lanes):
        before = one[w] <= two[w]
        rank_two[w] += counts_one[w] if before else 0
        rank_one[w] += 0 if before else counts_two[w]


@leaf
def tell(
    first: int,
    step: int,
    lanes: int,
    me: int,
    slots: int,
    other: FloatArray,
    counts: IntArray,
    rank: IntArray,
    who: IntArray,
    seen: FloatArray,
) -> None:
    """Fill in the slots of one robot of each world: ``first`` is its first slot in the first world."""
    ranges, bearings, headings, shares = seen[RANGE], seen[BEARING], seen[HEADING], seen[VISIBLE]
    for w in range(lanes):
        begin, found = first + w * step, 0
        for j in range(len(other)):
            if j == me or counts[j, w] == 0:
                continue
            found += 1
            if rank[j, w] < slots:
                slot = begin + rank[j, w]
                who[slot], shares[slot] = j, other[j, IN_SIGHT, w]
                ranges[slot], bearings[slot] = other[j, GAP, w], other[j, AT, w]
                headings[slot] = other[j, FACING, w]
        for slot in range(begin + found, begin + slots):
            who[slot], shares[slot] = -1, 0.0
            ranges[slot] = bearings[slot] = headings[slot] = np.nan
