"""How honest and how steady tracks are: a flock that is steered by the truth is watched by its cameras.

Prints, for what was seen in the newest look and for what is carried on since: the mean squared error over
what the covariance says (NEES per degree of freedom, 1 is honest), the same without the worst 1 %, and
the median; then how many tracks one neighbour had, and how many tracks went over to another one::

    python benchmarks/tracking.py --rig ring-7 --seconds 10
"""

from __future__ import annotations

import argparse

import numpy as np

from swarmvision.config.scenario import packaged_scenario
from swarmvision.config.sensor import CameraSensorConfig
from swarmvision.geometry import FloatArray, compose, inverse, polar, wrap
from swarmvision.sensing.camera import CameraSensor
from swarmvision.simulation import Simulation

ASTRAY = 0.15  # m: an estimate farther from every robot is nobody's


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--rig", default="ring-7")
    parser.add_argument("--rate", type=float, default=10.0, help="Hz")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=3)
    asked = parser.parse_args()
    scenario = packaged_scenario("flocking", ["sensor={kind='truth'}", f"control_hz={asked.rate}"])
    config = CameraSensorConfig.model_validate({"rig": asked.rig, "rate_hz": asked.rate})
    simulation = Simulation(scenario, asked.seed)
    camera = CameraSensor(config, scenario.robot, scenario.arena, scenario.robots, asked.seed)
    errors: list[tuple[float, float]] = []  # age, NEES
    whose: dict[tuple[int, int], int] = {}
    tracks: dict[tuple[int, int], set[int]] = {}
    switches = astray = 0
    for _ in range(round(asked.seconds * asked.rate)):
        pose, seen = simulation.scene.pose, camera.sense(simulation.scene)
        truth = np.stack(polar(compose(inverse(pose)[:, None], pose[None])), axis=-1)  # (r, r, 3)
        for i, k in zip(*np.nonzero(seen.seen), strict=True):
            estimate = np.array([seen.range[i, k], seen.bearing[i, k], seen.heading[i, k]])
            j, off = nearest(estimate, truth[i], i)
            if off is None:
                astray += 1
                continue
            track = int(seen.track[i, k])
            switches += whose.setdefault((i, track), j) != j
            whose[i, track] = j
            tracks.setdefault((i, j), set()).add(track)
            if np.isfinite(off).all():
                nees = float(off @ np.linalg.solve(seen.covariance[i, k], off)) / 3.0
                errors.append((float(seen.age[i, k]), nees))
        simulation.step()
    report(np.array(errors))
    each = np.mean([len(numbers) for numbers in tracks.values()])
    print(f"{each:.2f} tracks a neighbour, {switches} switches, {astray} astray")


def nearest(estimate: FloatArray, truth: FloatArray, observer: int) -> tuple[int, FloatArray | None]:
    """Return whose an estimate is, and its error; None where it is nobody's."""
    off = estimate - truth
    off[:, 1:] = wrap(off[:, 1:])
    away = np.hypot(off[:, 0], truth[:, 0] * off[:, 1])
    away[observer] = np.inf
    j = int(np.argmin(away))
    return j, off[j] if away[j] < ASTRAY else None


def report(errors: FloatArray) -> None:
    fresh = errors[:, 0] < 1e-9
    for name, rows in (("seen now", errors[fresh]), ("carried on", errors[~fresh])):
        nees = np.sort(rows[:, 1])
        if len(nees):
            kept = nees[: max(int(0.99 * len(nees)), 1)]
            print(
                f"{name}: {len(nees)} estimates, NEES a degree of freedom {nees.mean():.2f}, "
                f"without the worst 1 % {kept.mean():.2f}, median {np.median(nees):.2f}"
            )


if __name__ == "__main__":
    main()
