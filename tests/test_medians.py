"""Medians in place are those of NumPy, whatever the order and however many are the same."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from swarmvision.geometry import FloatArray
from swarmvision.perception.order import median_in_place, median_of, select, weighted_median

KINDS: dict[str, Callable[[np.random.Generator, int], FloatArray]] = {
    "any": lambda rng, n: rng.normal(size=n),
    "few": lambda rng, n: rng.integers(0, 3, n).astype(np.float64),
    "same": lambda rng, n: np.full(n, 7.0),
    "ascending": lambda rng, n: np.sort(rng.normal(size=n)),
    "descending": lambda rng, n: np.sort(rng.normal(size=n))[::-1].copy(),
}


def numbers(kind: str) -> list[FloatArray]:
    rng = np.random.default_rng(3)
    return [KINDS[kind](rng, n) for n in [*range(1, 40), 180, 501]]


@pytest.mark.parametrize("kind", KINDS)
def test_a_median_is_numpys_and_leaves_the_numbers_alone(kind: str) -> None:
    for values in numbers(kind):
        before = values.copy()
        assert median_of(values, len(values), np.empty(len(values))) == np.median(values)
        assert (values == before).all()
        assert median_in_place(values, len(values)) == np.median(before)
        assert (np.sort(values) == np.sort(before)).all()


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_selected_parts_the_smaller_from_the_larger(kind: str) -> None:
    rng = np.random.default_rng(4)
    for values in numbers(kind):
        place, before = int(rng.integers(len(values))), values.copy()
        chosen = select(values, len(values), place)
        assert chosen == values[place] == np.sort(before)[place]
        assert (values[:place] <= chosen).all()
        assert (values[place:] >= chosen).all()
        assert (np.sort(values) == np.sort(before)).all()


def test_the_median_of_nothing_is_nan() -> None:
    assert np.isnan(median_of(np.empty(0), 0, np.empty(0)))


@pytest.mark.parametrize("kind", KINDS)
def test_a_weighted_median_is_where_half_of_the_weight_is_passed(kind: str) -> None:
    rng = np.random.default_rng(5)
    for values in numbers(kind):
        n = len(values)
        weights = rng.uniform(0.1, 1.0, n)
        order = np.argsort(values, kind="stable")
        half = np.searchsorted(np.cumsum(weights[order]), 0.5 * weights.sum())
        assert weighted_median(values, weights, n, np.empty(n), np.empty(n)) == values[order][half]


def test_with_equal_weights_a_weighted_median_is_the_lower_one() -> None:
    for values in numbers("any"):
        n = len(values)
        middle = weighted_median(values, np.ones(n), n, np.empty(n), np.empty(n))
        assert middle == np.sort(values)[(n - 1) // 2]


def test_one_heavy_number_is_the_weighted_median() -> None:
    for values in numbers("any"):
        n = len(values)
        for heavy in range(0, n, 7):
            weights = np.where(np.arange(n) == heavy, 2.0 * n, 1.0)
            assert weighted_median(values, weights, n, np.empty(n), np.empty(n)) == values[heavy]
