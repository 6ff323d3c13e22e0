"""Aggregation by three states: approach the others, wait with them, leave them for a while.

Source: O. Soysal, E. Sahin, "Probabilistic aggregation strategies in swarm robotic systems", IEEE Swarm
Intelligence Symposium 2005, doi:10.1109/SIS.2005.1501639: a robot approaches until one is near, waits,
leaves with a probability in every step, and returns with another; below it, walls are avoided.

Where we differ: the paper's robots hear where the others are loudest; ours see them, and go where the
inverses of the ranges add up to, which is how sound pressure falls. Probabilities are rates per second, so
that they do not depend on the control period; their values are ours.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import SoysalConfig
from swarmvision.controllers.chance import Switch, begin_off
from swarmvision.controllers.crowd import FARTHEST, OBSTACLE_GAIN, crowd, push_of_obstacles, unit
from swarmvision.controllers.law import Law
from swarmvision.controllers.motion import turn_and_go, with_alone
from swarmvision.data import Commands, Senses


def step(senses: Senses, memory: Switch, config: SoysalConfig) -> tuple[Commands, Switch]:
    """Return the commands ``(...)``, and the memory after them: whether a robot leaves the others."""
    others = crowd(senses.neighbours, FARTHEST)
    near = others.within(config.robot_range).anybody
    rate = np.where(memory.on, config.return_rate, np.where(near, config.leave_rate, 0.0))
    leaving = memory.on ^ memory.chance.happens(rate, senses.dt)
    way = unit(others.total(others.towards / others.distance)) * np.where(leaving, -1.0, 1.0)
    way = way + OBSTACLE_GAIN * push_of_obstacles(senses, config.obstacle_range)
    moving = turn_and_go(way.real, way.imag, config.speed, config.turn_gain)
    waits = near & ~leaving
    commands = Commands(np.where(waits, 0.0, moving.speed), np.where(waits, 0.0, moving.turn_rate))
    commands = with_alone(commands, others.anybody, config.alone, config.speed)
    return commands, Switch(memory.chance.after(), leaving)


LAW = Law(SoysalConfig, frozenset({"range", "bearing", "proximity"}), step, begin_off)
