"""Flocking by alignment and proximal control.

Source: A. E. Turgut, H. Celikkanat, F. Gokce, E. Sahin, "Self-organized flocking in mobile robot
swarms", Swarm Intelligence 2, 2008, doi:10.1007/s11721-008-0016-2.

Where we differ: the paper's eight infrared sectors become the ranges of tracked neighbours, so the
proximal force is a function of range and is averaged over neighbours, those not measured lately counting
less; of a proximity ring only what is no robot pushes; the mean heading includes the robot's own;
neighbours whose heading is not told count for proximal control alone. The gains are ours, for robots of a
Zumo's size.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import KobotConfig
from swarmvision.controllers.crowd import ComplexArray, Crowd, crowd, obstacle_near, push_of_obstacles
from swarmvision.controllers.law import reflex_of_senses
from swarmvision.controllers.motion import turn_and_go, with_alone
from swarmvision.controllers.proximal import proximal_force
from swarmvision.data import Commands, Senses


def flock(senses: Senses, config: KobotConfig) -> Commands:
    """Return the commands of robots from the neighbours that they see.

    Args:
        senses: Shape ``(..., k)``; may be empty.
        config: Gains and ranges.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    others = crowd(senses.neighbours, config.reach, config.forget)
    wanted = wanted_direction(senses, others, config)
    commands = turn_and_go(wanted.real, wanted.imag, config.speed, config.turn_gain)
    obstacle = obstacle_near(senses, config.obstacle_range)
    return with_alone(commands, others.anybody | obstacle, config.alone, config.speed)


def wanted_direction(senses: Senses, others: Crowd, config: KobotConfig) -> ComplexArray:
    """Return the paper's ``h + beta p``, a complex vector in the robot frame, shape ``(...)``."""
    proximal = others.mean(proximal_force(others.distance, config) * others.towards)
    push = push_of_obstacles(senses, config.obstacle_range, config.contact_range)
    return np.asarray(others.heading() + config.proximal_gain * proximal + config.obstacle_gain * push)


LAW = reflex_of_senses(flock, KobotConfig, {"range", "bearing", "heading", "proximity"})
