"""Straightening: nothing for a straight lens, lines straight for a bent one, any size."""

from __future__ import annotations

import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.perception.straighten import Straightening

BENT = (-0.2, 0.05, 0.001, -0.001, 0.0)


def test_a_straight_lens_needs_none() -> None:
    image = np.random.default_rng(0).integers(0, 256, (46, 64, 3), dtype=np.uint8)
    lens = Lens(64, 46, 60.0, (32.0, 23.0), 0.085)
    np.testing.assert_array_equal(Straightening(lens).straight(image), image)


def test_a_bent_ramp_is_straight_again() -> None:
    # The bent picture shows in each pixel the column that its light came from.
    lens = Lens(200, 160, 200.0, (100.0, 80.0), 0.085, BENT)
    rows, columns = np.mgrid[:160, :200] + 0.5
    ideal = np.stack([columns, rows], axis=-1)
    for _ in range(50):  # the fixed point of ideal + (bent(ideal) - ideal) = pixel
        ideal += np.stack([columns, rows], axis=-1) - lens.distort(ideal)
    picture = np.repeat(np.rint(ideal[..., :1]).clip(0, 255), 3, axis=-1).astype(np.uint8)
    straight = Straightening(lens).straight(picture).astype(np.float64)
    inside = np.s_[30:-30, 30:-30]  # rounding to whole grey levels is half a column
    assert np.abs(straight[..., 0] - columns)[inside].max() <= 1.0


@pytest.mark.parametrize(("wide", "high"), [(1, 1), (1, 7), (7, 1), (2, 2)])
def test_any_size(wide: int, high: int) -> None:
    lens = Lens(wide, high, 10.0, (wide / 2, high / 2), 0.085, BENT)
    image = np.full((high, wide, 3), 9, dtype=np.uint8)
    np.testing.assert_array_equal(Straightening(lens).straight(image), image)
