"""What kernels share that cut solids by the columns of a level camera.

Seen along a border of a column, a vertical plane, an upright solid is a stack of bands. A kernel of
:mod:`swarmvision.rendering.boxes` or :mod:`swarmvision.rendering.cylinders` fills in the profile and the
plan of a sheet (see :mod:`swarmvision.rendering.painting`) for the columns that its solid reaches.

``view`` is focal length, principal column and row (px), lens height (m). ``light`` is ambient, diffuse
and the lamp's direction in the lens frame, see :class:`swarmvision.rendering.appearance.Light`.
"""

from __future__ import annotations

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray

NEAREST = 1e-3  # m; surfaces nearer than this to the lens plane are drawn as if there
FAR_ROW = 1e6  # px; beyond every picture
LEAST = 1e-12  # of a step that is divided by


@leaf
def shade(light: FloatArray, x: float, y: float, z: float) -> float:
    """Return Lambert's factor for a unit normal."""
    towards = light[2] * x + light[3] * y + light[4] * z
    factor: float = light[0] + light[1] * max(towards, 0.0)
    return factor
