"""The arena from above: robots as boxes with a nose, their trails, objects and walls."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.colour import rgb
from swarmvision.config.arena import ArenaConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.scenario import GoalConfig
from swarmvision.data import Scene
from swarmvision.drawing.palette import robot_colour
from swarmvision.geometry import FloatArray, rotate

Image = NDArray[np.uint8]
FLOOR, GRID, WALL, INK = (246, 246, 243), (226, 226, 222), (90, 90, 94), (40, 40, 44)
CUE, GOAL, GOAL_RIM = (250, 214, 140), (222, 240, 222), (120, 178, 126)
TEAMS = ((236, 232, 222), (180, 176, 170), (120, 118, 116))  # bodies of the second team and further ones
CUE_RINGS = 24
MARGIN = 0.5  # m round the swarm
NARROWEST = 2.4  # m: the least that a view shows
SHIFT = 4  # fractional bits of OpenCV's drawing


class TopView:
    """A window on the arena that keeps the swarm in sight without jumping."""

    def __init__(
        self,
        arena: ArenaConfig,
        robot: RobotConfig,
        width_px: int,
        height_px: int,
        goal: GoalConfig | None = None,
        team_sizes: tuple[int, ...] = (),
    ) -> None:
        """Set up the window; robots of further teams, after those of the first, are drawn in grey."""
        self._goal = goal
        self._team = np.repeat(np.arange(len(team_sizes)), team_sizes)
        self._arena = arena
        self._robot = robot
        self._size = (width_px, height_px)
        self._centre: FloatArray | None = None
        self._span = NARROWEST

    def draw(self, scene: Scene, trail: Sequence[FloatArray] = ()) -> Image:
        """Return the view of a scene; ``trail`` holds earlier poses ``(r, 3)``, oldest first."""
        self._follow(scene)
        image = np.full((self._size[1], self._size[0], 3), FLOOR, dtype=np.uint8)
        self._ground(image)
        self._walls(image)
        self._grid(image)
        for thing, pose in zip(self._arena.objects, scene.object_pose, strict=True):
            if isinstance(thing, DiscConfig):
                self._disc(image, pose[:2], thing.radius, rgb(thing.colour))
            else:
                self._polygon(image, _box(pose, thing.length, thing.width), rgb(thing.colour))
        self._trails(image, trail)
        for robot, pose in enumerate(scene.pose):
            self._draw_robot(image, robot, pose)
        return image

    def _follow(self, scene: Scene) -> None:
        """Move the window gently towards the swarm; the whole arena is shown where it fits."""
        whole = max(self._arena.width, self._arena.depth) + 0.2
        if whole <= NARROWEST * 1.6 or scene.robots == 0:
            self._centre, self._span = np.zeros(2), min(whole, 6.0)
            return
        shown = scene.pose[:, :2]
        if self._goal is not None:
            shown = np.vstack([shown, (self._goal.x, self._goal.y)])
        low, high = shown.min(axis=0), shown.max(axis=0)
        span = min(max(float((high - low).max()) + 2 * MARGIN, NARROWEST), whole)
        if self._centre is None:
            self._centre, self._span = (low + high) / 2.0, span
        self._centre = self._centre + 0.1 * ((low + high) / 2.0 - self._centre)
        self._span += 0.1 * (span - self._span)

    def _px(self, place: FloatArray) -> FloatArray:
        assert self._centre is not None
        scale = min(self._size) / self._span
        return (place - self._centre) * [scale, -scale] + np.array(self._size) / 2.0

    def _fixed(self, place: FloatArray) -> NDArray[np.int32]:
        return np.clip(np.rint(self._px(place) * (1 << SHIFT)), -(1 << 24), 1 << 24).astype(np.int32)

    def _polygon(self, image: Image, corners: FloatArray, colour: tuple[int, int, int]) -> None:
        cv2.fillPoly(image, [self._fixed(corners)], colour, cv2.LINE_AA, SHIFT)

    def _disc(self, image: Image, place: FloatArray, radius: float, colour: tuple[int, ...]) -> None:
        size = round(radius * min(self._size) / self._span * (1 << SHIFT))
        x, y = self._fixed(place).tolist()
        cv2.circle(image, (x, y), size, colour, -1, cv2.LINE_AA, SHIFT)

    def _ground(self, image: Image) -> None:
        """Draw the cues, the warmer the stronger, and the goal."""
        for cue in self._arena.cues:
            for ring in range(CUE_RINGS):
                share = cue.strength * (ring + 1) / CUE_RINGS
                colour = tuple(
                    round(floor + share * (warm - floor)) for floor, warm in zip(FLOOR, CUE, strict=True)
                )
                self._disc(image, np.array([cue.x, cue.y]), cue.radius * (1.0 - ring / CUE_RINGS), colour)
        if self._goal is not None:
            place = np.array([self._goal.x, self._goal.y])
            self._disc(image, place, self._goal.radius, GOAL_RIM)
            self._disc(image, place, 0.96 * self._goal.radius, GOAL)

    def _walls(self, image: Image) -> None:
        """Draw what is not arena."""
        x, y = self._arena.width / 2.0, self._arena.depth / 2.0
        far = max(x, y) + self._span
        for left, right, bottom, top in ((-far, -x, -far, far), (x, far, -far, far)):
            self._polygon(image, np.array([[left, bottom], [right, bottom], [right, top], [left, top]]), WALL)
        for bottom, top in ((-far, -y), (y, far)):
            self._polygon(image, np.array([[-far, bottom], [far, bottom], [far, top], [-far, top]]), WALL)

    def _body_colour(self, robot: int) -> tuple[int, int, int]:
        team = int(self._team[robot]) if robot < len(self._team) else 0
        return robot_colour(robot) if team == 0 else TEAMS[min(team, len(TEAMS)) - 1]

    def _grid(self, image: Image) -> None:
        assert self._centre is not None
        step = 0.5
        for axis in range(2):
            first = np.ceil((self._centre[axis] - self._span) / step) * step
            half = (self._arena.width, self._arena.depth)[axis] / 2.0
            across = (self._arena.depth, self._arena.width)[axis] / 2.0
            for at in np.arange(first, self._centre[axis] + self._span, step):
                if abs(at) < half:
                    ends = np.array([[at, -across], [at, across]])
                    cv2.polylines(
                        image,
                        [self._fixed(ends if axis == 0 else ends[:, ::-1])],
                        False,
                        GRID,
                        1,
                        cv2.LINE_AA,
                        SHIFT,
                    )

    def _trails(self, image: Image, trail: Sequence[FloatArray]) -> None:
        if len(trail) < 2:
            return
        ways = np.array(trail)[:, :, :2]  # (steps, r, 2)
        for robot in range(ways.shape[1]):
            light = tuple((2 * 246 + channel) // 3 for channel in self._body_colour(robot))
            cv2.polylines(image, [self._fixed(ways[:, robot])], False, light, 2, cv2.LINE_AA, SHIFT)

    def _draw_robot(self, image: Image, robot: int, pose: FloatArray) -> None:
        body = self._robot
        colour = self._body_colour(robot)
        self._polygon(image, _box(pose, body.length, body.width), INK)
        inner = _box(pose, 0.82 * body.length, 0.82 * body.width)
        self._polygon(image, inner, colour)
        nose = np.array([[0.5, 0.0], [0.22, 0.16], [0.22, -0.16]]) * body.length
        self._polygon(image, pose[:2] + rotate(nose, pose[2]), (255, 255, 255))
        self._disc(image, pose[:2], body.marker.radius, (255, 255, 255))
        x, y = self._px(pose[:2])
        text = str(robot)
        cv2.putText(
            image,
            text,
            (int(x) - 4 * len(text), int(y) + 4),
            cv2.FONT_HERSHEY_SIMPLEX,
            0.36,
            INK,
            1,
            cv2.LINE_AA,
        )


def _box(pose: FloatArray, length: float, width: float) -> FloatArray:
    half = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * [length / 2.0, width / 2.0]
    corners: FloatArray = pose[:2] + rotate(half, pose[2])
    return corners
