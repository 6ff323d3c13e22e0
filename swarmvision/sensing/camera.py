"""Pictures from every lens of every robot, read into neighbours and tracked.

One exposure of the whole swarm at a time: each robot's lenses are rendered, spoiled, read, fused
into the robot's frame and handed to its tracker. Robots are independent of each other, so a pool
of threads works on them in any order and the result is the same for any number of workers.
"""

from __future__ import annotations

import copy
import math
import os
import threading
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Rig
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import CameraSensorConfig
from swarmvision.data import Estimates, Picture, Scene
from swarmvision.drive import Drive
from swarmvision.geometry import FloatArray, compose, wrap
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.perception.fuse import robot_frame
from swarmvision.perception.track import Tracker
from swarmvision.randomness import Subsystem, hashed
from swarmvision.rendering.imperfections import add_noise
from swarmvision.rendering.raycast import Raycaster

Image = NDArray[np.uint8]
CLOCK_SLACK = 1e-9  # s; sums of control periods are not exact


class Renderer(Protocol):
    """Draws what one lens sees."""

    def render(
        self, scene: Scene, lens_pose: FloatArray, observer: int | None = None, out: Image | None = None
    ) -> Image:
        """Return the picture ``(h, w, 3)`` of the scene from a lens pose ``(3,)`` in the world."""
        ...


class CameraSensor:
    """The cameras of all robots, their readers and their trackers."""

    def __init__(
        self,
        config: CameraSensorConfig,
        robot: RobotConfig,
        arena: ArenaConfig,
        robots: int,
        seed: int,
        *,
        keep_pictures: bool = False,
        workers: int | None = None,
    ) -> None:
        """Set up one rig, reader and tracker per robot.

        Args:
            config: Lens, rig, rate, latency, noise, method and memory.
            robot: What the robots look like and how they drive.
            arena: Where they are.
            robots: How many.
            seed: Of the run; every picture's noise follows from it and from whose picture it is.
            keep_pictures: Whether :attr:`pictures` holds the newest ones.
            workers: Threads; as many as the machine has cores where not given.
        """
        self.rig = Rig.from_config(config.lens, config.rig)
        self.pictures: tuple[Picture, ...] = ()
        self._config = config
        self._seed = seed
        self._keep = keep_pictures
        self._drive = Drive.from_config(robot)
        self._reader = Reader(self.rig.lens, Marker.from_config(robot.marker), config.method)
        self._renderer, parallel = _renderer(config, self.rig, robot, arena)
        self._trackers = [Tracker(config.tracker) for _ in range(robots)]
        self._scenes: deque[Scene] = deque()
        self._next_exposure = 0
        self._tracked_until = 0.0
        self._buffers = threading.local()
        cores = workers if workers is not None else len(os.sched_getaffinity(0))
        self._pool = ThreadPoolExecutor(cores) if parallel and cores > 1 and robots > 1 else None
        cv2.setNumThreads(1)  # the threads are ours; OpenCV's own would fight them

    def sense(self, scene: Scene) -> Estimates:
        """Return what each robot believes at the scene's time, from every picture that has arrived."""
        self._scenes.append(scene)
        self.pictures = ()
        while (exposed := self._next_exposure / self._config.rate_hz) + self._config.latency <= (
            scene.time + CLOCK_SLACK
        ):
            self._expose(min(exposed, scene.time))
            self._next_exposure += 1
        while len(self._scenes) > 2 and self._scenes[1].time <= self._oldest_needed():
            self._scenes.popleft()
        return Estimates.stack([self._now(i, scene.time) for i in range(scene.robots)])

    def _oldest_needed(self) -> float:
        return min(self._tracked_until, self._next_exposure / self._config.rate_hz)

    def _expose(self, time: float) -> None:
        """Take, read and track one picture of every lens at a time (s) that has passed."""
        scene = self._scene_at(time)
        robot_from_lens = self.rig.robot_from_lens(time)
        travelled = self._travelled(self._tracked_until, time)

        def look(robot: int) -> list[Picture]:
            pictures, neighbours = self._look(robot, scene, robot_from_lens)
            self._trackers[robot].step(neighbours, *travelled[robot])
            return pictures

        robots = range(scene.robots)
        looks: list[list[Picture]] = list((self._pool.map if self._pool else map)(look, robots))
        self._tracked_until = time
        if self._keep:
            self.pictures = tuple(picture for pictures in looks for picture in pictures)

    def _look(self, robot: int, scene: Scene, robot_from_lens: FloatArray) -> tuple[list[Picture], Estimates]:
        """Return a robot's pictures, if they are kept, and the neighbours read from them."""
        poses = compose(scene.pose[robot], robot_from_lens)
        pictures, readings = [], []
        for lens, pose in enumerate(poses):
            image = self._renderer.render(scene, pose, robot, None if self._keep else self._buffer())
            if self._config.noise_std > 0.0:
                key = hashed(self._seed, Subsystem.SENSOR, robot, lens, self._next_exposure)
                add_noise(image, self._config.noise_std, key)
            reading = self._reader.read(image)
            readings.append(reading)
            if self._keep:
                pictures.append(Picture(robot, lens, pose, image, reading))
        neighbours = robot_frame(readings, robot_from_lens)
        return pictures, neighbours.select(neighbours.range <= self._config.reach)

    def _now(self, robot: int, time: float) -> Estimates:
        """Return a robot's tracks carried on from the newest picture to a time (s)."""
        tracker = copy.copy(self._trackers[robot])  # its own state must stay at the exposure
        speed, turn_rate, dt = self._travelled(self._tracked_until, time)[robot]
        return tracker.step(None, speed, turn_rate, dt)

    def _travelled(self, start: float, end: float) -> list[tuple[float, float, float]]:
        """Return each robot's mean speed (m/s) and turn rate (rad/s) by its encoders, and the time (s)."""
        dt = max(end - start, 0.0)
        first, last = self._scene_at(start), self._scene_at(end)
        if dt == 0.0:
            return [(0.0, 0.0, 0.0)] * last.robots
        speed, turn_rate = self._drive.twist((last.wheel_travel - first.wheel_travel) / dt)
        return [(float(v), float(w), dt) for v, w in zip(speed, turn_rate, strict=True)]

    def _scene_at(self, time: float) -> Scene:
        """Return the scene at a time (s) between the oldest and the newest that are kept."""
        after = next((i for i, scene in enumerate(self._scenes) if scene.time >= time), -1)
        if after <= 0 or math.isclose(self._scenes[after].time, time, abs_tol=CLOCK_SLACK):
            return self._scenes[after]
        before, later = self._scenes[after - 1], self._scenes[after]
        return between(before, later, (time - before.time) / (later.time - before.time))

    def _buffer(self) -> Image:
        if not hasattr(self._buffers, "image"):
            lens = self.rig.lens
            self._buffers.image = np.empty((lens.height_px, lens.width_px, 3), dtype=np.uint8)
        image: Image = self._buffers.image
        return image


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


def _renderer(
    config: CameraSensorConfig, rig: Rig, robot: RobotConfig, arena: ArenaConfig
) -> tuple[Renderer, bool]:
    """Return the renderer, and whether threads may share it: OpenGL belongs to the thread that began it."""
    if config.renderer == "raycast":
        return Raycaster(rig.lens, robot, arena), True
    from swarmvision.rendering.mesh import MeshRenderer

    return MeshRenderer(rig.lens, robot, arena), False
