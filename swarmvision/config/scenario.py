"""The scenario file: everything that one run needs but its seed, and the door through which it comes in."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from swarmvision.config.arena import ARENAS, ArenaConfig, Place
from swarmvision.config.controller import ControllerConfig, KobotConfig, LayerConfig
from swarmvision.config.model import Settings, read_toml, validated
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import CameraSensorConfig, ProximityConfig, SensorConfig
from swarmvision.errors import ConfigError, unknown_name


class StartConfig(Settings):
    """Where the robots stand when the run begins: random places that do not touch."""

    x: Place = 0.0
    """Centre of the starting circle (m)."""

    y: Place = 0.0
    """Centre of the starting circle (m)."""

    radius: Annotated[float, Field(gt=0, le=100)] | None = None
    """Robots start inside a circle of this radius (m); anywhere where not given."""

    spacing: Annotated[float, Field(ge=0, le=10)] = 0.16
    """Least distance between two robots' axes (m)."""

    heading_spread_deg: Annotated[float, Field(ge=0, le=180)] = 180.0
    """Headings are drawn evenly from plus or minus this about x (deg)."""


class GoalConfig(Settings):
    """A place that robots are to reach; some of them know where it is."""

    x: Place
    """m"""

    y: Place
    """m"""

    radius: Annotated[float, Field(gt=0, le=100)] = 0.5
    """Within this of it, the goal is reached (m)."""

    occlusion: bool = False
    """Whether things that are tall enough to hide a marker hide the goal, too."""

    informed: Annotated[float, Field(ge=0, le=1)] = 1.0
    """Fraction of the robots, the first ones, that know its direction and range."""


class TeamConfig(Settings):
    """Robots that differ from the others in law or senses."""

    name: str = Field(min_length=1, max_length=40)
    """What they are called."""

    count: Annotated[int, Field(ge=1, le=10_000)]
    """How many of the scenario's robots, counted from the last."""

    controller: ControllerConfig
    """What they do."""

    layers: tuple[LayerConfig, ...] = ()
    """What lies under their law, the lowest last."""

    sensor: SensorConfig | None = None
    """How they sense; as the others where not given."""

    start: StartConfig | None = None
    """Where they begin; as the others where not given."""


class ScenarioConfig(Settings):
    """One experiment."""

    name: str = "flocking"
    """What it is called."""

    description: str = ""
    """One line."""

    robots: Annotated[int, Field(ge=0, le=10_000)] = 8
    """How many."""

    seconds: Annotated[float, Field(gt=0, le=1e6)] = 60.0
    """Simulated time (s)."""

    control_hz: Annotated[float, Field(ge=1, le=1000)] = 10.0
    """Control steps per second."""

    physics_substeps: Annotated[int, Field(ge=1, le=1000)] = 12
    """Physics steps in one control step."""

    measure: Literal["flocking", "aggregation", "milling", "lattice", "chain", "herding", "transport"] = (
        "flocking"
    )
    """What the outcome tells; flocking links robots within 0.5 m into a cluster, all else within 1.5 body
    diagonals."""

    arena: ArenaConfig = ARENAS["open"]
    """A preset's name (open, paper) or its settings."""

    robot: RobotConfig = RobotConfig()
    """Every robot."""

    start: StartConfig = StartConfig()
    """Where they begin."""

    sensor: SensorConfig = CameraSensorConfig()
    """How they sense each other."""

    proximity: ProximityConfig | None = None
    """The infrared ring of every robot; none where not given."""

    controller: ControllerConfig = KobotConfig()
    """What they do."""

    layers: tuple[LayerConfig, ...] = ()
    """What lies under their law, the lowest last."""

    goal: GoalConfig | None = None
    """Where they are to go."""

    teams: tuple[TeamConfig, ...] = ()
    """Robots that are otherwise: the last ones, team after team; all before them are the main team."""

    @property
    def team_sizes(self) -> tuple[int, ...]:
        """Robots of the main team and of each further one; they stand in this order."""
        others = tuple(team.count for team in self.teams)
        return (self.robots - sum(others), *others)

    @property
    def with_common_sensor(self) -> tuple[int, ...]:
        """Numbers of the robots that see by the scenario's own sensor, not by one of their team's."""
        sensors = (None, *(team.sensor for team in self.teams))
        own = [
            sensor is not None
            for sensor, size in zip(sensors, self.team_sizes, strict=True)
            for _ in range(size)
        ]
        return tuple(robot for robot, has_own in enumerate(own) if not has_own)

    @model_validator(mode="after")
    def _teams_fit(self) -> ScenarioConfig:
        if self.team_sizes[0] < 0:
            raise ValueError(
                f"robots must be at least those of its teams, {sum(self.team_sizes[1:])}, got {self.robots}"
            )
        return self

    @property
    def steps(self) -> int:
        """How many control steps the scenario lasts."""
        return max(round(self.seconds * self.control_hz), 1)

    @field_validator("arena", mode="before")
    @classmethod
    def _arena_preset(cls, value: object) -> object:
        if not isinstance(value, str):
            return value
        if value not in ARENAS:
            raise ConfigError(unknown_name("arena", value, ARENAS))
        return ARENAS[value]


def packaged_scenarios() -> dict[str, str]:
    """Return the name and the description of every scenario that ships with the package."""
    folder = resources.files("swarmvision.scenarios")
    files = [file.name for file in folder.iterdir() if file.name.endswith(".toml")]
    names = sorted(file.removesuffix(".toml") for file in files)
    return {name: tomllib.loads((folder / f"{name}.toml").read_text())["description"] for name in names}


def packaged_scenario(name: str, overrides: Sequence[str] = ()) -> ScenarioConfig:
    """Return a scenario that ships with the package.

    Raises:
        ConfigError: If there is none of that name, or an override is wrong.
    """
    known = packaged_scenarios()
    if name not in known:
        raise ConfigError(unknown_name("scenario", name, known))
    text = (resources.files("swarmvision.scenarios") / f"{name}.toml").read_text()
    return _scenario(tomllib.loads(text), overrides, name)


def load_scenario(path: Path, overrides: Sequence[str] = ()) -> ScenarioConfig:
    """Return the scenario in a TOML file.

    Args:
        path: The file.
        overrides: ``key=value`` with dots for nesting and a TOML value, as ``robots=4``,
            ``sensor.latency=0.1``; a value that is not TOML is taken as text.

    Raises:
        ConfigError: One line that names file, field, rule and value.
    """
    return _scenario(read_toml(path), overrides, str(path))


def _scenario(values: dict[str, Any], overrides: Sequence[str], source: str) -> ScenarioConfig:
    for override in overrides:
        _override(values, override)
    return validated(ScenarioConfig, values, source)


def _override(values: dict[str, Any], override: str) -> None:
    key, separator, text = override.partition("=")
    if not separator or not key.strip():
        raise ConfigError(f"an override must read key=value, got {override!r}")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        value = text.strip()
    *path, last = key.strip().split(".")
    table = values
    for part in path:
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            raise ConfigError(f"override {override!r}: {part!r} is a value, it has no settings inside")
    table[last] = value
