"""Pictures from every lens of every robot, read into neighbours and tracked.

Each robot takes in what has arrived, see :mod:`swarmvision.sensing.exposures`: its lenses are rendered,
spoiled, read, fused into the robot's frame and handed to its tracks. Robots are independent of each
other, so a pool of threads works on shares of them in any order and the result is the same for any
number of workers.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
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
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.perception.fuse import lens_rows
from swarmvision.perception.track import Beliefs, Law, Tracks, forget
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.rendering.raycast import Raycaster
from swarmvision.sensing.exposures import Exposures, Looks, between
from swarmvision.sensing.watch import anticipate, follow, settle

__all__ = ["CameraSensor", "between"]

Image = NDArray[np.uint8]
SHARES = 4  # of the robots for each worker: who has done with one takes the next


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
            config: Lens, rig, rate, latency, imperfections, method, memory and faults.
            robot: What the robots look like and how they drive.
            arena: Where they are.
            robots: How many.
            seed: Of the run; every picture's chance follows from it and from whose picture it is.
            keep_pictures: Whether :attr:`pictures` holds the newest ones.
            workers: Threads; as many as the machine has cores where not given.
        """
        self.rig = Rig.from_config(config.lens, config.rig)
        self._reach, self._law = config.reach, Law.of(config.tracker)
        self._keep = keep_pictures
        self._kept: list[list[Picture]] = [[] for _ in range(robots)]
        self._reader = Reader(self.rig.lens, Marker.from_config(robot.marker), config.method)
        self._renderer, parallel = _renderer(config, self.rig, robot, arena)
        self._imperfections = Imperfections(config.imperfections, self.rig.lens)
        self._exposures = Exposures(
            config, self.rig, Drive.from_config(robot), self._imperfections, robots, seed
        )
        self._tracks, self._beliefs = Tracks.of(robots), Beliefs.of(robots)
        self._buffers = threading.local()
        cores = workers if workers is not None else len(os.sched_getaffinity(0))
        self._workers = max(min(cores, robots), 1) if parallel else 1
        # The thread that asks works too.
        self._pool = ThreadPoolExecutor(self._workers - 1) if self._workers > 1 else None
        cv2.setNumThreads(1)  # the threads are ours; OpenCV's own would fight them

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """What was photographed in the newest call of :meth:`sense`, if pictures are kept."""
        return tuple(picture for kept in self._kept for picture in kept)

    def sense(self, scene: Scene) -> Estimates:
        """Return what each robot believes at the scene's time, from every picture that has arrived."""
        self._exposures.note(scene)
        looks, since = self._exposures.arrived(scene.time), self._exposures.since(scene)
        count = min(self._workers * SHARES if self._workers > 1 else 1, max(scene.robots, 1))
        bounds = np.linspace(0, scene.robots, count + 1).astype(int).tolist()
        shares = iter(list(pairwise(bounds)))
        others = (
            [self._pool.submit(self._work, shares, looks, since) for _ in range(self._workers - 1)]
            if self._pool
            else []
        )
        self._work(shares, looks, since)
        for other in others:
            other.result()
        return self._beliefs.estimates()

    def _work(self, shares: Iterator[tuple[int, int]], looks: Looks, since: FloatArray) -> None:
        """Catch up with shares of the robots until none is left."""
        for first, last in shares:
            for robot in range(first, last):
                self._kept[robot] = []
                for look in range(looks.start[robot], looks.start[robot + 1]):
                    self._look(looks, look)
            settle(self._tracks, first, last, since, self._law, self._beliefs)

    def _look(self, looks: Looks, look: int) -> None:
        """Photograph, read, fuse and track what one robot sees in one look."""
        robot = int(looks.robot[look])
        anticipate(self._tracks, robot, looks.motion[look], self._law)
        lenses = np.nonzero(~looks.lost[look])[0]
        if len(lenses) == 0:
            forget(self._tracks, robot, self._law)
            return
        readings = [self._read(looks, look, int(lens)) for lens in lenses]
        counts = [len(reading.seen) for reading in readings]
        polar, covariance = np.empty((sum(counts), 4)), np.empty((sum(counts), 3, 3))
        end = 0
        for reading, count in zip(readings, counts, strict=True):
            lens_rows(reading, polar[end : end + count], covariance[end : end + count])
            end += count
        lens_of = np.repeat(lenses, counts)
        follow(self._tracks, robot, polar, covariance, lens_of, looks.mount[look], self._reach, self._law)

    def _read(self, looks: Looks, look: int, lens: int) -> Estimates:
        """Return what one lens reads."""
        robot, pose = int(looks.robot[look]), looks.pose[look, lens]
        scene = self._exposures.scenes[int(looks.scene[look, lens])]
        image = self._renderer.render(scene, pose, robot, None if self._keep else self._buffer())
        self._imperfections.spoil(image, int(looks.key[look, lens]), float(looks.turn_rate[look, lens]))
        reading = self._reader.read(image)
        if self._keep:
            self._kept[robot].append(Picture(robot, lens, pose, image, reading))
        return reading

    def _buffer(self) -> Image:
        if not hasattr(self._buffers, "image"):
            lens = self.rig.lens
            self._buffers.image = np.empty((lens.height_px, lens.width_px, 3), dtype=np.uint8)
        image: Image = self._buffers.image
        return image


def _renderer(
    config: CameraSensorConfig, rig: Rig, robot: RobotConfig, arena: ArenaConfig
) -> tuple[Renderer, bool]:
    """Return the renderer, and whether threads may share it: OpenGL belongs to the thread that began it."""
    if config.renderer == "raycast":
        return Raycaster(rig.lens, robot, arena), True
    from swarmvision.rendering.mesh import MeshRenderer

    return MeshRenderer(rig.lens, robot, arena), False
