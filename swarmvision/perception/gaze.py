"""Where in a picture tracked neighbours should be, so that the rest need not be looked at. Kernels.

A picture is looked at everywhere often enough to find who is new; between, in windows round the places
that a robot's tracks predict. A window has the grid of the whole look, so a marker that stands in one is
read to the same bits. Farther markers than a robot cares about are not measured at all.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray
from swarmvision.perception.look import Ints, everywhere
from swarmvision.perception.plan import BASE, HEIGHT, INNER_BOTTOM, INNER_TOP, RADIUS, Task
from swarmvision.perception.track import MOST_TRACKS, Tracks

SIGMAS = 4.0  # of a track's place
PLACE_SLACK = 0.01  # m: what an observer's encoders may be wrong by since the last picture
ANGLE_SLACK = 0.015  # rad: what rolling shutter and blur may shift a marker by
RISE_SLACK = 0.02  # rad: by which a camera may look up or down
MARGIN = 4  # columns of the grid, one of its widest steps
DOOR = 8  # columns of the grid at either side of the picture, where who is new comes in: always looked at
ROW_MARGIN = 2  # rows that are looked at
WIDEST = 1.4  # rad off the axis: the sides of a level picture are never farther
COARSE = 2.0  # rows of the grid by which the look may be wrong about a marker's height


class Gaze(NamedTuple):
    """Which part of a picture is looked at, and what is worth measuring there."""

    windows: Ints
    """First and last + 1 column of the grid and place in the rows that are looked at, ``(n, 4)``; they share
    no column. Those of a whole picture are never written."""
    least: float
    """Markers whose middle is less high (px) are left out."""

    @classmethod
    def at_all(cls, task: Task) -> Gaze:
        """Return the look at all of a picture that leaves nothing out."""
        return cls(everywhere(task.look), 0.0)


class Aim(NamedTuple):
    """How a robot's lens is aimed at its tracks."""

    everywhere: Ints
    """The window that is the whole picture, ``(1, 4)``."""
    least: float
    """As in :class:`Gaze`."""

    @classmethod
    def of(cls, task: Task, farthest: float) -> Aim:
        """Return the aim of a lens that need not tell who is farther away than that (m)."""
        tall = float(task.eye[0] * (task.heights[INNER_TOP] - task.heights[INNER_BOTTOM]))
        return cls(everywhere(task.look), tall / farthest - COARSE * task.look.down)


def windows_room() -> Ints:
    """Return room for the windows of one robot's tracks."""
    return np.empty((MOST_TRACKS + 2, 4), dtype=np.int32)


@compiled
def gaze(
    tracks: Tracks, robot: int, mount: FloatArray, task: Task, aim: Aim, whole: bool, room: Ints
) -> Gaze:
    """Return where a lens looks for a robot's tracks, predicted to the time of the picture, and at its sides.

    Everywhere if asked to, where the robot knows nobody, or where one that should be in the picture was
    lost in the look before.

    Args:
        tracks: Of all robots.
        robot: Whose lens it is.
        mount: x, y, yaw of the lens on the robot ``(3,)``.
        task: What is looked for, and by which lens.
        aim: Of that lens.
        whole: Whether it is time to look everywhere.
        room: For windows, see :func:`windows_room`.
    """
    if whole or tracks.used[robot] == 0:
        return Gaze(aim.everywhere, aim.least)
    width = len(task.look.columns)
    last = 4 * (max(width - DOOR, 0) // 4)
    room[0, 0], room[0, 1], room[0, 2], room[0, 3] = 0, DOOR, task.look.near[0], task.look.near[1]
    room[1, 0], room[1, 1], room[1, 2], room[1, 3] = last, width, task.look.near[0], task.look.near[1]
    count = 2
    if width < 2 * DOOR:
        return Gaze(aim.everywhere, aim.least)
    for i in range(tracks.used[robot]):
        if not _window(tracks.state[robot, i], tracks.covariance[robot, i], mount, task, room[count]):
            continue
        if tracks.missed[robot, i] == 1:
            return Gaze(aim.everywhere, aim.least)
        count = _joined(room, count)
    return Gaze(room[:count], aim.least)


@compiled
def _window(state: FloatArray, covariance: FloatArray, mount: FloatArray, task: Task, window: Ints) -> bool:
    """Write the window of a track; return whether any of it is in the picture."""
    focal, middle, level, lens = task.eye[0], task.eye[1], task.eye[2], task.eye[3]
    look, radius = task.look, task.heights[RADIUS]
    cos, sin = math.cos(mount[2]), math.sin(mount[2])
    x, y = state[0] - mount[0], state[1] - mount[1]
    ahead, left = cos * x + sin * y, cos * y - sin * x
    distance = math.hypot(ahead, left)
    slack = SIGMAS * math.sqrt(covariance[0, 0] + covariance[1, 1]) + PLACE_SLACK
    width, high = len(look.columns), len(look.rows)
    window[0], window[1], window[2], window[3] = 0, width, 0, high
    nearest = distance - slack - radius
    if nearest <= radius:
        beside: bool = ahead > 0.0 or distance <= slack + 2.0 * radius
        return beside
    bearing = math.atan2(left, ahead)
    half = math.asin((radius + slack) / distance) + ANGLE_SLACK
    if abs(bearing) - half >= WIDEST:
        return False
    first = middle - focal * math.tan(min(bearing + half, WIDEST))
    last = middle - focal * math.tan(max(bearing - half, -WIDEST))
    # Steps of the look begin at every fourth column.
    window[0] = 4 * int(min(max(first / look.across - MARGIN, 0.0), float(width)) / 4.0)
    window[1] = min(4 * (int(max(last / look.across + MARGIN, 0.0) / 4.0) + 1), width)
    if window[0] >= window[1]:
        return False
    depth = nearest * math.cos(min(abs(bearing) + half, WIDEST))
    top = level - focal * (max(task.heights[BASE] + task.heights[HEIGHT] - lens, 0.0) / depth + RISE_SLACK)
    foot = level - focal * (min(task.heights[BASE] - lens, 0.0) / depth - RISE_SLACK)
    begin, end = 0, high
    while begin < high and look.rows[begin] < top:
        begin += 1
    while end > begin and look.rows[end - 1] > foot:
        end -= 1
    window[2], window[3] = max(begin - ROW_MARGIN, 0), min(end + ROW_MARGIN, high)
    inside: bool = window[2] < window[3]
    return inside


@compiled
def _joined(windows: Ints, count: int) -> int:
    """Join the window behind ``count`` others with those that it touches; return how many are left."""
    i = 0
    while i < count:
        one, new = windows[i], windows[count]
        if one[0] > new[1] or new[0] > one[1]:
            i += 1
            continue
        new[0], new[1] = min(one[0], new[0]), max(one[1], new[1])
        new[2], new[3] = min(one[2], new[2]), max(one[3], new[3])
        count -= 1
        for k in range(4):  # the last of the others into the gap, the new one behind them
            windows[i, k] = windows[count, k]
            windows[count, k] = windows[count + 1, k]
        i = 0  # it is wider now
    return count + 1
