"""Settings of the laws that bring a swarm together or apart."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from swarmvision.config.controller.base import Alone, Gain, Range, Speed
from swarmvision.config.model import Settings


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


GatheringLaw = CohesionConfig | GauciConfig
