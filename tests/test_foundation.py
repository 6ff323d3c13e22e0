"""Laws of the ground floors: angles, poses, lenses, drives, markers, colours, nouns."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarmvision.camera import Lens, Rig, Servo
from swarmvision.colour import decode, encode, rgb
from swarmvision.config.camera import LENSES, RIGS, ServoConfig
from swarmvision.config.marker import PRESETS, BandConfig, MarkerConfig, PatternConfig
from swarmvision.config.model import validated
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Commands, Estimates, Scene
from swarmvision.drive import Drive
from swarmvision.errors import ConfigError, DataError
from swarmvision.geometry import cartesian, compose, inverse, polar, wrap
from swarmvision.marker import SHAPES, Marker
from swarmvision.randomness import Subsystem, hashed, numbered, stream

finite = st.floats(-1e3, 1e3)
pose = st.tuples(finite, finite, st.floats(-10, 10))


@given(finite)
def test_wrapping_keeps_the_direction_within_its_interval(angle: float) -> None:
    wrapped = float(wrap(angle))
    assert -np.pi < wrapped <= np.pi
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-9)


def test_half_a_turn_is_positive() -> None:
    np.testing.assert_allclose(wrap([np.pi, -np.pi, 3 * np.pi]), np.pi)


@given(pose, pose, pose)
def test_composing_is_associative_and_inverts(
    a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]
) -> None:
    left, right = compose(compose(a, b), c), compose(a, compose(b, c))
    np.testing.assert_allclose(left[:2], right[:2], atol=1e-8)
    assert float(wrap(left[2] - right[2])) == pytest.approx(0, abs=1e-9)
    back = compose(inverse(a), compose(a, b))
    np.testing.assert_allclose(back[:2], b[:2], atol=1e-8)


def test_polar_inverts_cartesian() -> None:
    distance, bearing = np.array([0.1, 2.0]), np.array([3.0, -1.0])
    place = cartesian(distance, bearing)
    got = polar(np.column_stack([place, [0.0, 0.0]]))
    np.testing.assert_allclose(got[0], distance)
    np.testing.assert_allclose(got[1], bearing)


@pytest.mark.parametrize("name", LENSES)
def test_a_lens_inverts_columns_and_rows(name: str) -> None:
    lens = Lens.from_config(LENSES[name])
    columns = np.linspace(0, lens.width_px, 9)
    np.testing.assert_allclose(
        lens.column_from_bearing(lens.bearing_from_column(columns)), columns, atol=1e-9
    )
    rows = np.linspace(0, lens.height_px, 9)
    np.testing.assert_allclose(lens.row_from_rise(lens.rise_from_row(rows)), rows, atol=1e-9)


def test_the_presets_have_the_fields_of_view_that_their_makers_state() -> None:
    fov = {name: np.degrees(Lens.from_config(lens).fov) for name, lens in LENSES.items()}
    assert fov["pi-v1"] == pytest.approx(53.5, abs=0.1)
    assert fov["pi-v2"] == pytest.approx(62.2, abs=0.1)
    assert fov["pi-v3-wide"] == pytest.approx(102.0, abs=0.1)


def test_undistorting_inverts_distorting() -> None:
    config = LENSES["pi-v1"].replace(distortion=(-0.05, 0.03, 0.001, -0.0008, 0.002))
    lens = Lens.from_config(config)
    px = np.random.default_rng(0).uniform([0, 0], [640, 460], (50, 2))
    np.testing.assert_allclose(lens.undistort(lens.distort(px)), px, atol=1e-6)
    assert not np.allclose(lens.distort(px), px, atol=0.5)


@pytest.mark.parametrize("name", RIGS)
def test_the_lenses_of_a_rig_look_outwards_from_a_circle(name: str) -> None:
    rig = Rig.from_config(LENSES["pi-v1"], RIGS[name])
    poses = rig.robot_from_lens(0.3)
    if rig.one_centre:  # the views of one lens, ahead of the axis
        np.testing.assert_allclose(poses[:, :2], [[0.04, 0.0]] * len(poses), atol=1e-12)
        return
    np.testing.assert_allclose(np.hypot(poses[:, 0], poses[:, 1]), 0.04)
    np.testing.assert_allclose(wrap(np.arctan2(poses[:, 1], poses[:, 0]) - poses[:, 2]), 0, atol=1e-12)


def test_a_servo_sweeps_to_both_sides_at_its_speed() -> None:
    servo = Servo(amplitude=np.pi, speed=2 * np.pi)
    # Left first: a quarter of the 2 s period to the left end, three quarters to the right end.
    np.testing.assert_allclose(servo.pan([0, 0.5, 1.0, 1.5, 2.0]), [0, np.pi, 0, -np.pi, 0], atol=1e-9)
    time = np.linspace(0.01, 1.99, 40)
    slope = (servo.pan(time + 1e-6) - servo.pan(time - 1e-6)) / 2e-6
    np.testing.assert_allclose(slope, servo.pan_rate(time), rtol=1e-4)


def test_a_servo_with_stops_rests_while_a_picture_is_taken() -> None:
    servo = Servo(np.pi, 0.0, stops=9, interval=0.1, rest=0.033)
    pictures = np.arange(40) / 10.0
    stops = servo.pan(pictures)
    np.testing.assert_array_equal(servo.pan_rate(pictures), 0.0)
    np.testing.assert_allclose(servo.pan(pictures + 0.0329), stops)
    np.testing.assert_allclose(np.degrees(stops[:7]), [0, 40, 80, 120, 160, 120, 80], atol=1e-9)
    assert len({round(stop, 9) for stop in stops[:16]}) == 9  # all of them in one sweep to and fro
    np.testing.assert_allclose(stops[16:], stops[:-16], atol=1e-12)
    moving = np.arange(0.0, 4.0, 1e-3) + 5e-4
    slope = np.diff(servo.pan(moving)) / 1e-3
    agree = np.abs(slope - servo.pan_rate(moving[:-1] + 5e-4)) < 1e-6
    assert agree.mean() > 0.95  # but for the corners, 2 in 100


def test_a_servo_that_is_too_slow_for_its_stops_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"360 deg/s needs more than the 0.067 s .* 40 deg"):
        validated(ServoConfig, {"stops": 9, "speed_deg": 360}, "servo")


DRIVE = Drive.from_config(RobotConfig())


@given(st.floats(-0.3, 0.3), st.floats(-3, 3))
def test_wheel_speeds_invert_and_saturation_keeps_the_curvature(speed: float, turn_rate: float) -> None:
    wheels = DRIVE.wheel_speeds(speed, turn_rate)
    np.testing.assert_allclose(DRIVE.twist(wheels), (speed, turn_rate), atol=1e-12)
    limited = DRIVE.saturate(10 * wheels)
    assert np.abs(limited).max() <= DRIVE.max_wheel_speed + 1e-12
    assert limited[0] * wheels[1] == pytest.approx(limited[1] * wheels[0], abs=1e-12)


def test_wheels_reach_63_percent_in_one_time_constant() -> None:
    got = DRIVE.lag(np.zeros(2), np.ones(2), DRIVE.time_constant)
    np.testing.assert_allclose(got, 1 - np.exp(-1))


def test_the_helix_has_the_papers_measures() -> None:
    marker = Marker.from_config(PRESETS["helix-40x60"])
    assert marker.patterned is not None
    assert marker.patterned.pattern is not None
    low, high = marker.patterned.pattern.span([0.0, np.pi, 2 * np.pi - 1e-9])
    np.testing.assert_allclose((low + high) / 2, [0.0136, 0.0300, 0.0464], atol=1e-9)
    np.testing.assert_allclose(high - low, 0.0072)
    top_to_bottom = marker.colour_at(np.full(5, np.pi), [0.055, 0.045, 0.03, 0.015, 0.005])
    wanted = [rgb(c) for c in ("red", "white", "yellow", "white", "blue")]
    np.testing.assert_array_equal(top_to_bottom, wanted)


@pytest.mark.parametrize("kind", SHAPES)
def test_patterns_stay_in_their_band_and_symmetric_ones_are_symmetric(kind: str) -> None:
    pattern_config = PatternConfig.model_validate({"kind": kind})
    bands = (PRESETS["helix-40x60"].bands[0], BandConfig(colour="white", height=0.04, pattern=pattern_config))
    marker = Marker.from_config(MarkerConfig(bands=(*bands, PRESETS["helix-40x60"].bands[-1])))
    assert marker.patterned is not None
    pattern = marker.patterned.pattern
    assert pattern is not None
    phi = np.linspace(0.01, 2 * np.pi - 0.01, 500)
    low, high = pattern.span(phi)
    assert (low >= 0.01 - 1e-12).all()
    assert (high <= 0.05 + 1e-12).all()
    assert (high >= low).all()
    mirrored = np.stack(pattern.span(-phi))
    assert np.allclose(mirrored, [low, high], atol=1e-9) == pattern.symmetric


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"bands": [{"colour": "red", "height": 0.1}] * 2}, "neighbouring bands must differ"),
        ({"bands": [{"colour": "rd", "height": 0.1}] * 2}, "unknown colour 'rd'; did you mean 'red'"),
        ({"radius": -1}, "radius: Input should be greater than 0"),
    ],
)
def test_a_marker_that_cannot_be_is_refused(values: dict[str, object], words: str) -> None:
    from swarmvision.config.model import validated

    with pytest.raises(ConfigError, match=words):
        validated(MarkerConfig, values, "marker.toml")


def test_srgb_inverts_and_is_the_standards() -> None:
    codes = np.arange(256)
    np.testing.assert_allclose(encode(decode(codes)), codes, atol=1e-9)
    assert float(decode(188)) == pytest.approx(0.5029, abs=1e-4)  # half the light is code 188


def test_estimates_are_checked_read_only_and_padded() -> None:
    row = Estimates.empty((2,))
    with pytest.raises(ValueError, match="read-only"):
        row.range[0] = 1.0
    stacked = Estimates.stack([Estimates.empty((2,)), Estimates.empty((0,)), Estimates.empty((3,))])
    assert stacked.seen.shape == (3, 3)
    assert stacked.select(1).seen.shape == (3,)
    assert stacked.count.tolist() == [0, 0, 0]
    assert Estimates.stack([]).seen.shape == (0, 0)
    with pytest.raises(DataError, match=r"Commands.turn_rate must have shape \(2,\), got \(3,\)"):
        Commands(np.zeros(2), np.zeros(3))
    with pytest.raises(DataError, match=r"Scene.velocity must have shape \(1, 3\), got \(0, 3\)"):
        Scene(0.0, np.zeros((1, 3)), *[np.zeros((0, 3))] * 5)


def test_streams_are_apart_and_repeat() -> None:
    one, again = stream(5, Subsystem.SENSOR, 3).random(4), stream(5, Subsystem.SENSOR, 3).random(4)
    other = stream(5, Subsystem.SENSOR, 4).random(4)
    np.testing.assert_array_equal(one, again)
    assert not np.array_equal(one, other)


def test_numbered_is_split_mix_without_its_lowest_bit() -> None:
    published = [6457827717110365317, 3203168211198807973, 9817491932198370423]  # of the seed 1234567
    assert numbered(1234567, np.arange(3)).tolist() == [number >> 1 for number in published]
    key = hashed(5, Subsystem.SENSOR, 1, 2)
    assert len(set(numbered(key, np.arange(1000)).tolist())) == 1000
