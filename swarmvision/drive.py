"""Unicycle commands and wheel speeds of a differential drive: conversion, saturation, motor lag.

The drive clips, once and here. Saturation scales both wheels by one factor, so that a command that
is too fast keeps its curvature.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from swarmvision.geometry import FloatArray

if TYPE_CHECKING:
    from swarmvision.config.robot import RobotConfig


@dataclass(frozen=True, slots=True)
class Drive:
    """Two driven tracks side by side."""

    track: float
    """Distance between the tracks' centre lines (m)."""
    max_wheel_speed: float
    """m/s"""
    time_constant: float
    """First-order lag of motor and gear (s); 0 for none."""
    turn_slip: float
    """Fraction of the wheels' turn rate that tracks lose by scrubbing, 0..1."""

    def wheel_speeds(self, speed: ArrayLike, turn_rate: ArrayLike) -> FloatArray:
        """Return left and right wheel speed (m/s) ``(..., 2)`` for a unicycle command, unlimited."""
        speed = np.asarray(speed, dtype=np.float64)
        # A skid-steered robot must over-drive its tracks to turn as fast as asked.
        half = np.asarray(turn_rate, dtype=np.float64) * self.track / 2.0 / (1.0 - self.turn_slip)
        return np.stack([speed - half, speed + half], axis=-1)

    def twist(self, wheel_speed: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return forward speed (m/s) and turn rate (rad/s) over ground; inverts :meth:`wheel_speeds`."""
        wheels = np.asarray(wheel_speed, dtype=np.float64)
        left, right = wheels[..., 0], wheels[..., 1]
        return (left + right) / 2.0, (right - left) / self.track * (1.0 - self.turn_slip)

    def saturate(self, wheel_speed: ArrayLike) -> FloatArray:
        """Return the wheel speeds ``(..., 2)`` scaled, both alike, to the limit."""
        wheels = np.asarray(wheel_speed, dtype=np.float64)
        fastest = np.max(np.abs(wheels), axis=-1, keepdims=True)
        scale: FloatArray = self.max_wheel_speed / np.maximum(fastest, self.max_wheel_speed)
        return wheels * scale

    def lag(self, wheel_speed: ArrayLike, wanted: ArrayLike, dt: ArrayLike) -> FloatArray:
        """Return the wheel speeds ``(..., 2)`` after ``dt`` (s) of first-order approach to ``wanted``.

        All three broadcast, so that one call tells the speeds at several times.
        """
        wheels = np.asarray(wheel_speed, dtype=np.float64)
        wanted = np.asarray(wanted, dtype=np.float64)
        if self.time_constant == 0.0:
            return np.array(
                np.broadcast_to(wanted, np.broadcast_shapes(wheels.shape, wanted.shape, np.shape(dt)))
            )
        left_over: FloatArray = np.exp(-np.asarray(dt, dtype=np.float64) / self.time_constant)
        after: FloatArray = wanted + (wheels - wanted) * left_over
        return after

    @classmethod
    def from_config(cls, config: RobotConfig) -> Drive:
        """Return the drive of a robot."""
        return cls(
            track=config.track,
            max_wheel_speed=config.max_wheel_speed,
            time_constant=config.motor_time_constant,
            turn_slip=config.turn_slip,
        )
