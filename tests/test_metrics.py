"""Measures by hand calculation."""

from __future__ import annotations

import numpy as np
import pytest

from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import TruthSensorConfig
from swarmvision.data import Estimates, Scene
from swarmvision.metrics import cluster_labels, largest_cluster, order, perception_errors, perception_table
from swarmvision.sensing.truth import TruthSensor


def test_order_is_one_for_aligned_and_zero_for_opposed() -> None:
    assert float(order([0.3, 0.3, 0.3])) == pytest.approx(1.0)
    assert float(order([0.0, np.pi])) == pytest.approx(0.0, abs=1e-12)
    assert float(order([0.0, np.pi / 2])) == pytest.approx(np.sqrt(0.5))
    np.testing.assert_allclose(order([[0.0, 0.0], [0.0, np.pi]]), [1, 0], atol=1e-12)
    assert float(order([])) == 1.0


def test_clusters_are_chains_of_links() -> None:
    places = np.array([[0, 0], [0.4, 0], [0.8, 0], [3, 0], [3.4, 0], [9, 9]])
    assert cluster_labels(places, 0.5).tolist() == [0, 0, 0, 1, 1, 2]
    assert largest_cluster(places, 0.5) == pytest.approx(0.5)
    assert largest_cluster(places, 20) == 1.0
    assert largest_cluster(np.zeros((0, 2)), 0.5) == 1.0


def estimates() -> tuple[Scene, Estimates]:
    scene = Scene.at_rest([[0, 0, 0], [0.4, 0, 1.0], [0, 0.8, -1.0]])
    return scene, TruthSensor(TruthSensorConfig(), RobotConfig(), ArenaConfig()).sense(scene)


def test_perfect_estimates_have_no_error() -> None:
    scene, seen = estimates()
    errors = perception_errors(scene.pose, seen, 2.0)
    assert errors.found.all()
    assert len(errors.found) == 6
    assert errors.phantoms == 0
    np.testing.assert_allclose(errors.range_error, 0, atol=1e-12)
    np.testing.assert_allclose(errors.heading_error, 0, atol=1e-12)


def test_a_wrong_range_a_miss_and_a_phantom_are_told_apart() -> None:
    scene, seen = estimates()
    columns = {n: getattr(seen, n).copy() for n in ("seen", "range", "bearing", "heading", "age")}
    columns["range"][0, 0] *= 1.10  # robot 0 sees robot 1 at 0.44 instead of 0.40 m
    columns["bearing"][0, 1] += 1.0  # and robot 2 where nobody is
    wrong = Estimates(**columns, covariance=seen.covariance, track=seen.track, visible=seen.visible)
    errors = perception_errors(scene.pose, wrong, 2.0)
    assert errors.range_error[0] == pytest.approx(0.04)
    assert errors.found.tolist() == [True, False, True, True, True, True]
    assert errors.phantoms == 1
    near, *_, total = perception_table([errors])
    assert (near["from_m"], near["neighbours"], near["found"]) == (0.25, 2, 2)
    assert near["range_percent_median"] == pytest.approx(5.0)
    assert (total["neighbours"], total["found"], total["phantoms"]) == (6, 5, 1)


@pytest.mark.parametrize("robots", [0, 1])
def test_nobody_to_see_is_a_table_of_nothing(robots: int) -> None:
    errors = perception_errors(np.zeros((robots, 3)), Estimates.empty((robots, 0)), 1.0)
    (row,) = perception_table([errors])
    assert row["neighbours"] == 0
    assert row["range_percent_median"] is None
