"""What this machine has: versions, and whether each renderer draws."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec

import numpy as np

from swarmvision.camera import Lens
from swarmvision.config.arena import ARENAS
from swarmvision.config.camera import LENSES
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.errors import SwarmVisionError

PACKAGES = ("numpy", "numba", "opencv-python-headless", "pymunk", "pettingzoo", "pyrender2", "imageio-ffmpeg")


def examine() -> Iterator[tuple[str, bool, str]]:
    """Yield what was looked at, whether it is well, and what was found."""
    yield "python", True, platform.python_version()
    for package in PACKAGES:
        try:
            yield package, True, version(package)
        except PackageNotFoundError:
            yield package, package in ("pyrender2", "imageio-ffmpeg", "numba"), "not installed"
    yield "raycast renderer", *_drawn("raycast")
    yield "mesh renderer", *_drawn("mesh")
    film = "H.264 by imageio-ffmpeg" if find_spec("imageio_ffmpeg") else "MPEG-4 by OpenCV"
    yield "video", True, film


def _drawn(renderer: str) -> tuple[bool, str]:
    lens, robot, arena = Lens.from_config(LENSES["pi-v1"]), RobotConfig(), ARENAS["paper"]
    scene = Scene.at_rest([[0.0, 0.0, 0.0], [0.4, 0.0, 1.0]])
    try:
        if renderer == "raycast":
            from swarmvision.rendering.raycast import Raycaster

            image = Raycaster(lens, robot, arena).render(scene, np.zeros(3), 0)
            what = "numba" if find_spec("numba") else "plain Python"
        else:
            from swarmvision.rendering.mesh import MeshRenderer, graphics

            image = MeshRenderer(lens, robot, arena).render(scene, np.zeros(3), 0)
            what = graphics()
    except SwarmVisionError as fault:
        return False, str(fault)
    reds = int(np.count_nonzero((image[..., 0] > 120) & (image[..., 1] < 80)))
    return reds > 0, f"draws a marker by {what}"
