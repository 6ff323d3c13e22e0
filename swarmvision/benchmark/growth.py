"""What a robot's camera costs in a large swarm over what it costs in a small one, and what is in its view."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator

import numpy as np

from swarmvision.benchmark.stage import DENSITY, LENS, one_camera, swarm
from swarmvision.benchmark.swarms import SEED, STEPS, Film, Watcher
from swarmvision.benchmark.timing import LEAST, duration
from swarmvision.geometry import compose, inverse, polar
from swarmvision.placement import starting_scene
from swarmvision.randomness import Subsystem, stream
from swarmvision.simulation import Simulation

FEW, MANY = 10, 1000  # robots of the two swarms
GROUPS = 10  # of few robots: small swarms, or parts of the large one
DENSITIES = (DENSITY, 2.0, 0.5)  # robots per m^2, the flocking demo's first


def at_density(density: float, seconds: float) -> float:
    """Return what a robot costs a step among ``MANY`` over among ``FEW``, everything included, one worker.

    Every turn steps the one swarm once and each of ``GROUPS`` small ones, which stand differently,
    ``STEPS`` times after a step that is not timed: a small swarm alone has its data in the caches.
    """
    large = Simulation(swarm(MANY, one_camera(), density), SEED, workers=1)
    small = [
        Simulation(swarm(FEW, one_camera(), density), seed, workers=1) for seed in range(SEED, SEED + GROUPS)
    ]
    return _typical(_step_ratios(large, small), seconds)


def in_one_crowd(seconds: float) -> float:
    """Return what a picture costs where all of ``MANY`` robots take one, over where ``FEW`` of them do.

    Both see the same crowd: what is left is what a camera pays for other cameras. ``GROUPS`` groups,
    chosen at random, stand for all.
    """
    scenario = swarm(MANY, one_camera())
    film = Film.of(MANY)
    groups = np.random.default_rng(SEED).permutation(MANY)[: GROUPS * FEW].reshape(GROUPS, FEW)
    everybody = Watcher.of(scenario, film, 1)
    watchers = [Watcher.of(scenario, film, 1, set(range(MANY)).difference(group)) for group in groups]

    def ratios() -> Iterator[float]:
        while True:
            film.scene(everybody.number)
            by_few = sum(duration(watcher.look) for watcher in watchers) / (GROUPS * FEW)
            yield duration(everybody.look) / MANY / by_few

    return _typical(ratios(), seconds)


def neighbours_in_view(robots: int, density: float = DENSITY) -> float:
    """Return how many robots are within a camera's view and sight on average, hidden or not, at the start."""
    scenario, counts = swarm(robots, one_camera(), density), []
    assert scenario.sensor.kind == "camera"
    for seed in range(SEED, SEED + max(1, GROUPS * FEW // robots)):
        pose = starting_scene(scenario, stream(seed, Subsystem.START)).pose
        gap, bearing, _ = polar(compose(inverse(pose)[:, None], pose[None]))
        seen = (np.abs(bearing) < LENS.fov / 2.0) & (gap < scenario.sensor.sight)
        np.fill_diagonal(seen, val=False)
        counts.append(seen.sum() / robots)
    return float(np.mean(counts))


def _step_ratios(large: Simulation, small: list[Simulation]) -> Iterator[float]:
    while True:
        of_many = duration(large.step) / MANY
        of_few = 0.0
        for simulation in small:
            simulation.step()
            of_few += sum(duration(simulation.step) for _ in range(STEPS)) / STEPS
        yield of_many / (of_few / (GROUPS * FEW))


def _typical(ratios: Iterator[float], seconds: float) -> float:
    """Return the median of what comes in about so many seconds, the first left out: it warms up."""
    next(ratios)
    taken: list[float] = []
    end = time.perf_counter() + seconds
    while len(taken) < LEAST or time.perf_counter() < end:
        taken.append(next(ratios))
    return statistics.median(taken)
