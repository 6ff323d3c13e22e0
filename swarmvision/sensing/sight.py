"""Line of sight in the plane: what a sensor can see, and what hides it.

How much of a marker is hidden is computed in :mod:`swarmvision.sensing.shadows`; who sees whom in
:mod:`swarmvision.sensing.abreast`, for few robots in any number of worlds, and in
:mod:`swarmvision.sensing.in_turn`, for many robots.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.geometry import FloatArray

ENOUGH = 0.3  # fraction of a marker's width that must be in sight for it to be seen
RANGE, BEARING, HEADING, VISIBLE = 0, 1, 2, 3  # columns of what is seen


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """What does not change between two looks."""

    reach: float
    """m"""
    half_fov: float
    """rad to either side of straight ahead."""
    radius: float
    """Of what is looked at, and hides (m)."""
    occlusion: bool
    """Whether anything hides anything."""
    things: FloatArray
    """Objects tall enough to hide: number in the scene, half length, half width, or radius and
    -1 for a disc (m), shape ``(b, 3)``."""
    ahead: float = 0.0
    """How far before the robot's axis, towards whom it looks at, its eye is (m): a ring of lenses."""

    @property
    def limit(self) -> float:
        """Largest bearing (rad) that is seen; inf all round, for straight behind may round to beyond pi."""
        return np.inf if self.half_fov >= np.pi else self.half_fov

    @classmethod
    def of(
        cls, robot: RobotConfig, arena: ArenaConfig, reach: float, fov: float, *, occlusion: bool = True
    ) -> View:
        """Return the view of the markers in an arena; ``fov`` in rad."""
        things = _taller(arena, robot.marker.base)
        return cls(reach, fov / 2.0, robot.marker.radius, occlusion, things)

    @classmethod
    def of_bodies(
        cls, robot: RobotConfig, arena: ArenaConfig, reach: float, *, occlusion: bool = True
    ) -> View:
        """Return the view all round on top of the chassis: a body hides as the disc inside its outline."""
        radius = min(robot.length, robot.width) / 2.0
        return cls(reach, np.pi, radius, occlusion, _taller(arena, robot.body_height))


def _taller(arena: ArenaConfig, height: float) -> FloatArray:
    things = [(i, *_size(thing)) for i, thing in enumerate(arena.objects) if thing.height > height]
    return np.array(things, np.float64).reshape(-1, 3)


def _size(thing: BoxConfig | DiscConfig) -> tuple[float, float]:
    if isinstance(thing, DiscConfig):
        return thing.radius, -1.0
    return thing.length / 2.0, thing.width / 2.0
