"""A hundred thousand pictures that nobody takes: nothing may break a reader.

    python benchmarks/fuzz_reading.py [PICTURES]

Random, constant, tiny, huge, float, transposed and torn pictures, in the marker's colours and others,
through every method. Prints how many were read and refused; exits with 1 at the first that breaks.
"""

from __future__ import annotations

import sys
from functools import cache

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.config.robot import RobotConfig
from swarmvision.errors import SwarmVisionError
from swarmvision.marker import Marker
from swarmvision.perception import Reader

COLOURS = np.array(
    [(190, 38, 42), (228, 228, 224), (30, 62, 150), (226, 190, 32), (0, 0, 0), (255, 255, 255)],
    dtype=np.uint8,
)
MARKER = Marker.from_config(RobotConfig().marker)


SIZES = 60  # different ones: a reader is made once for each


def sizes(rng: np.random.Generator) -> list[tuple[int, int]]:
    """Return heights and widths, the smallest among them."""
    drawn = rng.integers(1, 120, (SIZES, 2)).tolist()
    return [(1, 1), (1, 90), (90, 1), (3, 3), (4, 4), *((int(h), int(w)) for h, w in drawn)]


def picture(rng: np.random.Generator, high: int, wide: int) -> NDArray[np.generic]:
    """Return one that nobody takes."""
    kind = rng.integers(0, 7)
    if kind == 0:
        return rng.integers(0, 256, (high, wide, 3), dtype=np.uint8)
    if kind == 1:
        return np.full((high, wide, 3), rng.integers(0, 256, 3), dtype=np.uint8)
    if kind == 2:  # bands from the top down, some of them like a marker's
        rows = COLOURS[np.repeat(rng.integers(0, 6, high), rng.integers(1, 12))[:high]]
        return np.ascontiguousarray(np.repeat(rows[:, None], wide, axis=1))
    if kind == 3:
        return COLOURS[rng.integers(0, 6, (high, wide))]
    if kind == 4:
        values = rng.normal(0, 1e3, (high, wide, 3))
        values[rng.random(values.shape) < 0.1] = np.nan
        return values
    image = np.repeat(np.repeat(COLOURS[rng.integers(0, 6, (high, wide))], 4, axis=0), 9, axis=1)
    return image[::-1, ::2] if kind == 5 else image.transpose(1, 0, 2)


@cache
def reader_of(wide: int, high: int, focal_px: float, method: str) -> Reader:
    """Return the reader of a lens."""
    return Reader(Lens(wide, high, focal_px, (wide / 2.0, high / 2.0), 0.085), MARKER, method)


def main(count: int) -> None:
    """Read them all."""
    rng = np.random.default_rng(0)
    known, read, refused, told = sizes(rng), 0, 0, 0
    for number in range(count):
        size = (1000, 1400) if rng.random() < 0.001 else known[int(rng.integers(len(known)))]
        image = picture(rng, *size)
        method = ("edges", "fit", "moments")[number % 3]
        focal = (30.0, 100.0, 634.6)[int(rng.integers(3))]
        try:
            reader = reader_of(image.shape[1], image.shape[0], focal, method)
            estimates = reader.read(image)  # type: ignore[arg-type]
        except SwarmVisionError:
            refused += 1
            continue
        read += 1
        told += len(estimates.seen)
        finite = np.isfinite(estimates.range).all() and np.isfinite(estimates.bearing).all()
        if not finite or not np.isfinite(estimates.covariance[:, :2, :2]).all():
            sys.exit(f"picture {number}, {method}: something is not finite")
    print(f"{count} pictures: {read} read, {told} markers told, {refused} refused, none broke a reader")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100_000)
