"""Pictures from every lens of every robot, read into neighbours and tracked.

All robots expose at the same times; those scenes are noted as they pass. Each robot then takes in what
has arrived, in the order in which it was taken: its lenses are rendered, spoiled, read, fused into
the robot's frame and handed to its tracker. A picture may be lost (then the tracker coasts) or late
(then it and those behind it wait). Robots are independent of each other, so a pool of threads works
on them in any order and the result is the same for any number of workers.
"""

from __future__ import annotations

import copy
import math
import os
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
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
from swarmvision.rendering.imperfections import Imperfections
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


@dataclass(eq=False, slots=True)
class _Eyes:
    """How far one robot has got with its pictures."""

    tracker: Tracker
    exposures: int = 0
    """Taken in; the number of the next one."""
    scene: Scene | None = None
    """Of the last one."""
    pictures: list[Picture] = field(default_factory=list)


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
            config: Lens, rig, rate, latency, imperfections, method and memory.
            robot: What the robots look like and how they drive.
            arena: Where they are.
            robots: How many.
            seed: Of the run; every picture's chance follows from it and from whose picture it is.
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
        self._imperfections = Imperfections(config.imperfections, self.rig.lens)
        self._eyes = [_Eyes(Tracker(config.tracker)) for _ in range(robots)]
        self._newest: Scene | None = None
        self._exposed: dict[int, Scene] = {}
        self._buffers = threading.local()
        cores = workers if workers is not None else len(os.sched_getaffinity(0))
        self._pool = ThreadPoolExecutor(cores) if parallel and cores > 1 and robots > 1 else None
        cv2.setNumThreads(1)  # the threads are ours; OpenCV's own would fight them

    def sense(self, scene: Scene) -> Estimates:
        """Return what each robot believes at the scene's time, from every picture that has arrived."""
        self._expose(scene)

        def catch_up(robot: int) -> Estimates:
            return self._catch_up(robot, self._eyes[robot], scene)

        estimates = list((self._pool.map if self._pool else map)(catch_up, range(scene.robots)))
        self.pictures = tuple(picture for eyes in self._eyes for picture in eyes.pictures)
        read = min((eyes.exposures for eyes in self._eyes), default=0)
        # The last exposure that was read tells how far the robot has come since.
        self._exposed = {number: taken for number, taken in self._exposed.items() if number >= read - 1}
        return Estimates.stack(estimates)

    def _expose(self, scene: Scene) -> None:
        """Note the scenes of all exposures since the newest scene, up to this one."""
        rate, before = self._config.rate_hz, self._newest or scene
        first = 0 if self._newest is None else math.floor((before.time + CLOCK_SLACK) * rate) + 1
        for number in range(first, math.floor((scene.time + CLOCK_SLACK) * rate) + 1):
            passed, step = number / rate - before.time, scene.time - before.time
            now = passed >= step - CLOCK_SLACK
            self._exposed[number] = scene if now else between(before, scene, passed / step)
        self._newest = scene

    def _catch_up(self, robot: int, eyes: _Eyes, scene: Scene) -> Estimates:
        """Take in a robot's pictures that have arrived by now, in the order in which they were taken."""
        eyes.pictures = []
        while (taken := self._exposed.get(eyes.exposures)) is not None:
            keys = self._keys(robot, eyes.exposures)
            # What is late holds up what was taken after it.
            due = eyes.exposures / self._config.rate_hz + self._config.latency
            if due + self._imperfections.delay(keys[0]) > scene.time + CLOCK_SLACK:
                break
            lenses = [lens for lens, key in enumerate(keys) if not self._imperfections.is_lost(key)]
            seen = self._look(robot, eyes, taken, lenses, keys) if lenses else None
            eyes.tracker.step(seen, *self._travelled(robot, eyes, taken))
            eyes.scene = taken
            eyes.exposures += 1
        tracker = copy.copy(eyes.tracker)  # its own state must stay at the exposure
        return tracker.step(None, *self._travelled(robot, eyes, scene))

    def _keys(self, robot: int, exposure: int) -> list[int]:
        return [
            hashed(self._seed, Subsystem.SENSOR, robot, lens, exposure) for lens in range(len(self.rig.yaws))
        ]

    def _look(
        self, robot: int, eyes: _Eyes, scene: Scene, lenses: Sequence[int], keys: Sequence[int]
    ) -> Estimates:
        """Return the neighbours read from a robot's pictures by some of its lenses."""
        robot_from_lens = self.rig.robot_from_lens(scene.time)
        poses = compose(scene.pose[robot], robot_from_lens)
        turn_rate = float(scene.velocity[robot, 2])
        if self.rig.servo is not None:
            turn_rate += float(self.rig.servo.pan_rate(scene.time))
        eyes.pictures, readings = [], []
        for lens in lenses:
            image = self._renderer.render(scene, poses[lens], robot, None if self._keep else self._buffer())
            self._imperfections.spoil(image, keys[lens], turn_rate)
            reading = self._reader.read(image)
            readings.append(reading)
            if self._keep:
                eyes.pictures.append(Picture(robot, lens, poses[lens], image, reading))
        neighbours = robot_frame(readings, robot_from_lens[list(lenses)])
        return neighbours.select(neighbours.range <= self._config.reach)

    def _travelled(self, robot: int, eyes: _Eyes, scene: Scene) -> tuple[float, float, float]:
        """Return mean speed (m/s), turn rate (rad/s) by the encoders and time (s) since the last picture."""
        if eyes.scene is None or scene.time <= eyes.scene.time:
            return 0.0, 0.0, 0.0
        dt = scene.time - eyes.scene.time
        way = scene.wheel_travel[robot] - eyes.scene.wheel_travel[robot]
        speed, turn_rate = self._drive.twist(way / dt)
        return float(speed), float(turn_rate), dt

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
