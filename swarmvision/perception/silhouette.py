"""In which columns of a picture a robot is seen: its marker's colours, and nothing about where it is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.compiled import compiled
from swarmvision.data import BoolArray
from swarmvision.geometry import FloatArray
from swarmvision.perception.segment import Balance, Hues

LEAST = 4  # px of the marker's colours in a column; a ring of 10 mm is 6 px high at 1 m, noise makes 1 or 2


def marker_columns(image: NDArray[np.uint8], hues: Hues) -> BoolArray:
    """Return which columns of a picture ``(h, w, 3)`` hold a marker's colours, shape ``(w,)``."""
    image = np.require(image, requirements=["C", "W"])
    seen = np.zeros(image.shape[1], dtype=np.bool_)
    _count(image, Balance.of(image).address, hues.classes, seen)
    return seen


def marker_bearings(image: NDArray[np.uint8], lens: Lens, hues: Hues, bearing: FloatArray) -> BoolArray:
    """Return whether a marker is seen at bearings (rad, lens frame), False outside the picture, ``(n,)``.

    A bent picture is looked up along the row of its principal point, where the lens is level.
    """
    columns = marker_columns(image, hues)
    inside = np.abs(bearing) < np.pi / 2.0
    straight = lens.column_from_bearing(np.where(inside, bearing, 0.0))
    level = np.stack([straight, np.full_like(straight, lens.centre_px[1])], axis=-1)
    column = np.floor(lens.distort(level)[..., 0] if lens.is_distorted else straight).astype(np.int64)
    inside &= (column >= 0) & (column < lens.width_px)
    return np.asarray(inside & columns[np.where(inside, column, 0)])


@compiled
def _count(
    image: NDArray[np.uint8], address: NDArray[np.uint16], classes: NDArray[np.uint8], seen: BoolArray
) -> None:
    count = np.zeros(image.shape[1], dtype=np.int64)
    for v in range(image.shape[0]):
        for u in range(image.shape[1]):
            place = address[0, image[v, u, 0]] + address[1, image[v, u, 1]] + address[2, image[v, u, 2]]
            if classes[place] > 0:
                count[u] += 1
    for u in range(image.shape[1]):
        seen[u] = count[u] >= LEAST
