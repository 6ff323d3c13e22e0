"""Who touches whom, where and how deep."""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import leaf
from swarmvision.contacts.shapes import FRICTION, HALF_LENGTH, HALF_WIDTH, RADIUS, WALLS
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray
from swarmvision.ground import ANGLE, X, Y

# Of a contact: where, how deep and how rough; how far so far; levers and stiffness along and across it.
NORMAL_X, NORMAL_Y, ARM_AX, ARM_AY, ARM_BX, ARM_BY, DEPTH, RUB, PUSHED, RUBBED = range(10)
LEVER_A, LEVER_B, SIDE_A, SIDE_B, STIFF, STIFF_ASIDE = range(10, 16)


@leaf
def meet_all(
    world: FloatArray,
    shapes: FloatArray,
    bound: FloatArray,
    grips: FloatArray,
    room: FloatArray,
    robots: int,
    pairs: IntArray,
    walled: bool,
    who: IntArray,
    contacts: FloatArray,
) -> int:
    """Fill in the contacts of one world's bodies, as many as there is room for; return how many."""
    count, most = 0, len(who)
    for p in range(len(pairs)):
        if count < most:
            count += _meet(world, shapes, robots, pairs[p, 0], pairs[p, 1], count, who, contacts)
    for i in range(len(shapes) if walled else 0):
        if grips[i, 0] > 0.0 and count + 2 * WALLS <= most:
            count += _meet_walls(world, shapes, bound[i], room, i, count, who, contacts)
    return count


@leaf
def _meet(
    world: FloatArray,
    shapes: FloatArray,
    robots: int,
    a: int,
    b: int,
    c: int,
    who: IntArray,
    contacts: FloatArray,
) -> int:
    """Fill in the contact of two bodies, if they touch; return 1 or 0. The normal points from a to b.

    A robot and a box are a disc and a box; all others are two discs.
    """
    dx, dy = world[b, X] - world[a, X], world[b, Y] - world[a, Y]
    mine = shapes[a, RADIUS]
    if a < robots <= b and shapes[b, HALF_WIDTH] >= 0.0:
        # A disc and a box: from the disc's centre to the nearest point of the box, in the box's frame.
        cos, sin = np.cos(world[b, ANGLE]), np.sin(world[b, ANGLE])
        x, y = -cos * dx - sin * dy, sin * dx - cos * dy
        half_x, half_y = shapes[b, HALF_LENGTH], shapes[b, HALF_WIDTH]
        px, py = min(max(x, -half_x), half_x), min(max(y, -half_y), half_y)
        out_x, out_y = x - px, y - py
        gap = np.sqrt(out_x * out_x + out_y * out_y)
        if gap >= mine:
            return 0
        if gap > 1e-12:
            depth, nx, ny = mine - gap, -out_x / gap, -out_y / gap
        elif half_x - abs(x) < half_y - abs(y):  # the centre is inside: out by the nearest side
            depth, nx, ny = mine + half_x - abs(x), -1.0 if x > 0.0 else 1.0, 0.0
        else:
            depth, nx, ny = mine + half_y - abs(y), 0.0, -1.0 if y > 0.0 else 1.0
        nx, ny = cos * nx - sin * ny, sin * nx + cos * ny
        bx, by = cos * px - sin * py, sin * px + cos * py
        ax, ay = dx + bx, dy + by
    else:
        gap = np.sqrt(dx * dx + dy * dy)
        depth = mine + shapes[b, RADIUS] - gap
        if depth <= 0.0:
            return 0
        nx, ny = (dx / gap, dy / gap) if gap > 1e-12 else (1.0, 0.0)
        ax, ay = nx * mine, ny * mine
        bx, by = ax - dx, ay - dy
    _note(a, b, c, nx, ny, ax, ay, bx, by, depth, shapes[a, FRICTION] * shapes[b, FRICTION], who, contacts)
    return 1


@leaf
def _meet_walls(
    world: FloatArray,
    shapes: FloatArray,
    bound: float,
    room: FloatArray,
    a: int,
    first: int,
    who: IntArray,
    contacts: FloatArray,
) -> int:
    """Fill in the contacts of a body with walls, up to two of its corners each; return how many."""
    x, y, n = world[a, X], world[a, Y], len(shapes)
    count = 0
    if abs(x) + bound < room[0] and abs(y) + bound < room[1]:
        return 0
    rub = shapes[a, FRICTION] * room[2]
    cos, sin = np.cos(world[a, ANGLE]), np.sin(world[a, ANGLE])
    for wall in range(WALLS):
        nx = (-1.0, 1.0, 0.0, 0.0)[wall]
        ny = (0.0, 0.0, -1.0, 1.0)[wall]
        beyond = x * nx + y * ny - room[wall // 2]
        if shapes[a, HALF_WIDTH] < 0.0:
            depth = beyond + shapes[a, RADIUS]
            if depth > 0.0:
                arm = shapes[a, RADIUS]
                _note(
                    a,
                    n + wall,
                    first + count,
                    nx,
                    ny,
                    nx * arm,
                    ny * arm,
                    0.0,
                    0.0,
                    depth,
                    rub,
                    who,
                    contacts,
                )
                count += 1
            continue
        for corner in range(4):
            along = shapes[a, HALF_LENGTH] * (1.0 if corner < 2 else -1.0)
            aside = shapes[a, HALF_WIDTH] * (1.0 if corner % 2 == 0 else -1.0)
            ax, ay = cos * along - sin * aside, sin * along + cos * aside
            depth = beyond + ax * nx + ay * ny
            if depth > 0.0:
                _note(a, n + wall, first + count, nx, ny, ax, ay, 0.0, 0.0, depth, rub, who, contacts)
                count += 1
                if count == 2 * WALLS:
                    return count
    return count


@leaf
def _note(
    a: int,
    b: int,
    c: int,
    nx: float,
    ny: float,
    ax: float,
    ay: float,
    bx: float,
    by: float,
    depth: float,
    rub: float,
    who: IntArray,
    contacts: FloatArray,
) -> None:
    who[c, 0], who[c, 1] = a, b
    row = contacts[c]
    row[NORMAL_X], row[NORMAL_Y], row[DEPTH], row[RUB] = nx, ny, depth, rub
    row[ARM_AX], row[ARM_AY], row[ARM_BX], row[ARM_BY] = ax, ay, bx, by
    row[PUSHED] = row[RUBBED] = 0.0
