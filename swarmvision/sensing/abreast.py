"""Whom the robots of many small worlds see: the same robot of all worlds at once.

Every number of this computation is a row with an entry for each world, so that a processor takes several
worlds in one instruction. All pairs are computed; in worlds of up to ``FEW`` robots that is less than
finding out which to leave out. Only where two markers come near each other in bearing is one world looked
at for itself.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled, leaf
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray
from swarmvision.sensing.shadows import (
    RAYS,
    arc_sine,
    half_width,
    marker_shadow,
    may_hide,
    share_in_sight,
    spread,
    thing_shadows,
)
from swarmvision.sensing.sight import BEARING, HEADING, RANGE, VISIBLE
from swarmvision.trigonometry import direction, sine_cosine, wrapped

FEW = 16  # robots
ABREAST = 64  # worlds: their rows fit the nearest cache
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
    close, counts, rank = (
        np.empty(ABREAST, np.int64),
        np.empty((r, ABREAST), np.int64),
        np.empty((r, ABREAST), np.int64),
    )
    rays = np.empty((2, len(RAYS)))
    for first in range(0, worlds, ABREAST):
        lanes = min(ABREAST, worlds - first)
        place_robots(pose[first:], lanes, robot)
        for me in range(r):
            measure_all(me, lanes, radius, ahead, robot, other)
            if occlusion:
                compare_all(me, lanes, radius, ahead, other, -1 if len(things) > 0 else 0, close)
                hide(close, lanes, me, robot, other, reach, radius, ahead, objects[first:], things, rays)
            rank_all(me, lanes, reach, limit, least, robot, other, counts, rank)
            tell((first * r + me) * slots, r * slots, lanes, me, slots, other, counts, rank, who, seen)


@leaf
def measure_all(
    me: int, lanes: int, radius: float, ahead: float, robot: FloatArray, other: FloatArray
) -> None:
    """Fill in where a robot's neighbours are, ``(r, 7, lanes)``."""
    for j in range(len(other)):
        if j != me:
            measure(robot[me], robot[j], lanes, radius, ahead, other[j])


@leaf
def compare_all(
    me: int, lanes: int, radius: float, ahead: float, other: FloatArray, bits: int, close: IntArray
) -> None:
    """Fill in the bits of the neighbours of which others may hide some; ``bits`` are set in any case."""
    close[:] = bits
    for j in range(len(other)):
        for k in range(j):
            if me not in (j, k):
                compare(other[k], other[j], 1 << k, 1 << j, lanes, radius, ahead, close)


@leaf
def rank_all(
    me: int,
    lanes: int,
    reach: float,
    limit: float,
    least: float,
    robot: FloatArray,
    other: FloatArray,
    counts: IntArray,
    rank: IntArray,
) -> None:
    """Fill in where the neighbours are seen, who counts, and how many of those are nearer."""
    for j in range(len(other)):
        if j != me:
            mine, theirs = robot[me, YAW], robot[j, YAW]
            find(mine, theirs, lanes, reach, limit, least, other[j], counts[j], rank[j])
    for j in range(len(other)):
        for k in range(j):
            if me not in (j, k):
                line_up(other[k, GAP], other[j, GAP], lanes, counts[k], counts[j], rank[k], rank[j])


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
    bit_one: int,
    bit_two: int,
    lanes: int,
    radius: float,
    ahead: float,
    close: IntArray,
) -> None:
    """Set the bit of the farther of two markers where the nearer may hide some of it."""
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
        bit = bit_one if behind else bit_two
        close[w] |= bit if meet else 0


@leaf
def hide(
    close: IntArray,
    lanes: int,
    me: int,
    robot: FloatArray,
    other: FloatArray,
    reach: float,
    radius: float,
    ahead: float,
    objects: FloatArray,
    things: FloatArray,
    rays: FloatArray,
) -> None:
    """Fill in how much is in sight of the markers whose bits are set."""
    r = len(other)
    for w in range(lanes):
        if close[w] == 0:
            continue
        for j in range(r):
            gap = other[j, GAP, w]
            if j == me or (close[w] >> j) & 1 == 0 or gap > reach:
                continue
            far, size, hidden, drawn = max(gap, 1e-9), other[j, SIZE, w], 0, False
            ux, uy = other[j, DX, w] / far, other[j, DY, w] / far
            for k in range(r):
                near = other[k, GAP, w]
                if k in (me, j) or near >= gap:
                    continue
                along = other[k, DX, w] * ux + other[k, DY, w] * uy - ahead
                across = other[k, DX, w] * uy - other[k, DY, w] * ux
                if may_hide(across, along, near + ahead, size, radius):
                    if not drawn:
                        spread(arc_sine(size), rays)
                        drawn = True
                    hidden |= marker_shadow(across, along, radius, rays)
            if len(things) > 0:
                cosine, sine = robot[me, COSINE, w], robot[me, SINE, w]
                eye_x = robot[me, X, w] + ahead * (cosine * ux - sine * uy)
                eye_y = robot[me, Y, w] + ahead * (sine * ux + cosine * uy)
                half, bearing = arc_sine(size), direction(uy, ux)
                hidden |= thing_shadows(
                    bearing, half, gap - ahead, eye_x, eye_y, robot[me, YAW, w], objects[w], things
                )
            other[j, IN_SIGHT, w] = share_in_sight(hidden)


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
