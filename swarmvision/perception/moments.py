"""The paper's method: median filter, HSV masks, centroids by moments, equations 1-8.

Source: H. Majidi Balanji, E. Yilmaz, O. Cakmak, A. E. Turgut, "Design of a Vision-Based Range,
Bearing and Heading System for Robot Swarms" (METU). Equation numbers are the paper's.

Where we differ: several neighbours in one picture, by connected regions and a pairing of the top
band's with the bottom band's; hue windows follow from the marker's own colours; range is told to the
marker's axis, the paper's surface range plus the radius; for another lens or marker the constants
follow from the geometry that the paper's imply (f = 634.6 px, rings 5.03 cm apart, a stripe whose
middle climbs 3.28 cm per turn).

The paper's psi is the turn of the marker counted from the seam: 0 with the seam facing the camera.
The azimuth that faces the camera is ``bearing + pi - heading``; psi is that azimuth.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.data import Estimates
from swarmvision.errors import PictureError
from swarmvision.geometry import FloatArray, wrap
from swarmvision.marker import Marker

MEDIAN_SIZE = 15  # px; the paper's best filter
HUE_WINDOW = 12  # of OpenCV's 180: half width round a colour's hue
LEAST_SATURATION, LEAST_VALUE = 90, 40  # of 255
MOST_REGIONS = 512  # of one colour, the largest; confetti has more
LEAST_AREA = 25  # px of a region; a smaller one is noise
DEAD_ZONE = np.radians(45.0)  # psi from 0 to this cannot be told (the paper's own word)
RANGE_STD, BEARING_STD, HEADING_STD = 0.0044, 0.0597, np.radians(3.25)  # relative, relative, rad: Table 1
LEAST_BEARING_STD = np.radians(0.3)


@dataclass(frozen=True, slots=True)
class Constants:
    """The numbers that the paper fits, in SI units."""

    k: float
    """m px: surface range times the rows between top and bottom centroid (eq. 6)."""
    k1: float
    """rad per px and m of range: how k1 grows with range (figure 11, linear)."""
    k2: float
    """rad: psi at which the pattern's centroid would meet the bottom band's (figure 11)."""

    @classmethod
    def of(cls, lens: Lens, marker: Marker) -> Constants:
        """Return the constants that a lens and a marker imply by a plain pinhole."""
        separation = _middle(marker, 0) - _middle(marker, -1)
        k = lens.focal_px * separation
        band = marker.patterned
        if band is None or band.pattern is None:
            return cls(k, np.nan, np.nan)
        middles = band.pattern.knots[:, 1:].mean(axis=1)
        climb = (middles[-1] - middles[0]) / (2.0 * np.pi)  # m/rad
        if climb == 0.0:
            return cls(k, np.nan, np.nan)
        return cls(k, 1.0 / (lens.focal_px * climb), (middles[0] - _middle(marker, -1)) / climb)


def range_from_separation(rows_px: float, constants: Constants) -> float:
    """Return the surface range d_v (m) along the optical axis from the rows between two centroids (eq. 6)."""
    return constants.k / rows_px


def bearing_from_offset(columns_px: float, lens: Lens) -> float:
    """Return the bearing (rad) of columns left of the principal point (eqs. 3 and 8: k is d_v / f)."""
    return float(np.arctan(columns_px / lens.focal_px))


def heading_from_height(rows_px: float, surface_range: float, constants: Constants) -> float:
    """Return psi (rad, 0..2 pi) from the rows between pattern and bottom centroid (eq. 7)."""
    return constants.k1 * surface_range * rows_px - constants.k2


def read(image: NDArray[np.uint8], lens: Lens, marker: Marker) -> Estimates:
    """Return the neighbours in a picture ``(h, w, 3)``, nearest first, lens frame, shape ``(k,)``.

    Raises:
        PictureError: If the picture is not uint8 in three channels.
    """
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        raise PictureError(f"a picture must be uint8 of shape (h, w, 3), got {image.dtype} {image.shape}")
    constants = Constants.of(lens, marker)
    found = [_neighbour(triple, lens, marker, constants) for triple in centroids(image, marker)]
    found.sort(key=lambda neighbour: neighbour[0])
    return _estimates(np.array(found).reshape(-1, 3))


def smoothed(image: NDArray[np.uint8], kind: str, size: int) -> NDArray[np.uint8]:
    """Return a picture after one of the noise filters that the paper compares.

    Args:
        image: sRGB, shape ``(h, w, 3)``.
        kind: ``gaussian``, ``median``, ``bilateral`` or ``none``.
        size: Of the filter's window (px), odd.
    """
    image = np.ascontiguousarray(image)
    if kind == "gaussian":
        image = np.asarray(cv2.GaussianBlur(image, (size, size), 0), dtype=np.uint8)
    elif kind == "median":
        image = np.asarray(cv2.medianBlur(image, size), dtype=np.uint8)
    elif kind == "bilateral":
        image = np.asarray(cv2.bilateralFilter(image, size, 75.0, 75.0), dtype=np.uint8)
    return image


def centroids(
    image: NDArray[np.uint8], marker: Marker, kind: str = "median", size: int = MEDIAN_SIZE
) -> list[FloatArray]:
    """Return the centroids of every marker's top band, bottom band and pattern.

    Args:
        image: sRGB, shape ``(h, w, 3)``.
        marker: What to look for.
        kind: Of the noise filter, see :func:`smoothed`.
        size: Of its window (px).

    Returns:
        For each marker column and row (px) of the three, shape ``(3, 2)``; nan where there is none.
    """
    hsv = cv2.cvtColor(smoothed(image, kind, size), cv2.COLOR_RGB2HSV)
    tops, bottoms = _regions(hsv, marker.bands[0].colour), _regions(hsv, marker.bands[-1].colour)
    carrier = marker.patterned
    stripe = np.zeros(hsv.shape[:2], dtype=np.uint8)
    if carrier is not None and carrier.pattern is not None:
        stripe = _mask(hsv, carrier.pattern.colour)
    triples = []
    for top, bottom in _paired(tops, bottoms, marker):
        left, right = int(top[2]), int(top[2] + top[4])
        inside = stripe[int(top[1]) : int(np.ceil(bottom[1])), left:right]
        moments = cv2.moments(inside, binaryImage=True)
        pattern = (np.nan, np.nan)
        if moments["m00"] >= LEAST_AREA:
            # Equations 1 and 2; OpenCV counts pixel centres from 0, we from 0.5.
            pattern = (
                moments["m10"] / moments["m00"] + left + 0.5,
                moments["m01"] / moments["m00"] + int(top[1]) + 0.5,
            )
        triples.append(np.array([top[:2], bottom[:2], pattern]))
    return triples


def _middle(marker: Marker, band: int) -> float:
    return (marker.bands[band].bottom + marker.bands[band].top) / 2.0


def _neighbour(
    triple: FloatArray, lens: Lens, marker: Marker, constants: Constants
) -> tuple[float, float, float]:
    top, bottom, pattern = triple
    surface = range_from_separation(float(bottom[1] - top[1]), constants)
    bearing = bearing_from_offset(float(lens.centre_px[0] - (top[0] + bottom[0]) / 2.0), lens)
    distance = surface / np.cos(bearing) + marker.radius  # eq. 4, and on to the axis
    psi = heading_from_height(float(bottom[1] - pattern[1]), surface, constants)
    dead = not DEAD_ZONE <= psi <= 2.0 * np.pi
    heading = np.nan if dead else float(wrap(bearing + np.pi - psi))
    return float(distance), bearing, heading


def _mask(hsv: NDArray[np.uint8], colour: tuple[int, int, int]) -> NDArray[np.uint8]:
    """Return where a picture has a colour's hue, 255 or 0."""
    swatch = np.array([[colour]], dtype=np.uint8)
    hue = int(cv2.cvtColor(swatch, cv2.COLOR_RGB2HSV)[0, 0, 0])
    mask = np.zeros(hsv.shape[:2], dtype=np.uint8)
    for turn in (-180, 0, 180):  # hue is a circle of 180
        low, high = hue - HUE_WINDOW + turn, hue + HUE_WINDOW + turn
        if high >= 0 and low <= 179:
            lower = (max(low, 0), LEAST_SATURATION, LEAST_VALUE)
            mask |= cv2.inRange(hsv, lower, (min(high, 179), 255, 255))
    return mask


def _regions(hsv: NDArray[np.uint8], colour: tuple[int, int, int]) -> FloatArray:
    """Return column, row, left, top, width, height, area of every region of a colour, ``(n, 7)``."""
    _, _, stats, middles = cv2.connectedComponentsWithStats(_mask(hsv, colour))
    rows = [
        (middle[0] + 0.5, middle[1] + 0.5, *stat)
        for stat, middle in zip(stats[1:], middles[1:], strict=True)
        if stat[cv2.CC_STAT_AREA] >= LEAST_AREA
    ]
    regions = np.array(rows, dtype=np.float64).reshape(-1, 7)
    largest = np.argsort(-regions[:, 6], kind="stable")[:MOST_REGIONS]
    return regions[np.sort(largest)]


def _paired(tops: FloatArray, bottoms: FloatArray, marker: Marker) -> list[tuple[FloatArray, FloatArray]]:
    """Pair each region of the top band with one of the bottom band below it, best fits first."""
    proportion = (_middle(marker, 0) - _middle(marker, -1)) / (2.0 * marker.radius)
    width = np.maximum(tops[:, None, 4], bottoms[:, 4])  # (tops, bottoms)
    aside = np.abs(tops[:, None, 0] - bottoms[:, 0]) / width
    stretch = np.maximum(bottoms[:, 1] - tops[:, None, 1], 1e-9) / (width * proportion)
    alike = np.minimum(tops[:, None, 4], bottoms[:, 4]) / width
    score = aside + np.abs(np.log(stretch)) + 1.0 - alike
    places = np.argwhere((aside < 0.25) & (stretch > 0.6) & (stretch < 2.2) & (alike > 0.6))
    fits = [(float(score[i, j]), int(i), int(j)) for i, j in places]
    pairs, used_tops, used_bottoms = [], set(), set()
    for _, i, j in sorted(fits):
        if i not in used_tops and j not in used_bottoms:
            used_tops.add(i)
            used_bottoms.add(j)
            pairs.append((tops[i], bottoms[j]))
    return pairs


def _estimates(rows: FloatArray) -> Estimates:
    k = len(rows)
    covariance = np.zeros((k, 3, 3))
    covariance[:, 0, 0] = (RANGE_STD * rows[:, 0]) ** 2
    covariance[:, 1, 1] = np.maximum(BEARING_STD * np.abs(rows[:, 1]), LEAST_BEARING_STD) ** 2
    covariance[:, 2, 2] = HEADING_STD**2
    blind = np.isnan(rows[:, 2])
    covariance[blind, 2, :] = covariance[blind, :, 2] = np.nan
    return Estimates(
        seen=np.ones(k, dtype=bool),
        range=rows[:, 0],
        bearing=rows[:, 1],
        heading=rows[:, 2],
        covariance=covariance,
        age=np.zeros(k),
        track=np.full(k, -1),
        visible=np.ones(k),
        frame="lens",
    )
