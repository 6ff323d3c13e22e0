"""The paper's experiments come out as published, where its method can reach what it tells."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from swarmvision.experiments import paper
from swarmvision.experiments.apparatus import LENS, Apparatus
from swarmvision.marker import Marker
from swarmvision.perception.moments import smoothed


@pytest.fixture(scope="module")
def apparatus() -> Apparatus:
    return Apparatus()


@pytest.fixture(scope="module")
def fitted(apparatus: Apparatus) -> paper.Constants:
    return paper.constants(apparatus)


def test_the_constants_are_the_papers(fitted: paper.Constants) -> None:
    assert fitted.k == pytest.approx(3193.7, rel=0.02)
    assert fitted.k1[0] == pytest.approx(2.0951, rel=0.05)
    assert fitted.k1[-1] == pytest.approx(6.2095, rel=0.05)
    assert (np.diff(fitted.k1) > 0.0).all()
    # Eq. 8's k is the depth of a pixel: of the axis' depth over the focal length, nearly.
    np.testing.assert_allclose(fitted.aside_k, (fitted.aside_ranges + 2.0) / LENS.focal_px, rtol=0.03)


def test_table_1_of_moments_is_at_or_below_the_published(
    apparatus: Apparatus, fitted: paper.Constants
) -> None:
    table = paper.table_of_moments(apparatus, fitted)
    assert table.range_error_percent <= 0.414
    assert table.bearing_error_percent <= 4.044
    assert table.heading_error_percent <= 3.25
    # One centroid cannot do what the paper tells: the zone in which it fails is wider than 45 deg.
    assert 45.0 < table.dead_zone_deg < 160.0
    assert table.single_k_error_percent is not None
    assert table.single_k_error_percent > 1.0


def test_table_1_of_fit_is_ten_times_better(apparatus: Apparatus) -> None:
    table = paper.table_of_reader(apparatus, "fit")
    assert table.dead_zone_deg == 0.0
    assert table.range_error_percent < 0.2
    assert table.bearing_error_percent < 0.4044
    assert table.heading_error_percent < 0.325


def test_the_same_place_gives_the_same_picture(apparatus: Apparatus) -> None:
    one, again = (apparatus.picture(0.3, 1.0, 0.02) for _ in range(2))
    np.testing.assert_array_equal(one, again)
    assert not np.array_equal(one, apparatus.picture(0.3, 1.1, 0.02))


def test_markers_of_other_sizes_keep_their_rings() -> None:
    marker = Marker.from_config(paper.marker_of("wedge", 0.015, 0.07))
    assert marker.height == pytest.approx(0.07)
    assert marker.base + marker.height / 2.0 == pytest.approx(LENS.height)
    assert [round(1e3 * (band.top - band.bottom)) for band in marker.bands] == [10, 50, 10]


@pytest.mark.parametrize("kind", ["gaussian", "median", "bilateral", "none"])
def test_every_filter_keeps_an_even_picture(kind: str) -> None:
    even = np.full((20, 30, 3), 77, dtype=np.uint8)
    np.testing.assert_array_equal(smoothed(even, kind, 7), even)


def test_the_dead_zone_is_one_arc_round_the_seam() -> None:
    errors = np.zeros((2, len(paper.TURN)))
    errors[1, 3], errors[0, -2] = np.nan, 1.0
    told = paper._outside_dead_zone(errors.ravel()).reshape(2, -1)
    assert told[0].tolist() == told[1].tolist()
    assert told.sum() == 2 * (len(paper.TURN) - 4 - 2)
    assert not told[0, :4].any()
    assert not told[0, -2:].any()


def test_the_command_prints_one_object(tmp_path: Path) -> None:
    command = [sys.executable, "-c", "from swarmvision.cli import main; main()", "reproduce", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    results = json.loads(done.stdout)
    wanted = set(paper.PUBLISHED)
    assert wanted <= set(results["moments"])
    assert wanted <= set(results["fit"])
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    command = [sys.executable, "-c", "from swarmvision.cli import main; main()", "reproduce", "--out"]
    done = subprocess.run(
        [*command, str(tmp_path / "file" / "x")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "cannot write results there" in done.stderr
    assert "Traceback" not in done.stderr
