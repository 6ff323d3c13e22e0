"""Three zones: flee who is near, align with who is farther, approach who is farthest.

Source: I. D. Couzin, J. Krause, R. James, G. D. Ruxton, N. R. Franks, "Collective memory and spatial
sorting in animal groups", Journal of Theoretical Biology 218, 2002, doi:10.1006/jtbi.2002.3065. Whom a
robot flees it neither aligns with nor approaches; the widths of the outer zones choose a swarm, a torus or a
parallel group.

Where we differ: the plane instead of space; a robot turns at a rate proportional to the angle below
the paper's limit; neighbours whose heading is not told do not count for orientation. The widths are ours,
for robots of a Zumo's size, where a marker's heading is told best below 0.4 m.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import CouzinConfig
from swarmvision.controllers.chance import Chance, begin
from swarmvision.controllers.crowd import ComplexArray, Crowd, crowd
from swarmvision.controllers.law import Law
from swarmvision.controllers.motion import with_alone
from swarmvision.data import Commands, Senses


def turn(senses: Senses, chance: Chance, config: CouzinConfig) -> tuple[Commands, Chance]:
    """Return the commands of robots from the neighbours in their zones.

    Args:
        senses: Shape ``(..., k)``; may be empty.
        chance: Of each robot, shape ``(...)``.
        config: Speed, zones and noise.

    Returns:
        Before the limits of the drive, shape ``(...)``, and the chance after.
    """
    others = crowd(senses.neighbours, config.repulsion + config.orientation + config.attraction)
    wanted = wanted_direction(others, config)
    angle = np.where(wanted == 0.0, 0.0, np.angle(wanted)) + config.noise * chance.normal()
    limit = np.radians(config.turn_limit_deg)
    rate = np.clip(config.turn_gain * angle, -limit, limit)
    commands = Commands(np.full_like(rate, config.speed), rate)
    commands = with_alone(commands, others.anybody, config.alone, config.speed)
    return commands, chance.after()


def wanted_direction(others: Crowd, config: CouzinConfig) -> ComplexArray:
    """Return the direction that the zones ask for, 0 where they ask for nothing, shape ``(...)``."""
    near = others.within(config.repulsion)
    ahead = np.abs(np.angle(others.towards)) <= np.radians(config.fov_deg) / 2.0
    outside = others.within(ahead & (others.distance > config.repulsion))
    inner = outside.distance <= config.repulsion + config.orientation
    aligned = outside.within(inner).total(others.facing)
    drawn = outside.within(~inner).total(others.towards)
    # Where only one of the two zones holds anybody, the other's sum is 0 and does not matter.
    return np.asarray(np.where(near.anybody, -near.total(others.towards), aligned + drawn))


LAW = Law(CouzinConfig, frozenset({"range", "bearing", "heading"}), turn, begin)
