"""What is photographed: arenas with a given number of neighbours in view, tags, swarms of one density."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.config.arena import ARENAS
from swarmvision.config.camera import LENSES, RIGS
from swarmvision.config.imperfections import IMPERFECTIONS, ImperfectionsConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.scenario import ScenarioConfig, StartConfig, packaged_scenario
from swarmvision.data import Scene
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker

Image = NDArray[np.uint8]

LENS, ROBOT, ARENA = Lens.from_config(LENSES["pi-v1"]), RobotConfig(), ARENAS["open"]
MARKER = Marker.from_config(ROBOT.marker)
LENS_POSE = np.array([RIGS["single"].forward, 0.0, 0.0])
VIEWS = 16  # lens poses that are drawn in turn, for a processor learns one picture by heart,
SWAY = np.radians(2.0)  # either way, and every neighbour is still whole
LENS_POSES = LENS_POSE + np.column_stack(
    [np.zeros((VIEWS, 2)), np.random.default_rng(VIEWS).uniform(-SWAY, SWAY, VIEWS)]
)
READ = 5  # neighbours in the picture that is read
DRAWN = 8  # neighbours in the picture that is drawn
TURN_RATE = 0.5  # rad/s; of the lens, so that motion blur and rolling shutter have work to do
HALF_VIEW = np.radians(22.0)  # neighbours stand within this of the axis, so that all of them are whole
NEAREST, FARTHEST = 0.3, 1.1  # m; of up to ``DRAWN`` neighbours
TRIES = 200  # places tried for one neighbour before all are placed anew
DENSITY = 8 / (np.pi * 0.6**2)  # robots per m^2 at the start of the flocking demo
ROOM = 2.2  # widths of an arena over the radius of the circle where robots begin, at least
RATE = 32.0  # Hz; of camera and control, as the paper's camera
SUBSTEPS = 4  # of physics in a control step: 128 Hz
NOISE = IMPERFECTIONS["none"].model_copy(
    update={
        "white_electrons": IMPERFECTIONS["pi-v1"].white_electrons,
        "read_noise": IMPERFECTIONS["pi-v1"].read_noise,
    }
)
"""The sensor's noise and nothing else."""


def punctual(config: ImperfectionsConfig) -> ImperfectionsConfig:
    """Return the same camera without lost or late pictures, so that pictures can be counted."""
    return config.model_copy(update={"dropped": 0.0, "late": 0.0})


def lens_of(width_px: int) -> Lens:
    """Return the Pi camera with another number of pixels and the same view."""
    scale = width_px / LENS.width_px
    column, row = LENS.centre_px
    return replace(
        LENS,
        width_px=width_px,
        height_px=round(LENS.height_px * scale),
        focal_px=LENS.focal_px * scale,
        centre_px=(column * scale, row * scale),
    )


@lru_cache(maxsize=64)
def in_view(neighbours: int) -> Scene:
    """Return an observer at the origin and so many neighbours that a lens at ``LENS_POSE`` sees.

    Up to ``DRAWN`` none hides another; more than those stand farther away and overlap.
    """
    rng = np.random.default_rng(neighbours)
    farthest = FARTHEST * max(1.0, np.sqrt(neighbours / DRAWN))
    places, tries = np.empty((0, 3)), 0
    while len(places) < neighbours:
        distance = np.sqrt(rng.uniform(NEAREST**2, farthest**2))
        place = np.array([distance, rng.uniform(-HALF_VIEW, HALF_VIEW), rng.uniform(-np.pi, np.pi)])
        tries += 1
        if _is_clear(place, places, apart=neighbours <= DRAWN):
            places, tries = np.vstack([places, place]), 0
        elif tries > TRIES:
            places, tries = np.empty((0, 3)), 0
    x = LENS_POSE[0] + places[:, 0] * np.cos(places[:, 1])
    y = places[:, 0] * np.sin(places[:, 1])
    return Scene.at_rest(np.vstack([np.zeros((1, 3)), np.column_stack([x, y, places[:, 2]])]))


def _is_clear(place: FloatArray, places: FloatArray, *, apart: bool) -> bool:
    """Return whether a place (m, rad, rad) touches none of the others and, if asked, hides none."""
    towards = np.exp(1j * places[:, 1]) * places[:, 0] - np.exp(1j * place[1]) * place[0]
    if (np.abs(towards) < 1.5 * ROBOT.length).any():
        return False
    room = 1.2 * MARKER.radius * (1.0 / place[0] + 1.0 / places[:, 0])
    return not apart or bool((np.abs(places[:, 1] - place[1]) > room).all())


def with_tags(background: Image, scene: Scene, tags: list[Image]) -> Image:
    """Return a picture with a tag where each neighbour's marker would be, facing the lens.

    A tag is as wide as the marker, with a white margin of one of its modules.

    Args:
        background: sRGB of the empty arena, shape ``(h, w, 3)``.
        scene: Whose neighbours give the places.
        tags: Grey, square, one module a pixel, black border included.
    """
    picture = background.copy()
    for tag, pose in zip(tags, scene.pose[1:], strict=True):
        depth, left = pose[0] - LENS_POSE[0], pose[1]
        size = max(round(LENS.focal_px * 2.0 * MARKER.radius / depth / len(tag)), 1) * len(tag)
        module = size // len(tag)
        card = np.pad(np.kron(tag, np.ones((module, module), np.uint8)), module, constant_values=255)
        column = round(float(LENS.centre_px[0] - LENS.focal_px * left / depth) - len(card) / 2.0)
        height = MARKER.base + (MARKER.bands[0].top + MARKER.bands[-1].bottom) / 2.0
        row = round(float(LENS.row_from_rise((height - LENS.height) / depth)) - len(card) / 2.0)
        picture[row : row + len(card), column : column + len(card)] = card[:, :, None]
    return picture


def swarm(robots: int, sensor: dict[str, Any], density: float = DENSITY) -> ScenarioConfig:
    """Return the flocking demo with so many robots, camera and control at 32 Hz.

    Args:
        robots: How many.
        sensor: Settings of their sensor.
        density: Robots per m^2 of the circle they start in; the arena is the demo's, or as wide as they need.
    """
    demo = packaged_scenario("flocking")
    values = demo.model_dump(exclude={"sensor", "start", "arena"})
    radius = float(np.sqrt(robots / density / np.pi))
    arena = demo.arena.model_dump()
    arena |= {side: max(arena[side], ROOM * radius) for side in ("width", "depth")}
    return ScenarioConfig.model_validate(
        {
            **values,
            "robots": robots,
            "start": StartConfig(radius=radius),
            "arena": arena,
            "sensor": sensor,
            "control_hz": RATE,
            "physics_substeps": SUBSTEPS,
        }
    )


def one_camera() -> dict[str, Any]:
    """Return the settings of one Pi camera a robot at 32 Hz that loses no picture."""
    return {
        "kind": "camera",
        "lens": "pi-v1",
        "rig": "single",
        "rate_hz": RATE,
        "imperfections": punctual(IMPERFECTIONS["pi-v1"]),
    }
