"""How well pictures are read, and whether the covariances know it: a table of hard cases.

    python benchmarks/reading_accuracy.py [--renderer mesh|raycast] [--pictures N] [--case NAME]

Pictures come from either renderer (the mesh renderer shares no code with perception) and then go through a
camera: defocus of 0.7 px, noise of 2 grey levels, JPEG 95 (4:4:4). A neighbour counts where at least half
of its width is in view and not hidden; an estimate is its match within 3 deg and 25 % of its range. NEES is
the squared error in units of the covariance that is told, over its degrees of freedom: 1 is honest, more is
overconfident.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.colour import decode, encode
from swarmvision.config.arena import ARENAS, ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.camera import LENSES, LensConfig
from swarmvision.config.marker import PRESETS
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import TruthSensorConfig
from swarmvision.data import Estimates, Scene
from swarmvision.geometry import FloatArray, compose, wrap
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.rendering.mesh import MeshRenderer
from swarmvision.rendering.raycast import Raycaster
from swarmvision.sensing.truth import TruthSensor

Image = NDArray[np.uint8]
PI, ROBOT, COURT = Lens.from_config(LENSES["pi-v1"]), RobotConfig(), ARENAS["open"]
POLE = ROBOT.replace(marker=PRESETS["pole-52x150"])
SMALL = Lens(320, 240, 317.3, (160.0, 120.0), PI.height)
LARGE = Lens(1280, 960, 1269.2, (640.0, 480.0), PI.height)
PI2 = Lens.from_config(LensConfig(width_px=320, height_px=240, focal_px=265.0))
POST = COURT.model_copy(update={"objects": (BoxConfig(x=0, y=0, length=0.02, width=0.1, height=0.2),)})
COLOURS = ("red", "blue", "yellow", "white")


class Draws(Protocol):
    """Either renderer."""

    def render(self, scene: Scene, lens_pose: FloatArray, observer: int | None = None) -> Image: ...


Renders = Callable[[Lens, RobotConfig, ArenaConfig], Draws]
RENDERERS: dict[str, Renders] = {"mesh": MeshRenderer, "raycast": Raycaster}


@dataclass(frozen=True)
class Shot:
    """A picture and what is in it: range, bearing, heading, visible fraction ``(n, 4)``."""

    image: Image
    lens: Lens
    marker: Marker
    truth: FloatArray


@dataclass(frozen=True)
class Case:
    """What is photographed."""

    near: float
    far: float
    robots: int = 1
    lens: Lens = PI
    robot: RobotConfig = ROBOT
    smear: int = 0
    dim: float = 1.0
    hidden: bool = False
    cut: bool = False
    aside: bool = False
    """Whether the picture's side passes through the outer half of the marker."""
    clutter: int = 0
    tilt: float = 0.0
    thinned: bool = False


CASES = {
    "0.09-0.14 m": Case(0.09, 0.14),
    "0.14-0.25 m": Case(0.14, 0.25),
    "0.25-0.5 m": Case(0.25, 0.5),
    "0.5-1 m": Case(0.5, 1.0),
    "1-1.5 m": Case(1.0, 1.5),
    "1.5-2.2 m": Case(1.5, 2.2),
    "four robots, 0.3-1.5 m": Case(0.3, 1.5, robots=4),
    "half hidden, 0.3-0.6 m": Case(0.3, 0.6, hidden=True),
    "one ring outside": Case(0.14, 0.22, cut=True),
    "cut by the side, 0.09-0.14 m": Case(0.09, 0.14, aside=True),
    "cut by the side, 0.14-0.3 m": Case(0.14, 0.3, aside=True),
    "11 px motion blur, 0.3-0.6 m": Case(0.3, 0.6, smear=11),
    "5 px motion blur, 0.3-1 m": Case(0.3, 1.0, smear=5),
    "a tenth of the light, 0.2-0.6 m": Case(0.2, 0.6, dim=0.1),
    "clutter, 0.3-1.2 m": Case(0.3, 1.2, robots=2, clutter=6),
    "320x240, 0.2-0.8 m": Case(0.2, 0.8, lens=SMALL),
    "1280x960, 0.3-2 m": Case(0.3, 2.0, lens=LARGE),
    "tilted by 3 deg, 0.3-1 m": Case(0.3, 1.0, tilt=3.0),
    "chroma thinned out (4:2:0), 0.3-1 m": Case(0.3, 1.0, thinned=True),
    "pole, 320x240, 0.3-2 m": Case(0.3, 2.0, lens=PI2, robot=POLE),
}


def shots(case: Case, renders: Renders, pictures: int) -> Iterator[Shot]:
    """Return so many pictures of a case; the same ones every time."""
    plain = renders(case.lens, case.robot, POST if case.hidden else COURT)
    sensor = TruthSensor(TruthSensorConfig(fov_deg=360), case.robot, COURT)
    marker = Marker.from_config(case.robot.marker)
    for seed in range(pictures):
        rng = np.random.default_rng(seed)
        there = _places(case, rng)
        eye = np.array([*rng.uniform(-4, 4, 2), rng.uniform(-3, 3)])
        poses = np.vstack([eye, compose(eye, there)])
        visible = sensor.sense(Scene.at_rest(poses)).visible[0]
        things = np.empty((0, 3))
        draws, truth = plain, np.column_stack([there, visible])
        if case.clutter:
            arena, things = _clutter(case, rng, eye, there)
            draws = renders(case.lens, case.robot, arena)
        if case.hidden:
            things, truth[0, 3] = _post(rng, eye, there[0], case), 0.5
        polar = np.column_stack(
            [np.hypot(there[:, 0], there[:, 1]), np.arctan2(there[:, 1], there[:, 0]), there[:, 2]]
        )
        truth[:, :3] = polar
        image = draws.render(Scene.at_rest(poses, things), eye, 0)
        lens = case.lens
        if case.tilt:
            image, truth = _tilted(image, lens, truth, rng, case)
        image = _photographed(image, rng, case)
        if case.cut:
            image, lens = _cropped(image, lens, truth[0], rng)
        yield Shot(image, lens, marker, truth)


def _places(case: Case, rng: np.random.Generator) -> FloatArray:
    """Return robots ``(n, 3)`` in the lens frame that do not stand in each other."""
    limit = 0.8 * case.lens.fov / 2.0
    placed: list[FloatArray] = []
    while len(placed) < case.robots:
        distance, bearing = rng.uniform(case.near, case.far), rng.uniform(-limit, limit)
        if case.aside:
            half = np.arcsin(case.robot.marker.radius / distance)
            bearing = np.sign(bearing) * (case.lens.fov / 2.0 - half * rng.uniform())
        place = np.array([distance * np.cos(bearing), distance * np.sin(bearing), rng.uniform(-np.pi, np.pi)])
        if all(np.hypot(*(place - other)[:2]) > 0.13 for other in placed):
            placed.append(place)
    return np.array(placed)


def _clutter(
    case: Case, rng: np.random.Generator, eye: FloatArray, robots: FloatArray
) -> tuple[ArenaConfig, FloatArray]:
    """Return boxes and posts in the marker's colours that stand behind all robots."""
    things: list[BoxConfig | DiscConfig] = []
    poses = []
    behind = np.hypot(robots[:, 0], robots[:, 1]).max() if len(robots) else 0.3
    for _ in range(case.clutter):
        distance, bearing = behind + rng.uniform(0.3, 2.0), rng.uniform(-0.45, 0.45)
        poses.append(compose(eye, np.array([distance * np.cos(bearing), distance * np.sin(bearing), 0.0])))
        colour, height = str(rng.choice(COLOURS)), float(rng.choice([0.065, 0.105, 0.115, 0.2]))
        size = float(rng.uniform(0.02, 0.2))
        if rng.random() < 0.5:
            things.append(BoxConfig(x=0, y=0, length=size, width=0.1, height=height, colour=colour))
        else:
            things.append(DiscConfig(x=0, y=0, radius=size / 3.0, height=height, colour=colour))
    return COURT.model_copy(update={"objects": tuple(things)}), np.array(poses).reshape(-1, 3)


def _post(rng: np.random.Generator, eye: FloatArray, robot: FloatArray, case: Case) -> FloatArray:
    """Return the pose of a grey post, 0.1 m wide, one side of which stands before the robot's axis."""
    bearing, distance = np.arctan2(robot[1], robot[0]), float(np.hypot(*robot[:2])) - 0.1
    aside = 0.05 if rng.random() < 0.5 else -0.05
    x = distance * np.cos(bearing) - aside * np.sin(bearing)
    y = distance * np.sin(bearing) + aside * np.cos(bearing)
    return np.asarray(compose(eye, np.array([x, y, bearing]))).reshape(1, 3)


def _tilted(
    image: Image, lens: Lens, truth: FloatArray, rng: np.random.Generator, case: Case
) -> tuple[Image, FloatArray]:
    """Return the picture by a lens that looks up or down and leans, and where it sees the markers."""
    up, lean = np.radians(rng.uniform(-case.tilt, case.tilt, 2))
    pitch = np.array([[1, 0, 0], [0, np.cos(up), -np.sin(up)], [0, np.sin(up), np.cos(up)]])
    roll = np.array([[np.cos(lean), -np.sin(lean), 0], [np.sin(lean), np.cos(lean), 0], [0, 0, 1]])
    # OpenCV counts pixel centres from 0.
    inner = np.array(
        [[lens.focal_px, 0, lens.centre_px[0] - 0.5], [0, lens.focal_px, lens.centre_px[1] - 0.5], [0, 0, 1]]
    )
    turn = roll @ pitch
    way = inner @ turn @ np.linalg.inv(inner)
    light = decode(image).astype(np.float32)
    size = (lens.width_px, lens.height_px)
    bent = cv2.warpPerspective(light, way, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    truth = truth.copy()
    for row in truth:
        # A marker's middle is as high as the lens: right, down, ahead.
        right, _, ahead = turn @ np.array([-np.sin(row[1]), 0.0, np.cos(row[1])])
        row[1] = np.arctan2(-right, ahead)
    return np.rint(encode(bent)).astype(np.uint8), truth


def _photographed(image: Image, rng: np.random.Generator, case: Case) -> Image:
    light = cv2.GaussianBlur(decode(image) * case.dim, (0, 0), 0.7)
    if case.smear:
        light = cv2.blur(light, (case.smear, 1))
    noisy = np.clip(np.rint(encode(light) + rng.normal(0.0, 2.0, image.shape)), 0, 255).astype(np.uint8)
    thinned = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420 if case.thinned else cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444
    quality = [cv2.IMWRITE_JPEG_QUALITY, 95, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, thinned]
    _, file = cv2.imencode(".jpg", noisy[..., ::-1], quality)
    return np.ascontiguousarray(np.asarray(cv2.imdecode(file, cv2.IMREAD_COLOR), dtype=np.uint8)[..., ::-1])


def _cropped(image: Image, lens: Lens, truth: FloatArray, rng: np.random.Generator) -> tuple[Image, Lens]:
    """Return the picture without one of the rings, which begin 20 mm above and below the lens."""
    rows = lens.focal_px * 0.020 / (truth[0] - 0.02) - 3.0
    if rng.random() < 0.5:
        image = image[: int(lens.centre_px[1] + rows)]
        return image, replace(lens, height_px=len(image))
    first = round(lens.centre_px[1] - rows)
    image = image[first:]
    centre = (lens.centre_px[0], lens.centre_px[1] - first)
    return image, replace(lens, height_px=len(image), centre_px=centre)


@dataclass
class Score:
    """What was found, how well, and how honestly."""

    wanted: int
    errors: FloatArray
    """Relative range, bearing, heading (rad), ``(n, 3)``."""
    nees: FloatArray
    """Over the degrees of freedom, ``(n,)``."""
    sigmas: FloatArray
    """Errors over their standard deviations, ``(n, 3)``."""
    phantoms: int


def score(pairs: list[tuple[Shot, Estimates]]) -> Score:
    """Return the score of what was read from pictures."""
    wanted = phantoms = 0
    errors, nees, sigmas = [], [], []
    for shot, seen in pairs:
        free = set(range(len(seen.seen)))
        matches = _matches(seen, shot.truth)
        free -= set(matches.values())
        for number, (distance, bearing, heading, visible) in enumerate(shot.truth):
            match = matches.get(number)
            wanted += visible >= 0.5
            if match is None:
                continue
            if visible < 0.5:
                continue
            off = np.array(
                [
                    seen.range[match] - distance,
                    wrap(seen.bearing[match] - bearing),
                    wrap(seen.heading[match] - heading),
                ]
            )
            told = np.isfinite(off)
            covariance = seen.covariance[match][np.ix_(told, told)]
            nees.append(off[told] @ np.linalg.solve(covariance, off[told]) / told.sum())
            sigmas.append(off / np.sqrt(np.diag(seen.covariance[match])))
            errors.append(np.abs(off) / [distance, 1.0, 1.0])
        phantoms += len(free)
    return Score(
        int(wanted),
        np.array(errors).reshape(-1, 3),
        np.array(nees),
        np.array(sigmas).reshape(-1, 3),
        phantoms,
    )


def _matches(seen: Estimates, truth: FloatArray) -> dict[int, int]:
    """Return which estimate belongs to which neighbour, the nearest pairs first."""
    off = np.abs(wrap(seen.bearing[:, None] - truth[:, 1])) / np.radians(3.0)
    off += np.abs(np.log(seen.range[:, None] / truth[:, 0])) / np.log(1.25)
    matches: dict[int, int] = {}
    for i, j in zip(*np.unravel_index(np.argsort(off, axis=None), off.shape), strict=True):
        if off[i, j] < 1.0 and int(j) not in matches and int(i) not in matches.values():
            matches[int(j)] = int(i)
    return matches


def line(name: str, method: str, judged: Score) -> str:
    """Return a row of the table."""
    if len(judged.errors) == 0:
        return f"| {name} | {method} | 0 / {judged.wanted} | | | | | {judged.phantoms} |"
    scale = [100.0, np.degrees(1.0), np.degrees(1.0)]
    half, most = (np.nanquantile(judged.errors, q, axis=0) * scale for q in (0.5, 0.95))
    cells = [
        f"{half[0]:.3f} / {most[0]:.3f}",
        f"{half[1]:.4f} / {most[1]:.4f}",
        "-" if np.isnan(half[2]) else f"{half[2]:.2f} / {most[2]:.2f}",
    ]
    squares = np.nanmean(np.square(judged.sigmas), axis=0) if len(judged.sigmas) else np.zeros(3)
    honest = f"{judged.nees.mean():.2f} ({', '.join(f'{s:.1f}' for s in squares)})"
    found = f"{len(judged.errors)} / {judged.wanted}"
    return f"| {name} | {method} | {found} | {' | '.join(cells)} | {honest} | {judged.phantoms} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--renderer", choices=RENDERERS, default="mesh")
    parser.add_argument("--pictures", type=int, default=40)
    parser.add_argument("--case", choices=CASES, action="append")
    options = parser.parse_args()
    print("| case | method | found | range % | bearing deg | heading deg | NEES (r, b, h) | phantoms |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for name in options.case or CASES:
        taken = list(shots(CASES[name], RENDERERS[options.renderer], options.pictures))
        for method in ("edges", "fit"):
            pairs = [(shot, Reader(shot.lens, shot.marker, method).read(shot.image)) for shot in taken]
            print(line(name, method, score(pairs)), flush=True)


if __name__ == "__main__":
    main()
