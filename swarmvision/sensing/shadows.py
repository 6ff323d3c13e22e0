"""How much of a marker is hidden: by nearer markers, and by things that stand before it.

A marker is a disc of the plane. Ten rays across its width, from the observer's eye, tell how much of it is
in sight: a ray is hidden where a nearer marker, or a thing taller than the markers' base, stands across
it. Hidden rays are the bits of a number. Angles are computed only where two markers come near each other
in bearing.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import apart, leaf
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray
from swarmvision.trigonometry import direction, sine_cosine

RAYS = np.linspace(-0.9, 0.9, 10)  # across a marker's half width; each ray is a tenth of its width
MIDDLE = len(RAYS) // 2  # the first ray to the left of the middle
LANES = 8  # pairs of markers that are taken at once
ALL_RAYS = (1 << len(RAYS)) - 1


@leaf
def half_width(gap: float, radius: float, ahead: float) -> float:
    """Return the sine of half the width of a marker at a range (m), from an eye so far ahead; 1 at most."""
    return min(radius / max(gap - ahead, 1e-9), 1.0)


@leaf
def may_hide(across: float, along: float, distance: float, sine: float, radius: float) -> bool:
    """Return whether a nearer marker may hide some of a farther one; False only if it does not.

    Args:
        across: Place of the nearer marker's axis across the direction of the farther one (m).
        along: And along it (m).
        distance: No less than how far it is (m): for most, no root need be drawn.
        sine: Of half the width of the farther marker.
        radius: Of both (m).
    """
    return ((abs(across) < radius + sine * distance) & (along > -2.0 * radius)) | (sine >= 0.5)


@apart
def marker_shadows(
    count: int, across: FloatArray, along: FloatArray, sine: FloatArray, radius: float, bits: IntArray
) -> None:
    """Fill in the bits of the rays that nearer markers cover, each those of one farther marker.

    They are taken ``LANES`` at once, so what the arrays hold up to the next whole number of those is, too.

    Args:
        count: How many; the arrays have room for more, to whole ``LANES``.
        across: Place of the nearer marker's axis, from the eye, across the direction of the farther one (m).
        along: And along it (m).
        sine: Of half the width of the farther one, as the eye sees it.
        radius: Of all markers (m).
        bits: Out.
    """
    for n in range(LANES * ((count + LANES - 1) // LANES)):
        x, y = across[n], along[n]
        # From the middle outwards, each a tenth of the width beyond the last: cheaper than so many sines.
        out, ahead = sine_cosine(RAYS[MIDDLE] * arc_sine(sine[n]))
        step_out, step_ahead = 2.0 * out * ahead, 1.0 - 2.0 * out * out
        found = 0
        for ray in range(MIDDLE, len(RAYS)):
            left, right = abs(x * ahead + y * out) < radius, abs(x * ahead - y * out) < radius
            found |= (1 if left & (y * ahead - x * out > 0.0) else 0) << ray
            found |= (1 if right & (y * ahead + x * out > 0.0) else 0) << (len(RAYS) - 1 - ray)
            out, ahead = out * step_ahead + ahead * step_out, ahead * step_ahead - out * step_out
        bits[n] = found


@leaf
def arc_sine(sine: float) -> float:
    """Return the angle (rad) of a sine in 0..1."""
    return direction(sine, np.sqrt((1.0 - sine) * (1.0 + sine)))


@leaf
def thing_shadow(
    bearing: float,
    half: float,
    distance: float,
    thing_x: float,
    thing_y: float,
    thing_yaw: float,
    length: float,
    width: float,
) -> int:
    """Return the bits of the rays that meet a thing before they meet the marker.

    Args:
        bearing: Of the marker in the observer's frame (rad).
        half: Half width of the marker (rad).
        distance: Of the marker (m).
        thing_x: Of the thing in the observer's frame (m).
        thing_y: Of the same (m).
        thing_yaw: Of the same (rad).
        length: Half of the box's, or the disc's radius (m).
        width: Half of the box's, or -1 (m).
    """
    square = thing_x * thing_x + thing_y * thing_y
    bound = length if width < 0.0 else np.hypot(length, width)
    if square > (distance + bound) * (distance + bound):
        return 0
    sine, cosine = sine_cosine(thing_yaw)
    start_x = -(cosine * thing_x + sine * thing_y)
    start_y = -(cosine * thing_y - sine * thing_x)
    bits = 0
    for n in range(len(RAYS)):
        ray = bearing + RAYS[n] * half
        if width < 0.0:
            y, x = sine_cosine(ray)
            along = x * thing_x + y * thing_y
            miss = square - along * along
            if along > 0.0 and miss < length * length and along < distance:
                bits |= 1 << n
            continue
        # In the box's own frame: the slab test.
        y, x = sine_cosine(ray - thing_yaw)
        x = x if abs(x) >= 1e-12 else 1e-12
        y = y if abs(y) >= 1e-12 else 1e-12
        x1, x2 = (-length - start_x) / x, (length - start_x) / x
        y1, y2 = (-width - start_y) / y, (width - start_y) / y
        enter, leave = max(min(x1, x2), min(y1, y2)), min(max(x1, x2), max(y1, y2))
        if enter < leave and leave > 0.0 and enter < distance:
            bits |= 1 << n
    return bits


@leaf
def thing_shadows(
    bearing: float,
    half: float,
    distance: float,
    eye_x: float,
    eye_y: float,
    yaw: float,
    objects: FloatArray,
    things: FloatArray,
) -> int:
    """Return the bits of the rays that any thing covers, from the eye's place and yaw in the world.

    ``objects`` are poses ``(m, 3)``, ``things`` as in :class:`swarmvision.sensing.sight.View`.
    """
    bits = 0
    sine, cosine = sine_cosine(yaw)
    for b in range(len(things)):
        thing = objects[int(things[b, 0])]
        x, y = thing[0] - eye_x, thing[1] - eye_y
        ahead, left = cosine * x + sine * y, cosine * y - sine * x
        bits |= thing_shadow(bearing, half, distance, ahead, left, thing[2] - yaw, things[b, 1], things[b, 2])
        if bits == ALL_RAYS:
            break
    return bits


@leaf
def share_in_sight(hidden: int) -> float:
    """Return the fraction of a marker's width whose rays are not among the hidden ones."""
    bits, left = 0, hidden
    while left > 0:
        bits += 1
        left &= left - 1  # without its lowest bit
    return 1.0 - bits / len(RAYS)
