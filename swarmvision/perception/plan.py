"""Everything about one kind of marker, and one lens, that reading by edges needs: worked out once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from swarmvision.camera import Lens
from swarmvision.colour import decode
from swarmvision.geometry import FloatArray
from swarmvision.marker import Band, Marker, pattern_edges
from swarmvision.perception.look import Look, LookScratch, Proportions
from swarmvision.perception.segment import DECODE, Balance, Hues, chroma_of, white_scratch

PROBES = 15  # heights of the middle zone that are looked at
HEIGHTS = 48  # samples of the patterned band from its bottom to its top
AZIMUTHS = 288  # of the pattern's table for the coarse look at headings
MOST_COLUMNS = 32  # of one marker that are measured
UPPER, LOWER, TOP_RING, BOTTOM_RING, STRIPE, GROUND = range(6)  # directions of colour
OFF_CHROMA, OFF_CHROMA_SHARE = (
    0.16,
    0.35,
)  # by which a probe's chroma may be off, and by which share of itself
INNER_TOP, INNER_BOTTOM, BAND_LOW, BAND_HIGH, HEIGHT, RADIUS, BASE = range(7)  # of the plan's heights


@dataclass(frozen=True, eq=False, slots=True)
class Plan:
    """Everything about one kind of marker that reading needs."""

    hues: Hues
    proportions: Proportions | None
    directions: FloatArray
    """Weights of the channels for each direction of colour, ``(6, 3)``."""
    heights: FloatArray
    """Of the inner edges of top and bottom band, of bottom and top of the patterned band, of marker,
    all above the marker's bottom edge; the radius; height of the marker's base above the ground (m)."""
    knots: FloatArray
    """Of the pattern; empty where the marker tells no heading."""
    expected: FloatArray
    """Chroma that each probe of the middle zone may have, and the square of how far off it may be; nan where
    unused, ``(PROBES, 2, 4)``."""
    pale: bool
    """Whether the largest middle band is white or grey."""

    @classmethod
    def of(cls, marker: Marker) -> Plan:
        """Return the plan for a marker."""
        hues = Hues.of(marker)
        directions = np.zeros((6, 3))
        directions[UPPER] = _inner_direction(marker.bands[0], marker.bands[1])
        directions[LOWER] = -_inner_direction(marker.bands[-1], marker.bands[-2])
        for place, band in ((TOP_RING, marker.bands[0]), (BOTTOM_RING, marker.bands[-1])):
            chroma = chroma_of(band.colour)
            directions[place] = chroma / max(float(np.linalg.norm(chroma)), 1e-9)
        knots = np.empty((0, 3))
        low = high = 0.0
        carrier = marker.patterned
        if carrier is not None and carrier.pattern is not None and not carrier.pattern.symmetric:
            knots, low, high = carrier.pattern.knots, carrier.bottom, carrier.top
            ground, ink = decode(carrier.colour), decode(carrier.pattern.colour)
            # Blind to brightness: what the band's own colour gives is nothing.
            weights = _towards(carrier.colour, carrier.pattern.colour)
            weights = weights - ground * (weights @ ground) / (ground @ ground)
            directions[STRIPE] = weights / (ink @ weights)
            directions[GROUND] = ground / (ground @ ground)
        heights = np.array(
            [
                marker.bands[0].bottom,
                marker.bands[-1].top,
                low,
                high,
                marker.height,
                marker.radius,
                marker.base,
            ]
        )
        middle = max(marker.bands[1:-1] or marker.bands, key=lambda band: band.top - band.bottom)
        pale = bool(np.linalg.norm(chroma_of(middle.colour)) < 0.1)
        return cls(
            hues, Proportions.of(marker, hues), directions, heights, knots, _expected_chroma(marker), pale
        )


class Task(NamedTuple):
    """A plan and a lens as plain arrays and numbers, for kernels."""

    look: Look
    eye: FloatArray
    """Focal length, principal column and row (px), lens height (m)."""
    directions: FloatArray
    """As in :class:`Plan`, like the next four."""
    heights: FloatArray
    knots: FloatArray
    expected: FloatArray
    pale: bool
    stripe: FloatArray
    """Low and high edge of the pattern over the azimuth, in samples of the band, ``(AZIMUTHS, 2)``."""
    decode: FloatArray
    """Linear light of every code, ``(256,)``."""

    @classmethod
    def of(cls, plan: Plan, lens: Lens) -> Task | None:
        """Return the task; None where there is nothing to look for, or no picture to look at."""
        if plan.proportions is None or min(lens.height_px, lens.width_px) < 4:
            return None
        return cls(
            Look.of(lens.width_px, lens.height_px, plan.hues, plan.proportions, lens),
            np.array([lens.focal_px, lens.centre_px[0], lens.centre_px[1], lens.height]),
            plan.directions,
            plan.heights,
            plan.knots,
            plan.expected,
            plan.pale,
            _stripe_table(plan),
            DECODE,
        )


class Scratch(NamedTuple):
    """Room to read pictures of one size in; one per thread. The reading itself takes no memory."""

    look: LookScratch
    samples: np.ndarray[tuple[int, ...], np.dtype[np.uint8]]
    """See :func:`swarmvision.perception.segment.sample_white`, like the counts."""
    counts: np.ndarray[tuple[int, ...], np.dtype[np.int64]]
    white: FloatArray
    light: FloatArray
    """As in :class:`swarmvision.perception.segment.Balance`, like white and address."""
    address: np.ndarray[tuple[int, ...], np.dtype[np.uint16]]
    waiting: FloatArray
    """Candidates that are yet to be measured, ``(n, 7)``."""
    lines: FloatArray
    """Of the columns that are measured, ``(LINES, width)``."""
    signals: FloatArray
    """The pattern unrolled, ``(MOST_COLUMNS, HEIGHTS)``."""
    strip: FloatArray
    """The pattern in every row of one column, ``(height + 2,)``."""

    @classmethod
    def of(cls, width_px: int, height_px: int) -> Scratch:
        """Return room for pictures of a size."""
        samples, counts = white_scratch()
        return cls(
            LookScratch.of(width_px),
            samples,
            counts,
            np.empty(3),
            np.empty((3, 256)),
            np.empty((3, 256), np.uint16),
            np.empty((2 * MOST_WAITING, 7)),
            np.empty((LINES, 2 * PROBES * MOST_LOOKS)),
            np.empty((MOST_COLUMNS, HEIGHTS)),
            np.empty(height_px + 2),
        )

    def balance(self) -> Balance:
        """Return a copy of the balance of the picture that was read last."""
        return Balance(self.white.copy(), self.light.copy(), self.address.copy())


MOST_WAITING = 512
MOST_LOOKS = 12  # columns, about, in which the middle zone is looked at
# Lines of the scratch.
COLUMNS, UPPERS, LOWERS, RAYS, GAPS, FACING, SPARE_A, SPARE_B, SPARE_C, SPARE_D, SPARE_E = range(11)
LINES = 11


def _stripe_table(plan: Plan) -> FloatArray:
    table = np.zeros((AZIMUTHS, 2))
    if len(plan.knots) == 0:
        return table
    low, high = plan.heights[BAND_LOW], plan.heights[BAND_HIGH]
    for i in range(AZIMUTHS):
        edges = pattern_edges(plan.knots, 2.0 * np.pi * (i + 0.5) / AZIMUTHS)[:2]
        table[i] = np.clip((np.array(edges) - low) * HEIGHTS / (high - low), 0.0, HEIGHTS)
    return table


def _towards(start: tuple[int, int, int], end: tuple[int, int, int]) -> FloatArray:
    """Return the direction of colour along which a step from one print to another is largest."""
    difference = decode(end) - decode(start)
    return difference / max(float(np.linalg.norm(difference)), 1e-9)


def _inner_direction(ring: Band, middle: Band) -> FloatArray:
    """Return the direction of colour from a ring to what lies inside, blind to the pattern on that."""
    direction = _towards(ring.colour, middle.colour)
    if middle.pattern is not None:
        stripe = _towards(middle.colour, middle.pattern.colour)
        blind = direction - stripe * (stripe @ direction)
        if np.linalg.norm(blind) > 0.3:  # else the stripe has the ring's own colour
            return blind / float(np.linalg.norm(blind))
    return direction


def _expected_chroma(marker: Marker) -> FloatArray:
    expected = np.full((PROBES, 2, 4), np.nan)
    middle = marker.bands[0].bottom - marker.bands[-1].top
    for i, share in enumerate(np.linspace(0.08, 0.92, PROBES)):
        height = marker.bands[0].bottom - share * middle
        for band in marker.bands:
            if band.bottom < height < band.top:
                expected[i, 0, :3] = chroma_of(band.colour)
                if band.pattern is not None:
                    expected[i, 1, :3] = chroma_of(band.pattern.colour)
    size = np.sqrt((expected[..., :3] ** 2).sum(axis=-1))
    expected[..., 3] = (OFF_CHROMA + OFF_CHROMA_SHARE * size) ** 2
    return expected
