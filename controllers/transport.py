"""Co-operative transport: push the load where it hides the goal.

Source: J. Chen, M. Gauci, W. Li, A. Kolling, R. Gross, "Occlusion-based cooperative transport with a swarm of
miniature mobile robots", IEEE Transactions on Robotics 31(2), 2015, doi:10.1109/TRO.2015.2400731: a robot
searches for the load, goes to it, and pushes if it cannot see the goal from there, because the load is in the
way; else it goes on round the load. No robot knows of any other, and a convex load that moves so comes to
the goal.

Where we differ: a robot sees where the load's middle is, and goes round at a distance from it, by the shorter
way, stepping back from robots ahead; the goal's sense tells a place, which is nan while it is hidden. A robot
that is not told of a goal at all, ever, would push from anywhere.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import TransportConfig
from swarmvision.controllers.crowd import ComplexArray, crowd, goal_offset, load_offset, unit
from swarmvision.controllers.law import reflex_of_senses
from swarmvision.controllers.motion import turn_and_go, with_alone
from swarmvision.data import Commands, Senses


def carry(senses: Senses, config: TransportConfig) -> Commands:
    """Return the commands of robots ``(...)``."""
    load, found = load_offset(senses)
    goal, told = goal_offset(senses)
    hidden = ~told
    way = np.where(hidden, unit(load), _round(load, goal, config.orbit))
    ahead = crowd(senses.neighbours, config.clearance)
    blocked = np.sum(ahead.weight * np.maximum(ahead.towards.real, 0.0) * ahead.towards, axis=-1)
    way = np.where(hidden, way, way - blocked)
    speed = np.where(hidden, config.push_speed, config.speed)
    unit_speed = turn_and_go(way.real, way.imag, 1.0, config.turn_gain)
    commands = Commands(speed * unit_speed.speed, unit_speed.turn_rate)
    return with_alone(commands, found, config.alone, config.speed)


def _round(load: ComplexArray, goal: ComplexArray, orbit: float) -> ComplexArray:
    """Return the direction round the load to the side that is turned away from the goal, ``(...)``.

    On the circle of radius ``orbit`` it is the circle's tangent, outside it leads nearer, inside away.
    """
    away = np.maximum(np.abs(load), 1e-9)
    out = -unit(load)  # from the load's middle to the robot
    behind = unit(load - goal)  # where the load hides the goal
    left = np.where((out.conjugate() * behind).imag >= 0.0, 1.0, -1.0)
    return np.asarray(1j * left * out - np.clip((away - orbit) / (0.3 * orbit), -1.0, 1.0) * out)


LAW = reflex_of_senses(carry, TransportConfig, {"range", "bearing", "goal", "load"})
