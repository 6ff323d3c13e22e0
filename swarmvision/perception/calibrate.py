"""Focal length, height and tilt of a lens, and the marker's colours, from pictures of one marker.

Every point of a ring's inner edge is a ray that meets a circle of known radius and height; every end
of a ring is a ray in a vertical plane that touches the cylinder. One least squares problem over all
pictures holds the lens (focal length, height, pitch, roll) and for each picture range and bearing of
the marker; distances read off a ruler are measurements like any other, and so are the zero of the
ruler and the measures of the print, each with the error that it may well have. With ``t`` the slope and ``b``
the azimuth of a ray in the level frame, bearing ``B`` and range ``d`` of the axis, radius ``R``::

    t = (z - h) / (d cos(b - B) - sqrt(R^2 - d^2 sin^2(b - B)))      on a ring's edge at height z
    b = B +- asin(R / d)                                             at a side

What the pictures tell without a ruler. Separation and width of the rings grow as ``f / d`` together,
so far away only that quotient is seen. Near the lens the cylinder's front is nearer than its sides:
width over separation falls as ``sqrt((d - R) / (d + R))``, about ``1 - R / d``. Towards the border of
the picture the same ratio grows as ``1 / cos B``. Both are weak, so the uncertainty of the focal
length is reported, and pictures that leave it above :data:`WORST_FOCAL` are refused. Height and
tilt come from rows against separations, ``row = horizon - separation (z - h) / H``, and need neither
ruler nor focal length, but different distances.

Source of the geometry: our own. A lens looks level in the rest of the package; a tilt by ``pitch``
is written as the horizon's row, with the first tangential coefficient that keeps the distortion where
it was (see :meth:`Calibration.level_lens`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from swarmvision.camera import Lens
from swarmvision.colour import encode
from swarmvision.errors import CalibrationError
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception.bundle import RULER_BIAS, SHARED, Bundle
from swarmvision.perception.leastsquares import Solution
from swarmvision.perception.sighting import Sighting, palette

LEAST_PICTURES = 3
LEAST_SPREAD = 1.3  # largest over smallest separation; less cannot tell height from tilt
WORST_FOCAL = 0.03  # relative standard error of the focal length that is still worth a file
WORST_HEIGHT = 0.010  # m, the same for the lens height
WORST_RMS = 1.5  # px: more means another marker, or another lens, than was said
WRONG_RANGE = 0.15  # by which a range may contradict the others before it is called wrong
WRONG_RULER = 6.0  # standard errors, after the fit, from which a range is called wrong
STEEP = np.radians(5.0)  # tilt beyond which readers that think the lens level go wrong
GUESSES = (0.5, 0.8, 1.2, 2.0)  # focal lengths to start from, in picture widths: 90 to 28 deg
WRONG_PRINT = 0.01  # relative error of the print beyond which it is not this marker: five times PRINT_BIAS
BASE_BIAS = 0.0005  # m: error of the height at which the marker stands


@dataclass(frozen=True, eq=False, slots=True)
class Calibration:
    """What the pictures tell, each value with its standard error."""

    start: Lens
    """Size, principal point and distortion, taken as given."""
    focal_px: tuple[float, float]
    height: tuple[float, float]
    """m"""
    pitch: tuple[float, float]
    """Up from the horizon (rad)."""
    roll: tuple[float, float]
    """By which the lens's left side is raised (rad)."""
    ruler_zero: tuple[float, float] | None
    """What must be added to every range as given (m); None where none was given."""
    print_scale: tuple[float, float]
    """True over stated radius and height of the marker, as far as the pictures tell them."""
    ranges: FloatArray
    """Of the axis in each picture and its standard error (m), shape ``(n, 2)``."""
    bearings: FloatArray
    """rad, shape ``(n,)``"""
    points_px: tuple[FloatArray, ...]
    """Points that were used in each picture, columns and rows, each ``(k, 2)``."""
    residuals_px: tuple[FloatArray, ...]
    """Their distances from where the model has them, along rows on edges and columns at sides, ``(k,)``."""
    colours: FloatArray
    """sRGB, not rounded, of each colour of the marker's palette, shape ``(c, 3)``; NaN where not seen."""
    colours_spread: FloatArray
    """Standard deviation from picture to picture, shape ``(c, 3)``."""

    @property
    def rms_px(self) -> FloatArray:
        """Root mean square residual of each picture (px), shape ``(n,)``."""
        return np.array([np.sqrt(np.mean(np.square(r))) for r in self.residuals_px])

    @property
    def overall_rms_px(self) -> float:
        """Root mean square residual of all points (px)."""
        return float(np.sqrt(np.mean(np.square(np.concatenate(self.residuals_px)))))

    @property
    def is_steep(self) -> bool:
        """Whether the lens is tilted by more than readers that think it level forgive."""
        return bool(np.hypot(self.pitch[0], self.roll[0]) > STEEP)

    def level_lens(self) -> Lens:
        """Return the level lens that sees markers where this one does, to first order in the pitch.

        Looking up by ``p`` moves the horizon down by ``f tan p``. The principal point goes with it; radial
        distortion about a point ``e`` lower is radial distortion about the old one plus a tangential
        part ``p1 = k1 e``, so that much is added.
        """
        lens = replace(self.start, focal_px=self.focal_px[0], height=self.height[0])
        drop = float(np.tan(self.pitch[0]))
        k1, k2, p1, p2, k3 = lens.distortion
        column, row = lens.centre_px
        return replace(
            lens,
            centre_px=(column, row + lens.focal_px * drop),
            distortion=(k1, k2, p1 + k1 * drop, p2, k3),
        )


def calibrate(
    sightings: Sequence[Sighting],
    marker: Marker,
    start: Lens,
    ranges: Sequence[float | None] | None = None,
    *,
    ruler_std: float = 0.001,
    keep_focal: bool = False,
) -> Calibration:
    """Return what pictures of one marker tell about the lens that took them.

    Args:
        sightings: One for each picture, at different distances.
        marker: Its measures must be right; its colours need not be.
        start: Gives size, principal point and distortion; its focal length too where that is kept.
        ranges: From the lens to the marker's axis, on the ground (m); None where unknown.
        ruler_std: Standard error of each given range (m).
        keep_focal: Whether the start's focal length is right and only height and tilt are wanted.

    Raises:
        CalibrationError: If the pictures are too few or too much alike, or contradict the ranges or the
            marker; one line that tells which and what to do.
    """
    rulers = np.array([np.nan if r is None else r for r in ranges or [None] * len(sightings)], dtype=float)
    _refuse_alike(sightings, rulers)
    focals = [start.focal_px] if keep_focal else _guesses(sightings, marker, start, rulers)
    bundle = Bundle(sightings, marker, start, rulers, ruler_std, keep_focal)
    solution = min((bundle.solved(focal) for focal in focals), key=lambda found: found.cost)
    bundle.drop_outliers(solution)
    found = _told(bundle, bundle.solved_from(solution.parameters), sightings, start)
    _refuse_contradiction(found, rulers, ruler_std)
    _refuse_uncertain(found, marker)
    return found


def _refuse_alike(sightings: Sequence[Sighting], rulers: FloatArray) -> None:
    if len(rulers) != len(sightings):
        raise CalibrationError(f"{len(sightings)} pictures need as many ranges, got {len(rulers)}")
    wrong = [float(r) for r in rulers if np.isinf(r) or r <= 0]
    if wrong:
        raise CalibrationError(f"a range must be positive (m), got {wrong[0]}")
    if len(sightings) < LEAST_PICTURES:
        raise CalibrationError(
            f"{len(sightings)} picture{'s are' if len(sightings) != 1 else ' is'} too few: "
            f"{LEAST_PICTURES} are needed, 6 to 10 are good"
        )
    separations = [s.separation_px for s in sightings]
    if max(separations) < LEAST_SPREAD * min(separations):
        raise CalibrationError(
            "all pictures show the marker at about one distance "
            f"(rings {min(separations):.0f} to {max(separations):.0f} px apart), so lens height and tilt "
            "cannot be told apart: add nearer or farther ones"
        )


def _refuse_uncertain(found: Calibration, marker: Marker) -> None:
    focal, std = found.focal_px
    if not np.isfinite([focal, *found.height, *found.pitch]).all() or not np.isfinite(std):
        raise CalibrationError("the pictures do not determine the lens: add nearer and farther ones")
    worst = int(np.argmax(found.rms_px))
    if found.rms_px[worst] > WORST_RMS:
        raise CalibrationError(
            f"picture {worst + 1} fits marker {marker.name!r} to {found.rms_px[worst]:.1f} px only (rms): "
            "is it this marker, whole, and is the distortion of the lens known?"
        )
    radius, height = found.print_scale
    if max(abs(np.log(radius)), abs(np.log(height))) > WRONG_PRINT:
        raise CalibrationError(
            f"the pictures want the radius of marker {marker.name!r} {100.0 * (radius - 1.0):+.1f} % and its "
            f"height {100.0 * (height - 1.0):+.1f} % larger: is it this marker, and are the ranges right?"
        )
    if std > WORST_FOCAL * focal:
        raise CalibrationError(
            f"the focal length stays uncertain by {100.0 * std / focal:.1f} %: give --ranges, or add "
            "pictures within 0.15 m and towards the left and right border"
        )
    if found.height[1] > WORST_HEIGHT:
        raise CalibrationError(
            f"the lens height stays uncertain by {1e3 * found.height[1]:.0f} mm: add nearer and "
            "farther pictures"
        )


def _guesses(sightings: Sequence[Sighting], marker: Marker, start: Lens, rulers: FloatArray) -> list[float]:
    """Return focal lengths (px) to start from: one by the ranges where there are any, else a ladder."""
    known = np.isfinite(rulers)
    if not known.any():
        return [share * start.width_px for share in GUESSES]
    depth = rulers - marker.radius
    if (depth[known] <= 0).any():
        raise CalibrationError(
            f"a range goes to the marker's axis and must exceed its radius {marker.radius} m"
        )
    separation = np.array([s.separation_px for s in sightings])
    focal = separation * depth / (marker.bands[0].bottom - marker.bands[-1].top)  # f / cos B
    column = np.array([np.median(s.edges_px[:, 0]) for s in sightings])
    focal *= np.cos(np.arctan((column - start.centre_px[0]) / np.median(focal[known])))
    middle = float(np.median(focal[known]))
    slack = WRONG_RANGE + 2.0 * RULER_BIAS / depth
    _refuse_range(rulers, np.abs(focal / middle - 1.0) / slack, middle / focal * depth + marker.radius)
    return [middle]


def _refuse_contradiction(found: Calibration, rulers: FloatArray, ruler_std: float) -> None:
    if found.ruler_zero is not None:
        expected = found.ranges[:, 0] - found.ruler_zero[0]
        bearable = WRONG_RULER * np.hypot(ruler_std, found.ranges[:, 1])
        _refuse_range(rulers, np.abs(rulers - expected) / bearable, expected)


def _refuse_range(rulers: FloatArray, off: FloatArray, expected: FloatArray) -> None:
    """Raise if a given range is off, in units of what is bearable, by more than 1."""
    off = np.nan_to_num(off)
    worst = int(np.argmax(off))
    if off[worst] > 1.0:
        raise CalibrationError(
            f"the range of picture {worst + 1}, {rulers[worst]:.3f} m, contradicts the others, "
            f"which make it about {expected[worst]:.2f} m: are the ranges in the order of the pictures?"
        )


def _told(bundle: Bundle, solution: Solution, sightings: Sequence[Sighting], start: Lens) -> Calibration:
    """Return the solution in words; its errors grow where the residuals are larger than expected."""
    count, at = len(sightings), solution.parameters
    freedom = max(len(solution.residuals) - len(at), 1)
    with np.errstate(invalid="ignore"):
        std = np.sqrt(np.diag(solution.covariance) * max(solution.cost / freedom, 1.0))
    misses = bundle.misses(at)
    own = [(bundle.picture == i) & bundle.used for i in range(count)]
    focal, distance = bundle.focal(at), bundle.ranges(at)
    height, pitch, roll, zero = ((float(at[i]), float(std[i])) for i in (1, 2, 3, 4))
    colours, colours_spread = _colours(sightings)
    return Calibration(
        start=start,
        focal_px=(focal, focal * float(std[0])),
        height=(height[0], float(np.hypot(height[1], BASE_BIAS))),
        pitch=pitch,
        roll=roll,
        ruler_zero=zero if bundle.has_rulers else None,
        print_scale=bundle.print_scale(at),
        ranges=np.column_stack([distance, distance * std[SHARED : SHARED + count]]),
        bearings=at[SHARED + count :],
        points_px=tuple(bundle.points[mask] for mask in own),
        residuals_px=tuple(misses[mask] for mask in own),
        colours=colours,
        colours_spread=colours_spread,
    )


def _colours(sightings: Sequence[Sighting]) -> tuple[FloatArray, FloatArray]:
    """Return the median sRGB over pictures and its spread, each ``(c, 3)``; near pictures count first."""
    near = max(s.separation_px for s in sightings)
    large = [s.colours for s in sightings if s.separation_px >= 0.4 * near]
    seen = np.array([encode(colours) for colours in large])  # (n, c, 3)
    middle, spread = np.full(seen.shape[1:], np.nan), np.full(seen.shape[1:], np.nan)
    for i in range(seen.shape[1]):
        rows = seen[np.isfinite(seen[:, i]).all(axis=1), i]
        if len(rows):
            middle[i], spread[i] = np.median(rows, axis=0), rows.std(axis=0)
    return middle, spread


def recoloured(found: Calibration, marker: Marker) -> dict[tuple[int, int, int], str]:
    """Return the measured ``#rrggbb`` of each of the marker's colours that the pictures tell."""
    codes = {}
    for colour, seen in zip(palette(marker), found.colours, strict=True):
        if np.isfinite(seen).all():
            codes[colour] = "#" + "".join(f"{round(float(c)):02x}" for c in np.clip(seen, 0, 255))
    return codes
