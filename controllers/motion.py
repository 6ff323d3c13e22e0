"""From a wanted direction or velocity to a unicycle command, for every law. The drive saturates, not we.

Sources: A. E. Turgut, H. Celikkanat, F. Gokce, E. Sahin, "Self-organized flocking in mobile robot
swarms", Swarm Intelligence 2, 2008, doi:10.1007/s11721-008-0016-2 (heading-dependent motion control);
E. Ferrante, A. E. Turgut, C. Huepe, A. Stranieri, C. Pinciroli, M. Dorigo, "Self-organized flocking with a
mobile robot swarm: a novel motion control method", Adaptive Behavior 20(6), 2012,
doi:10.1177/1059712312462248 (magnitude-dependent motion control).
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import Alone, ParticleDrive
from swarmvision.controllers.crowd import ComplexArray
from swarmvision.data import BoolArray, Commands, Senses
from swarmvision.geometry import FloatArray

SCAN_RATE = 1.0  # rad/s: how fast a lone robot looks about


def turn_and_go(forward: FloatArray, left: FloatArray, speed: float, turn_gain: float) -> Commands:
    """Return the command that turns towards a direction and goes the faster the nearer it is to it.

    ``v = speed * max(0, cos(phi))``, ``w = turn_gain * phi`` with ``phi`` the angle of the direction.

    Args:
        forward: Of the wanted direction in the robot frame, shape ``(...)``; any length.
        left: The same.
        speed: Cruise speed (m/s).
        turn_gain: Proportional gain (1/s).
    """
    angle = np.arctan2(left, forward)
    return Commands(speed * np.maximum(np.cos(angle), 0.0), turn_gain * angle)


def glide(
    forward: FloatArray,
    left: FloatArray,
    speed: float,
    top_speed: float,
    gains: tuple[float, float],
) -> Commands:
    """Return the command whose forward speed and turn rate follow a vector's two components.

    ``v = speed + gains[0] * forward`` in ``0..top_speed``, ``w = gains[1] * left``: the vector's size counts,
    and nobody needs to know where anybody faces.

    Args:
        forward: Of the vector in the robot frame, shape ``(...)``.
        left: The same.
        speed: With no vector at all (m/s).
        top_speed: m/s
        gains: Of the speed (m/s) and of the turn rate (rad/s) on a vector of length 1.
    """
    return Commands(np.clip(speed + gains[0] * forward, 0.0, top_speed), gains[1] * left)


def look_ahead(forward: FloatArray, left: FloatArray, length: float, top_speed: float) -> Commands:
    """Return the command that gives a point ahead of the axle a wanted velocity.

    ``v = forward``, ``w = left / length``: the point at ``length`` (m) ahead can move in any direction at
    once, so laws for free-moving particles hold for it. The velocity is shortened to ``top_speed`` (m/s).
    """
    size = np.hypot(forward, left)
    scale = top_speed / np.maximum(size, top_speed)
    return Commands(forward * scale, left * scale / length)


def accelerated(acceleration: ComplexArray, senses: Senses, drive: ParticleDrive) -> Commands:
    """Return the command that accelerates a point ahead of the axle, and holds its cruise speed.

    The velocity of the point is the present one, by the encoders, carried on for the horizon of the drive
    with the acceleration, and with a return of its size to the cruise speed, which is ours.

    Args:
        acceleration: Robot frame (m/s^2), ahead is real and left imaginary, shape ``(...)``.
        senses: For the own motion.
        drive: Cruise speed, top speed, the point and the horizon.
    """
    velocity = own_velocity(senses, drive)
    size = np.abs(velocity)
    direction = np.where(size > 1e-9, velocity / np.maximum(size, 1e-9), 1.0)
    cruise = drive.cruise_gain * (drive.speed - size) * direction
    wanted = velocity + drive.horizon * (acceleration + cruise)
    return look_ahead(wanted.real, wanted.imag, drive.look_ahead, drive.top_speed)


def own_velocity(senses: Senses, drive: ParticleDrive) -> ComplexArray:
    """Return the velocity (m/s) of the point ahead of the axle in the robot frame, shape ``(...)``."""
    return np.asarray(senses.speed + 1j * drive.look_ahead * senses.turn_rate)


def with_alone(commands: Commands, seen_any: BoolArray | np.bool_, policy: Alone, speed: float) -> Commands:
    """Return the commands with the declared policy where a robot sees nobody, shape ``(...)``."""
    if np.all(seen_any):
        return commands
    lone_speed = speed if policy == "keep" else 0.0
    lone_turn = SCAN_RATE if policy == "scan" else 0.0
    return Commands(
        np.where(seen_any, commands.speed, lone_speed),
        np.where(seen_any, commands.turn_rate, lone_turn),
    )
