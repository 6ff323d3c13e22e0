"""What bodies are to each other: outlines, masses, and how far they reach."""

from __future__ import annotations

import numpy as np

from swarmvision.config.arena import ArenaConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.geometry import FloatArray
from swarmvision.ground import robot_grip, thing_grip

WALLS = 4
HALF_LENGTH, HALF_WIDTH, RADIUS, FRICTION = range(4)  # columns of a shape; half width is -1 for a disc


def shapes_of(robots: int, robot: RobotConfig, arena: ArenaConfig) -> tuple[FloatArray, FloatArray]:
    """Return the shapes ``(n, 4)`` and the grips ``(n, 4)`` of robots and objects.

    A shape is half length and half width (m), -1 for a disc; the radius of the disc of its area (m); and the
    root of its friction, two of which multiply.
    """
    box = (robot.length / 2.0, robot.width / 2.0, np.sqrt(robot.length * robot.width / np.pi))
    moment = robot.mass * (robot.length**2 + robot.width**2) / 12.0
    shapes = [(*box, np.sqrt(robot.friction))] * robots
    grips = [robot_grip(robot, moment)] * robots
    for thing in arena.objects:
        mass = thing.mass or 1.0
        if isinstance(thing, DiscConfig):
            moment = mass * thing.radius**2 / 2.0
            shape = (thing.radius, -1.0, thing.radius)
        else:
            moment = mass * (thing.length**2 + thing.width**2) / 12.0
            shape = (thing.length / 2.0, thing.width / 2.0, np.sqrt(thing.length * thing.width / np.pi))
        shapes.append((*shape, np.sqrt(arena.wall_friction)))
        grips.append(thing_grip(thing, moment, arena.floor_friction))
    return np.array(shapes).reshape(-1, 4), np.array(grips).reshape(-1, 4)


def bounds_of(robots: int, shapes: FloatArray) -> FloatArray:
    """Return how far bodies reach (m), towards each other and towards walls, shape ``(2, n)``.

    Robots meet each other as discs, and walls as boxes; of a thing it is its outline.
    """
    outline = np.hypot(shapes[:, HALF_LENGTH], np.maximum(shapes[:, HALF_WIDTH], 0.0))
    towards = np.maximum(outline, shapes[:, RADIUS])
    towards[:robots] = shapes[:robots, RADIUS]
    return np.stack([towards, outline])
