"""The paper's apparatus, simulated: one camera, one marker on a graduated floor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.config.arena import ARENAS
from swarmvision.config.camera import LENSES
from swarmvision.config.imperfections import IMPERFECTIONS, ImperfectionsConfig
from swarmvision.config.marker import PRESETS, MarkerConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.geometry import FloatArray, polar
from swarmvision.marker import Marker
from swarmvision.randomness import Subsystem, hashed
from swarmvision.rendering.exposing import photograph
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.rendering.raycast import Raycaster

LENS = Lens.from_config(LENSES["pi-v1"])
EYE = np.array([-0.5, 0.0, 0.0])  # where the lens stands in the paper's arena


class Apparatus:
    """Takes pictures of one marker at measured places."""

    def __init__(
        self, marker: MarkerConfig = PRESETS["helix-40x60"], faults: ImperfectionsConfig | None = None
    ) -> None:
        """Set it up.

        Args:
            marker: On the cylinder.
            faults: Of the camera; those of its preset where not given.
        """
        self.marker = Marker.from_config(marker)
        self._camera = Raycaster(LENS, RobotConfig(marker=marker), ARENAS["paper"])
        self._faults = Imperfections(faults or IMPERFECTIONS["pi-v1"], LENS)

    def picture(self, surface_range: float, psi: float = 2.0, aside: float = 0.0) -> NDArray[np.uint8]:
        """Return a picture ``(h, w, 3)``; the same place gives the same one.

        Args:
            surface_range: From the lens plane to the marker's surface (m), the paper's d_v.
            psi: Azimuth of the marker that faces the camera (rad), the paper's heading: 0 is the seam.
            aside: How far to the left the marker's axis stands (m), the paper's d_h.
        """
        x, y, yaw = self.pose(surface_range, psi, aside)
        scene = Scene.at_rest([[EYE[0] + x, y, yaw]])
        place = (round(1e6 * surface_range), round(1e6 * psi), round(1e6 * aside))
        key = hashed(0, Subsystem.SENSOR, *(n % (1 << 31) for n in place))
        return photograph(self._camera, self._faults, scene, EYE, key=key)

    def pose(self, surface_range: float, psi: float, aside: float = 0.0) -> FloatArray:
        """Return x, y (m) and yaw (rad) of the marker from the lens, shape ``(3,)``."""
        x = surface_range + self.marker.radius
        bearing = np.arctan2(aside, x)
        return np.array([x, aside, bearing + np.pi - psi])

    def truth(self, surface_range: float, psi: float, aside: float = 0.0) -> FloatArray:
        """Return range of the axis (m), bearing and heading (rad) from the lens, shape ``(3,)``."""
        return np.array(polar(self.pose(surface_range, psi, aside)))
