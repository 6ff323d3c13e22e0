"""Camera flights: what trackers believe of every neighbour, set beside the truth.

Flocks of several densities, that flock, gather or wander, are photographed by every robot; each
neighbour within reach of each observer makes one row of a record in each picture.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision.config.scenario import ScenarioConfig, packaged_scenario
from swarmvision.data import Commands, Estimates, Scene
from swarmvision.geometry import FloatArray, compose, inverse, polar, wrap
from swarmvision.metrics.perception import MATCH_BEARING, MATCH_RANGE
from swarmvision.randomness import Subsystem, stream
from swarmvision.sensing.error_model import camera_view
from swarmvision.sensing.sight import View
from swarmvision.sensing.truth import sight
from swarmvision.simulation import Simulation

REACH = 3.0  # m: how far the record goes; beyond, markers are hardly seen
TENSE = 0.3  # correlation of a wanderer's speed and turn from step to step is 1 less this


@dataclass(frozen=True, slots=True)
class Flight:
    """One of the runs that the record is made of."""

    robots: int
    radius: float
    """Of the circle in which they start (m)."""
    pilot: str
    """A law, or wander."""
    steps: int


FLIGHTS = (
    Flight(8, 0.6, "kobot", 60),
    Flight(8, 0.6, "wander", 40),
    Flight(4, 0.4, "kobot", 60),
    Flight(12, 0.6, "kobot", 40),
    Flight(12, 1.0, "kobot", 40),
    Flight(10, 1.4, "cohesion", 60),
    Flight(16, 1.6, "wander", 30),
    Flight(2, 0.3, "kobot", 60),
    Flight(8, 0.35, "wander", 60),
    Flight(10, 0.6, "ferrante", 150),
    Flight(10, 0.6, "kobot", 150),
)
"""One round; of the flocking demo's density and around it, in disorder and, the last two, in order."""

PILOTS = {"wander": 'law="kobot"', "ferrante": 'law="ferrante",anticipation=0.0'}
"""Where a pilot is not a law as it comes. Anticipation came after the error model was fitted."""

ERRORS = ("range_error", "bearing_error", "heading_error")
STDS = ("range_std", "bearing_std", "heading_std")
COLUMNS = (
    *("flight", "time", "observer", "neighbour", "range", "bearing", "visible", "turn", "state", "age"),
    *ERRORS,
    *STDS,
)
"""Of a record: one row for each neighbour within :data:`REACH` of each observer in each picture, and one for
each ghost and phantom. ``state``: 0 unseen, 1 measured, 2 remembered, 3 ghost, 4 phantom (its errors are
its range and bearing)."""

Record = NDArray[np.float64]
UNSEEN, MEASURED, REMEMBERED, GHOST, PHANTOM = range(5)


def record(
    flight: Flight,
    seed: int,
    number: int = 0,
    sensor: str = "camera",
    workers: int | None = None,
    reach: float = REACH,
) -> Record:
    """Return what robots believed against what was true in a run, shape ``(rows, columns)``.

    Args:
        flight: Who flies how.
        seed: Of the run.
        number: Of the flight, for the first column.
        sensor: ``camera``, or ``error_model`` to set against it.
        workers: Threads; change nothing.
        reach: Of the sensor (m).
    """
    simulation = Simulation(flown(flight, sensor, reach), seed, workers=workers)
    view = camera_view(simulation.scenario.robot, simulation.scenario.arena, reach)
    fly = _pilot(flight, simulation, seed)
    owners: list[dict[int, int]] = [{} for _ in range(flight.robots)]
    rows: list[tuple[float, ...]] = []
    for step in range(flight.steps):
        estimates = simulation.sense()
        found = rows_of(simulation.scene, estimates, view, owners)
        rows.extend((number, step, *row) for row in found)
        simulation.act(fly(estimates))
    return np.array(rows, dtype=np.float64).reshape(-1, len(COLUMNS))


def flown(flight: Flight, sensor: str, reach: float) -> ScenarioConfig:
    """Return the scenario of a flight, seen by a sensor of some reach (m)."""
    law = PILOTS.get(flight.pilot, f'law="{flight.pilot}"')
    return packaged_scenario(
        "flocking",
        [
            f"robots={flight.robots}",
            f"start.radius={flight.radius}",
            f"controller={{{law}}}",
            f'sensor={{kind="{sensor}",reach={reach}}}',
        ],
    )


def _pilot(flight: Flight, simulation: Simulation, seed: int) -> Callable[[Estimates], Commands]:
    if flight.pilot != "wander":
        return lambda estimates: simulation.decide(simulation.feel(estimates))
    rng = stream(seed, Subsystem.CONTROLLER)
    wish = rng.normal(size=(2, flight.robots))

    def wander(estimates: Estimates) -> Commands:
        wish[:] = (1.0 - TENSE) * wish + np.sqrt(1.0 - (1.0 - TENSE) ** 2) * rng.normal(size=wish.shape)
        return Commands(0.1 + 0.05 * wish[0], wish[1])

    return wander


def rows_of(
    scene: Scene, estimates: Estimates, view: View, owners: list[dict[int, int]]
) -> list[tuple[float, ...]]:
    """Return the rows of one instant without flight and time.

    Args:
        scene: What was true.
        estimates: What was believed then.
        view: Of the cameras; its reach is the rows'.
        owners: Of each robot, whose its tracks are; goes on from instant to instant.
    """
    r = scene.robots
    distance, bearing, heading = polar(compose(inverse(scene.pose)[:, None], scene.pose[None]))
    visible = np.zeros((r, r))
    who, seen = sight(scene.pose[None], scene.object_pose[None], view, max(r - 1, 0), least=-1.0)
    robot, slot = np.nonzero(who[0] >= 0)
    visible[robot, who[0, robot, slot]] = seen[0, robot, slot, 3]
    rows = []
    for i in range(r):
        slots = _assigned(estimates, i, distance[i], bearing[i], owners[i])
        for j in [j for j in range(r) if j != i and distance[i, j] <= view.reach]:
            mine = slots.pop(j, [])
            head = (i, j, distance[i, j], bearing[i, j], visible[i, j], scene.velocity[i, 2])
            if not mine:
                rows.append((*head, UNSEEN, *[np.nan] * 7))
            for n, k in enumerate(mine):
                aged = REMEMBERED if estimates.age[i, k] > 1e-9 else MEASURED
                rows.append(
                    (
                        *head,
                        GHOST if n else aged,
                        estimates.age[i, k],
                        estimates.range[i, k] - distance[i, j],
                        float(wrap(estimates.bearing[i, k] - bearing[i, j])),
                        float(wrap(estimates.heading[i, k] - heading[i, j])),
                        *np.sqrt(np.diag(estimates.covariance[i, k])),
                    )
                )
        for k in slots.get(-1, []):
            if estimates.age[i, k] <= 1e-9:
                place = (estimates.range[i, k], estimates.bearing[i, k])
                rows.append((i, -1, *place, 0.0, scene.velocity[i, 2], PHANTOM, 0.0, *place, *[np.nan] * 4))
    return rows


def _assigned(
    estimates: Estimates, i: int, distance: FloatArray, bearing: FloatArray, owner: dict[int, int]
) -> dict[int, list[int]]:
    """Return the slots of each neighbour, the best first; phantoms' under -1.

    Fresh estimates belong to whom they fit, the nearest fit first; a track that is remembered to whom
    it was last measured on.
    """
    fits = []
    slots = [int(k) for k in np.flatnonzero(estimates.seen[i])]
    fresh = [k for k in slots if estimates.age[i, k] <= 1e-9]
    for k in fresh:
        off = np.abs(wrap(estimates.bearing[i, k] - bearing)) / MATCH_BEARING
        scale = np.abs(estimates.range[i, k] / np.maximum(distance, 1e-9) - 1.0) / MATCH_RANGE
        fits += [
            (off[j] + scale[j], k, j)
            for j in range(len(bearing))
            if j != i and off[j] < 1.0 and scale[j] < 1.0
        ]
    found: dict[int, list[int]] = {}
    placed: set[int] = set()
    for _, k, j in sorted(fits):
        if k not in placed and j not in found:
            found[j] = [k]
            placed.add(k)
            owner[int(estimates.track[i, k])] = j
    for k in fresh:
        if k not in placed:
            owner[int(estimates.track[i, k])] = -1
            found.setdefault(-1, []).append(k)
    for k in sorted((k for k in slots if estimates.age[i, k] > 1e-9), key=lambda k: estimates.age[i, k]):
        found.setdefault(owner.get(int(estimates.track[i, k]), -1), []).append(k)
    return found
