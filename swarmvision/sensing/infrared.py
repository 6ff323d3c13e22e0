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

from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import InfraredSensorConfig
from swarmvision.data import Estimates, Picture, Scene
from swarmvision.randomness import RobotKeys, Subsystem, draw
from swarmvision.sensing.ranging import Spread, measured, only
from swarmvision.sensing.sight import View
from swarmvision.sensing.truth import Teams, sight

LOSS = 3  # the channel of chance that decides which messages meet; 0 to 2 are the errors'


class InfraredSensor:
    """The infrared links of all robots, the nearest neighbours first; a track is a number, a kind a team."""

    pictures: tuple[Picture, ...] = ()

    def __init__(
        self,
        config: InfraredSensorConfig,
        robot: RobotConfig,
        arena: ArenaConfig,
        seed: int = 0,
        team_sizes: tuple[int, ...] = (),
    ) -> None:
        self._teams = Teams(team_sizes)
        self._config = config
        self._view = View.of_bodies(robot, arena, config.reach, occlusion=config.occlusion)
        self._spread = Spread(
            range=0.0,
            range_share=config.range_noise_percent / 100.0,
            bearing=np.radians(config.bearing_noise_deg),
            heading=np.radians(config.heading_noise_deg) if config.heading else None,
        )
        self._keys = RobotKeys(seed, Subsystem.SENSOR)
        self._readings = 0

    def sense(self, scene: Scene) -> Estimates:
        """Return what each robot reads of the neighbours whose messages arrive, shape ``(r, k)``."""
        keys = self._keys.of(scene.robots)
        most = max(scene.robots - 1, 0)
        if self._config.neighbours is not None:
            most = min(most, self._config.neighbours)
        who, seen = sight(scene.pose[None], scene.object_pose[None], self._view, most)
        who, seen = only(who[0], seen[0], who[0] >= 0)
        others = np.count_nonzero(who >= 0, axis=1)[:, None] - 1
        arrives = draw(keys[:, None], self._readings, who, LOSS) < (1.0 - self._config.airtime) ** others
        who, seen = only(who, seen, arrives)
        estimates = measured(who, seen, self._teams.of(who), self._spread, keys, self._readings)
        self._readings += 1
        return estimates
