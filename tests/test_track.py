"""Neighbours over time, and over several lenses."""

from __future__ import annotations

from dataclasses import fields
from itertools import permutations

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from swarmvision.config.sensor import TrackerConfig
from swarmvision.data import Estimates, Frame
from swarmvision.geometry import compose, inverse, polar, wrap
from swarmvision.perception.fuse import robot_frame
from swarmvision.perception.track import Tracker, assignment

STD = (0.003, 0.002, 0.05)


def measured(poses: ArrayLike, observer: ArrayLike = (0, 0, 0), frame: Frame = "robot") -> Estimates:
    """Perfect estimates ``(k,)`` of world poses from an observer's pose; heading nan is not told."""
    relative = compose(inverse(observer), np.asarray(poses, dtype=float).reshape(-1, 3))
    distance, bearing, heading = polar(relative)
    k = len(distance)
    covariance = np.tile(np.diag(np.square(STD)), (k, 1, 1))
    blind = np.isnan(heading)
    covariance[blind, 2, :] = covariance[blind, :, 2] = np.nan
    return Estimates(
        seen=np.ones(k, dtype=bool),
        range=distance,
        bearing=bearing,
        heading=heading,
        covariance=covariance,
        age=np.zeros(k),
        track=np.full(k, -1),
        visible=np.ones(k),
        frame=frame,
    )


def world_poses(estimates: Estimates, observer: ArrayLike) -> np.ndarray:
    place = estimates.positions
    return compose(observer, np.column_stack([place, estimates.heading]))


def test_a_still_neighbour_stays_put_while_the_observer_drives_a_curve() -> None:
    tracker, observer = Tracker(TrackerConfig(memory=5.0)), np.zeros(3)
    neighbour = np.array([0.6, 0.2, 1.0])
    seen = tracker.step(measured([neighbour], observer), 0.0, 0.0, 0.0)
    for step in range(20):
        speed, turn, dt = 0.1, 0.9, 0.1
        arc = [speed / turn * np.sin(turn * dt), speed / turn * (1 - np.cos(turn * dt)), turn * dt]
        observer = compose(observer, arc)
        fresh = measured([neighbour], observer) if step < 10 else None
        seen = tracker.step(fresh, speed, turn, dt)
        np.testing.assert_allclose(world_poses(seen, observer)[0], neighbour, atol=0.02)
    assert seen.age[0] == pytest.approx(1.0)
    assert seen.track.tolist() == [0]


def test_a_moving_neighbour_is_carried_on_while_unseen_and_then_forgotten() -> None:
    tracker = Tracker(TrackerConfig(memory=0.55))
    for step in range(15):
        seen = tracker.step(measured([[0.5 + 0.02 * step, 0.1, 0.0]]), 0, 0, 0.1)
    for step in range(15, 20):
        seen = tracker.step(None, 0, 0, 0.1)
        assert seen.positions[0, 0] == pytest.approx(0.5 + 0.02 * step, abs=0.03)
    assert len(tracker.step(None, 0, 0, 0.1).seen) == 0


def test_crossing_neighbours_keep_their_numbers() -> None:
    tracker = Tracker(TrackerConfig())
    for step in range(41):
        one, two = [0.5, -0.2 + 0.01 * step, 1.6], [0.6, 0.2 - 0.01 * step, -1.6]
        seen = tracker.step(measured([one, two] if step % 2 else [two, one]), 0, 0, 0.1)
    left, right = seen.positions[np.argsort(seen.track)]
    first_was_near = seen.track.tolist() == [0, 1]
    assert first_was_near
    assert left[0] == pytest.approx(0.5, abs=0.03)
    assert left[1] == pytest.approx(0.2, abs=0.03)
    assert right[1] == pytest.approx(-0.2, abs=0.03)


def test_the_order_of_detections_does_not_matter() -> None:
    poses = [[0.5, 0.1, 0], [0.4, -0.3, 1], [-0.6, 0.2, np.nan]]
    results = []
    for order in permutations(range(3)):
        tracker = Tracker(TrackerConfig())
        for _ in range(3):
            seen = tracker.step(measured([poses[i] for i in order]), 0.1, 0.3, 0.1)
        results.append(seen)
    for other in results[1:]:
        for field in fields(Estimates)[:-1]:
            np.testing.assert_array_equal(getattr(results[0], field.name), getattr(other, field.name))


def test_covariances_stay_positive_definite_and_errors_honest() -> None:
    rng = np.random.default_rng(0)
    tracker, squares = Tracker(TrackerConfig()), []
    pose, velocity = np.array([0.6, 0.0, 0.0]), np.zeros(3)
    for _ in range(1000):
        kick = rng.normal(0, [0.5, 0.5, 6.0]) * 0.1
        pose = pose + velocity * 0.1 + kick * 0.05
        velocity = velocity + kick - 0.05 * velocity - 0.2 * np.array([pose[0] - 0.6, pose[1], 0])
        noisy = measured([pose])
        noisy = Estimates(
            seen=noisy.seen,
            range=noisy.range + rng.normal(0, STD[0]),
            bearing=noisy.bearing + rng.normal(0, STD[1]),
            heading=wrap(noisy.heading + rng.normal(0, STD[2])),
            covariance=noisy.covariance,
            age=noisy.age,
            track=noisy.track,
            visible=noisy.visible,
        )
        seen = tracker.step(noisy, 0, 0, 0.1)
        i = int(np.argmin(seen.age))
        assert np.linalg.eigvalsh(seen.covariance[i]).min() > 0
        truth = np.array(polar(pose)).ravel()
        off = np.array([seen.range[i], seen.bearing[i], seen.heading[i]]) - truth
        off[1:] = wrap(off[1:])
        squares.append(off @ np.linalg.solve(seen.covariance[i], off))
    assert 0.6 < np.mean(squares[50:]) / 3 < 1.5


def test_nothing_in_nothing_out() -> None:
    tracker = Tracker(TrackerConfig())
    assert len(tracker.step(Estimates.empty((0,)), 0.1, 0.2, 0.1).seen) == 0
    assert len(tracker.step(None, 0.1, 0.2, 0.1).seen) == 0


def test_a_neighbour_is_reported_once_confirmed() -> None:
    tracker = Tracker(TrackerConfig(confirm=2))
    assert len(tracker.step(measured([[0.5, 0, 0]]), 0, 0, 0.1).seen) == 0
    assert len(tracker.step(measured([[0.5, 0, 0]]), 0, 0, 0.1).seen) == 1


@pytest.mark.parametrize("seed", range(20))
def test_the_assignment_is_the_cheapest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cost = rng.random((rng.integers(1, 9), rng.integers(1, 9)))
    mine = sum(cost[i, j] for i, j in enumerate(assignment(cost)) if j >= 0)
    assert mine == pytest.approx(cost[linear_sum_assignment(cost)].sum())


LENSES = np.array([[0.04, 0.0, 0.0], [0.0, 0.04, np.pi / 2], [-0.04, 0.0, np.pi]])


def test_lenses_agree_on_where_a_neighbour_is_in_the_robots_frame() -> None:
    pose = np.array([0.4, 0.3, 0.7])
    readings = [measured([pose], lens, "lens") for lens in LENSES[:2]]
    fused = robot_frame([*readings, Estimates.empty((0,), "lens")], LENSES)
    assert len(fused.seen) == 1  # one neighbour, seen twice
    np.testing.assert_allclose(world_poses(fused, (0, 0, 0))[0], pose, atol=1e-9)
    alone = robot_frame([readings[0], *[Estimates.empty((0,), "lens")] * 2], LENSES)
    assert np.linalg.det(fused.covariance[0]) < np.linalg.det(alone.covariance[0])


def test_fusing_keeps_untold_headings_and_two_neighbours_apart() -> None:
    readings = [measured([[0.4, 0.1, np.nan], [0.4, -0.1, 1.0]], LENSES[0], "lens")]
    fused = robot_frame([*readings, *[Estimates.empty((0,), "lens")] * 2], LENSES)
    assert len(fused.seen) == 2
    assert np.isnan(fused.heading).sum() == 1
    assert np.isnan(fused.covariance[np.isnan(fused.heading), 2, 2]).all()
    assert len(robot_frame([Estimates.empty((0,), "lens")] * 3, LENSES).seen) == 0
