"""Range, bearing and heading of every marker in a picture, in closed form from its edges.

All edges are found to a fraction of a pixel by area integration on linear light: where a signal
steps from one plateau to another, the edge stands where a sharp step of the same area would.

* Bearing is the bisector of the two tangent *angles* (not of their pixels).
* Range: in each column the inner edges of top and bottom band are ``f h / x`` px apart at the depth
  ``x`` of the surface there; the ray, that depth and the radius give the distance of the axis
  exactly. Separations do not feel a lens that sits too high or looks a little up.
* Heading: every column of the pattern votes. The surface seen in a column faces azimuth ``a`` in the
  lens frame; a stripe at the height that the pattern has at azimuth ``phi`` means a heading of
  ``a - phi``. There is no seam to cut and no dead zone.
* Where one tangent is hidden, both possibilities are tried against the sag of the band edges, which
  follow the curve of the cylinder.

Source of the geometry: our own; the paper (Majidi Balanji et al.) uses centroids of regions instead,
see :mod:`swarmvision.perception.moments`.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.colour import decode
from swarmvision.data import Estimates
from swarmvision.geometry import FloatArray, wrap
from swarmvision.marker import Band, Marker
from swarmvision.perception.detect import Candidate, candidates
from swarmvision.perception.segment import Hues, Light, chroma_of, classify, linear, white_of

COARSE_WIDTH = 320  # px; the first look is taken at about this width
WHOLE = 0.955  # measured over expected width from which both tangents are taken as real
EDGE_FLOOR = 0.03  # px: error of an edge that no averaging removes
HEADING_FLOOR = 0.006  # rad: the same for heading
TILT = 0.07  # rad: more than the 3 deg that a camera may look up or down
LEAST_SEPARATION = 2.0  # px between the inner edges; less tells nothing
PALE_ENOUGH = 0.55  # share of the middle zone that must look like the marker
HORIZON_SLACK = 0.012  # m: by which a marker may stand higher or lower than it should


@dataclass(frozen=True, eq=False, slots=True)
class Reading:
    """One marker, measured."""

    range: float
    bearing: float
    heading: float
    std: tuple[float, float, float]
    visible: float
    middle_px: float


def read(image: NDArray[np.uint8], lens: Lens, marker: Marker) -> Estimates:
    """Return the neighbours in a picture ``(h, w, 3)``, nearest first, lens frame, shape ``(k,)``."""
    scale = max(1, round(lens.width_px / COARSE_WIDTH))
    if min(image.shape[0], image.shape[1]) < 4 * scale:
        return Estimates.empty((0,), frame="lens")
    coarse = _coarse(image, scale)
    white = white_of(coarse)
    hues = Hues.of(marker)
    found = candidates(classify(coarse, white, hues), marker, hues, scale)
    readings = [measure(image, white, candidate, lens, marker, scale) for candidate in found]
    return _estimates(_distinct([reading for reading in readings if reading is not None], marker))


def measure(
    image: NDArray[np.uint8], white: Light, candidate: Candidate, lens: Lens, marker: Marker, scale: int
) -> Reading | None:
    """Return what a candidate measures at full resolution; None where it is no marker after all."""
    patch = _Patch.cut(image, white, candidate, scale)
    if patch is None or not _looks_like(patch, candidate, marker):
        return None
    columns, upper, lower = _inner_edges(patch, candidate, marker)
    if len(columns) < 3:
        return None
    sides = _sides(patch, candidate, marker, scale)
    fit = _range_and_bearing(columns, lower - upper, sides, lens, marker)
    if fit is None or not _stands_right(fit, columns, upper, lower, lens, marker):
        return None
    distance, bearing, visible, noise = fit
    heading, heading_std = _heading(patch, columns, upper, lower, (distance, bearing), lens, marker)
    separation = float(np.median(lower - upper))
    spread = np.hypot(noise / np.sqrt(len(columns)), EDGE_FLOOR * (1.0 if visible >= WHOLE else 4.0))
    range_std = distance * spread / separation
    bearing_std = EDGE_FLOOR / lens.focal_px * (1.0 if visible >= WHOLE else 10.0)
    std = (float(range_std), float(bearing_std), heading_std)
    return Reading(distance, bearing, heading, std, min(visible, 1.0), separation)


@dataclass(frozen=True, eq=False, slots=True)
class _Patch:
    """The piece of the picture round a candidate, in balanced linear light."""

    light: Light
    column: int
    row: int
    """Of the patch's first pixel in the picture."""

    @classmethod
    def cut(cls, image: NDArray[np.uint8], white: Light, candidate: Candidate, scale: int) -> _Patch | None:
        margin = int(4 + 3 * scale + 0.2 * (candidate.right - candidate.left))
        left = max(int(candidate.left) - margin, 0)
        right = min(int(candidate.right) + margin, image.shape[1])
        band = float(np.max(candidate.rows[:, 1] - candidate.rows[:, 0]))
        top = max(int(candidate.rows[:, 0].min() - 2 - 0.2 * band), 0)
        bottom = min(int(candidate.rows[:, 3].max() + 2 + 0.2 * band), image.shape[0])
        if right - left < 4 or bottom - top < 6:
            return None
        return cls(linear(image[top:bottom, left:right]) / white, left, top)

    def signal(self, weights: FloatArray) -> Light:
        """Return the picture along one direction of colour, shape ``(h, w)``."""
        return self.light @ weights.astype(np.float32)


def _coarse(image: NDArray[np.uint8], scale: int) -> Light:
    if scale == 1:
        return linear(image)
    size = (image.shape[1] // scale, image.shape[0] // scale)
    whole = image[: size[1] * scale, : size[0] * scale]
    return linear(cv2.resize(whole, size, interpolation=cv2.INTER_AREA))


def _towards(start: tuple[int, int, int], end: tuple[int, int, int]) -> FloatArray:
    """Return the direction of colour along which a step from one print to another is largest."""
    difference = decode(end) - decode(start)
    return difference / np.linalg.norm(difference)


def _interpolated(candidate: Candidate, columns: FloatArray) -> FloatArray:
    """Return the four coarse rows of a candidate at full columns (px), shape ``(n, 4)``."""
    return np.stack([np.interp(columns, candidate.columns, candidate.rows[:, i]) for i in range(4)], axis=1)


def _looks_like(patch: _Patch, candidate: Candidate, marker: Marker) -> bool:
    """Whether what lies between top and bottom band has the colours that the marker has there."""
    columns = np.clip(candidate.columns - patch.column, 0, patch.light.shape[1] - 1).astype(int)
    shares = np.linspace(0.08, 0.92, 15)
    start, end = candidate.rows[:, 1:2] - patch.row, candidate.rows[:, 2:3] - patch.row
    rows = np.clip(start + shares * (end - start), 0, patch.light.shape[0] - 1).astype(int)  # (n, 15)
    pixels = patch.light[rows, columns[:, None]]  # (n, 15, 3)
    total = pixels.sum(axis=-1)
    share = pixels / np.maximum(total, 1e-6)[..., None] - 1.0 / 3.0
    middle = marker.bands[0].bottom - marker.bands[-1].top
    heights = marker.bands[0].bottom - shares * middle
    fits = np.zeros(total.shape, dtype=bool)
    for band in marker.bands:
        inside = (heights < band.top) & (heights > band.bottom)
        colours = [band.colour] + ([band.pattern.colour] if band.pattern is not None else [])
        for colour in colours:
            expected = chroma_of(colour)
            near = np.linalg.norm(share - expected, axis=-1) < 0.16 + 0.35 * np.linalg.norm(expected)
            fits |= near & inside
    # A white middle is brighter than both rings; dark grey is a body or a wall in shadow.
    if chroma_is_grey(marker):
        ring = np.median(np.concatenate([total[:, :1], total[:, -1:]]))
        fits &= total > 0.35 * max(float(np.median(total)), 0.25 * float(ring))
        ends = _ring_brightness(patch, candidate)
        if np.median(total) < 1.2 * ends:
            return False
    return bool(fits.mean() >= PALE_ENOUGH)


def chroma_is_grey(marker: Marker) -> bool:
    """Whether the largest middle band of a marker is white or grey."""
    middle = max(marker.bands[1:-1] or marker.bands, key=lambda band: band.top - band.bottom)
    return bool(np.linalg.norm(chroma_of(middle.colour)) < 0.1)


def _ring_brightness(patch: _Patch, candidate: Candidate) -> float:
    columns = np.clip(candidate.columns - patch.column, 0, patch.light.shape[1] - 1).astype(int)
    levels = []
    for pair in (candidate.rows[:, :2], candidate.rows[:, 2:]):
        rows = np.clip(pair.mean(axis=1) - patch.row, 0, patch.light.shape[0] - 1).astype(int)
        levels.append(float(np.median(patch.light[rows, columns].sum(axis=-1))))
    return max(levels)


def _inner_edges(
    patch: _Patch, candidate: Candidate, marker: Marker
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return columns, rows of the top band's lower and of the bottom band's upper edge (px), ``(n,)``."""
    first = max(int(np.ceil(candidate.left)), patch.column)
    last = min(int(candidate.right), patch.column + patch.light.shape[1])
    inner = np.arange(first, last)
    if len(inner) == 0:
        return np.empty(0), np.empty(0), np.empty(0)
    coarse = _interpolated(candidate, inner + 0.5)
    found = []
    for ring, (above, below), edge, end in (
        (marker.bands[0], marker.bands[:2], 1, 0),
        (marker.bands[-1], marker.bands[-2:], 2, 3),
    ):
        half = 0.5 * np.abs(coarse[:, edge] - coarse[:, end])
        other = below if ring is above else above
        half = np.minimum(half, 0.35 * half * 2.0 * (other.top - other.bottom) / (ring.top - ring.bottom))
        signal = patch.signal(_towards(above.colour, below.colour))
        found.append(_row_edges(signal, inner - patch.column, coarse[:, edge] - patch.row, half))
    (upper, upper_ok), (lower, lower_ok) = found
    good = upper_ok & lower_ok & (lower - upper > LEAST_SEPARATION)
    return inner[good] + 0.5, upper[good] + patch.row, lower[good] + patch.row


def _row_edges(
    signal: Light, columns: NDArray[np.int64], guess: FloatArray, half: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the row of a step in each column by area integration, and whether it is one.

    Args:
        signal: Steps up from above to below, shape ``(h, w)``.
        columns: Where, shape ``(n,)``.
        guess: Of the row (px), to about a pixel, shape ``(n,)``.
        half: Half of the window (px): what is free of other edges, shape ``(n,)``.
    """
    reach = float(np.median(half))
    # Two rounds: the first centres the window on the edge.
    rows = guess
    good = np.ones(len(columns), dtype=bool)
    for _ in range(2):
        window = max(round(reach), 2)
        start = np.rint(rows).astype(int) - window  # (n,)
        index = start[:, None] + np.arange(2 * window)  # (n, 2 window)
        good = (index[:, 0] >= 0) & (index[:, -1] < signal.shape[0])
        index = np.clip(index, 0, signal.shape[0] - 1)
        values = signal[index, columns[:, None]]
        flat = max(window // 2, 1) if window > 2 else 1
        above, below = values[:, :flat].mean(axis=1), values[:, -flat:].mean(axis=1)
        step = below - above
        good &= step > 0.25 * np.median(step[good]) if good.any() else False
        safe = np.where(np.abs(step) > 1e-9, step, 1.0)
        share = ((values - above[:, None]) / safe[:, None]).sum(axis=1)
        rows = np.where(good, start + 2 * window - share, rows)
    return rows.astype(np.float64), good & (np.abs(rows - guess) < np.maximum(half, 2.5))


@dataclass(frozen=True, slots=True)
class _Sides:
    """Columns (px) at which the marker's print ends, and whether the picture ends there too."""

    left: float
    right: float
    left_cut: bool
    right_cut: bool


def _sides(patch: _Patch, candidate: Candidate, marker: Marker, scale: int) -> _Sides:
    """Return where the rings end, by area integration of their chroma along rows."""
    width = candidate.right - candidate.left
    ends: dict[int, list[tuple[float, float]]] = {-1: [], 1: []}
    for ring, pair in ((marker.bands[0], (0, 1)), (marker.bands[-1], (2, 3))):
        weights = chroma_of(ring.colour)
        signal = patch.signal(weights / np.linalg.norm(weights))
        for side in (-1, 1):
            edge = _column_edge(signal, patch, candidate, pair, side, width, scale)
            if edge is not None:
                ends[side].append(edge)
    left = _weighted(ends[-1], candidate.left)
    right = _weighted(ends[1], candidate.right)
    last = patch.column + patch.light.shape[1]
    return _Sides(left, right, left - patch.column < 1.5, last - right < 1.5)


def _weighted(edges: list[tuple[float, float]], otherwise: float) -> float:
    if not edges:
        return otherwise
    places, weights = np.array(edges).T
    return float(np.average(places, weights=weights))


def _column_edge(
    signal: Light,
    patch: _Patch,
    candidate: Candidate,
    pair: tuple[int, int],
    side: int,
    width: float,
    scale: int,
) -> tuple[float, float] | None:
    """Return the column (px) at which a ring ends on one side, and the weight of the measurement."""
    guess = candidate.left if side < 0 else candidate.right
    ends = candidate.rows[:3] if side < 0 else candidate.rows[-3:]
    top, bottom = np.median(ends[:, pair[0]]), np.median(ends[:, pair[1]])
    inset = 0.3 * (bottom - top)
    first = int(np.ceil(top + inset - patch.row))
    last = max(int(bottom - inset - patch.row), first + 1)
    if first < 0 or last > signal.shape[0]:
        return None
    profile = signal[first:last].mean(axis=0)
    if side < 0:
        profile = profile[::-1]
    guess -= patch.column
    if side < 0:
        guess = len(profile) - guess
    reach = int(np.clip(0.16 * width, 3 + scale, 14))
    start, end = round(guess) - reach, round(guess) + reach
    inside = profile[max(start - reach // 2, 0) : max(start + reach // 2, 1)].mean()
    outside_piece = profile[min(end - reach // 2, len(profile) - 1) :][: max(reach // 2, 1)]
    outside = float(outside_piece.mean()) if len(outside_piece) else 0.0
    start, end = max(start, 0), min(end, len(profile))
    if inside - outside < max(0.3 * inside, 1e-6) or end - start < 3:
        return None
    area = float(((profile[start:end] - outside) / (inside - outside)).sum())
    place = start + area
    place = len(profile) - place if side < 0 else place
    return float(place + patch.column), float((last - first) * (inside - outside))


def _range_and_bearing(
    columns: FloatArray, separation: FloatArray, sides: _Sides, lens: Lens, marker: Marker
) -> tuple[float, float, float, float] | None:
    """Return range (m), bearing (rad), visible fraction and spread of the edges (px)."""
    left, right = lens.bearing_from_column([sides.left, sides.right])
    if left - right <= 1e-4:
        return None
    trials = []
    middle = (left + right) / 2.0
    distance, noise = _distance(columns, separation, float(middle), lens, marker)
    if not np.isfinite(distance) or distance <= marker.radius:
        return None
    half = np.arcsin(marker.radius / distance)
    visible = float((left - right) / (2.0 * half))
    if visible > 1.25:
        return None
    whole = visible >= WHOLE and not (sides.left_cut or sides.right_cut)
    if whole:
        return distance, float(middle), visible, noise
    for edge, sign, cut in ((left, -1.0, sides.left_cut), (right, 1.0, sides.right_cut)):
        if cut:
            continue
        bearing = float(edge + sign * half)
        for _ in range(3):
            trial, trial_noise = _distance(columns, separation, bearing, lens, marker)
            if not np.isfinite(trial) or trial <= marker.radius:
                break
            bearing = float(edge + sign * np.arcsin(marker.radius / trial))
        else:
            trials.append((trial_noise, trial, bearing))
    if not trials:
        return distance, float(middle), visible, noise
    noise, distance, bearing = min(trials)
    half = np.arcsin(marker.radius / distance)
    return distance, bearing, float((left - right) / (2.0 * half)), noise


def _distance(
    columns: FloatArray, separation: FloatArray, bearing: float, lens: Lens, marker: Marker
) -> tuple[float, float]:
    """Return the range (m) of the axis at a bearing (rad), and the spread of the separations (px).

    With ``rho`` the way of the ray to the surface, ``delta`` its angle off the axis and R the radius,
    ``d = rho cos(delta) + sqrt(R^2 - rho^2 sin^2(delta))``.
    """
    height = marker.bands[0].bottom - marker.bands[-1].top
    rays = lens.bearing_from_column(columns)
    rho = lens.focal_px * height / separation / np.cos(rays)
    across = rho * np.sin(rays - bearing)
    within = np.abs(across) < 0.86 * marker.radius  # the rim is too steep to be told well
    if within.sum() < 2:
        within = np.abs(across) < marker.radius
    if within.sum() < 2:
        return np.nan, np.nan
    inner = np.sqrt(np.maximum(marker.radius**2 - across[within] ** 2, 0.0))
    distances = rho[within] * np.cos(rays[within] - bearing) + inner
    middle = float(np.median(distances))
    spread = 1.4826 * float(np.median(np.abs(distances - middle)))
    kept = distances[np.abs(distances - middle) <= 3.0 * spread + 1e-9]
    pixels = float(np.median(separation)) / middle
    return float(kept.mean()), float(kept.std() * pixels)


def _stands_right(
    fit: tuple[float, float, float, float],
    columns: FloatArray,
    upper: FloatArray,
    lower: FloatArray,
    lens: Lens,
    marker: Marker,
) -> bool:
    """Whether the marker stands at its height above the ground, give or take the tilt of a camera."""
    distance, bearing = fit[0], fit[1]
    rays = lens.bearing_from_column(columns)
    near = int(np.argmin(np.abs(rays - bearing)))
    depth = max((distance - marker.radius) * np.cos(bearing), 1e-3)
    rise = float(lens.rise_from_row((upper[near] + lower[near]) / 2.0))
    middle = marker.base + (marker.bands[0].bottom + marker.bands[-1].top) / 2.0
    return bool(
        abs(np.arctan(rise) - np.arctan((middle - lens.height) / depth)) < TILT + HORIZON_SLACK / depth
    )


def _heading(
    patch: _Patch,
    columns: FloatArray,
    upper: FloatArray,
    lower: FloatArray,
    axis: tuple[float, float],
    lens: Lens,
    marker: Marker,
) -> tuple[float, float]:
    """Return heading (rad) and its spread; nan for a marker without a pattern, or with a symmetric one."""
    band = marker.patterned
    if band is None or band.pattern is None or band.pattern.symmetric:
        return np.nan, np.nan
    stripes = _unrolled(patch, columns, upper, lower, marker, band)  # (n, heights)
    facing, within = _facing(lens.bearing_from_column(columns), axis, marker)
    if within.sum() < 2:
        return np.nan, np.nan
    stripes, facing = stripes[within], facing[within]
    heading = _coarse_heading(stripes, facing, band)
    return _voted_heading(stripes, facing, heading, band)


HEIGHTS = 48  # samples of the patterned band from its bottom to its top


def _unrolled(
    patch: _Patch, columns: FloatArray, upper: FloatArray, lower: FloatArray, marker: Marker, band: Band
) -> FloatArray:
    """Return how much of the pattern's colour stands at each height of each column, ``(n, HEIGHTS)``."""
    assert band.pattern is not None
    weights = _towards(band.colour, band.pattern.colour)
    # Blind to brightness: what the band's own colour gives is nothing.
    ground = decode(band.colour)
    weights = weights - ground * (weights @ ground) / (ground @ ground)
    signal = patch.signal(weights / (decode(band.pattern.colour) @ weights))
    level = patch.signal(ground / (ground @ ground))
    share = (np.arange(HEIGHTS) + 0.5) / HEIGHTS
    height = band.bottom + share * (band.top - band.bottom)
    high, low = marker.bands[0].bottom, marker.bands[-1].top
    rows = lower[:, None] + (height - low) / (high - low) * (upper - lower)[:, None] - patch.row
    at = columns[:, None] - patch.column + np.zeros_like(rows)
    # OpenCV counts pixel centres from 0.
    x, y = (at - 0.5).astype(np.float32), (rows - 0.5).astype(np.float32)
    stripe = cv2.remap(signal, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    white = cv2.remap(level, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    bright = np.percentile(white, 75, axis=1, keepdims=True)
    unrolled: FloatArray = np.clip(stripe / np.maximum(bright, 1e-6), -0.3, 1.5).astype(np.float64)
    return unrolled


def _facing(
    rays: FloatArray, axis: tuple[float, float], marker: Marker
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the direction (rad, lens frame) that the surface faces in each column, and which are on it."""
    distance, bearing = axis
    across = distance * np.sin(rays - bearing) / marker.radius
    within = np.abs(across) < 0.93
    # The normal of the near surface: back along the ray, turned by the angle of incidence.
    return rays + np.pi - np.arcsin(np.clip(across, -1.0, 1.0)), within


def _coarse_heading(stripes: FloatArray, facing: FloatArray, band: Band) -> float:
    """Return the heading (rad), of a few dozen, whose pattern correlates best with the stripes."""
    assert band.pattern is not None
    trials = np.linspace(-np.pi, np.pi, 72, endpoint=False)
    thin = slice(None, None, max(len(facing) // 16, 1))  # a coarse look needs few columns
    stripes, facing = stripes[thin, ::2], facing[thin]
    height = band.bottom + (np.arange(0, HEIGHTS, 2) + 0.5) / HEIGHTS * (band.top - band.bottom)
    low, high = band.pattern.span(facing[None, :] - trials[:, None])  # (trials, n)
    inside = (height > low[..., None]) & (height < high[..., None])
    score = np.einsum("tnh,nh->t", inside - inside.mean(axis=(1, 2), keepdims=True), stripes)
    return float(trials[int(np.argmax(score))])


def _voted_heading(
    stripes: FloatArray, facing: FloatArray, heading: float, band: Band
) -> tuple[float, float]:
    """Return heading (rad) and spread from every column's own vote near a coarse heading.

    In each column the height of the stripe's middle is compared with that of the pattern; the
    pattern's slope there turns the difference into an angle (one Gauss-Newton step, repeated).
    """
    assert band.pattern is not None
    size = (band.top - band.bottom) / HEIGHTS
    height = band.bottom + (np.arange(HEIGHTS) + 0.5) * size
    step = 0.02
    votes = weights = np.zeros(0)
    for _ in range(4):
        azimuth = facing - heading
        low, high = band.pattern.span(azimuth)
        before, after = band.pattern.span(azimuth - step), band.pattern.span(azimuth + step)
        slope = ((after[0] + after[1]) - (before[0] + before[1])) / (4.0 * step)  # of the middle, m/rad
        jump = np.maximum(np.abs(after[0] - before[0]), np.abs(after[1] - before[1])) > 0.004
        # The stripe's own middle, in a window a little wider than the stripe.
        slack = 0.35 * (high - low) + 1.5 * size
        window = (height > (low - slack)[:, None]) & (height < (high + slack)[:, None])
        mass = np.where(window, np.clip(stripes, 0.0, None), 0.0)
        area = mass.sum(axis=1) * size
        middle = (mass @ height) * size / np.maximum(area, 1e-9)
        full = (area > 0.4 * (high - low)) & ~jump & (np.abs(slope) > 1e-4)
        if full.sum() < 2:
            return heading, 0.5
        # A stripe higher than expected, where the pattern climbs, means a larger azimuth: less heading.
        votes = -(middle - (low + high) / 2.0)[full] / slope[full]
        weights = np.abs(slope[full]) * area[full]
        centre = _weighted_median(votes, weights)
        spread = 1.4826 * _weighted_median(np.abs(votes - centre), weights) + 1e-6
        kept = np.abs(votes - centre) <= 2.5 * spread
        change = float(np.average(votes[kept], weights=weights[kept]))
        heading = float(wrap(heading + np.clip(change, -0.6, 0.6)))
        if abs(change) < 1e-4:
            break
    return heading, float(np.hypot(spread / np.sqrt(max(kept.sum(), 1)), HEADING_FLOOR))


def _weighted_median(values: FloatArray, weights: FloatArray) -> float:
    rank = np.argsort(values, kind="stable")
    total = np.cumsum(weights[rank])
    return float(values[rank][int(np.searchsorted(total, total[-1] / 2.0))])


def _distinct(readings: list[Reading], marker: Marker) -> list[Reading]:
    """Drop readings of a marker that is already read: two axes cannot be nearer than two radii."""
    kept: list[Reading] = []
    for reading in sorted(readings, key=lambda r: (-r.visible, r.range)):
        place = reading.range * np.exp(1j * reading.bearing)
        if all(abs(place - r.range * np.exp(1j * r.bearing)) > 2.0 * marker.radius for r in kept):
            kept.append(reading)
    return sorted(kept, key=lambda r: r.range)


def _estimates(readings: list[Reading]) -> Estimates:
    k = len(readings)
    covariance = np.zeros((k, 3, 3))
    for i, reading in enumerate(readings):
        covariance[i] = np.diag(np.square(reading.std))
        if np.isnan(reading.heading):
            covariance[i, 2, :] = covariance[i, :, 2] = np.nan
    return Estimates(
        seen=np.ones(k, dtype=bool),
        range=np.array([r.range for r in readings]),
        bearing=np.array([r.bearing for r in readings]),
        heading=np.array([r.heading for r in readings]),
        covariance=covariance,
        age=np.zeros(k),
        track=np.full(k, -1),
        visible=np.array([r.visible for r in readings]),
        frame="lens",
    )
