"""The picture that a pinhole would have taken, from one by a lens that bends straight lines.

Bilinear, with whole numbers and 1/256 px. OpenCV 4's ``remap`` rounds to 1/32 px and OpenCV 5's does
not: at a metre that is 0.2 % of range.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens

PARTS = 256  # of a pixel


class Straightening:
    """Where in a bent picture each pixel of the straight one is found, once for every lens."""

    def __init__(self, lens: Lens) -> None:
        rows, columns = np.mgrid[: lens.height_px, : lens.width_px] + 0.5
        bent = lens.distort(np.stack([columns, rows], axis=-1)) - 0.5
        size = np.array([lens.width_px, lens.height_px])
        place = np.rint(np.clip(bent, 0.0, size - 1.0) * PARTS).astype(np.int64)
        whole = np.minimum(place // PARTS, np.maximum(size - 2, 0))
        share = (place - whole * PARTS).astype(np.uint16).reshape(-1, 2, 1)
        self._shape = (lens.height_px, lens.width_px, 3)
        self._first = (whole[..., 1] * lens.width_px + whole[..., 0]).ravel()
        self._right, self._down = share[:, 0], share[:, 1].astype(np.uint32)
        self._next = min(1, lens.width_px - 1), lens.width_px * min(1, lens.height_px - 1)

    def straight(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the straight picture; what the bent one does not show repeats its border."""
        pixels = image.reshape(-1, 3)
        across, along = self._next
        above = self._between(pixels, self._first, across)
        below = self._between(pixels, self._first + along, across)
        mixed = above * (PARTS - self._down) + below * self._down + PARTS * PARTS // 2
        straight: NDArray[np.uint8] = (mixed // (PARTS * PARTS)).astype(np.uint8)
        return straight.reshape(self._shape)

    def _between(
        self, pixels: NDArray[np.uint8], first: NDArray[np.int64], across: int
    ) -> NDArray[np.uint32]:
        left, right = pixels[first].astype(np.uint16), pixels[first + across].astype(np.uint16)
        mixed: NDArray[np.uint16] = left * (PARTS - self._right) + right * self._right
        return mixed.astype(np.uint32)
