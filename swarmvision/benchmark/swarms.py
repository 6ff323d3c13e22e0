"""Many robots: cameras a second, workers, real time, sensors without pictures, many worlds."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import cv2

from swarmvision.benchmark import rivals
from swarmvision.benchmark.rival_renderers import PlainPyrender
from swarmvision.benchmark.stage import LENS, MARKER, RATE, one_camera, swarm
from swarmvision.benchmark.timing import CPU, LEAST, WALL, Absent, Call, Effort, Figure, duration, medians
from swarmvision.camera import Rig
from swarmvision.config.camera import LENSES, RIGS
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.data import Scene
from swarmvision.geometry import compose
from swarmvision.perception import Reader
from swarmvision.sensing.camera import CameraSensor
from swarmvision.simulation import Simulation

CHAIN_ROBOTS = 32  # of the swarm whose pictures are counted
STEPS = 8  # that its cameras are timed for in a turn
SEED = 1
NEAREST_TOLD = 6  # neighbours that sensors without pictures tell of
SENSORS: dict[str, dict[str, Any]] = {
    "camera": one_camera(),
    "truth": {"kind": "truth", "neighbours": NEAREST_TOLD},
    "error_model": {"kind": "error_model", "neighbours": NEAREST_TOLD, "rate_hz": RATE},
}


@dataclass(slots=True)
class Film:
    """The scenes of a swarm that flocks, made as they are asked for."""

    simulation: Simulation
    scenes: list[Scene] = field(default_factory=list)

    @classmethod
    def of(cls, robots: int) -> Film:
        """Return the film of a swarm of so many at the demo's density."""
        return cls(Simulation(swarm(robots, SENSORS["truth"]), SEED))

    def scene(self, number: int) -> Scene:
        """Return the scene after so many steps and one."""
        while len(self.scenes) <= number:
            self.scenes.append(self.simulation.step().scene)
        return self.scenes[number]


@dataclass(slots=True)
class Watcher:
    """A swarm's cameras that see a film scene by scene: one picture a robot and call."""

    sensor: CameraSensor
    film: Film
    number: int = 0

    @classmethod
    def of(cls, scenario: ScenarioConfig, film: Film, workers: int, idle: Collection[int] = ()) -> Watcher:
        """Return the cameras of a scenario but for those of idle robots."""
        config = scenario.sensor
        assert config.kind == "camera"
        sensor = CameraSensor(
            config, scenario.robot, scenario.arena, scenario.robots, SEED, workers=workers, idle=idle
        )
        return cls(sensor, film)

    def look(self) -> None:
        """See the next scene, which the film must have."""
        self.sensor.sense(self.film.scenes[self.number])
        self.number += 1


@dataclass(slots=True)
class Episodes:
    """A scenario that begins anew whenever its time is over.

    A swarm that is let go on for minutes comes to a wall and is pressed against it, which is another swarm:
    a step of a hundred robots costs four times as much there.
    """

    scenario: ScenarioConfig
    workers: int
    simulation: Simulation | None = None
    left: int = 0

    def step(self) -> None:
        """Go on by one step, from the start after the last."""
        if self.simulation is None or self.left == 0:
            self.simulation = Simulation(self.scenario, SEED, workers=self.workers)
            self.left = self.scenario.steps
        self.simulation.step()
        self.left -= 1


def chain(effort: Effort) -> dict[str, Figure]:
    """Return what one robot's picture costs (ms) in a swarm's cameras, by workers, and in the naive loop.

    Ours is drawn, spoiled by ``pi-v1``, read by ``edges`` and tracked: ``loop`` in CPU time on one core,
    ``workers_1``, ``workers_2`` ... up to the cores by the clock on the wall. The naive loop draws the
    same scenes plainly with pyrender and reads them by the paper's pipeline; nothing is spoiled or
    tracked. A turn is ``STEPS`` steps, and one before them that is not timed: threads wake, caches fill.
    """
    scenario = swarm(CHAIN_ROBOTS, SENSORS["camera"])
    film = Film.of(CHAIN_ROBOTS)
    cores = len(os.sched_getaffinity(0))
    watchers = {f"workers_{n}": Watcher.of(scenario, film, n) for n in sorted({1, min(2, cores), cores})}
    naive = rivals.attempt("pyrender", lambda: _naive(film))
    samples: dict[str, list[float]] = {name: [] for name in ["loop", *watchers, "naive"]}
    end = time.perf_counter() + 3.0 * effort.seconds
    while len(samples["loop"]) < LEAST or time.perf_counter() < end:
        film.scene(watchers["workers_1"].number + STEPS)
        for name, watcher in watchers.items():
            watcher.look()
            for _ in range(STEPS):
                busy, wall = CPU(), WALL()
                watcher.look()
                samples[name].append((WALL() - wall) / CHAIN_ROBOTS)
                if name == "workers_1":
                    samples["loop"].append((CPU() - busy) / CHAIN_ROBOTS)
        if not isinstance(naive, Absent):
            samples["naive"].append(1e9 * duration(naive))
    found: dict[str, Figure] = {
        name: 1e-6 * statistics.median(taken) for name, taken in samples.items() if taken
    }
    return found | ({"naive": naive} if isinstance(naive, Absent) else {})


def real_time(effort: Effort) -> float:
    """Return simulated seconds per second of a whole flock with one 32 Hz camera each, two workers."""
    cost = step_cost(swarm(effort.swarm, SENSORS["camera"]), effort.seconds * 2.0, workers=2)
    return 1e3 / RATE / cost


def by_robots(effort: Effort) -> dict[int, dict[str, Figure]]:
    """Return what a robot costs a step (ms) in whole simulations of so many, by sensor, one worker."""
    return {
        n: {name: per_robot(n, sensor, effort.seconds / 2.0) for name, sensor in SENSORS.items()}
        for n in effort.robots
    }


def by_workers(ms: Mapping[str, Figure]) -> dict[int, dict[str, Figure]]:
    """Return the pictures of :func:`chain` by number of workers."""
    prefix = "workers_"
    return {
        int(name.removeprefix(prefix)): {"loop": cost} for name, cost in ms.items() if name.startswith(prefix)
    }


def per_robot(robots: int, sensor: dict[str, Any], seconds: float) -> float:
    """Return what one robot costs one step (ms) in a simulation of so many."""
    return step_cost(swarm(robots, sensor), seconds, workers=1) / robots


def step_cost(scenario: ScenarioConfig, seconds: float, workers: int) -> float:
    """Return the median duration (ms) of a step of a scenario's own time, over and over.

    It is CPU time with one worker, the wall's with more.
    """
    elsewhere = ("step",) if workers > 1 else ()
    cost = medians({"step": Episodes(scenario, workers).step}, seconds, elsewhere)["step"]
    assert isinstance(cost, float)
    return cost


def _naive(film: Film) -> Call:
    """Return one robot's picture drawn plainly by pyrender and read by the paper's method."""
    rig = Rig.from_config(LENSES["pi-v1"], RIGS["single"])
    renderer = PlainPyrender(LENS, CHAIN_ROBOTS - 1)
    reader, turn = Reader(LENS, MARKER, "moments"), [0]
    cv2.setNumThreads(1)

    def picture() -> None:
        scene, robot = film.scene(max(len(film.scenes) - 1, 0)), turn[0] % CHAIN_ROBOTS
        turn[0] += 1
        pose = compose(scene.pose[robot], rig.robot_from_lens(scene.time)[0])
        reader.read(renderer.render(scene, pose, robot))

    return picture
