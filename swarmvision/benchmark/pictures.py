"""One picture: what drawing, spoiling and reading it cost, beside renderers and detectors of others."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from swarmvision.benchmark import rival_detectors as detectors
from swarmvision.benchmark import rival_renderers as renderers
from swarmvision.benchmark import rivals
from swarmvision.benchmark.apart import Apart, apart
from swarmvision.benchmark.stage import (
    ARENA,
    DRAWN,
    LENS_POSE,
    LENS_POSES,
    MARKER,
    NOISE,
    READ,
    ROBOT,
    TURN_RATE,
    Image,
    in_view,
    lens_of,
    with_tags,
)
from swarmvision.benchmark.timing import Absent, Call, Effort, Figure, difference, medians
from swarmvision.camera import Lens
from swarmvision.config.imperfections import IMPERFECTIONS, ImperfectionsConfig
from swarmvision.data import Scene
from swarmvision.perception import Reader
from swarmvision.rendering.exposing import photograph
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.rendering.raycast import Raycaster

FULL_WIDTH = 640  # px, of the paper's pictures
DETECTORS = {
    "aruco": ("cv2", "DICT_4X4_50", 6, detectors.aruco),
    "apriltag": ("pupil_apriltags", "DICT_APRILTAG_36h11", 8, detectors.apriltag),
    "locus": ("locus", "DICT_APRILTAG_36h11", 8, detectors.locus),
}
"""The module it is in, OpenCV's name of the tags, their width in modules, and who finds them."""


@dataclass(slots=True)
class _Counter:
    """Keys of pictures, so that no two have the same noise."""

    key: int = 0

    def next(self) -> int:
        self.key += 1
        return self.key


def drawing(effort: Effort) -> dict[str, Figure]:
    """Return what a picture with ``DRAWN`` neighbours costs (ms): ours, with noise, spoiled, and rivals."""
    lens, scene = lens_of(FULL_WIDTH), in_view(DRAWN)

    def plain(*, shaded: bool) -> Callable[[], Call]:
        def build() -> Call:
            renderer = renderers.PlainPyrender(lens, DRAWN, shaded=shaded)
            return lambda: renderer.render(scene, LENS_POSE, 0)

        return build

    calls: dict[str, Call | Absent] = {
        "render": _render(lens, scene),
        "render_with_noise": _render(lens, scene, NOISE),
        "render_and_spoil": _render(lens, scene, IMPERFECTIONS["pi-v1"]),
        "pyrender_flat": rivals.attempt("pyrender", plain(shaded=False)),
        "pyrender_shaded": rivals.attempt("pyrender", plain(shaded=True)),
        "vizdoom": apart("vizdoom", "vizdoom", renderers.vizdoom),
        "pybullet": apart("pybullet", "pybullet", renderers.pybullet, scene),
        "copy": _copy(lens),
    }
    return _beside(calls, 2.0 * effort.seconds, elsewhere=("vizdoom",))


def reading(effort: Effort) -> dict[str, Figure]:
    """Return what reading a picture with ``READ`` neighbours costs (ms): ours, the paper's, tag detectors.

    Tags stand in the markers' places and are as wide; every detector must find all of them. The camera is
    at rest: ArUco loses tags to the blur of a turn.

    Raises:
        RuntimeError: If ``edges`` or ``fit`` misses a neighbour: a cost without the work would mean nothing.
    """
    lens, scene = lens_of(FULL_WIDTH), in_view(READ)
    picture = spoiled(lens, scene, 0.0)
    for method in ("edges", "fit"):
        if (told := len(Reader(lens, MARKER, method).read(picture).seen)) != READ:
            raise RuntimeError(f"{method} tells {told} of {READ} neighbours")
    calls: dict[str, Call | Absent] = {
        method: _read(lens, picture, method) for method in ("edges", "fit", "moments")
    }
    for name, (module, family, modules, detector) in DETECTORS.items():
        tagged = _tagged(lens, scene, family, modules)
        calls[name] = apart(name, module, detectors.finding_all, detector, tagged, READ)
    calls["aruco_on_markers"] = rivals.attempt("aruco", lambda: detectors.aruco(picture))
    return _beside(calls, 2.0 * effort.seconds)


def by_neighbours(effort: Effort) -> dict[int, dict[str, Figure]]:
    """Return what drawing, spoiling and reading cost (ms) with so many neighbours in view."""
    lens = lens_of(FULL_WIDTH)
    return {n: _costs(lens, in_view(n), n, effort.seconds / 2.0) for n in effort.neighbours}


def by_width(effort: Effort) -> dict[int, dict[str, Figure]]:
    """Return what drawing, spoiling and reading cost (ms) at so many columns, ``DRAWN`` in view."""
    return {w: _costs(lens_of(w), in_view(DRAWN), DRAWN, effort.seconds / 2.0) for w in effort.widths_px}


def found(neighbours: int) -> int:
    """Return how many neighbours ``edges`` tells in the picture with so many in view."""
    lens = lens_of(FULL_WIDTH)
    return len(Reader(lens, MARKER, "edges").read(spoiled(lens, in_view(neighbours))).seen)


def drawn(lens: Lens, scene: Scene) -> Image:
    """Return a perfect picture from ``LENS_POSE``."""
    return Raycaster(lens, ROBOT, ARENA).render(scene, LENS_POSE, 0)


def spoiled(lens: Lens, scene: Scene, turn_rate: float = TURN_RATE) -> Image:
    """Return a picture by the Pi camera of a robot that turns (rad/s)."""
    raycaster, camera = Raycaster(lens, ROBOT, ARENA), Imperfections(IMPERFECTIONS["pi-v1"], lens)
    return photograph(raycaster, camera, scene, LENS_POSE, 0, key=1, turn_rate=turn_rate)


def _beside(
    calls: Mapping[str, Call | Absent], seconds: float, elsewhere: Container[str] = ()
) -> dict[str, Figure]:
    """Return medians, and end the processes of rivals."""
    try:
        return medians(calls, seconds, elsewhere)
    finally:
        for call in calls.values():
            if isinstance(call, Apart):
                call.close()


def _tagged(lens: Lens, scene: Scene, family: str, modules: int) -> Image | Absent:
    """Return a spoiled picture with tags in the markers' places, by a camera at rest."""
    if not hasattr(cv2, "aruco"):
        return Absent("this OpenCV has no ArUco to draw tags with")
    image = with_tags(drawn(lens, in_view(0)), scene, detectors.tags(family, modules, READ))
    Imperfections(IMPERFECTIONS["pi-v1"], lens).spoil(image, 1, 0.0)
    return image


def _costs(lens: Lens, scene: Scene, neighbours: int, seconds: float) -> dict[str, Figure]:
    def pyrender() -> Call:
        renderer = renderers.PlainPyrender(lens, neighbours)
        return lambda: renderer.render(scene, LENS_POSE, 0)

    picture = spoiled(lens, scene)
    found = medians(
        {
            "render": _render(lens, scene),
            "render_and_spoil": _render(lens, scene, IMPERFECTIONS["pi-v1"]),
            "edges": _read(lens, picture, "edges"),
            "pyrender_flat": rivals.attempt("pyrender", pyrender),
        },
        seconds,
    )
    found["spoil"] = difference(found.pop("render_and_spoil"), found["render"])
    return found


def _render(lens: Lens, scene: Scene, faults: ImperfectionsConfig | None = None) -> Call:
    """Return a picture from one of ``LENS_POSES`` after the other, spoiled where there are faults."""
    raycaster, keys = Raycaster(lens, ROBOT, ARENA), _Counter()
    camera = None if faults is None else Imperfections(faults, lens)
    out = np.empty((lens.height_px, lens.width_px, 3), dtype=np.uint8)

    def render() -> None:
        key = keys.next()
        pose = LENS_POSES[key % len(LENS_POSES)]
        if camera is None:
            raycaster.render(scene, pose, 0, out)
        else:
            photograph(raycaster, camera, scene, pose, 0, key=key, turn_rate=TURN_RATE, out=out)

    return render


def _read(lens: Lens, picture: Image, method: str) -> Call:
    reader = Reader(lens, MARKER, method)
    return lambda: reader.read(picture)


def _copy(lens: Lens) -> Call:
    one = np.zeros((lens.height_px, lens.width_px, 3), dtype=np.uint8)
    two = np.ones_like(one)
    return lambda: np.copyto(one, two)
