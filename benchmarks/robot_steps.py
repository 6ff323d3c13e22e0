"""Robot-steps per second on one core without pictures: one world by pymunk, many worlds by arrays.

python benchmarks/robot_steps.py
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter, thread_time

from swarmvision.config.scenario import ScenarioConfig, packaged_scenario
from swarmvision.simulation import Simulation
from swarmvision.worlds import Worlds

PER_ROBOT = 0.35  # m: the starting circle's radius over the root of the robots: about 2.6 in a square metre
SECONDS = 1.0  # of each measurement
WARM_UP = 5  # steps


def flock(robots: int, kind: str) -> ScenarioConfig:
    radius = PER_ROBOT * robots**0.5
    sensor = f'sensor={{kind="{kind}",neighbours=8}}'
    arena = max(16.0, 4.0 * radius)
    return packaged_scenario(
        "flocking",
        [
            f"robots={robots}",
            f"start.radius={radius}",
            f"arena.width={arena}",
            f"arena.depth={arena}",
            sensor,
        ],
    )


def rate(turn: Callable[[], object], robots: int) -> float:
    """Robot-steps per second of the core's time, of the fastest turn: others may share the machine."""
    for _ in range(WARM_UP):
        turn()
    best, begin = float("inf"), perf_counter()
    while perf_counter() - begin < SECONDS:
        before = thread_time()
        turn()
        best = min(best, thread_time() - before)
    return robots / best


def measure(name: str, one: Simulation | Worlds, robots: int) -> None:
    estimates = one.sense()
    commands = one.decide(one.feel(estimates))

    def without_law() -> None:
        one.sense()
        one.act(commands)

    whole, bare = rate(one.step, robots), rate(without_law, robots)
    print(f"{name:34s} sense + act {bare:12,.0f}   with the law {whole:12,.0f}")


if __name__ == "__main__":
    for kind in ("truth", "error_model"):
        for robots in (10, 100, 1000):
            measure(f"Simulation {robots} {kind}", Simulation(flock(robots, kind), 1), robots)
        for worlds, robots in ((1, 100), (256, 8), (2048, 8)):
            many = Worlds(flock(robots, kind), worlds, 1)
            measure(f"Worlds {worlds} x {robots} {kind}", many, worlds * robots)
