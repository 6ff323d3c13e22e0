"""Looks into beliefs: what robots' lenses show is drawn, spoiled, read, fused and tracked. Kernels.

:func:`watch` is the whole way for all robots in one call of each thread, without the interpreter; the
steps behind the reading are here as functions of their own, for readers and renderers that are not
kernels.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from swarmvision.camera import Lens
from swarmvision.compiled import compiled
from swarmvision.compiled.ticket import Counter, ticket
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception.cylinder import BEARING, HEADING, RANGE, RANGE_STD, VISIBLE
from swarmvision.perception.edges import MOST, ROW, read_edges_into
from swarmvision.perception.fuse import fuse
from swarmvision.perception.gaze import Aim, gaze, windows_room
from swarmvision.perception.look import Ints
from swarmvision.perception.plan import Scratch, Task
from swarmvision.perception.track import Beliefs, Law, Tracks, believe, forget, predict, take_in
from swarmvision.rendering.blur import Image
from swarmvision.rendering.exposing import expose
from swarmvision.rendering.raycast import Raycaster
from swarmvision.rendering.spoiling import Dirt, Faults
from swarmvision.rendering.stage import Scratch as Brushes
from swarmvision.rendering.stage import Stage
from swarmvision.sensing.exposures import Looks


class Scenes(NamedTuple):
    """What the looks show, ``s`` scenes."""

    robots: FloatArray
    """Poses, shape ``(s, r, 3)``."""
    objects: FloatArray
    """Poses, shape ``(s, m, 3)``."""
    slot: IntArray
    """Which of them each lens of each look shows, shape ``(n, c)``."""


class Shutter(NamedTuple):
    """How much a rolling shutter in a turn adds to the spread of a reading, for each rad/s of the turn.

    The rings of a marker are exposed one after the other, and each stands where the lens looked at its
    time; a reading may follow either of them, or the slant that they make.
    """

    bearing: float
    """Times range (s m): from the middle of the marker to a ring."""
    heading: float
    """s: the same on the marker's own radius."""

    @classmethod
    def of(cls, lens: Lens, readout_time: float, marker: Marker) -> Shutter:
        """Return what reading out in a time (s) does to a marker."""
        way = readout_time * lens.focal_px / lens.height_px * marker.height / 2.0
        return cls(way, way / marker.radius)


class Habits(NamedTuple):
    """What is alike in all looks of all robots."""

    sight: float
    """Who is farther from a lens is not drawn (m)."""
    reach: float
    """Who is farther from the robot is left out (m)."""
    shutter: Shutter
    law: Law


class Desk(NamedTuple):
    """Memory of one thread."""

    picture: Image
    """Shape ``(h, w, 3)``."""
    lines: Image
    """The same memory, ``(h, 3 w)``."""
    brushes: Brushes
    dirt: Dirt
    reading: Scratch
    windows: Ints
    """Where tracks should be in one picture, ``(MOST_TRACKS, 4)``."""
    markers: FloatArray
    """What one picture tells, ``(MOST, ROW)``."""
    near: FloatArray
    """Poses of the robots that are drawn, room for all, ``(r, 3)``."""
    polar: FloatArray
    """What one look tells: range, bearing, heading, visible, ``(n, 4)``."""
    covariance: FloatArray
    """Of the first three, ``(n, 3, 3)``."""
    lens: IntArray
    """Which lens saw it, ``(n,)``."""

    @classmethod
    def of(cls, eye: Lens, raycaster: Raycaster, faults: Faults, robots: int, lenses: int) -> Desk:
        """Return memory for looks with a number of lenses at scenes with a number of robots."""
        picture, most = np.empty((eye.height_px, eye.width_px, 3), np.uint8), MOST * lenses
        return cls(
            picture=picture,
            lines=picture.reshape(eye.height_px, -1),
            brushes=raycaster.scratch(robots),
            dirt=Dirt.of(eye.width_px, faults),
            reading=Scratch.of(eye.width_px, eye.height_px),
            windows=windows_room(),
            markers=np.empty((MOST, ROW)),
            near=np.empty((robots, 3)),
            polar=np.empty((most, 4)),
            covariance=np.empty((most, 3, 3)),
            lens=np.empty(most, np.int64),
        )


@compiled
def watch(
    counter: Counter,
    looks: Looks,
    scenes: Scenes,
    stage: Stage,
    faults: Faults,
    task: Task,
    aim: Aim,
    desk: Desk,
    since: FloatArray,
    tracks: Tracks,
    beliefs: Beliefs,
    habits: Habits,
) -> None:
    """Do all looks of robots, and tell what they believe, until no robot is left.

    Args:
        counter: Of all threads that share the robots: whose turn it is.
        looks: Of all robots.
        scenes: What they show.
        stage: Of the ray caster.
        faults: Of the cameras.
        task: Of the reader.
        aim: Of all lenses.
        desk: Of this thread alone.
        since: Speed, turn rate and time of each robot since its last look, ``(r, 3)``.
        tracks: Of all robots.
        beliefs: Out: of all robots.
        habits: Of all robots.
    """
    robot = ticket(counter)
    while robot < len(since):
        for look in range(looks.start[robot], looks.start[robot + 1]):
            anticipate(tracks, robot, looks.motion[look], habits.law)
            told, pictures = 0, 0
            for lens in range(looks.lost.shape[1]):
                if looks.lost[look, lens]:
                    continue
                pictures += 1
                slot = scenes.slot[look, lens]
                pose, turn_rate = looks.pose[look, lens], looks.turn_rate[look, lens]
                near = gather_near(scenes.robots[slot], robot, pose, habits.sight, desk.near)
                expose(
                    desk.lines,
                    pose,
                    desk.near[:near],
                    -1,
                    scenes.objects[slot],
                    stage,
                    desk.brushes,
                    looks.key[look, lens],
                    turn_rate,
                    faults,
                    desk.dirt,
                )
                where = gaze(
                    tracks, robot, looks.mount[look, lens], task, aim, looks.search[look, lens], desk.windows
                )
                count = read_edges_into(desk.picture, task, where, desk.reading, desk.markers)
                told = _note(desk.markers, count, lens, told, desk.polar, desk.covariance, desk.lens)
            if pictures > 0:
                follow(
                    tracks,
                    robot,
                    desk.polar[:told],
                    desk.covariance[:told],
                    desk.lens[:told],
                    looks.mount[look],
                    looks.turning[look],
                    habits,
                )
            else:
                lose_sight(tracks, robot, habits.law)
        settle(tracks, robot, since[robot], habits.law, beliefs)
        robot = ticket(counter)


@compiled
def gather_near(robots: FloatArray, observer: int, pose: FloatArray, sight: float, near: FloatArray) -> int:
    """Write the poses of all other robots within sight (m) of a lens; return how many there are."""
    count = 0
    for i in range(len(robots)):
        x, y = robots[i, 0] - pose[0], robots[i, 1] - pose[1]
        if i != observer and x * x + y * y <= sight * sight:
            for k in range(3):
                near[count, k] = robots[i, k]
            count += 1
    return count


@compiled
def _note(
    markers: FloatArray,
    count: int,
    lens: int,
    told: int,
    polar: FloatArray,
    covariance: FloatArray,
    lens_of: IntArray,
) -> int:
    """Put what one picture tells behind what is told already; return how much that is then."""
    for i in range(min(count, len(polar) - told)):
        polar[told, 0], polar[told, 1] = markers[i, RANGE], markers[i, BEARING]
        polar[told, 2], polar[told, 3] = markers[i, HEADING], min(markers[i, VISIBLE], 1.0)
        for k in range(3):
            for m in range(3):
                covariance[told, k, m] = markers[i, RANGE_STD + k] ** 2 if k == m else 0.0
        lens_of[told] = lens
        told += 1
    return told


@compiled
def anticipate(tracks: Tracks, robot: int, motion: FloatArray, law: Law) -> None:
    """Carry a robot's tracks on to its next look; ``motion`` is speed, turn rate and time ``(3,)``."""
    predict(tracks, robot, motion[0], motion[1], motion[2], law)


@compiled
def follow(
    tracks: Tracks,
    robot: int,
    polar: FloatArray,
    covariance: FloatArray,
    lens: IntArray,
    mount: FloatArray,
    turning: FloatArray,
    habits: Habits,
) -> None:
    """Take in what all lenses of a robot read at once; other arguments as for :func:`fuse`.

    Args:
        tracks: Of all robots.
        robot: Who looks.
        polar: See there.
        covariance: Likewise; here it grows by what a turn does.
        lens: Likewise.
        mount: Likewise.
        turning: Of each lens (rad/s), ``(lenses,)``.
        habits: Of all robots.
    """
    for i in range(len(polar)):
        turn = turning[lens[i]]
        covariance[i, 1, 1] += (turn * habits.shutter.bearing / polar[i, 0]) ** 2
        covariance[i, 2, 2] += (turn * habits.shutter.heading) ** 2  # nan where it is not told
    rows, spreads = np.empty((len(polar), 4)), np.empty((len(polar), 3, 3))
    count = fuse(polar, covariance, lens, mount, habits.reach, rows, spreads)
    take_in(tracks, robot, rows[:count], spreads[:count], habits.law)
    forget(tracks, robot, habits.law)


@compiled
def lose_sight(tracks: Tracks, robot: int, law: Law) -> None:
    """End a look of which no picture arrived."""
    forget(tracks, robot, law)


@compiled
def settle(tracks: Tracks, robot: int, motion: FloatArray, law: Law, beliefs: Beliefs) -> None:
    """Write what a robot believes; ``motion`` ``(3,)`` is since its last look, as for :func:`anticipate`."""
    believe(tracks, robot, motion[0], motion[1], motion[2], law, beliefs)
