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
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.colour import encode
from swarmvision.errors import CalibrationError
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception.leastsquares import Solution, solve
from swarmvision.perception.sighting import Sighting, palette

LEAST_PICTURES = 3
LEAST_SPREAD = 1.3  # largest over smallest separation; less cannot tell height from tilt
EDGE_BIAS = 0.05  # px: error that all points of one edge share, so that no averaging removes it
RULER_BIAS = 0.003  # m: where the optical centre sits in its barrel, the same in every picture
WORST_FOCAL = 0.03  # relative standard error of the focal length that is still worth a file
WORST_HEIGHT = 0.010  # m, the same for the lens height
WORST_RMS = 1.5  # px: more means another marker, or another lens, than was said
WRONG_RANGE = 0.15  # by which a range may contradict the others before it is called wrong
WRONG_RULER = 6.0  # standard errors, after the fit, from which a range is called wrong
STEEP = np.radians(5.0)  # tilt beyond which readers that think the lens level go wrong
GUESSES = (0.5, 0.8, 1.2, 2.0)  # focal lengths to start from, in picture widths: 90 to 28 deg
PRINT_BIAS = 0.002  # relative error of the printed marker's radius and of its height: 0.1 mm in 40 to 60 mm
BASE_BIAS = 0.0005  # m: error of the height at which the marker stands
SHARED = 7  # log f, height, pitch, roll, the ruler's zero, log of true over stated radius and height; then
# for each picture the log of its range, then for each picture its bearing


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
    problem = _Problem(sightings, marker, start, rulers, ruler_std, keep_focal)
    focals = (start.focal_px,) if keep_focal else problem.guesses()
    _, solution = min(
        ((found.cost, found) for found in map(problem.solved, focals)), key=lambda pair: pair[0]
    )
    problem.drop_outliers(solution)
    solution = problem.solved_from(solution.parameters)
    calibration = problem.told(solution)
    problem.check_ruler(calibration)
    _refuse_uncertain(calibration, marker)
    return calibration


def _refuse_alike(sightings: Sequence[Sighting], rulers: FloatArray) -> None:
    if len(rulers) != len(sightings):
        raise CalibrationError(f"{len(sightings)} pictures need as many ranges, got {len(rulers)}")
    wrong = [float(r) for r in rulers if np.isinf(r) or r <= 0]
    if wrong:
        raise CalibrationError(f"a range must be positive (m), got {wrong[0]}")
    if len(sightings) < LEAST_PICTURES:
        raise CalibrationError(
            f"{len(sightings)} pictures are too few: {LEAST_PICTURES} are needed, 6 to 10 are good"
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
    if found.overall_rms_px > WORST_RMS:
        raise CalibrationError(
            f"the pictures fit marker {marker.name!r} to {found.overall_rms_px:.1f} px only (rms): "
            "is it this marker, and is the distortion of the lens known?"
        )
    if std > WORST_FOCAL * focal:
        raise CalibrationError(
            f"the focal length stays uncertain by {100.0 * std / focal:.0f} %: give --ranges, or add "
            "pictures within 0.15 m and towards the left and right border"
        )
    if found.height[1] > WORST_HEIGHT:
        raise CalibrationError(
            f"the lens height stays uncertain by {1e3 * found.height[1]:.0f} mm: add nearer and "
            "farther pictures"
        )


class _Problem:
    """The residuals of all pictures as one function of all parameters."""

    def __init__(
        self,
        sightings: Sequence[Sighting],
        marker: Marker,
        start: Lens,
        rulers: FloatArray,
        ruler_std: float,
        keep_focal: bool,
    ) -> None:
        self._sightings = sightings
        self._marker = marker
        self._start = start
        self._rulers = rulers
        self._ruler_std = ruler_std
        self._focal = start.focal_px if keep_focal else None
        count = np.arange(len(sightings))
        self._points = np.concatenate([s.edges_px for s in sightings] + [s.sides_px for s in sightings])
        edges, sides = [len(s.edges_px) for s in sightings], [len(s.sides_px) for s in sightings]
        self._edges = sum(edges)  # points before this are on edges, the others at sides
        self._picture = np.concatenate([np.repeat(count, edges), np.repeat(count, sides)])
        self._z = np.concatenate([s.heights for s in sightings])  # above the marker's bottom edge
        self._sign = np.concatenate([s.signs for s in sightings])
        self._used = np.ones(len(self._points), dtype=bool)
        self._std = self._spread()

    def _kinds(self) -> list[NDArray[np.int64]]:
        """Return the indices of the points of each edge and side of each picture."""
        kind = np.concatenate([self._z, 10.0 * self._sign])  # heights are far below 10 m
        groups = []
        for i in range(len(self._sightings)):
            for k in np.unique(kind[self._picture == i]):
                groups.append(np.flatnonzero((self._picture == i) & (kind == k) & self._used))
        return [group for group in groups if len(group)]

    def _spread(self) -> FloatArray:
        """Return the standard deviation of each point (px): averaged over its edge it is EDGE_BIAS."""
        std = np.full(len(self._points), np.inf)
        for group in self._kinds():
            std[group] = EDGE_BIAS * np.sqrt(len(group))
        return std

    def guesses(self) -> list[float]:
        """Return focal lengths to start from: from the ranges where there are any, else a ladder.

        Raises:
            CalibrationError: If a range contradicts the others.
        """
        known = np.isfinite(self._rulers)
        if not known.any():
            return [share * self._start.width_px for share in GUESSES]
        marker = self._marker
        depth = self._rulers - marker.radius
        if (depth[known] <= 0).any():
            raise CalibrationError(
                f"a range goes to the marker's axis and must exceed its radius {marker.radius} m"
            )
        separation = np.array([s.separation_px for s in self._sightings])
        focal = separation * depth / (marker.bands[0].bottom - marker.bands[-1].top)  # f / cos B
        column = np.array([np.median(s.edges_px[:, 0]) for s in self._sightings])
        focal *= np.cos(np.arctan((column - self._start.centre_px[0]) / np.median(focal[known])))
        middle = float(np.median(focal[known]))
        slack = WRONG_RANGE + 2.0 * RULER_BIAS / depth
        self._agreeing(np.abs(focal / middle - 1.0) / slack, middle / focal * depth + marker.radius)
        return [middle]

    def _agreeing(self, off: FloatArray, expected: FloatArray) -> None:
        """Raise if a given range is off, in units of what is bearable, by more than 1."""
        worst = int(np.argmax(np.nan_to_num(off)))
        if np.nan_to_num(off)[worst] > 1.0:
            raise CalibrationError(
                f"the range of picture {worst + 1}, {self._rulers[worst]:.3f} m, contradicts the others, "
                f"which make it about {expected[worst]:.2f} m: are the ranges in the order of the pictures?"
            )

    def check_ruler(self, found: Calibration) -> None:
        """Raise if a given range contradicts the fit.

        Raises:
            CalibrationError: Names the worst.
        """
        if found.ruler_zero is not None:
            expected = found.ranges[:, 0] - found.ruler_zero[0]
            bearable = WRONG_RULER * np.hypot(self._ruler_std, found.ranges[:, 1])
            self._agreeing(np.abs(self._rulers - expected) / bearable, expected)

    def solved(self, focal: float) -> Solution:
        """Return the solution next to a focal length (px), from a closed form."""
        start, marker = self._start, self._marker
        span = marker.bands[0].bottom - marker.bands[-1].top
        middle = marker.base + (marker.bands[0].bottom + marker.bands[-1].top) / 2.0
        straight = replace(start, focal_px=focal).undistort(self._points)
        centre = np.array([np.median(straight[self._picture == i], axis=0) for i in self._indices()])
        separation = np.array([s.separation_px for s in self._sightings])
        # row = horizon - separation (z - h) / H, a line in the separation
        slope, horizon = np.polyfit(separation, centre[:, 1], 1)
        bearing = np.arctan2(start.centre_px[0] - centre[:, 0], focal)
        distance = focal * span / separation / np.cos(bearing) + marker.radius
        pitch = np.arctan2(horizon - start.centre_px[1], focal)
        lens = [np.log(focal), middle + slope * span, np.clip(pitch, -0.5, 0.5), 0.0]
        return self.solved_from(np.array([*lens, 0.0, 0.0, 0.0, *np.log(distance), *bearing]))

    def solved_from(self, parameters: FloatArray) -> Solution:
        """Return the solution next to parameters."""
        return solve(self.residuals, parameters, np.full(len(parameters), 1e-6))

    def _indices(self) -> range:
        return range(len(self._sightings))

    def residuals(self, parameters: FloatArray) -> FloatArray:
        """Return all residuals over their standard deviations: points, ruler, its zero, the print."""
        distance = np.exp(parameters[SHARED : SHARED + len(self._sightings)])
        known = np.isfinite(self._rulers)
        ruler = (distance - self._rulers - parameters[4])[known] / self._ruler_std
        given = parameters[4:SHARED] / [RULER_BIAS, PRINT_BIAS, PRINT_BIAS]
        kept = [] if self._focal is None else [(parameters[0] - np.log(self._focal)) / 1e-6]
        points = (self.misses(parameters) / self._std)[self._used]
        return np.concatenate([points, ruler, given, kept])

    def misses(self, parameters: FloatArray) -> FloatArray:
        """Return by how much each point misses the model (px): rows on edges, columns at sides."""
        focal, (height, pitch, roll) = float(np.exp(np.clip(parameters[0], 0, 12))), parameters[1:4]
        distance, bearing = np.split(parameters[SHARED:], 2)
        d, b = np.exp(distance)[self._picture], bearing[self._picture]
        radius, edges = self._marker.radius * np.exp(parameters[5]), self._edges
        z = self._marker.base + self._z * np.exp(parameters[6])
        d = np.maximum(d, 1.02 * radius)
        azimuth, slope = _level_rays(replace(self._start, focal_px=focal), self._points, pitch, roll)
        off = (azimuth - b)[:edges]
        across = np.clip(d[:edges] * np.sin(off) / radius, -0.98, 0.98)
        depth = d[:edges] * np.cos(off) - radius * np.sqrt(1.0 - across**2)
        up = slope[:edges] - (z - height) / np.maximum(depth, 1e-3)
        left = azimuth[edges:] - b[edges:] - self._sign * np.arcsin(radius / d[edges:])
        return focal * np.concatenate([-up / np.cos(azimuth[:edges]), -left / np.cos(azimuth[edges:]) ** 2])

    def drop_outliers(self, solution: Solution) -> None:
        """Leave out points of an edge that stand far from its others."""
        misses = self.misses(solution.parameters)
        for group in self._kinds():
            off = np.abs(misses[group] - np.median(misses[group]))
            self._used[group[off > 4.0 * 1.4826 * np.median(off) + 0.05]] = False
        self._std = self._spread()

    def told(self, solution: Solution) -> Calibration:
        """Return the solution in words; its errors grow where the residuals are larger than expected."""
        count, at = len(self._sightings), solution.parameters
        freedom = max(len(solution.residuals) - len(at), 1)
        with np.errstate(invalid="ignore"):
            std = np.sqrt(np.diag(solution.covariance) * max(solution.cost / freedom, 1.0))
        misses = self.misses(at)
        own = [(self._picture == i) & self._used for i in self._indices()]
        focal, distance = float(np.exp(at[0])), np.exp(at[SHARED : SHARED + count])
        spread = distance * std[SHARED : SHARED + count]
        height, pitch, roll = ((float(at[i]), float(std[i])) for i in (1, 2, 3))
        colours, colours_spread = _colours(self._sightings)
        return Calibration(
            start=self._start,
            focal_px=(focal, focal * float(std[0])),
            height=(height[0], float(np.hypot(height[1], BASE_BIAS))),
            pitch=pitch,
            roll=roll,
            ruler_zero=(float(at[4]), float(std[4])) if np.isfinite(self._rulers).any() else None,
            ranges=np.column_stack([distance, spread]),
            bearings=at[SHARED + count :],
            points_px=tuple(self._points[mask] for mask in own),
            residuals_px=tuple(misses[mask] for mask in own),
            colours=colours,
            colours_spread=colours_spread,
        )


def _level_rays(
    lens: Lens, points_px: FloatArray, pitch: float, roll: float
) -> tuple[FloatArray, FloatArray]:
    """Return azimuth (rad, left positive) and slope (up per way over the ground) of rays, each ``(n,)``."""
    straight = lens.undistort(points_px)
    left = (lens.centre_px[0] - straight[:, 0]) / lens.focal_px
    up = (lens.centre_px[1] - straight[:, 1]) / lens.focal_px
    left, up = left * np.cos(roll) - up * np.sin(roll), left * np.sin(roll) + up * np.cos(roll)
    ahead, up = np.cos(pitch) - up * np.sin(pitch), np.sin(pitch) + up * np.cos(pitch)
    return np.arctan2(left, ahead), up / np.hypot(ahead, left)


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
