"""What a user meets: results on stdout, one clear line for every mistake."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.camera import LENSES
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.rendering.raycast import Raycaster

SCENARIOS = Path(__file__).parent.parent / "swarmvision" / "scenarios"
SMALL = [
    "--set",
    "seconds=1",
    "--set",
    "robots=3",
    "--set",
    'sensor.rig="ring-2"',
    "--set",
    "start.radius=0.4",
]


def swarmvision(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "swarmvision", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def refused(*arguments: object) -> str:
    """The one line that a mistake is answered with."""
    result = swarmvision(*arguments)
    assert result.returncode == 1, result.stderr
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1, result.stderr
    return lines[0]


@pytest.fixture(scope="module")
def picture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    lens = Lens.from_config(LENSES["pi-v1"])
    scene = Scene.at_rest([[0, 0, 0], [0.44, 0.05, 2.0]])
    image = Raycaster(lens, RobotConfig(), ArenaConfig()).render(scene, np.array([0.04, 0, 0]), 0)
    path = tmp_path_factory.mktemp("pictures") / "one.png"
    cv2.imwrite(str(path), image[..., ::-1])
    return path


def test_help_answers_without_heavy_imports() -> None:
    code = (
        "import sys; sys.argv = ['swarmvision', '--help']\n"
        "from swarmvision.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "heavy = {'numba', 'cv2', 'pymunk', 'pettingzoo', 'pydantic', 'matplotlib', 'scipy', 'numpy'}\n"
        "print('LOADED', sorted(heavy & set(sys.modules)))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "detect" in out
    assert "LOADED []" in out


def test_two_runs_of_one_seed_write_equal_bytes(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        result = swarmvision("run", "flocking", "--seed", 5, *SMALL, "--out", tmp_path / folder)
        assert result.returncode == 0, result.stderr
    for name in ("states.mcap", "summary.json", "perception.csv"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    assert json.loads((tmp_path / "a" / "summary.json").read_text())["seed"] == 5


def test_demo_writes_what_it_promises(tmp_path: Path) -> None:
    result = swarmvision("demo", "--robots", 2, "--seconds", 0.5, "--out", tmp_path / "demo")
    assert result.returncode == 0, result.stderr
    wanted = {"flocking.mp4", "flocking.png", "perception.csv", "states.mcap", "summary.json"}
    assert {path.name for path in (tmp_path / "demo").iterdir()} == wanted
    summary = json.loads((tmp_path / "demo" / "summary.json").read_text())
    keys = {"order", "largest_cluster", "contacts", "seed", "state_sha256", "perception"}
    assert keys <= set(summary)
    film = cv2.VideoCapture(str(tmp_path / "demo" / "flocking.mp4"))
    assert int(film.get(cv2.CAP_PROP_FRAME_COUNT)) == 5


def test_demo_shows_a_scenario_of_ones_own(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('name = "mine"\nrobots = 3\nseconds = 0.2\n')
    result = swarmvision(
        "demo",
        tmp_path / "mine.toml",
        "--controller",
        "vicsek",
        "--set",
        "robots=2",
        "--out",
        tmp_path / "out",
    )
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "out" / "mine.mp4").exists()
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["robots"] == 2


def test_demo_lists_the_scenarios() -> None:
    names = [line.split()[0] for line in swarmvision("demo", "--list").stdout.splitlines()]
    assert {"aggregation", "flocking", "herding", "lattice", "paper", "transport"} <= set(names)
    assert names == sorted(path.stem for path in SCENARIOS.glob("*.toml"))


def test_detect_prints_one_json_line_a_picture(picture: Path) -> None:
    result = swarmvision("detect", picture, picture, "--json")
    assert result.returncode == 0, result.stderr
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    assert len(lines) == 2
    (neighbour,) = lines[0]["neighbours"]
    # The lens is 0.04 m ahead, so the marker stands at (0.40, 0.05): 0.4031 m, 7.125 deg.
    assert neighbour["range"] == pytest.approx(np.hypot(0.40, 0.05), rel=0.01)
    assert neighbour["bearing"] == pytest.approx(np.arctan2(0.05, 0.40), abs=0.002)
    assert neighbour["heading"] == pytest.approx(2.0, abs=0.05)
    assert min(neighbour["range_std"], neighbour["bearing_std"], neighbour["heading_std"]) > 0
    assert neighbour["visible"] == pytest.approx(1.0, abs=0.05)


def test_detect_reads_on_after_a_picture_that_cannot_be_read(picture: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.png"
    broken.write_bytes(picture.read_bytes()[:200])
    result = swarmvision("detect", tmp_path / "none.png", broken, __file__, picture, "--json")
    assert result.returncode == 1
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 3
    assert "none.png: cannot be read: No such file" in lines[0]
    assert "broken.png: the picture is broken" in lines[1]
    assert "test_cli.py: neither a PNG nor a JPEG" in lines[2]
    assert json.loads(result.stdout)["image"] == str(picture)


def test_detect_refuses_a_picture_of_another_camera(picture: Path) -> None:
    line = refused("detect", picture, "--camera", "pi-v2")
    assert "640 x 460 px" in line
    assert "640 x 480 px" in line


def test_an_unknown_camera_marker_or_method_is_named(picture: Path) -> None:
    assert "unknown camera 'pi-v9'; did you mean" in refused("detect", picture, "--camera", "pi-v9")
    assert "unknown marker 'helix'" in refused("detect", picture, "--marker", "helix")
    assert "unknown method 'fits'" in refused("detect", picture, "--method", "fits")


def test_an_unknown_setting_is_answered_with_the_nearest(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("robbots = 3\n")
    line = refused("run", path)
    assert "mine.toml: unknown setting 'robbots'; did you mean 'robots'?" in line


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("robots=-1", "robots: Input should be greater than or equal to 0, got -1"),
        ("seconds=nan", "seconds: Input should be a finite number"),
        ("sensor.rig='ring-8'", "unknown rig 'ring-8'; did you mean"),
        ("controller.law='kobo'", "controller"),
        ("robots", "an override must read key=value, got 'robots'"),
    ],
)
def test_a_wrong_setting_is_named_with_rule_and_value(change: str, words: str) -> None:
    assert words in refused("run", "flocking", "--set", change)


def test_robots_that_do_not_fit_are_refused() -> None:
    line = refused("run", "flocking", "--set", "robots=100", "--set", "arena='paper'", "--set", "start={}")
    assert "100 robots do not fit the 1.14 x 0.63 m arena" in line


@pytest.mark.parametrize("verb", [("demo",), ("run", "flocking")])
def test_an_unwritable_folder_is_refused_before_any_work(verb: tuple[str, ...], tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("")
    line = refused(*verb, "--out", file / "folder")
    assert "cannot write results there" in line
    assert str(file) in line


def test_a_missing_or_broken_scenario_is_refused(tmp_path: Path) -> None:
    assert "none.toml: cannot be read: No such file" in refused("run", tmp_path / "none.toml")
    bad = tmp_path / "bad.toml"
    bad.write_bytes(b"\xff\x00 = [")
    assert "bad.toml: not valid TOML" in refused("run", bad)
    assert "unknown scenario 'floking'; did you mean 'flocking'?" in refused("demo", "floking")


def test_wrong_usage_exits_with_2() -> None:
    assert swarmvision("run").returncode == 2
    assert swarmvision("fly").returncode == 2


def test_the_schema_is_a_json_schema() -> None:
    schema = json.loads(swarmvision("schema").stdout)
    assert schema["properties"]["robots"]["minimum"] == 0


def test_the_doctor_says_that_the_default_renderer_draws() -> None:
    out = swarmvision("doctor").stdout
    assert "ok  raycast renderer" in out
