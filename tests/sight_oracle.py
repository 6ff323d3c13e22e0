"""Line of sight as plain NumPy over all pairs: slow, and simple enough to be believed."""

from __future__ import annotations

import numpy as np

from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import BoolArray, Scene
from swarmvision.geometry import FloatArray, cartesian, compose, inverse, polar, rotate, wrap
from swarmvision.sensing.shadows import RAYS


def visible_fraction(scene: Scene, robot: RobotConfig, arena: ArenaConfig) -> FloatArray:
    """Return how much of marker ``j`` robot ``i`` has in sight, shape ``(r, r)``; 1 on the diagonal."""
    r = scene.robots
    relative = compose(inverse(scene.pose)[:, None], scene.pose[None])
    distance, bearing, _ = polar(relative)
    distance[np.eye(r, dtype=bool)] = np.inf  # nobody hides anything from himself
    half = np.arcsin(np.minimum(robot.marker.radius / distance, 1.0))
    rays = bearing[..., None] + RAYS * half[..., None]  # (r, r, rays)
    hidden = np.zeros(rays.shape, dtype=bool)
    for n in range(r):  # the n-th robot as the one in front
        nearer = distance[:, n, None] < distance
        across = np.abs(wrap(rays - bearing[:, n, None, None])) < half[:, n, None, None]
        hidden |= across & nearer[..., None]
    for index, thing in enumerate(arena.objects):
        if thing.height > robot.marker.base:
            place = compose(inverse(scene.pose), scene.object_pose[index])  # (r, 3)
            hidden |= _blocked(rays, distance, place, thing)
    visible: FloatArray = 1.0 - hidden.mean(axis=-1)
    return visible


def _blocked(
    rays: FloatArray, distance: FloatArray, place: FloatArray, thing: BoxConfig | DiscConfig
) -> BoolArray:
    towards = cartesian(np.ones_like(rays), rays)
    if isinstance(thing, DiscConfig):
        along = np.einsum("rknc,rc->rkn", towards, place[:, :2])
        miss = np.sum(place[:, :2] ** 2, axis=-1)[:, None, None] - along**2
        disc: BoolArray = (along > 0) & (miss < thing.radius**2) & (along < distance[..., None])
        return disc
    yaw = place[:, 2]
    start = rotate(-place[:, :2], -yaw)[:, None, None]  # in the box's own frame: the slab test
    step = rotate(towards, -yaw[:, None, None])
    step = np.where(np.abs(step) < 1e-12, 1e-12, step)
    half = np.array([thing.length, thing.width]) / 2.0
    one, two = (-half - start) / step, (half - start) / step
    enter = np.max(np.minimum(one, two), axis=-1)
    leave = np.min(np.maximum(one, two), axis=-1)
    box: BoolArray = (enter < leave) & (leave > 0) & (enter < distance[..., None])
    return box
