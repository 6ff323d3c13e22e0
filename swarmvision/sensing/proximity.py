"""A ring of eight short-range infrared sectors round the body, as Kobot's.

Source: A. E. Turgut, H. Celikkanat, F. Gokce, E. Sahin, "Self-organized flocking in mobile robot swarms",
Swarm Intelligence 2, 2008, doi:10.1007/s11721-008-0016-2: eight sensors at 45 deg, a reach of about 20 cm,
a coarse level of nearness, and whether the thing is a robot.

A sector is a wedge of the plane from the robot's axis. Its reading is the exact distance to the nearest point
in the wedge of any body, wall or object; whatever stands on the floor is tall enough. Where we differ: our
wedges of 45 deg meet without gap or overlap and are equally sensitive all over, dark surfaces are as near as
bright ones, and neighbours' beams do not disturb each other. The size of the noise is ours.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.config.arena import ArenaConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import ProximityConfig
from swarmvision.data import SECTOR_BEARINGS, BoolArray, IntArray, Scene
from swarmvision.geometry import FloatArray
from swarmvision.randomness import RobotKeys, Subsystem, normal

SECTORS = len(SECTOR_BEARINGS)
HALF = np.pi / SECTORS  # rad; half of a wedge
RIGHT = np.stack([np.cos(SECTOR_BEARINGS - HALF), np.sin(SECTOR_BEARINGS - HALF)], axis=1)
LEFT = np.stack([np.cos(SECTOR_BEARINGS + HALF), np.sin(SECTOR_BEARINGS + HALF)], axis=1)
BEARINGS = SECTOR_BEARINGS.copy()


class ProximityRing:
    """The rings of all robots."""

    def __init__(
        self, config: ProximityConfig, robot: RobotConfig, arena: ArenaConfig, seed: int = 0
    ) -> None:
        self._config = config
        self._body = np.array([robot.length / 2.0, robot.width / 2.0])
        self._things = np.array(
            [
                (thing.radius, -1.0)
                if isinstance(thing, DiscConfig)
                else (thing.length / 2.0, thing.width / 2.0)
                for thing in arena.objects
            ]
        ).reshape(-1, 2)
        walls = np.array([arena.width / 2.0, arena.depth / 2.0])
        self._walls = walls if arena.wall_height > 0.0 else np.full(2, np.inf)
        self._keys = RobotKeys(seed, Subsystem.PROXIMITY)
        self._readings = 0

    def sense(self, scene: Scene) -> tuple[FloatArray, BoolArray]:
        """Return what the rings read now; each call draws new noise.

        Returns:
            Range from the robot's centre (m), inf where nothing is in reach, ``(r, 8)``; whether the thing is
            a robot, ``(r, 8)``.
        """
        gap, is_robot = self.measure(scene)
        gap += self._config.noise * normal(
            self._keys.of(scene.robots)[:, None], self._readings, np.arange(SECTORS)
        )
        self._readings += 1
        inner = self._body.min()
        gap = np.maximum(gap, inner)
        gap[gap > self._config.reach] = np.inf
        if self._config.levels:
            step = (self._config.reach - inner) / self._config.levels
            level = np.minimum(np.floor((gap - inner) / step), self._config.levels - 1)
            gap = np.where(np.isfinite(gap), inner + (level + 0.5) * step, np.inf)
        return gap, is_robot & np.isfinite(gap)

    def measure(self, scene: Scene) -> tuple[FloatArray, BoolArray]:
        """Return the same without noise and levels."""
        gap = np.full((scene.robots, SECTORS), np.inf)
        is_robot = np.zeros(gap.shape, dtype=np.bool_)
        _measure(
            scene.pose,
            np.argsort(scene.pose[:, 0], kind="stable"),
            scene.object_pose,
            self._body,
            self._things,
            self._walls,
            self._config.reach,
            gap,
            is_robot,
        )
        return gap, is_robot


@compiled
def _measure(
    pose: FloatArray,
    by_x: IntArray,
    objects: FloatArray,
    body: FloatArray,
    things: FloatArray,
    walls: FloatArray,
    reach: float,
    gap: FloatArray,
    is_robot: BoolArray,
) -> None:
    """Fill in the nearest range in every sector; boxes by half sizes, discs by radius and -1.

    Robots are met in the order of their x, ``by_x``, to either side until they are too far.
    """
    far = reach + np.hypot(body[0], body[1])
    for place in range(len(pose)):
        me = by_x[place]
        x, y, yaw = pose[me]
        cos, sin = np.cos(yaw), np.sin(yaw)
        for side in (-1, 1):
            at = place + side
            while 0 <= at < len(pose) and abs(pose[by_x[at], 0] - x) < far:
                other = by_x[at]
                dx, dy = pose[other, 0] - x, pose[other, 1] - y
                if dx * dx + dy * dy < far * far:
                    turn = pose[other, 2] - yaw
                    _box(cos * dx + sin * dy, cos * dy - sin * dx, turn, body, reach, gap[me])
                at += side
        for k in range(SECTORS):  # all that was met so far was a robot
            is_robot[me, k] = gap[me, k] < np.inf
        before = gap[me].copy()
        for n in range(len(things)):
            dx, dy = objects[n, 0] - x, objects[n, 1] - y
            left, ahead = cos * dy - sin * dx, cos * dx + sin * dy
            if things[n, 1] < 0.0:
                _disc(ahead, left, things[n, 0], reach, gap[me])
            else:
                _box(ahead, left, objects[n, 2] - yaw, things[n], reach, gap[me])
        if abs(x) > walls[0] - reach or abs(y) > walls[1] - reach:
            _box(-cos * x - sin * y, sin * x - cos * y, -yaw, walls, reach, gap[me])
        for k in range(SECTORS):
            is_robot[me, k] = is_robot[me, k] and gap[me, k] == before[k]


@compiled
def _box(x: float, y: float, yaw: float, half: FloatArray, reach: float, gap: FloatArray) -> None:
    """Take in a box at a pose in the robot's frame: its four sides."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    ax, ay = cos * half[0], sin * half[0]
    bx, by = -sin * half[1], cos * half[1]
    _side(x + ax + bx, y + ay + by, x - ax + bx, y - ay + by, reach, gap)
    _side(x - ax + bx, y - ay + by, x - ax - bx, y - ay - by, reach, gap)
    _side(x - ax - bx, y - ay - by, x + ax - bx, y + ay - by, reach, gap)
    _side(x + ax - bx, y + ay - by, x + ax + bx, y + ay + by, reach, gap)


@compiled
def _side(px: float, py: float, qx: float, qy: float, reach: float, gap: FloatArray) -> None:
    """Take in a line from p to q, cut to each wedge in turn."""
    dx, dy = qx - px, qy - py
    square = dx * dx + dy * dy
    nearest = min(max(-(px * dx + py * dy) / square, 0.0), 1.0)
    if np.hypot(px + nearest * dx, py + nearest * dy) > reach:
        return
    for k in range(SECTORS):
        first, last = 0.0, 1.0
        # Inside is where both are positive: left of the right border, right of the left one.
        begin = RIGHT[k, 0] * py - RIGHT[k, 1] * px
        first, last = _cut(begin, RIGHT[k, 0] * dy - RIGHT[k, 1] * dx, first, last)
        begin = px * LEFT[k, 1] - py * LEFT[k, 0]
        first, last = _cut(begin, dx * LEFT[k, 1] - dy * LEFT[k, 0], first, last)
        if first <= last:
            at = min(max(nearest, first), last)
            distance = np.hypot(px + at * dx, py + at * dy)
            if distance <= reach and distance < gap[k]:
                gap[k] = distance


@compiled
def _cut(begin: float, slope: float, first: float, last: float) -> tuple[float, float]:
    """Return the part of first..last where ``begin + t * slope`` is not negative."""
    if slope > 0.0:
        return max(first, -begin / slope), last
    if slope < 0.0:
        return first, min(last, -begin / slope)
    return (first, last) if begin >= 0.0 else (1.0, 0.0)


@compiled
def _disc(x: float, y: float, radius: float, reach: float, gap: FloatArray) -> None:
    """Take in a disc: ahead of a wedge its nearest point, beside it where the border ray meets it."""
    distance = np.hypot(x, y)
    if distance > reach + radius:
        return
    bearing = np.arctan2(y, x)
    for k in range(SECTORS):
        off = abs((bearing - BEARINGS[k] + np.pi) % (2.0 * np.pi) - np.pi)
        beside = max(off - HALF, 0.0)
        miss = distance * np.sin(beside)
        if beside < np.pi / 2.0 and miss < radius:
            met = max(distance * np.cos(beside) - np.sqrt(radius * radius - miss * miss), 0.0)
            if met <= reach and met < gap[k]:
                gap[k] = met
