"""Line of sight in the plane: who sees how much of whose marker, for every robot at once.

A marker is a disc of the plane. Ten rays across its width, from an observer's axis, tell how much of
it is in sight: a ray is hidden where a nearer marker, or a thing taller than the markers' base,
stands across it. Neighbours are taken nearest first, so only who came before can hide, and a robot
with a limited number of slots looks no farther than it must; angles are computed only where two
markers come near each other in bearing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray

RAYS = np.linspace(-0.9, 0.9, 10)  # across a marker's half width; each ray is a tenth of its width
ALL_RAYS = (1 << len(RAYS)) - 1
ENOUGH = 0.3  # fraction of a marker's width that must be in sight for it to be seen
FEW = 32  # robots that are not worth sorting into cells
RANGE, BEARING, HEADING, VISIBLE = 0, 1, 2, 3  # columns of what is seen
TWO_PI = 2.0 * np.pi


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """What does not change between two looks."""

    reach: float
    """m"""
    half_fov: float
    """rad to either side of straight ahead."""
    radius: float
    """Of what is looked at, and hides (m)."""
    occlusion: bool
    """Whether anything hides anything."""
    things: FloatArray
    """Objects tall enough to hide: number in the scene, half length, half width, or radius and
    -1 for a disc (m), shape ``(b, 3)``."""
    ahead: float = 0.0
    """How far before the robot's axis, towards whom it looks at, its eye is (m): a ring of lenses."""

    @property
    def limit(self) -> float:
        """Largest bearing (rad) that is seen; inf all round, for straight behind may round to beyond pi."""
        return np.inf if self.half_fov >= np.pi else self.half_fov

    @classmethod
    def of(
        cls, robot: RobotConfig, arena: ArenaConfig, reach: float, fov: float, *, occlusion: bool = True
    ) -> View:
        """Return the view of the markers in an arena; ``fov`` in rad."""
        things = _taller(arena, robot.marker.base)
        return cls(reach, fov / 2.0, robot.marker.radius, occlusion, things)

    @classmethod
    def of_bodies(
        cls, robot: RobotConfig, arena: ArenaConfig, reach: float, *, occlusion: bool = True
    ) -> View:
        """Return the view all round on top of the chassis: a body hides as the disc inside its outline."""
        radius = min(robot.length, robot.width) / 2.0
        return cls(reach, np.pi, radius, occlusion, _taller(arena, robot.body_height))


def _taller(arena: ArenaConfig, height: float) -> FloatArray:
    things = [(i, *_size(thing)) for i, thing in enumerate(arena.objects) if thing.height > height]
    return np.array(things, np.float64).reshape(-1, 3)


def _size(thing: BoxConfig | DiscConfig) -> tuple[float, float]:
    if isinstance(thing, DiscConfig):
        return thing.radius, -1.0
    return thing.length / 2.0, thing.width / 2.0


@compiled
def wrapped(angle: float) -> float:
    """Return the direction (rad) in (-pi, pi]; :func:`swarmvision.geometry.wrap` of one number."""
    if -np.pi < angle <= np.pi:
        return angle
    return np.pi - (np.pi - angle) % TWO_PI


@compiled
def cells(pose: FloatArray, reach: float) -> tuple[FloatArray, IntArray, IntArray]:
    """Return robots sorted into square cells no smaller than the reach.

    Args:
        pose: Shape ``(r, 3)``.
        reach: m.

    Returns:
        Left, bottom, size, columns and rows of the grid, ``(5,)``; where each cell's robots begin,
        ``(columns * rows + 1,)``; the robots, cell by cell, by number in each, ``(r,)``.
    """
    r = len(pose)
    if r <= FEW:  # one cell, wherever they are
        return np.array([0.0, 0.0, np.inf, 1.0, 1.0]), np.array([0, r]), np.arange(r)
    left, bottom, right, top = 0.0, 0.0, 0.0, 0.0
    for i in range(r):
        x, y = pose[i, 0], pose[i, 1]
        if i == 0 or x < left:
            left = x
        if i == 0 or x > right:
            right = x
        if i == 0 or y < bottom:
            bottom = y
        if i == 0 or y > top:
            top = y
    size = max(reach, 1e-6)
    side = max(int(np.sqrt(r)), 1)  # more cells than that in a row would be empty ones
    size = max(size, (right - left) / side, (top - bottom) / side)
    columns, rows = int((right - left) / size) + 1, int((top - bottom) / size) + 1
    grid = np.array([left, bottom, size, columns, rows])
    begin = np.zeros(columns * rows + 1, np.int64)
    cell = np.empty(r, np.int64)
    for i in range(r):
        cell[i] = int((pose[i, 1] - bottom) / size) * columns + int((pose[i, 0] - left) / size)
        begin[cell[i] + 1] += 1
    for c in range(columns * rows):
        begin[c + 1] += begin[c]
    filled = begin.copy()
    robots = np.empty(r, np.int64)
    for i in range(r):
        robots[filled[cell[i]]] = i
        filled[cell[i]] += 1
    return grid, begin, robots


@compiled
def measure_pairs(pose: FloatArray, gaps: FloatArray, angles: FloatArray) -> None:
    """Fill in the distance (m) and direction in the world (rad) from each robot to each, ``(r, r)``."""
    for i in range(len(pose)):
        gaps[i, i] = np.inf
        for j in range(i):
            dx, dy = pose[j, 0] - pose[i, 0], pose[j, 1] - pose[i, 1]
            gaps[i, j] = gaps[j, i] = np.sqrt(dx * dx + dy * dy)
            angles[i, j] = np.arctan2(dy, dx)
            angles[j, i] = angles[i, j] + np.pi if angles[i, j] <= 0.0 else angles[i, j] - np.pi


@compiled
def nearest_of_few(me: int, reach: float, gaps: FloatArray, who: IntArray, distance: FloatArray) -> int:
    """Fill in who is within reach of a robot and how far, nearest first; return how many."""
    count = 0
    for other in range(len(gaps)):
        gap = gaps[me, other]
        if gap > reach:
            continue
        m = count
        while m > 0 and distance[m - 1] > gap:
            distance[m], who[m] = distance[m - 1], who[m - 1]
            m -= 1
        distance[m], who[m] = gap, other
        count += 1
    return count


@compiled
def near(
    pose: FloatArray,
    me: int,
    reach: float,
    grid: FloatArray,
    begin: IntArray,
    robots: IntArray,
    who: IntArray,
    distance: FloatArray,
) -> int:
    """Fill in who is within reach of a robot and how far; return how many."""
    x, y = pose[me, 0], pose[me, 1]
    columns, rows = int(grid[3]), int(grid[4])
    column, row = int((x - grid[0]) / grid[2]), int((y - grid[1]) / grid[2])
    count = 0
    for r in range(max(row - 1, 0), min(row + 2, rows)):
        first = begin[r * columns + max(column - 1, 0)]
        last = begin[r * columns + min(column + 1, columns - 1) + 1]
        for n in range(first, last):
            other = robots[n]
            dx, dy = pose[other, 0] - x, pose[other, 1] - y
            square = dx * dx + dy * dy
            if other != me and square <= reach * reach:
                who[count] = other
                distance[count] = np.sqrt(square)
                count += 1
    return count


@compiled
def sink(heap: IntArray, distance: FloatArray, who: IntArray, root: int, count: int) -> None:
    """Restore the order of a heap, nearest first, below one of its places."""
    while True:
        child = 2 * root + 1
        if child >= count:
            return
        if child + 1 < count and before(heap[child + 1], heap[child], distance, who):
            child += 1
        if not before(heap[child], heap[root], distance, who):
            return
        heap[root], heap[child] = heap[child], heap[root]
        root = child


@compiled
def before(one: int, two: int, distance: FloatArray, who: IntArray) -> bool:
    """Return whether one candidate is nearer than another; of equals the one with the lower number."""
    if distance[one] == distance[two]:
        return bool(who[one] < who[two])
    return bool(distance[one] < distance[two])


@compiled
def shadow(sine: float, cosine: float, half: float, by: float) -> int:
    """Return the bits of the rays that a nearer marker covers.

    Args:
        sine: Of the angle from the nearer marker to the farther.
        cosine: Of the same.
        half: Half width of the farther marker (rad).
        by: Half width of the nearer (rad).
    """
    bits, angle = 0, np.arctan2(sine, cosine)
    for n in range(len(RAYS)):
        if abs(wrapped(angle + RAYS[n] * half)) < by:
            bits |= 1 << n
    return bits


@compiled
def marker_shadows(
    count: int, x: float, y: float, gap: float, radius: float, ahead: float, nearer: FloatArray
) -> int:
    """Return the bits of the rays that any nearer marker covers.

    Args:
        count: Of the nearer ones.
        x: Of the marker's direction, of length 1.
        y: Of the same.
        gap: Range of the marker (m).
        radius: Of all markers (m).
        ahead: Of the eye, towards the marker (m).
        nearer: The same three of the nearer markers, shape ``(3, r)``.
    """
    bits = 0
    sine = min(radius / max(gap - ahead, 1e-9), 1.0)
    for m in range(count):
        # From the eye to the nearer marker, along the direction of the farther one and across it.
        along = nearer[2, m] * (nearer[0, m] * x + nearer[1, m] * y) - ahead
        across = nearer[2, m] * (nearer[0, m] * y - nearer[1, m] * x)
        # The distance is at most that from the axis and the way to the eye: no root for most.
        if abs(across) >= radius + sine * (nearer[2, m] + ahead) and sine < 0.5:
            continue
        square = along * along + across * across
        distance = max(np.sqrt(square), 1e-9)
        by = min(radius / distance, 1.0)
        if abs(across) < (sine + by) * distance and (along > 0.0 or sine + by >= 1.0):
            bits |= shadow(across, along, np.arcsin(sine), np.arcsin(by))
            if bits == ALL_RAYS:
                break
    return bits


@compiled
def thing_shadow(
    bearing: float,
    half: float,
    distance: float,
    place: FloatArray,
    length: float,
    width: float,
) -> int:
    """Return the bits of the rays that meet a thing before they meet the marker.

    Args:
        bearing: Of the marker in the observer's frame (rad).
        half: Half width of the marker (rad).
        distance: Of the marker (m).
        place: Of the thing in the observer's frame: x, y, yaw.
        length: Half of the box's, or the disc's radius (m).
        width: Half of the box's, or -1 (m).
    """
    square = place[0] * place[0] + place[1] * place[1]
    bound = length if width < 0.0 else np.hypot(length, width)
    if square > (distance + bound) * (distance + bound):
        return 0
    cos, sin = np.cos(place[2]), np.sin(place[2])
    start_x = -(cos * place[0] + sin * place[1])
    start_y = -(cos * place[1] - sin * place[0])
    bits = 0
    for n in range(len(RAYS)):
        ray = bearing + RAYS[n] * half
        if width < 0.0:
            x, y = np.cos(ray), np.sin(ray)
            along = x * place[0] + y * place[1]
            miss = square - along * along
            if along > 0.0 and miss < length * length and along < distance:
                bits |= 1 << n
            continue
        # In the box's own frame: the slab test.
        x, y = np.cos(ray - place[2]), np.sin(ray - place[2])
        x = x if abs(x) >= 1e-12 else 1e-12
        y = y if abs(y) >= 1e-12 else 1e-12
        x1, x2 = (-length - start_x) / x, (length - start_x) / x
        y1, y2 = (-width - start_y) / y, (width - start_y) / y
        enter, leave = max(min(x1, x2), min(y1, y2)), min(max(x1, x2), max(y1, y2))
        if enter < leave and leave > 0.0 and enter < distance:
            bits |= 1 << n
    return bits


@compiled
def thing_shadows(
    bearing: float,
    half: float,
    distance: float,
    eye_x: float,
    eye_y: float,
    yaw: float,
    objects: FloatArray,
    things: FloatArray,
) -> int:
    """Return the bits of the rays that any thing covers, from the eye's place and yaw in the world."""
    bits = 0
    cos, sin = np.cos(yaw), np.sin(yaw)
    place = np.empty(3)
    for b in range(len(things)):
        thing = objects[int(things[b, 0])]
        x, y = thing[0] - eye_x, thing[1] - eye_y
        place[0], place[1], place[2] = cos * x + sin * y, cos * y - sin * x, thing[2] - yaw
        bits |= thing_shadow(bearing, half, distance, place, things[b, 1], things[b, 2])
        if bits == ALL_RAYS:
            break
    return bits


@compiled
def look(
    pose: FloatArray,
    objects: FloatArray,
    me: int,
    reach: float,
    half_fov: float,
    radius: float,
    occlusion: bool,
    ahead: float,
    least: float,
    things: FloatArray,
    grid: FloatArray,
    begin: IntArray,
    robots: IntArray,
    gaps: FloatArray,
    angles: FloatArray,
    who: IntArray,
    seen: FloatArray,
    candidates: IntArray,
    order: IntArray,
    distance: FloatArray,
    nearer: FloatArray,
) -> int:
    """Fill in whom a robot sees, nearest first, until nobody is left or ``who`` is full.

    Args:
        pose: Of the robots, shape ``(r, 3)``.
        objects: Poses, shape ``(m, 3)``.
        me: The observer.
        reach: m.
        half_fov: rad.
        radius: Of a marker (m).
        occlusion: Whether anything hides anything.
        ahead: As in :class:`View`.
        least: Fraction of a marker's width that must be in sight.
        things: As in :class:`View`.
        grid: From :func:`cells`, and so the next two.
        begin: Where each cell's robots begin.
        robots: The robots, cell by cell.
        gaps: From :func:`measure_pairs` for few robots; else ``(0, 0)``, and so the next.
        angles: From the same.
        who: Out: numbers of those seen, shape ``(k,)``.
        seen: Out: range, bearing, heading, visible fraction, shape ``(k, 4)``.
        candidates: Room to work in, shape ``(r,)``, and so the next two.
        order: Room to work in.
        distance: Room to work in.
        nearer: Room to work in, shape ``(3, r)``.

    Returns:
        How many are seen.
    """
    few = len(gaps) > 0
    if few:
        count = nearest_of_few(me, reach, gaps, candidates, distance)
    else:
        count = near(pose, me, reach, grid, begin, robots, candidates, distance)
        for n in range(count):
            order[n] = n
        for root in range(count // 2 - 1, -1, -1):
            sink(order, distance, candidates, root, count)
    yaw = pose[me, 2]
    found = 0
    for n in range(count):
        if found == len(who):
            break
        c = n
        if not few:
            c = order[0]
            order[0] = order[count - 1 - n]
            sink(order, distance, candidates, 0, count - 1 - n)
        other, gap = candidates[c], max(distance[c], 1e-9)
        dx, dy = pose[other, 0] - pose[me, 0], pose[other, 1] - pose[me, 1]
        x, y = dx / gap, dy / gap
        visible = 1.0
        if occlusion:
            hidden = marker_shadows(n, x, y, gap, radius, ahead, nearer)
            if len(things) > 0:
                eye_x, eye_y = pose[me, 0] + ahead * x, pose[me, 1] + ahead * y
                half = np.arcsin(min(radius / max(gap - ahead, 1e-9), 1.0))
                bearing = np.arctan2(y, x) - yaw
                hidden |= thing_shadows(bearing, half, gap - ahead, eye_x, eye_y, yaw, objects, things)
            nearer[0, n], nearer[1, n], nearer[2, n] = x, y, gap
            if hidden:
                visible = 1.0 - bits_of(hidden) / len(RAYS)
        if visible < least:
            continue
        bearing = wrapped((angles[me, other] if few else np.arctan2(dy, dx)) - yaw)
        if abs(bearing) <= half_fov:
            who[found] = other
            seen[found, 0], seen[found, 1], seen[found, 3] = distance[c], bearing, visible
            seen[found, 2] = wrapped(pose[other, 2] - yaw)
            found += 1
    return found


@compiled
def bits_of(mask: int) -> int:
    """Return how many of the rays are set."""
    bits = 0
    for ray in range(len(RAYS)):
        bits += (mask >> ray) & 1
    return bits
