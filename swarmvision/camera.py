"""Pixels and directions for one lens, and where the lenses of a rig sit on a robot.

Lens frame: x along the optical axis, y left, z up. A picture's column is counted from its left
border and its row from its top border, in px; the first pixel's centre is at (0.5, 0.5). For a
level lens a column is one vertical plane, so bearing depends on the column alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from swarmvision.geometry import FloatArray, compose

if TYPE_CHECKING:
    from swarmvision.config.camera import LensConfig, RigConfig

UNDISTORT_STEPS = 12  # fixed-point steps; 1e-9 px for the distortion of a Pi lens


@dataclass(frozen=True, slots=True)
class Lens:
    """A pinhole with the five-coefficient distortion of OpenCV (k1, k2, p1, p2, k3)."""

    width_px: int
    height_px: int
    focal_px: float
    centre_px: tuple[float, float]
    """Column and row of the principal point."""
    height: float
    """Of the lens centre above the ground (m)."""
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    @property
    def bearing_limits(self) -> tuple[float, float]:
        """Bearing (rad) of the right (negative) and the left border of the picture, undistorted."""
        left, right = self.bearing_from_column(np.array([0.0, float(self.width_px)]))
        return float(right), float(left)

    @property
    def fov(self) -> float:
        """Horizontal field of view (rad), undistorted."""
        right, left = self.bearing_limits
        return left - right

    def bearing_from_column(self, column_px: ArrayLike) -> FloatArray:
        """Return the bearing (rad, left positive) of an undistorted column (px)."""
        return np.arctan2(self.centre_px[0] - np.asarray(column_px, dtype=np.float64), self.focal_px)

    def column_from_bearing(self, bearing: ArrayLike) -> FloatArray:
        """Return the undistorted column (px) of a bearing (rad) in (-pi/2, pi/2)."""
        return self.centre_px[0] - self.focal_px * np.tan(np.asarray(bearing, dtype=np.float64))

    def rise_from_row(self, row_px: ArrayLike) -> FloatArray:
        """Return height over depth of an undistorted row (px): m up per m along the optical axis."""
        return (self.centre_px[1] - np.asarray(row_px, dtype=np.float64)) / self.focal_px

    def row_from_rise(self, rise: ArrayLike) -> FloatArray:
        """Return the undistorted row (px) of a height over depth."""
        return self.centre_px[1] - self.focal_px * np.asarray(rise, dtype=np.float64)

    @property
    def is_distorted(self) -> bool:
        """Whether the lens bends straight lines."""
        return any(self.distortion)

    def distort(self, px: ArrayLike) -> FloatArray:
        """Return where the real lens puts undistorted points ``(..., 2)`` of column and row (px).

        Brown-Conrady as in OpenCV's camera model (k1, k2, p1, p2, k3), in x right, y down.
        """
        px = np.asarray(px, dtype=np.float64)
        x = (px[..., 0] - self.centre_px[0]) / self.focal_px
        y = (px[..., 1] - self.centre_px[1]) / self.focal_px
        scale, dx, dy = self._bend(x, y)
        return self._px(x * scale + dx, y * scale + dy)

    def undistort(self, px: ArrayLike) -> FloatArray:
        """Return the points ``(..., 2)`` (px) of a perfect pinhole; inverts :meth:`distort`."""
        px = np.asarray(px, dtype=np.float64)
        if not self.is_distorted:
            return px.copy()
        bent_x = (px[..., 0] - self.centre_px[0]) / self.focal_px
        bent_y = (px[..., 1] - self.centre_px[1]) / self.focal_px
        x, y = bent_x, bent_y
        for _ in range(UNDISTORT_STEPS):
            scale, dx, dy = self._bend(x, y)
            x, y = (bent_x - dx) / scale, (bent_y - dy) / scale
        return self._px(x, y)

    def _bend(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        k1, k2, p1, p2, k3 = self.distortion
        square = x * x + y * y
        scale = 1.0 + square * (k1 + square * (k2 + square * k3))
        dx = 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x)
        dy = p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y
        return scale, dx, dy

    def _px(self, x: FloatArray, y: FloatArray) -> FloatArray:
        return np.stack(
            [self.centre_px[0] + self.focal_px * x, self.centre_px[1] + self.focal_px * y], axis=-1
        )

    @classmethod
    def from_config(cls, config: LensConfig) -> Lens:
        """Return the lens that a camera file describes."""
        centre = config.centre_px or (config.width_px / 2.0, config.height_px / 2.0)
        return cls(
            width_px=config.width_px,
            height_px=config.height_px,
            focal_px=config.focal_px,
            centre_px=centre,
            height=config.height,
            distortion=config.distortion,
        )


@dataclass(frozen=True, slots=True)
class Servo:
    """Sweeps a lens to and fro about the robot's axis.

    Without stops a triangle wave, so its speed is its limit. With stops it rests at the middle of each of
    ``stops`` equal parts of the sweep, from the middle one to the left end, to the right end and back.
    """

    amplitude: float
    """Largest pan to either side (rad)."""
    speed: float
    """Pan speed (rad/s), of a sweep without stops."""
    stops: int = 0
    interval: float = 0.1
    """From one stop to the next (s)."""
    rest: float = 0.0
    """Of that, at a stop (s)."""

    def pan(self, time: ArrayLike) -> FloatArray:
        """Return the pan (rad, left positive) at a time (s); turning left at time 0."""
        time = np.asarray(time, dtype=np.float64)
        if self.stops > 0:
            here, there, moved = self._between(time)
            return here + moved * (there - here)
        if self.amplitude == 0.0 or self.speed == 0.0:
            return np.zeros_like(time)
        phase = np.mod(time * self.speed / self.amplitude + 1.0, 4.0)  # a sweep is 2, a period is 4
        return self.amplitude * (1.0 - np.abs(phase - 2.0))

    def pan_rate(self, time: ArrayLike) -> FloatArray:
        """Return the pan speed (rad/s, left positive) at a time (s)."""
        time = np.asarray(time, dtype=np.float64)
        if self.stops > 0:
            here, there, moved = self._between(time)
            return np.where(moved > 0.0, (there - here) / (self.interval - self.rest), 0.0)
        if self.amplitude == 0.0 or self.speed == 0.0:
            return np.zeros_like(time)
        phase = np.mod(time * self.speed / self.amplitude + 1.0, 4.0)
        return np.where(phase < 2.0, self.speed, -self.speed)

    def _between(self, time: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the stops (rad) before and after a time (s), and how much of the way is done, 0..1."""
        count = np.floor(time / self.interval + 1e-6)  # exposure times are sums
        passed = time - count * self.interval - self.rest
        return self._stop(count), self._stop(count + 1.0), np.clip(passed / (self.interval - self.rest), 0, 1)

    def _stop(self, count: FloatArray) -> FloatArray:
        last = self.stops - 1
        place = np.mod(count + self.stops // 2, max(2 * last, 1))
        place = np.minimum(place, 2 * last - place)
        stop: FloatArray = self.amplitude * ((2.0 * place + 1.0) / self.stops - 1.0)
        return stop


@dataclass(frozen=True, slots=True)
class Rig:
    """Lenses of one kind round a robot's vertical axis, fixed or panned together by a servo."""

    lens: Lens
    forward: float
    """Distance of every lens centre from the robot's axis, along the lens's own yaw (m)."""
    yaws: tuple[float, ...]
    """Where the lenses look, relative to the robot (rad), left positive."""
    servo: Servo | None = None
    one_centre: bool = False
    """Whether all look from one place, ``forward`` of the axis along the nose, before the servo turns it."""

    def robot_from_lens(self, time: float) -> FloatArray:
        """Return the pose of every lens in the robot frame at a time (s), shape ``(lenses, 3)``."""
        yaws = np.array(self.yaws, dtype=np.float64)
        pan = self.servo.pan(time) if self.servo is not None else 0.0
        on_axis, ahead = np.zeros((len(yaws), 3)), np.zeros((len(yaws), 3))
        ahead[:, 0] = self.forward
        if self.one_centre:
            on_axis[:, 2], ahead[:, 2] = pan, yaws
        else:
            on_axis[:, 2] = yaws + pan
        return compose(on_axis, ahead)

    @classmethod
    def from_config(cls, lens: LensConfig, rig: RigConfig) -> Rig:
        """Return the rig of the given lens."""
        servo = None
        if rig.servo is not None:
            sweep = rig.servo
            amplitude, speed = np.radians([sweep.amplitude_deg, sweep.speed_deg])
            servo = Servo(amplitude, speed, sweep.stops, sweep.interval, sweep.rest)
        yaws = tuple(float(yaw) for yaw in np.radians(rig.yaws_deg))
        return cls(Lens.from_config(lens), rig.forward, yaws, servo, rig.one_centre)
