"""Laws that every law keeps: mirror, order, empty, batches, finite for anything."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarmvision.config.controller import CohesionConfig, GauciConfig, KobotConfig
from swarmvision.controllers import controller
from swarmvision.controllers.kobot import proximal_force
from swarmvision.data import Commands, Estimates

CONFIGS = [KobotConfig(), GauciConfig(), CohesionConfig()]
LAWS = pytest.mark.parametrize("config", CONFIGS, ids=lambda config: config.law)


def seen(*neighbours: tuple[float, float, float], slots: int | None = None) -> Estimates:
    """Estimates ``(k,)`` of range, bearing, heading; the other slots are empty."""
    k = slots or len(neighbours)
    empty = Estimates.empty((k,))
    columns = {name: getattr(empty, name).copy() for name in ("seen", "range", "bearing", "heading", "age")}
    for i, (distance, bearing, heading) in enumerate(neighbours):
        columns["seen"][i] = True
        columns["range"][i], columns["bearing"][i], columns["heading"][i] = distance, bearing, heading
        columns["age"][i] = 0.0
    return Estimates(**columns, covariance=empty.covariance, track=empty.track, visible=empty.visible)


def close(one: Commands, two: Commands) -> None:
    np.testing.assert_allclose(one.speed, two.speed, atol=1e-12)
    np.testing.assert_allclose(one.turn_rate, two.turn_rate, atol=1e-12)


neighbours = st.lists(
    st.tuples(st.floats(0.05, 3.0), st.floats(-3.1, 3.1), st.one_of(st.floats(-3.1, 3.1), st.just(np.nan))),
    min_size=0,
    max_size=6,
)


@pytest.mark.parametrize("config", [KobotConfig(), CohesionConfig()], ids=lambda config: config.law)
@given(rows=neighbours)
def test_a_mirrored_world_gives_a_mirrored_command(
    config: Any, rows: list[tuple[float, float, float]]
) -> None:
    if not rows and config.alone == "scan":
        return  # a lone robot scans to the left, by declaration
    law = controller(config).act
    here, there = law(seen(*rows)), law(seen(*[(r, -b, -h) for r, b, h in rows]))
    np.testing.assert_allclose(there.speed, here.speed, atol=1e-9)
    turned = np.abs(np.abs(here.turn_rate) - config.turn_gain * np.pi) < 1e-6  # straight back: either way
    assert turned or there.turn_rate == pytest.approx(-here.turn_rate, abs=1e-9)


@LAWS
@given(rows=neighbours)
def test_commands_are_finite_and_order_and_padding_do_not_matter(
    config: Any, rows: list[tuple[float, float, float]]
) -> None:
    law = controller(config).act
    here = law(seen(*rows))
    assert np.isfinite([here.speed, here.turn_rate]).all()
    np.testing.assert_allclose(law(seen(*rows[::-1])).speed, here.speed, atol=1e-9)
    np.testing.assert_allclose(law(seen(*rows, slots=9)).speed, here.speed, atol=1e-9)


@LAWS
def test_a_batch_is_its_members(config: Any) -> None:
    law = controller(config).act
    rows = [seen((0.3, 0.2, 1.0), (0.5, -1.0, np.nan)), seen((0.2, 0.0, -2.0)), Estimates.empty((0,))]
    batch = law(Estimates.stack(rows))
    for i, row in enumerate(rows):
        close(law(row), Commands(batch.speed[i], batch.turn_rate[i]))
    worlds = Estimates.stack(rows).select((None, slice(None), slice(None)))
    close(Commands(batch.speed[None], batch.turn_rate[None]), law(worlds))


def test_a_lone_robot_does_what_was_declared() -> None:
    nobody = Estimates.empty((4,))
    keep = controller(KobotConfig(alone="keep")).act(nobody)
    assert (float(keep.speed), float(keep.turn_rate)) == (0.10, 0.0)
    scan = controller(KobotConfig(alone="scan")).act(nobody)
    assert scan.speed == 0.0
    assert scan.turn_rate > 0.0
    stop = controller(KobotConfig(alone="stop")).act(nobody)
    assert (float(stop.speed), float(stop.turn_rate)) == (0.0, 0.0)


def test_kobot_turns_towards_its_neighbours_heading() -> None:
    # At the desired range nothing pulls; with itself at 0 and one neighbour at 90 deg the mean is 45 deg.
    command = controller(KobotConfig()).act(seen((0.25, 0.0, np.pi / 2)))
    assert command.turn_rate == pytest.approx(2.0 * np.pi / 4)
    assert command.speed == pytest.approx(0.10 * np.cos(np.pi / 4))


def test_the_proximal_force_pushes_near_and_pulls_far() -> None:
    force = proximal_force(np.array([0.12, 0.185, 0.25, 0.425, 0.60]), KobotConfig())
    np.testing.assert_allclose(force, [-1, -0.25, 0, 0.25, 1])


def test_gauci_sends_the_two_pairs_of_wheel_speeds() -> None:
    law = controller(GauciConfig(speed=0.1, track=0.1)).act
    ahead, aside = law(seen((1.0, 0.05, 0.0))), law(seen((1.0, 0.2, 0.0)))
    assert (ahead.speed, ahead.turn_rate) == pytest.approx((0.0, -2.0))
    assert (aside.speed, aside.turn_rate) == pytest.approx((-0.085, -0.3))
