"""Neighbours remembered by their tracks, and expected where they will be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmvision.config.controller import FerranteConfig
from swarmvision.config.scenario import packaged_scenario
from swarmvision.controllers import controller
from swarmvision.controllers.anticipation import FARTHEST_SHIFT, Motion, anticipated, at_rest
from swarmvision.controllers.crowd import Crowd, crowd
from swarmvision.controllers.recall import earlier_slot, recalled
from swarmvision.data import Estimates, Senses
from swarmvision.simulation import run

ONE = np.array(7, dtype=np.uint64)
DT = 0.1


def looked(places: list[complex], tracks: list[int], turn_rate: float = 0.0) -> Senses:
    """What one robot senses of neighbours at some places in its frame (m)."""
    here, k = np.array(places), len(places)
    return Senses.of(
        Estimates(
            seen=np.ones(k, dtype=bool),
            range=np.abs(here),
            bearing=np.angle(here),
            heading=np.full(k, np.nan),
            covariance=np.tile(np.eye(3) * 1e-4, (k, 1, 1)),
            age=np.zeros(k),
            track=np.array(tracks),
            visible=np.ones(k),
        ),
        dt=DT,
        turn_rate=np.array(turn_rate),
    )


def told(looks: list[Senses], ahead: float, smoothing: float = 0.0) -> tuple[Crowd, Motion]:
    """The neighbours to come after the last of some looks."""
    motion = at_rest(FerranteConfig(), ONE)
    for senses in looks:
        others, motion = anticipated(crowd(senses.neighbours, np.inf), senses, motion, ahead, smoothing)
    return others, motion


@settings(deadline=None)  # the first call compiles
@given(
    st.lists(st.integers(-1, 9), max_size=8),
    st.lists(st.integers(0, 9), max_size=8, unique=True),
)
def test_a_value_is_recalled_by_the_number_of_its_track_from_whatever_slot(
    now: list[int], before: list[int]
) -> None:
    track, earlier = np.array(now, dtype=np.int64), np.array(before, dtype=np.int64)
    values = 10.0 + earlier.astype(np.float64)
    expected = [10.0 + number if number in before else np.nan for number in now]
    np.testing.assert_array_equal(recalled(values, earlier_slot(track, earlier)), expected)


def test_nobody_is_recalled_from_a_slot_that_held_nobody() -> None:
    slot = earlier_slot(np.array([-2, -1, 3]), np.array([-2, -1, -2]))
    np.testing.assert_array_equal(slot, [-1, -1, -1])


@pytest.mark.parametrize("turn_rate", [0.0, 1.3])
def test_who_moves_steadily_is_expected_where_it_will_be_however_the_robot_turns(turn_rate: float) -> None:
    start, velocity, ahead = np.array([0.4 + 0.1j, -0.3j]), np.array([-0.05 + 0.02j, 0.04j]), 0.6
    looks = []
    for n in range(3):
        frame = np.exp(-1j * turn_rate * DT * n)
        places = (start + velocity * DT * n) * frame
        looks.append(looked(list(places), [4, 2], turn_rate))
    expected = (start + velocity * (2 * DT + ahead)) * frame
    np.testing.assert_allclose(told(looks, ahead)[0].offset, expected, atol=1e-12)


def test_the_slot_of_a_neighbour_does_not_matter() -> None:
    first, second = [0.4 + 0.1j, -0.3j, 0.5j], [0.38 + 0.1j, -0.28j, 0.52j]
    straight = told([looked(first, [0, 1, 2]), looked(second, [0, 1, 2])], 0.6)[0].offset
    swapped = told([looked(first, [0, 1, 2]), looked(second[::-1], [2, 1, 0])], 0.6)[0].offset
    np.testing.assert_array_equal(straight, swapped[::-1])


def test_who_was_not_seen_before_or_has_no_track_is_where_it_is() -> None:
    newcomer = told([looked([0.3], [0]), looked([0.28, 0.5j], [0, 1])], 0.6)[0]
    assert newcomer.offset[0].real < 0.28
    assert newcomer.offset[1] == pytest.approx(0.5j)
    untracked = told([looked([0.3], [-1]), looked([0.28], [-1])], 0.6)[0]
    assert untracked.offset[0] == pytest.approx(0.28)


def test_a_glimpse_counts_little_where_velocities_are_smoothed() -> None:
    looks = [looked([0.3], [0]), looked([0.28], [0])]
    sharp, smooth = (told(looks, 0.6, smoothing)[0].offset[0].real for smoothing in (0.0, 0.3))
    assert sharp == pytest.approx(0.28 - 0.6 * 0.2)
    assert smooth == pytest.approx(0.28 - 0.6 * 0.2 * DT / (DT + 0.3))


def test_nobody_is_expected_to_pass_through_the_robot() -> None:
    others, _ = told([looked([0.5], [0]), looked([0.2], [0])], 10.0)
    assert others.distance[0] == pytest.approx((1.0 - FARTHEST_SHIFT) * 0.2)
    assert others.towards[0] == pytest.approx(1.0)


def test_no_time_ahead_is_the_law_of_the_paper_which_remembers_nothing() -> None:
    control = controller(FerranteConfig(anticipation=0.0))
    command, memory = control.step(looked([0.35j], [0]), control.begin(ONE))
    again, _ = control.step(looked([0.30j], [0]), memory)
    fresh, _ = control.step(looked([0.30j], [0]), control.begin(ONE))
    assert float(command.turn_rate) > float(again.turn_rate) == float(fresh.turn_rate)


def test_who_drifts_away_is_followed_before_it_has_gone_far() -> None:
    def turn_rate(places: list[complex], **settings: Any) -> float:
        control = controller(FerranteConfig(**settings))
        memory = control.begin(ONE)
        for place in places:
            command, memory = control.step(looked([place], [0]), memory)
        return float(command.turn_rate)

    drifting = [0.25j, 0.252j]
    assert turn_rate(drifting) > turn_rate(drifting, anticipation=0.0) > 0.0


def test_a_flock_that_looks_ahead_keeps_its_course_on_eyes_that_are_late() -> None:
    orders = []
    for anticipation in (0.0, 0.6):
        law = f'controller={{law="ferrante", anticipation={anticipation}}}'
        late = 'sensor={kind="truth", latency=0.1}'
        scenario = packaged_scenario("flocking", ["robots=10", "seconds=60", late, law])
        orders.append(np.median([run(scenario, seed).summary["order"] for seed in range(3)]))
    assert orders[0] < 0.95 < orders[1]
