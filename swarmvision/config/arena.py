"""The arena: a walled rectangle with things in it. Its origin is its centre, x along its width."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator

from swarmvision.colour import rgb
from swarmvision.config.model import Settings

Length = Annotated[float, Field(gt=0, le=100)]
Place = Annotated[float, Field(ge=-100, le=100)]


class _Thing(Settings):
    x: Place
    """Centre (m)."""

    y: Place
    """Centre (m)."""

    yaw_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """deg, counter-clockwise."""

    height: Length = 0.10
    """m"""

    colour: str = "#8a8f94"
    """A name or '#rrggbb'."""

    mass: Annotated[float, Field(gt=0, le=1000)] | None = None
    """kg; a thing without a mass is fixed."""

    @field_validator("colour")
    @classmethod
    def _known_colour(cls, colour: str) -> str:
        rgb(colour)
        return colour


class BoxConfig(_Thing):
    """A box, fixed or pushable."""

    kind: Literal["box"] = "box"
    length: Length = 0.2
    """Along its own x (m)."""
    width: Length = 0.2
    """Across (m)."""


class DiscConfig(_Thing):
    """An upright cylinder, fixed or pushable."""

    kind: Literal["disc"] = "disc"
    radius: Length = 0.1
    """m"""


ObjectConfig = Annotated[BoxConfig | DiscConfig, Field(discriminator="kind")]


class CueConfig(Settings):
    """A spot on the ground that a robot's ground sensor reads: light, warmth."""

    x: Place = 0.0
    """Centre (m)."""

    y: Place = 0.0
    """Centre (m)."""

    radius: Length = 0.5
    """Distance at which it has fallen to 0 (m); it falls evenly from the centre."""

    strength: Annotated[float, Field(ge=0, le=1)] = 1.0
    """Reading at the centre."""


class ArenaConfig(Settings):
    """Walls, floor and objects."""

    width: Length = 16.0
    """Inner size along x (m)."""

    depth: Length = 16.0
    """Inner size along y (m)."""

    wall_height: Annotated[float, Field(ge=0, le=10)] = 0.26
    """m"""

    wall_friction: Annotated[float, Field(ge=0, le=5)] = 0.3
    """Coulomb friction of walls and objects."""

    floor_friction: Annotated[float, Field(ge=0, le=5)] = 0.5
    """Coulomb friction between a pushable object and the floor."""

    objects: Annotated[tuple[ObjectConfig, ...], Field(max_length=1000)] = ()
    """Boxes and discs."""

    cues: Annotated[tuple[CueConfig, ...], Field(max_length=100)] = ()
    """Spots on the ground; where they overlap, the strongest counts."""


ARENAS: dict[str, ArenaConfig] = {
    "open": ArenaConfig(),
    # The paper's: 114 x 63 cm, walls of 26 cm.
    "paper": ArenaConfig(width=1.14, depth=0.63, wall_height=0.26),
}
"""A court for a swarm, and the paper's box."""
