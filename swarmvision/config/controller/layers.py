"""Settings of what lies under a law: it corrects the law's commands and knows nothing of its aim."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from swarmvision.config.controller.base import Gain, Range, Seconds
from swarmvision.config.model import Settings


class AvoidanceConfig(Settings):
    """Slow down before what is ahead, and turn away from it."""

    layer: Literal["avoidance"] = "avoidance"

    stop_range: Range = 0.10
    """Range of a thing ahead, from the robot's centre, at which it stands (m)."""

    slow_range: Range = 0.20
    """Range of a thing ahead at which it begins to slow down (m); more than stop_range."""

    turn_gain: Gain = 2.0
    """Turn rate away from a thing at stop_range (rad/s)."""

    @model_validator(mode="after")
    def _ranges_ascend(self) -> AvoidanceConfig:
        if not self.stop_range < self.slow_range:
            raise ValueError(
                f"stop_range < slow_range (m) must hold, got {self.stop_range}, {self.slow_range}"
            )
        return self


class ConnectivityConfig(Settings):
    """Never go where a neighbour in sight would be lost."""

    layer: Literal["connectivity"] = "connectivity"

    reach: Range = 0.80
    """Two robots farther apart than this lose sight of each other (m)."""

    horizon: Annotated[Seconds, Field(gt=0)] = 0.5
    """The way of this time must stay inside (s); at least the control period."""

    turn_gain: Gain = 1.5
    """Turn rate towards who is nearly lost (rad/s)."""


LayerConfig = Annotated[AvoidanceConfig | ConnectivityConfig, Field(discriminator="layer")]
