"""The paper's constants come out of the simulated apparatus with the paper's own method."""

from __future__ import annotations

import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.config.arena import ARENAS
from swarmvision.config.camera import LENSES
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception.moments import Constants, centroids
from swarmvision.rendering.raycast import Raycaster

LENS, ROBOT = Lens.from_config(LENSES["pi-v1"]), RobotConfig()
MARKER = Marker.from_config(ROBOT.marker)
APPARATUS = Raycaster(LENS, ROBOT, ARENAS["paper"])
EYE = np.array([-0.5, 0.0, 0.0])


def photographed(surface_range: float, psi: float = 2.0) -> FloatArray:
    """Centroids of red, blue and yellow with the surface at a range (m) and azimuth psi towards the lens."""
    yaw = np.pi - psi
    scene = Scene.at_rest([[EYE[0] + surface_range + MARKER.radius, 0.0, yaw]])
    (triple,) = centroids(APPARATUS.render(scene, EYE), MARKER)
    return triple


def test_k_is_the_papers() -> None:
    ranges = np.linspace(0.099, 0.60, 18)
    rows = np.array([photographed(d)[1, 1] - photographed(d)[0, 1] for d in ranges])
    # Least squares of d = k / P, as the paper fits it; in its unit, cm px.
    k = 100 * np.sum(ranges / rows) / np.sum(1 / rows**2)
    assert k == pytest.approx(3193.7, rel=0.03)


@pytest.mark.parametrize(("surface_range", "published"), [(0.12, 2.0951), (0.37, 6.2095)])
def test_k1_is_the_papers(surface_range: float, published: float) -> None:
    # Away from the seam, where the stripe is in one piece and its height is linear in psi.
    degrees = np.arange(100, 261, 10)
    heights = []
    for psi in np.radians(degrees):
        triple = photographed(surface_range, psi)
        heights.append(triple[1, 1] - triple[2, 1])
    k1 = np.polyfit(heights, degrees, 1)[0]
    assert k1 == pytest.approx(published, rel=0.08)


def test_the_constants_that_the_geometry_implies_are_the_published_ones() -> None:
    constants = Constants.of(LENS, MARKER)
    assert 100 * constants.k == pytest.approx(3193.7, rel=0.01)
    assert np.degrees(constants.k1 * 0.12) == pytest.approx(2.0951, rel=0.02)
    assert np.degrees(constants.k1 * 0.37) == pytest.approx(6.2095, rel=0.04)
    assert np.degrees(constants.k2) == pytest.approx(95.8, abs=2.0)  # published: 97.2 to 94.4
