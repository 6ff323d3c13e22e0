"""Sine, cosine and direction: as NumPy's, for any angle, and the same whether compiled or not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from swarmvision.geometry import wrap
from swarmvision.trigonometry import direction, sine_cosine, wrapped

ULP = np.finfo(np.float64).eps
ANGLES = np.concatenate(
    [np.random.default_rng(0).uniform(-1e3, 1e3, 2000), np.arange(-24, 25) * np.pi / 8.0, [0.0, 1e-300]]
)


def plain(kernel: Any) -> Any:
    return getattr(kernel, "py_func", kernel)


def test_sine_and_cosine_are_numpys() -> None:
    found = np.array([sine_cosine(angle) for angle in ANGLES])
    np.testing.assert_allclose(found[:, 0], np.sin(ANGLES), rtol=0, atol=ULP)
    np.testing.assert_allclose(found[:, 1], np.cos(ANGLES), rtol=0, atol=ULP)


def test_direction_is_numpys() -> None:
    x, y = np.random.default_rng(1).normal(size=(2, 2000)) * 10.0 ** np.arange(-10, 10).repeat(100)
    found = [direction(b, a) for a, b in zip(x, y, strict=True)]
    np.testing.assert_allclose(found, np.arctan2(y, x), rtol=2 * ULP, atol=0)


@pytest.mark.parametrize("zero", [0.0, -0.0])
def test_straight_behind_is_half_a_turn_to_the_left_and_nowhere_is_ahead(zero: float) -> None:
    assert direction(zero, -1.0) == np.pi
    assert direction(zero, 1.0) == 0.0
    assert direction(zero, 0.0) == 0.0
    assert np.isnan(direction(np.nan, np.nan))


def test_a_direction_turned_back_is_where_it_was() -> None:
    sine, cosine = np.array([sine_cosine(angle) for angle in ANGLES]).T
    found = [direction(s, c) for s, c in zip(sine, cosine, strict=True)]
    turned = np.angle(np.exp(1j * (np.array(found) - ANGLES)))
    np.testing.assert_allclose(turned, 0.0, atol=1e3 * ULP)  # of angles up to 1000 rad


def test_wrapping_is_that_of_poses() -> None:
    found = np.array([wrapped(angle) for angle in ANGLES])
    assert ((found > -np.pi) & (found <= np.pi)).all()
    np.testing.assert_allclose(np.exp(1j * found), np.exp(1j * wrap(ANGLES)), atol=1e3 * ULP)
    assert wrapped(-np.pi) == wrapped(np.pi) == np.pi


def test_the_same_lines_run_uncompiled() -> None:
    for angle in ANGLES[:100]:
        assert sine_cosine(angle) == plain(sine_cosine)(angle)
        assert direction(angle, 3.0) == plain(direction)(angle, 3.0)
        assert wrapped(angle) == plain(wrapped)(angle)
