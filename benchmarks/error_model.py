"""The error model beside the camera that it stands for, and many worlds beside pymunk.

    python benchmarks/error_model.py [SEEDS]

Three tables: what both sensors say of the same held-out scenes (wanderers, whose way does not depend on
what they see), what the flocking demo comes to with either, and how far worlds drift from pymunk.
"""

from __future__ import annotations

import sys

import numpy as np

from swarmvision.config.scenario import packaged_scenario
from swarmvision.data import Commands
from swarmvision.experiments.error_model import (
    COLUMNS,
    ERRORS,
    GHOST,
    MEASURED,
    REMEMBERED,
    Flight,
    Record,
    record,
)
from swarmvision.geometry import FloatArray
from swarmvision.simulation import Simulation, run
from swarmvision.worlds import Worlds

HELD_OUT = 9000  # seeds that no fit has used
WANDERERS = Flight(8, 0.6, "wander", 40)
BINS = ((0.0, 0.3), (0.3, 0.6), (0.6, 1.0), (1.0, 1.5), (0.0, 1.5))


def said(rows: Record, low: float, high: float) -> list[float]:
    """Share measured, remembered and of ghosts; median and 90th percentile of the absolute errors."""
    state, distance = rows[:, COLUMNS.index("state")], rows[:, COLUMNS.index("range")]
    inside = (distance >= low) & (distance < high)
    pairs = np.count_nonzero(inside & (state <= REMEMBERED))
    shares = [np.count_nonzero(inside & (state == what)) / pairs for what in (MEASURED, REMEMBERED, GHOST)]
    errors = np.abs(rows[inside & (state == MEASURED)][:, [COLUMNS.index(name) for name in ERRORS]])
    return shares + [float(np.quantile(errors[:, c], share)) for c in range(3) for share in (0.5, 0.9)]


def same_scenes(seeds: int) -> None:
    rows = {
        kind: np.concatenate(
            [record(WANDERERS, HELD_OUT + seed, seed, kind, reach=1.5) for seed in range(seeds)]
        )
        for kind in ("camera", "error_model")
    }
    print(
        "range (m)   measured cam/model   remembered     ghosts        model over camera: range p50 p90,"
        " bearing, heading"
    )
    for low, high in BINS:
        camera, model = (said(rows[kind], low, high) for kind in ("camera", "error_model"))
        shares = "  ".join(f"{one:.3f}/{two:.3f}" for one, two in zip(camera[:3], model[:3], strict=True))
        ratios = " ".join(f"{two / one:.2f}" for one, two in zip(camera[3:], model[3:], strict=True))
        print(f"{low:.1f}-{high:.1f}     {shares}   {ratios}")


def same_flock(seeds: int) -> None:
    for kind in ("camera", "error_model", "truth"):
        change = [] if kind == "camera" else [f'sensor={{kind="{kind}"}}']
        scenario = packaged_scenario("flocking", ["seconds=30", *change])
        outcomes = [run(scenario, seed).summary for seed in range(seeds)]
        for name in ("order", "largest_cluster"):
            values = np.array([outcome[name] for outcome in outcomes])
            print(f"{kind:12s} {name:16s} mean {values.mean():.4f}  std {values.std():.4f}")


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
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 4
    same_scenes(count)
    same_flock(count)
    for steps_of in (12, 4):
        drift(steps_of, ["start.radius=6", "start.spacing=2.5"])
        drift(steps_of, ["start.radius=0.4"])
        drift(steps_of, ["arena.width=1.2", "arena.depth=1.2"])
