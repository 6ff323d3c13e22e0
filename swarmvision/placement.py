"""Where robots stand when a run begins: random places that do not touch."""

from __future__ import annotations

import math

import numpy as np

from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.scenario import ScenarioConfig, StartConfig
from swarmvision.data import Scene
from swarmvision.errors import ConfigError
from swarmvision.geometry import FloatArray, wrap

TRIES_PER_ROBOT = 200


def starting_scene(scenario: ScenarioConfig, rng: np.random.Generator) -> Scene:
    """Return robots at random places that do not touch, and the objects where the arena has them.

    Team after team; random places are tried first, and where they run out, the sites of a hexagonal lattice
    are dealt.

    Raises:
        ConfigError: If the robots do not fit.
    """
    places, yaws = np.empty((0, 2)), np.empty(0)
    starts = [scenario.start, *(team.start or scenario.start for team in scenario.teams)]
    for count, start in zip(scenario.team_sizes, starts, strict=True):
        places = np.vstack([places, _placed(scenario, start, count, places, rng)])
        spread = math.radians(start.heading_spread_deg)
        yaws = np.append(yaws, rng.uniform(-spread, spread, count))
    objects = [(thing.x, thing.y, math.radians(thing.yaw_deg)) for thing in scenario.arena.objects]
    return Scene.at_rest(np.column_stack([places, wrap(yaws)]), objects)


def _placed(
    scenario: ScenarioConfig, start: StartConfig, count: int, taken: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Return places ``(count, 2)`` for robots of one team, clear of those that are taken ``(n, 2)``."""
    robot = scenario.robot
    diagonal = math.hypot(robot.length, robot.width)
    spacing = max(start.spacing, diagonal)
    free = _FreeGround(scenario.arena, start, diagonal / 2.0)
    places = _scattered(free, count, spacing, taken, rng)
    if places is not None:
        return places
    sites = free.lattice(spacing)
    sites = sites[[bool((np.hypot(*(taken - site).T) >= spacing).all()) for site in sites]]
    if len(sites) < count:
        ground = f"{scenario.arena.width:g} x {scenario.arena.depth:g} m arena"
        if start.radius is not None:
            ground = f"starting circle of {start.radius:g} m radius in the {ground}"
        raise ConfigError(
            f"scenario {scenario.name!r}: {count} robots do not fit the {ground}; "
            f"about {len(sites)} do, {spacing:.3g} m apart"
        )
    return rng.permutation(sites)[:count]


class _FreeGround:
    """Where a robot's axis may be: inside the walls and the starting circle, clear of objects."""

    def __init__(self, arena: ArenaConfig, start: StartConfig, margin: float) -> None:
        self._arena = arena
        self._margin = margin
        self._start = start
        far = np.array([arena.width, arena.depth]) / 2.0 - margin
        self.low, self.high = np.minimum(-far, 0.0), np.maximum(far, 0.0)
        if start.radius is not None:
            centre = np.array([start.x, start.y])
            self.low = np.maximum(self.low, centre - start.radius)
            self.high = np.maximum(np.minimum(self.high, centre + start.radius), self.low)

    def has(self, x: float, y: float) -> bool:
        if abs(x) > self._arena.width / 2.0 - self._margin or abs(y) > self._arena.depth / 2.0 - self._margin:
            return False
        start = self._start
        if start.radius is not None and math.hypot(x - start.x, y - start.y) > start.radius:
            return False
        return all(
            math.hypot(x - thing.x, y - thing.y) > _reach_of(thing) + self._margin
            for thing in self._arena.objects
        )

    def lattice(self, spacing: float) -> FloatArray:
        """Return the sites of a hexagonal lattice that are free, shape ``(sites, 2)``."""
        row_height = spacing * math.sqrt(3.0) / 2.0
        rows = [math.floor(self.low[1] / row_height), math.ceil(self.high[1] / row_height)]
        columns = [math.floor(self.low[0] / spacing) - 1, math.ceil(self.high[0] / spacing)]
        sites = [
            ((column + (row % 2) / 2.0) * spacing, row * row_height)
            for row in range(rows[0], rows[1] + 1)
            for column in range(columns[0], columns[1] + 1)
        ]
        return np.array([site for site in sites if self.has(*site)], dtype=np.float64).reshape(-1, 2)


def _reach_of(thing: BoxConfig | DiscConfig) -> float:
    if isinstance(thing, DiscConfig):
        return thing.radius
    return math.hypot(thing.length, thing.width) / 2.0


def _scattered(
    free: _FreeGround, robots: int, spacing: float, taken: FloatArray, rng: np.random.Generator
) -> FloatArray | None:
    places = taken
    for _ in range(TRIES_PER_ROBOT * robots):
        if len(places) == len(taken) + robots:
            break
        x, y = rng.uniform(free.low, free.high)
        if free.has(x, y) and (np.hypot(*(places - (x, y)).T) >= spacing).all():
            places = np.vstack([places, (x, y)])
    return places[len(taken) :] if len(places) == len(taken) + robots else None
