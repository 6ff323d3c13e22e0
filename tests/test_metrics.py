"""Measures by hand calculation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import TruthSensorConfig
from swarmvision.data import Estimates, Scene
from swarmvision.geometry import FloatArray, rotate
from swarmvision.metrics import (
    Ledger,
    TrackSwitches,
    algebraic_connectivity,
    blind_share,
    cluster_labels,
    contacts_per_robot_minute,
    deviation_energy,
    dispersion,
    displacement,
    expected_cluster_size,
    gathered_share,
    herding_success,
    in_largest_cluster,
    largest_cluster,
    lattice_order,
    milling,
    nearest_distance,
    order,
    pair_distance,
    path_efficiency,
    path_length,
    perception_errors,
    perception_table,
    radius_of_gyration,
    social_entropy,
    strong_components,
    stuck,
    transport_distance,
    transport_progress,
    visibility,
    weak_components,
)
from swarmvision.sensing.truth import TruthSensor

NOBODY = np.zeros((0, 2))


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


def test_the_largest_of_equal_clusters_is_the_first() -> None:
    places = np.array([[9.0, 9.0], [0.0, 0.0], [9.1, 9.0], [0.1, 0.0]])
    assert in_largest_cluster(places, 0.5).tolist() == [True, False, True, False]
    assert in_largest_cluster(np.zeros((0, 2)), 0.5).shape == (0,)


def test_the_order_of_the_flock_leaves_out_who_has_left_it() -> None:
    ledger = Ledger(4, reach=1.0)
    pose = np.array([[0.0, 0.0, 0.5], [0.3, 0.0, 0.5], [0.0, 0.3, 0.5], [5.0, 0.0, 0.5 + np.pi]])
    ledger.note(Scene.at_rest(pose), Estimates.empty((4, 0)))
    np.testing.assert_allclose(ledger.order(), [0.5])
    for link, share, flock_order in ((0.5, 0.75, 1.0), (9.0, 1.0, 0.5)):
        found = ledger.flock(link)
        np.testing.assert_allclose(found[0], [share])
        np.testing.assert_allclose(found[1], [flock_order])


def test_labels_follow_the_first_members() -> None:
    # Far, near, far again: the second and fourth are one cluster, numbered by the second.
    assert cluster_labels(np.array([[9, 9], [0, 0], [5, 5], [0.1, 0]]), 0.5).tolist() == [0, 1, 2, 1]


def test_the_cluster_that_a_robot_finds_itself_in() -> None:
    # Clusters of 3 and 1: three robots find 3, one finds 1: 10/4.
    assert expected_cluster_size(np.array([[0, 0], [0.3, 0], [0.6, 0], [5, 0]]), 0.5) == pytest.approx(2.5)
    assert expected_cluster_size(NOBODY, 0.5) == 0.0


def test_a_wheel_mills_and_a_line_does_not() -> None:
    place = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    round_and_round = np.array([[0, 2], [-2, 0], [0, -2], [2, 0]])
    assert float(milling(place, round_and_round)) == pytest.approx(1.0)
    assert float(milling(place, -round_and_round)) == pytest.approx(1.0)
    assert float(milling(place, place)) == pytest.approx(0.0)
    # One stands, the others mill: 3/4. A common velocity: the moments cancel.
    assert float(milling(place, round_and_round * [[0], [1], [1], [1]])) == pytest.approx(0.75)
    assert float(milling(place, np.ones((4, 2)))) == pytest.approx(0.0)
    assert milling(np.zeros((5, 0, 2)), np.zeros((5, 0, 2))).tolist() == [0] * 5


def test_dispersion_is_gaucis_sum() -> None:
    # Two robots of radius 1 that touch: each 1 from the middle, (1 + 1)/4.
    assert float(dispersion([[0, 0], [2, 0]], 1.0)) == pytest.approx(0.5)
    assert float(radius_of_gyration([[0, 0], [2, 0]])) == pytest.approx(1.0)
    assert float(dispersion(NOBODY, 1.0)) == 0.0
    assert float(radius_of_gyration(NOBODY)) == 0.0
    assert dispersion([[[0, 0], [2, 0]], [[0, 0], [4, 0]]], 1.0).tolist() == [0.5, 2.0]


def test_distances_of_a_triangle() -> None:
    # 3-4-5: the nearest are 3, 3, 4; the pairs 3, 4, 5.
    triangle = [[0, 0], [3, 0], [0, 4]]
    assert nearest_distance(triangle) == pytest.approx(10 / 3)
    assert pair_distance(triangle) == pytest.approx(4.0)
    assert np.isnan(nearest_distance([[0, 0]]))
    assert np.isnan(pair_distance([[0, 0]]))


def test_social_entropy_is_the_area_under_its_steps() -> None:
    # On a line at 0, 1 and 3: apart, H = log2 3 up to h = 1; then clusters of 2 and 1 up to h = 2.
    parted = -(2 / 3) * np.log2(2 / 3) - (1 / 3) * np.log2(1 / 3)
    assert social_entropy([[0, 0], [1, 0], [3, 0]]) == pytest.approx(np.log2(3) + parted)
    assert social_entropy([[0, 0], [1, 0]]) == pytest.approx(1.0)
    assert social_entropy([[0, 0]]) == 0.0
    assert social_entropy(NOBODY) == 0.0
    assert social_entropy([[0, 0], [0, 0], [0, 0]]) == pytest.approx(0.0)


def test_social_entropy_agrees_with_the_integral_of_the_clusters() -> None:
    place = np.random.default_rng(4).uniform(0, 1, (12, 2))
    lengths = np.linspace(0, 1.5, 1501)
    entropy = []
    for h in lengths[:-1]:
        share = np.bincount(cluster_labels(place, h)) / 12
        entropy.append(-np.sum(share * np.log2(share)))
    # Each step falls within a slice of 1e-3 m, and all together they fall by log2(12) = 3.6 bit.
    assert social_entropy(place) == pytest.approx(np.sum(entropy) * 1e-3, abs=3.6e-3)


def test_a_chain_of_looks_is_weakly_but_not_strongly_connected() -> None:
    chain = np.array([[0, 1, 0], [0, 0, 1], [0, 0, 0]])
    assert (weak_components(chain), strong_components(chain)) == (1, 3)
    ring = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]])
    assert (weak_components(ring), strong_components(ring)) == (1, 1)
    assert blind_share(chain) == pytest.approx(1 / 3)
    assert weak_components(np.zeros((3, 3))) == 3
    assert (weak_components(np.zeros((0, 0))), strong_components(np.zeros((0, 0)))) == (0, 0)
    assert blind_share(np.zeros((0, 0))) == 0.0


def test_algebraic_connectivity_of_known_graphs() -> None:
    # A complete graph of n has n; a path of three has 1; looks from one side count half; a parted one has 0.
    assert algebraic_connectivity(np.ones((4, 4)) - np.eye(4)) == pytest.approx(4.0)
    path = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]])
    assert algebraic_connectivity(path) == pytest.approx(1.0)
    assert algebraic_connectivity(np.triu(path)) == pytest.approx(0.5)
    assert algebraic_connectivity(np.zeros((3, 3))) == pytest.approx(0.0)
    assert algebraic_connectivity(np.zeros((1, 1))) == 0.0


def test_contacts_are_counted_by_robot_and_minute() -> None:
    assert contacts_per_robot_minute(6, robots=4, seconds=90) == pytest.approx(1.0)
    assert contacts_per_robot_minute(0, robots=0, seconds=90) == 0.0


def test_ways_of_a_straight_and_a_detour() -> None:
    # One goes straight from 0 to 4, one by (2, 3) and back to (4, 0): ways 4 and 2 sqrt(13).
    course = np.array([[[0, 0], [0, 0]], [[2, 0], [2, 3]], [[4, 0], [4, 0]]])
    assert displacement(course) == pytest.approx(4.0)
    np.testing.assert_allclose(path_length(course), [4.0, 2 * np.sqrt(13)])
    assert path_efficiency(course) == pytest.approx(4.0 / (2 + np.sqrt(13)))
    assert path_efficiency(np.zeros((3, 2, 2))) == 0.0
    assert displacement(np.zeros((3, 0, 2))) == 0.0
    assert path_efficiency(np.zeros((3, 0, 2))) == 0.0


def test_who_drives_on_the_spot_is_stuck_and_who_waits_or_turns_is_not() -> None:
    steps = np.arange(11)[:, None] * 0.05  # tracks that run 0.5 m
    still, going = np.zeros((11, 2)), np.hstack([steps, 0 * steps])
    place = np.stack([still, going, still, still, going * 0.2], axis=1)
    travel = np.stack(
        [
            np.hstack([steps, steps]),  # against a wall: stuck
            np.hstack([steps, steps]),  # gets on
            np.hstack([0 * steps, 0 * steps]),  # waits
            np.hstack([-steps, steps]),  # turns
            np.hstack([steps, steps]),  # slips: a fifth of its way: stuck
        ],
        axis=1,
    )
    assert stuck(place, travel).tolist() == [True, False, False, False, True]
    assert stuck(np.zeros((3, 0, 2)), np.zeros((3, 0, 2))).shape == (0,)


def lattice(step: FloatArray, half: int = 3) -> FloatArray:
    """Places of a lattice whose cell's sides are the rows of ``step``, turned by 0.3 rad."""
    index = np.stack(np.meshgrid(*[np.arange(-half, half + 1)] * 2), axis=-1).reshape(-1, 2)
    return rotate(index @ step, 0.3)


def test_hexagons_are_six_fold_and_squares_four_fold() -> None:
    hexagons = lattice(np.array([[1.0, 0.0], [0.5, np.sqrt(3) / 2]]))
    assert lattice_order(hexagons, 6, 1.2) == pytest.approx(1.0)
    squares = lattice(np.eye(2))
    assert lattice_order(squares, 4, 1.2) == pytest.approx(1.0)
    # A square's inside has 1 - 1 + 1 - 1 = 0, its sides |1 - 1 + (-1)|... = 1/3, its corners |1 - 1| = 0.
    assert lattice_order(squares, 6, 1.2) == pytest.approx(4 * 5 * (1 / 3) / 49)
    assert lattice_order([[0, 0], [1, 0]], 6, 1.2) == 0.0  # one neighbour is no lattice
    assert lattice_order(NOBODY, 6, 1.2) == 0.0


def test_deviation_energy_of_one_long_link() -> None:
    # One link of 1.2 where 1 is wanted, from both ends: 2 * 0.04 / (2 + 1).
    assert deviation_energy([[0.0, 0.0], [1.2, 0.0]], 1.0, 1.5) == pytest.approx(0.08 / 3)
    assert deviation_energy([[0.0, 0.0], [2.4, 0.0]], 2.0, 3.0) == pytest.approx(
        0.08 / 3
    )  # whatever the scale
    assert deviation_energy([[0, 0], [9, 0]], 1.0, 1.5) == 0.0
    assert deviation_energy(NOBODY, 1.0, 1.5) == 0.0


def test_a_flock_is_home_when_its_last_sheep_is() -> None:
    course = np.array([[[3, 0], [0, 0]], [[0.4, 0], [0, 0.3]], [[3, 0], [0, 0]]])
    np.testing.assert_allclose(gathered_share(course, (0, 0), 0.5), [0.5, 1.0, 0.5])
    assert herding_success(course, (0, 0), 0.5)
    assert not herding_success(course, (0, 0), 0.35)
    assert gathered_share(NOBODY, (0, 0), 1.0) == 1.0


def test_a_box_is_carried_as_far_as_it_came() -> None:
    course = np.array([[0, 0], [9, 9], [3, 4]])
    assert transport_distance(course) == pytest.approx(5.0)
    assert transport_progress(course, (3, 5)) == pytest.approx(np.sqrt(34) - 1)
    assert transport_distance(NOBODY) == 0.0
    assert transport_progress(NOBODY, (0, 0)) == 0.0


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


def told(*neighbours: tuple[float, float, int], spread: float = 0.01, age: float = 0.0) -> Estimates:
    """What robot 0 believes of neighbours at range, bearing and track; robots 1 and 2 believe nothing."""
    k = len(neighbours)
    seen = np.zeros((3, k), dtype=bool)
    seen[0] = True
    column = np.array([*neighbours]).reshape(k, 3)
    rows = [np.where(seen, column[:, c], np.nan) for c in range(3)]
    return Estimates(
        seen=seen,
        range=rows[0],
        bearing=rows[1],
        heading=np.full((3, k), np.nan),
        covariance=np.where(seen[..., None, None], spread**2 * np.eye(3), np.nan),
        age=np.where(seen, age, np.nan),
        track=np.where(seen, column[:, 2], -1),
        visible=seen.astype(float),
    )


# Robot 1 at 0.5 m and 0 rad of robot 0, robot 2 at 0.5 m and 0.1 rad.
TRIO = np.array([[0, 0, 0], [0.5, 0, 0], [0.5 * np.cos(0.1), 0.5 * np.sin(0.1), 0]])


def test_an_estimate_that_knows_its_error_may_be_farther_off() -> None:
    # 0.15 rad off is more than 3 deg, but less than three standard deviations of 0.1 rad.
    sure, unsure = told((0.5, -0.15, 7)), told((0.5, -0.15, 7), spread=0.1)
    assert perception_errors(TRIO, sure, 1.0).found.tolist() == 6 * [False]
    errors = perception_errors(TRIO, unsure, 1.0)
    assert errors.found.tolist() == [True, *5 * [False]]
    assert errors.bearing_error[0] == pytest.approx(-0.15)
    assert (errors.phantoms, errors.fresh, errors.missed) == (0, 1, 5)


def test_old_estimates_count_up_to_the_given_age() -> None:
    late = told((0.5, 0.0, 7), age=0.3)
    assert perception_errors(TRIO, late, 1.0).fresh == 0
    assert perception_errors(TRIO, late, 1.0, oldest=0.3).found[0]


def test_a_track_stays_with_its_neighbour_while_it_may() -> None:
    # Track 7 was robot 1's; now it is read nearer to robot 2, but not too far from robot 1.
    last = np.full((3, 3), -1)
    last[0, 1] = 7
    seen = told((0.5, 0.06, 7), spread=0.05)
    assert perception_errors(TRIO, seen, 1.0).track.tolist()[:2] == [-1, 7]
    assert perception_errors(TRIO, seen, 1.0, last_track=last).track.tolist()[:2] == [7, -1]


def test_switches_are_counted_even_after_a_gap() -> None:
    switches = TrackSwitches(3)
    for track in (7, 7, None, 8, -1, 8, 7):
        seen = told() if track is None else told((0.5, 0.0, track))
        switches.note(perception_errors(TRIO, seen, 1.0, last_track=switches.last))
    assert switches.count == 2  # 7 to 8 over the gap, and 8 to 7; an estimate without a track is no switch


def test_who_sees_whom_is_told_by_matches() -> None:
    sees = visibility(perception_errors(TRIO, told((0.5, 0.0, 1), (0.5, 0.1, 2)), 1.0), 3)
    assert sees.toarray().tolist() == [[0, 1, 1], [0, 0, 0], [0, 0, 0]]
    assert visibility(perception_errors(np.zeros((0, 3)), Estimates.empty((0, 0)), 1.0), 0).shape == (0, 0)


def test_a_ledger_sums_up_what_it_noted() -> None:
    # Three robots drive abreast at 0.2 m/s for 4 s; robot 0 sees one of them, and every other step a phantom.
    ledger = Ledger(3, reach=1.0)
    for step in range(41):
        scene = Scene.at_rest(TRIO + np.array([0.02 * step, 0, 0]))
        way = np.full((3, 2), 0.02 * step)
        scene = replace(scene, time=0.1 * step, wheel_travel=way, velocity=np.full((3, 3), [0.2, 0, 0]))
        ledger.note(scene, told((0.5, 0.0, 7)) if step % 2 else told((0.5, 0.0, 7), (3.0, 3.0, 8)))
    motion = ledger.motion(contacts=2, body_radius=0.05)
    assert motion["displacement"] == pytest.approx(0.8)
    assert motion["path_efficiency"] == pytest.approx(1.0)
    assert motion["contacts_per_robot_minute"] == pytest.approx(2 / 3 / (4 / 60))
    assert (motion["stuck"], motion["stuck_share"]) == (0, 0.0)
    seeing = ledger.perception()
    assert seeing["missed"] == pytest.approx(5 / 6)
    assert seeing["phantoms"] == pytest.approx(21 / 62)
    assert (seeing["track_switches"], seeing["connected"]) == (0, 0.0)
    assert seeing["blind"] == pytest.approx(2 / 3)
    share, flock_order = ledger.flock(0.6)
    assert ledger.order().shape == share.shape == flock_order.shape == (41,)


def test_a_ledger_judges_the_eyes_that_it_is_about() -> None:
    # Robot 0 has other eyes: what it sees and invents is not in the figures, but in who sees whom.
    ledger = Ledger(3, reach=1.0, judged=(1, 2))
    ledger.note(Scene.at_rest(TRIO), told((0.5, 0.0, 7), (3.0, 3.0, 8)))
    seeing = ledger.perception()
    assert (seeing["missed"], seeing["phantoms"], seeing["blind"]) == (1.0, None, pytest.approx(2 / 3))
    assert seeing["perception"][-1]["neighbours"] == 4
    assert seeing["perception"][-1]["phantoms"] == 0


@pytest.mark.parametrize("robots", [0, 1])
@pytest.mark.parametrize("steps", [1, 3])
def test_a_ledger_of_nobody_or_one_is_a_normal_one(robots: int, steps: int) -> None:
    ledger = Ledger(robots, reach=1.0)
    for step in range(steps):
        scene = replace(Scene.at_rest(np.zeros((robots, 3))), time=0.1 * step)
        ledger.note(scene, Estimates.empty((robots, 0)))
    numbers = [value for value in ledger.motion(0, 0.05).values() if value is not None]
    assert np.isfinite(numbers).all()
    assert ledger.perception()["missed"] is None
