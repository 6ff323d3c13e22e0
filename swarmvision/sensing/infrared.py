"""Infrared range and bearing between robots.

The paper (Majidi Balanji et al.) quotes the infrared and radio system of James et al.: a range error of at
most 6.5 % at 20 cm and a bearing deviation of 9.4 deg, and that it degrades with many robots. We take both
as standard deviations, of any range in its reach, which is the pessimist's reading. Crowding is ours: each
robot sends for a share ``a`` of the time without asking whether the air is free, so a message arrives where
none of the ``n - 1`` other senders in the listener's sight sends at once, with the chance ``(1 - a)^(n - 1)``
(N. Abramson, "The ALOHA System", AFIPS 1970, doi:10.1145/1478462.1478502, with slots).

Light starts from the top of the chassis, so bodies, and objects taller than a chassis, hide what is behind.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import InfraredSensorConfig
from swarmvision.data import BoolArray, IntArray, Scene
from swarmvision.randomness import draw
from swarmvision.sensing.ranging import RangingSensor, Spread
from swarmvision.sensing.sight import View

LOSS = 3  # the channel of chance that decides which messages meet; 0 to 2 are the errors'


class InfraredSensor(RangingSensor):
    """The infrared links of all robots."""

    def __init__(
        self,
        config: InfraredSensorConfig,
        robot: RobotConfig,
        arena: ArenaConfig,
        seed: int = 0,
        team_sizes: tuple[int, ...] = (),
    ) -> None:
        view = View.of_bodies(robot, arena, config.reach, occlusion=config.occlusion)
        spread = Spread.of(config, 0.0, config.range_noise_percent / 100.0)
        super().__init__(config, view, spread, seed, team_sizes)
        self._free = 1.0 - config.airtime

    def arrives(self, scene: Scene, who: IntArray, keys: NDArray[np.uint64]) -> BoolArray:
        """Return whose messages meet no other on the way, shape ``(r, k)``."""
        others = np.count_nonzero(who >= 0, axis=1)[:, None] - 1
        free: BoolArray = draw(keys[:, None], self._reading, who, LOSS) < self._free**others
        return free
