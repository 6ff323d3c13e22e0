"""Many worlds' bodies at once, pushed apart where they touch: a contact model without pymunk.

Motion and traction are :mod:`swarmvision.world`'s, in the same order; without contacts the two agree to
rounding when their substeps are equal. Contacts are simpler: robots meet each other and things as discs
of their own area, walls as the boxes that they are. Impulses are found by a few rounds over
all contacts (sequential impulses with Coulomb friction, as in Chipmunk, without warm starts and without
bounce), and what still overlaps is moved apart a little in every substep, at Chipmunk's rate.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled, leaf
from swarmvision.config.arena import ArenaConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import BoolArray, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.ground import ANGLE, SPIN, VX, VY, X, Y, pull, pull_round, robot_grip, thing_grip
from swarmvision.trigonometry import wrapped

ROUNDS = 6  # over the contacts of a substep
STILL = 1e-12  # N s; a round that changes less is the last
OVERLAP = 1e-4  # m that bodies may overlap
LEFT_AFTER_A_SECOND = 0.9**60  # share of an overlap that is left after 1 s: Chipmunk's collision_bias
WALLS = 4
REST = np.zeros(1)  # of what has no tracks
ABREAST = 32  # worlds that are moved together: they fit the nearest cache
PER_BODY = 8  # contacts that there is room for, for each body
HALF_LENGTH, HALF_WIDTH, RADIUS, FRICTION = range(4)  # columns of a shape; half width is -1 for a disc
# Of a contact: where, how deep and how rough; how far so far; levers and stiffness along and across it.
NORMAL_X, NORMAL_Y, ARM_AX, ARM_AY, ARM_BX, ARM_BY, DEPTH, RUB, PUSHED, RUBBED = range(10)
LEVER_A, LEVER_B, SIDE_A, SIDE_B, STIFF, STIFF_ASIDE = range(10, 16)


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


def bounds_of(robots: int, shapes: FloatArray) -> FloatArray:
    """Return how far bodies reach (m), towards each other and towards walls, shape ``(2, n)``.

    Robots meet each other as discs, and walls as boxes; of a thing it is its outline.
    """
    outline = np.hypot(shapes[:, HALF_LENGTH], np.maximum(shapes[:, HALF_WIDTH], 0.0))
    towards = np.maximum(outline, shapes[:, RADIUS])
    towards[:robots] = shapes[:robots, RADIUS]
    return np.stack([towards, outline])


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
        shapes: From :func:`shapes_of`, shape ``(n, 4)``.
        bounds: From :func:`bounds_of`, shape ``(2, n)``.
        grips: From :func:`shapes_of`, shape ``(n, 4)``.
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
                count = _meet_all(
                    world, shapes, bounds[1], grips, room, r, close, walled[w - first], who, contacts
                )
                if count > 0:
                    _resolve(world, ease, count, who, contacts, dt)
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
def _meet_all(
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


@leaf
def _resolve(
    world: FloatArray, ease: FloatArray, count: int, who: IntArray, contacts: FloatArray, dt: float
) -> None:
    """Stop what approaches, within friction, and move apart some of what overlaps.

    Args:
        world: Bodies, then walls at rest, shape ``(n + 4, 6)``.
        ease: How easily they move (1/kg) and turn (1/(kg m^2)); 0 for what is fixed, ``(n + 4, 2)``.
        count: Of the contacts.
        who: Pairs of bodies.
        contacts: One a row.
        dt: Of the substep (s).
    """
    for c in range(count):
        a, b, row = who[c, 0], who[c, 1], contacts[c]
        nx, ny = row[NORMAL_X], row[NORMAL_Y]
        row[LEVER_A], row[LEVER_B] = row[ARM_AX] * ny - row[ARM_AY] * nx, row[ARM_BX] * ny - row[ARM_BY] * nx
        row[SIDE_A], row[SIDE_B] = row[ARM_AX] * nx + row[ARM_AY] * ny, row[ARM_BX] * nx + row[ARM_BY] * ny
        straight = ease[a, 0] + ease[b, 0]
        along = straight + row[LEVER_A] ** 2 * ease[a, 1] + row[LEVER_B] ** 2 * ease[b, 1]
        aside = straight + row[SIDE_A] ** 2 * ease[a, 1] + row[SIDE_B] ** 2 * ease[b, 1]
        row[STIFF] = 1.0 / along if along > 0.0 else 0.0
        row[STIFF_ASIDE] = 1.0 / aside if aside > 0.0 else 0.0
    for _ in range(ROUNDS):
        change = 0.0
        for c in range(count):
            a, b, row = who[c, 0], who[c, 1], contacts[c]
            mine, theirs, nx, ny = world[a], world[b], row[NORMAL_X], row[NORMAL_Y]
            apart = (theirs[VX] - mine[VX]) * nx + (theirs[VY] - mine[VY]) * ny
            apart += theirs[SPIN] * row[LEVER_B] - mine[SPIN] * row[LEVER_A]
            pushed = max(row[PUSHED] - apart * row[STIFF], 0.0)
            _push(mine, theirs, ease[a], ease[b], nx, ny, row[LEVER_A], row[LEVER_B], pushed - row[PUSHED])
            apart = (theirs[VY] - mine[VY]) * nx - (theirs[VX] - mine[VX]) * ny
            apart += theirs[SPIN] * row[SIDE_B] - mine[SPIN] * row[SIDE_A]
            most = row[RUB] * pushed
            rubbed = min(max(row[RUBBED] - apart * row[STIFF_ASIDE], -most), most)
            _push(mine, theirs, ease[a], ease[b], -ny, nx, row[SIDE_A], row[SIDE_B], rubbed - row[RUBBED])
            change = max(change, abs(pushed - row[PUSHED]), abs(rubbed - row[RUBBED]))
            row[PUSHED], row[RUBBED] = pushed, rubbed
        if change < STILL:
            break
    share = 1.0 - LEFT_AFTER_A_SECOND**dt
    for c in range(count):
        a, b = who[c, 0], who[c, 1]
        easy = ease[a, 0] + ease[b, 0]
        push = share * max(contacts[c, DEPTH] - OVERLAP, 0.0) / easy if easy > 0.0 else 0.0
        for axis in range(2):
            world[a, axis] -= push * ease[a, 0] * contacts[c, axis]
            world[b, axis] += push * ease[b, 0] * contacts[c, axis]


@leaf
def _push(
    mine: FloatArray,
    theirs: FloatArray,
    my_ease: FloatArray,
    their_ease: FloatArray,
    ux: float,
    uy: float,
    my_lever: float,
    their_lever: float,
    push: float,
) -> None:
    """Push two bodies apart along a direction by an impulse (N s) with levers (m) round their middles."""
    mine[VX] -= push * my_ease[0] * ux
    mine[VY] -= push * my_ease[0] * uy
    mine[SPIN] -= push * my_ease[1] * my_lever
    theirs[VX] += push * their_ease[0] * ux
    theirs[VY] += push * their_ease[0] * uy
    theirs[SPIN] += push * their_ease[1] * their_lever
