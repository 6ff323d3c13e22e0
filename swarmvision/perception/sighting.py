"""One marker in one picture, with nothing known of the lens: its edges and its colours.

Calibration needs points of the picture, not ranges: the two inner ring edges column by column, and
the four places where the two rings end at the sides. Each is found to a fraction of a pixel by area
integration on linear light, between plateaus whose colours are measured on the spot.

At a side the *background's* share of every pixel is integrated, along the direction of colour that is
square to the ring's own light. A ring that darkens towards its rim (Lambert) has no part in that
direction, so shading does not move the edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from swarmvision.colour import decode
from swarmvision.errors import PictureError
from swarmvision.geometry import FloatArray
from swarmvision.marker import Band, Marker
from swarmvision.perception.detect import Candidate, candidates
from swarmvision.perception.look import Proportions
from swarmvision.perception.pairs import BOTH
from swarmvision.perception.segment import COLOURFUL, DECODE, Balance, Hues, chroma_of

COARSE_WIDTH = 320  # px; markers are looked for at about this width
USED = 0.43  # of the marker's width to either side of its middle: the rim is too steep to be told well
LEAST_COLUMNS = 6  # in which each inner edge must be found
LEAST_SEPARATION = 8.0  # px between them
CORE = 0.3  # of the width to either side of the middle: where colours are taken
OTHER_COLOUR = 0.08  # share by which a plateau may differ from the median plateau; more is the stripe
SMALLEST_PICTURE = 8  # px, either way
SATURATED = 0.985  # linear light from which a pixel may have been brighter than the camera can tell
SLICES, SLICE = 4, 4  # a ring's side is measured in up to so many slices, of so many rows or more
NO_THIRD = 0.6  # least sum of the shares of ring and background in a pixel between them
NARROWEST = 0.78  # least width of a whole marker: sqrt((d - R) / (d + R)) at a range of 4 R
TOO_SMALL = "the marker's rings are cut, hidden, blurred or too small to be measured"
FLAT = 0.2  # spread of a background plateau, as a fraction of the step


@dataclass(frozen=True, eq=False, slots=True)
class Sighting:
    """What calibration takes from a picture; px are columns and rows as the real lens made them."""

    edges_px: FloatArray
    """Points of the two inner ring edges, shape ``(n, 2)``."""
    heights: FloatArray
    """Of those points above the marker's bottom edge (m), shape ``(n,)``."""
    sides_px: FloatArray
    """Where rings end, shape ``(m, 2)``."""
    signs: FloatArray
    """+1 for the left side, -1 for the right, shape ``(m,)``."""
    separation_px: float
    """Between the inner edges, in the marker's middle."""
    colours: FloatArray
    """Linear light of each colour of :func:`palette` under the light in which its white is as printed,
    shape ``(c, 3)``; NaN where it cannot be told."""


def palette(marker: Marker) -> tuple[tuple[int, int, int], ...]:
    """Return the distinct colours of a marker's bands from the top down, then of its pattern."""
    colours = [band.colour for band in marker.bands]
    if marker.patterned is not None and marker.patterned.pattern is not None:
        colours.append(marker.patterned.pattern.colour)
    return tuple(dict.fromkeys(colours))


def sight(image: NDArray[np.uint8], marker: Marker) -> Sighting:
    """Return the one marker in a picture, sRGB ``(h, w, 3)``.

    Raises:
        PictureError: If no marker is found, more than one, or not both of its sides.
    """
    light, balance = DECODE[image], Balance.of(image)
    scale = max(1, round(image.shape[1] / COARSE_WIDTH))
    faults, seen = [], []
    for candidate in _found(image, balance, marker):
        try:
            seen.append(_measured(light, balance.white, candidate, marker, scale))
        except PictureError as fault:
            faults.append(str(fault))
    if len(seen) > 1:
        raise PictureError(f"{len(seen)} markers are in view; calibration wants one")
    if not seen:
        raise PictureError(faults[0] if faults else f"no marker {marker.name!r} found")
    return seen[0]


def _found(image: NDArray[np.uint8], balance: Balance, marker: Marker) -> list[Candidate]:
    hues = Hues.of(marker)
    proportions = Proportions.of(marker, hues)
    if proportions is None or min(image.shape[:2]) < SMALLEST_PICTURE:
        return []
    return [found for found in candidates(image, balance, hues, proportions) if found.bands == BOTH]


def _measured(
    light: FloatArray, white: FloatArray, candidate: Candidate, marker: Marker, scale: int
) -> Sighting:
    middle, width = (candidate.left + candidate.right) / 2.0, candidate.right - candidate.left
    first = max(int(np.ceil(middle - USED * width)), 0)
    columns = np.arange(first, min(int(middle + USED * width), light.shape[1]))
    if len(columns) < LEAST_COLUMNS:
        raise PictureError(TOO_SMALL)
    coarse = np.stack(
        [np.interp(columns + 0.5, candidate.columns, candidate.rows[:, i]) for i in range(4)], axis=1
    )
    upper, upper_ok = _ring_edge(light, columns, coarse, 0)
    lower, lower_ok = _ring_edge(light, columns, coarse, 1)
    if min(upper_ok.sum(), lower_ok.sum()) < LEAST_COLUMNS:
        raise PictureError(TOO_SMALL)
    # Where the pattern's seam faces the lens the stripe touches one ring left of it, the other right.
    separation = float(np.median(lower[lower_ok]) - np.median(upper[upper_ok]))
    if separation < LEAST_SEPARATION:
        raise PictureError(
            f"the marker is too far away: its rings are {separation:.0f} px apart, "
            f"{LEAST_SEPARATION:.0f} are needed"
        )
    sides, signs = _sides(light, candidate, scale)
    if set(signs) != {-1.0, 1.0}:
        raise PictureError(
            "the marker's sides are not both free: cut by the border, hidden or before clutter"
        )
    heights = (marker.bands[0].bottom, marker.bands[-1].top)
    # From afar; nearer it looks narrower, towards the border wider.
    widest = 2.0 * marker.radius / (heights[0] - heights[1]) * separation
    if sides[signs < 0, 0].max() - sides[signs > 0, 0].min() < NARROWEST * widest:
        raise PictureError("the marker is partly hidden")
    core = np.abs(columns + 0.5 - middle) < CORE * width
    upper_all = np.interp(columns, columns[upper_ok], upper[upper_ok])
    lower_all = np.interp(columns, columns[lower_ok], lower[lower_ok])
    return Sighting(
        edges_px=np.concatenate(
            [
                np.column_stack([columns[good] + 0.5, rows[good]])
                for good, rows in ((upper_ok, upper), (lower_ok, lower))
            ]
        ),
        heights=np.repeat(heights, [upper_ok.sum(), lower_ok.sum()]),
        sides_px=sides,
        signs=signs,
        separation_px=separation,
        colours=_colours(light, white, columns[core], upper_all[core], lower_all[core], marker),
    )


def _ring_edge(
    light: FloatArray, columns: NDArray[np.int64], coarse: FloatArray, which: int
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the rows (px) of a ring's inner edge, and where they are to be trusted, ``(n,)``.

    Args:
        light: Linear, shape ``(h, w, 3)``.
        columns: Shape ``(n,)``.
        coarse: Top and bottom row of the upper, then of the lower ring, shape ``(n, 4)``.
        which: 0 for the upper ring's lower edge, 1 for the lower ring's upper edge.
    """
    ring = np.median(np.abs(coarse[:, 2 * which + 1] - coarse[:, 2 * which]))
    reach = int(np.clip(round(0.42 * ring), 2, 8))
    flat = max(reach // 2, 1)
    rows = coarse[:, 1 + which]
    good = np.ones(len(columns), dtype=bool)
    for _ in range(3):
        start = np.rint(rows).astype(int) - reach
        index = start[:, None] + np.arange(2 * reach)  # (n, 2 reach)
        good = (start >= 0) & (index[:, -1] < light.shape[0])
        pixels = light[np.clip(index, 0, light.shape[0] - 1), columns[:, None]].astype(np.float64)
        above, below = pixels[:, :flat].mean(axis=1), pixels[:, -flat:].mean(axis=1)  # (n, 3)
        direction = np.median(below - above, axis=0)
        direction /= max(float(np.linalg.norm(direction)), 1e-9)
        low, step = above @ direction, (below - above) @ direction
        usual = float(np.median(step))
        good &= (step > 0.5 * usual) & (step < 2.0 * usual) & (usual > 1e-4)
        share = (pixels @ direction - low[:, None]) / np.where(np.abs(step) > 1e-9, step, 1.0)[:, None]
        rows = np.where(good, start + 2 * reach - share.sum(axis=1), coarse[:, 1 + which])
    for plateau in (above, below):  # where the stripe touches the ring the edge is of another kind
        shares = plateau / np.maximum(plateau.sum(axis=1, keepdims=True), 1e-9)
        good &= np.linalg.norm(shares - np.median(shares, axis=0), axis=1) < OTHER_COLOUR
    return rows, good & (np.abs(rows - coarse[:, 1 + which]) < reach)


def _sides(light: FloatArray, candidate: Candidate, scale: int) -> tuple[FloatArray, FloatArray]:
    """Return points ``(m, 2)`` (px) where the two rings end, and +1 for left or -1 for right, ``(m,)``."""
    width = candidate.right - candidate.left
    reach = int(np.clip(round(0.08 * width), 3, 6)) + scale
    points, signs = [], []
    for sign, guess in ((1.0, candidate.left), (-1.0, candidate.right)):
        ends = candidate.rows[:3] if sign > 0 else candidate.rows[-3:]
        for ring in (0, 2):
            top, bottom = np.median(ends[:, ring]), np.median(ends[:, ring + 1])
            inset = 0.25 * (bottom - top)
            first, last = max(int(np.ceil(top + inset)), 0), min(int(bottom - inset), light.shape[0])
            for rows in _slices(first, last):
                piece = (light[rows] if sign < 0 else light[rows, ::-1]).astype(np.float64)
                start = light.shape[1] - guess if sign > 0 else guess
                # The look is sparse where markers are wide: the end may be beyond its last column.
                ends_at = (_end_of(piece, start + shift, reach) for shift in (0, reach, -reach))
                at = next((end for end in ends_at if end is not None), None)
                if at is not None:
                    points.append((light.shape[1] - at if sign > 0 else at, (rows.start + rows.stop) / 2.0))
                    signs.append(sign)
    return np.array(points).reshape(-1, 2), np.array(signs)


def _slices(first: int, last: int) -> list[slice]:
    """Return up to SLICES pieces of the rows of a ring, each SLICE rows or more where there are as many."""
    count = int(np.clip((last - first) // SLICE, 1, SLICES))
    borders = np.linspace(first, max(last, first + 1), count + 1).astype(int)
    return [slice(int(a), int(b)) for a, b in pairwise(borders)]


def _end_of(rows: FloatArray, guess: float, reach: int) -> float | None:
    """Return the column (px) where rows ``(s, w, 3)`` leave the ring's colour for the background's, if so."""
    profile = rows.mean(axis=0)  # (w, 3)
    at = guess
    for _ in range(3):
        start, end = round(at) - reach, round(at) + reach
        if start - reach < 0 or end + 2 > len(profile) or len(rows) == 0:
            return None
        ring = profile[start - reach : start + 1].mean(axis=0)
        outside = rows[:, end - 2 : end + 2]
        background = outside.mean(axis=(0, 1))
        # Square to the ring's light, so that its shading has no part in the signal.
        direction = background - ring * (background @ ring) / max(float(ring @ ring), 1e-12)
        contrast = float(background @ direction)
        size = float(np.linalg.norm(direction))
        if size < 0.25 * np.linalg.norm(background) or size < 0.25 * np.linalg.norm(ring):
            return None  # of the ring's own colour, or too dark to be told from it
        across = np.ptp((outside @ direction).mean(axis=0))
        along = np.ptp((outside @ direction).mean(axis=1))
        if max(across, along) > FLAT * contrast:
            return None  # another edge lies behind
        shares = np.linalg.lstsq(np.stack([ring, background], axis=1), profile[start:end].T, rcond=None)[0]
        if shares.sum(axis=0).min() < NO_THIRD:
            return None  # something dark stands between the two
        at = end - float((profile[start:end] @ direction).sum()) / contrast
        if abs(at - guess) > reach:
            return None
    return at


def _colours(
    light: FloatArray,
    picture_white: FloatArray,
    columns: NDArray[np.int64],
    upper: FloatArray,
    lower: FloatArray,
    marker: Marker,
) -> FloatArray:
    """Return the light ``(c, 3)`` of each colour of the palette relative to the marker's own white.

    A column of a cylinder is lit alike from top to bottom, so white and colour are compared column by
    column. A marker without a white band is compared with the white of the picture, which tells hue but
    no brightness: that is taken from the print.
    """
    colours = palette(marker)
    samples: dict[tuple[int, int, int], list[FloatArray]] = {colour: [] for colour in colours}
    for band in marker.bands:
        pixels = _inside(light, columns, upper, lower, band, marker)  # (n, s, 3)
        own = np.ones(pixels.shape[:2], dtype=bool)
        if band.pattern is not None:
            own, stripe = _parted(pixels, band)
            samples[band.pattern.colour].append(np.where(stripe[..., None], pixels, np.nan))
        samples[band.colour].append(np.where(own[..., None], pixels, np.nan))
    grey = next((c for c in colours if np.linalg.norm(chroma_of(c)) < COLOURFUL and min(c) > 128), None)
    if grey is not None:
        white = _middle(np.concatenate(samples[grey], axis=1), axis=1) / decode(grey)  # (n, 3)
    else:
        white = np.broadcast_to(picture_white, (len(columns), 3))
    found = np.full((len(colours), 3), np.nan)
    for i, colour in enumerate(colours):
        pixels = np.concatenate(samples[colour], axis=1)
        if grey is not None and np.nanmax(np.concatenate(samples[grey], axis=1), initial=0.0) > SATURATED:
            continue
        found[i] = _middle(_middle(pixels, axis=1) / np.maximum(white, 1e-6), axis=0)
    if grey is None:
        found *= decode(colours)[np.isfinite(found)].sum() / max(float(np.nansum(found)), 1e-9)
    return found


def _inside(
    light: FloatArray,
    columns: NDArray[np.int64],
    upper: FloatArray,
    lower: FloatArray,
    band: Band,
    marker: Marker,
) -> FloatArray:
    """Return pixels ``(n, s, 3)`` well inside a band; in a column of a cylinder rows go by height."""
    scale = (lower - upper) / (marker.bands[0].bottom - marker.bands[-1].top)  # px per m, (n,)
    top = upper + (marker.bands[0].bottom - band.top) * scale
    bottom = upper + (marker.bands[0].bottom - band.bottom) * scale
    inset = np.minimum(np.maximum(0.2 * (bottom - top), 2.0), 0.45 * (bottom - top))
    count = int(np.clip(np.median(bottom - top), 1, 48))
    shares = (np.arange(count) + 0.5) / count
    rows = (top + inset)[:, None] + shares * (bottom - top - 2.0 * inset)[:, None]
    index = np.clip(rows.astype(int), 0, light.shape[0] - 1)
    pixels: FloatArray = light[index, columns[:, None]].astype(np.float64)
    return pixels


def _parted(pixels: FloatArray, band: Band) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which pixels ``(n, s)`` are of the band's own colour and which of its pattern's; no edges."""
    assert band.pattern is not None
    shares = pixels / np.maximum(pixels.sum(axis=-1, keepdims=True), 1e-9)
    towards = chroma_of(band.pattern.colour) - chroma_of(band.colour)
    along = (shares - np.median(shares.reshape(-1, 3), axis=0)) @ towards / (towards @ towards)
    peak = max(float(np.percentile(along, 98.0)), 1e-9)
    own, stripe = along < 0.15 * peak, along > 0.8 * peak
    if peak < 0.3:
        return np.ones_like(own), np.zeros_like(stripe)
    inner = stripe.copy()
    inner[:, 1:] &= stripe[:, :-1]
    inner[:, :-1] &= stripe[:, 1:]
    return own, inner if inner.any() else stripe


def _middle(values: FloatArray, axis: int) -> FloatArray:
    """Return the median along an axis without the NaN; NaN where there is nothing else."""
    order = np.sort(values, axis=axis)  # NaN last
    count = np.isfinite(order).sum(axis=axis, keepdims=True)
    low = np.take_along_axis(order, np.maximum((count - 1) // 2, 0), axis=axis)
    high = np.take_along_axis(order, np.minimum(count // 2, order.shape[axis] - 1), axis=axis)
    middle: FloatArray = np.squeeze((low + np.where(count > 0, high, np.nan)) / 2.0, axis=axis)
    return middle
