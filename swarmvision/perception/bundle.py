"""All pictures of a marker as one least squares problem: the residuals of every point and every ruler.

The geometry and the parameters are those of :mod:`swarmvision.perception.calibrate`; in photogrammetry
this is a bundle adjustment whose points lie on a known cylinder.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception.leastsquares import Solution, solve
from swarmvision.perception.sighting import Sighting

EDGE_BIAS = 0.05  # px: error that all points of one edge share, so that no averaging removes it
RULER_BIAS = 0.003  # m: where the optical centre sits in its barrel, the same in every picture
PRINT_BIAS = 0.002  # relative error of the printed marker's radius and of its height: 0.1 mm in 40 to 60 mm
SHARED = 7  # log f, height, pitch, roll, the ruler's zero, log of true over stated radius and height; then
# for each picture the log of its range, then for each picture its bearing


class Bundle:
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
        """Gather the points; arguments as for :func:`swarmvision.perception.calibrate.calibrate`.

        ``rulers`` holds NaN for an unknown range, shape ``(pictures,)``.
        """
        self._sightings = sightings
        self._marker = marker
        self._start = start
        self._rulers = rulers
        self._ruler_std = ruler_std
        self._focal = start.focal_px if keep_focal else None
        count = np.arange(len(sightings))
        self.points = np.concatenate([s.edges_px for s in sightings] + [s.sides_px for s in sightings])
        edges, sides = [len(s.edges_px) for s in sightings], [len(s.sides_px) for s in sightings]
        self._edges = sum(edges)  # points before this are on edges, the others at sides
        self.picture = np.concatenate([np.repeat(count, edges), np.repeat(count, sides)])
        self._z = np.concatenate([s.heights for s in sightings])  # above the marker's bottom edge
        self._sign = np.concatenate([s.signs for s in sightings])
        self.used = np.ones(len(self.points), dtype=bool)
        self._std = self._spread()

    @property
    def has_rulers(self) -> bool:
        """Whether any range was given."""
        return bool(np.isfinite(self._rulers).any())

    def _kinds(self) -> list[NDArray[np.int64]]:
        """Return the indices of the points of each edge and side of each picture."""
        kind = np.concatenate([self._z, 10.0 * self._sign])  # heights are far below 10 m
        groups = []
        for i in range(len(self._sightings)):
            for k in np.unique(kind[self.picture == i]):
                groups.append(np.flatnonzero((self.picture == i) & (kind == k) & self.used))
        return [group for group in groups if len(group)]

    def _spread(self) -> FloatArray:
        """Return the standard deviation of each point (px): averaged over its edge it is EDGE_BIAS."""
        std = np.full(len(self.points), np.inf)
        for group in self._kinds():
            std[group] = EDGE_BIAS * np.sqrt(len(group))
        return std

    def solved(self, focal: float) -> Solution:
        """Return the solution next to a focal length (px), from a closed form."""
        start, marker = self._start, self._marker
        span = marker.bands[0].bottom - marker.bands[-1].top
        middle = marker.base + (marker.bands[0].bottom + marker.bands[-1].top) / 2.0
        straight = replace(start, focal_px=focal).undistort(self.points)
        centre = np.array([np.median(straight[self.picture == i], axis=0) for i in self._indices()])
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
        distance = self.ranges(parameters)
        known = np.isfinite(self._rulers)
        ruler = (distance - self._rulers - parameters[4])[known] / self._ruler_std
        given = parameters[4:SHARED] / [RULER_BIAS, PRINT_BIAS, PRINT_BIAS]
        kept = [] if self._focal is None else [(parameters[0] - np.log(self._focal)) / 1e-6]
        points = (self.misses(parameters) / self._std)[self.used]
        return np.concatenate([points, ruler, given, kept])

    @staticmethod
    def focal(parameters: FloatArray) -> float:
        """Return the focal length (px), from 1 to 1e5."""
        return float(np.exp(np.clip(parameters[0], 0.0, 11.5)))

    @staticmethod
    def print_scale(parameters: FloatArray) -> tuple[float, float]:
        """Return true over stated radius and true over stated height of the print."""
        radius, height = np.exp(np.clip(parameters[5:SHARED], -1.0, 1.0))
        return float(radius), float(height)

    def ranges(self, parameters: FloatArray) -> FloatArray:
        """Return the range in each picture (m); kept finite, for a trial step may go anywhere."""
        distance: FloatArray = np.exp(
            np.clip(parameters[SHARED : SHARED + len(self._sightings)], -10.0, 10.0)
        )
        return distance

    def misses(self, parameters: FloatArray) -> FloatArray:
        """Return by how much each point misses the model (px): rows on edges, columns at sides."""
        focal, (height, pitch, roll) = self.focal(parameters), parameters[1:4]
        d, b = (
            self.ranges(parameters)[self.picture],
            parameters[SHARED + len(self._sightings) :][self.picture],
        )
        print_radius, print_height = self.print_scale(parameters)
        radius, edges = self._marker.radius * print_radius, self._edges
        z = self._marker.base + self._z * print_height
        d = np.maximum(d, 1.02 * radius)
        azimuth, slope = _level_rays(replace(self._start, focal_px=focal), self.points, pitch, roll)
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
            self.used[group[off > 4.0 * 1.4826 * np.median(off) + 0.05]] = False
        self._std = self._spread()


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
