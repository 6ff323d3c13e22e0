"""The paper's experiments, repeated: its constants, its comparisons and its Table 1.

Source: H. Majidi Balanji, E. Yilmaz, O. Cakmak, A. E. Turgut, "Design of a Vision-Based Range, Bearing
and Heading System for Robot Swarms" (METU). Equation and figure numbers are the paper's.

How we read it where it does not say. Table 1's errors are the greatest of their range; that of range and
bearing is relative to the true value (bearing as eq. 3 has it, towards the surface's d_v), that of
heading relative to the full turn. Constants are fitted on one set of places and tested on another. The
paper has one k, but k1 and k2 by centimetres; a single k cannot reach the 0.414 % that it tells, because
the rings' pixels do not lie at the surface's range. So Table 1 uses k by range, as it does k1 and k2, and
what the single k does is told beside it.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision.config.imperfections import IMPERFECTIONS
from swarmvision.config.marker import BandConfig, MarkerConfig, PatternConfig
from swarmvision.errors import ConfigError
from swarmvision.experiments.apparatus import LENS, Apparatus
from swarmvision.geometry import FloatArray, wrap
from swarmvision.marker import SHAPES, SYMMETRIC
from swarmvision.perception import Reader
from swarmvision.perception.moments import centroids

CM = 0.01
RANGES = np.arange(9.9, 70.1, 1.5) * CM  # figure 10
HEADING_RANGES = np.arange(12, 38) * CM  # figure 11
STRAIGHT = np.radians(np.arange(100, 261, 20))  # psi at which the stripe is surely in one piece
ASIDE = np.linspace(5.1, 23.0, 10) * CM  # figure 12: d_h, and the d_v at which it is nearly at the border
ASIDE_RANGES = np.linspace(13.1, 48.5, 10) * CM
TEST_RANGES = np.arange(13.4, 50.0, 2.3) * CM  # Table 1: other places than the constants are fitted at
TEST_HEADING_RANGES = np.arange(12.6, 37.0, 4.1) * CM
TURN = np.radians(np.arange(2.5, 360, 5.0))
WRONG = 0.0325 * 2.0 * np.pi  # rad: Table 1's greatest error of heading; more is a heading that is not told
FILTERS = ("gaussian", "median", "bilateral")
FILTER_SIZES = (3, 7, 11, 15, 19, 23, 27, 31)
FILTER_RANGES = np.array([14.0, 22.0, 30.0, 38.0, 46.0]) * CM
PATTERN_RANGE = 0.25
TELLS_APART = 1.0  # px between two centroids that a camera tells apart
LIGHTS = (1.0, 0.5, 0.25, 0.1, 0.05)
PUBLISHED = {
    "k": 3193.7,
    "k1_12": 2.0951,
    "k1_37": 6.2095,
    "k2_12": 97.179,
    "k2_37": 94.421,
    "range_error_percent": 0.414,
    "bearing_error_percent": 4.044,
    "heading_error_percent": 3.25,
    "dead_zone_deg": 45.0,
}
"""What the paper prints, in its units: cm px, deg/px, deg."""


@dataclass(frozen=True, eq=False, slots=True)
class Constants:
    """Figures 10 to 12 and their fits, in the paper's units."""

    ranges: FloatArray
    """d_v (cm), shape ``(n,)``."""
    rows: FloatArray
    """P (px) there; nan where the filter has eaten a ring."""
    k: float
    """Of eq. 6, d_v = k / P, by least squares of the relative error (cm px)."""
    heading_ranges: FloatArray
    """d_v (cm), shape ``(m,)``."""
    k1: FloatArray
    """Of eq. 7 (deg/px)."""
    k2: FloatArray
    """deg"""
    aside: FloatArray
    """d_h (cm), shape ``(a,)``."""
    aside_k: FloatArray
    """Of eq. 8 (cm/px)."""
    aside_ranges: FloatArray
    """d_v (cm) of those."""

    def range_of(self, rows_px: float) -> float:
        """Return d_v (cm) by the curve of k over P."""
        good = np.isfinite(self.rows)
        rows, k = self.rows[good][::-1], (self.rows * self.ranges)[good][::-1]
        return float(np.interp(rows_px, rows, k)) / rows_px

    def bearing_of(self, columns_px: float, range_cm: float) -> float:
        """Return theta (rad) by eqs. 3 and 8."""
        slope, start = np.polyfit(self.aside_ranges, self.aside_k, 1)
        return float(np.arctan2((slope * range_cm + start) * columns_px, range_cm))

    def heading_of(self, rows_px: float, range_cm: float) -> float:
        """Return psi (deg) by eq. 7."""
        k1 = float(np.interp(range_cm, self.heading_ranges, self.k1))
        return k1 * rows_px - float(np.interp(range_cm, self.heading_ranges, self.k2))


@dataclass(frozen=True, slots=True)
class Table:
    """Table 1 of one method."""

    range_error_percent: float
    range_std: float
    bearing_error_percent: float
    bearing_std: float
    heading_error_percent: float
    """Greatest outside the dead zone, of the full turn."""
    heading_std: float
    dead_zone_deg: float
    """Width of the least arc round the seam outside which every heading is told as well as published."""
    single_k_error_percent: float | None = None
    """Greatest error of range with one k."""


@dataclass(frozen=True, eq=False, slots=True)
class Comparison:
    """One row per thing that is compared."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str | float | None, ...], ...]


def constants(apparatus: Apparatus) -> Constants:
    """Fit k, k1 and k2 as the paper did, by pictures at measured places."""
    rows = np.array([_ring_rows(apparatus, d) for d in RANGES])
    good = np.isfinite(rows)
    if good.sum() < 3:
        raise ConfigError("the marker cannot be seen at three ranges; k cannot be fitted")
    centimetres = RANGES / CM
    k = float(np.exp(np.mean(np.log(rows[good] * centimetres[good]))))
    fits = []
    for distance in HEADING_RANGES:
        heights = np.array([_stripe_rows(apparatus, distance, psi) for psi in STRAIGHT])
        told = np.isfinite(heights)
        slope, start = np.polyfit(heights[told], np.degrees(STRAIGHT[told]), 1)
        fits.append((slope, -start))
    k1, k2 = np.array(fits).T
    aside_k = []
    for distance, aside in zip(ASIDE_RANGES, ASIDE, strict=True):
        triple = _one(centroids(apparatus.picture(distance, 2.0, aside), apparatus.marker))
        aside_k.append(aside / CM / (LENS.centre_px[0] - float(triple[:2, 0].mean())))
    return Constants(
        ranges=centimetres,
        rows=rows,
        k=k,
        heading_ranges=np.asarray(HEADING_RANGES / CM, dtype=np.float64),
        k1=k1,
        k2=k2,
        aside=ASIDE / CM,
        aside_k=np.array(aside_k),
        aside_ranges=ASIDE_RANGES / CM,
    )


def table_of_moments(apparatus: Apparatus, fitted: Constants) -> Table:
    """Return Table 1 of the paper's method, at places where the constants were not fitted."""
    rows = np.array([_ring_rows(apparatus, d) for d in TEST_RANGES])
    true = TEST_RANGES / CM
    found = np.array([fitted.range_of(row) for row in rows])
    bearings = []
    for distance, aside in _off_axis():
        triple = _one(centroids(apparatus.picture(distance, 2.0, aside), apparatus.marker))
        measured = fitted.range_of(float(triple[1, 1] - triple[0, 1]))
        theta = fitted.bearing_of(LENS.centre_px[0] - float(triple[:2, 0].mean()), measured)
        bearings.append(theta / np.arctan2(aside, distance) - 1.0)  # eq. 3: d_v is the surface's
    headings = []
    for distance in TEST_HEADING_RANGES:
        for psi in TURN:
            triple = _one(centroids(apparatus.picture(distance, psi), apparatus.marker))
            measured = fitted.range_of(float(triple[1, 1] - triple[0, 1]))
            told = np.radians(fitted.heading_of(float(triple[1, 1] - triple[2, 1]), measured))
            headings.append(float(wrap(told - psi)))
    return _table(found / true - 1.0, np.array(bearings), np.array(headings), fitted.k / rows / true - 1.0)


def table_of_reader(apparatus: Apparatus, method: str) -> Table:
    """Return Table 1 of one of our methods at the same places."""
    reader = Reader(LENS, apparatus.marker, method)

    def off(distance: float, psi: float, aside: float) -> FloatArray:
        estimates = reader.read(apparatus.picture(distance, psi, aside))
        true = apparatus.truth(distance, psi, aside)
        if len(estimates.seen) == 0:
            return np.full(3, np.nan)
        bearing = float(estimates.bearing[0])
        heading = float(wrap(estimates.heading[0] - true[2]))
        return np.array(
            [estimates.range[0] / true[0] - 1.0, bearing / true[1] - 1.0 if true[1] else 0.0, heading]
        )

    ranges = np.array([off(d, 2.0, 0.0)[0] for d in TEST_RANGES])
    bearings = np.array([off(d, 2.0, aside)[1] for d, aside in _off_axis()])
    headings = np.array([off(d, psi, 0.0)[2] for d in TEST_HEADING_RANGES for psi in TURN])
    return _table(ranges, bearings, headings)


def filters(apparatus: Apparatus) -> Comparison:
    """Compare the paper's noise filters: error of range with a k of their own, and time."""
    pictures = [apparatus.picture(d) for d in FILTER_RANGES]
    rows: list[tuple[str | float | None, ...]] = []
    for kind, size in [("none", 1), *((kind, size) for kind in FILTERS for size in FILTER_SIZES)]:
        start = time.perf_counter()
        triples = [centroids(picture, apparatus.marker, kind, size) for picture in pictures]
        wall_ms = 1e3 * (time.perf_counter() - start) / len(pictures)
        rings = np.array([t[0][1, 1] - t[0][0, 1] if len(t) == 1 else np.nan for t in triples])
        good = np.isfinite(rings)
        error = None
        if good.all():
            k = float(np.median(rings * FILTER_RANGES))
            error = 100.0 * float(np.sqrt(np.mean((k / rings / FILTER_RANGES - 1.0) ** 2)))
        rows.append((kind, float(size), error, float(good.mean()), wall_ms))
    return Comparison(("filter", "size_px", "range_error_percent", "read", "wall_ms"), tuple(rows))


def patterns() -> Comparison:
    """Compare the eight patterns: which headings one centroid tells, and which our reading does."""
    rows: list[tuple[str | float | None, ...]] = []
    for kind in SHAPES:
        apparatus = Apparatus(marker_of(kind=kind))
        heights = np.array([_stripe_rows(apparatus, PATTERN_RANGE, psi) for psi in TURN])
        symmetric = kind in SYMMETRIC
        told_by_centroid = _told_apart(heights, symmetric)
        told_by_fit = None
        if not symmetric:
            reader = Reader(LENS, apparatus.marker, "fit")
            good = 0
            for psi in TURN:
                estimates = reader.read(apparatus.picture(PATTERN_RANGE, psi))
                truth = apparatus.truth(PATTERN_RANGE, psi)[2]
                good += bool(len(estimates.seen)) and abs(float(wrap(estimates.heading[0] - truth))) < WRONG
            told_by_fit = 360.0 * good / len(TURN)
        rows.append((kind, "symmetric" if symmetric else "asymmetric", told_by_centroid, told_by_fit))
    return Comparison(("pattern", "kind", "centroid_tells_deg", "fit_tells_deg"), tuple(rows))


def sizes() -> Comparison:
    """Compare the paper's marker diameters and heights: k, its error, and the range error of our reading."""
    rows: list[tuple[str | float | None, ...]] = []
    for diameter in (3.0, 4.0, 5.0):
        for height in (5.0, 6.0, 7.0):
            apparatus = Apparatus(marker_of(radius=diameter / 2.0 * CM, height=height * CM))
            distances = np.array([13.0, 20.0, 30.0, 40.0, 50.0]) * CM
            rings = np.array([_ring_rows(apparatus, d) for d in distances])
            k = float(np.nanmedian(rings * distances))
            spread = 100.0 * float(np.nanmax(np.abs(k / rings / distances - 1.0)))
            reader = Reader(LENS, apparatus.marker, "fit")
            off = []
            for distance in distances:
                estimates = reader.read(apparatus.picture(distance))
                true = apparatus.truth(distance, 2.0)[0]
                off.append(estimates.range[0] / true - 1.0 if len(estimates.seen) else np.nan)
            rows.append((diameter, height, k / CM, spread, 100.0 * float(np.nanmax(np.abs(off)))))
    columns = ("diameter_cm", "height_cm", "k_cm_px", "moments_error_percent", "fit_error_percent")
    return Comparison(columns, tuple(rows))


def lights() -> Comparison:
    """Compare levels of light: how often each method finds the marker, and its greatest range error."""
    rows: list[tuple[str | float | None, ...]] = []
    distances = np.array([14.0, 20.0, 30.0, 40.0, 48.0]) * CM
    for level in LIGHTS:
        apparatus = Apparatus(faults=IMPERFECTIONS["pi-v1"].model_copy(update={"gain": level}))
        row: list[str | float | None] = [level]
        for method in ("moments", "fit"):
            reader = Reader(LENS, apparatus.marker, method)
            off = []
            for distance in distances:
                estimates = reader.read(apparatus.picture(distance))
                if len(estimates.seen) == 1:
                    off.append(100.0 * abs(estimates.range[0] / apparatus.truth(distance, 2.0)[0] - 1.0))
            row += [len(off) / len(distances), float(max(off)) if off else None]
        rows.append(tuple(row))
    columns = ("light", "moments_found", "moments_error_percent", "fit_found", "fit_error_percent")
    return Comparison(columns, tuple(rows))


def marker_of(kind: str = "helix", radius: float = 0.02, height: float = 0.06) -> MarkerConfig:
    """Return the paper's marker with another pattern, radius or height (m); its middle stays level."""
    return MarkerConfig(
        name=f"{kind}-{2e3 * radius:.0f}x{1e3 * height:.0f}",
        radius=radius,
        base=LENS.height - height / 2.0,
        bands=(
            BandConfig(colour="red", height=0.010),
            BandConfig(
                colour="white",
                height=height - 0.020,
                pattern=PatternConfig.model_validate({"kind": kind}),
            ),
            BandConfig(colour="blue", height=0.010),
        ),
    )


def _one(triples: list[FloatArray]) -> FloatArray:
    """Return the one marker's centroids; nan where not one is found."""
    return triples[0] if len(triples) == 1 else np.full((3, 2), np.nan)


def _ring_rows(apparatus: Apparatus, surface_range: float) -> float:
    triple = _one(centroids(apparatus.picture(surface_range), apparatus.marker))
    return float(triple[1, 1] - triple[0, 1])


def _stripe_rows(apparatus: Apparatus, surface_range: float, psi: float) -> float:
    triple = _one(centroids(apparatus.picture(surface_range, psi), apparatus.marker))
    return float(triple[1, 1] - triple[2, 1])


def _off_axis() -> list[tuple[float, float]]:
    """Return d_v and d_h (m) at which Table 1's bearing is tested: 5.1 to 23 cm aside, in the picture."""
    places = [(d, aside) for d in TEST_RANGES[::2] for aside in np.array([5.3, 9.7, 14.2, 18.6, 22.8]) * CM]
    return [(d, aside) for d, aside in places if aside / (d + 0.02) < 0.42]


def _table(
    ranges: FloatArray, bearings: FloatArray, headings: FloatArray, single: FloatArray | None = None
) -> Table:
    """Return the greatest errors; what is not told, or told wrong, counts to the dead zone of heading."""
    told = _outside_dead_zone(headings)
    return Table(
        range_error_percent=100.0 * float(np.abs(ranges).max()),
        range_std=float(np.std(ranges)),
        bearing_error_percent=100.0 * float(np.abs(bearings).max()),
        bearing_std=float(np.std(bearings)),
        heading_error_percent=100.0 * float(np.abs(headings[told]).max(initial=0.0)) / (2.0 * np.pi),
        heading_std=float(np.std(headings[told] / (2.0 * np.pi))) if told.any() else float("nan"),
        dead_zone_deg=360.0 * float(1.0 - told.mean()),
        single_k_error_percent=None if single is None else 100.0 * float(np.abs(single).max()),
    )


def _outside_dead_zone(headings: FloatArray) -> NDArray[np.bool_]:
    """Return which errors, rounds of TURN, lie outside the least arc round psi = 0 that holds the bad."""
    rounds = headings.reshape(-1, len(TURN))
    bad: NDArray[np.bool_] = np.any(~np.isfinite(rounds) | (np.abs(rounds) > WRONG), axis=0)
    half = len(TURN) // 2
    after = np.flatnonzero(bad[:half])
    before = np.flatnonzero(bad[half:])
    last = after[-1] + 1 if len(after) else 0
    first = half + before[0] if len(before) else len(TURN)
    told = (np.arange(len(TURN)) >= last) & (np.arange(len(TURN)) < first)
    return np.tile(told, len(rounds))


def _told_apart(heights: FloatArray, symmetric: bool) -> float:
    """Return how many degrees of heading no other heading shares its centroid's height with.

    Neighbours within 15 deg are the same heading; a mirror-symmetric pattern has half a turn to tell.
    """
    turn = TURN[: len(TURN) // 2] if symmetric else TURN
    heights = heights[: len(turn)]
    apart = np.abs(wrap(turn[:, None] - turn)) > np.radians(15.0)
    alike: NDArray[np.bool_] = np.abs(heights[:, None] - heights) < TELLS_APART
    unique = ~(apart & alike).any(axis=1) & np.isfinite(heights)
    return float(np.degrees(turn[1] - turn[0]) * unique.sum())
