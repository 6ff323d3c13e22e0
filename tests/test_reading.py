"""Reading pictures: laws of every method, and the pictures that nobody expects."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from grain import add_noise
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmvision.camera import Lens
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.camera import LENSES, LensConfig
from swarmvision.config.marker import PRESETS
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.errors import ConfigError, PictureError
from swarmvision.geometry import wrap
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.perception.detect import candidates
from swarmvision.perception.edges import MOST, ROW, read_edges_into
from swarmvision.perception.gaze import Gaze
from swarmvision.perception.look import Proportions
from swarmvision.perception.plan import Scratch
from swarmvision.perception.segment import Balance, Hues
from swarmvision.rendering.raycast import Raycaster

LENS, ROBOT, ARENA = Lens.from_config(LENSES["pi-v1"]), RobotConfig(), ArenaConfig()
RAYCASTER = Raycaster(LENS, ROBOT, ARENA)
MARKER = Marker.from_config(ROBOT.marker)
EYE = np.zeros(3)
METHODS = pytest.mark.parametrize("method", ["edges", "fit", "moments"])


def picture(*poses: tuple[float, float, float]) -> np.ndarray:
    image = RAYCASTER.render(Scene.at_rest(poses), EYE)
    add_noise(image, 2.0, 3)
    return image


@METHODS
def test_an_empty_court_has_no_neighbours(method: str) -> None:
    estimates = Reader(LENS, MARKER, method).read(picture())
    assert estimates.seen.shape == (0,)
    assert estimates.frame == "lens"


@METHODS
def test_several_neighbours_are_read_nearest_first(method: str) -> None:
    estimates = Reader(LENS, MARKER, method).read(picture((0.5, 0.1, 1.2), (0.3, -0.08, 2.0)))
    assert len(estimates.seen) == 2
    np.testing.assert_allclose(estimates.range, [np.hypot(0.3, 0.08), np.hypot(0.5, 0.1)], rtol=0.02)
    np.testing.assert_allclose(estimates.bearing, np.arctan2([-0.08, 0.1], [0.3, 0.5]), atol=0.01)
    assert (np.diagonal(estimates.covariance, axis1=-2, axis2=-1)[:, :2] > 0).all()


@pytest.mark.parametrize("heading", np.radians(np.arange(-180, 180, 20)))
def test_edges_have_no_dead_zone(heading: float) -> None:
    estimates = Reader(LENS, MARKER).read(picture((0.4, 0.05, heading)))
    assert abs(float(wrap(estimates.heading[0] - heading))) < np.radians(2)


def test_the_papers_method_has_its_dead_zone() -> None:
    # The azimuth that faces the lens is pi - heading; at 20 deg it lies in 0..45 deg.
    estimates = Reader(LENS, MARKER, "moments").read(picture((0.3, 0.0, np.radians(160))))
    assert len(estimates.seen) == 1
    # The seam cuts the stripe in two and its centroid means another heading: untold, or told wrong.
    error = abs(float(wrap(estimates.heading[0] - np.radians(160))))
    assert np.isnan(error) or error > np.radians(15)


def test_half_hidden_and_cut_markers_are_read() -> None:
    # The far marker's middle lies on the near one's edge: 0.25 m away, 4.59 deg half angle.
    edge = np.arcsin(0.02 / 0.25)
    far = (0.6 * np.cos(edge), 0.6 * np.sin(edge), 1.0)
    estimates = Reader(LENS, MARKER).read(picture((0.25, 0.0, 0.5), far))
    assert len(estimates.seen) == 2
    assert estimates.range[1] == pytest.approx(0.6, rel=0.02)
    assert estimates.bearing[1] == pytest.approx(edge, abs=np.radians(0.3))
    assert estimates.visible[1] == pytest.approx(0.5, abs=0.1)
    border = LENS.fov / 2
    cut = Reader(LENS, MARKER).read(picture((0.4 * np.cos(border - 0.01), 0.4 * np.sin(border - 0.01), 1.0)))
    assert cut.range[0] == pytest.approx(0.4, rel=0.02)
    assert cut.bearing[0] == pytest.approx(border - 0.01, abs=np.radians(0.5))


@pytest.mark.parametrize("dim", [0.1, 0.4])
def test_a_dark_and_warm_picture_is_read_alike(dim: float) -> None:
    bright = picture((0.4, 0.05, 1.0))
    light = (bright / 255.0) ** 2.2 * dim * np.array([1.0, 0.85, 0.65])
    dark = np.rint(255 * light ** (1 / 2.2)).astype(np.uint8)
    estimates = Reader(LENS, MARKER).read(dark)
    assert len(estimates.seen) == 1
    assert estimates.range[0] == pytest.approx(np.hypot(0.4, 0.05), rel=0.02)
    assert estimates.heading[0] == pytest.approx(1.0, abs=np.radians(4))


def test_a_pole_without_a_pattern_works_from_its_description_alone() -> None:
    pole = PRESETS["pole-52x150"]
    lens = Lens.from_config(LensConfig(width_px=320, height_px=240, focal_px=265.0))
    image = Raycaster(lens, ROBOT.replace(marker=pole), ARENA).render(Scene.at_rest([[0.8, 0.1, 1.0]]), EYE)
    estimates = Reader(lens, Marker.from_config(pole)).read(image)
    assert len(estimates.seen) == 1
    assert estimates.range[0] == pytest.approx(np.hypot(0.8, 0.1), rel=0.02)
    assert estimates.bearing[0] == pytest.approx(np.arctan2(0.1, 0.8), abs=0.005)
    assert np.isnan(estimates.heading[0])


@pytest.mark.parametrize(("method", "within"), [("edges", 0.016), ("fit", 0.004)])
def test_a_pole_is_found_where_nothing_is_white(method: str, within: float) -> None:
    # The picture's brightest is a wooden wall; taken for white, it would turn the red band grey. Red before
    # brown is a faint edge: edges tell it within half of the pole's half width, fit within an eighth.
    pole = RobotConfig.model_validate({"marker": {"name": "pole", "radius": 0.026, "base": 0.05, "bands": [
        {"colour": colour, "height": 0.05} for colour in ("red", "blue", "yellow")]}})  # fmt: skip
    render = Raycaster(LENS, pole, ARENA).render
    image, bare = render(Scene.at_rest([[0.8, 0.1, 1.0]]), EYE), render(Scene.at_rest([]), EYE)
    image[(image == bare).all(axis=-1)] = (150, 84, 46)
    add_noise(image, 2.0, 3)
    estimates = Reader(LENS, Marker.from_config(pole.marker), method).read(image)
    np.testing.assert_allclose(estimates.range, [np.hypot(0.8, 0.1)], rtol=0.02)
    np.testing.assert_allclose(estimates.bearing, [np.arctan2(0.1, 0.8)], atol=within)


def test_coloured_clutter_is_no_neighbour() -> None:
    image = picture()
    image[100:140, 100:160] = (190, 38, 42)  # red over blue with nothing marker-like between
    image[200:240, 100:160] = (30, 62, 150)
    image[150:170, 300:500] = (226, 190, 32)
    image[300:340, 400:420] = (30, 62, 150)  # blue over red: upside down
    image[360:400, 400:420] = (190, 38, 42)
    assert len(Reader(LENS, MARKER).read(image).seen) == 0


@METHODS
@pytest.mark.parametrize(
    "bad", [np.zeros((460, 640), np.uint8), np.zeros((460, 640, 3)), np.zeros((10, 640, 3), np.uint8), None]
)
def test_what_is_no_picture_of_this_lens_is_refused(method: str, bad: object) -> None:
    with pytest.raises(PictureError, match=r"picture"):
        Reader(LENS, MARKER, method).read(bad)  # type: ignore[arg-type]


def test_an_unknown_method_is_refused() -> None:
    with pytest.raises(ConfigError, match="unknown method 'edge'; did you mean 'edges'"):
        Reader(LENS, MARKER, "edge")


@METHODS
@settings(max_examples=60, deadline=None)
@given(
    width=st.integers(1, 90),
    height=st.integers(1, 90),
    kind=st.sampled_from(["noise", "constant", "stripes", "palette"]),
    seed=st.integers(0, 10_000),
)
def test_no_picture_breaks_a_reader(method: str, width: int, height: int, kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    colours = np.array([(190, 38, 42), (228, 228, 224), (30, 62, 150), (226, 190, 32)], dtype=np.uint8)
    image = {
        "noise": rng.integers(0, 256, (height, width, 3)),
        "constant": np.full((height, width, 3), rng.integers(0, 256)),
        "stripes": np.repeat(colours[(np.arange(height) // 3) % 4][:, None], width, axis=1),
        "palette": colours[rng.integers(0, 4, (height, width))],
    }[kind]
    lens = Lens.from_config(LensConfig(width_px=width, height_px=height, focal_px=60.0))
    backwards = np.asarray(image, dtype=np.uint8)[:, ::-1]  # not contiguous
    estimates = Reader(lens, MARKER, method).read(backwards)
    assert np.isfinite(estimates.range).all()
    assert np.isfinite(estimates.bearing).all()
    assert (estimates.range > 0).all()


@pytest.mark.parametrize("method", ["edges", "fit"])
def test_plain_python_reads_the_same(method: str, tmp_path: Path) -> None:
    image = picture((0.9, 0.2, 1.2), (1.3, -0.2, 2.0))
    np.save(tmp_path / "picture.npy", image)
    code = (
        "import sys\n"
        "sys.modules['numba'] = None\n"
        "import numpy as np\n"
        "from swarmvision.compiled import HAS_NUMBA\n"
        "from swarmvision.camera import Lens\n"
        "from swarmvision.config.camera import LENSES\n"
        "from swarmvision.config.marker import MarkerConfig\n"
        "from swarmvision.marker import Marker\n"
        "from swarmvision.perception import Reader\n"
        "assert not HAS_NUMBA\n"
        "lens, marker = Lens.from_config(LENSES['pi-v1']), Marker.from_config(MarkerConfig())\n"
        "seen = Reader(lens, marker, sys.argv[1]).read(np.load(sys.argv[2]))\n"
        "print(*seen.range, *seen.bearing, *seen.heading, *seen.covariance.ravel())\n"
    )
    command = [sys.executable, "-c", code, method, str(tmp_path / "picture.npy")]
    plain = subprocess.run(command, capture_output=True, text=True, check=False)
    assert plain.returncode == 0, plain.stderr
    seen = Reader(LENS, MARKER, method).read(image)
    ours = np.concatenate([seen.range, seen.bearing, seen.heading, seen.covariance.ravel()])
    np.testing.assert_allclose([float(word) for word in plain.stdout.split()], ours, atol=1e-6)


def test_threads_share_a_reader() -> None:
    reader = Reader(LENS, MARKER)
    pictures = [picture((0.2 + 0.05 * i, 0.02 * i, 0.5 * i)) for i in range(8)]
    alone = [reader.read(image).heading for image in pictures]
    with ThreadPoolExecutor(4) as pool:
        together = [estimates.heading for estimates in pool.map(reader.read, pictures * 5)]
    np.testing.assert_array_equal(np.concatenate(together), np.tile(np.concatenate(alone), 5))


def test_reading_takes_no_memory() -> None:
    # numba counts: the headers of the arrays that are handed in, and nothing for what a picture shows.
    runtime = pytest.importorskip("numba.core.runtime")
    runtime._nrt_python.memsys_enable_stats()
    reader = Reader(LENS, MARKER)
    assert reader.task is not None
    scratch, rows = Scratch.of(LENS.width_px, LENS.height_px), np.empty((MOST, ROW))
    taken = []
    for image, markers in ((picture(), 0), (picture((0.5, 0.1, 1.2), (0.3, -0.08, 2.0)), 2)):
        before = runtime.rtsys.get_allocation_stats().alloc
        assert read_edges_into(image, reader.task, Gaze.at_all(reader.task), scratch, rows) == markers
        taken.append(runtime.rtsys.get_allocation_stats().alloc - before)
    assert taken[0] == taken[1] < 50


@pytest.mark.parametrize("tilt_deg", [-3.5, 0.0, 3.5])
def test_the_look_misses_no_row_that_matters(tilt_deg: float) -> None:
    # A small tilt moves the picture up or down: the horizon lies in another row than the lens says.
    shift = round(LENS.focal_px * np.tan(np.radians(tilt_deg)))
    for distance in (0.2, 0.3, 0.5, 0.8, 1.3, 2.0):
        image = np.roll(picture((distance, 0.1 * distance, 1.0)), shift, axis=0)
        hues = Hues.of(MARKER)
        proportions = Proportions.of(MARKER, hues)
        assert proportions is not None
        every = candidates(image, Balance.of(image), hues, proportions)
        assert len(every) == len(Reader(LENS, MARKER).read(image).seen) == 1


def test_perception_needs_numpy_and_opencv_alone() -> None:
    code = (
        "import sys\n"
        "for name in ('pydantic', 'numba', 'pymunk', 'scipy', 'pettingzoo', 'matplotlib', 'typer'):\n"
        "    sys.modules[name] = None\n"
        "import numpy as np\n"
        "from swarmvision.perception import Reader, fuse, track\n"
        "from swarmvision.camera import Lens\n"
        "from swarmvision.marker import Band, Marker\n"
        "bands = (Band(.05, .06, (190, 38, 42), None), Band(.01, .05, (228, 228, 224), None),\n"
        "         Band(0., .01, (30, 62, 150), None))\n"
        "marker = Marker('bare', .02, .055, bands)\n"
        "lens = Lens(640, 460, 634.6, (320., 230.), .085)\n"
        "image = np.full((460, 640, 3), 200, np.uint8)\n"
        "image[190:204, 293:347], image[256:270, 293:347] = (190, 38, 42), (30, 62, 150)\n"
        "image[204:256, 293:347] = 225\n"
        "for method in ('edges', 'fit', 'moments'):\n"
        "    print(len(Reader(lens, marker, method).read(image).seen))\n"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert result.stdout.split() == ["1", "1", "1"]
