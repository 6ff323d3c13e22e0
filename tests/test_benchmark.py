"""The benchmark measures what it says it does; no time is asserted."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from swarmvision.benchmark import rivals
from swarmvision.benchmark.apart import Apart, apart
from swarmvision.benchmark.pictures import found, spoiled
from swarmvision.benchmark.process import alone
from swarmvision.benchmark.rival_detectors import aruco, finding_all, tags
from swarmvision.benchmark.stage import (
    DENSITY,
    DRAWN,
    HALF_VIEW,
    LENS,
    LENS_POSE,
    RATE,
    READ,
    in_view,
    lens_of,
    swarm,
    with_tags,
)
from swarmvision.benchmark.swarms import SENSORS, Episodes
from swarmvision.benchmark.table import table_text
from swarmvision.benchmark.timing import WALL, Absent, Call, LostError, difference, duration, medians, ratio

# A fresh machine compiles every kernel in the quick run.
pytestmark = pytest.mark.timeout(900)

PROMISED = {
    "pyrender_flat_over_raycast",
    "aruco_over_perceive",
    "paper_over_perceive",
    "naive_over_loop",
    "two_workers_over_one",
    "camera_pictures_per_second_core",
    "realtime_100_robots",
    "error_model_robot_steps_per_second_core",
}


@pytest.fixture(scope="module")
def quick(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Path]:
    """A quick run by the command, and its folder."""
    folder = tmp_path_factory.mktemp("bench")
    command = "from swarmvision.cli import main; main()"
    arguments = ["bench", "--quick", "--json", "--out", str(folder)]
    result = subprocess.run(
        [sys.executable, "-c", command, *arguments], capture_output=True, text=True, check=True
    )
    report: dict[str, Any] = json.loads(result.stdout)  # nothing else is on stdout
    return report, folder


def test_what_is_promised_is_there_and_positive_or_has_a_reason(quick: tuple[dict[str, Any], Path]) -> None:
    report, _ = quick
    assert set(report) >= PROMISED
    figures = {name: value for name, value in report.items() if name not in ("reasons", "curves", "machine")}
    assert {name for name, value in figures.items() if value is None} == set(report["reasons"])
    assert all(report["reasons"].values())
    # A difference of two noisy medians, and memory handed back, may be below 0.
    signed = {"imperfections_ms", "fit_ms_per_neighbour", "memory_growth_mb"}
    for name, value in figures.items():
        assert value is None or math.isfinite(value), name
        assert value is None or value > 0.0 or name in signed, name


def test_what_needs_no_rival_is_never_absent(quick: tuple[dict[str, Any], Path]) -> None:
    report, _ = quick
    for name in ("render_ms", "edges_ms", "paper_over_perceive", "loop_ms", "realtime_100_robots"):
        assert report[name] is not None
    assert report["machine"]["processor"]


def test_the_folder_holds_object_table_and_plot(quick: tuple[dict[str, Any], Path]) -> None:
    report, folder = quick
    assert json.loads((folder / "bench.json").read_text()) == report
    assert (folder / "bench.md").read_text() == table_text(report)
    assert (folder / "bench.png").read_bytes().startswith(b"\x89PNG")


def test_the_curves_are_as_long_as_their_abscissae(quick: tuple[dict[str, Any], Path]) -> None:
    report, _ = quick
    assert set(report["curves"]) == {"robots", "neighbours in view", "picture width (px)", "workers"}
    for curve in report["curves"].values():
        assert all(len(line) == len(curve["x"]) for line in curve["lines"].values())


def test_the_report_names_neither_machine_nor_folder(quick: tuple[dict[str, Any], Path]) -> None:
    report, _ = quick
    assert str(Path.home()) not in json.dumps(report)


def test_a_reason_passes_through_arithmetic() -> None:
    missing = Absent("not here")
    assert ratio(6.0, 2.0) == 3.0
    assert difference(6.0, 2.0) == 4.0
    assert ratio(missing, 2.0) is missing
    assert difference(6.0, missing) is missing


def test_a_rival_that_fails_is_absent_with_its_name_and_one_line() -> None:
    def broken() -> Any:
        raise OSError("no display\nand much more")

    assert rivals.attempt("pyrender", broken) == Absent("pyrender: no display")
    assert apart("aruco", "cv2", finding_all, aruco, np.zeros((9, 9, 3), np.uint8), 5) == (
        Absent("aruco: found 0 of 5 tags")
    )


def test_what_fails_in_a_process_of_its_own_is_absent_with_one_line() -> None:
    assert alone("memory", "raise OSError('too many')") == Absent("memory: OSError: too many")
    assert alone("memory", "import os; print(os.environ['HOW_MANY'])", {"HOW_MANY": "7"}) == 7.0


def test_a_flock_that_is_timed_begins_anew_when_its_time_is_over() -> None:
    episodes = Episodes(swarm(2, SENSORS["truth"]).replace(seconds=3 / RATE), workers=1)
    times = []
    for _ in range(7):
        episodes.step()
        assert episodes.simulation is not None
        times.append(round(episodes.simulation.scene.time * RATE))
    assert times == [1, 2, 3, 1, 2, 3, 1]


def test_a_rival_that_ends_its_process_is_absent_with_the_signal() -> None:
    reason = "doom: its process was ended by SIGSEGV"
    assert apart("doom", "os", _crashing, 0) == Absent(reason)  # before its first turn
    rival = apart("doom", "os", _crashing, 3)
    assert isinstance(rival, Apart)
    told = medians({"ours": lambda: None, "theirs": rival}, 0.0)  # and in the midst of it
    rival.close()
    assert told["theirs"] == Absent(reason)
    assert isinstance(told["ours"], float)


def test_a_rival_apart_takes_turns_until_it_is_closed() -> None:
    rival = apart("sleeper", "os", _sleeping)
    assert isinstance(rival, Apart)
    assert rival.duration(WALL) >= 0.001
    rival.close()
    with pytest.raises(LostError, match="sleeper: its process was ended"):
        rival.duration(WALL)
    assert apart("nobody", "no_such_module", _sleeping) == Absent("nobody: No module named 'no_such_module'")


def _crashing(_: ExitStack, turns: int) -> Call:
    left = [turns]

    def turn() -> None:
        if not left[0]:
            os.kill(os.getpid(), signal.SIGSEGV)
        left[0] -= 1

    return turn


def _sleeping(_: ExitStack) -> Call:
    return lambda: time.sleep(0.001)


def test_medians_tell_the_present_and_keep_the_absent() -> None:
    missing = Absent("not here")
    turns: list[str] = []
    calls: dict[str, Call | Absent] = {
        "one": lambda: turns.append("one"),
        "two": missing,
        "three": lambda: turns.append("three"),
    }
    told = medians(calls, 0.0)
    assert list(told) == ["one", "two", "three"]
    assert told["two"] is missing
    assert turns[-1] == "three"  # they take turns
    assert "one" in turns[len(turns) // 2 :]
    assert duration(lambda: None) >= 0.0
    assert medians({}, 0.0) == {}


@pytest.mark.parametrize("neighbours", [0, 1, READ, DRAWN, 32])
def test_every_neighbour_stands_in_view(neighbours: int) -> None:
    scene = in_view(neighbours)
    assert scene.robots == neighbours + 1
    places = scene.pose[1:, :2] - LENS_POSE[:2]
    assert (np.abs(np.arctan2(places[:, 1], places[:, 0])) <= HALF_VIEW).all()
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    assert (apart[np.triu_indices(neighbours, 1)] > 0.098).all()


@pytest.mark.parametrize("neighbours", [0, 1, READ, DRAWN])
def test_all_that_are_in_view_are_read(neighbours: int) -> None:
    assert found(neighbours) == neighbours


def test_a_smaller_picture_has_the_same_view() -> None:
    small = lens_of(80)
    assert small.fov == pytest.approx(LENS.fov)
    assert spoiled(small, in_view(1)).shape == (58, 80, 3)


def test_tags_are_found_where_markers_were() -> None:
    scene = in_view(READ)
    background = np.full((LENS.height_px, LENS.width_px, 3), 200, np.uint8)
    tagged = with_tags(background, scene, tags("DICT_4X4_50", 6, READ))
    assert aruco(tagged)() == READ
    assert aruco(background)() == 0


def test_swarms_of_every_size_have_one_density() -> None:
    for robots in (1, 100, 1000):
        scenario = swarm(robots, SENSORS["truth"])
        assert scenario.robots == robots
        assert scenario.start.radius is not None
        assert robots / (math.pi * scenario.start.radius**2) == pytest.approx(DENSITY)
