"""Perfect range, bearing and heading of every neighbour in line of sight.

The upper bound that every real sensor is held against. Line of sight is computed in the plane: a
marker is hidden where a nearer marker, or an object taller than the markers' base, stands before it.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import TruthSensorConfig
from swarmvision.data import BoolArray, Estimates, Picture, Scene
from swarmvision.geometry import FloatArray, cartesian, compose, inverse, polar, rotate, wrap

RAYS = np.linspace(-0.9, 0.9, 10)  # across a marker's half width; each ray is a tenth of its width
ENOUGH = 0.3  # fraction of a marker's width that must be in sight for it to be seen
VARIANCE = 1e-12  # of a perfect sensor: covariances stay positive definite


class TruthSensor:
    """Line of sight without error; neighbour ``j`` keeps its slot and has track number ``j``."""

    pictures: tuple[Picture, ...] = ()

    def __init__(self, config: TruthSensorConfig, robot: RobotConfig, arena: ArenaConfig) -> None:
        self._config = config
        self._radius = robot.marker.radius
        base = robot.marker.base
        self._blockers = [
            (i, thing) for i, thing in enumerate(arena.objects) if config.occlusion and thing.height > base
        ]

    def sense(self, scene: Scene) -> Estimates:
        """Return the true neighbours of every robot, shape ``(r, r - 1)``."""
        r = scene.robots
        if r < 2:
            return Estimates.empty((r, 0))
        others = np.array([[j for j in range(r) if j != i] for i in range(r)])  # (r, r - 1)
        relative = compose(inverse(scene.pose)[:, None], scene.pose[others])
        distance, bearing, heading = polar(relative)
        visible = self._visible(scene, distance, bearing)
        seen = (
            (visible >= ENOUGH)
            & (distance <= self._config.reach)
            & (np.abs(bearing) <= np.radians(self._config.fov_deg) / 2.0)
        )
        covariance = np.where(seen[..., None, None], VARIANCE * np.eye(3), np.nan)
        return Estimates(
            seen=seen,
            range=np.where(seen, distance, np.nan),
            bearing=np.where(seen, bearing, np.nan),
            heading=np.where(seen, heading, np.nan),
            covariance=covariance,
            age=np.where(seen, 0.0, np.nan),
            track=np.where(seen, others, -1),
            visible=np.where(seen, visible, 0.0),
        )

    def _visible(self, scene: Scene, distance: FloatArray, bearing: FloatArray) -> FloatArray:
        """Return the fraction of each marker's width that nothing hides, shape ``(r, k)``."""
        if not self._config.occlusion:
            return np.ones_like(distance)
        half = np.arcsin(np.minimum(self._radius / distance, 1.0))
        rays = bearing[..., None] + RAYS * half[..., None]  # (r, k, rays)
        hidden = np.zeros(rays.shape, dtype=bool)
        for n in range(distance.shape[1]):  # the n-th neighbour of each robot as the one in front
            nearer = distance[:, n, None] < distance
            nearer[:, n] = False
            across = np.abs(wrap(rays - bearing[:, n, None, None])) < half[:, n, None, None]
            hidden |= across & nearer[..., None]
        for index, thing in self._blockers:
            blocker = compose(inverse(scene.pose), scene.object_pose[index])  # (r, 3)
            hidden |= _blocked(rays, distance, blocker, thing)
        visible: FloatArray = 1.0 - hidden.mean(axis=-1)
        return visible


def _blocked(
    rays: FloatArray, distance: FloatArray, blocker: FloatArray, thing: BoxConfig | DiscConfig
) -> BoolArray:
    """Return which rays ``(r, k, rays)`` meet an object, at its pose ``(r, 3)``, before the marker."""
    towards = cartesian(np.ones_like(rays), rays)
    if isinstance(thing, DiscConfig):
        along = np.einsum("rknc,rc->rkn", towards, blocker[:, :2])
        square = np.sum(blocker[:, :2] ** 2, axis=-1)[:, None, None]
        miss = square - along**2
        disc: BoolArray = (along > 0) & (miss < thing.radius**2) & (along < distance[..., None])
        return disc
    # In the box's own frame: the slab test.
    yaw = blocker[:, 2]
    start = rotate(-blocker[:, :2], -yaw)[:, None, None]
    step = rotate(towards, -yaw[:, None, None])
    step = np.where(np.abs(step) < 1e-12, 1e-12, step)
    half = np.array([thing.length, thing.width]) / 2.0
    one, two = (-half - start) / step, (half - start) / step
    enter = np.max(np.minimum(one, two), axis=-1)
    leave = np.min(np.maximum(one, two), axis=-1)
    box: BoolArray = (enter < leave) & (leave > 0) & (enter < distance[..., None])
    return box
