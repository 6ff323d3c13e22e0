"""The error model beside the camera that it stands for, and many worlds beside pymunk.

    python benchmarks/error_model.py [SEEDS]

Three tables: what both sensors say of the very same flocks, flown by what the cameras tell, on seeds that no
fit has used; what the flocking demo comes to with either; and how far worlds drift from pymunk.
"""

from __future__ import annotations

import sys

import numpy as np

from swarmvision.config.scenario import ScenarioConfig, packaged_scenario
from swarmvision.data import Commands
from swarmvision.experiments.flights import (
    COLUMNS,
    ERRORS,
    GHOST,
    MEASURED,
    REMEMBERED,
    Record,
    rows_of,
)
from swarmvision.geometry import FloatArray
from swarmvision.sensing.error_model import camera_view
from swarmvision.sensing.registry import sensor_of
from swarmvision.simulation import Simulation, run
from swarmvision.worlds import Worlds

HELD_OUT = 9000  # seeds that no fit has used
LAWS = ("kobot", "ferrante")
ROBOTS, STEPS, REACH = 10, 200, 1.5
LAGS = (1, 2, 4, 8, 16)  # pictures
SENSORS = ("camera", "error_model")


def flock(law: str, sensor: str) -> ScenarioConfig:
    return packaged_scenario(
        "flocking",
        [f"robots={ROBOTS}", f'controller={{law="{law}"}}', f'sensor={{kind="{sensor}",reach={REACH}}}'],
    )


def same_motion(law: str, seed: int) -> dict[str, Record]:
    """What both sensors say of one flock that flies by what its cameras say."""
    scenario = flock(law, "camera")
    simulation = Simulation(scenario, seed)
    model = sensor_of(flock(law, "error_model").sensor, scenario, seed)
    view = camera_view(scenario.robot, scenario.arena, REACH)
    owners: dict[str, list[dict[int, int]]] = {name: [{} for _ in range(ROBOTS)] for name in SENSORS}
    rows: dict[str, list[tuple[float, ...]]] = {name: [] for name in SENSORS}
    for step in range(STEPS):
        estimates = simulation.sense()
        for name, told in (("camera", estimates), ("error_model", model.sense(simulation.scene))):
            found = rows_of(simulation.scene, told, view, owners[name])
            rows[name].extend((seed, step, *row) for row in found)
        simulation.act(simulation.decide(simulation.feel(estimates)))
    return {name: np.array(rows[name]) for name in SENSORS}


def said(rows: Record) -> dict[str, FloatArray]:
    """Shares; quantiles of the absolute errors of range, bearing and heading; their correlation in time."""
    state = rows[:, COLUMNS.index("state")]
    pairs = np.count_nonzero(state <= REMEMBERED)
    shares = [np.count_nonzero(state == what) / pairs for what in (MEASURED, REMEMBERED, GHOST)]
    table = {"measured, remembered, ghosts": np.array(shares)}
    columns = [COLUMNS.index(name) for name in ERRORS]
    for what, name in ((MEASURED, "measured"), (REMEMBERED, "remembered")):
        errors = np.abs(rows[state == what][:, columns]) * [1e3, 1e3, 180.0 / np.pi]
        for share in (0.5, 0.95):
            table[f"{name}, p{100 * share:.0f} (mm, mrad, deg)"] = np.quantile(errors, share, axis=0)
    for column, name in zip(columns, ERRORS, strict=True):
        table[f"{name} after {LAGS}"] = correlations(rows[state == MEASURED], column)
    return table


def correlations(rows: Record, column: int) -> FloatArray:
    """Of a pair's errors with its own, so many pictures later; the outermost 2 % are clipped."""
    errors = np.clip(rows[:, column], *np.quantile(rows[:, column], [0.02, 0.98]))
    seed, time, observer, neighbour = rows[:, :4].astype(np.int64).T
    pair = ((seed - HELD_OUT) * ROBOTS + observer) * ROBOTS + neighbour
    series = np.full((pair.max() + 1, STEPS), np.nan)
    series[pair, time] = errors - errors.mean()
    whole = np.nanmean(series**2)
    return np.array([np.nanmean(series[:, :-lag] * series[:, lag:]) / whole for lag in LAGS])


def same_flocks(seeds: int) -> None:
    for law in LAWS:
        flown = [same_motion(law, HELD_OUT + seed) for seed in range(seeds)]
        camera, model = (said(np.concatenate([one[name] for one in flown])) for name in SENSORS)
        print(f"{law}, {ROBOTS} robots, {STEPS} pictures, {seeds} seeds")
        for name, values in camera.items():
            print(f"  {name:42s} camera {np.round(values, 3)}  model {np.round(model[name], 3)}")


def outcomes(seeds: int) -> None:
    for law in LAWS:
        for kind in (*SENSORS, "truth"):
            found = [run(flock(law, kind), seed).summary for seed in range(seeds)]
            told = [
                f"{name} {np.mean(values):.3f} (std {np.std(values):.3f})"
                for name in ("order", "largest_cluster", "contacts")
                for values in [[one[name] for one in found]]
            ]
            print(f"{law:9s} {kind:12s} {'  '.join(told)}")


def drift(substeps: int, overrides: list[str], worlds: int = 4, steps: int = 50) -> None:
    scenario = packaged_scenario("flocking", ['sensor={kind="truth"}', *overrides])
    many = Worlds(scenario, worlds, substeps=substeps)
    alone = [Simulation(scenario, int(seed)) for seed in many.seeds]
    rng, wish = np.random.default_rng(0), np.zeros((2, worlds, scenario.robots))
    off: list[FloatArray] = []
    for _ in range(steps):
        wish = 0.7 * wish + 0.71 * rng.normal(size=wish.shape)
        commands = Commands(0.1 + 0.05 * wish[0], wish[1])
        many.act(commands)
        for w, one in enumerate(alone):
            one.act(Commands(commands.speed[w], commands.turn_rate[w]))
        poses = np.array([one.scene.pose for one in alone])
        off.append(np.hypot(*np.moveaxis(many.pose[..., :2] - poses[..., :2], -1, 0)))
    told = [f"{1e3 * np.median(off[n]):.2f} / {1e3 * np.quantile(off[n], 0.95):.1f}" for n in (9, -1)]
    begun = sum(one.contacts for one in alone)
    print(
        f"{substeps:2d} substeps {overrides}: mm p50 / p95 after 1 s {told[0]}, after {steps / 10:.0f} s "
        f"{told[1]}; contacts {many.contacts.sum()}, pymunk {begun}"
    )


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 2
    same_flocks(count)
    outcomes(count)
    for steps_of in (12, 4):
        drift(steps_of, ["start.radius=6", "start.spacing=2.5"])
        drift(steps_of, ["start.radius=0.4"])
        drift(steps_of, ["arena.width=1.2", "arena.depth=1.2"])
