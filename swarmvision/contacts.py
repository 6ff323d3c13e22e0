"""Many worlds' bodies at once, pushed apart where they touch: a contact model without pymunk.

Motion and traction are :mod:`swarmvision.world`'s, in the same order; without contacts the two agree to
rounding when their substeps are equal. Contacts are simpler: robots meet each other and things as discs
of their own area, walls as the boxes that they are. Impulses are found by a few rounds over
all contacts (sequential impulses with Coulomb friction, as in Chipmunk, without warm starts and without
bounce), and what still overlaps is moved apart a little in every substep, at Chipmunk's rate.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.config.arena import ArenaConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import BoolArray, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.ground import ANGLE, SPIN, VX, VY, X, Y, robot_grip, thing_grip, traction

ROUNDS = 6  # over the contacts of a substep
OVERLAP = 1e-4  # m that bodies may overlap
LEFT_AFTER_A_SECOND = 0.9**60  # share of an overlap that is left after 1 s: Chipmunk's collision_bias
WALLS = 4
PER_BODY = 8  # contacts that there is room for, for each body
HALF_LENGTH, HALF_WIDTH, RADIUS, FRICTION = range(4)  # columns of a shape; half width is -1 for a disc
NORMAL_X, NORMAL_Y, ARM_AX, ARM_AY, ARM_BX, ARM_BY, DEPTH, RUB, PUSHED, RUBBED = range(10)  # of a contact


def shapes_of(robots: int, robot: RobotConfig, arena: ArenaConfig) -> tuple[FloatArray, FloatArray]:
    """Return the shapes ``(n, 4)`` and the grips ``(n, 4)`` of robots and objects.

    A shape is half length and half width (m), -1 for a disc; the radius of the disc of its area (m); and the
    root of its friction, two of which multiply.
    """
    box = (robot.length / 2.0, robot.width / 2.0, np.sqrt(robot.length * robot.width / np.pi))
    moment = robot.mass * (robot.length**2 + robot.width**2) / 12.0
    shapes = [(*box, np.sqrt(robot.friction))] * robots
    grips = [robot_grip(robot, moment)] * robots
    for thing in arena.objects:
        mass = thing.mass or 1.0
        if isinstance(thing, DiscConfig):
            moment = mass * thing.radius**2 / 2.0
            shape = (thing.radius, -1.0, thing.radius)
        else:
            moment = mass * (thing.length**2 + thing.width**2) / 12.0
            shape = (thing.length / 2.0, thing.width / 2.0, np.sqrt(thing.length * thing.width / np.pi))
        shapes.append((*shape, np.sqrt(arena.wall_friction)))
        grips.append(thing_grip(thing, moment, arena.floor_friction))
    return np.array(shapes).reshape(-1, 4), np.array(grips).reshape(-1, 4)


@compiled
def advance(
    state: FloatArray,
    twists: FloatArray,
    shapes: FloatArray,
    grips: FloatArray,
    room: FloatArray,
    dt: float,
    lead: float,
    margin: float,
    touched: BoolArray,
) -> None:
    """Move the bodies of all worlds through the substeps of a period.

    Args:
        state: In and out: bodies as in :mod:`swarmvision.ground`, robots first, shape ``(w, n, 6)``.
        twists: Speed and turn rate of the tracks at the end of each substep, shape ``(s, w, r, 2)``.
        shapes: From :func:`shapes_of`, shape ``(n, 4)``.
        grips: Likewise, shape ``(n, 4)``.
        room: Half width and half depth of the arena (m) and the root of its walls' friction, shape ``(3,)``.
        dt: Of a substep (s).
        lead: As in :func:`swarmvision.ground.traction`.
        margin: How much nearer two bodies can come to each other in the period (m).
        touched: Out: whether a body touched another (with a higher number) or a wall, ``(w, n, n + 4)``.
    """
    n = state.shape[1]
    r = twists.shape[2]
    pairs = np.empty((max(n * (n - 1) // 2, 1), 2), np.int64)
    most = PER_BODY * n + WALLS
    who, contacts = np.empty((most, 2), np.int64), np.empty((most, 10))
    twist, force = np.zeros((n, 2)), np.zeros((n, 3))
    for w in range(len(state)):
        world = state[w]
        near = _near(world, shapes, grips, margin, pairs)
        touched[w] = False
        for s in range(len(twists)):
            for i in range(n):
                world[i, X] += world[i, VX] * dt
                world[i, Y] += world[i, VY] * dt
                world[i, ANGLE] += world[i, SPIN] * dt
            twist[:r] = twists[s, w]
            traction(world, twist, grips, dt, lead, force)
            for i in range(n):
                if grips[i, 0] > 0.0:
                    world[i, VX] += force[i, 0] / grips[i, 0] * dt
                    world[i, VY] += force[i, 1] / grips[i, 0] * dt
                    world[i, SPIN] += force[i, 2] / grips[i, 1] * dt
            count = 0
            for p in range(near):
                if count < most:
                    count += _meet(world, shapes, r, pairs[p, 0], pairs[p, 1], count, who, contacts)
            for i in range(n):
                if grips[i, 0] > 0.0 and count + 2 * WALLS <= most:
                    count += _meet_walls(world, shapes, room, i, count, who, contacts)
            if count > 0:
                _resolve(world, grips, count, who, contacts, dt)
                for c in range(count):
                    touched[w, who[c, 0], who[c, 1]] = True


@compiled
def _near(world: FloatArray, shapes: FloatArray, grips: FloatArray, margin: float, pairs: IntArray) -> int:
    """Fill in the pairs of bodies that can touch in this period, of which one can move; return how many."""
    count = 0
    for i in range(len(world)):
        for j in range(i + 1, len(world)):
            dx, dy = world[j, X] - world[i, X], world[j, Y] - world[i, Y]
            reach = _bound(shapes[i]) + _bound(shapes[j]) + margin
            if dx * dx + dy * dy < reach * reach and grips[i, 0] + grips[j, 0] > 0.0:
                pairs[count, 0], pairs[count, 1] = i, j
                count += 1
    return count


@compiled
def _bound(shape: FloatArray) -> float:
    """Return the radius (m) of a circle round a shape, roughly: no less than it and its disc."""
    return float(max(shape[HALF_LENGTH] + max(shape[HALF_WIDTH], 0.0), shape[RADIUS]))


@compiled
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


@compiled
def _meet_walls(
    world: FloatArray,
    shapes: FloatArray,
    room: FloatArray,
    a: int,
    first: int,
    who: IntArray,
    contacts: FloatArray,
) -> int:
    """Fill in the contacts of a body with walls, up to two of its corners each; return how many."""
    x, y, n = world[a, X], world[a, Y], len(world)
    bound = _bound(shapes[a])
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


@compiled
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


@compiled
def _resolve(
    world: FloatArray, grips: FloatArray, count: int, who: IntArray, contacts: FloatArray, dt: float
) -> None:
    """Stop what approaches, within friction, and move apart some of what overlaps."""
    for _ in range(ROUNDS):
        for c in range(count):
            row = contacts[c]
            pushed = _impulse(
                world, grips, who[c], row, row[NORMAL_X], row[NORMAL_Y], row[PUSHED], 0.0, np.inf
            )
            row[PUSHED] = pushed
            most = row[RUB] * pushed
            row[RUBBED] = _impulse(
                world, grips, who[c], row, -row[NORMAL_Y], row[NORMAL_X], row[RUBBED], -most, most
            )
    share = 1.0 - LEFT_AFTER_A_SECOND**dt
    for c in range(count):
        a, b = who[c, 0], who[c, 1]
        mine, theirs = _ease(grips, a), _ease(grips, b)
        if mine + theirs == 0.0:
            continue
        push = share * max(contacts[c, DEPTH] - OVERLAP, 0.0) / (mine + theirs)
        for axis in range(2):
            world[a, axis] -= push * mine * contacts[c, axis]
            if theirs > 0.0:
                world[b, axis] += push * theirs * contacts[c, axis]


@compiled
def _ease(grips: FloatArray, i: int) -> float:
    """Return how easily a body moves (1/kg); 0 for walls and what is fixed."""
    if i >= len(grips) or grips[i, 0] == 0.0:
        return 0.0
    return 1.0 / float(grips[i, 0])


@compiled
def _impulse(
    world: FloatArray,
    grips: FloatArray,
    pair: IntArray,
    row: FloatArray,
    ux: float,
    uy: float,
    total: float,
    least: float,
    most: float,
) -> float:
    """Push two bodies along a direction until they stop approaching there; return the impulse so far (N s).

    Args:
        world: Bodies, shape ``(n, 6)``.
        grips: Shape ``(n, 4)``.
        pair: The two bodies; the second may be a wall.
        row: Of the contact.
        ux: Direction from the first to the second.
        uy: The same.
        total: Impulse so far.
        least: Bound of it.
        most: Bound of it.
    """
    a, b = pair[0], pair[1]
    mine, theirs = _ease(grips, a), _ease(grips, b)
    turn_a, turn_b = row[ARM_AX] * uy - row[ARM_AY] * ux, row[ARM_BX] * uy - row[ARM_BY] * ux
    spin_a = 1.0 / grips[a, 1] if mine > 0.0 else 0.0
    spin_b = 1.0 / grips[b, 1] if theirs > 0.0 else 0.0
    give = mine + theirs + turn_a * turn_a * spin_a + turn_b * turn_b * spin_b
    if give == 0.0:
        return total
    apart = -(world[a, VX] * ux + world[a, VY] * uy + world[a, SPIN] * turn_a)
    if theirs > 0.0:
        apart += world[b, VX] * ux + world[b, VY] * uy + world[b, SPIN] * turn_b
    after = min(max(total - float(apart / give), least), most)
    push = after - total
    world[a, VX] -= push * mine * ux
    world[a, VY] -= push * mine * uy
    world[a, SPIN] -= push * spin_a * turn_a
    if theirs > 0.0:
        world[b, VX] += push * theirs * ux
        world[b, VY] += push * theirs * uy
        world[b, SPIN] += push * spin_b * turn_b
    return after
