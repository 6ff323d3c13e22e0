"""Settings of the laws that arrange a swarm: lattices, triangles, chains."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from swarmvision.config.controller.base import Alone, Gain, Range, Share, Speed
from swarmvision.config.model import Settings

Rate = Annotated[float, Field(ge=0, le=100)]


class SpearsConfig(Settings):
    """Hexagonal and square lattices by artificial physics."""

    law: Literal["spears"] = "spears"

    lattice: Literal["hexagonal", "square"] = "hexagonal"
    """In a square lattice, robots of the other team stand at the spacing and the own at its diagonal."""

    own_kind: Annotated[int, Field(ge=0, le=100)] = 0
    """The own team, whose robots are of like kind; a neighbour whose team is not told counts as unlike."""

    spacing: Range = 0.25
    """Range at which the force turns from push to pull, the paper's R (m)."""

    reach: Annotated[float, Field(gt=1, le=10)] = 1.5
    """Neighbours farther than this many of their spacings are not felt."""

    power: Annotated[float, Field(ge=0, le=10)] = 2.0
    """The force falls with this power of the range, the paper's p."""

    strength: Annotated[float, Field(gt=0, le=100)] = 1.0
    """G as a multiple of the paper's G_t, above which robots collapse into clusters."""

    speed: Speed = 0.08
    """Speed that the greatest force of one neighbour gives (m/s), and the top speed."""

    turn_gain: Gain = 1.5
    """Turn rate that such a force from the side gives (rad/s)."""

    band: Range = 0.02
    """Width round the spacing in which the force passes from push to pull (m)."""

    alone: Alone = "stop"
    """With nobody within reach."""


class HanadaConfig(Settings):
    """Equilateral triangles with two neighbours, on the way to a goal and among obstacles."""

    law: Literal["hanada"] = "hanada"

    spacing: Range = 0.30
    """Side of the triangles, the paper's d_u (m)."""

    reach: Range = 1.0
    """Neighbours farther away are no partners (m)."""

    speed: Speed = 0.12
    """Top speed (m/s)."""

    gain: Gain = 0.8
    """Speed for each metre that the robot is out of place (1/s)."""

    goal_speed: Annotated[float, Field(ge=0, le=5)] = 0.05
    """Share of the speed that leads to the goal (m/s), for robots that know it."""

    turn_gain: Gain = 15.0
    """Turn rate for each m/s that is wanted to the side (rad/m)."""

    obstacle_range: Range = 0.30
    """Things other than robots within this push (m)."""

    obstacle_speed: Annotated[float, Field(ge=0, le=5)] = 0.15
    """Speed of that push from a touch (m/s)."""

    alone: Alone = "keep"
    """With nobody within reach and no goal known."""


class ChainConfig(Settings):
    """A chain of standing robots from a nest, the goal, outwards."""

    law: Literal["chain"] = "chain"

    spacing: Range = 0.28
    """Between members (m)."""

    speed: Speed = 0.10
    """While exploring (m/s)."""

    turn_gain: Gain = 2.0
    """Proportional gain of the turn rate on the angle to the wanted direction (1/s)."""

    clearance: Range = 0.20
    """Robots ahead within this are gone round (m)."""

    join_rate: Rate = 1.0
    """Chance to become a member at the end of the chain, per second."""

    leave_rate: Rate = 0.0
    """Chance of the last member to leave the chain, per second."""

    tolerance: Share = 0.3
    """Of the spacing: how far off it a link may be."""

    @model_validator(mode="after")
    def _members_do_not_crowd(self) -> ChainConfig:
        if not self.clearance < self.spacing:
            raise ValueError(f"clearance < spacing (m) must hold, got {self.clearance}, {self.spacing}")
        return self


FormationLaw = ChainConfig | HanadaConfig | SpearsConfig
