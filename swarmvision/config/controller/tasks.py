"""Settings of the laws that do something to the world: herding, transport."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from swarmvision.config.controller.base import Alone, Gain, Range, Share, Speed
from swarmvision.config.model import Settings

Team = Annotated[int, Field(ge=0, le=100)]


class DogConfig(Settings):
    """A sheepdog: gathers the flock, then drives it to the goal."""

    law: Literal["dog"] = "dog"

    own_kind: Team = 0
    """The dogs' team; all others, and those whose team is not told, are sheep."""

    sheep_range: Range = 0.22
    """Range within which sheep keep off each other, the paper's r_a (m)."""

    speed: Speed = 0.20
    """Top speed (m/s)."""

    turn_gain: Gain = 3.0
    """Proportional gain of the turn rate on the angle to the wanted direction (1/s)."""

    slow_range: Range = 0.45
    """Sheep ahead within this slow it down (m)."""

    slow: Share = 0.3
    """Of its speed, then."""

    noise: Share = 0.1
    """Of its direction, the paper's e."""

    obstacle_range: Range = 0.30
    """Walls and things within this turn it aside while it searches (m)."""

    alone: Alone | Literal["search"] = "search"
    """With no sheep in sight; ``search`` crosses the arena from wall to wall."""


class SheepConfig(Settings):
    """A sheep: grazes, flees a dog, keeps with the others."""

    law: Literal["sheep"] = "sheep"

    own_kind: Team = 1
    """The sheep's team; robots of other teams are dogs."""

    dog_range: Range = 1.0
    """A dog within this is fled, the paper's r_s (m)."""

    sheep_range: Range = 0.22
    """Sheep within this push each other off, the paper's r_a (m)."""

    speed: Speed = 0.12
    """While it flees (m/s)."""

    turn_gain: Gain = 3.0
    """Proportional gain of the turn rate on the angle to the wanted direction (1/s)."""

    inertia: Gain = 0.5
    """Weight of the direction it has, the paper's h."""

    attraction: Gain = 1.05
    """Weight of the middle of the flock, the paper's c."""

    repulsion: Gain = 2.0
    """Weight of sheep that are too near, the paper's rho_a."""

    fear: Gain = 1.0
    """Weight of the dog, the paper's rho_s."""

    noise: Gain = 0.3
    """Weight of a random direction, the paper's e."""

    graze: Share = 0.05
    """Share of the control steps in which a sheep that is left in peace takes a step anywhere."""

    obstacle_range: Range = 0.20
    """Walls and things within this push it off (m)."""


class TransportConfig(Settings):
    """Pushes a load where it hides the goal."""

    law: Literal["transport"] = "transport"

    speed: Speed = 0.12
    """On the way to the load and round it (m/s)."""

    push_speed: Speed = 0.10
    """Of the tracks while pushing (m/s)."""

    turn_gain: Gain = 2.5
    """Proportional gain of the turn rate on the angle to the wanted direction (1/s)."""

    orbit: Range = 0.42
    """Range from the load's middle at which it goes round it (m)."""

    clearance: Range = 0.20
    """Robots ahead within this are gone round (m)."""

    alone: Alone = "scan"
    """With no load in sight."""


TaskLaw = DogConfig | SheepConfig | TransportConfig
