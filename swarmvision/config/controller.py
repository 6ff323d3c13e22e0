"""What robots do with what they see: one settings model for each law, told apart by ``law``."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from swarmvision.config.model import Settings

Alone = Literal["keep", "stop", "scan"]
"""With nobody in sight: go straight on, stand still, or turn on the spot."""

Gain = Annotated[float, Field(ge=0, le=1000)]
Speed = Annotated[float, Field(gt=0, le=5)]
Range = Annotated[float, Field(gt=0, le=100)]


class KobotConfig(Settings):
    """Flocking by alignment and proximal control."""

    law: Literal["kobot"] = "kobot"

    speed: Speed = 0.10
    """Cruise speed, the paper's u_max (m/s)."""

    turn_gain: Gain = 2.0
    """Proportional gain of the turn rate on the angle to the wanted direction, the paper's K_p (1/s)."""

    proximal_gain: Gain = 1.5
    """Weight of proximal control against alignment, the paper's beta."""

    desired_range: Range = 0.25
    """Range that neighbours keep (m)."""

    contact_range: Range = 0.12
    """Range at which the push is fully felt (m); less than desired_range."""

    reach: Range = 0.60
    """Neighbours farther away are ignored (m)."""

    alone: Alone = "keep"
    """With nobody in sight."""

    @model_validator(mode="after")
    def _ranges_ascend(self) -> KobotConfig:
        if not self.contact_range < self.desired_range < self.reach:
            raise ValueError(
                "contact_range < desired_range < reach (m) must hold, "
                f"got {self.contact_range}, {self.desired_range}, {self.reach}"
            )
        return self


class GauciConfig(Settings):
    """Aggregation by one bit: is a robot straight ahead?"""

    law: Literal["gauci"] = "gauci"

    speed: Speed = 0.10
    """Wheel speed that the law's 1 stands for (m/s)."""

    beam_deg: Annotated[float, Field(gt=0, le=180)] = 5.0
    """Half width of the line of sight in which a robot counts as ahead (deg)."""

    track: Range = 0.085
    """Distance between the tracks (m), which turns wheel speeds into a turn rate."""


class CohesionConfig(Settings):
    """Aggregation by going towards the neighbours in sight."""

    law: Literal["cohesion"] = "cohesion"

    speed: Speed = 0.12
    """Top speed (m/s)."""

    turn_gain: Gain = 2.0
    """Proportional gain of the turn rate on the angle to the wanted direction (1/s)."""

    desired_range: Range = 0.17
    """Range at which neighbours neither pull nor push (m)."""

    softness: Range = 0.06
    """Deviation (m) from the desired range at which the force nears its full size."""

    rest: Annotated[float, Field(gt=0, le=1)] = 0.4
    """Force, of at most 1, below which a robot slows down."""

    alone: Alone = "scan"
    """With nobody in sight."""


ControllerConfig = Annotated[CohesionConfig | GauciConfig | KobotConfig, Field(discriminator="law")]
