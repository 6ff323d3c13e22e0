"""The marker: a stack of coloured bands round a cylinder, one of which may carry a pattern.

Azimuth ``phi`` (rad) runs counter-clockwise seen from above and is 0 at the robot's nose; height
``z`` (m) is measured from the cylinder's bottom edge. A pattern is one coloured span
``low(phi) < z < high(phi)`` per azimuth, given by knots and linear between them, so every reader
and every renderer needs one formula only, :meth:`Pattern.span`.

Source of the default: H. Majidi Balanji, E. Yilmaz, O. Cakmak, A. E. Turgut, "Design of a
Vision-Based Range, Bearing and Heading System for Robot Swarms" (METU). The paper prints no
drawing; the measures follow from its constants (eq. 5: rings 5.03 cm apart; eq. 7: a helix band
7.2 mm tall whose centre climbs 32.8 mm per turn).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from swarmvision.colour import rgb
from swarmvision.compiled import leaf
from swarmvision.errors import ConfigError, unknown_name
from swarmvision.geometry import FloatArray

if TYPE_CHECKING:
    from swarmvision.config.marker import MarkerConfig

TURN = 2.0 * np.pi

SHAPES: dict[str, tuple[tuple[float, float, float], ...]] = {
    # kind: knots of (turn, bottom lift, top lift), each in 0..1. The span's bottom edge is
    # bottom lift * (band height - thickness); its top edge is top lift * (same) + thickness,
    # so that equal lifts give a stripe of constant thickness.
    # Asymmetric: a heading over the whole turn.
    "helix": ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),
    "step": tuple(
        (turn, level / 3, level / 3)
        for level in range(4)
        for turn in (level / 4, (level + 1) / 4)
    ),
    "wedge": ((0.0, 0.0, 0.0), (1.0, 0.0, 1.0)),
    "skew": ((0.0, 0.0, 0.0), (0.75, 1.0, 1.0), (1.0, 0.0, 0.0)),
    # Mirror-symmetric about the nose: a heading over half a turn.
    "chevron": ((0.0, 0.0, 0.0), (0.5, 1.0, 1.0), (1.0, 0.0, 0.0)),
    "pyramid": tuple(
        (turn, lift, lift)
        for start, end, lift in (
            (0.0, 0.125, 0.0), (0.125, 0.375, 0.5), (0.375, 0.625, 1.0),
            (0.625, 0.875, 0.5), (0.875, 1.0, 0.0),
        )
        for turn in (start, end)
    ),
    "spindle": ((0.0, 0.0, 0.0), (0.5, 0.0, 1.0), (1.0, 0.0, 0.0)),
    "block": (
        (0.0, 0.0, 0.0), (0.25, 0.0, 0.0), (0.25, 1.0, 1.0),
        (0.75, 1.0, 1.0), (0.75, 0.0, 0.0), (1.0, 0.0, 0.0),
    ),
}  # fmt: skip

SYMMETRIC = frozenset({"chevron", "pyramid", "spindle", "block"})
"""The kinds that look alike to the left and to the right of the nose."""


@leaf
def pattern_edges(knots: FloatArray, azimuth: float) -> tuple[float, float, float, float]:
    """Return low and high edge (m) of a pattern at an azimuth (rad), and their slopes (m/rad)."""
    turn = 2.0 * math.pi
    phi = azimuth - turn * math.floor(azimuth / turn)
    i = len(knots) - 2
    while i > 0 and knots[i, 0] > phi:
        i -= 1
    width = max(knots[i + 1, 0] - knots[i, 0], 1e-12)
    low = (knots[i + 1, 1] - knots[i, 1]) / width
    high = (knots[i + 1, 2] - knots[i, 2]) / width
    ahead = phi - knots[i, 0]
    return knots[i, 1] + low * ahead, knots[i, 2] + high * ahead, low, high


@dataclass(frozen=True, eq=False, slots=True)
class Pattern:
    """One coloured span per azimuth."""

    kind: str
    colour: tuple[int, int, int]
    """sRGB, 8 bit."""
    knots: FloatArray
    """Azimuth (rad, 0..2 pi, ascending, a jump is a doubled azimuth), low and high edge (m above the
    marker's bottom edge), shape ``(n, 3)``."""

    @property
    def symmetric(self) -> bool:
        """Whether left and right of the nose look alike, so that heading is known up to its sign."""
        return self.kind in SYMMETRIC

    def span(self, azimuth: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the low and the high edge (m above the marker's bottom) at an azimuth (rad)."""
        phi = np.mod(np.asarray(azimuth, dtype=np.float64), TURN)
        # Behind a jump its second knot holds; the last knot closes the turn.
        left = np.clip(np.searchsorted(self.knots[:, 0], phi, side="right") - 1, 0, len(self.knots) - 2)
        start, end = self.knots[left], self.knots[left + 1]
        share = (phi - start[..., 0]) / np.maximum(end[..., 0] - start[..., 0], 1e-12)
        edges = start[..., 1:] + share[..., None] * (end[..., 1:] - start[..., 1:])
        return edges[..., 0], edges[..., 1]


@dataclass(frozen=True, eq=False, slots=True)
class Band:
    """A ring of one colour, ``bottom`` to ``top`` (m above the marker's bottom edge)."""

    bottom: float
    top: float
    colour: tuple[int, int, int]
    """sRGB, 8 bit."""
    pattern: Pattern | None


@dataclass(frozen=True, eq=False, slots=True)
class Marker:
    """What is printed on the cylinder, and where the cylinder stands."""

    name: str
    radius: float
    """m"""
    base: float
    """Height of the bottom edge above the ground (m)."""
    bands: tuple[Band, ...]
    """From the top down."""

    @property
    def height(self) -> float:
        """Height of the cylinder (m)."""
        return self.bands[0].top

    @property
    def patterned(self) -> Band | None:
        """The band that carries the pattern; ``None`` for a marker that tells no heading."""
        return next((band for band in self.bands if band.pattern is not None), None)

    def colour_at(self, azimuth: ArrayLike, height: ArrayLike) -> NDArray[np.uint8]:
        """Return the sRGB colour ``(..., 3)`` at an azimuth (rad) and height (m above the bottom edge)."""
        azimuth, height = np.broadcast_arrays(
            np.asarray(azimuth, dtype=np.float64), np.asarray(height, dtype=np.float64)
        )
        colours = np.zeros((*height.shape, 3), dtype=np.uint8)
        for band in self.bands:
            inside = (height >= band.bottom) & (height <= band.top)
            colours[inside] = band.colour
            if band.pattern is not None:
                low, high = band.pattern.span(azimuth)
                colours[inside & (height > low) & (height < high)] = band.pattern.colour
        return colours

    @classmethod
    def from_config(cls, config: MarkerConfig) -> Marker:
        """Return the marker that a marker file describes."""
        top = sum(band.height for band in config.bands)
        bands = []
        for band in config.bands:
            bottom = top - band.height
            pattern = None
            if band.pattern is not None:
                knots = _knots(band.pattern.kind, bottom, band.height, band.pattern.thickness)
                pattern = Pattern(band.pattern.kind, rgb(band.pattern.colour), knots)
            bands.append(Band(bottom, top, rgb(band.colour), pattern))
            top = bottom
        # Adding decimals leaves dust (0.06000000000000001); the ground line must be exact.
        bands[-1] = Band(0.0, bands[-1].top, bands[-1].colour, bands[-1].pattern)
        return cls(config.name, config.radius, config.base, tuple(bands))


def _knots(kind: str, bottom: float, height: float, thickness: float) -> FloatArray:
    if kind not in SHAPES:
        raise ConfigError(unknown_name("pattern", kind, SHAPES))
    turn, low, high = np.array(SHAPES[kind]).T
    travel = height - thickness
    return np.column_stack([turn * TURN, bottom + low * travel, bottom + high * travel + thickness])
