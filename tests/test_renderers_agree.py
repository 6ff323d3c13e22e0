"""Two renderers that share nothing but colours draw the same scenes."""

from __future__ import annotations

import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.colour import decode
from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.camera import LENSES
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.marker import Marker
from swarmvision.perception.segment import Hues, classify
from swarmvision.rendering.mesh import MeshRenderer
from swarmvision.rendering.raycast import Raycaster

LENS, ROBOT = Lens.from_config(LENSES["pi-v1"]), RobotConfig()
ARENA = ArenaConfig(width=3.4, depth=3.4, objects=(BoxConfig(x=1.2, y=0.9), DiscConfig(x=1.1, y=-0.8)))
MARKER = Marker.from_config(ROBOT.marker)
HUES = Hues.of(MARKER)
WHITE = np.ones(3, dtype=np.float32)


def random_scene(seed: int) -> Scene:
    """One to five robots before the lens of robot 0, 0.17 m apart at least, at any heading."""
    rng = np.random.default_rng(seed)
    places: list[np.ndarray] = []
    wanted = rng.integers(1, 6)
    while len(places) < wanted:
        distance, bearing = rng.uniform(0.17, 1.4), rng.uniform(-0.45, 0.45)
        place = np.array([distance * np.cos(bearing), distance * np.sin(bearing)])
        if all(np.hypot(*(place - other)) > 0.17 for other in places):
            places.append(place)
    yaw = rng.uniform(-np.pi, np.pi, wanted)
    return Scene.at_rest([[-0.04, 0, 0], *np.column_stack([places, yaw])], [[1.2, 0.9, 0.4], [1.1, -0.8, 0]])


def test_markers_cover_the_same_pixels_and_rings_have_the_same_middles() -> None:
    raycaster, mesh = Raycaster(LENS, ROBOT, ARENA), MeshRenderer(LENS, ROBOT, ARENA)
    both, either = 0, 0
    offsets, differences = [], []
    ring_classes = [HUES.number(MARKER.bands[0].colour), HUES.number(MARKER.bands[-1].colour)]
    for seed in range(100):
        scene = random_scene(seed)
        pictures = [renderer.render(scene, np.zeros(3), 0) for renderer in (raycaster, mesh)]
        one, two = (classify(decode(picture) / WHITE, HUES.chroma) for picture in pictures)
        both += int(np.count_nonzero((one == two) & (one > 0)))
        either += int(np.count_nonzero((one > 0) | (two > 0)))
        differences.append(np.abs(pictures[0].astype(int) - pictures[1]).mean())
        for ring in ring_classes:
            middles = [np.argwhere(classes == ring).mean(axis=0) for classes in (one, two)]
            offsets.append(float(np.hypot(*(middles[0] - middles[1]))))
    assert both / either >= 0.97
    assert np.median(offsets) <= 0.2
    assert np.mean(differences) <= 0.3  # grey levels of 255


@pytest.mark.parametrize("renderer", [Raycaster, MeshRenderer])
def test_the_floor_has_its_colour_and_the_observer_is_not_drawn(
    renderer: type[Raycaster] | type[MeshRenderer],
) -> None:
    drawing = renderer(LENS, ROBOT, ArenaConfig())
    empty = drawing.render(Scene.at_rest(np.zeros((0, 3))), np.zeros(3))
    alone = drawing.render(Scene.at_rest([[0, 0, 0]]), np.zeros(3), 0)
    np.testing.assert_array_equal(empty, alone)
    # 220 (dc) in linear light 0.7157, times 0.78 + 0.3 sin(0.9) = 1.015: 0.7264, which is 221.5.
    np.testing.assert_allclose(alone[-5, 320, 0], 221.5, atol=1)


@pytest.mark.parametrize("renderer", [Raycaster, MeshRenderer])
def test_a_marker_stands_where_the_pinhole_puts_it(renderer: type[Raycaster] | type[MeshRenderer]) -> None:
    # Axis 0.5 m ahead: the near surface is 0.48 m away. Red begins 115 mm up, 30 mm over the lens:
    # row 230 - 634.6 * 0.03 / 0.48 = 190.34; blue ends at 230 + 39.66 = 269.66.
    image = renderer(LENS, ROBOT, ArenaConfig()).render(Scene.at_rest([[0.5, 0, 0.0]]), np.zeros(3))
    column = image[:, 320].astype(int)
    red = np.flatnonzero((column[:, 0] > 120) & (column[:, 1] < 100))
    blue = np.flatnonzero((column[:, 2] > 100) & (column[:, 0] < 90))
    # The two border pixels are red and blue by two thirds: a mask may take them or not.
    assert red[0] in (190, 191)
    assert blue[-1] in (268, 269)
    # The nose looks away, so azimuth pi faces the lens: the stripe's middle is at 13.6 + 16.4 = 30 mm,
    # level with the lens, and it rises to the right.
    yellow = (image[..., 0].astype(int) > 150) & (image[..., 2] < 110) & (image[..., 1] > 120)
    assert abs(np.flatnonzero(yellow[:, 320]).mean() + 0.5 - 230) < 1.0
    assert np.flatnonzero(yellow[:, 335]).mean() < np.flatnonzero(yellow[:, 305]).mean()
