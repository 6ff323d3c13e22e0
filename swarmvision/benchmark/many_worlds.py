"""Many worlds in one process, as for learning."""

from __future__ import annotations

import numpy as np

from swarmvision.benchmark.apart import Apart, apart
from swarmvision.benchmark.rival_swarms import vmas
from swarmvision.benchmark.stage import swarm
from swarmvision.benchmark.swarms import SEED, SENSORS
from swarmvision.benchmark.timing import Effort, Figure, medians, ratio
from swarmvision.data import Commands
from swarmvision.worlds import Worlds

ROBOTS = 8  # of each world


def figures(effort: Effort) -> dict[str, Figure]:
    """Return robot-steps a second of many worlds stepped at once on one core, ours and those of VMAS.

    Ours are sensed by ``error_model`` and driven, by commands that are given as VMAS's are, and once more
    with the flocking law instead.
    """
    scenario = swarm(ROBOTS, SENSORS["error_model"])
    given, flocking = Worlds(scenario, effort.worlds, SEED), Worlds(scenario, effort.worlds, SEED)
    rng = np.random.default_rng(SEED)
    shape = (effort.worlds, ROBOTS)
    commands = Commands(rng.uniform(0.0, 0.1, shape), rng.uniform(-1.0, 1.0, shape))

    def sense_and_act() -> None:
        given.sense()
        given.act(commands)

    rival = apart("vmas", "vmas", vmas, effort.worlds, ROBOTS)
    ms = medians(
        {
            "given": sense_and_act,
            "flocking": flocking.step,
            "vmas": rival,
        },
        effort.seconds,
    )
    if isinstance(rival, Apart):
        rival.close()
    steps = 1e3 * effort.worlds * ROBOTS
    return {
        "worlds_robot_steps_per_second_core": ratio(steps, ms["given"]),
        "worlds_flocking_robot_steps_per_second_core": ratio(steps, ms["flocking"]),
        "vmas_robot_steps_per_second_core": ratio(steps, ms["vmas"]),
        "worlds_over_vmas": ratio(ms["vmas"], ms["given"]),
    }
