"""How well a marker stands in the pictures of the ring: what the error model's chances and errors depend on.

Whoever is hidden in part is read worse. Whoever is in full sight is still cut by a picture's edge where
two lenses meet: they sit ahead of the axis, so between their views is a wedge that no lens sees. Near by,
a marker of which half is out of both pictures is more often not read.
"""

from __future__ import annotations

import math

from swarmvision.compiled import leaf
from swarmvision.config.camera import LENSES, RIGS
from swarmvision.sensing.error_table import CUTS, VISIBLES
from swarmvision.trigonometry import TO_INTEGER

LENS, RING = LENSES["pi-v1"], RIGS["ring-7"]
AHEAD, APART = RING.forward, 2.0 * math.pi / len(RING.yaws_deg)  # m, rad
EDGE = math.atan(LENS.width_px / (2.0 * LENS.focal_px))  # rad, from a lens's axis
SINE_EDGE = math.sin(EDGE)
WHOLE, CUT, DEEP = len(VISIBLES), len(VISIBLES) + 1, len(VISIBLES) + 2
VIEWS = WHOLE + 1 + CUTS
INSIDE, HALF = 1.0, -0.25
"""How far inside a picture, in radii of the marker, it is whole, and where about half of it is out."""


@leaf
def view_of(distance: float, bearing: float, visible: float, radius: float) -> tuple[int, float]:
    """Return how a marker is seen, and on which side of its lens's axis it is.

    Args:
        distance: m
        bearing: In -2 pi ... 2 pi (rad).
        visible: Fraction that nobody hides.
        radius: Of the marker (m).

    Returns:
        How many of the fractions at which bins of ``VISIBLES`` begin are in sight, or :data:`WHOLE`,
        :data:`CUT` or :data:`DEEP`; 1.0 for left and -1.0 for right.
    """
    lenses = bearing * (1.0 / APART)
    off = lenses - ((lenses + TO_INTEGER) - TO_INTEGER)
    side = 1.0 if off >= 0.0 else -1.0
    view = 0
    for n in range(len(VISIBLES)):
        view += 1 if visible >= VISIBLES[n] else 0
    angle = EDGE - side * off * APART  # 0.02 ... 0.47: two terms of its sine are enough
    inside = distance * (angle * (1.0 - angle * angle * (1.0 / 6.0))) - AHEAD * SINE_EDGE
    cut = (1 if inside < INSIDE * radius else 0) + (1 if inside < HALF * radius else 0)
    return view + (cut if view == WHOLE else 0), side
