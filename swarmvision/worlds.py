"""Many worlds of one scenario in one process, as arrays: for learning, sweeps and statistics.

The loop of :mod:`swarmvision.simulation` without pictures, for ``w`` worlds at once::

    poses ──sense──> estimates (w, r, k) ──control──> commands (w, r) ──act──> poses (w, r, 3)

Sensing is by ``truth`` or ``error_model``; controllers are the same functions. Motion is that of
:mod:`swarmvision.world`, contacts are simpler (:mod:`swarmvision.contacts`). A world begins with a seed of
its own, and nothing that happens in it depends on the others.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmvision.config.scenario import ScenarioConfig
from swarmvision.config.sensor import DeliveryConfig, ErrorModelSensorConfig, TruthSensorConfig
from swarmvision.contacts import WALLS, advance, bounds_of, shapes_of
from swarmvision.controllers import Memory, Sense, controller
from swarmvision.data import BoolArray, Commands, Estimates, IntArray, Scene, Senses
from swarmvision.drive import Drive, run_tracks
from swarmvision.errors import ConfigError, PhysicsError
from swarmvision.geometry import FloatArray
from swarmvision.ground import ANGLE, SPIN, VX, X
from swarmvision.placement import starting_scene
from swarmvision.randomness import Subsystem, hashed, stream
from swarmvision.sensing.error_memory import ErrorMemory
from swarmvision.sensing.error_model import (
    error_model,
    exposures_until,
    observer_keys,
    slots_of,
)
from swarmvision.sensing.registry import has_own_way
from swarmvision.sensing.sight import View
from swarmvision.sensing.truth import sight, truth_estimates

SUBSTEPS = 4  # of a control period; a scenario's own are for pymunk
FELT: frozenset[Sense] = frozenset({"range", "bearing", "heading", "motion", "proximity", "goal", "cue"})
# The last three at their neutral values: scenarios that have them are refused.


class Worlds:
    """``worlds`` copies of a scenario, advanced together one control step at a time."""

    def __init__(
        self, scenario: ScenarioConfig, worlds: int, seed: int = 0, *, substeps: int = SUBSTEPS
    ) -> None:
        """Place the robots of every world.

        Args:
            scenario: The experiment; its sensor is ``truth`` or ``error_model``.
            worlds: How many.
            seed: Of everything random; each world's own follows from it.
            substeps: Physics steps in a control step.

        Raises:
            ConfigError: If the scenario asks for what many worlds do not have, or the robots do not fit.
        """
        _refuse(scenario)
        r, m = scenario.robots, len(scenario.arena.objects)
        self.scenario = scenario
        self.seeds: IntArray = np.zeros(worlds, np.int64)
        """The seed of each world's episode, ``(w,)``: a :class:`Simulation` of it begins alike."""
        self.time = np.zeros(worlds)
        """Since each world's episode began (s), ``(w,)``."""
        self._robots, self._seed = r, seed
        self._episodes = np.zeros(worlds, np.int64)
        self._drive = Drive.from_config(scenario.robot)
        self._shapes, self._grips = shapes_of(r, scenario.robot, scenario.arena)
        arena = scenario.arena
        self._room = np.array([arena.width / 2.0, arena.depth / 2.0, np.sqrt(arena.wall_friction)])
        self._bounds = bounds_of(r, self._shapes)
        self._steps = self._substep(substeps)
        self._kept = self._drive.kept(self._steps[0], substeps)
        self._state = np.zeros((6, worlds, r + m))
        self._wheels, self._travel = np.zeros((2, worlds, r)), np.zeros((2, worlds, r))
        self._ahead, self._turning = np.zeros((2, substeps, worlds * r))
        self._touching = np.zeros((worlds, r + m, r + m + WALLS), bool)
        self._busy, self._begun = np.zeros(worlds, bool), np.zeros((worlds, 2), np.int64)
        self._look = _Look(scenario, worlds)
        self._controller = controller(scenario.controller, scenario.layers)
        if missing := self._controller.inputs - FELT:
            raise ConfigError(f"many worlds do not have the senses {', '.join(sorted(missing))}")
        self._memory: Memory = ()
        self.reset()

    @property
    def worlds(self) -> int:
        """How many worlds there are."""
        return len(self.seeds)

    @property
    def pose(self) -> FloatArray:
        """Robots: x, y (m), yaw (rad), shape ``(w, r, 3)``."""
        return self._columns(slice(X, ANGLE + 1), slice(self._robots))

    @property
    def velocity(self) -> FloatArray:
        """Robots: dx/dt, dy/dt (m/s), dyaw/dt (rad/s), shape ``(w, r, 3)``."""
        return self._columns(slice(VX, SPIN + 1), slice(self._robots))

    @property
    def wheel_speed(self) -> FloatArray:
        """As in :class:`Scene`, ``(w, r, 2)``."""
        return np.stack(list(self._wheels), axis=-1)

    @property
    def wheel_travel(self) -> FloatArray:
        """As in :class:`Scene`, ``(w, r, 2)``."""
        return np.stack(list(self._travel), axis=-1)

    @property
    def robot_contacts(self) -> IntArray:
        """Contacts of robots with robots begun in each world's episode, ``(w,)``."""
        return self._begun[:, 0].copy()

    @property
    def obstacle_contacts(self) -> IntArray:
        """And with walls and objects."""
        return self._begun[:, 1].copy()

    @property
    def contacts(self) -> IntArray:
        """Contacts begun so far in each world's episode, ``(w,)``."""
        return np.asarray(self._begun.sum(axis=1), dtype=np.int64)

    def scene(self, world: int) -> Scene:
        """Return one world as a scene."""
        one, r = self._state[:, world].T, self._robots
        return Scene(
            time=float(self.time[world]),
            pose=one[:r, : ANGLE + 1],
            velocity=one[:r, VX:],
            wheel_speed=self._wheels[:, world].T,
            wheel_travel=self._travel[:, world].T,
            object_pose=one[r:, : ANGLE + 1],
            object_velocity=one[r:, VX:],
        )

    def reset(self, which: BoolArray | None = None) -> None:
        """Begin new episodes in some worlds ``(w,)``, or in all; each has a seed that it had not before."""
        which = np.ones(self.worlds, bool) if which is None else which
        for world in np.flatnonzero(which):
            seed = hashed(self._seed, Subsystem.START, int(world), int(self._episodes[world]))
            self._place(int(world), starting_scene(self.scenario, stream(seed, Subsystem.START)))
            self._look.forget(int(world), seed)
            self.seeds[world] = seed
            self._episodes[world] += 1
        keys = _law_keys(self.seeds, self._robots)
        fresh = self._controller.begin(keys)
        self._memory = _renewed(self._memory, fresh, which) if self._memory else fresh

    def sense(self) -> Estimates:
        """Return what each robot believes about its neighbours now, robot frame, shape ``(w, r, k)``."""
        r = self._robots
        things = self._columns(slice(X, ANGLE + 1), slice(r, None))
        turn_rate = np.ascontiguousarray(self._state[SPIN, :, :r])
        return self._look.sense(self.pose, turn_rate, self._travel, things, self.time)

    def feel(self, estimates: Estimates) -> Senses:
        """Return all that the robots know now: what they see of each other, and their own motion."""
        speed, turn_rate = self._drive.twist(np.moveaxis(self._wheels, 0, -1))
        return Senses.of(estimates, 1.0 / self.scenario.control_hz, speed=speed, turn_rate=turn_rate)

    def decide(self, senses: Senses) -> Commands:
        """Return what the robots' law commands, shape ``(w, r)``; the law's memory goes on."""
        commands, self._memory = self._controller.step(senses, self._memory)
        return commands

    def act(self, commands: Commands) -> None:
        """Drive the robots of all worlds through one control period.

        Args:
            commands: Shape ``(w, r)``.

        Raises:
            PhysicsError: If a command or the new state is not finite.
        """
        drive, period, flat = self._drive, 1.0 / self.scenario.control_hz, (2, -1)
        limits = (drive.track, drive.max_wheel_speed, drive.turn_slip)
        speed, turn_rate = commands.speed.reshape(-1), commands.turn_rate.reshape(-1)
        wheels, travel = self._wheels.reshape(flat), self._travel.reshape(flat)
        if run_tracks(
            speed, turn_rate, limits, self._kept, self._steps[0], wheels, travel, self._ahead, self._turning
        ):
            _refuse_nonfinite("command", np.stack([commands.speed, commands.turn_rate], axis=-1))
        if advance(
            self._state.reshape(6, -1),
            self._ahead,
            self._turning,
            self._shapes,
            self._bounds,
            self._grips,
            self._room,
            self._steps,
            self._touching,
            self._busy,
            self._begun,
        ):
            _refuse_nonfinite("state", np.moveaxis(self._state, 0, -1))
        self.time = self.time + period

    def step(self) -> Estimates:
        """Sense, control and act once; return what was sensed."""
        estimates = self.sense()
        self.act(self.decide(self.feel(estimates)))
        return estimates

    def _substep(self, substeps: int) -> tuple[float, float, float]:
        """Return duration, lead and margin of :func:`advance`."""
        period = 1.0 / self.scenario.control_hz
        dt = period / substeps
        # Longer substeps than pymunk's would turn every path a little; the tracks point as in pymunk's.
        lead = (dt - period / self.scenario.physics_substeps) / 2.0
        return dt, lead, 2.0 * period * self._drive.max_wheel_speed + SLACK

    def _columns(self, columns: slice, bodies: slice) -> FloatArray:
        """Return some columns of the state of some bodies, ``(w, b, c)``, our own copy."""
        return np.ascontiguousarray(self._state[columns, :, bodies].transpose(1, 2, 0))

    def _place(self, world: int, scene: Scene) -> None:
        self._state[:, world] = 0.0
        self._state[: ANGLE + 1, world] = np.vstack([scene.pose, scene.object_pose]).T
        self._wheels[:, world] = self._travel[:, world] = self.time[world] = 0.0
        self._begun[world], self._touching[world], self._busy[world] = 0, False, False


SLACK = 0.01  # m: what being pushed apart may add to a body's way in a period


class _Look:
    """The sensor of all worlds."""

    def __init__(self, scenario: ScenarioConfig, worlds: int) -> None:
        config, r = scenario.sensor, scenario.robots
        self._rate, self._robots = scenario.control_hz, r
        if isinstance(config, ErrorModelSensorConfig):
            self._rate = config.rate_hz
            self._model = error_model(config, scenario.robot, scenario.arena)
            self._memory = ErrorMemory.blank(np.zeros((worlds, r), np.uint64), slots_of(config, r))
            self._exposures, self._time = np.zeros(worlds, np.int64), np.zeros(worlds)
            return
        assert isinstance(config, TruthSensorConfig)
        self._view = View.of(
            scenario.robot,
            scenario.arena,
            config.reach,
            np.radians(config.fov_deg),
            occlusion=config.occlusion,
        )
        self._slots = config.neighbours or max(r - 1, 0)

    def forget(self, world: int, seed: int) -> None:
        if hasattr(self, "_memory"):
            self._memory.forget(world, observer_keys(seed, self._robots))
            self._exposures[world] = self._time[world] = 0

    def sense(
        self,
        pose: FloatArray,
        turn_rate: FloatArray,
        travel: FloatArray,
        objects: FloatArray,
        time: FloatArray,
    ) -> Estimates:
        if not hasattr(self, "_memory"):
            return truth_estimates(*sight(pose, objects, self._view, self._slots))
        due = exposures_until(time, self._rate)
        exposed, passed = due > self._exposures, time - self._time
        self._exposures, self._time = due, time.copy()
        told = self._model.believe(pose, turn_rate, travel, objects, self._memory, exposed, passed)
        return told.estimates((*turn_rate.shape, self._memory.each))


def _law_keys(seeds: IntArray, robots: int) -> NDArray[np.uint64]:
    """Return the keys of the laws' chance, ``(w, r)``; those of a :class:`Simulation` of each seed."""
    return np.array(
        [[hashed(int(seed), Subsystem.CONTROLLER, robot) for robot in range(robots)] for seed in seeds],
        dtype=np.uint64,
    ).reshape(len(seeds), robots)


def _renewed(old: Memory, fresh: Memory, which: BoolArray) -> Memory:
    """Return a law's memory with some worlds' begun anew."""
    rows = [
        np.where(which.reshape(-1, *[1] * (np.ndim(a) - 1)), b, a) for a, b in zip(old, fresh, strict=True)
    ]
    return type(old)(*rows)


def _refuse(scenario: ScenarioConfig) -> None:
    if not isinstance(scenario.sensor, TruthSensorConfig | ErrorModelSensorConfig):
        raise ConfigError(f"many worlds sense by truth or error_model, not by {scenario.sensor.kind}")
    for what, there in (
        ("teams", scenario.teams),
        ("a goal", scenario.goal),
        ("cues", scenario.arena.cues),
        ("a proximity ring", scenario.proximity),
    ):
        if there:
            raise ConfigError(f"many worlds do not have {what}")
    sensor = scenario.sensor
    if isinstance(sensor, DeliveryConfig) and has_own_way(sensor):
        raise ConfigError("many worlds do not have sensors that are late, lossy, broken or with a memory")


def _refuse_nonfinite(field: str, values: FloatArray) -> None:
    if np.isfinite(values).all():
        return
    world, robot = (int(n) for n in np.argwhere(~np.isfinite(values))[0, :2])
    raise PhysicsError(
        f"{field} of robot {robot} in world {world} must be finite, got {values[world, robot]}"
    )
