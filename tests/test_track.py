"""Neighbours over time, and over several lenses."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import fields
from itertools import permutations

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from swarmvision.config.sensor import TrackerConfig
from swarmvision.data import Estimates, Frame
from swarmvision.geometry import compose, inverse, polar, wrap
from swarmvision.perception.assignment import assignment
from swarmvision.perception.fuse import robot_frame
from swarmvision.perception.track import MOST_TRACKS, Tracker

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


def test_birth_takes_enough_looks_in_time() -> None:
    here, nobody = measured([[0.5, 0, 0]]), Estimates.empty((0,))

    def told(*looks: bool) -> list[int]:
        tracker = Tracker(TrackerConfig(confirm=2, confirm_within=3))
        return [len(tracker.step(here if look else nobody, 0, 0, 0.1).seen) for look in looks]

    assert told(True, False, True, False, False) == [0, 0, 1, 1, 1]
    assert told(True, False, False, True, False, True) == [0, 0, 0, 0, 0, 1]  # begun anew
    tracker = Tracker(TrackerConfig(confirm=2, confirm_within=3))
    tracker.step(here, 0, 0, 0.1)
    for _ in range(3):  # without a picture nothing is held against it
        tracker.step(None, 0, 0, 0.1)
    assert tracker.step(here, 0, 0, 0.1).track.tolist() == [0]


def test_mirrored_neighbours_make_mirrored_tracks() -> None:
    flip = np.array([1.0, -1.0, -1.0])
    left, right = Tracker(TrackerConfig()), Tracker(TrackerConfig())
    for step in range(8):
        poses = np.array([[0.5 + 0.01 * step, 0.1, 0.3], [0.3, -0.2 + 0.02 * step, 2.0 + 0.1 * step]])
        one = left.step(measured(poses), 0.1, 0.4, 0.1)
        two = right.step(measured(poses * flip), 0.1, -0.4, 0.1)
        np.testing.assert_allclose(one.range, two.range, atol=1e-12)
        np.testing.assert_allclose(one.bearing, -two.bearing, atol=1e-12)
        np.testing.assert_allclose(wrap(one.heading + two.heading), 0.0, atol=1e-12)


def test_a_crowd_beyond_the_room_for_tracks_is_cut_to_the_nearest() -> None:
    angles = np.linspace(-3.0, 3.0, MOST_TRACKS + 20)
    crowd = np.column_stack(
        [(0.5 + 0.01 * angles) * np.cos(angles), (0.5 + 0.01 * angles) * np.sin(angles), angles]
    )
    tracker = Tracker(TrackerConfig())
    seen = tracker.step(measured(crowd), 0, 0, 0.1)
    assert len(seen.seen) == MOST_TRACKS
    assert seen.range.max() < 0.53


def test_kernels_say_the_same_uncompiled() -> None:
    code = "import sys; sys.path.insert(0, 'tests'); from test_track import history; print(history())"
    plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    there = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=plain
    )
    np.testing.assert_allclose(np.array(json.loads(there.stdout)), np.array(json.loads(history())), atol=1e-9)


def history() -> str:
    """A short life of a tracker, as text."""
    tracker, out = Tracker(TrackerConfig()), []
    lenses = LENSES[:2]
    for step in range(6):
        poses = [[0.5, 0.1 * step - 0.3, 0.4], [0.6, 0.3 - 0.1 * step, np.nan], [0.52, 0.2, 2.0]]
        fused = robot_frame([measured(poses, lens, "lens") for lens in lenses], lenses)
        seen = tracker.step(fused, 0.1, 0.5, 0.1)
        out.append([seen.range.tolist()[:3], seen.bearing.tolist()[:3], seen.covariance[:3, 1, 1].tolist()])
    return json.dumps(out)


def test_a_neighbour_that_is_pushed_keeps_its_number() -> None:
    tracker = Tracker(TrackerConfig())
    for _ in range(10):
        tracker.step(measured([[0.5, 0.0, 0.0]]), 0, 0, 0.1)
    pushed = tracker.step(measured([[0.5, 0.06, 0.0]]), 0, 0, 0.1)
    assert pushed.track.tolist() == [0]
    assert pushed.positions[0, 1] == pytest.approx(0.06, abs=1e-6)
    another = tracker.step(measured([[0.5, 0.06, 0.0], [0.5, 0.2, 0.0]]), 0, 0, 0.1)
    assert another.track.tolist() == [0, 1]


def test_a_contested_neighbour_goes_to_the_track_that_fits_best() -> None:
    tracker = Tracker(TrackerConfig())
    for _ in range(5):
        tracker.step(measured([[0.5, 0.0, 0.0], [0.5, 0.12, 0.0]]), 0, 0, 0.1)
    # The second is hidden, and the first must not be taken for it.
    seen = tracker.step(measured([[0.5, 0.01, 0.0]]), 0, 0, 0.1)
    assert seen.age.tolist() == [0.0, pytest.approx(0.1)]


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


def test_who_tells_no_heading_still_helps_with_the_place() -> None:
    pose = [0.4, 0.3, 0.7]
    blind = [0.4, 0.3, np.nan]
    for one, two in ((pose, blind), (blind, pose)):
        readings = [measured([one], LENSES[0], "lens"), measured([two], LENSES[1], "lens")]
        fused = robot_frame(readings, LENSES[:2])
        np.testing.assert_allclose(world_poses(fused, (0, 0, 0)), [pose], atol=1e-9)
        alone = robot_frame([measured([pose], LENSES[0], "lens")], LENSES[:1])
        assert np.linalg.det(fused.covariance[0]) < np.linalg.det(alone.covariance[0])
    both = robot_frame([measured([blind], lens, "lens") for lens in LENSES[:2]], LENSES[:2])
    assert np.isnan(both.heading[0])
    assert np.isfinite(both.covariance[0, :2, :2]).all()


def test_the_order_of_lenses_does_not_matter() -> None:
    poses = [[0.4, 0.3, 0.7], [0.5, -0.3, 1.0]]
    readings = [measured(poses, lens, "lens") for lens in LENSES]
    one, two = robot_frame(readings, LENSES), robot_frame(readings[::-1], LENSES[::-1])
    np.testing.assert_allclose(one.range, two.range, atol=1e-12)
    np.testing.assert_allclose(one.covariance, two.covariance, atol=1e-12)
