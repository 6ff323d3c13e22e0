"""What the floor does to a body that stands on it: traction of tracks, rubbing of things that are pushed.

Both pull the body's velocity towards one that is wanted, the tracks' or rest, with no more force than
Coulomb friction under its weight allows.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.trigonometry import sine_cosine, wrapped

if TYPE_CHECKING:
    from swarmvision.config.arena import BoxConfig, DiscConfig
    from swarmvision.config.robot import RobotConfig

GRAVITY = 9.81  # m/s^2
X, Y, ANGLE, VX, VY, SPIN = range(6)  # columns of a body's state
NO_GRIP = (0.0, 0.0, 0.0, 0.0)  # of what does not move


@leaf
def traction(
    state: FloatArray,
    ahead: FloatArray,
    turning: FloatArray,
    grips: FloatArray,
    dt: float,
    lead: float,
    force: FloatArray,
) -> None:
    """Fill in what the floor does to each robot in a substep, within what friction allows.

    Args:
        state: x, y (m), angle (rad), velocity (m/s) and spin (rad/s), shape ``(n, 6)``.
        ahead: Speed (m/s) that the tracks of the first ``r`` bodies run at, shape ``(r,)``.
        turning: Their turn rate (rad/s), shape ``(r,)``.
        grips: As from :func:`grip`, shape ``(r, 4)``.
        dt: Of the substep (s).
        lead: How much later than the state's the angle is wanted at which the tracks pull (s).
        force: Out: force (N) and torque (N m), shape ``(n, 3)``.
    """
    for i in range(len(ahead)):
        mass, moment = grips[i, 0], grips[i, 1]
        angle = state[i, ANGLE] + state[i, SPIN] * lead
        change_x, change_y = pull(angle, state[i, VX], state[i, VY], ahead[i], grips[i, 2] * dt)
        force[i, 0], force[i, 1] = mass * change_x / dt, mass * change_y / dt
        force[i, 2] = moment * pull_round(state[i, SPIN], turning[i], grips[i, 3] * dt) / dt


@leaf
def pull(angle: float, vx: float, vy: float, ahead: float, most: float) -> tuple[float, float]:
    """Return the change of velocity (m/s) by tracks that run ``ahead`` (m/s), no larger than ``most``."""
    sine, cosine = sine_cosine(angle)
    change_x, change_y = ahead * cosine - vx, ahead * sine - vy
    size = math.sqrt(change_x * change_x + change_y * change_y)
    share = min(1.0, most / max(size, 1e-12))
    return share * change_x, share * change_y


@leaf
def pull_round(spin: float, turning: float, most: float) -> float:
    """Return the change of spin (rad/s) by tracks that turn so fast (rad/s), no larger than ``most``."""
    return max(-most, min(most, turning - spin))


@leaf
def settle(state: FloatArray, pose: FloatArray, velocity: FloatArray, fastest: float) -> bool:
    """Fill in poses and velocities ``(n, 3)`` from states ``(n, 6)``; return whether all are sane.

    That is, finite, and no body faster than ``fastest`` (m/s) along an axis.
    """
    wild = 0
    for i in range(len(pose)):
        for c in range(3):
            pose[i, c], velocity[i, c] = state[i, c], state[i, VX + c]
            wild += 0 if (abs(pose[i, c]) < math.inf) & (abs(velocity[i, c]) < math.inf) else 1
        wild += 0 if max(abs(velocity[i, 0]), abs(velocity[i, 1])) <= fastest else 1
        pose[i, ANGLE] = wrapped(pose[i, ANGLE])
    return wild == 0


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
