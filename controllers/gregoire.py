"""Mean heading, a force that keeps a distance, and noise: flocks that hold together in open space.

Source: G. Gregoire, H. Chate, Y. Tu, "Moving and staying together without a leader", Physica D 181, 2003,
doi:10.1016/S0167-2789(03)00102-7: the new heading is that of
``alpha sum v_j + beta sum f_ij + n eta`` with the number of neighbours ``n`` and a random unit vector
``eta``; ``f`` is a hard core, then linear about its zero, then constant.

Where we differ: means instead of sums, which is the same direction; the infinite core is a push of
``CORE`` times the outer pull; a robot turns at a bounded rate and slows down for it. The ranges are ours.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import GregoireConfig
from swarmvision.controllers.chance import Chance, begin
from swarmvision.controllers.crowd import crowd
from swarmvision.controllers.law import Law
from swarmvision.controllers.motion import turn_and_go, with_alone
from swarmvision.data import Commands, Senses
from swarmvision.geometry import FloatArray

CORE = 10.0  # push of the core against a pull of 1; the paper's is infinite


def stay_together(senses: Senses, chance: Chance, config: GregoireConfig) -> tuple[Commands, Chance]:
    """Return the commands of robots from the neighbours that they see.

    Args:
        senses: Shape ``(..., k)``; may be empty.
        chance: Of each robot, shape ``(...)``.
        config: Speed, weights and ranges.

    Returns:
        Before the limits of the drive, shape ``(...)``, and the chance after.
    """
    others = crowd(senses.neighbours, config.reach)
    number = np.count_nonzero(others.counts, axis=-1)
    # The robot is one of those whose headings are summed.
    aligned = (1.0 + others.total(others.facing)) / (1.0 + number)
    forced = others.mean(force(others.distance, config) * others.towards)
    noise = np.exp(2j * np.pi * chance.even())
    wanted = config.alignment_gain * aligned + config.force_gain * forced + config.noise * noise
    commands = turn_and_go(wanted.real, wanted.imag, config.speed, config.turn_gain)
    commands = with_alone(commands, others.anybody, config.alone, config.speed)
    return commands, chance.after()


def force(distance: FloatArray, config: GregoireConfig) -> FloatArray:
    """Return the pull (positive) or push towards a neighbour at a range (m)."""
    slope = 0.25 * (distance - config.desired_range) / (config.attraction - config.desired_range)
    far = np.where(distance < config.attraction, slope, 1.0)
    return np.asarray(np.where(distance < config.core, -CORE, far))


LAW = Law(GregoireConfig, frozenset({"range", "bearing", "heading"}), stay_together, begin)
