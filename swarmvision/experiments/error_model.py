"""The error model of the state-only sensor, fitted from camera runs.

Flocks of several densities, that flock, gather or wander, are photographed by every robot; the truth
of every neighbour within reach is set beside what the robot's tracker believes of it. The tables of
:class:`swarmvision.sensing.error_table.ErrorTable` are frequencies and quantiles of that record.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from swarmvision.config.scenario import ScenarioConfig, packaged_scenario
from swarmvision.config.sensor import CameraSensorConfig
from swarmvision.data import Commands, Estimates, Scene
from swarmvision.geometry import FloatArray, compose, inverse, polar, wrap
from swarmvision.metrics.perception import MATCH_BEARING, MATCH_RANGE
from swarmvision.randomness import Subsystem, stream
from swarmvision.sensing.error_model import camera_view
from swarmvision.sensing.error_table import AGES, DEVIATES, RANGES, TURNS, VISIBLES, ErrorTable
from swarmvision.sensing.sight import View
from swarmvision.sensing.truth import sight
from swarmvision.simulation import Simulation

REACH = 3.0  # m: how far the record goes; beyond, markers are hardly seen
ENOUGH = 300  # samples of a bin's quantiles; with fewer, its neighbours' are taken in too
ENOUGH_SHARES = 60  # samples of a bin's chances, likewise
CAMERA_HZ = 10.0  # of the scenario that is flown
TENSE = 0.3  # correlation of a wanderer's speed and turn from step to step is 1 less this


@dataclass(frozen=True, slots=True)
class Flight:
    """One of the runs that the record is made of."""

    robots: int
    radius: float
    """Of the circle in which they start (m)."""
    pilot: str
    """kobot, cohesion, or wander."""
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
)
"""One round; of the flocking demo's density and around it."""

ERRORS = ("range_error", "bearing_error", "heading_error")
STDS = ("range_std", "bearing_std", "heading_std")
COLUMNS = (
    *("flight", "time", "observer", "neighbour", "range", "bearing", "visible", "turn", "state", "age"),
    *ERRORS,
    *STDS,
)
"""Of a record: one row for each neighbour within :data:`REACH` of each observer in each picture, and one for
each ghost and phantom. ``state``: 0 unseen, 1 measured, 2 remembered, 3 ghost, 4 phantom (its errors are
its range and bearing). Errors of bearing and heading are times the sign of the observer's turn."""

Record = NDArray[np.float64]
UNSEEN, MEASURED, REMEMBERED, GHOST, PHANTOM = range(5)


def error_model_text(
    rounds: int, seed: int, workers: int | None = None, tell: Callable[[str], None] = lambda line: None
) -> str:
    """Return the text of the error model's file, from camera runs made now.

    Args:
        rounds: How often each of :data:`FLIGHTS` is flown, each time with another seed.
        seed: Of the first round.
        workers: Threads; change nothing.
        tell: Is told of every flight that is over.
    """
    records: list[Record] = []
    for n in range(rounds):
        for f, flight in enumerate(FLIGHTS):
            number = n * len(FLIGHTS) + f
            records.append(record(flight, seed + number, number, workers=workers))
            tell(f"{number + 1} of {rounds * len(FLIGHTS)}: {flight}")
    rows = np.concatenate(records)
    camera = _scenario(FLIGHTS[0], "camera", REACH).sensor
    assert isinstance(camera, CameraSensorConfig)
    lenses = len(camera.rig.yaws_deg)
    told: dict[str, Any] = {
        "command": f"swarmvision fit-error-model --rounds {rounds} --seed {seed}",
        "method": "frequencies and quantiles of what trackers believed, set beside the truth",
        "flights": [asdict(flight) for flight in FLIGHTS],
        "seeds": [seed, seed + rounds * len(FLIGHTS) - 1],
        "pictures": rounds * lenses * sum(flight.robots * flight.steps for flight in FLIGHTS),
        "neighbours": int(np.count_nonzero(rows[:, COLUMNS.index("state")] <= REMEMBERED)),
        "versions": {name: version(name) for name in ("swarmvision", "numpy", "opencv-python-headless")},
        "sensor": camera.model_dump(mode="json"),
    }
    return fit(rows).as_json(told)


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
    simulation = Simulation(_scenario(flight, sensor, reach), seed, workers=workers)
    view = camera_view(simulation.scenario.robot, simulation.scenario.arena, reach)
    fly = _pilot(flight, simulation, seed)
    owners: list[dict[int, int]] = [{} for _ in range(flight.robots)]
    rows: list[tuple[float, ...]] = []
    for step in range(flight.steps):
        estimates = simulation.sense()
        found = _rows(simulation.scene, estimates, view, owners)
        rows.extend((number, step, *row) for row in found)
        simulation.act(fly(estimates))
    return np.array(rows, dtype=np.float64).reshape(-1, len(COLUMNS))


def _scenario(flight: Flight, sensor: str, reach: float) -> ScenarioConfig:
    law = flight.pilot if flight.pilot != "wander" else "kobot"
    return packaged_scenario(
        "flocking",
        [
            f"robots={flight.robots}",
            f"start.radius={flight.radius}",
            f'controller={{law="{law}"}}',
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


def _rows(
    scene: Scene, estimates: Estimates, view: View, owners: list[dict[int, int]]
) -> list[tuple[float, ...]]:
    """Return the rows of one instant without flight and time; ``owners`` says whose the tracks are."""
    r = scene.robots
    distance, bearing, heading = polar(compose(inverse(scene.pose)[:, None], scene.pose[None]))
    visible = np.zeros((r, r))
    who, seen = sight(scene.pose[None], scene.object_pose[None], view, max(r - 1, 0), least=-1.0)
    robot, slot = np.nonzero(who[0] >= 0)
    visible[robot, who[0, robot, slot]] = seen[0, robot, slot, 3]
    rows = []
    for i in range(r):
        sign = 1.0 if scene.velocity[i, 2] >= 0.0 else -1.0
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
                        sign * float(wrap(estimates.bearing[i, k] - bearing[i, j])),
                        sign * float(wrap(estimates.heading[i, k] - heading[i, j])),
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


def fit(rows: Record) -> ErrorTable:
    """Return the tables of a record."""
    column = dict(zip(COLUMNS, rows.T, strict=True))
    state = column["state"].astype(int)
    pair = (state != GHOST) & (state != PHANTOM)
    bins = (len(RANGES) + 1, len(TURNS) + 1, len(VISIBLES) + 1)
    place = np.stack(
        [
            np.searchsorted(RANGES, column["range"], side="right"),
            np.searchsorted(TURNS, np.abs(column["turn"]), side="right"),
            np.searchsorted(VISIBLES, column["visible"], side="right"),
        ],
        axis=1,
    )
    errors = rows[:, [COLUMNS.index(name) for name in ERRORS]]
    stds = rows[:, [COLUMNS.index(name) for name in STDS]]
    scaled = errors / np.column_stack([column["range"] ** 2, np.ones((len(rows), 2))])
    moved = errors * np.column_stack([np.ones(len(rows)), column["range"], np.ones(len(rows))])
    before = _state_before(rows)
    measured = state == MEASURED
    again, anew = np.zeros(bins), np.zeros(bins)
    fresh, fresh_std = np.zeros((*bins, 3, len(DEVIATES))), np.zeros((*bins, 3))
    for index in np.ndindex(*bins):
        for table, rest in ((again, before == MEASURED), (anew, (before >= 0) & (before != MEASURED))):
            some = _pooled(place, index, pair & rest, ENOUGH_SHARES)
            table[index] = float(np.mean(measured[some])) if len(some) else 0.0
        some = _pooled(place, index, measured)
        fresh[index], fresh_std[index] = _quantiles(scaled[some]), np.sqrt(np.mean(stds[some] ** 2, axis=0))
    ages, t = np.searchsorted(AGES, column["age"], side="right"), place[:, 1]
    aged = np.zeros((len(AGES) + 1, bins[1], 3, len(DEVIATES)))
    aged_std = np.zeros(aged.shape[:3])
    ghost = np.zeros((len(AGES) + 1, 3, len(DEVIATES)))
    at = np.stack([ages, t, np.zeros_like(t)], axis=1)
    for a, turn in np.ndindex(*aged.shape[:2]):
        some = _pooled(at, (a, turn, 0), state == REMEMBERED)
        aged[a, turn], aged_std[a, turn] = _quantiles(moved[some]), np.sqrt(np.mean(stds[some] ** 2, axis=0))
    for a in range(len(ghost)):
        some = _pooled(at, (a, 0, 0), state == GHOST)
        ghost[a] = _quantiles(moved[some if len(some) else state == REMEMBERED])
    split = np.array([_split(rows, measured & (t == n)) for n in range(bins[1])])
    pictures = len(np.unique(rows[:, :3], axis=0))
    nobody = rows[state == PHANTOM]
    memory, common = _correlations(rows, scaled, place, measured, fresh)
    return ErrorTable(
        again=again,
        anew=anew,
        fresh=fresh,
        fresh_std=fresh_std,
        aged=aged,
        aged_std=aged_std,
        split=split,
        ghost=ghost,
        stay=np.array([_stay(rows)]),
        phantom=np.array([len(nobody) / max(pictures, 1)]),
        phantom_place=_quantiles(nobody[:, [COLUMNS.index(n) for n in ("range_error", "bearing_error")]]),
        memory=memory,
        common=common,
    )


def _pooled(
    place: NDArray[np.int64], index: tuple[int, ...], mask: NDArray[np.bool_], enough: int = ENOUGH
) -> NDArray[np.int64]:
    """Return the rows of a bin, with those of bins around it until there are enough.

    First the visible fraction is let go, then turn rate and range step by step.
    """
    off = np.abs(place - index)
    rows = np.empty(0, np.int64)
    for reach in (
        (0, 0, 0),
        (0, 0, 1),
        (0, 1, 0),
        (0, 1, 1),
        (1, 1, 1),
        (1, 2, 1),
        (2, 2, 2),
        (4, 4, 4),
        (99,) * 3,
    ):
        rows = np.flatnonzero(mask & (off <= reach).all(axis=1))
        if len(rows) >= enough:
            break
    return rows


def _quantiles(errors: FloatArray) -> FloatArray:
    """Return the quantiles of each column at :data:`DEVIATES`, shape ``(columns, q)``; 0 for no rows."""
    if len(errors) == 0:
        return np.zeros((errors.shape[1], len(DEVIATES)))
    return np.asarray(np.quantile(errors, ndtr(DEVIATES), axis=0).T)


def _numbers(rows: Record) -> NDArray[np.int64]:
    """Return one number for each (flight, observer, neighbour, time) such that time counts by one."""
    flight, time, observer, neighbour = rows[:, :4].astype(np.int64).T
    numbers: NDArray[np.int64] = ((flight * 1000 + observer) * 1000 + neighbour) * 100_000 + time
    return numbers


def _state_before(rows: Record) -> NDArray[np.int64]:
    """Return the state of the same pair one picture before, UNSEEN in the first; -1 beyond reach."""
    pair = np.isin(rows[:, COLUMNS.index("state")], (UNSEEN, MEASURED, REMEMBERED))
    numbers, known = _numbers(rows), _numbers(rows[pair])
    order = np.argsort(known)
    known, states = known[order], rows[pair][order, COLUMNS.index("state")].astype(np.int64)
    at = np.clip(np.searchsorted(known, numbers - 1), 0, len(known) - 1)
    before = np.where(known[at] == numbers - 1, states[at], -1)
    return np.where(rows[:, 1] == 0, UNSEEN, before)


def _born(rows: Record) -> NDArray[np.bool_]:
    """Return which rows are ghosts in their first picture, shape ``(rows,)``."""
    age = rows[:, COLUMNS.index("age")]
    period = np.min(age[age > 1e-9], initial=np.inf)
    born: NDArray[np.bool_] = (rows[:, COLUMNS.index("state")] == GHOST) & (age <= period * 1.5)
    return born


def _split(rows: Record, measured: NDArray[np.bool_]) -> float:
    """Return the share of measurements at which a ghost of the same neighbour begins."""
    total = int(np.count_nonzero(measured))
    if total == 0:
        return 0.0
    return float(np.isin(_numbers(rows[measured]), _numbers(rows[_born(rows)])).sum() / total)


def _stay(rows: Record) -> float:
    """Return the chance that a ghost stays for one more picture, from how many pictures one lasts."""
    born = int(np.count_nonzero(_born(rows)))
    ghosts = rows[:, COLUMNS.index("state")] == GHOST
    if born == 0:
        return 0.0
    pictures = round(float(np.max(rows[ghosts, COLUMNS.index("age")])) * CAMERA_HZ)
    wanted = np.count_nonzero(ghosts) / born
    stays = np.linspace(0.0, 1.0, 1001)
    lasts = np.sum(stays[:, None] ** np.arange(pictures), axis=1)  # the mean of a life that ends at last
    return float(stays[np.argmin(np.abs(lasts - wanted))])


def _correlations(
    rows: Record,
    errors: FloatArray,
    place: NDArray[np.int64],
    measured: NDArray[np.bool_],
    fresh: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the correlations of the normal deviates in time and between neighbours, each ``(3,)``."""
    z = np.full((int(np.count_nonzero(measured)), 3), np.nan)
    where, values = place[measured], errors[measured]
    for n, (index, error) in enumerate(zip(where, values, strict=True)):
        for q in range(3):
            z[n, q] = np.interp(error[q], fresh[(*index, q)], DEVIATES)
    numbers = _numbers(rows[measured])
    order = np.argsort(numbers)
    numbers, z_sorted = numbers[order], z[order]
    after = np.flatnonzero(np.diff(numbers) == 1)
    memory = [_correlation(z_sorted[after, q], z_sorted[after + 1, q]) for q in range(3)]
    flight, time, observer = rows[measured][:, :3].astype(np.int64).T
    look = (flight * 1000 + observer) * 100_000 + time
    order = np.lexsort((rows[measured][:, 3], look))
    same = np.flatnonzero(np.diff(look[order]) == 0)
    common = [_correlation(z[order[same], q], z[order[same + 1], q]) for q in range(3)]
    return np.clip(memory, 0.0, 0.99), np.clip(common, 0.0, 0.99)


def _correlation(one: FloatArray, two: FloatArray) -> float:
    return float(np.corrcoef(one, two)[0, 1]) if len(one) > 2 and one.std() > 0 and two.std() > 0 else 0.0
