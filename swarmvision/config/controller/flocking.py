"""Settings of the laws that move a swarm together."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from swarmvision.config.controller.base import Alone, Gain, Range, Seconds, Speed
from swarmvision.config.model import Settings


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

    forget: Seconds = 0.0
    """Time in which the weight of a neighbour that is not measured anew falls to 1/e (s); 0 for never."""

    obstacle_range: Range = 0.25
    """Range from which what the proximity ring meets, if no robot, pushes (m); more than contact_range."""

    obstacle_gain: Gain = 2.0
    """Weight of that push against alignment."""

    alone: Alone = "keep"
    """With nobody in sight."""

    @model_validator(mode="after")
    def _ranges_ascend(self) -> KobotConfig:
        if not self.contact_range < self.desired_range < self.reach:
            raise ValueError(
                "contact_range < desired_range < reach (m) must hold, "
                f"got {self.contact_range}, {self.desired_range}, {self.reach}"
            )
        if not self.contact_range < self.obstacle_range:
            raise ValueError(
                "contact_range < obstacle_range (m) must hold, "
                f"got {self.contact_range}, {self.obstacle_range}"
            )
        return self


FlockingLaw = KobotConfig
