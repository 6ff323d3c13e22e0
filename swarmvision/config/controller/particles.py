"""Settings of the models of self-propelled particles."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from swarmvision.config.controller.base import Alone, Gain, Range, Seconds, Speed
from swarmvision.config.model import Settings

Width = Annotated[float, Field(ge=0, le=100)]


class VicsekConfig(Settings):
    """Take the mean heading of the neighbours, and some noise."""

    law: Literal["vicsek"] = "vicsek"

    speed: Speed = 0.10
    """Constant speed (m/s)."""

    reach: Range = 0.60
    """Neighbours farther away are ignored (m)."""

    noise: Annotated[float, Field(ge=0, le=6.3)] = 0.2
    """Width of the even distribution of the error of the heading, the paper's eta (rad)."""

    turn_gain: Gain = 5.0
    """Turn rate on the angle to the wanted heading (1/s); the paper turns at once."""

    turn_limit: Gain = 3.0
    """Largest turn rate (rad/s)."""

    alone: Alone = "keep"
    """With nobody in sight."""


class CouzinConfig(Settings):
    """Three zones: flee who is near, align with who is farther, approach who is farthest."""

    law: Literal["couzin"] = "couzin"

    speed: Speed = 0.10
    """Constant speed (m/s)."""

    repulsion: Range = 0.15
    """Radius of the zone of repulsion (m)."""

    orientation: Width = 0.20
    """Width of the zone of orientation beyond it, the paper's delta r_o (m)."""

    attraction: Width = 0.60
    """Width of the zone of attraction beyond that, the paper's delta r_a (m)."""

    fov_deg: Annotated[float, Field(gt=0, le=360)] = 360.0
    """Field in which others are perceived, the paper's alpha (deg); repulsion has no blind spot."""

    turn_limit_deg: Annotated[float, Field(gt=0, le=1000)] = 100.0
    """Largest turn rate, the paper's theta (deg/s)."""

    turn_gain: Gain = 5.0
    """Turn rate on the angle to the wanted direction (1/s), below that limit."""

    noise: Annotated[float, Field(ge=0, le=3)] = 0.05
    """Standard deviation of the error of the wanted direction, the paper's sigma (rad)."""

    alone: Alone = "keep"
    """With nobody in sight."""


class GregoireConfig(Settings):
    """Mean heading, a force that keeps a distance, and noise: droplets that move and stay together."""

    law: Literal["gregoire"] = "gregoire"

    speed: Speed = 0.10
    """Cruise speed, the paper's v0 (m/s)."""

    turn_gain: Gain = 2.0
    """Proportional gain of the turn rate on the angle to the wanted direction (1/s)."""

    alignment_gain: Gain = 1.0
    """Weight of the headings, the paper's alpha."""

    force_gain: Gain = 2.0
    """Weight of the force, the paper's beta."""

    noise: Gain = 0.1
    """Weight of the noise, the paper's eta."""

    core: Range = 0.12
    """Radius of the hard core (m), the paper's r_c."""

    desired_range: Range = 0.25
    """Range without force (m), the paper's r_e."""

    attraction: Range = 0.40
    """Range from which on the pull is full (m), the paper's r_a."""

    reach: Range = 0.60
    """Neighbours farther away are ignored (m), the paper's r_0."""

    alone: Alone = "keep"
    """With nobody in sight."""

    @model_validator(mode="after")
    def _ranges_ascend(self) -> GregoireConfig:
        ranges = (self.core, self.desired_range, self.attraction, self.reach)
        if not ranges[0] < ranges[1] < ranges[2] < ranges[3]:
            raise ValueError(f"core < desired_range < attraction < reach (m) must hold, got {ranges}")
        return self


class RandomWalkConfig(Settings):
    """Go straight, and turn by chance now and then; neighbours do not matter."""

    law: Literal["random-walk"] = "random-walk"

    speed: Speed = 0.10
    """m/s"""

    persistence: Annotated[Seconds, Field(gt=0)] = 3.0
    """A turn rate is kept for this long (s)."""

    turn_spread: Gain = 0.5
    """Standard deviation of the turn rates (rad/s)."""


ParticleLaw = CouzinConfig | GregoireConfig | RandomWalkConfig | VicsekConfig

_SCHOOL = CouzinConfig(speed=0.20, repulsion=0.13, attraction=2.0, turn_limit_deg=20.0, fov_deg=300.0)

COUZIN: dict[str, CouzinConfig] = {
    "swarm": _SCHOOL.replace(orientation=0.0, fov_deg=360.0),
    "torus": _SCHOOL.replace(orientation=0.35),
    "parallel": _SCHOOL.replace(orientation=1.20, turn_limit_deg=30.0),
}
"""Couzin's regimes at a Zumo's size; the values are ours. They need eyes that see 3 m."""
