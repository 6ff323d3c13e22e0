"""Scenarios, laws, cameras, markers and boards by the names and files that a user gives."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmvision.errors import ConfigError, unknown_name

if TYPE_CHECKING:
    from swarmvision.camera import Lens
    from swarmvision.config.board import BoardConfig
    from swarmvision.config.camera import LensConfig
    from swarmvision.config.marker import MarkerConfig
    from swarmvision.config.scenario import ScenarioConfig
    from swarmvision.marker import Marker


def scenario_of(name: str, law: str | None, overrides: Sequence[str]) -> ScenarioConfig:
    """Return a scenario by its file or its packaged name; a file goes first.

    Args:
        name: Whose.
        law: Of all robots, by name or as ``my.module:law``; ``None`` for the scenario's own.
        overrides: As ``robots=4``.

    Raises:
        ConfigError: If there is none, or it is wrong; so for all of these.
    """
    from swarmvision.config.scenario import load_scenario, packaged_scenario, packaged_scenarios

    changes = [*([_law_override(law)] if law else []), *overrides]
    path = Path(name)
    if path.exists() or (path.suffix == ".toml" and name not in packaged_scenarios()):
        return load_scenario(path, changes)
    return packaged_scenario(name, changes)


def lens_of(name: str) -> Lens:
    """Return the lens of a camera file or preset."""
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


def _law_override(name: str) -> str:
    """Return the override that chooses a law: ours by its name, else one by module or entry point."""
    from swarmvision.controllers import LAWS

    if name in LAWS:
        return f'controller={{law="{name}"}}'
    if ":" not in name:
        from swarmvision.controllers.custom import registered_laws

        if name not in (registered := registered_laws()):
            raise ConfigError(
                f"{unknown_name('controller', name, [*LAWS, *registered])}; or package.module:law"
            )
    sys.path.insert(0, "")  # as for a script: a module in the current folder is found
    return f'controller={{law="custom", target="{name}"}}'
