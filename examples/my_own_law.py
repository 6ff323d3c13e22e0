"""A law of your own: hold the nearest neighbour at arm's length.

``swarmvision run flocking --controller my_own_law:keep_company`` runs it, from this folder.
"""

import sys
from pathlib import Path

import numpy as np

from swarmvision.config.scenario import packaged_scenario
from swarmvision.data import Commands, Estimates
from swarmvision.simulation import run


def keep_company(estimates: Estimates, arm: float = 0.3) -> Commands:
    distance = np.where(estimates.seen, estimates.range, np.inf)  # (..., k)
    nearest = np.min(distance, axis=-1, initial=np.inf)
    side = np.where(distance == nearest[..., None], estimates.bearing, 0.0)
    turn = np.nansum(np.where(estimates.seen, side, 0.0), axis=-1)
    return Commands(np.where(nearest > arm, 0.1, 0.0) * np.maximum(np.cos(turn), 0.0), 2.0 * turn)


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent))  # so that the law is found by its module's name
    changes = ["robots=4", "seconds=10", 'controller={law="custom", target="my_own_law:keep_company"}']
    result = run(packaged_scenario("aggregation", changes), seed=1)
    print(f"largest cluster at the end: {result.summary['largest_cluster_final']:.2f}")
