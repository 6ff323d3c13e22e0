"""Unicycle commands and wheel speeds of a differential drive: conversion, saturation, motor lag.

The drive clips, once and here. Saturation scales both wheels by one factor, so that a command that
is too fast keeps its curvature.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from swarmvision.compiled import leaf
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

    def kept(self, dt: float, steps: int) -> FloatArray:
        """Return the share of a change of speed that is to come after each of some steps, ``(steps,)``."""
        if self.time_constant == 0.0:
            return np.zeros(steps)
        left_over: FloatArray = np.exp(-dt * np.arange(1, steps + 1) / self.time_constant)
        return left_over

    @classmethod
    def from_config(cls, config: RobotConfig) -> Drive:
        """Return the drive of a robot."""
        return cls(
            track=config.track,
            max_wheel_speed=config.max_wheel_speed,
            time_constant=config.motor_time_constant,
            turn_slip=config.turn_slip,
        )


@leaf
def over_ground(left: float, right: float, track: float, slip: float) -> tuple[float, float]:
    """Return forward speed and turn rate by those of the tracks, as :meth:`Drive.twist`; or way and turn."""
    return (left + right) / 2.0, (right - left) / track * (1.0 - slip)


@leaf
def run_tracks(
    speed: FloatArray,
    turn_rate: FloatArray,
    drive: tuple[float, float, float],
    kept: FloatArray,
    dt: float,
    wheels: FloatArray,
    travel: FloatArray,
    ahead: FloatArray,
    turning: FloatArray,
) -> int:
    """Run the tracks of robots ``n`` through the steps of a period: all that :class:`Drive` does, at once.

    Args:
        speed: Commanded (m/s), shape ``(n,)``.
        turn_rate: Commanded (rad/s), shape ``(n,)``.
        drive: Track (m), top speed of a wheel (m/s) and slip of a turn.
        kept: From :meth:`Drive.kept`, shape ``(s,)``.
        dt: Of a step (s).
        wheels: In and out: speed of the left and the right track (m/s), shape ``(2, n)``.
        travel: In and out: their way (m), shape ``(2, n)``.
        ahead: Out: speed over ground at the end of each step (m/s), shape ``(s, n)``.
        turning: Out: turn rate likewise (rad/s).

    Returns:
        How many commands are not finite; if any, nothing is done.
    """
    track, most, slip = drive
    bad = 0
    for n in range(len(speed)):
        bad += 0 if (abs(speed[n]) < np.inf) & (abs(turn_rate[n]) < np.inf) else 1
    if bad > 0:
        return bad
    left, right, left_way, right_way = wheels[0], wheels[1], travel[0], travel[1]
    last = len(kept) - 1
    for s in range(len(kept)):
        fast, turned, share = ahead[s], turning[s], kept[s]
        for n in range(len(speed)):
            half = turn_rate[n] * track / 2.0 / (1.0 - slip)
            scale = most / max(abs(speed[n] - half), abs(speed[n] + half), most)
            wanted_left, wanted_right = (speed[n] - half) * scale, (speed[n] + half) * scale
            now_left = wanted_left + (left[n] - wanted_left) * share
            now_right = wanted_right + (right[n] - wanted_right) * share
            fast[n], turned[n] = over_ground(now_left, now_right, track, slip)
            # The way is the trapezoid under the speeds; it is summed before the speeds are replaced.
            weight = dt if s < last else dt / 2.0
            left_way[n] += now_left * weight + (left[n] * dt / 2.0 if s == 0 else 0.0)
            right_way[n] += now_right * weight + (right[n] * dt / 2.0 if s == 0 else 0.0)
            left[n], right[n] = (now_left, now_right) if s == last else (left[n], right[n])
    return 0
