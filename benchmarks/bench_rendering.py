"""What a picture costs: by its size and the neighbours in view, and each of a camera's faults on top.

python benchmarks/bench_rendering.py [--repetitions 200]

Median and least of many short repetitions, one thread. ``draw`` is the compiled function alone, as loops
over many cameras call it; ``render`` is what Python calls. Nothing here asserts a time.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

from swarmvision.camera import Lens
from swarmvision.config.arena import ARENAS
from swarmvision.config.camera import LensConfig
from swarmvision.config.imperfections import IMPERFECTIONS
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.rendering.raycast import Raycaster, draw

SIZES = ((640, 460, 634.6), (320, 240, 317.3), (96, 48, 95.2))
NEIGHBOURS = (0, 1, 8, 32)
SCENES = 3  # for each number of neighbours
EYE = np.zeros(3)
FAULTS: dict[str, tuple[dict[str, object] | None, float]] = {
    "noise": ({"white_electrons": 4000.0, "read_noise": 4.0}, 0.0),
    "vignetting, white balance": ({"vignetting": 0.25, "white_balance": (1.03, 1.0, 0.96)}, 0.0),
    "defocus": ({"defocus": 0.5}, 0.0),
    "motion blur, 0.5 rad/s": ({"exposure_time": 0.008}, 0.5),
    "rolling shutter, 0.5 rad/s": ({"readout_time": 0.025}, 0.5),
    "6 bits": ({"bits": 6}, 0.0),
    "pi-v1, still": (None, 0.0),
    "pi-v1, 0.5 rad/s": (None, 0.5),
    "pi-v1, 2 rad/s": (None, 2.0),
}


def neighbours(count: int, seed: int) -> Scene:
    """Robots within 25 degrees of the axis, from 0.3 m to 2 m away, 4 m when they are many."""
    rng = np.random.default_rng(seed)
    places: list[np.ndarray] = []
    while len(places) < count:
        distance, bearing = rng.uniform(0.3, 2.0 if count <= 8 else 4.0), rng.uniform(-0.42, 0.42)
        place = np.array([distance * np.cos(bearing), distance * np.sin(bearing)])
        if all(np.hypot(*(place - other)) > 0.16 for other in places):
            places.append(place)
    return Scene.at_rest([[*place, rng.uniform(-np.pi, np.pi)] for place in places])


def timed(call: Callable[[], object], repetitions: int) -> tuple[float, float]:
    """Return median and least duration (ms)."""
    call()
    durations = []
    for _ in range(repetitions):
        begun = time.perf_counter()
        call()
        durations.append(time.perf_counter() - begun)
    return float(np.median(durations)) * 1e3, min(durations) * 1e3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repetitions", type=int, default=200)
    repetitions = parser.parse_args().repetitions
    print(f"{'picture':34s}{'median ms':>10s}{'least ms':>10s}")
    for width, height, focal in SIZES:
        lens = Lens.from_config(LensConfig(width_px=width, height_px=height, focal_px=focal))
        raycaster, image = (
            Raycaster(lens, RobotConfig(), ARENAS["open"]),
            np.zeros((height, width, 3), np.uint8),
        )
        lines, scratch = image.reshape(height, -1), raycaster.scratch(32)
        for count in NEIGHBOURS:
            scenes = [neighbours(count, seed) for seed in range(SCENES)]

            def by_kernel(scene: Scene) -> None:
                draw(lines, EYE, scene.pose, -1, scene.object_pose, raycaster.stage, scratch, True)  # noqa: B023

            def by_python(scene: Scene) -> None:
                raycaster.render(scene, EYE, None, image)  # noqa: B023

            for name, call in (("draw", by_kernel), ("render", by_python)):
                each = [timed(lambda s=scene, c=call: c(s), repetitions) for scene in scenes]  # type: ignore[misc]
                median, least = np.mean(each, axis=0)
                print(
                    f"{name:7s}{width}x{height}, {count:2d} neighbours".ljust(34)
                    + f"{median:10.4f}{least:10.4f}"
                )
    lens = Lens.from_config(LensConfig())
    clean = Raycaster(lens, RobotConfig(), ARENAS["open"]).render(neighbours(8, 0), EYE)
    image = clean.copy()
    copying = timed(lambda: np.copyto(image, clean), repetitions)
    for name, (setting, turn_rate) in FAULTS.items():
        config = IMPERFECTIONS["none"].replace(**setting) if setting else IMPERFECTIONS["pi-v1"]
        faults = Imperfections(config, lens)

        def spoil(faults: Imperfections = faults, turn_rate: float = turn_rate) -> None:
            np.copyto(image, clean)
            faults.spoil(image, 1, turn_rate)

        median, least = np.subtract(timed(spoil, repetitions), copying)
        print(f"{name:34s}{median:10.4f}{least:10.4f}")


if __name__ == "__main__":
    main()
