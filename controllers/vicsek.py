"""Take the mean heading of the neighbours, and some noise.

Source: T. Vicsek, A. Czirok, E. Ben-Jacob, I. Cohen, O. Shochet, "Novel type of phase transition in a
system of self-driven particles", Physical Review Letters 75, 1995, doi:10.1103/PhysRevLett.75.1226.

Where we differ: a robot turns towards the new heading at a bounded rate, the paper's points take it at
once. Nothing keeps robots together or apart; lay collision avoidance under it.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import VicsekConfig
from swarmvision.controllers.chance import Chance, begin
from swarmvision.controllers.crowd import crowd
from swarmvision.controllers.law import Law
from swarmvision.controllers.motion import with_alone
from swarmvision.data import Commands, Senses


def align(senses: Senses, chance: Chance, config: VicsekConfig) -> tuple[Commands, Chance]:
    """Return the commands of robots from the headings of the neighbours that they see.

    Args:
        senses: Shape ``(..., k)``; may be empty.
        chance: Of each robot, shape ``(...)``.
        config: Speed, reach and noise.

    Returns:
        Before the limits of the drive, shape ``(...)``, and the chance after.
    """
    others = crowd(senses.neighbours, config.reach)
    error = config.noise * (chance.even() - 0.5)
    angle = np.angle(others.heading() * np.exp(1j * error))
    rate = np.clip(config.turn_gain * angle, -config.turn_limit, config.turn_limit)
    commands = Commands(np.full_like(rate, config.speed), rate)
    commands = with_alone(commands, others.anybody, config.alone, config.speed)
    return commands, chance.after()


LAW = Law(VicsekConfig, frozenset({"range", "bearing", "heading"}), align, begin)
