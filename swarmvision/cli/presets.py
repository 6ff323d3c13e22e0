"""Cameras, markers and boards by the names and files that a user gives."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmvision.errors import ConfigError, unknown_name

if TYPE_CHECKING:
    from swarmvision.camera import Lens
    from swarmvision.config.board import BoardConfig
    from swarmvision.config.camera import LensConfig
    from swarmvision.config.marker import MarkerConfig
    from swarmvision.marker import Marker


def lens_of(name: str) -> Lens:
    """Return the lens of a camera file or preset.

    Raises:
        ConfigError: If there is none, or it is wrong; so for all of these.
    """
    from swarmvision.camera import Lens

    return Lens.from_config(camera_config(name))


def camera_config(name: str) -> LensConfig:
    """Return the settings of a camera file or preset."""
    from swarmvision.config.camera import LENSES, LensConfig

    config: LensConfig = _file_or_preset("camera", name, LENSES, LensConfig)
    return config


def marker_of(name: str) -> Marker:
    """Return the marker of a marker file or preset."""
    from swarmvision.marker import Marker

    return Marker.from_config(marker_config(name))


def marker_config(name: str) -> MarkerConfig:
    """Return the settings of a marker file or preset."""
    from swarmvision.config.marker import PRESETS, MarkerConfig

    config: MarkerConfig = _file_or_preset("marker", name, PRESETS, MarkerConfig)
    return config


def board_config(path: Path) -> BoardConfig:
    """Return the settings of a board file."""
    from swarmvision.config.board import BoardConfig
    from swarmvision.config.model import read_toml, validated

    return validated(BoardConfig, read_toml(path), str(path))


def _file_or_preset(kind: str, name: str, presets: dict[str, Any], model: Any) -> Any:
    from swarmvision.config.model import read_toml, validated

    if name in presets:
        return presets[name]
    path = Path(name)
    if not path.exists() and path.suffix != ".toml":
        raise ConfigError(unknown_name(kind, name, presets) + ", or a TOML file")
    return validated(model, read_toml(path), name)
