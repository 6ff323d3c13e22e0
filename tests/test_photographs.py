"""Photographs by a path tracer that shares no code with this project, if they are at hand.

They do not ship. Where they are absent, the same measures are taken on our own ray caster's pictures
and the test's name says so.
"""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from grain import add_noise

from swarmvision.camera import Lens
from swarmvision.config.arena import ARENAS
from swarmvision.config.camera import LENSES
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import TruthSensorConfig
from swarmvision.data import Estimates, Scene
from swarmvision.geometry import FloatArray, compose, inverse, polar, wrap
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.rendering.raycast import Raycaster
from swarmvision.sensing.truth import TruthSensor

PHOTOGRAPHS = Path(__file__).parent.parent.parent / "shared" / "photos"
LENS = Lens.from_config(LENSES["pi-v1"])
ROBOT = RobotConfig()
READER = Reader(LENS, Marker.from_config(ROBOT.marker))

Judged = tuple[Estimates, FloatArray]
"""What was read, and the truth ``(n, 4)``: range, bearing, heading, visible fraction."""


def photographs() -> list[Judged]:
    truth = json.loads((PHOTOGRAPHS / "truth.json").read_text())
    judged = []
    for frame in truth["frames"]:
        image = cv2.imread(str(PHOTOGRAPHS / frame["image"]))
        assert image is not None
        robots = [[r["range"], r["bearing"], r["heading"], r["visible"]] for r in frame["robots"]]
        judged.append((READER.read(np.ascontiguousarray(image[..., ::-1])), np.array(robots)))
    return judged


def our_own() -> list[Judged]:
    raycaster, judged = Raycaster(LENS, ROBOT, ARENAS["open"]), []
    sensor = TruthSensor(TruthSensorConfig(fov_deg=360), ROBOT, ARENAS["open"])
    for seed in range(24):
        rng = np.random.default_rng(seed)
        distance, bearing = np.array([0.2, 0.45, 0.9]) * rng.uniform(0.8, 1.2, 3), rng.uniform(-0.4, 0.4, 3)
        ahead, aside = distance * np.cos(bearing), distance * np.sin(bearing)
        places = np.column_stack([ahead, aside, rng.uniform(-3, 3, 3)])
        eye = np.zeros(3)
        scene = Scene.at_rest(np.vstack([eye, places]))
        image = raycaster.render(scene, eye, 0)
        add_noise(image, 2.0, seed)
        visible = sensor.sense(scene).visible[0]
        true = np.column_stack([*polar(compose(inverse(eye), places)), visible])
        judged.append((READER.read(image), true))
    return judged


def errors(judged: list[Judged]) -> tuple[FloatArray, int, int]:
    """Errors ``(n, 3)`` of what was found up to 1 m (relative, rad, rad), how many there are, phantoms."""
    rows, wanted, phantoms = [], 0, 0
    for estimates, truth in judged:
        free = set(range(len(estimates.seen)))
        for distance, bearing, heading, visible in truth:
            match = next(
                (
                    i
                    for i in sorted(free)
                    if abs(wrap(estimates.bearing[i] - bearing)) < np.radians(3)
                    and abs(estimates.range[i] / distance - 1) < 0.25
                ),
                None,
            )
            counts = visible >= 0.5 and distance < 1.0
            wanted += counts
            if match is None:
                continue
            free.remove(match)
            if counts:
                rows.append(
                    (
                        abs(estimates.range[match] / distance - 1),
                        abs(wrap(estimates.bearing[match] - bearing)),
                        abs(wrap(estimates.heading[match] - heading)),
                    )
                )
        phantoms += len(free)
    return np.array(rows), wanted, phantoms


SOURCES = [photographs] if PHOTOGRAPHS.exists() else []


@pytest.mark.parametrize("source", [*SOURCES, our_own], ids=lambda source: source.__name__)
def test_reads_independent_pictures_to_a_metre(source: object) -> None:
    assert callable(source)
    rows, wanted, phantoms = errors(source())
    middle = np.median(rows, axis=0)
    assert len(rows) >= 0.9 * wanted
    assert wanted > 30
    assert phantoms == 0
    assert middle[0] <= 0.005
    assert middle[1] <= np.radians(0.05)
    assert middle[2] <= np.radians(1.5)
