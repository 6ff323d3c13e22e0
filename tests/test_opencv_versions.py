"""OpenCV 4 and OpenCV 5 read the same numbers out of the same pictures."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.config.arena import ARENAS
from swarmvision.config.camera import LENSES
from swarmvision.config.imperfections import IMPERFECTIONS
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.rendering.raycast import Raycaster

OLDER = Path(sys.prefix) / "opencv4"
"""Where ``make venv`` puts it."""

READ = """
import sys
import cv2, numpy as np
from swarmvision.camera import Lens
from swarmvision.config.robot import RobotConfig
from swarmvision.marker import Marker
from swarmvision.perception import Reader

assert cv2.__version__.startswith(sys.argv[1] + "."), cv2.__version__
pictures = np.load(sys.argv[2])
marker = Marker.from_config(RobotConfig().marker)
for bend in (0.0, -0.12):
    lens = Lens(640, 460, 634.6, (320.0, 230.0), 0.085, (bend, 0.02, 0.0, 0.0, 0.0))
    for method in ("edges", "fit", "moments"):
        reader = Reader(lens, marker, method)
        for picture in pictures:
            told = reader.read(picture)
            for row in zip(told.range, told.bearing, told.heading):
                print(method, bend, *(repr(float(value)) for value in row))
"""


def numbers(major: int, pictures: Path, folder: Path | None) -> list[list[str]]:
    path = [str(folder)] if folder is not None else []
    known = os.environ.get("PYTHONPATH")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([*path, *([known] if known else [])])}
    done = subprocess.run(
        [sys.executable, "-c", READ, str(major), str(pictures)],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
    )
    assert done.returncode == 0, done.stderr
    return [line.split() for line in done.stdout.splitlines()]


@pytest.mark.skipif(
    not OLDER.exists() and "CI" not in os.environ,
    reason="OpenCV 4 stands beside the environment only where `make venv` made it",
)
def test_both_major_versions_read_the_same(tmp_path: Path) -> None:
    lens = Lens.from_config(LENSES["pi-v1"])
    render = Raycaster(lens, RobotConfig(), ARENAS["open"]).render
    pictures = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        distance, bearing = np.array([0.25, 0.45, 0.8]), rng.uniform(-0.3, 0.3, 3)
        places = [distance * np.cos(bearing), distance * np.sin(bearing), rng.uniform(-3.0, 3.0, 3)]
        picture = render(Scene.at_rest(np.column_stack(places)), np.zeros(3))
        Imperfections(IMPERFECTIONS["pi-v1"], lens).spoil(picture, seed + 1, 0.2)
        pictures.append(picture)
    np.save(tmp_path / "pictures.npy", pictures)
    older = numbers(4, tmp_path / "pictures.npy", OLDER)
    newer = numbers(5, tmp_path / "pictures.npy", None)
    assert [row[:2] for row in older] == [row[:2] for row in newer]
    assert {row[0] for row in newer} == {"edges", "fit", "moments"}
    values = [np.array([row[2:] for row in rows], dtype=np.float64) for rows in (older, newer)]
    np.testing.assert_allclose(values[0], values[1], atol=1e-6)
