"""From edges in px to where a cylinder stands, by the exact geometry of ray and circle.

Source: our own; the paper (Majidi Balanji et al.) uses centroids of regions instead, see
:mod:`swarmvision.perception.moments`.
"""

from __future__ import annotations

import math

import numpy as np

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.perception.look import HORIZON_SLACK, TILT
from swarmvision.perception.order import median_in_place, median_of
from swarmvision.perception.pairs import TOP_ONLY
from swarmvision.perception.plan import (
    BASE,
    GAPS,
    INNER_BOTTOM,
    INNER_TOP,
    LOWERS,
    RADIUS,
    RAYS,
    SPARE_A,
    SPARE_B,
    UPPERS,
)

WHOLE = 0.955  # measured over expected width from which both tangents may be real;
WIDTH_SLACK, WIDTH_SHARE = 1.0, 0.005  # px by which, plus which share of it, the width may be another
SIDE_FLOOR = 0.105  # px of a tangent: what no averaging removes, measured on rendered pictures
# What is written of a marker.
RANGE, BEARING, HEADING, RANGE_STD, BEARING_STD, HEADING_STD, VISIBLE, DROP, LEFT, RIGHT, COVERED = range(11)


@leaf
def range_and_bearing(
    count: int,
    lines: FloatArray,
    left_px: float,
    right_px: float,
    cut: int,
    view: FloatArray,
    heights: FloatArray,
    out: FloatArray,
) -> int:
    """Write range (m), bearing (rad), visible fraction and, as RANGE_STD, the spread of the edges (px).

    Returns:
        2 where both tangents tell the bearing, 1 where fewer do; 0 where this is no marker.
    """
    radius = heights[RADIUS]
    left = math.atan((view[1] - left_px) / view[0])
    right = math.atan((view[1] - right_px) / view[0])
    if left - right <= 1e-4:
        return 0
    bearing = (left + right) / 2.0
    distance, noise = axis_distance(count, lines, bearing, view, heights)
    if not distance > radius:
        return 0
    half = math.asin(radius / distance)
    visible = (left - right) / (2.0 * half)
    if visible > 1.25:
        return 0
    wide = right_px - left_px
    odd = abs(wide / visible - wide) > WIDTH_SLACK + WIDTH_SHARE * wide
    tangents = 2
    if visible < WHOLE or odd or cut != 0:
        best, tangents = np.inf, 1
        for side in range(2):
            if cut & (1 << side):
                continue
            edge, sign = (left, -1.0) if side == 0 else (right, 1.0)
            trial_bearing, trial_noise, trial = edge + sign * half, np.inf, distance
            for _ in range(3):
                trial, trial_noise = axis_distance(count, lines, trial_bearing, view, heights)
                if not trial > radius:
                    trial_noise = np.inf
                    break
                trial_bearing = edge + sign * math.asin(radius / trial)
            if trial_noise < best:
                best, distance, bearing, noise = trial_noise, trial, trial_bearing, trial_noise
        visible = (left - right) / (2.0 * math.asin(radius / distance))
    out[RANGE], out[BEARING], out[VISIBLE], out[RANGE_STD] = distance, bearing, visible, noise
    return tangents


@leaf
def axis_distance(
    count: int, lines: FloatArray, bearing: float, view: FloatArray, heights: FloatArray
) -> tuple[float, float]:
    """Return the range (m) of the axis at a bearing (rad), and the spread of the separations (px).

    With ``rho`` the way of the ray to the surface, ``delta`` its angle off the axis and R the radius,
    ``d = rho cos(delta) + sqrt(R^2 - rho^2 sin^2(delta))``.
    """
    radius = heights[RADIUS]
    rays, gaps, distances, spare = lines[RAYS], lines[GAPS], lines[SPARE_A], lines[SPARE_B]
    tall = view[0] * (heights[INNER_TOP] - heights[INNER_BOTTOM])
    within = 0
    for rim in (0.86, 1.0):  # near the rim the sag is too steep to be told well
        within = 0
        for i in range(count):
            rho = tall / gaps[i] / math.cos(rays[i])
            across = abs(rho * math.sin(rays[i] - bearing))
            if across < rim * radius:
                inner = math.sqrt(max(radius * radius - across * across, 0.0))
                distances[within] = rho * math.cos(rays[i] - bearing) + inner
                within += 1
        if within >= 2:
            break
    if within < 2:
        return np.nan, np.nan
    middle = median_of(distances, within, spare)
    for i in range(within):
        spare[i] = abs(distances[i] - middle)
    spread = 1.4826 * median_in_place(spare, within)
    mean = square = 0.0
    kept = 0
    for i in range(within):
        off = distances[i] - middle
        if abs(off) <= 3.0 * spread + 1e-9:
            mean += off
            square += off * off
            kept += 1
    mean /= kept
    std = math.sqrt(max(square / kept - mean * mean, 0.0))
    return middle + mean, std * median_of(gaps, count, spare) / middle


@leaf
def range_from_width(
    left_px: float, right_px: float, view: FloatArray, heights: FloatArray, out: FloatArray
) -> bool:
    """Write range and bearing from the two tangents alone."""
    left = math.atan((view[1] - left_px) / view[0])
    right = math.atan((view[1] - right_px) / view[0])
    half = (left - right) / 2.0
    if half <= 1e-3:
        return False
    out[RANGE], out[BEARING], out[VISIBLE] = heights[RADIUS] / math.sin(half), (left + right) / 2.0, 1.0
    out[RANGE_STD] = out[RANGE] * SIDE_FLOOR / (view[0] * half)
    return True


@leaf
def surface_depth(ray: float, heights: FloatArray, out: FloatArray) -> float:
    """Return how far along the optical axis (m) a ray meets the cylinder, or passes nearest to it."""
    delta = ray - out[BEARING]
    across = min(abs(out[RANGE] * math.sin(delta)), heights[RADIUS])
    rho = out[RANGE] * math.cos(delta) - math.sqrt(heights[RADIUS] ** 2 - across * across)
    depth: float = max(rho * math.cos(ray), 1e-3)
    return depth


@leaf
def complete_edges(
    count: int, lines: FloatArray, bands: int, view: FloatArray, heights: FloatArray, out: FloatArray
) -> None:
    """Write where the inner edge of the band that the picture lacks would be."""
    for i in range(count):
        gap = view[0] * (heights[INNER_TOP] - heights[INNER_BOTTOM])
        gap /= surface_depth(lines[RAYS, i], heights, out)
        if bands == TOP_ONLY:
            lines[LOWERS, i] = lines[UPPERS, i] + gap
        else:
            lines[UPPERS, i] = lines[LOWERS, i] - gap


@leaf
def stands_right(
    count: int, lines: FloatArray, view: FloatArray, heights: FloatArray, out: FloatArray
) -> bool:
    """Write the drop (px); return whether it stands at its height, give or take the tilt of a camera."""
    middle = heights[BASE] + (heights[INNER_TOP] + heights[INNER_BOTTOM]) / 2.0
    drops = lines[SPARE_A]
    for i in range(count):
        depth = surface_depth(lines[RAYS, i], heights, out)
        level = view[2] - view[0] * (middle - view[3]) / depth
        drops[i] = (lines[UPPERS, i] + lines[LOWERS, i]) / 2.0 - level
    out[DROP] = median_in_place(drops, count)
    depth = max((out[RANGE] - heights[RADIUS]) * math.cos(out[BEARING]), 1e-3)
    right: bool = abs(out[DROP]) / view[0] < TILT + HORIZON_SLACK / depth
    return right
