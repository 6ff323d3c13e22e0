"""The loop: the one place where scene, estimates and commands are joined.

::

    scene ──sense──> estimates ──control──> commands ──act──> scene
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmvision.config.scenario import ScenarioConfig
from swarmvision.config.sensor import TruthSensorConfig
from swarmvision.controllers import controller
from swarmvision.data import Commands, Estimates, Picture, Scene
from swarmvision.geometry import FloatArray
from swarmvision.metrics import PerceptionErrors, largest_cluster, order, perception_errors, perception_table
from swarmvision.randomness import Subsystem, stream
from swarmvision.sensing import Sensor
from swarmvision.sensing.camera import CameraSensor
from swarmvision.sensing.truth import TruthSensor
from swarmvision.world import World, starting_scene

FLOCK_LINK = 0.5  # m; two robots nearer than this belong to one flock
AGGREGATE_LINK = 1.5  # body diagonals; two robots nearer than this touch or nearly so
SETTLED = 0.2  # the last fifth of a run counts as its outcome


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """One turn of the loop: what was sensed in a scene, and what was commanded upon it."""

    step: int
    """Counted from 0."""
    scene: Scene
    """As it was sensed."""
    estimates: Estimates
    """Robot frame, shape ``(r, k)``."""
    commands: Commands
    """Shape ``(r,)``."""
    pictures: tuple[Picture, ...]
    """The newest pictures, where they are kept."""

    @property
    def time(self) -> float:
        """Time since the start of the run (s)."""
        return self.scene.time


@dataclass(frozen=True, eq=False, slots=True)
class RunResult:
    """A run as series over its ``t`` control steps, and in a few numbers."""

    time: FloatArray
    """s, shape ``(t,)``."""
    pose: FloatArray
    """Shape ``(t, r, 3)``."""
    order: FloatArray
    """Polar order, shape ``(t,)``."""
    largest_cluster: FloatArray
    """Fraction of the robots, shape ``(t,)``."""
    summary: dict[str, Any]
    """What ``summary.json`` holds."""


class Simulation:
    """A swarm in its arena, advanced one control step at a time."""

    def __init__(
        self,
        scenario: ScenarioConfig,
        seed: int = 0,
        *,
        keep_pictures: bool = False,
        workers: int | None = None,
    ) -> None:
        """Place the robots.

        Args:
            scenario: The experiment.
            seed: Of everything random.
            keep_pictures: Whether frames hold the pictures that were taken.
            workers: Threads that render and read; changes no result.

        Raises:
            ConfigError: If the robots do not fit the arena.
        """
        self.scenario = scenario
        self.seed = seed
        self.scene = starting_scene(scenario, stream(seed, Subsystem.START))
        self._world = World(scenario.arena, scenario.robot, self.scene)
        self._control = controller(scenario.controller)
        self._sensor = _sensor(scenario, seed, keep_pictures, workers)
        self._step = 0

    @property
    def contacts(self) -> int:
        """How many contacts have begun so far, of robots with robots, walls and objects."""
        return self._world.contacts

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """What was photographed in the newest call of :meth:`sense`, if pictures are kept."""
        return self._sensor.pictures

    def sense(self) -> Estimates:
        """Return what each robot believes about its neighbours now, robot frame, shape ``(r, k)``."""
        return self._sensor.sense(self.scene)

    def act(self, commands: Commands) -> Scene:
        """Drive the robots through one control period and return the scene after it.

        Raises:
            PhysicsError: If a command or the world is not finite.
        """
        period = 1.0 / self.scenario.control_hz
        self.scene = self._world.step(commands, period, self.scenario.physics_substeps)
        self._step += 1
        return self.scene

    def step(self) -> Frame:
        """Sense, control and act once."""
        scene, step = self.scene, self._step
        estimates = self.sense()
        commands = self._control(estimates)
        frame = Frame(step, scene, estimates, commands, self.pictures)
        self.act(commands)
        return frame


def run(
    scenario: ScenarioConfig,
    seed: int = 0,
    on_frame: Callable[[Frame], None] | None = None,
    *,
    keep_pictures: bool = False,
    workers: int | None = None,
) -> RunResult:
    """Return the whole run of a scenario; ``on_frame`` is told every frame as it happens."""
    simulation = Simulation(scenario, seed, keep_pictures=keep_pictures, workers=workers)
    scenes: list[Scene] = []
    errors: list[PerceptionErrors] = []
    digest = hashlib.sha256()
    reach = scenario.sensor.reach
    for _ in range(scenario.steps):
        frame = simulation.step()
        scenes.append(frame.scene)
        errors.append(perception_errors(frame.scene.pose, frame.estimates, reach))
        digest.update(_state_bytes(frame.scene))
        if on_frame is not None:
            on_frame(frame)
    digest.update(_state_bytes(simulation.scene))
    pose = np.array([scene.pose for scene in scenes])
    link = cluster_link(scenario)
    ordered = order(pose[..., 2])
    largest = np.array([largest_cluster(places, link) for places in pose[..., :2]])
    settled = slice(-max(round(SETTLED * len(scenes)), 1), None)
    summary = {
        "scenario": scenario.name,
        "seed": seed,
        "robots": scenario.robots,
        "seconds": simulation.scene.time,
        "sensor": scenario.sensor.kind,
        "controller": scenario.controller.law,
        "order": float(np.mean(ordered[settled])),
        "largest_cluster": float(np.mean(largest[settled])),
        "order_final": float(ordered[-1]),
        "largest_cluster_final": float(largest[-1]),
        "cluster_link": link,
        "contacts": simulation.contacts,
        "state_sha256": digest.hexdigest(),
        "perception": perception_table(errors),
    }
    times = np.array([scene.time for scene in scenes])
    return RunResult(times, pose, ordered, largest, summary)


def cluster_link(scenario: ScenarioConfig) -> float:
    """Return the distance (m) below which two robots of a scenario belong to one cluster."""
    if scenario.measure == "flocking":
        return FLOCK_LINK
    return AGGREGATE_LINK * float(np.hypot(scenario.robot.length, scenario.robot.width))


def _sensor(scenario: ScenarioConfig, seed: int, keep_pictures: bool, workers: int | None) -> Sensor:
    config = scenario.sensor
    if isinstance(config, TruthSensorConfig):
        return TruthSensor(config, scenario.robot, scenario.arena)
    return CameraSensor(
        config,
        scenario.robot,
        scenario.arena,
        scenario.robots,
        seed,
        keep_pictures=keep_pictures,
        workers=workers,
    )


def _state_bytes(scene: Scene) -> bytes:
    """Return the state of a scene as little-endian float64."""
    arrays = (
        scene.pose,
        scene.velocity,
        scene.wheel_speed,
        scene.wheel_travel,
        scene.object_pose,
        scene.object_velocity,
    )
    return b"".join(np.ascontiguousarray(array, dtype="<f8").tobytes() for array in arrays)
