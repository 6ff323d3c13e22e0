"""The error model: laws of its chance, its tables, and the camera that it stands for."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from swarmvision.config.arena import ArenaConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import ErrorModelSensorConfig
from swarmvision.data import Estimates, Scene
from swarmvision.errors import ConfigError, DataError
from swarmvision.experiments.error_fit import fit
from swarmvision.experiments.flights import COLUMNS, FLIGHTS, MEASURED, REMEMBERED, Flight, record
from swarmvision.sensing.error_chance import bin_of, picked
from swarmvision.sensing.error_model import ErrorModelSensor
from swarmvision.sensing.error_numbers import grips
from swarmvision.sensing.error_table import DEVIATES, RANGES, TURNS, ErrorTable, provenance
from swarmvision.sensing.error_views import WHOLE, view_of

ROBOT = RobotConfig()
RADIUS = ROBOT.marker.radius
OPEN = ArenaConfig()


def sensor(robots: int, seed: int = 0, arena: ArenaConfig = OPEN, **settings: object) -> ErrorModelSensor:
    config = ErrorModelSensorConfig.model_validate(settings)
    return ErrorModelSensor(config, ROBOT, arena, robots, seed)


def scene(
    poses: object, time: float = 0.0, turn_rate: float = 0.2, objects: object = (), way: object = 0.0
) -> Scene:
    """Robots that say they turn; ``way`` is what their encoders say both tracks went (m)."""
    rest = Scene.at_rest(poses, objects)
    velocity = np.zeros_like(rest.pose)
    velocity[:, 2] = turn_rate
    return Scene(
        time=time,
        pose=rest.pose,
        velocity=velocity,
        wheel_speed=rest.wheel_speed,
        wheel_travel=np.broadcast_to(np.asarray(way, dtype=float).reshape(-1, 1), rest.wheel_travel.shape),
        object_pose=rest.object_pose,
        object_velocity=rest.object_velocity,
    )


def watched(one: ErrorModelSensor, poses: object, steps: int, turn_rate: float = 0.2) -> list[Estimates]:
    return [one.sense(scene(poses, 0.1 * step, turn_rate)) for step in range(steps)]


POSES = np.array([[0, 0, 0.3], [0.4, 0.1, 1.0], [-0.2, 0.5, -2.0], [0.3, -0.6, 3.0]])


def test_one_seed_is_one_run_and_another_another() -> None:
    one, two, other = (watched(sensor(4, seed), POSES, 10)[-1] for seed in (1, 1, 2))
    for name in ("seen", "range", "bearing", "heading", "covariance", "age", "track"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert not np.array_equal(one.range, other.range)


def test_a_mirrored_scene_gives_mirrored_estimates() -> None:
    here = watched(sensor(4), POSES, 8, 0.5)[-1]
    there = watched(sensor(4), POSES * [1, -1, -1], 8, -0.5)[-1]
    np.testing.assert_array_equal(here.seen, there.seen)
    np.testing.assert_allclose(here.range, there.range)
    np.testing.assert_allclose(here.bearing, -there.bearing, atol=1e-12)
    np.testing.assert_allclose(here.heading, -there.heading, atol=1e-12)


def test_somebody_far_away_shifts_nobody_s_chance() -> None:
    few = watched(sensor(4, neighbours=3), POSES, 10)
    more = watched(sensor(5, neighbours=3), np.vstack([POSES, [6.0, 6.0, 0.0]]), 10)
    for one, two in zip(few, more, strict=True):
        np.testing.assert_array_equal(one.range, two.range[:4])


@pytest.mark.parametrize("robots", [0, 1])
def test_nobody_is_seen_by_nobody_or_by_one(robots: int) -> None:
    assert not sensor(robots).sense(Scene.at_rest(np.zeros((robots, 3)))).seen.any()


def test_who_is_hidden_is_remembered_for_a_while_and_then_forgotten() -> None:
    wall = ArenaConfig(objects=(DiscConfig(x=0, y=0, radius=0.1, height=0.3),))
    pair = [[-0.4, 0, 0], [0.4, 0, np.pi]]
    one = sensor(2, arena=wall, neighbours=1, memory=0.5)
    away, between = [[3, 3, 0]], [[0, 0, 0]]
    for step in range(20):
        last = one.sense(scene(pair, 0.1 * step, 0.0, away))
    assert last.seen[0, 0]
    hidden = [one.sense(scene(pair, 2.0 + 0.1 * step, 0.0, between)) for step in range(200)]
    ages = [float(estimates.age[0, 0]) for estimates in hidden if estimates.seen[0, 0]]
    assert max(ages, default=0.0) <= 0.5 + 1e-9
    assert np.mean([estimates.seen[0, 0] for estimates in hidden[10:]]) < 0.5
    assert np.mean([np.nan_to_num(e.age[0, 0], nan=1.0) > 0 for e in hidden]) > 0.5


def test_who_is_hidden_is_believed_to_go_on_as_before() -> None:
    # Both drive abreast, 0.1 m/s ahead, until a disc stands between them.
    wall = ArenaConfig(objects=(DiscConfig(x=0, y=0, radius=0.1, height=0.3),))
    one = sensor(2, arena=wall, neighbours=1)
    off = []
    for step in range(40):
        x = 0.01 * step
        pair = [[x, 0, 0], [x, 0.5, 0]]
        estimates = one.sense(scene(pair, 0.1 * step, 0.0, [[x, 0.25 if step > 30 else 9.0, 0]], [x, x]))
        if step > 31 and estimates.seen[0, 0] and estimates.age[0, 0] > 0.0:
            place = estimates.positions[0, 0]
            off.append(np.hypot(place[0], place[1] - 0.5))
    assert len(off) > 4
    # Its way while it is hidden is 8 cm; standing still would be off by half of that in the middle.
    assert np.median(off) < 0.01


def test_an_observer_that_is_pushed_leaves_ghosts_and_begins_anew() -> None:
    pair = np.array([[0, 0, 0], [0.9, 0, 1.0]])
    one = sensor(2)
    before = [one.sense(scene(pair, 0.1 * step, 0.0)) for step in range(20)][-1]
    pushed = pair + np.array([[0, 0, 0.4], [0, 0, 0]])  # turned without its tracks: 0.36 m aside at 0.9 m
    after = one.sense(scene(pushed, 2.0, 0.0))
    assert before.seen[0].sum() == 1
    assert after.seen[0].sum() == 2
    assert after.track[0, 0] != before.track[0, 0]
    assert after.track[0, 1] == before.track[0, 0]
    np.testing.assert_allclose(after.bearing[0, :2], [-0.4, 0.0], atol=0.02)


@pytest.mark.parametrize("distance", [0.13, 0.16, 0.3])
def test_a_marker_is_cut_where_two_lenses_meet(distance: float) -> None:
    seam = np.pi / 7.0
    assert view_of(distance, 0.0, 1.0, RADIUS)[0] == WHOLE
    assert view_of(distance, seam, 1.0, RADIUS)[0] > WHOLE
    assert view_of(distance, seam, 0.0, RADIUS)[0] == 0
    for bearing in np.linspace(0.01, seam - 0.01, 9):
        view, side = view_of(distance, bearing, 1.0, RADIUS)
        assert view_of(distance, -bearing, 1.0, RADIUS) == (view, -side)
        for lens in range(-7, 8):  # seven lenses are alike
            assert view_of(distance, bearing + 2.0 * seam * lens, 1.0, RADIUS) == (view, side)


def test_a_sure_place_tells_the_pace_and_an_unsure_one_nothing() -> None:
    # A jump in a period at a constant acceleration is half of what the pace gained in it.
    assert grips(np.array(1e-9), np.array(1.0), 0.1) == pytest.approx(2.0, abs=1e-2)
    assert grips(np.array(1e3), np.array(1.0), 0.1) == pytest.approx(0.0, abs=1e-2)


def test_between_pictures_what_was_measured_grows_old() -> None:
    one = sensor(2, rate_hz=5.0, neighbours=1)
    pair = [[0, 0, 0], [0.4, 0, 1]]
    ages = [one.sense(scene(pair, 0.1 * step)).age[0, 0] for step in range(20)]
    measured = np.array(ages) == 0.0
    assert measured[::2].sum() > 6
    assert not measured[1::2].any()


def test_estimates_beyond_reach_are_dropped() -> None:
    pair = [[0, 0, 0], [1.0, 0, 0]]
    seen = [estimates.range for estimates in watched(sensor(2, reach=1.001), pair, 60)]
    ranges = np.concatenate([rows[np.isfinite(rows)] for rows in seen])
    assert len(ranges) > 0
    assert ranges.max() <= 1.001 + 0.3  # what is only remembered may drift beyond
    # Nobody is within 0.8 m; phantoms are seen in a few of a thousand pictures and live for up to 1 s.
    few = [estimates.seen.any() for estimates in watched(sensor(2, reach=0.8), pair, 100)]
    assert np.mean(few) < 0.2


def test_errors_have_the_quantiles_of_their_bin_and_neighbours_are_found_as_often() -> None:
    # Far apart pairs at one range: every pair is a sample of one bin, whatever its correlation in time.
    distance, turn, pairs = 0.5, 0.2, 400
    place = np.column_stack([np.arange(pairs) % 20, np.arange(pairs) // 20, np.zeros(pairs)]) * 4.0
    poses = np.vstack([place, place + np.array([distance, 0.0, 0.0])])
    table = ErrorTable.load()
    bins = (bin_of(RANGES, distance), bin_of(TURNS, turn), view_of(0.5, 0.0, 1.0, RADIUS)[0])
    estimates = watched(sensor(2 * pairs, neighbours=2), poses, 12, turn)[-1]
    fresh = (estimates.age[:pairs] == 0.0).any(axis=1)
    # A chain of two states is in the first for the share anew / (anew + 1 - again) of the time.
    share = table.anew[bins] / (table.anew[bins] + 1.0 - table.again[bins])
    assert fresh.mean() == pytest.approx(share, abs=4.0 * np.sqrt(share * (1.0 - share) / pairs))
    slot = np.argmax(estimates.age[:pairs] == 0.0, axis=1)[fresh]
    row = np.flatnonzero(fresh)
    for error, q, unit in (
        (estimates.range[row, slot] - distance, 0, distance**2),
        (estimates.bearing[row, slot], 1, 1.0),
        (estimates.heading[row, slot], 2, 1.0),
    ):
        for z in (-1.0, 0.0, 1.0):
            below = np.mean(error < picked(table.fresh[bins][q], 0, z) * unit)
            level = {-1.0: 0.1587, 0.0: 0.5, 1.0: 0.8413}[z]
            assert below == pytest.approx(level, abs=4.0 * np.sqrt(level * (1 - level) / len(row)))


def test_fitting_what_the_model_says_gives_the_model_back() -> None:
    rows = np.concatenate([record(FLIGHTS[1], seed, seed, "error_model") for seed in range(6)])
    again = fit(rows, RADIUS)
    table = ErrorTable.load()
    state = rows[:, COLUMNS.index("state")]
    common = (bin_of(RANGES, 0.5), bin_of(TURNS, 0.2), view_of(0.5, 0.0, 1.0, RADIUS)[0])
    # 6 runs of 8 robots and 40 pictures: some hundreds of samples in a usual bin.
    assert again.again[common] == pytest.approx(table.again[common], abs=0.05)
    middle = slice(len(DEVIATES) // 3, -len(DEVIATES) // 3)
    spread = table.fresh[common][2, -4] - table.fresh[common][2, 3]
    np.testing.assert_allclose(
        again.fresh[common][2, middle], table.fresh[common][2, middle], atol=0.25 * spread
    )
    assert np.count_nonzero(state == REMEMBERED) < np.count_nonzero(state == MEASURED)


def test_a_held_out_camera_run_is_told_from_the_model_by_chance_alone() -> None:
    # The wanderers' way does not depend on what they see: both sensors look at the same scenes.
    flight = Flight(5, 0.5, "wander", 25)
    camera, model = (record(flight, 4711, sensor=kind, reach=1.5) for kind in ("camera", "error_model"))
    rates, errors = [], []
    for rows in (camera, model):
        state = rows[:, COLUMNS.index("state")]
        rates.append(np.sum(state == MEASURED) / np.sum(state <= REMEMBERED))
        columns = [COLUMNS.index(name) for name in ("range_error", "bearing_error", "heading_error")]
        errors.append(np.abs(rows[state == MEASURED][:, columns]))
    # 20 pairs for 2.5 s, correlated over a few pictures: about 200 independent samples, 5 % may miss.
    assert rates[0] == pytest.approx(rates[1], abs=0.06)
    for share, factor in ((0.5, 1.8), (0.9, 1.8)):
        ratio = np.quantile(errors[1], share, axis=0) / np.quantile(errors[0], share, axis=0)
        assert (ratio > 1.0 / factor).all()
        assert (ratio < factor).all()


def test_the_file_says_where_it_comes_from() -> None:
    told = provenance()
    assert told["command"].startswith("swarmvision fit-error-model --rounds")
    assert told["pictures"] > 10_000
    assert told["sensor"]["method"] == "edges"
    assert {"swarmvision", "numpy"} <= set(told["versions"])


def test_the_file_written_is_the_file_read(tmp_path: Path) -> None:
    table = ErrorTable.load()
    path = tmp_path / "errors.json"
    path.write_text(table.as_json({"command": "test"}))
    again = ErrorTable.load(path)
    for field in fields(ErrorTable):
        np.testing.assert_array_equal(getattr(again, field.name), getattr(table, field.name))
    path.write_text(path.read_text().replace('"anew"', '"knew"'))
    with pytest.raises(ConfigError, match=r"errors.json: is no error model: KeyError: 'anew'"):
        ErrorTable.load(path)


def test_arrays_that_are_given_are_checked_and_become_read_only() -> None:
    empty = Estimates.empty((2, 3))
    arrays = {name: getattr(empty, name).copy() for name in ("seen", "range", "bearing", "heading")}
    arrays |= {name: getattr(empty, name).copy() for name in ("covariance", "age", "track", "visible")}
    given = Estimates.given(**arrays)
    assert given.range is arrays["range"]
    assert not arrays["range"].flags.writeable
    with pytest.raises(DataError, match=r"Estimates.age must be given as float64 of shape \(2, 3\)"):
        Estimates.given(**{**arrays, "age": np.zeros(3)})
