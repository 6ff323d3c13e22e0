"""Settings of the laws that move a swarm together."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

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


class InformedConfig(KobotConfig):
    """Kobot flocking in which those who know a goal steer towards it."""

    law: Literal["informed"] = "informed"  # type: ignore[assignment]  # another name is the point

    goal_gain: Gain = 0.5
    """Weight of the goal's direction against alignment, the paper's omega."""

    arrival_range: Range = 0.5
    """Within this of the goal its pull fades (m)."""


class FerranteConfig(Settings):
    """Flocking by attraction and repulsion alone: magnitude-dependent motion control."""

    law: Literal["ferrante"] = "ferrante"

    speed: Speed = 0.06
    """Forward speed with no force, the paper's U (m/s)."""

    top_speed: Speed = 0.20
    """m/s; at least speed."""

    speed_gain: Gain = 0.20
    """Forward speed for each unit of force, the paper's K1 (m/s)."""

    turn_gain: Gain = 1.2
    """Turn rate for each unit of force, the paper's K2 (rad/s)."""

    desired_range: Range = 0.25
    """Range that neighbours keep (m)."""

    reach_factor: Annotated[float, Field(gt=1, le=10)] = 1.8
    """Neighbours farther away than this many desired ranges are ignored."""

    exponent: Annotated[float, Field(gt=0, le=10)] = 1.5
    """Steepness of the Lennard-Jones force, the paper's alpha of its potential."""

    strength: Gain = 0.6
    """Depth of the potential, the paper's epsilon (m)."""

    force_limit: Gain = 8.0
    """Largest force of one neighbour, in either direction."""

    proximal_gain: Gain = 1.0
    """Weight of the mean force, the paper's beta."""

    alignment_gain: Gain = 0.0
    """Weight of the mean heading, the paper's alpha; 0 is flocking without alignment."""

    anticipation: Seconds = 0.6
    """The force is that between the places this far ahead (s); 0 is the paper's law."""

    smoothing: Seconds = 0.3
    """Time constant of the velocities that tell those places (s)."""

    goal_gain: Gain = 0.25
    """Weight of the goal's direction for those who know it, the paper's gamma."""

    forget: Seconds = 0.0
    """Time in which the weight of a neighbour that is not measured anew falls to 1/e (s); 0 for never."""

    obstacle_range: Range = 0.25
    """Range from which what the proximity ring meets, if no robot, pushes (m); more than contact_range."""

    contact_range: Range = 0.12
    """Range at which that push is fully felt (m)."""

    obstacle_gain: Gain = 2.0
    """Weight of that push."""

    alone: Alone = "keep"
    """With nobody in sight and no goal."""

    @model_validator(mode="after")
    def _limits_ascend(self) -> FerranteConfig:
        if not self.speed <= self.top_speed:
            raise ValueError(f"speed <= top_speed (m/s) must hold, got {self.speed}, {self.top_speed}")
        if not self.contact_range < self.obstacle_range:
            raise ValueError(
                "contact_range < obstacle_range (m) must hold, "
                f"got {self.contact_range}, {self.obstacle_range}"
            )
        return self


class ElasticConfig(Settings):
    """The active elastic sheet: neighbours are springs, a robot goes and turns by their pull."""

    law: Literal["elastic"] = "elastic"

    speed: Speed = 0.06
    """Forward speed with no force, the paper's v0 (m/s)."""

    top_speed: Speed = 0.12
    """m/s"""

    speed_gain: Gain = 0.10
    """Forward speed for each unit of force, the paper's alpha (m/s)."""

    turn_gain: Gain = 4.0
    """Turn rate for each unit of force, the paper's beta (rad/s)."""

    desired_range: Range = 0.25
    """Length of the springs at rest (m)."""

    reach: Range = 0.45
    """Neighbours farther away are not tied (m)."""

    stiffness: Gain = 1.0
    """Force of a spring that is drawn to twice its length, the paper's k."""

    alone: Alone = "keep"
    """With nobody in sight."""


FlockingLaw = ElasticConfig | FerranteConfig | InformedConfig | KobotConfig
