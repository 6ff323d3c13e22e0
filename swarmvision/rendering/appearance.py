"""What things look like; both renderers draw from this page, so they can be judged against each other.

All light is linear in [0, 1] and becomes sRGB only when a picture is stored. Shading is Lambert's
law under one distant lamp and an even sky: ``ambient + diffuse * max(0, n . l)``. There are no
shadows; light does not depend on distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from swarmvision.colour import decode, rgb
from swarmvision.geometry import FloatArray


@dataclass(frozen=True, slots=True)
class Light:
    """An even sky and one distant lamp."""

    ambient: float = 0.78
    """Share of the light that comes from everywhere."""
    diffuse: float = 0.30
    """Share of the lamp on a surface that faces it."""
    azimuth: float = 2.2
    """Direction of the lamp in the world (rad)."""
    elevation: float = 0.9
    """Of the lamp above the horizon (rad)."""

    @property
    def direction(self) -> FloatArray:
        """Unit vector towards the lamp, shape ``(3,)``."""
        level = np.cos(self.elevation)
        return np.array(
            [
                level * np.cos(self.azimuth),
                level * np.sin(self.azimuth),
                np.sin(self.elevation),
            ]
        )

    def shade(self, normal: ArrayLike) -> FloatArray:
        """Return the factor on a surface's own light for world normals ``(..., 3)`` of unit length."""
        towards = np.asarray(normal, dtype=np.float64) @ self.direction
        return self.ambient + self.diffuse * np.maximum(towards, 0.0)


UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Appearance:
    """Colours of everything that is neither marker nor object, as linear light ``(3,)``."""

    light: Light = Light()
    floor_colour: str = "#dcdcd8"
    wall_colour: str = "#cfcfca"
    beyond_colour: str = "#c3c3c3"
    """What is seen over the walls."""
    body_colour: str = "#2c2c30"
    mast_colour: str = "#3a3a3c"

    @property
    def floor(self) -> FloatArray:
        """Linear light of the floor, shaded."""
        return decode(rgb(self.floor_colour)) * self.light.shade(UP)

    @property
    def beyond(self) -> FloatArray:
        """Linear light of what is seen over the walls; it shines by itself."""
        return decode(rgb(self.beyond_colour))
