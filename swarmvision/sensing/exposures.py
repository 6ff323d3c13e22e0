"""When the cameras expose, what has arrived of it, and from where each lens looked.

All robots expose at the same times; those scenes are noted as they pass. A picture may be lost, or
late: then it and those behind it wait. A dead robot's pictures are all lost; a stuck lens goes on
showing what it showed in its first picture.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from swarmvision.camera import Rig
from swarmvision.config.sensor import CameraSensorConfig
from swarmvision.data import BoolArray, IntArray, Scene
from swarmvision.drive import Drive
from swarmvision.geometry import FloatArray, compose, wrap
from swarmvision.randomness import Subsystem, hashed, numbered
from swarmvision.rendering.imperfections import Imperfections

CLOCK_SLACK = 1e-9  # s; sums of control periods are not exact


class Looks(NamedTuple):
    """What robots take in at once, robot by robot, each in the order of its exposures; ``c`` lenses."""

    robot: IntArray
    """Shape ``(n,)``."""
    start: IntArray
    """Looks of robot ``i`` are those from ``start[i]`` to ``start[i + 1]``, shape ``(r + 1,)``."""
    scene: IntArray
    """Which of :attr:`Exposures.scenes` each lens shows, shape ``(n, c)``."""
    pose: FloatArray
    """Of each lens in the world when it took that: x, y, yaw, shape ``(n, c, 3)``."""
    turn_rate: FloatArray
    """Of each lens in the world then (rad/s), shape ``(n, c)``."""
    key: IntArray
    """Decides all chance in the picture, shape ``(n, c)``."""
    lost: BoolArray
    """Whether a picture never arrives, shape ``(n, c)``."""
    turning: FloatArray
    """What the robot takes for the turn rate of each lens: by its encoders and servo (rad/s), ``(n, c)``."""
    mount: FloatArray
    """Of each lens on the robot at the exposure: x, y, yaw, shape ``(n, c, 3)``."""
    search: BoolArray
    """Whether the picture is to be looked at everywhere, for neighbours that are new, ``(n, c)``."""
    motion: FloatArray
    """Mean speed (m/s), turn rate (rad/s) by the encoders, time (s) since the exposure before, ``(n, 3)``."""


class Exposures:
    """The exposures of all robots' cameras, and how far each robot has got with taking them in."""

    def __init__(
        self,
        config: CameraSensorConfig,
        rig: Rig,
        drive: Drive,
        imperfections: Imperfections,
        robots: int,
        seed: int,
        idle: Collection[int] = (),
    ) -> None:
        """Begin before the first exposure.

        Args:
            config: Rate, latency and faults.
            rig: Where the lenses sit.
            drive: Tells a robot's way from its encoders.
            imperfections: Say what is lost or late.
            robots: How many.
            seed: Of the run.
            idle: Robots that take no pictures.
        """
        self.scenes: dict[int, Scene] = {}
        """By the number of the exposure; those that somebody still needs."""
        self._rate, self._latency = config.rate_hz, config.latency
        self._every = max(int(config.rate_hz * config.tracker.search + CLOCK_SLACK), 1)
        self._rig, self._drive, self._imperfections = rig, drive, imperfections
        self._newest: Scene | None = None
        self._next = 0
        self._taken = np.zeros(robots, dtype=np.int64)
        lenses = range(len(rig.yaws))
        keys = [hashed(seed, Subsystem.SENSOR, robot, lens) for robot in range(robots) for lens in lenses]
        self._keys = np.array(keys, dtype=np.uint64).reshape(robots, len(lenses))
        self._dead = np.isin(np.arange(robots), [*config.faults.dead, *idle])
        self._stuck = np.isin(np.arange(robots), config.faults.stuck)
        self._first = np.full(self._keys.shape, -1)
        """The exposure at which a stuck lens took its first picture; -1 before."""

    def note(self, scene: Scene) -> None:
        """Note the scenes of all exposures since the newest scene, up to this one."""
        before, newest = self._newest or scene, math.floor((scene.time + CLOCK_SLACK) * self._rate)
        if self._newest is None:  # what was exposed before there was a sensor is nobody's
            self._next = newest
            self._taken[:] = newest
        for number in range(self._next, newest + 1):
            passed, step = number / self._rate - before.time, scene.time - before.time
            now = passed >= step - CLOCK_SLACK or step <= 0.0
            self.scenes[number] = scene if now else between(before, scene, passed / step)
        self._newest, self._next = scene, newest + 1

    def arrived(self, time: float) -> Looks:
        """Return what has arrived by a time (s) and was not taken in before; now it is."""
        self._drop_old()
        robots, numbers = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
        waiting = np.arange(len(self._taken))
        while True:  # what is late holds up what was taken after it
            waiting = waiting[self._taken[waiting] < self._next]
            if len(waiting) > 0:
                waiting = waiting[self._due(waiting) <= time + CLOCK_SLACK]
            if len(waiting) == 0:
                break
            robots.append(waiting)
            numbers.append(self._taken[waiting])
            self._taken[waiting] += 1
        robot, number = np.concatenate(robots), np.concatenate(numbers)
        order = np.argsort(robot, kind="stable")
        return self._looks(robot[order], number[order])

    def since(self, scene: Scene) -> FloatArray:
        """Return mean speed, turn rate and time since the last exposure that each robot has, ``(r, 3)``."""
        robots = np.arange(len(self._taken))
        times = np.full(len(robots), scene.time)
        return self._motion(robots, self._taken - 1, scene.wheel_travel, times)

    def _drop_old(self) -> None:
        # The last exposure that was taken in tells how far the robot has come since.
        oldest = int(self._taken.min(initial=self._next)) - 1
        needed = set(self._first[self._first >= 0].tolist())
        self.scenes = {n: scene for n, scene in self.scenes.items() if n >= oldest or n in needed}

    def _due(self, robots: IntArray) -> FloatArray:
        number = self._taken[robots]
        late = self._imperfections.delay(numbered(self._keys[robots, 0], number))
        return number / self._rate + self._latency + late

    def _looks(self, robot: IntArray, number: IntArray) -> Looks:
        own = numbered(self._keys[robot], number[:, None])
        lost = self._imperfections.is_lost(own) | self._dead[robot, None]
        shown = self._shown(robot, number, lost)
        servo = self._rig.servo
        lens = np.arange(own.shape[1])
        n, c = own.shape
        pose, mount, turn_rate = np.empty((n, c, 3)), np.empty((n, c, 3)), np.empty((n, c))
        for i in {*shown.ravel().tolist(), *number.tolist()}:
            mounts = self._rig.robot_from_lens(i / self._rate)
            mount[number == i] = mounts
            look, column = np.nonzero(shown == i)
            if len(look) > 0:
                scene = self.scenes[i]
                pose[look, column] = compose(scene.pose[robot[look]], mounts[column])
                pan_rate = 0.0 if servo is None else float(servo.pan_rate(i / self._rate))
                turn_rate[look, column] = scene.velocity[robot[look], 2] + pan_rate
        motion = self._motion(robot, number - 1, *self._odometry(robot, number))
        pan = np.zeros(n) if servo is None else servo.pan_rate(number / self._rate)
        return Looks(
            robot=robot,
            start=np.searchsorted(robot, np.arange(len(self._taken) + 1)),
            scene=shown,
            pose=pose,
            turn_rate=turn_rate,
            key=numbered(self._keys[robot[:, None], lens], shown),
            lost=lost,
            turning=np.repeat((motion[:, 1] + pan)[:, None], c, axis=1),
            # Not all at once, so that no step has the work of many.
            search=(number[:, None] + robot[:, None] + lens) % self._every == 0,
            mount=mount,
            motion=motion,
        )

    def _shown(self, robot: IntArray, number: IntArray, lost: BoolArray) -> IntArray:
        """Return the exposure that each lens shows: its own, but the first delivered where it is stuck."""
        shown = np.repeat(number[:, None], lost.shape[1], axis=1)
        for look in np.nonzero(self._stuck[robot])[0]:
            first = self._first[robot[look]]
            begins = (first < 0) & ~lost[look]
            first[begins] = number[look]
            shown[look] = np.where(first >= 0, first, number[look])
        return shown

    def _motion(self, robot: IntArray, number: IntArray, way: FloatArray, time: FloatArray) -> FloatArray:
        """Return mean speed, turn rate and time from exposures (-1: none) to a later way and time."""
        earlier_way, earlier_time = self._odometry(robot, number, way, time)
        dt = time - earlier_time
        moved = dt > 0.0
        rates = self._drive.twist((way - earlier_way) / np.where(moved, dt, 1.0)[:, None])
        motion: FloatArray = np.where(moved[:, None], np.column_stack([*rates, dt]), 0.0)
        return motion

    def _odometry(
        self,
        robot: IntArray,
        number: IntArray,
        way: FloatArray | None = None,
        time: FloatArray | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Return the encoders' way ``(n, 2)`` and the time ``(n,)`` at exposures; as given if none."""
        n = len(robot)
        way = np.zeros((n, 2)) if way is None else way.copy()
        time = np.zeros(n) if time is None else time.copy()
        for i in set(number.tolist()) & self.scenes.keys():
            there = number == i
            way[there], time[there] = self.scenes[i].wheel_travel[robot[there]], self.scenes[i].time
        return way, time


def between(first: Scene, last: Scene, share: float) -> Scene:
    """Return the scene at a share (0..1) of the way from one to the next, poses along the short turn."""

    def mix(a: FloatArray, b: FloatArray) -> FloatArray:
        return a + share * (b - a)

    def mix_pose(a: FloatArray, b: FloatArray) -> FloatArray:
        pose = mix(a, b)
        pose[:, 2] = wrap(a[:, 2] + share * wrap(b[:, 2] - a[:, 2]))
        return pose

    return Scene(
        time=first.time + share * (last.time - first.time),
        pose=mix_pose(first.pose, last.pose),
        velocity=mix(first.velocity, last.velocity),
        wheel_speed=mix(first.wheel_speed, last.wheel_speed),
        wheel_travel=mix(first.wheel_travel, last.wheel_travel),
        object_pose=mix_pose(first.object_pose, last.object_pose),
        object_velocity=mix(first.object_velocity, last.object_velocity),
    )
