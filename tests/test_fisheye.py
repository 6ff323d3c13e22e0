"""A fisheye as four straightened views that look from one place."""

from __future__ import annotations

import numpy as np
import pytest

from swarmvision.camera import Rig
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.camera import LENSES, RIGS, RigConfig, ServoConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import CameraSensorConfig
from swarmvision.data import Scene
from swarmvision.geometry import compose, polar
from swarmvision.sensing.camera import CameraSensor

FISHEYE = Rig.from_config(LENSES["fisheye-view"], RIGS["fisheye"])


def test_all_views_look_from_one_place() -> None:
    views = FISHEYE.robot_from_lens(0.0)
    np.testing.assert_allclose(views[:, :2], [[0.04, 0.0]] * 4)
    np.testing.assert_allclose(views[:, 2], np.radians([65, 65 / 3, -65 / 3, -65]))


def test_the_views_span_190_deg_and_have_a_near_marker_whole() -> None:
    half = FISHEYE.lens.fov / 2
    assert np.degrees(max(FISHEYE.yaws) + half) == pytest.approx(95, abs=0.2)
    # 60 deg of 193 px/rad at the middle are 2 * 193 * tan(30 deg) = 223 px.
    assert np.degrees(FISHEYE.lens.fov) == pytest.approx(60, abs=0.3)
    shared = FISHEYE.lens.fov - (FISHEYE.yaws[0] - FISHEYE.yaws[1])
    assert shared > 2 * np.arcsin(0.02 / 0.15)  # a marker of 2 cm radius, 15 cm from the lens


def test_a_servo_turns_one_place_about_the_axis() -> None:
    settings = RigConfig(yaws_deg=(30.0, -30.0), one_centre=True, servo=ServoConfig())
    rig = Rig.from_config(LENSES["fisheye-view"], settings)
    assert rig.servo is not None
    time = 0.1
    pan = float(rig.servo.pan(time))
    expected = compose([0.0, 0.0, pan], [[0.04, 0.0, np.pi / 6], [0.04, 0.0, -np.pi / 6]])
    np.testing.assert_allclose(rig.robot_from_lens(time), expected)


@pytest.mark.parametrize("bearing_deg", [-85.0, -43.0, 0.0, 43.0, 85.0])
def test_a_neighbour_is_read_from_pixels_to_either_side(bearing_deg: float) -> None:
    lens_to_marker = 0.35
    place = [0.04 + lens_to_marker * np.cos(np.radians(bearing_deg)), 0.35 * np.sin(np.radians(bearing_deg))]
    scene = Scene.at_rest([[0, 0, 0], [*place, 1.0]])
    settings = {"lens": "fisheye-view", "rig": "fisheye", "imperfections": "fisheye"}
    sensor = CameraSensor(
        CameraSensorConfig.model_validate(settings), RobotConfig(), ArenaConfig(), 2, 3, workers=1
    )
    read = sensor.sense(scene).select(0)
    distance, bearing, heading = polar(np.array([*place, 1.0]))
    (slot,) = np.flatnonzero(read.seen)
    # The marker is 22 px wide: half a pixel of it is 2 % of its range, and a pixel is 0.3 deg.
    assert read.range[slot] == pytest.approx(float(distance), rel=0.02)
    assert read.bearing[slot] == pytest.approx(float(bearing), abs=np.radians(0.3))
    # A turn climbs 3.28 cm, 18 px here: a pixel is 20 deg, and of 22 columns that each err one, 4.3 deg.
    assert read.heading[slot] == pytest.approx(float(heading), abs=np.radians(10))
