"""What a user installs: one package, everything in it, every public name real."""

from __future__ import annotations

import json
import runpy
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import swarmvision
from swarmvision.data import Scene
from swarmvision.errors import DataError, OutputError
from swarmvision.recording import Recorder, read

ROOT = Path(__file__).parent.parent


def test_the_wheel_holds_one_package(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "build",
        "--wheel",
        "--no-isolation",
        "--outdir",
        str(tmp_path),
        str(ROOT),
    ]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    (wheel,) = tmp_path.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names} == {
        "swarmvision",
        f"swarmvision-{swarmvision.__version__}.dist-info",
    }
    for name in ("envs/flocking_v0.py", "controllers/kobot.py", "scenarios/flocking.toml", "py.typed"):
        assert f"swarmvision/{name}" in names
    sources = {f"{path.relative_to(ROOT)}" for path in (ROOT / "swarmvision").rglob("*.py")}
    assert len(sources) > 150
    assert sources <= set(names)


def test_every_public_name_exists() -> None:
    assert swarmvision.__all__ == sorted(swarmvision.__all__)
    for name in swarmvision.__all__:
        assert getattr(swarmvision, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'Swarm'"):
        _ = swarmvision.Swarm


@pytest.mark.parametrize("example", sorted((ROOT / "examples").glob("*.py")), ids=lambda path: path.stem)
def test_every_example_runs_and_says_something(example: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert len(example.read_text().splitlines()) < 60
    runpy.run_path(str(example), run_name="__main__")
    assert capsys.readouterr().out.strip()


def scenes(count: int) -> list[Scene]:
    rng = np.random.default_rng(0)
    return [
        Scene(0.1 * i, rng.random((2, 3)), rng.random((2, 3)), rng.random((2, 2)), rng.random((2, 2)),
              rng.random((1, 3)), rng.random((1, 3)))
        for i in range(count)
    ]  # fmt: skip


def test_a_recording_gives_back_what_was_written(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap") as recorder:
        for scene in scenes(50):
            recorder.write(scene)
    for one, two in zip(scenes(50), read(tmp_path / "run.mcap"), strict=True):
        assert one.time == two.time
        np.testing.assert_array_equal(one.pose, two.pose)
        np.testing.assert_array_equal(one.object_velocity, two.object_velocity)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_a_recording_that_was_cut_off_gives_what_is_whole(tmp_path: Path, share: float) -> None:
    path = tmp_path / "run.mcap"
    with Recorder(path) as recorder:
        for scene in scenes(600):
            recorder.write(scene)
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    got = read(path)
    assert 0.4 * share * 600 < len(got) <= 600
    np.testing.assert_array_equal(got[-1].pose, scenes(600)[len(got) - 1].pose)


def test_what_is_no_recording_is_refused(tmp_path: Path) -> None:
    junk = tmp_path / "junk.mcap"
    junk.write_text(json.dumps({"a": 1}))
    with pytest.raises(DataError, match=r"junk.mcap: not a recording"):
        read(junk)
    with pytest.raises(DataError, match=r"none.mcap: cannot be read"):
        read(tmp_path / "none.mcap")
    with pytest.raises(OutputError, match=r"cannot be written"):
        Recorder(junk / "below.mcap")
