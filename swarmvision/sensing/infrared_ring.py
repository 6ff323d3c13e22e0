"""The proximity ring as the only sense: in which sector a robot is close, and about how far.

A sector's reading is the nearest point of a body (:mod:`swarmvision.sensing.proximity`); the axis is
taken to be half a body behind it, in the middle of the sector. Nobody tells who it is, nor its heading.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import InfraredRingSensorConfig
from swarmvision.data import SECTOR_BEARINGS, Estimates, Picture, Scene
from swarmvision.sensing.proximity import ProximityRing


class InfraredRingSensor:
    """The rings of all robots, one slot for each sector."""

    pictures: tuple[Picture, ...] = ()

    def __init__(
        self, config: InfraredRingSensorConfig, robot: RobotConfig, arena: ArenaConfig, seed: int = 0
    ) -> None:
        self._ring = ProximityRing(config, robot, arena, seed)
        self._behind = min(robot.length, robot.width) / 2.0
        corner = np.hypot(robot.length, robot.width) / 2.0
        step = (config.reach - self._behind) / config.levels if config.levels else 0.0
        # Evenly spread over a width w is a variance of w^2/12: the step, and how a body may be turned.
        range_variance = config.noise**2 + (step**2 + (corner - self._behind) ** 2) / 12.0
        self._covariance = np.full((3, 3), np.nan)
        self._covariance[:2, :2] = np.diag([range_variance, (2.0 * np.pi / len(SECTOR_BEARINGS)) ** 2 / 12.0])

    def sense(self, scene: Scene) -> Estimates:
        """Return where each robot feels robots, shape ``(r, 8)``."""
        gap, seen = self._ring.sense(scene)
        return Estimates(
            seen=seen,
            range=np.where(seen, gap + self._behind, np.nan),
            bearing=np.where(seen, SECTOR_BEARINGS, np.nan),
            heading=np.full(gap.shape, np.nan),
            covariance=np.where(seen[..., None, None], self._covariance, np.nan),
            age=np.where(seen, 0.0, np.nan),
            track=np.full(gap.shape, -1),
            visible=seen.astype(np.float64),
        )
