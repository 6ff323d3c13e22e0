"""Pictures from every lens of every robot, read into neighbours and tracked.

Each robot takes in what has arrived, see :mod:`swarmvision.sensing.exposures`: its lenses are rendered,
spoiled, read, fused into the robot's frame and handed to its tracks, see
:mod:`swarmvision.sensing.watch`. Robots are independent of each other, so threads take them one by one,
each who is next, and the result is the same for any number of workers.
"""

from __future__ import annotations

import os
from collections.abc import Collection
from concurrent.futures import Future, ThreadPoolExecutor

import cv2
import numpy as np

from swarmvision.camera import Rig
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import CameraSensorConfig
from swarmvision.data import Estimates, Picture, Scene
from swarmvision.drive import Drive
from swarmvision.perception.track import Beliefs, Tracks
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.sensing.exposures import Exposures, between
from swarmvision.sensing.watching import watcher

__all__ = ["CameraSensor", "between"]


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
        idle: Collection[int] = (),
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
            idle: Robots whom nobody asks what they see, and who take no pictures therefore.
        """
        self.rig = Rig.from_config(config.lens, config.rig)
        imperfections = Imperfections(config.imperfections, self.rig.lens)
        drive = Drive.from_config(robot)
        self._exposures = Exposures(config, self.rig, drive, imperfections, robots, seed, idle)
        self._watcher = watcher(config, robot, arena, self.rig.lens, imperfections, robots, keep_pictures)
        self._tracks, self._beliefs = Tracks.of(robots), Beliefs.of(robots)
        cores = workers if workers is not None else len(os.sched_getaffinity(0))
        self._workers = max(min(cores, robots), 1) if self._watcher.parallel else 1
        # The thread that asks works too.
        self._pool = ThreadPoolExecutor(self._workers - 1) if self._workers > 1 else None
        cv2.setNumThreads(1)  # the threads are ours; OpenCV's own would fight them

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """What was photographed in the newest call of :meth:`sense`, if pictures are kept."""
        return tuple(picture for kept in self._watcher.pictures for picture in kept)

    def sense(self, scene: Scene) -> Estimates:
        """Return what each robot believes at the scene's time, from every picture that has arrived."""
        self._exposures.note(scene)
        looks, since = self._exposures.arrived(scene.time), self._exposures.since(scene)
        self._watcher.prepare(looks, self._exposures.scenes)
        work = (np.zeros(1, np.int64), since, self._tracks, self._beliefs)
        others: list[Future[None]] = []
        if self._pool is not None:
            others = [self._pool.submit(self._watcher.watch, *work) for _ in range(self._workers - 1)]
        self._watcher.watch(*work)
        for other in others:
            other.result()
        return self._beliefs.estimates()
