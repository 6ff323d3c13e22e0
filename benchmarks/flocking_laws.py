"""How well the laws of motion flock: order, cohesion, contacts, robots that are stuck, over many seeds.

python benchmarks/flocking_laws.py kobot ferrante --seeds 20
python benchmarks/flocking_laws.py kobot --set sensor.kind=camera --set sensor.rig=ring-7 --seeds 3
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np

from swarmvision.config.scenario import ScenarioConfig, packaged_scenario
from swarmvision.simulation import run

STUCK = 0.01  # m/s: mean speed over the last fifth below which a robot is stuck


def outcome(scenario: ScenarioConfig, seed: int) -> tuple[float, float, float, int]:
    """Return order, largest cluster, contacts per robot-minute and stuck robots of one run."""
    result = run(scenario, seed, workers=1)
    summary = result.summary
    last = result.pose[-max(len(result.pose) // 5, 2) :, :, :2]
    way = np.hypot(*np.moveaxis(np.diff(last, axis=0), -1, 0)).sum(axis=0)
    speed = way / ((len(last) - 1) / scenario.control_hz)
    minutes = max(scenario.robots * scenario.seconds / 60.0, 1e-9)
    stuck = int(np.count_nonzero(speed < STUCK))
    return summary["order"], summary["largest_cluster"], summary["contacts"] / minutes, stuck


def main() -> None:
    """Print one line for each law."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("laws", nargs="+")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--robots", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--set", action="append", default=[], dest="changes", metavar="KEY=VALUE")
    options = parser.parse_args()
    print(f"{'law':<14} order  (p10)  largest (p10)  contacts/robot-min (max)  stuck")
    with ProcessPoolExecutor(options.workers) as pool:
        for law in options.laws:
            changes = [f"robots={options.robots}", f"seconds={options.seconds}", *options.changes]
            if not any(change.startswith("sensor.kind") for change in changes):
                changes = ["sensor={kind='truth', reach=1.5}", *changes]
            scenario = packaged_scenario("flocking", [f"controller={{law='{law}'}}", *changes])
            rows = np.array(list(pool.map(partial(outcome, scenario), range(options.seeds))))
            middle, low = np.median(rows, axis=0), np.percentile(rows, 10, axis=0)
            print(
                f"{law:<14} {middle[0]:.3f} ({low[0]:.3f})  {middle[1]:.3f} ({low[1]:.3f})  "
                f"{rows[:, 2].mean():.2f} ({rows[:, 2].max():.1f})  {int(rows[:, 3].sum())}",
                flush=True,
            )


if __name__ == "__main__":
    main()
