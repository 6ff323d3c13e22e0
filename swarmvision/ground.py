"""What the floor does to a body that stands on it: traction of tracks, rubbing of things that are pushed.

Both pull the body's velocity towards one that is wanted, the tracks' or rest, with no more force than
Coulomb friction under its weight allows.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray

if TYPE_CHECKING:
    from swarmvision.config.arena import BoxConfig, DiscConfig
    from swarmvision.config.robot import RobotConfig

GRAVITY = 9.81  # m/s^2
X, Y, ANGLE, VX, VY, SPIN = range(6)  # columns of a body's state
NO_GRIP = (0.0, 0.0, 0.0, 0.0)  # of what does not move


@compiled
def traction(
    state: FloatArray, twist: FloatArray, grips: FloatArray, dt: float, lead: float, force: FloatArray
) -> None:
    """Fill in what the floor does to each body in a substep, within what friction allows.

    Args:
        state: x, y (m), angle (rad), velocity (m/s) and spin (rad/s), shape ``(n, 6)``.
        twist: Speed ahead (m/s) and turn rate (rad/s) that the tracks run at, shape ``(n, 2)``.
        grips: As from :func:`grip`, shape ``(n, 4)``.
        dt: Of the substep (s).
        lead: How much later than the state's the angle is wanted at which the tracks pull (s).
        force: Out: force (N) and torque (N m), shape ``(n, 3)``.
    """
    for i in range(len(state)):
        mass, moment, most, spin_most = grips[i, 0], grips[i, 1], grips[i, 2], grips[i, 3]
        if mass == 0.0:
            continue
        angle = state[i, ANGLE] + state[i, SPIN] * lead
        change_x = twist[i, 0] * math.cos(angle) - state[i, VX]
        change_y = twist[i, 0] * math.sin(angle) - state[i, VY]
        size = math.sqrt(change_x * change_x + change_y * change_y)
        share = min(1.0, most * dt / max(size, 1e-12))
        limit = spin_most * dt
        spin = max(-limit, min(limit, twist[i, 1] - state[i, SPIN]))
        force[i, 0], force[i, 1] = mass * share * change_x / dt, mass * share * change_y / dt
        force[i, 2] = moment * spin / dt


def travelled(before: FloatArray, wheels: FloatArray, dt: float) -> FloatArray:
    """Return the way of the wheels (m) over substeps that end at speeds ``(substeps, ..., 2)`` (m/s)."""
    way: FloatArray = (before / 2.0 + wheels[:-1].sum(axis=0) + wheels[-1] / 2.0) * dt
    return way


def grip(
    mass: float | None, moment: float, friction: float, lever: float
) -> tuple[float, float, float, float]:
    """Return mass (kg), moment (kg m^2) and the most that the floor accelerates (m/s^2, rad/s^2).

    Args:
        mass: kg; None for what is fixed.
        moment: Of inertia (kg m^2).
        friction: Coulomb's coefficient.
        lever: Mean radius at which the floor resists a spin (m).
    """
    if mass is None:
        return NO_GRIP
    return mass, moment, friction * GRAVITY, friction * GRAVITY * mass * lever / moment


def lever_of(length: float, width: float) -> float:
    """Return the mean radius (m) at which ground friction resists a box's spin."""
    return math.hypot(length, width) / 3.0


def robot_grip(robot: RobotConfig, moment: float) -> tuple[float, float, float, float]:
    """Return the grip of a robot."""
    return grip(robot.mass, moment, robot.traction, lever_of(robot.length, robot.width))


def thing_grip(
    thing: BoxConfig | DiscConfig, moment: float, friction: float
) -> tuple[float, float, float, float]:
    """Return the grip of an object on a floor."""
    lever = 2.0 / 3.0 * thing.radius if thing.kind == "disc" else lever_of(thing.length, thing.width)
    return grip(thing.mass, moment, friction, lever)
