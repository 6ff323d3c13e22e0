"""Many robots: cameras a second, workers, real time, sensors without pictures, many worlds."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np

from swarmvision.benchmark import rivals
from swarmvision.benchmark.rival_renderers import PlainPyrender
from swarmvision.benchmark.stage import LENS, MARKER, RATE, one_camera, swarm
from swarmvision.benchmark.timing import CPU, LEAST, WALL, Absent, Call, Effort, Figure, duration, medians
from swarmvision.camera import Rig
from swarmvision.config.camera import LENSES, RIGS
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.data import Scene
from swarmvision.geometry import compose, inverse, polar
from swarmvision.perception import Reader
from swarmvision.placement import starting_scene
from swarmvision.randomness import Subsystem, stream
from swarmvision.sensing.camera import CameraSensor
from swarmvision.simulation import Simulation

CHAIN_ROBOTS = 32  # of the swarm whose pictures are counted
STEPS = 8  # that its cameras are timed for in a turn
GROUPS = 10  # of robots, whose pictures stand for those of a whole crowd
SEED = 1
NEAREST_TOLD = 6  # neighbours that sensors without pictures tell of
SENSORS: dict[str, dict[str, Any]] = {
    "camera": one_camera(),
    "truth": {"kind": "truth", "neighbours": NEAREST_TOLD},
    "error_model": {"kind": "error_model", "neighbours": NEAREST_TOLD, "rate_hz": RATE},
}


@dataclass(slots=True)
class _Film:
    """The scenes of a swarm that flocks, made as they are asked for."""

    simulation: Simulation
    scenes: list[Scene] = field(default_factory=list)

    def scene(self, number: int) -> Scene:
        while len(self.scenes) <= number:
            self.scenes.append(self.simulation.step().scene)
        return self.scenes[number]


@dataclass(slots=True)
class _Watcher:
    """A swarm's cameras that see a film scene by scene: one picture a robot and call."""

    sensor: CameraSensor
    film: _Film
    number: int = 0

    def look(self) -> None:
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
    film = _Film(Simulation(swarm(CHAIN_ROBOTS, SENSORS["truth"]), SEED))
    cores = len(os.sched_getaffinity(0))
    watchers = {f"workers_{n}": _watcher(scenario, film, n) for n in sorted({1, min(2, cores), cores})}
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


def in_one_crowd(robots: int, few: int, seconds: float) -> float:
    """Return what a picture costs where all robots of a crowd take one, over where ``few`` of them do.

    Both see the same crowd: what is left is what a camera pays for other cameras. ``GROUPS`` groups,
    chosen at random, stand for all.
    """
    scenario = swarm(robots, SENSORS["camera"])
    film = _Film(Simulation(swarm(robots, SENSORS["truth"]), SEED))
    shuffled = np.random.default_rng(SEED).permutation(robots)
    groups = [shuffled[few * i : few * (i + 1)] for i in range(GROUPS)]
    everybody = _watcher(scenario, film, 1)
    watchers = [_watcher(scenario, film, 1, set(range(robots)).difference(group)) for group in groups]
    ratios: list[float] = []
    end = time.perf_counter() + seconds
    while len(ratios) <= LEAST or time.perf_counter() < end:
        film.scene(everybody.number)
        by_few = sum(duration(watcher.look) for watcher in watchers) / (GROUPS * few)
        ratios.append(duration(everybody.look) / robots / by_few)
    return statistics.median(ratios[1:])  # the first picture warms up


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


def neighbours_in_view(robots: int) -> float:
    """Return how many markers stand in one camera's view on average, hidden or not, when so many begin."""
    pose = starting_scene(swarm(robots, SENSORS["camera"]), stream(SEED, Subsystem.START)).pose
    _, bearing, _ = polar(compose(inverse(pose)[:, None], pose[None]))
    seen = np.abs(bearing) < LENS.fov / 2.0
    np.fill_diagonal(seen, val=False)
    return float(seen.sum() / robots)


def step_cost(scenario: ScenarioConfig, seconds: float, workers: int) -> float:
    """Return the median duration (ms) of a step of a scenario's own time, over and over.

    It is CPU time with one worker, the wall's with more.
    """
    elsewhere = ("step",) if workers > 1 else ()
    cost = medians({"step": Episodes(scenario, workers).step}, seconds, elsewhere)["step"]
    assert isinstance(cost, float)
    return cost


def _watcher(scenario: ScenarioConfig, film: _Film, workers: int, idle: Collection[int] = ()) -> _Watcher:
    config = scenario.sensor
    assert config.kind == "camera"
    sensor = CameraSensor(
        config, scenario.robot, scenario.arena, scenario.robots, SEED, workers=workers, idle=idle
    )
    return _Watcher(sensor, film)


def _naive(film: _Film) -> Call:
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
