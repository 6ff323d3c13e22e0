"""Flocking in which some know the way: the others follow because they align.

Sources: H. Celikkanat, E. Sahin, "Steering self-organized robot flocks through externally guided
individuals", Neural Computing and Applications 19, 2010, doi:10.1007/s00521-010-0355-y: Kobot flocking
plus the desired direction, weighted, for the informed; after I. D. Couzin, J. Krause, N. R. Franks,
S. A. Levin, "Effective leadership and decision-making in animal groups on the move", Nature 433, 2005,
doi:10.1038/nature03236.

Where we differ: as :mod:`~swarmvision.controllers.kobot`; the informed know a place, not only a
direction, and its pull fades near it. The weight is ours.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import InformedConfig
from swarmvision.controllers.crowd import crowd, goal_offset, obstacle_near, unit
from swarmvision.controllers.kobot import wanted_direction
from swarmvision.controllers.law import reflex_of_senses
from swarmvision.controllers.motion import turn_and_go, with_alone
from swarmvision.data import Commands, Senses


def migrate(senses: Senses, config: InformedConfig) -> Commands:
    """Return the commands of robots of which some, those whose ``senses.goal`` is finite, know the goal.

    Args:
        senses: Shape ``(..., k)``; may be empty.
        config: Gains and ranges.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    others = crowd(senses.neighbours, config.reach, config.forget)
    goal, informed = goal_offset(senses)
    pull = unit(goal) * np.minimum(np.abs(goal) / config.arrival_range, 1.0)
    wanted = wanted_direction(senses, others, config) + config.goal_gain * pull
    commands = turn_and_go(wanted.real, wanted.imag, config.speed, config.turn_gain)
    obstacle = obstacle_near(senses, config.obstacle_range)
    return with_alone(commands, others.anybody | obstacle | informed, config.alone, config.speed)


LAW = reflex_of_senses(migrate, InformedConfig, {"range", "bearing", "heading", "proximity", "goal"})
