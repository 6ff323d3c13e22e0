"""Purely visual flocking meets the polarisations of a public simulation of the paper's model."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

STUDY = Path(__file__).parent.parent / "benchmarks" / "visual_flocking.py"


def study() -> ModuleType:
    spec = importlib.util.spec_from_file_location("visual_flocking", STUDY)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


# From a start near each other, so that gathering does not take long. Without gains nobody turns, and the
# polarisation is that of the start: many short runs tell its mean.
@pytest.mark.parametrize(
    ("gains", "steps", "worlds"), [((0.5, 0.1), 2000, 4), ((0.5, 2.0), 900, 3), ((0.0, 0.0), 2, 64)]
)
def test_the_regression_points_are_met(gains: tuple[float, float], steps: int, worlds: int) -> None:
    model = study()
    found, _ = model.polarisation(gains, steps, worlds, start=250.0)
    assert found == pytest.approx(model.POINTS[gains], abs=0.1)
