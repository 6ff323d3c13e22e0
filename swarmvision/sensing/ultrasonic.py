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
from numpy.typing import NDArray

from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import UltrasonicSensorConfig
from swarmvision.data import BoolArray, IntArray, Scene
from swarmvision.sensing.ranging import RangingSensor, Spread
from swarmvision.sensing.sight import View

CLOCK_SLACK = 1e-9  # s; sums of control periods are not exact


class UltrasonicSensor(RangingSensor):
    """The transducers of all robots."""

    def __init__(
        self,
        config: UltrasonicSensorConfig,
        robot: RobotConfig,
        arena: ArenaConfig,
        seed: int = 0,
        team_sizes: tuple[int, ...] = (),
    ) -> None:
        view = View.of(robot, arena, config.reach, 2.0 * np.pi, occlusion=config.occlusion)
        super().__init__(config, view, Spread.of(config, config.range_noise, 0.0), seed, team_sizes)
        self._turn = config.turn
        self._turns = -1

    def arrives(self, scene: Scene, who: IntArray, keys: NDArray[np.uint64]) -> BoolArray:
        """Return who sounded since the last call, shape ``(r, k)``."""
        sounded = np.append(self._sounded(scene), False)  # the last stands for nobody's number, -1
        return sounded[who]

    def _sounded(self, scene: Scene) -> BoolArray:
        """Return whose turn came up since the last call, shape ``(r,)``; the first robot's is at time 0."""
        turns = int(np.floor((scene.time + CLOCK_SLACK) / self._turn))
        new = np.arange(max(self._turns + 1, turns - scene.robots + 1), turns + 1)
        self._turns = turns
        sounded = np.zeros(scene.robots, dtype=bool)
        if scene.robots:
            sounded[new % scene.robots] = True
        return sounded
