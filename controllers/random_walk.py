"""Go straight, and turn by chance now and then; neighbours do not matter.

Source: the correlated random walk, E. A. Codling, M. J. Plank, S. Benhamou, "Random walk models in
biology", Journal of the Royal Society Interface 5, 2008, doi:10.1098/rsif.2008.0014.

Where we differ: the turn rate, not the heading, is drawn anew, so that the way has no corners; it is kept
for a fixed time, which begins at another moment for every robot. The values are ours.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import RandomWalkConfig
from swarmvision.controllers.chance import Chance, begin
from swarmvision.controllers.law import Law
from swarmvision.data import Commands, Senses

PHASE = 1 << 32  # a count that no run reaches: the stream of the phases


def walk(senses: Senses, chance: Chance, config: RandomWalkConfig) -> tuple[Commands, Chance]:
    """Return the commands of robots that wander, shape ``(...)``, and the chance after."""
    phase = Chance(chance.keys, np.full_like(chance.steps, PHASE)).even()
    spell = np.floor(chance.steps * senses.dt / config.persistence + phase).astype(np.int64)
    rate = config.turn_spread * Chance(chance.keys, spell).normal()
    return Commands(np.full_like(rate, config.speed), rate), chance.after()


LAW = Law(RandomWalkConfig, frozenset(), walk, begin)
