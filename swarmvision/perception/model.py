"""What a picture of a marker should look like, pixel by pixel, and how that changes.

The model of one pixel, in balanced linear light, is

    cover * shade * sum_k colour_k * share_k(row) + (1 - cover) * background

* ``share_k``: how much of the pixel shows colour ``k``; the edges between bands, and of the pattern,
  stand where the exact geometry of the cylinder puts them, and are as soft as the blur makes them.
* ``cover``: the two tangents and the top edge, equally soft. The bottom edge is left out.
* ``shade``: 1, sin, cos, sin cos and sin^2 of the angle across the cylinder, and linear in height.
* Colours, and a background that changes evenly from side to side and from row to row, are linear.

It shares nothing with the renderers of the simulator but :func:`swarmvision.marker.pattern_edges`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker, pattern_edges

# The parameters, in their order.
LOG_RANGE, BEARING, HEADING, DROP, LEAN, BLUR, SIN, COS, SIN_COS, SIN_SQUARE, RISE, SMEAR = range(12)
FREE = 12
ROW = 16  # derivatives, a residual and zeros: whole vectors
GROUND = 3  # basis functions of the background: left, right, growing upwards
SOFTNESS = 3.2  # half width of the soft step over its standard deviation
ERF_SCALE, ROOT_PI = SOFTNESS / math.sqrt(2.0), math.sqrt(math.pi)
RIM = 0.985  # of the radius: farther out the surface is seen as if here


@compiled
def soft_step(t: float) -> float:
    """Return the integral of a Gaussian of the standard deviation 1 / SOFTNESS, 0 below -1 and 1 above 1."""
    if t <= -1.0:
        return 0.0
    if t >= 1.0:
        return 1.0
    return 0.5 + 0.5 * math.erf(t * ERF_SCALE)


@compiled
def soft_slope(t: float) -> float:
    """Return the derivative of :func:`soft_step`."""
    if t <= -1.0 or t >= 1.0:
        return 0.0
    return ERF_SCALE / ROOT_PI * math.exp(-((t * ERF_SCALE) ** 2))


@dataclass(frozen=True, eq=False, slots=True)
class Skin:
    """A marker as the kernel wants it: edges from the top down, and which colour lies below each."""

    top: float
    """Height of the top edge above the ground (m)."""
    radius: float
    heights: FloatArray
    """Of the edges above the ground (m); those of the pattern are nan, shape ``(edges,)``."""
    kinds: NDArray[np.int64]
    """0 for an edge between bands, 1 and 2 for the pattern's high and low one, shape ``(edges,)``."""
    inks: NDArray[np.int64]
    """Number of the colour above the first edge, then below each, shape ``(edges + 1,)``."""
    knots: FloatArray
    """Of the pattern, above the ground."""
    jumps: FloatArray
    """Azimuths (rad) at which the pattern jumps: vertical edges, shape ``(jumps,)``."""
    colours: int
    """How many different colours there are."""
    base: float
    """Height of the bottom edge above the ground (m)."""
    middle: float
    """Height (m) half way between the two inner edges of top and bottom band."""
    inner: float
    """Distance (m) of those edges."""
    told: bool
    """Whether the pattern tells the heading."""

    @classmethod
    def of(cls, marker: Marker) -> Skin:
        """Return the skin of a marker."""
        palette: dict[tuple[int, int, int], int] = {}

        def ink(colour: tuple[int, int, int]) -> int:
            return palette.setdefault(colour, len(palette))

        heights: list[float] = []
        kinds: list[int] = []
        inks: list[int] = []
        knots = np.zeros((2, 3))
        for band in marker.bands:
            if inks:
                heights.append(band.top)
                kinds.append(0)
            inks.append(ink(band.colour))
            if band.pattern is not None:
                heights += [np.nan, np.nan]
                kinds += [1, 2]
                inks += [ink(band.pattern.colour), ink(band.colour)]
                knots = band.pattern.knots + np.array([0.0, marker.base, marker.base])
        high, low = marker.bands[0].bottom, marker.bands[-1].top
        carrier = marker.patterned
        return cls(
            top=marker.base + marker.height,
            radius=marker.radius,
            heights=np.array(heights) + marker.base,
            kinds=np.array(kinds, dtype=np.int64),
            inks=np.array(inks, dtype=np.int64),
            knots=knots,
            jumps=_jumps(knots),
            colours=len(palette),
            base=marker.base,
            middle=marker.base + (high + low) / 2.0,
            inner=high - low,
            told=carrier is not None and carrier.pattern is not None and not carrier.pattern.symmetric,
        )


def _jumps(knots: FloatArray) -> FloatArray:
    """Return the azimuths (rad) at which a pattern jumps, the closing of the turn included."""
    step = np.abs(np.diff(knots[:, 1:], axis=0)).max(axis=1)
    inside = knots[1:, 0][(np.diff(knots[:, 0]) < 1e-9) & (step > 0.0)]
    closes = np.abs(knots[-1, 1:] - knots[0, 1:]).max() < 1e-9
    return inside if closes else np.append(inside, 0.0)


@compiled
def model(
    theta: FloatArray,
    colours: FloatArray,
    view: FloatArray,
    sizes: FloatArray,
    heights: FloatArray,
    kinds: NDArray[np.int64],
    inks: NDArray[np.int64],
    knots: FloatArray,
    jumps: FloatArray,
    frame: FloatArray,
    columns: FloatArray,
    rows: FloatArray,
    thin: int,
    moving: bool,
    basis: FloatArray,
    change: FloatArray,
    used: NDArray[np.int64],
) -> int:
    """Write the linear basis and the derivatives of the model at every pixel; return at how many.

    The basis is the same for all channels.

    Args:
        theta: The parameters, shape ``(12,)``.
        colours: Light of each colour, then of the background's basis, ``(3, colours + 3)``.
        view: Focal length, principal column and row (px), lens height (m).
        sizes: Radius, height of the top edge, of the middle above the ground (m).
        heights: As in :class:`Skin`, like kinds, inks, knots and jumps.
        kinds: See there.
        inks: See there.
        knots: See there.
        jumps: See there.
        frame: Middle row and half of the height of the marker (px), footprint of a pixel across and
            down (px).
        columns: Of the pixels (px), equal ones in a row, shape ``(n,)``.
        rows: Of the pixels (px), shape ``(n,)``.
        thin: Where no edge is near, only every so many-th pixel is used.
        moving: Whether the derivatives are written.
        basis: Out: what each colour, then of the background's basis, gives, ``(n, colours + 3)``.
        change: Out: derivatives of each channel, and room for a residual, ``(3, n, ROW)``.
        used: Which pixels are written, in their order, ``(n,)``.
    """
    edges = len(kinds)
    most = 2 * edges + 1  # where the pattern jumps, its edges on both sides of that; last, the top edge
    count = colours.shape[1] - GROUND
    row_at, soft, slope_u, share_of = np.empty(most), np.empty(most), np.empty(most), np.empty(most)
    by = np.zeros((most, 5))  # row of an edge by range, bearing, heading, drop, lean
    above, below = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    weight_by = np.zeros(5)  # how the share of the pattern beyond a jump changes
    used_edges = crown = 0
    mix = np.empty(count)
    distance = math.exp(theta[LOG_RANGE])
    bearing = theta[BEARING]
    radius = sizes[0]
    axis_x, axis_y = distance * math.cos(bearing), distance * math.sin(bearing)
    half = math.asin(min(radius / distance, 0.999))
    half_by_range = -radius / math.sqrt(max(distance * distance - radius * radius, 1e-12))  # times d
    tan_left, tan_right = math.tan(bearing + half), math.tan(bearing - half)
    left, right = view[1] - view[0] * tan_left, view[1] - view[0] * tan_right
    left_by_bearing = -view[0] * (1.0 + tan_left * tan_left)
    right_by_bearing = -view[0] * (1.0 + tan_right * tan_right)
    left_by_range, right_by_range = left_by_bearing * half_by_range, -right_by_bearing * half_by_range
    blur = theta[BLUR]
    across_var = blur * blur + frame[2] * frame[2] / 12.0
    down_var = blur * blur + frame[3] * frame[3] / 12.0
    soft_u = SOFTNESS * math.sqrt(across_var)
    soft_u_by_blur = SOFTNESS * SOFTNESS * blur / soft_u
    last = np.nan
    sine = cosine = 0.0
    n = 0
    for pixel in range(len(columns)):
        u = columns[pixel]
        if u != last:
            last = u
            # The surface that this column sees; beyond the rim, the rim's.
            middle, reach = 0.5 * (left + right), 0.5 * RIM * (right - left)
            at = min(max(u, middle - reach), middle + reach)
            m = (view[1] - at) / view[0]
            a = 1.0 + m * m
            b = axis_x + m * axis_y
            c = distance * distance - radius * radius
            x = (b - math.sqrt(max(b * b - a * c, 1e-12))) / a
            nx, ny = (x - axis_x) / radius, (m * x - axis_y) / radius
            size = math.hypot(nx, ny)
            nx, ny = nx / size, ny / size
            ray = nx + m * ny  # towards the lens: negative
            ray = min(ray, -0.05)
            # Of depth x and of the direction of the normal, by range (times d), bearing and column.
            x_by_range = (nx * axis_x + ny * axis_y) / ray
            x_by_bearing = (-nx * axis_y + ny * axis_x) / ray
            x_by_u = (x * ny / ray) / view[0]
            turn_by_range = (nx * (m * x_by_range - axis_y) - ny * (x_by_range - axis_x)) / radius
            turn_by_bearing = (nx * (m * x_by_bearing - axis_x) - ny * (x_by_bearing + axis_y)) / radius
            turn_by_u = (nx * (m * x_by_u - x / view[0]) - ny * x_by_u) / radius
            ray_angle = math.atan(m)
            sine = -(nx * math.sin(ray_angle) - ny * math.cos(ray_angle)) * 1.0
            sine = min(max(sine, -1.0), 1.0)
            cosine = math.sqrt(1.0 - sine * sine)
            azimuth = math.atan2(ny, nx) - theta[HEADING]
            beyond, bend = 1.0, 0.0  # share of the pattern as it is here, and how sharply that changes
            gap, turn_px = 0.0, max(abs(turn_by_u), 1e-9)
            for k in range(len(jumps)):
                off = azimuth - jumps[k]
                off -= 2.0 * math.pi * math.floor(off / (2.0 * math.pi) + 0.5)
                t = off / (turn_px * soft_u)
                if abs(t) < 1.0:
                    gap = off
                    beyond = soft_step(t)
                    bend = soft_slope(t) / (turn_px * soft_u)
                    weight_by[0], weight_by[1], weight_by[2] = (
                        bend * turn_by_range,
                        bend * turn_by_bearing,
                        -bend,
                    )
            used_edges = 0
            for e in range(edges + 1):
                for side in range(2):
                    share = 1.0
                    z, steep = sizes[1], 0.0
                    if e < edges:
                        z = heights[e]
                        if kinds[e] > 0:
                            # On the far side of a jump, and on the near one, each carried on to here.
                            share = beyond if side == 0 else 1.0 - beyond
                            at_jump = azimuth
                            if bend > 0.0:
                                at_jump = azimuth - gap + (1e-6 if side == 0 else -1e-6)
                            low, high, low_slope, high_slope = pattern_edges(knots, at_jump)
                            z, steep = (high, high_slope) if kinds[e] == 1 else (low, low_slope)
                            z += steep * (azimuth - at_jump)
                    if (side == 1 and share == 1.0) or share == 0.0:
                        continue
                    k = used_edges
                    used_edges += 1
                    up = view[0] * (z - view[3]) / (x * x)
                    lift = -view[0] * steep / x
                    row_at[k] = view[2] + theta[DROP] - view[0] * (z - view[3]) / x
                    tilt = up * x_by_u + lift * turn_by_u
                    slope_u[k], share_of[k] = tilt, share
                    by[k, 0] = up * x_by_range + lift * turn_by_range
                    by[k, 1] = up * x_by_bearing + lift * turn_by_bearing
                    by[k, 2] = -lift
                    by[k, 3] = 1.0
                    by[k, 4] = -tilt * (row_at[k] - frame[0])
                    row_at[k] += theta[LEAN] * by[k, 4]
                    soft[k] = SOFTNESS * math.sqrt(down_var + min(tilt * tilt, 25.0) * across_var)
                    if e < edges:
                        above[k], below[k] = inks[e], inks[e + 1]
                    if side == 1:
                        share_of[k] = -share  # the minus marks the near side of a jump
            if bend == 0.0:
                weight_by[:] = 0.0
            used_edges -= 1
            crown = used_edges
        v = rows[pixel]
        down = v - frame[0]
        side = u - theta[LEAN] * down
        t_left, t_right = (side - left) / soft_u, (side - right) / soft_u
        t_top = (v - row_at[crown]) / soft[crown]
        on_left, on_right, on_top = soft_step(t_left), 1.0 - soft_step(t_right), soft_step(t_top)
        cover = on_left * on_right * on_top
        if thin > 1 and cover == 1.0 and (int(v / frame[3]) + 2 * int(u / frame[3])) % thin != 0:
            near = weight_by[2] != 0.0
            for e in range(used_edges):
                near = near or abs(v - row_at[e]) < soft[e]
            if not near:
                continue
        rise = -down / frame[1]
        shade = (
            1.0
            + theta[SIN] * sine
            + theta[COS] * cosine
            + theta[SIN_COS] * sine * cosine
            + theta[SIN_SQUARE] * sine * sine
            + theta[RISE] * rise
        )
        for k in range(count):
            mix[k] = 0.0
        mix[inks[0]] = 1.0
        if moving:
            for channel in range(3):
                for j in range(FREE):
                    change[channel, n, j] = 0.0
        for e in range(used_edges):
            t = (v - row_at[e]) / soft[e]
            if t <= -1.0:
                continue
            far = share_of[e] > 0.0
            part = soft_step(t) * abs(share_of[e])
            mix[above[e]] -= part
            mix[below[e]] += part
            if not moving:
                continue
            if weight_by[2] != 0.0 and abs(share_of[e]) < 1.0:
                swing = soft_step(t) * cover * shade * (1.0 if far else -1.0)
                for channel in range(3):
                    step = colours[channel, below[e]] - colours[channel, above[e]]
                    for j in range(3):
                        change[channel, n, j] += step * swing * weight_by[j]
            if t >= 1.0:
                continue
            slope = soft_slope(t) / soft[e] * cover * shade * abs(share_of[e])
            tilt = slope_u[e]
            wider = -slope * t * SOFTNESS * SOFTNESS * blur * (1.0 + min(tilt * tilt, 25.0)) / soft[e]
            for channel in range(3):
                step = colours[channel, below[e]] - colours[channel, above[e]]
                for j in range(5):
                    change[channel, n, j] -= step * slope * by[e, j]
                change[channel, n, BLUR] += step * wider
        share = min(max((right - u) / (right - left), 0.0), 1.0)
        away = 1.0 - cover
        for k in range(count):
            basis[n, k] = mix[k] * cover * shade
        basis[n, count] = share * away
        basis[n, count + 1] = (1.0 - share) * away
        basis[n, count + 2] = rise * away
        used[n] = pixel
        n += 1
        if not moving:
            continue
        by_left = -soft_slope(t_left) / soft_u * on_right * on_top
        by_right = soft_slope(t_right) / soft_u * on_left * on_top
        by_top = -soft_slope(t_top) / soft[crown] * on_left * on_right
        for channel in range(3):
            value = 0.0
            for k in range(count):
                value += colours[channel, k] * mix[k]
            behind = (
                colours[channel, count] * share
                + colours[channel, count + 1] * (1.0 - share)
                + colours[channel, count + 2] * rise
            )
            bare = value * cover
            change[channel, n - 1, SIN] = bare * sine
            change[channel, n - 1, COS] = bare * cosine
            change[channel, n - 1, SIN_COS] = bare * sine * cosine
            change[channel, n - 1, SIN_SQUARE] = bare * sine * sine
            change[channel, n - 1, RISE] = bare * rise
            if away > 0.0:
                contrast = value * shade - behind
                change[channel, n - 1, LOG_RANGE] += contrast * (
                    by_left * left_by_range + by_right * right_by_range + by_top * by[crown, 0]
                )
                change[channel, n - 1, BEARING] += contrast * (
                    by_left * left_by_bearing + by_right * right_by_bearing + by_top * by[crown, 1]
                )
                change[channel, n - 1, DROP] += contrast * by_top
                change[channel, n - 1, LEAN] += contrast * (
                    (by_left + by_right) * down + by_top * by[crown, 4]
                )
                change[channel, n - 1, BLUR] += contrast * (
                    (by_left * t_left + by_right * t_right) * soft_u_by_blur
                    + by_top * t_top * SOFTNESS * SOFTNESS * blur / soft[crown]
                )
    return n


@compiled
def smeared(
    sharp: FloatArray,
    sharp_change: FloatArray,
    kept: NDArray[np.int64],
    high: int,
    length: float,
    colours: FloatArray,
    moving: bool,
    basis: FloatArray,
    change: FloatArray,
) -> None:
    """Spread every place of the grid over ``length`` columns, and add the derivative by the length.

    Args:
        sharp: From :func:`model`, column by column: the basis, ``(n, colours + 3)``.
        sharp_change: And the derivatives, ``(3, n, ROW)``.
        kept: Places to write, ``(kept,)``.
        high: Places in one column.
        length: Of the box (columns).
        colours: As in :func:`model`.
        moving: As in :func:`model`.
        basis: Out: ``(kept, colours + 3)``.
        change: Out: ``(3, kept, ROW)``.
    """
    width = colours.shape[1]
    reach = math.ceil(length / 2.0 + 0.5)
    share, by_length = np.zeros(2 * reach + 1), np.zeros(2 * reach + 1)
    for offset in range(-reach, reach + 1):
        near, far = abs(offset) - 0.5, abs(offset) + 0.5
        inside = min(far, length / 2.0) - max(near, -length / 2.0)
        inside = max(inside, 0.0)
        grows = 0.0
        if near < length / 2.0 < far:
            grows = 0.5
            if offset == 0:
                grows = 1.0
        share[offset + reach] = inside / length
        by_length[offset + reach] = grows / length - inside / (length * length)
    slope = np.empty(width)
    for n in range(len(kept)):
        for w in range(width):
            basis[n, w] = slope[w] = 0.0
        if moving:
            for channel in range(3):
                for j in range(FREE):
                    change[channel, n, j] = 0.0
        for offset in range(-reach, reach + 1):
            part, grows = share[offset + reach], by_length[offset + reach]
            place = kept[n] + offset * high
            if part == 0.0 and grows == 0.0:
                continue
            for w in range(width):
                basis[n, w] += part * sharp[place, w]
                slope[w] += grows * sharp[place, w]
            if moving:
                for channel in range(3):
                    for j in range(FREE):
                        change[channel, n, j] += part * sharp_change[channel, place, j]
        if moving:
            for channel in range(3):
                value = 0.0
                for w in range(width):
                    value += colours[channel, w] * slope[w]
                change[channel, n, SMEAR] = value
