"""A sweep: the same whoever runs it, and it goes on where it was stopped."""

from __future__ import annotations

from pathlib import Path

import pytest

from swarmvision.errors import ConfigError
from swarmvision.experiments.sweep import RunSpec, repeated, sweep

TINY = ("robots=3", "seconds=1.0", 'sensor={kind="truth"}')


def test_processes_and_order_change_no_result() -> None:
    specs = repeated("flock", "flocking", TINY, range(3))
    one = sweep(specs)
    assert sweep(specs, processes=2) == one
    assert sweep(specs[::-1]) == one[::-1]
    assert [row["seed"] for row in one] == [0, 1, 2]
    assert len({row["state_sha256"] for row in one}) == 3


def test_a_stopped_sweep_goes_on(tmp_path: Path) -> None:
    specs = repeated("flock", "flocking", TINY, range(2))
    kept = tmp_path / "runs.jsonl"
    first = sweep(specs[:1], kept=kept)
    told: list[tuple[int, int]] = []
    both = sweep(specs, kept=kept, tell=lambda *count: told.append(count))
    assert told == [(2, 2)]
    assert both[0] == first[0]
    assert sweep(specs, kept=kept, tell=lambda *count: pytest.fail("nothing was left")) == both
    assert len(kept.read_text().splitlines()) == 2


def test_a_wrong_condition_is_refused_before_anything_runs(tmp_path: Path) -> None:
    kept = tmp_path / "runs.jsonl"
    specs = [RunSpec("good", "flocking", TINY), RunSpec("bad", "flocking", ("robotss=3",))]
    with pytest.raises(ConfigError, match="unknown setting 'robotss'"):
        sweep(specs, kept=kept)
    assert not kept.exists()


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    kept = tmp_path / "runs.jsonl"
    kept.write_text("no json\n")
    with pytest.raises(ConfigError, match="not a file of finished runs"):
        sweep([], kept=kept)


def test_no_runs_is_a_sweep() -> None:
    assert sweep([]) == []
