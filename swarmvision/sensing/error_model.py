"""What a tracked camera would believe, drawn from tables instead of from pictures.

Modelled is the outcome of the tracker, not the single reading: an extended Kalman filter for every
neighbour costs more than the whole of this sensor, and what a controller gets is the outcome. For each
neighbour in reach a robot remembers whether the last picture measured it, since when not, and three
normal deviates that drift from picture to picture; part of them is common to all that one robot sees,
for most of the error is its own turn. The deviates pick quantiles of the error by true range, turn rate
and visible fraction, or by age once a neighbour is only remembered. Now and then a track splits and
leaves a ghost, and rarer still there is a phantom; both are forgotten after the tracker's memory.

Chance is hashed from the observer's key, the picture's number and the neighbour's, so it shifts with
nobody else's. The tables are in :mod:`swarmvision.sensing.error_table`; what they leave out: the error
does not depend on the neighbour's own aspect, nor on which lens of the ring sees it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import ErrorModelSensorConfig
from swarmvision.data import BoolArray, Estimates, IntArray, Picture, Scene
from swarmvision.drive import Drive
from swarmvision.geometry import FloatArray
from swarmvision.randomness import Subsystem, hashed
from swarmvision.sensing.error_chance import normal_table
from swarmvision.sensing.error_memory import ErrorMemory, Keys
from swarmvision.sensing.error_numbers import Tables, Told
from swarmvision.sensing.error_step import believe
from swarmvision.sensing.error_table import ErrorTable
from swarmvision.sensing.error_tracks import CLOCK_SLACK
from swarmvision.sensing.error_views import AHEAD
from swarmvision.sensing.sight import View
from swarmvision.sensing.truth import looked

MARGIN = 1.1  # candidates are looked for a little beyond the reach: an estimate may be nearer than the truth
CANDIDATES = 2  # of the nearest for each slot; in a crowd those behind are hidden anyway
SLOTS_EACH = 2  # where the slots are not limited: one for everybody, and as many for ghosts


class ErrorModel:
    """Draws estimates for every robot of every world."""

    def __init__(self, table: ErrorTable, view: View, drive: Drive, memory: float, period: float) -> None:
        """Prepare the tables.

        Args:
            table: Of the errors.
            view: Reach, field of view and what hides.
            drive: Of the robots, whose encoders tell their way.
            memory: How long a neighbour that is not measured is remembered (s).
            period: Between pictures (s).
        """
        self._tables = Tables.of(table, normal_table(), period)
        self._drive = drive.track, drive.turn_slip
        self._chances = memory, float(table.phantom[0])
        self._limits = view.reach, period, view.radius
        self._view = replace(view, reach=view.reach * MARGIN)

    def believe(
        self,
        pose: FloatArray,
        turn_rate: FloatArray,
        travel: FloatArray,
        objects: FloatArray,
        memory: ErrorMemory,
        exposed: BoolArray,
        passed: FloatArray,
    ) -> Told:
        """Return what the robots believe now; their memory goes on.

        Args:
            pose: Shape ``(w, r, 3)``.
            turn_rate: Of the robots (rad/s), shape ``(w, r)``.
            travel: Way of their left and right tracks by the encoders since the start (m), ``(2, w, r)``.
            objects: Poses, shape ``(w, m, 3)``.
            memory: Of the worlds.
            exposed: Whether a picture has been taken since the last call, shape ``(w,)``.
            passed: Time since the last call (s), shape ``(w,)``.

        Returns:
            Measured neighbours first, nearest first, for estimates of shape ``(w, r, k)``.
        """
        worlds, robots = turn_rate.shape
        slots = memory.each
        told = Told.of(worlds * robots * slots)
        most = min(max(robots - 1, 0), CANDIDATES * slots)
        scenes = (pose, objects) if exposed.all() else (pose[exposed], objects[exposed])
        who, found = looked(*scenes, self._view, most, least=-1.0)
        with np.errstate(over="ignore"):  # hashes are meant to wrap, where no compiler makes them
            believe(
                robots,
                slots,
                most,
                pose.reshape(-1),
                turn_rate.reshape(-1),
                travel.reshape(2, -1),
                self._drive,
                who.reshape(-1),
                found.reshape(4, -1),
                exposed,
                passed,
                self._limits,
                self._chances,
                self._tables,
                memory.slots,
                memory.minds,
                memory.spare,
                told,
            )
        memory.exchange()
        return told


class ErrorModelSensor:
    """The error model as the sensor of one swarm."""

    pictures: tuple[Picture, ...] = ()

    def __init__(
        self, config: ErrorModelSensorConfig, robot: RobotConfig, arena: ArenaConfig, robots: int, seed: int
    ) -> None:
        """Load the tables.

        Args:
            config: Reach, field of view, rate, memory and slots.
            robot: Whose markers are seen.
            arena: Whose objects hide them.
            robots: How many.
            seed: Of the run.
        """
        self._rate = config.rate_hz
        self._model = error_model(config, robot, arena)
        self._memory = ErrorMemory.blank(observer_keys(seed, robots)[None], slots_of(config, robots))
        self._exposures = 0
        self._time: float | None = None

    def sense(self, scene: Scene) -> Estimates:
        """Return what each robot believes at the scene's time, robot frame, shape ``(r, k)``."""
        # Of several pictures since the last call the newest counts.
        due = int(exposures_until(np.asarray(scene.time), self._rate))
        passed = 0.0 if self._time is None else scene.time - self._time
        told = self._model.believe(
            scene.pose[None],
            scene.velocity[None, :, 2],
            scene.wheel_travel.T[:, None],
            scene.object_pose[None],
            self._memory,
            np.array([due > self._exposures]),
            np.array([passed]),
        )
        self._exposures, self._time = due, scene.time
        return told.estimates((scene.robots, self._memory.each))


def error_model(config: ErrorModelSensorConfig, robot: RobotConfig, arena: ArenaConfig) -> ErrorModel:
    """Return the model of a configured sensor, with the tables that ship with the package."""
    view = camera_view(robot, arena, config.reach, np.radians(config.fov_deg))
    return ErrorModel(ErrorTable.load(), view, Drive.from_config(robot), config.memory, 1.0 / config.rate_hz)


def camera_view(robot: RobotConfig, arena: ArenaConfig, reach: float, fov: float = 2.0 * np.pi) -> View:
    """Return the view from the lenses of a ring, which stand before the robot's axis."""
    return replace(View.of(robot, arena, reach, fov), ahead=AHEAD)


def slots_of(config: ErrorModelSensorConfig, robots: int) -> int:
    """Return how many slots a robot has: the configured ones, or enough for everybody and ghosts."""
    if config.neighbours is not None:
        return config.neighbours
    return SLOTS_EACH * max(robots - 1, 0)


def observer_keys(seed: int, robots: int) -> Keys:
    """Return the keys of the chance of a run's robots, shape ``(r,)``."""
    return np.array([hashed(seed, Subsystem.SENSOR, robot) for robot in range(robots)], dtype=np.uint64)


def exposures_until(time: FloatArray, rate_hz: float) -> IntArray:
    """Return how many pictures have been taken at times ``(...)`` (s), the first one at 0."""
    return np.floor((time + CLOCK_SLACK) * rate_hz).astype(np.int64) + 1
