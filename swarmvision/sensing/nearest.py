"""Who is near whom: the others of every robot within reach, a ring at a time, nearest first.

Many robots are sorted into square cells, so that whom to ask is found without asking everybody. Their
distances are taken in one go; of those within reach only the nearest few are put in order, and more only
when they are asked for, because a robot with a limited number of slots looks no farther than it must.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import leaf
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray

FEW = 32  # robots that are not worth sorting into cells
RING = 32  # robots that a ring is to have at most, about
RANK = (1 << 16) - 1  # the bits of a key that tell the place in a ring
TAKEN = np.iinfo(np.int64).max
HALVINGS = 30  # tries to make a ring so narrow


@leaf
def sort_into_cells(
    pose: FloatArray,
    reach: float,
    grid: FloatArray,
    begin: IntArray,
    filled: IntArray,
    number: IntArray,
) -> None:
    """Sort robots into square cells no smaller than the reach; few robots are one cell, wherever they are.

    Args:
        pose: Shape ``(r, 3)``.
        reach: m.
        grid: Out: left, bottom, size, columns and rows, ``(5,)``.
        begin: Out: where each cell's robots begin, ``(r + 2,)`` of which some are not used.
        filled: Room to work in, likewise.
        number: Out: the robots, cell by cell, by number in each, ``(r,)`` and more.
    """
    r = len(pose)
    begin[0] = 0
    if r <= FEW:
        grid[0], grid[1], grid[2], grid[3], grid[4] = 0.0, 0.0, np.inf, 1.0, 1.0
        begin[1] = r
        for i in range(r):
            number[i] = i
        return
    left, bottom, right, top = pose[0, 0], pose[0, 1], pose[0, 0], pose[0, 1]
    for i in range(r):
        left, right = min(left, pose[i, 0]), max(right, pose[i, 0])
        bottom, top = min(bottom, pose[i, 1]), max(top, pose[i, 1])
    side = int(np.sqrt(r))  # more cells than that in a row would be empty ones
    size = max(reach, 1e-6, (right - left) / side, (top - bottom) / side) * (1.0 + 1e-9)
    columns, rows = int((right - left) / size) + 1, int((top - bottom) / size) + 1
    grid[0], grid[1], grid[2], grid[3], grid[4] = left, bottom, size, columns, rows
    begin[: columns * rows + 1] = 0
    for i in range(r):
        begin[cell_of(pose[i, 0], pose[i, 1], grid) + 1] += 1
    for c in range(columns * rows):
        begin[c + 1] += begin[c]
        filled[c] = begin[c]
    for i in range(r):
        c = cell_of(pose[i, 0], pose[i, 1], grid)
        number[filled[c]] = i
        filled[c] += 1


@leaf
def cell_of(x: float, y: float, grid: FloatArray) -> int:
    """Return the number of the cell of a place."""
    return int((y - grid[1]) / grid[2]) * int(grid[3]) + int((x - grid[0]) / grid[2])


@leaf
def measure(
    me: int,
    x: FloatArray,
    y: FloatArray,
    grid: FloatArray,
    begin: IntArray,
    square: FloatArray,
    place: IntArray,
) -> int:
    """Fill in the squared distance (m^2) from a robot to those in the cells around, nan to itself.

    Args:
        me: Its place in the order of the cells.
        x: Of all in that order (m).
        y: Of the same.
        grid: From :func:`sort_into_cells`, and so the next.
        begin: Where the cells begin.
        square: Out.
        place: Out: who it is, by the place in the order.

    Returns:
        How many there are.
    """
    columns, rows = int(grid[3]), int(grid[4])
    my_x, my_y = x[me], y[me]
    column, row = 0, 0
    if columns * rows > 1:
        column, row = int((my_x - grid[0]) / grid[2]), int((my_y - grid[1]) / grid[2])
    count = 0
    for r in range(max(row - 1, 0), min(row + 2, rows)):
        first = begin[r * columns + max(column - 1, 0)]
        last = begin[r * columns + min(column + 1, columns - 1) + 1]
        # As slices: numbers that begin at 0 are never from the end, which is asked of others each time.
        xs, ys, squares, places = x[first:last], y[first:last], square[count:], place[count:]
        for n in range(len(xs)):
            dx, dy = xs[n] - my_x, ys[n] - my_y
            squares[n] = dx * dx + dy * dy
            places[n] = first + n
        if first <= me < last:
            square[count + me - first] = np.nan
        count += last - first
    return count


@leaf
def ring_of(square: FloatArray, count: int, far: float, wanted: int) -> float:
    """Return the area (m^2, without pi) of a disc that holds about so many, and ``far`` at most."""
    if count <= 2 * min(wanted, RING):
        return far
    wanted = min(wanted, RING)
    inside = within(square, count, far)
    if inside <= 2 * wanted:
        return far
    high = far * wanted / inside
    for _ in range(HALVINGS):
        if within(square, count, high) <= 3 * wanted:
            break
        high /= 2.0
    return high


@leaf
def within(square: FloatArray, count: int, high: float) -> int:
    """Return how many of the first ``count`` are no farther."""
    inside = 0
    for n in range(count):
        inside += 1 if square[n] <= high else 0
    return inside


@leaf
def gather(
    square: FloatArray,
    place: IntArray,
    count: int,
    low: float,
    high: float,
    first: int,
    key: IntArray,
    who: IntArray,
) -> int:
    """Append a ring's robots, in no order; return how many there are then.

    Args:
        square: From :func:`measure`, and so the next two.
        place: Who it is.
        count: How many there are.
        low: Squared inner radius of the ring (m^2), which is outside.
        high: Squared outer radius, which is inside.
        first: How many there are already.
        key: In and out: numbers that grow with the distance; their last bits are the place in this list.
        who: In and out: the place of each in the order of the cells.
    """
    bits, some = square.view(np.int64), first  # of positive numbers, they are in the same order
    for n in range(count):
        if low < square[n] <= high:
            key[some] = (bits[n] | RANK) ^ (RANK ^ some)
            who[some] = place[n]
            some += 1
    return some


@leaf
def take_nearest(key: IntArray, count: int) -> int:
    """Return the place in the list of the nearest that is not taken yet, and take it.

    Of those equally near, to 11 digits, the first.
    """
    nearest = TAKEN
    for n in range(count):
        nearest = min(nearest, key[n])
    found = nearest & RANK
    key[found] = TAKEN
    return found
