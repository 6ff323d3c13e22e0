"""Run a small flock on real pixels and tell how well it was aligned and how well it saw."""

from swarmvision.config.scenario import packaged_scenario
from swarmvision.simulation import run


def main() -> None:
    scenario = packaged_scenario("flocking", ["robots=3", "seconds=3", "start.radius=0.3"])
    result = run(scenario, seed=1)
    print(f"order {result.order[0]:.2f} -> {result.order[-1]:.2f}")
    for row in result.summary["perception"]:
        print(f"from {row['from_m']} m: {row['found']} of {row['neighbours']} neighbours found")


if __name__ == "__main__":
    main()
