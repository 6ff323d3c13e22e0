"""Aggregation by three states: approach the others, wait with them, leave them for a while.

Source: O. Soysal, E. Sahin, "Probabilistic aggregation strategies in swarm robotic systems", IEEE Swarm
Intelligence Symposium 2005, doi:10.1109/SIS.2005.1501639: a robot approaches until one is near, waits,
leaves with a probability in every step, and returns with another; below it, walls are avoided.

Where we differ: the paper's robots hear where the others are loudest; ours see them, and go where the
inverses of the ranges add up to, which is how sound pressure falls. Probabilities are rates per second, so
that they do not depend on the control period; their values are ours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from swarmvision.config.controller import SoysalConfig
from swarmvision.controllers.chance import Chance
from swarmvision.controllers.chance import begin as chance
from swarmvision.controllers.crowd import FARTHEST, OBSTACLE_GAIN, crowd, push_of_obstacles, unit
from swarmvision.controllers.law import Keys, Law
from swarmvision.controllers.motion import turn_and_go, with_alone
from swarmvision.data import BoolArray, Commands, Senses


class SoysalMemory(NamedTuple):
    """Of each robot, shape ``(...)``."""

    chance: Chance
    """Decides when it leaves and returns."""
    leaving: BoolArray
    """Whether it repels itself; else it approaches, or waits where a robot is near."""


def begin(config: SoysalConfig, keys: Keys) -> SoysalMemory:
    """Return the memory of robots that approach."""
    return SoysalMemory(chance(config, keys), np.zeros(keys.shape, dtype=bool))


def step(senses: Senses, memory: SoysalMemory, config: SoysalConfig) -> tuple[Commands, SoysalMemory]:
    """Return the commands ``(...)``, and the memory after them."""
    others = crowd(senses.neighbours, FARTHEST)
    near = others.within(config.robot_range).anybody
    rate = np.where(memory.leaving, config.return_rate, np.where(near, config.leave_rate, 0.0))
    changed = memory.chance.even() < 1.0 - np.exp(-rate * senses.dt)
    leaving = memory.leaving ^ changed
    way = unit(others.total(others.towards / others.distance)) * np.where(leaving, -1.0, 1.0)
    way = way + OBSTACLE_GAIN * push_of_obstacles(senses, config.obstacle_range)
    moving = turn_and_go(way.real, way.imag, config.speed, config.turn_gain)
    waits = near & ~leaving
    commands = Commands(np.where(waits, 0.0, moving.speed), np.where(waits, 0.0, moving.turn_rate))
    commands = with_alone(commands, others.anybody, config.alone, config.speed)
    return commands, SoysalMemory(memory.chance.after(), leaving)


LAW = Law(SoysalConfig, frozenset({"range", "bearing", "proximity"}), step, begin)
