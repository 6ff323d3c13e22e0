"""Pictures from every lens of every robot, read into neighbours and tracked.

Each robot takes in what has arrived, see :mod:`swarmvision.sensing.exposures`: its lenses are rendered,
spoiled, read, fused into the robot's frame and handed to its tracks, see
:mod:`swarmvision.sensing.watch`. Robots are independent of each other, so a pool of threads works on
shares of them in any order and the result is the same for any number of workers.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator
from concurrent.futures import Future, ThreadPoolExecutor

import cv2

from swarmvision.camera import Rig
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import CameraSensorConfig
from swarmvision.data import Estimates, Picture, Scene
from swarmvision.drive import Drive
from swarmvision.geometry import FloatArray
from swarmvision.perception.track import Beliefs, Law, Tracks
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.sensing.exposures import Exposures, between
from swarmvision.sensing.watch import settle
from swarmvision.sensing.watching import watcher

__all__ = ["CameraSensor", "between"]

SHARES = 2  # of what is left for each worker: who has done with one takes the next, smaller one


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
        self._law = Law.of(config.tracker)
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
        shares = iter(_shares(scene.robots, self._workers))
        others: list[Future[None]] = []
        if self._pool is not None:
            others = [self._pool.submit(self._work, shares, since) for _ in range(self._workers - 1)]
        self._work(shares, since)
        for other in others:
            other.result()
        return self._beliefs.estimates()

    def _work(self, shares: Iterator[tuple[int, int]], since: FloatArray) -> None:
        """Catch up with shares of the robots until none is left."""
        for first, last in shares:
            self._watcher.watch(first, last, self._tracks)
            settle(self._tracks, first, last, since, self._law, self._beliefs)


def _shares(robots: int, workers: int) -> list[tuple[int, int]]:
    """Return first and last + 1 robot of each share.

    They shrink to a single robot, so that all workers end at about the same time whatever robots cost
    (C. D. Polychronopoulos, D. J. Kuck, IEEE Trans. Comput. C-36, 1987, doi:10.1109/TC.1987.5009495).
    """
    if workers == 1:
        return [(0, robots)] if robots > 0 else []
    shares, first = [], 0
    while first < robots:
        last = first + max((robots - first) // (SHARES * workers), 1)
        shares.append((first, last))
        first = last
    return shares
