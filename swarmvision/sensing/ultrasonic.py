"""Ultrasonic relative positioning: exact, far, and one robot at a time.

The paper (Majidi Balanji et al.) quotes 8 mm and 3 deg at 6.7 m and a slow refresh. We take both as standard
deviations at any range up to there. Robots sound in turn, by number, so each is read once in the time of a
turn times the number of robots; between its turns a listener carries a neighbour on by its own odometry
(:mod:`swarmvision.sensing.delivery`). A turn that ended within a control step counts as at the step's end.

The transducer sits at the marker, so line of sight is as for a camera; sound that bends or echoes is not
modelled.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import UltrasonicSensorConfig
from swarmvision.data import BoolArray, Estimates, Picture, Scene
from swarmvision.randomness import RobotKeys, Subsystem
from swarmvision.sensing.ranging import Spread, measured, only
from swarmvision.sensing.sight import View
from swarmvision.sensing.truth import Teams, sight

CLOCK_SLACK = 1e-9  # s; sums of control periods are not exact


class UltrasonicSensor:
    """The transducers of all robots, the nearest neighbours first; a track is a number, a kind a team."""

    pictures: tuple[Picture, ...] = ()

    def __init__(
        self,
        config: UltrasonicSensorConfig,
        robot: RobotConfig,
        arena: ArenaConfig,
        seed: int = 0,
        team_sizes: tuple[int, ...] = (),
    ) -> None:
        self._teams = Teams(team_sizes)
        self._config = config
        self._view = View.of(robot, arena, config.reach, 2.0 * np.pi, occlusion=config.occlusion)
        self._spread = Spread(
            range=config.range_noise,
            range_share=0.0,
            bearing=np.radians(config.bearing_noise_deg),
            heading=np.radians(config.heading_noise_deg) if config.heading else None,
        )
        self._keys = RobotKeys(seed, Subsystem.SENSOR)
        self._readings = 0
        self._turns = -1

    def sense(self, scene: Scene) -> Estimates:
        """Return what each robot reads of those that sounded since the last call, shape ``(r, k)``."""
        most = max(scene.robots - 1, 0)
        if self._config.neighbours is not None:
            most = min(most, self._config.neighbours)
        sounded = self._sounded(scene)
        who, seen = sight(scene.pose[None], scene.object_pose[None], self._view, most)
        who, seen = who[0], seen[0]
        if scene.robots:
            who, seen = only(who, seen, sounded[who])
        estimates = measured(
            who, seen, self._teams.of(who), self._spread, self._keys.of(scene.robots), self._readings
        )
        self._readings += 1
        return estimates

    def _sounded(self, scene: Scene) -> BoolArray:
        """Return whose turn came up since the last call, shape ``(r,)``; the first robot's is at time 0."""
        turns = int(np.floor((scene.time + CLOCK_SLACK) / self._config.turn))
        new = np.arange(max(self._turns + 1, turns - scene.robots + 1), turns + 1)
        self._turns = turns
        sounded = np.zeros(scene.robots, dtype=bool)
        if scene.robots:
            sounded[new % scene.robots] = True
        return sounded
