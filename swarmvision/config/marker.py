"""The marker file: bands round a cylinder, one of which may carry a pattern."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from swarmvision.colour import rgb
from swarmvision.config.model import Settings

PatternKind = Literal["helix", "step", "wedge", "skew", "chevron", "pyramid", "spindle", "block"]


def _known_colour(colour: str) -> str:
    rgb(colour)  # raises, with the known names, for one that nobody knows
    return colour


class PatternConfig(Settings):
    """The coloured stripe that tells heading."""

    kind: PatternKind = "helix"
    """helix, step, wedge and skew tell heading over the whole turn; chevron, pyramid, spindle and block are
    mirror-symmetric and tell it up to its sign."""

    colour: str = "yellow"
    """A name or '#rrggbb'."""

    thickness: Annotated[float, Field(gt=0, le=1)] = 0.0072
    """Height of the stripe (m)."""

    _colour = field_validator("colour")(_known_colour)


class BandConfig(Settings):
    """One ring of the marker."""

    colour: str
    """A name or '#rrggbb'."""

    height: Annotated[float, Field(gt=0, le=1)]
    """m"""

    pattern: PatternConfig | None = None
    """The stripe in this band, if any."""

    _colour = field_validator("colour")(_known_colour)

    @model_validator(mode="after")
    def _pattern_fits(self) -> BandConfig:
        if self.pattern is not None and self.pattern.thickness > self.height:
            raise ValueError(
                f"pattern.thickness (m) must not exceed the band's height {self.height}, "
                f"got {self.pattern.thickness}"
            )
        return self


PAPER_BANDS = (
    BandConfig(colour="red", height=0.010),
    BandConfig(colour="white", height=0.040, pattern=PatternConfig()),
    BandConfig(colour="blue", height=0.010),
)
"""The paper's outer pattern with its yellow helix (see :mod:`swarmvision.marker`)."""


class MarkerConfig(Settings):
    """A printed cylinder on a robot's vertical centre line."""

    name: str = "helix-40x60"
    """What it is called in messages."""

    radius: Annotated[float, Field(gt=0, le=1)] = 0.020
    """m"""

    base: Annotated[float, Field(ge=0, le=2)] = 0.055
    """Height of the bottom edge above the ground (m)."""

    bands: Annotated[tuple[BandConfig, ...], Field(min_length=2, max_length=16)] = PAPER_BANDS
    """From the top down."""

    @model_validator(mode="after")
    def _readable(self) -> MarkerConfig:
        for upper, lower in zip(self.bands, self.bands[1:], strict=False):
            if rgb(upper.colour) == rgb(lower.colour):
                raise ValueError(f"neighbouring bands must differ in colour, got {upper.colour} twice")
        if sum(band.pattern is not None for band in self.bands) > 1:
            raise ValueError("at most one band may carry a pattern")
        return self


PRESETS: dict[str, MarkerConfig] = {
    "helix-40x60": MarkerConfig(),
    "pole-52x150": MarkerConfig(
        name="pole-52x150",
        radius=0.026,
        base=0.05,
        bands=(
            BandConfig(colour="red", height=0.05),
            BandConfig(colour="blue", height=0.05),
            BandConfig(colour="yellow", height=0.05),
        ),
    ),
}
"""The paper's marker, and a plain pole that tells range and bearing but no heading."""
