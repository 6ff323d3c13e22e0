"""Settings of the laws that bring a swarm together or apart."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from swarmvision.config.controller.base import Alone, Gain, Range, Seconds, Speed
from swarmvision.config.model import Settings

WheelSpeed = Annotated[float, Field(ge=-1, le=1)]
Rate = Annotated[float, Field(ge=0, le=100)]


class GauciConfig(Settings):
    """Four wheel speeds and one bit: is a robot straight ahead?"""

    law: Literal["gauci"] = "gauci"

    behaviour: Literal["aggregation", "dispersal", "milling", "pursuit"] = "aggregation"
    """Which four wheel speeds, and how wide a line of sight."""

    wheels: tuple[WheelSpeed, WheelSpeed, WheelSpeed, WheelSpeed] | None = None
    """Instead of the behaviour's: left and right with nobody ahead, left and right with a robot ahead."""

    speed: Speed = 0.10
    """Wheel speed that the law's 1 stands for (m/s)."""

    beam_deg: Annotated[float, Field(ge=0, le=180)] | None = None
    """Half width of the line of sight, which a robot ahead meets with its body (deg); the behaviour's own
    where not given."""

    body_radius: Annotated[float, Field(ge=0, le=1)] = 0.05
    """Of the robots (m)."""

    track: Range = 0.085
    """Distance between the tracks (m), which turns wheel speeds into a turn rate."""


class CohesionConfig(Settings):
    """Aggregation by going towards the neighbours in sight, and standing clear of the nearest."""

    law: Literal["cohesion"] = "cohesion"

    speed: Speed = 0.12
    """Top speed (m/s)."""

    turn_gain: Gain = 2.0
    """Turn rate for a full pull from the side (rad/s)."""

    desired_range: Range = 0.165
    """Range of a robot straight ahead at which its push outweighs the pull of all others (m)."""

    slow_range: Range = 0.195
    """Range at which neighbours begin to push (m); more than desired_range."""

    forget: Annotated[float, Field(gt=0, le=60)] = 0.5
    """Time (s) in which a neighbour that is not seen again loses all but 1/e of its weight."""

    alone: Alone = "scan"
    """With nobody in sight."""

    @model_validator(mode="after")
    def _ranges_ascend(self) -> CohesionConfig:
        if not self.desired_range < self.slow_range:
            raise ValueError(
                f"desired_range < slow_range (m) must hold, got {self.desired_range}, {self.slow_range}"
            )
        return self


class BeeclustConfig(Settings):
    """Aggregation on a spot of the ground: who meets a robot waits, the longer the better the spot."""

    law: Literal["beeclust"] = "beeclust"

    speed: Speed = 0.10
    """While driving (m/s)."""

    turn_rate: Gain = 2.0
    """While turning (rad/s)."""

    robot_range: Range = 0.18
    """A robot ahead within this is met (m)."""

    obstacle_range: Range = 0.14
    """Anything else ahead within this, from the robot's centre, is turned away from (m)."""

    max_wait: Seconds = 120.0
    """Wait on the best of spots (s)."""

    half_cue: Annotated[float, Field(gt=0, le=1)] = 0.46
    """Reading of the ground sensor, of at most 1, at which half of that is waited."""


class SoysalConfig(Settings):
    """Aggregation by three states: approach, wait, repel."""

    law: Literal["soysal"] = "soysal"

    speed: Speed = 0.12
    """Top speed (m/s)."""

    turn_gain: Gain = 2.0
    """Proportional gain of the turn rate on the angle to the wanted direction (1/s)."""

    robot_range: Range = 0.19
    """A robot within this is arrived at (m)."""

    obstacle_range: Range = 0.16
    """Anything else within this, from the robot's centre, is turned away from (m)."""

    leave_rate: Rate = 0.01
    """Chance to leave the robots that it waits with, per second."""

    return_rate: Rate = 0.2
    """Chance to approach again while it leaves, per second."""

    alone: Alone = "scan"
    """With nobody in sight."""


GatheringLaw = BeeclustConfig | CohesionConfig | GauciConfig | SoysalConfig
