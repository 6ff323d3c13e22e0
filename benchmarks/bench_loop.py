"""What one turn of the loop costs: drawing a picture, spoiling it, reading it, by each method.

Run with ``make bench``. Figures are for comparison within one run; nothing here asserts a time.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.config.arena import ARENAS
from swarmvision.config.camera import LENSES
from swarmvision.config.imperfections import IMPERFECTIONS
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.rendering.raycast import Raycaster

LENS, ROBOT = Lens.from_config(LENSES["pi-v1"]), RobotConfig()
LENS_POSE = np.array([0.04, 0.0, 0.0])
SCENE = Scene.at_rest(
    [[0, 0, 0], [0.35, 0.1, 1], [0.5, -0.12, 2], [0.7, 0.15, 3], [0.9, -0.3, 4], [1.2, 0.05, 5]]
)


@pytest.fixture(scope="module")
def raycaster() -> Raycaster:
    return Raycaster(LENS, ROBOT, ARENAS["open"])


def bench_render(benchmark: Any, raycaster: Raycaster) -> None:
    out = raycaster.render(SCENE, LENS_POSE, 0)
    benchmark(raycaster.render, SCENE, LENS_POSE, 0, out)


def bench_imperfections(benchmark: Any, raycaster: Raycaster) -> None:
    faults = Imperfections(IMPERFECTIONS["pi-v1"], LENS)
    benchmark(faults.spoil, raycaster.render(SCENE, LENS_POSE, 0), 1, 0.5)


@pytest.mark.parametrize("method", ["edges", "fit", "moments"])
def bench_read(benchmark: Any, raycaster: Raycaster, method: str) -> None:
    picture = raycaster.render(SCENE, LENS_POSE, 0)
    benchmark(Reader(LENS, Marker.from_config(ROBOT.marker), method).read, picture)
