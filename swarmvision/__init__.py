"""A multi-robot swarm simulator with embedded perception.

The public names; each is imported when it is first used, so that a robot may import
``swarmvision.perception`` with NumPy and OpenCV alone and ``swarmvision --help`` answers at once.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any

_HOMES = {
    "Commands": "swarmvision.data",
    "Estimates": "swarmvision.data",
    "Lens": "swarmvision.camera",
    "Marker": "swarmvision.marker",
    "Raycaster": "swarmvision.rendering.raycast",
    "Reader": "swarmvision.perception",
    "Rig": "swarmvision.camera",
    "ScenarioConfig": "swarmvision.config.scenario",
    "Scene": "swarmvision.data",
    "Simulation": "swarmvision.simulation",
    "SwarmVisionError": "swarmvision.errors",
    "Tracker": "swarmvision.perception.track",
    "World": "swarmvision.world",
}

__all__ = [*_HOMES, "__version__"]  # noqa: PLE0604 - strings, as the test of the public names checks

try:
    __version__ = version("swarmvision")
except PackageNotFoundError:  # a bare checkout that was never installed
    __version__ = "0+unknown"


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'swarmvision' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return __all__
