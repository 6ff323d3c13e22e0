"""Lattices and triangles: what artificial physics and geometry bring about with true eyes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from neighbours import flock_at

from swarmvision.config.controller import ChainConfig, HanadaConfig, SpearsConfig
from swarmvision.config.model import validated
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.controllers import controller
from swarmvision.controllers.chain import chain_of
from swarmvision.controllers.crowd import crowd
from swarmvision.controllers.hanada import out_of_place
from swarmvision.controllers.spears import pull, transition_gain
from swarmvision.data import Estimates
from swarmvision.geometry import FloatArray
from swarmvision.simulation import run


def settled(robots: int, seconds: float, **changes: Any) -> FloatArray:
    """Places ``(r, 2)`` at the end of a run."""
    values = {"robots": robots, "seconds": seconds, "sensor": {"kind": "truth"}, "start": {"radius": 0.5}}
    return run(validated(ScenarioConfig, {**values, **changes}, "test"), 1).pose[-1, :, :2]


def bond_order(place: FloatArray, fold: int, link: float) -> float:
    """Mean over the places of |mean(exp(i fold angle))| over the bonds shorter than ``link`` (m)."""
    offset = place[None] - place[:, None]
    distance = np.hypot(offset[..., 0], offset[..., 1])
    bond = (distance > 0.0) & (distance < link)
    turn = np.where(bond, np.exp(1j * fold * np.arctan2(offset[..., 1], offset[..., 0])), 0.0)
    many = bond.sum(axis=1) >= 2
    return float(np.mean(np.abs(turn.sum(axis=1)[many]) / bond.sum(axis=1)[many]))


def test_spears_arranges_hexagons() -> None:
    place = settled(19, 40.0, controller={"law": "spears"})
    assert bond_order(place, 6, 1.3 * 0.25) > 0.95
    distance = np.hypot(*np.moveaxis(place[:, None] - place[None], -1, 0)) + np.eye(19)
    np.testing.assert_allclose(distance.min(axis=1), 0.25, atol=0.015)


def test_spears_arranges_squares_of_two_kinds() -> None:
    law = {"law": "spears", "lattice": "square"}
    other = {"name": "odd", "count": 8, "controller": {**law, "own_kind": 1}}
    place = settled(16, 60.0, controller=law, teams=[other])
    # Sixfold order would be 1 for hexagons and is 0 for squares; grain boundaries cost a little.
    assert bond_order(place, 4, 1.2 * 0.25) > 0.75
    assert bond_order(place, 6, 1.2 * 0.25) < 0.5


def test_the_transition_is_where_two_on_one_site_are_held_by_six() -> None:
    # Two robots on one site push each other with F_max. The six round it, at R, pull one of them, moved aside
    # by nothing yet, with G / R^p each; along any axis their pulls add up to 2 sqrt(3) at most.
    gain = transition_gain(1.0, 0.25, 2.0)
    assert 2.0 * np.sqrt(3.0) * gain / 0.25**2 == pytest.approx(1.0)


def test_the_force_turns_from_push_to_pull_at_the_spacing() -> None:
    config = SpearsConfig(spacing=0.25, strength=2.0)
    force = pull(np.array([0.05, 0.2, 0.25, 0.3]), config)
    # G / r^2 with G = 2 G_t = 0.25^2 / sqrt(3): 0.577 (0.25 / r)^2, at most 1.
    np.testing.assert_allclose(force, [-1.0, -0.9021, 0.0, 0.4009], atol=1e-4)


def test_three_robots_stand_in_an_equilateral_triangle() -> None:
    place = settled(3, 30.0, controller={"law": "hanada"})
    distance = np.hypot(*np.moveaxis(place[:, None] - place[None], -1, 0))
    np.testing.assert_allclose(distance[np.triu_indices(3, 1)], 0.30, atol=0.02)


def test_the_apex_is_straight_off_the_line_through_the_partners() -> None:
    # Partners at (0.5, +-0.15): the centroid with the robot is at x = 1/3, the apex 0.3 / sqrt(3) nearer.
    seen = Estimates.empty((2,))
    values = {"range": np.hypot(0.5, 0.15), "bearing": np.arctan2([0.15, -0.15], 0.5), "heading": 0.0}
    arrays: dict[str, Any] = {name: np.broadcast_to(value, (2,)) for name, value in values.items()}
    there = Estimates(
        seen=np.ones(2, dtype=bool),
        **arrays,
        covariance=seen.covariance,
        age=np.zeros(2),
        track=seen.track,
        visible=seen.visible,
    )
    way = out_of_place(crowd(there, 1.0), 0.3)
    assert way == pytest.approx(1.0 / 3.0 - 0.3 / np.sqrt(3.0))
    assert controller(HanadaConfig()).act(there).speed > 0.0


def test_robots_line_up_from_a_nest() -> None:
    goal = {"x": 0.0, "y": 0.0, "radius": 0.1}
    start = {"x": 0.9, "y": 0.0, "radius": 0.5}
    place = settled(6, 90.0, controller={"law": "chain"}, goal=goal, start=start)
    tolerance = 0.3 * 0.28
    away = np.sort(np.hypot(*place.T))
    np.testing.assert_allclose(away, 0.28 * np.arange(1, 7), atol=tolerance)
    ray = place[np.argmax(np.hypot(*place.T))] / away[-1]
    aside = place[:, 0] * ray[1] - place[:, 1] * ray[0]
    assert np.abs(aside).max() < 2.0 * tolerance


def test_the_next_place_of_a_chain_is_the_first_that_is_neither_taken_nor_hidden() -> None:
    config = ChainConfig(spacing=0.3, tolerance=0.3)

    def length(*places: tuple[float, float]) -> tuple[int, list[bool]]:
        chain = chain_of(crowd(flock_at(*places), 100.0), np.array(-1.0 + 0.5j), config)
        return int(chain.length), chain.exploring.tolist()

    # The nest is at (-1, 0.5), the chain along y = 0.5.
    assert length((-0.7, 0.5)) == (1, [False])
    assert length((-0.7, 0.5), (-0.4, 0.55), (0.9, 0.9)) == (2, [False, False, True])
    assert length((-0.7, 0.5), (-0.1, 0.5)) == (1, [False, True])  # the second place is free
    assert length((-0.7, 0.5), (-0.2, 0.25), (-0.1, 0.5)) == (3, [False, True, False])  # it is hidden
    alone = chain_of(crowd(Estimates.empty((0,)), 100.0), np.array(-1.0 + 0.0j), config)
    assert int(alone.length) == 0
    np.testing.assert_allclose(alone.at(np.array(0)), -0.7)
