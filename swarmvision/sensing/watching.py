"""Two ways to do the looks of robots: in one kernel, or object by object for what is no kernel."""

from __future__ import annotations

import threading
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.compiled.ticket import Counter, ticket
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import CameraSensorConfig
from swarmvision.data import Estimates, Picture, Scene
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.perception.fuse import lens_rows
from swarmvision.perception.gaze import Aim, Gaze, gaze, windows_room
from swarmvision.perception.plan import Task
from swarmvision.perception.track import Beliefs, Law, Tracks
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.rendering.raycast import Raycaster
from swarmvision.sensing.exposures import Looks
from swarmvision.sensing.watch import (
    Desk,
    Habits,
    Scenes,
    Shutter,
    anticipate,
    follow,
    gather_near,
    lose_sight,
    settle,
    watch,
)

Image = NDArray[np.uint8]


class Renderer(Protocol):
    """Draws what one lens sees."""

    def render(
        self, scene: Scene, lens_pose: FloatArray, observer: int | None = None, out: Image | None = None
    ) -> Image:
        """Return the picture ``(h, w, 3)`` of the scene from a lens pose ``(3,)`` in the world."""
        ...


class Watcher(Protocol):
    """Does the looks of robots: from scenes to beliefs."""

    parallel: bool
    """Whether threads may share it, robot by robot."""
    pictures: list[list[Picture]]
    """Of each robot's newest look, where they are kept."""

    def prepare(self, looks: Looks, scenes: dict[int, Scene]) -> None:
        """Get ready for looks at scenes."""
        ...

    def watch(self, counter: Counter, since: FloatArray, tracks: Tracks, beliefs: Beliefs) -> None:
        """Do the looks of robots until none is left, see :func:`swarmvision.sensing.watch.watch`."""
        ...


def watcher(
    config: CameraSensorConfig,
    robot: RobotConfig,
    arena: ArenaConfig,
    lens: Lens,
    imperfections: Imperfections,
    robots: int,
    keep_pictures: bool,
) -> Watcher:
    """Return the fastest watcher that can do what is asked."""
    marker = Marker.from_config(robot.marker)
    reader = Reader(lens, marker, config.method)
    shutter = Shutter.of(lens, config.imperfections.readout_time, marker)
    habits = Habits(config.sight, config.reach, shutter, Law.of(config.tracker))
    if config.renderer == "mesh":
        from swarmvision.rendering.mesh import MeshRenderer

        renderer: Renderer = MeshRenderer(lens, robot, arena)
        return ByHand(config, renderer, imperfections, reader, habits, robots, keep_pictures)
    raycaster, counts = Raycaster(lens, robot, arena), (robots, len(arena.objects))
    plain = imperfections.by_kernel and not lens.is_distorted and config.method == "edges"
    if plain and reader.task is not None and not keep_pictures:
        return ByKernel(config, raycaster, imperfections, reader.task, lens, habits, counts)
    return ByHand(config, raycaster, imperfections, reader, habits, robots, keep_pictures)


def _farthest(config: CameraSensorConfig) -> float:
    """Return how far from a lens a neighbour may be that the robot wants to know of (m)."""
    return config.reach + config.rig.forward


class ByKernel:
    """Everything in one kernel: the ray caster, faults and reader that have one."""

    parallel = True

    def __init__(
        self,
        config: CameraSensorConfig,
        raycaster: Raycaster,
        imperfections: Imperfections,
        task: Task,
        lens: Lens,
        habits: Habits,
        counts: tuple[int, int],
    ) -> None:
        robots, objects = counts
        self.pictures: list[list[Picture]] = [[] for _ in range(robots)]
        self._raycaster, self._imperfections, self._task, self._lens = raycaster, imperfections, task, lens
        self._robots, self._objects, self._lenses = robots, objects, len(config.rig.yaws_deg)
        self._habits = habits
        self._aim = Aim.of(task, _farthest(config))
        self._memory = threading.local()

    def prepare(self, looks: Looks, scenes: dict[int, Scene]) -> None:
        """Stack the scenes that are shown."""
        shown: list[int] = sorted(set(looks.scene.ravel().tolist()))
        poses = np.array([scenes[number].pose for number in shown], dtype=np.float64)
        things = [scenes[number].object_pose for number in shown]
        self._looks = looks
        self._scenes = Scenes(
            robots=poses.reshape(len(shown), self._robots, 3),
            objects=np.array(things, dtype=np.float64).reshape(len(shown), self._objects, 3),
            slot=np.searchsorted(shown, looks.scene),
        )

    def watch(self, counter: Counter, since: FloatArray, tracks: Tracks, beliefs: Beliefs) -> None:
        """Do the looks of robots until none is left."""
        if not hasattr(self._memory, "desk"):
            self._memory.desk = Desk.of(
                self._lens, self._raycaster, self._imperfections.faults, self._robots, self._lenses
            )
        watch(
            counter,
            self._looks,
            self._scenes,
            self._raycaster.stage,
            self._imperfections.faults,
            self._task,
            self._aim,
            self._memory.desk,
            since,
            tracks,
            beliefs,
            self._habits,
        )


class ByHand:
    """Renderer, faults and reader one after the other; keeps pictures where asked to."""

    def __init__(
        self,
        config: CameraSensorConfig,
        renderer: Renderer,
        imperfections: Imperfections,
        reader: Reader,
        habits: Habits,
        robots: int,
        keep_pictures: bool,
    ) -> None:
        self.parallel = config.renderer == "raycast"  # OpenGL belongs to the thread that began it
        self.pictures: list[list[Picture]] = [[] for _ in range(robots)]
        self._keep = keep_pictures
        self._renderer, self._imperfections, self._reader = renderer, imperfections, reader
        self._habits = habits
        self._aim = Aim.of(reader.task, _farthest(config)) if reader.task is not None else None
        self._memory = threading.local()

    def prepare(self, looks: Looks, scenes: dict[int, Scene]) -> None:
        """Note what to look at."""
        self._looks, self._scenes = looks, scenes

    def watch(self, counter: Counter, since: FloatArray, tracks: Tracks, beliefs: Beliefs) -> None:
        """Do the looks of robots until none is left."""
        while (robot := ticket(counter)) < len(since):
            self.pictures[robot] = []
            for look in range(self._looks.start[robot], self._looks.start[robot + 1]):
                self._look(robot, look, tracks)
            settle(tracks, robot, since[robot], self._habits.law, beliefs)

    def _look(self, robot: int, look: int, tracks: Tracks) -> None:
        looks = self._looks
        anticipate(tracks, robot, looks.motion[look], self._habits.law)
        lenses = np.nonzero(~looks.lost[look])[0]
        if len(lenses) == 0:
            lose_sight(tracks, robot, self._habits.law)
            return
        self.pictures[robot] = []
        readings = [self._read(robot, look, int(lens), tracks) for lens in lenses]
        counts = [len(reading.seen) for reading in readings]
        polar, covariance = np.empty((sum(counts), 4)), np.empty((sum(counts), 3, 3))
        for reading, count, end in zip(readings, counts, np.cumsum(counts), strict=True):
            lens_rows(reading, polar[end - count : end], covariance[end - count : end])
        lens_of = np.repeat(lenses, counts)
        follow(
            tracks,
            robot,
            polar,
            covariance,
            lens_of,
            looks.mount[look],
            looks.turning[look],
            self._habits,
        )

    def _read(self, robot: int, look: int, lens: int, tracks: Tracks) -> Estimates:
        """Return what one lens reads."""
        looks, pose = self._looks, self._looks.pose[look, lens]
        scene = self._scenes[int(looks.scene[look, lens])]
        near = np.empty_like(scene.pose)
        count = gather_near(scene.pose, robot, pose, self._habits.sight, near)
        seen = Scene.at_rest(near[:count], scene.object_pose)  # a picture is of an instant
        image = self._renderer.render(seen, pose, None, None if self._keep else self._buffer())
        self._imperfections.spoil(image, int(looks.key[look, lens]), float(looks.turn_rate[look, lens]))
        reading = self._reader.read(image, self._gaze(robot, look, lens, tracks))
        if self._keep:
            self.pictures[robot].append(Picture(robot, lens, pose, image, reading))
        return reading

    def _gaze(self, robot: int, look: int, lens: int, tracks: Tracks) -> Gaze | None:
        task, mount = self._reader.task, self._looks.mount[look, lens]
        if task is None or self._aim is None:
            return None
        return gaze(
            tracks, robot, mount, task, self._aim, bool(self._looks.search[look, lens]), windows_room()
        )

    def _buffer(self) -> Image:
        if not hasattr(self._memory, "image"):
            lens = self._reader.lens
            self._memory.image = np.empty((lens.height_px, lens.width_px, 3), dtype=np.uint8)
        image: Image = self._memory.image
        return image
