"""The loop: the one place where scene, estimates and commands are joined.

::

    scene ──sense──> estimates ──control──> commands ──act──> scene
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from swarmvision.config.scenario import ScenarioConfig
from swarmvision.config.sensor import SensorConfig
from swarmvision.controllers import Controller, Memory, controller
from swarmvision.data import Commands, Estimates, Picture, Scene, Senses
from swarmvision.geometry import FloatArray
from swarmvision.metrics import SETTLED, Ledger
from swarmvision.outcome import cluster_link, outcome
from swarmvision.placement import starting_scene
from swarmvision.randomness import Subsystem, hashed, stream
from swarmvision.sensing import Sensor
from swarmvision.sensing.body import Body
from swarmvision.sensing.registry import newest_age, sensor_of
from swarmvision.sensing.silhouette import Silhouettes
from swarmvision.world import World


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
        self._body = Body(scenario, seed)
        self._teams = _teams(scenario, seed)
        looks = any("silhouette" in team.controller.inputs for team in self._teams)

        def sensor(config: SensorConfig, asked: Iterable[int]) -> Sensor:
            # Silhouettes are from the common pictures, whatever sensor a team has of its own.
            idle = set() if looks else set(range(scenario.robots)).difference(asked)
            return sensor_of(
                config, scenario, seed, keep_pictures=keep_pictures or looks, workers=workers, idle=idle
            )

        self._sensor = sensor(scenario.sensor, scenario.with_common_sensor)
        self._own_sensors = [
            self._sensor
            if config.sensor is None
            else sensor(config.sensor, range(scenario.robots)[team.rows])
            for config, team in zip(scenario.teams, self._teams[1:], strict=True)
        ]
        self._silhouettes = Silhouettes(self._sensor, scenario) if looks else None
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
        seen = self._sensor.sense(self.scene)
        if all(sensor is self._sensor for sensor in self._own_sensors):
            return seen
        parts = [seen.select(self._teams[0].rows)]
        for team, sensor in zip(self._teams[1:], self._own_sensors, strict=True):
            theirs = seen if sensor is self._sensor else sensor.sense(self.scene)
            parts.append(theirs.select(team.rows))
        return Estimates.join(parts)

    def feel(self, estimates: Estimates) -> Senses:
        """Return all that the robots know now, given what they see of each other, ``(r, k)``."""
        senses = self._body.feel(self.scene, estimates)
        if self._silhouettes is None:
            return senses
        return replace(senses, silhouette=self._silhouettes.of(self.scene, estimates))

    def decide(self, senses: Senses) -> Commands:
        """Return what the robots' laws command, shape ``(r,)``; the laws' memories go on."""
        if len(self._teams) == 1:
            team = self._teams[0]
            commands, team.memory = team.controller.step(senses, team.memory)
            return commands
        speed, turn_rate = np.zeros(senses.shape), np.zeros(senses.shape)
        for team in self._teams:
            commands, team.memory = team.controller.step(senses.select(team.rows), team.memory)
            speed[team.rows], turn_rate[team.rows] = commands.speed, commands.turn_rate
        return Commands(speed, turn_rate)

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
        commands = self.decide(self.feel(estimates))
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
    sensor = scenario.sensor
    ledger = Ledger(scenario.robots, sensor.reach, newest_age(sensor), scenario.with_common_sensor)
    digest = hashlib.sha256()
    for _ in range(scenario.steps):
        frame = simulation.step()
        ledger.note(frame.scene, frame.estimates)
        digest.update(_state_bytes(frame.scene))
        if on_frame is not None:
            on_frame(frame)
    digest.update(_state_bytes(simulation.scene))
    link = cluster_link(scenario)
    ordered, (largest, flock_order) = ledger.order(), ledger.flock(link)
    settled = slice(-max(round(SETTLED * len(ordered)), 1), None)
    summary = {
        "scenario": scenario.name,
        "seed": seed,
        "robots": scenario.robots,
        "seconds": simulation.scene.time,
        "sensor": scenario.sensor.kind,
        "controller": scenario.controller.law,
        "outcome": outcome(scenario, ledger.scenes),
        "order": float(np.mean(ordered[settled])),
        "flock_order": float(np.mean(flock_order[settled])),
        "largest_cluster": float(np.mean(largest[settled])),
        "order_final": float(ordered[-1]),
        "largest_cluster_final": float(largest[-1]),
        "cluster_link": link,
        "contacts": simulation.contacts,
        **ledger.motion(
            simulation.contacts, float(np.hypot(scenario.robot.length, scenario.robot.width)) / 2.0
        ),
        "state_sha256": digest.hexdigest(),
        **ledger.perception(),
    }
    return RunResult(ledger.time, ledger.pose, ordered, largest, summary)


@dataclass(slots=True)
class _Team:
    """Robots of one law, with what the law remembers."""

    rows: slice
    controller: Controller
    memory: Memory


def _teams(scenario: ScenarioConfig, seed: int) -> list[_Team]:
    keys = np.array(
        [hashed(seed, Subsystem.CONTROLLER, robot) for robot in range(scenario.robots)], dtype=np.uint64
    )
    laws = [(scenario.controller, scenario.layers), *((t.controller, t.layers) for t in scenario.teams)]
    teams, first = [], 0
    for count, (law, layers) in zip(scenario.team_sizes, laws, strict=True):
        rows = slice(first, first + count)
        control = controller(law, layers)
        teams.append(_Team(rows, control, control.begin(keys[rows])))
        first += count
    return teams


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
