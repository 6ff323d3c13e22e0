"""The camera file (one lens) and the rig (where lenses of one kind sit)."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from swarmvision.config.model import Settings

Degrees = Annotated[float, Field(ge=-360, le=360)]


class LensConfig(Settings):
    """A camera file: a pinhole with OpenCV's five distortion coefficients."""

    width_px: Annotated[int, Field(ge=1, le=8192)] = 640
    """Picture width (px)."""

    height_px: Annotated[int, Field(ge=1, le=8192)] = 460
    """Picture height (px)."""

    focal_px: Annotated[float, Field(gt=0, le=1e5)] = 634.6
    """Focal length (px). 634.6 at 640 px width is what the paper's constants imply: 53.5 deg."""

    centre_px: tuple[float, float] | None = None
    """Column and row of the principal point (px); the picture's middle where not given."""

    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    """k1, k2, p1, p2, k3 of OpenCV's camera model."""

    height: Annotated[float, Field(ge=0, le=2)] = 0.085
    """Lens centre above the ground (m)."""


class ServoConfig(Settings):
    """A servo that sweeps the lens to and fro, without pause or from stop to stop."""

    amplitude_deg: Annotated[float, Field(ge=0, le=180)] = 180.0
    """Largest pan to either side (deg)."""

    speed_deg: Annotated[float, Field(ge=0, le=1080)] = 600.0
    """Pan speed (deg/s): 60 deg in 0.1 s is a common micro servo at 4.8 V."""

    stops: Annotated[int, Field(ge=0, le=100)] = 0
    """Directions, evenly spread over the sweep, at which it rests for a picture; 0 for no rest. A picture in
    mid-sweep is smeared: 8 ms at 600 deg/s are 57 px of a pi-v1."""

    interval: Annotated[float, Field(gt=0, le=10)] = 0.1
    """From one stop to the next (s): that of the pictures."""

    rest: Annotated[float, Field(ge=0, le=10)] = 0.033
    """Of the interval (s), at a stop: an exposure of 8 ms and the rows' readout of 25 ms."""

    @model_validator(mode="after")
    def _fast_enough(self) -> ServoConfig:
        if self.stops > 1:
            step = 2.0 * self.amplitude_deg / self.stops
            left = self.interval - self.rest
            if step > self.speed_deg * left:
                raise ValueError(
                    f"a servo of {self.speed_deg:g} deg/s needs more than the {left:g} s between two rests "
                    f"for the {step:g} deg from stop to stop"
                )
        return self


class RigConfig(Settings):
    """Where the lenses of one robot look."""

    forward: Annotated[float, Field(ge=0, le=1)] = 0.040
    """Lens centre ahead of the robot's axis, along the lens's own yaw (m); clears the own marker."""

    one_centre: bool = False
    """Whether all look from one place ahead of the axis: views that were cut from one wide picture."""

    yaws_deg: Annotated[tuple[Degrees, ...], Field(min_length=1, max_length=32)] = (0.0,)
    """One lens for each yaw (deg, left positive)."""

    servo: ServoConfig | None = None
    """Pans all lenses together."""

    @model_validator(mode="after")
    def _distinct(self) -> RigConfig:
        if len({yaw % 360.0 for yaw in self.yaws_deg}) < len(self.yaws_deg):
            raise ValueError("two lenses must not share one yaw")
        return self


def _ring(lenses: int) -> RigConfig:
    return RigConfig(yaws_deg=tuple(360.0 * i / lenses for i in range(lenses)))


LENSES: dict[str, LensConfig] = {
    "pi-v1": LensConfig(),
    # Sony IMX219, 3.04 mm lens, 1.12 um pixels: 62.2 deg over 3280 px, binned and scaled to 640 px.
    "pi-v2": LensConfig(width_px=640, height_px=480, focal_px=530.5),
    # Sony IMX708 wide, 2.75 mm lens, 1.4 um pixels: 102 deg over 4608 px, here as a pinhole.
    "pi-v3-wide": LensConfig(width_px=640, height_px=360, focal_px=259.1),
    # 60 deg of an equidistant fisheye that spreads 190 deg over the same 640 px: 193 px/rad, straightened.
    "fisheye-view": LensConfig(width_px=224, height_px=224, focal_px=193.0),
}
"""The paper's camera (Pi camera v1), its two successors, and a view cut from a fisheye's picture."""

RIGS: dict[str, RigConfig] = {
    "single": RigConfig(),
    "ring-2": _ring(2),
    "ring-4": _ring(4),
    "ring-7": _ring(7),
    "pan": RigConfig(servo=ServoConfig(stops=9)),
    # Four views of 60 deg across 190 deg: 16.7 deg in common, so that a marker is whole in one of two.
    "fisheye": RigConfig(yaws_deg=(65.0, 65.0 / 3.0, -65.0 / 3.0, -65.0), one_centre=True),
}
"""One lens ahead; rings of 2, 4 and 7; one lens on a servo; the views of one fisheye."""
