"""A sheepdog: gathers the flock, then drives it to the goal.

Source: D. Strombom, R. P. Mann, A. M. Wilson, et al., "Solving the shepherding problem: heuristics for
herding autonomous, interacting agents", J. R. Soc. Interface 11, 2014, doi:10.1098/rsif.2014.0719:
if a sheep is farther than ``r_a N^(2/3)`` from the middle of the flock, go to ``r_a`` behind the farthest;
else go to ``r_a sqrt(N)`` behind the middle, seen from the goal; near a sheep, go slowly. The robot sheepdog
before it: R. Vaughan, N. Sumpter, J. Henderson, A. Frost, S. Cameron, "Experiments in automatic flock
control", Robotics and Autonomous Systems 31, 2000, doi:10.1016/S0921-8890(99)00084-6.

Where we differ: ``N`` and the middle are of the sheep in sight; the dog goes round the flock, where the
paper's may walk through it; a dog that does not know the goal gathers only. Where the sensor cannot tell
teams, whoever it sees is a sheep. The paper's dog knows where every sheep is; ours, with none in sight,
crosses the arena from wall to wall until it sees one. Values are ours.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import DogConfig
from swarmvision.controllers.chance import Chance, begin
from swarmvision.controllers.crowd import (
    FARTHEST,
    OBSTACLE_GAIN,
    ComplexArray,
    Crowd,
    crowd,
    goal_offset,
    push_of_obstacles,
    unit,
)
from swarmvision.controllers.law import Law
from swarmvision.controllers.motion import turn_and_go, with_alone
from swarmvision.data import BoolArray, Commands, Senses


def step(senses: Senses, memory: Chance, config: DogConfig) -> tuple[Commands, Chance]:
    """Return the commands ``(...)``, and the memory after them."""
    sheep = crowd(senses.neighbours, FARTHEST).within(senses.neighbours.kind != config.own_kind)
    target = post(sheep, *goal_offset(senses), config)
    way = unit(_round_the_flock(target, sheep, config))
    way = way + config.noise * np.exp(2j * np.pi * memory.even())
    near = sheep.within((sheep.distance < config.slow_range) & (sheep.towards.real > 0.0)).anybody
    pace = np.where(near, config.slow, 1.0) * np.minimum(np.abs(target) / config.sheep_range, 1.0)
    push = push_of_obstacles(senses, config.obstacle_range)
    way = np.where(sheep.anybody, way, 1.0 + OBSTACLE_GAIN * push)
    commands = turn_and_go(way.real, way.imag, config.speed, config.turn_gain)
    commands = Commands(np.where(sheep.anybody, pace, 1.0) * commands.speed, commands.turn_rate)
    if config.alone != "search":
        commands = with_alone(commands, sheep.anybody, config.alone, config.speed)
    return commands, memory.after()


def post(sheep: Crowd, goal: ComplexArray, known: BoolArray, config: DogConfig) -> ComplexArray:
    """Return the place that the dog is to take, in its frame (m), shape ``(...)``.

    Args:
        sheep: In sight, ``(..., k)``.
        goal: Its place (m), ``(...)``.
        known: Whether the dog knows it, ``(...)``.
        config: Settings.
    """
    number = np.count_nonzero(sheep.counts, axis=-1)
    middle = sheep.mean(sheep.offset)
    off = np.where(sheep.counts, np.abs(sheep.offset - middle[..., None]), 0.0)
    farthest = np.max(off, axis=-1, initial=0.0)
    stray = sheep.within(off >= farthest[..., None] - 1e-9)
    stray_at = stray.mean(stray.offset)
    collect = stray_at + config.sheep_range * unit(stray_at - middle)
    behind = unit(middle - goal)
    drive = middle + config.sheep_range * np.sqrt(number) * behind
    scattered = (farthest > config.sheep_range * number ** (2.0 / 3.0)) | ~known
    return np.asarray(np.where(scattered, collect, drive))


def _round_the_flock(target: ComplexArray, sheep: Crowd, config: DogConfig) -> ComplexArray:
    """Return the direction to a target, along the tangent of the flock's circle where that is in the way."""
    middle = sheep.mean(sheep.offset)
    away = np.maximum(np.abs(middle), 1e-9)
    radius = config.sheep_range * np.sqrt(np.count_nonzero(sheep.counts, axis=-1))
    half = np.arcsin(np.minimum(radius / away, 1.0))
    aside = np.angle(target * middle.conjugate())
    behind = (np.abs(aside) < half) & (np.abs(target) > away * np.cos(half))
    tangent = middle * np.exp(1j * np.copysign(half, aside))
    return np.asarray(np.where(behind, tangent, target))


LAW = Law(DogConfig, frozenset({"range", "bearing", "kind", "goal", "proximity"}), step, begin)
