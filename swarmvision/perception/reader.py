"""A picture in, the neighbours in it out: the door to every method of reading."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.data import Estimates
from swarmvision.errors import ConfigError, PictureError, unknown_name
from swarmvision.marker import Marker
from swarmvision.perception.edges import read as read_edges
from swarmvision.perception.moments import read as read_moments

METHODS: dict[str, Callable[[NDArray[np.uint8], Lens, Marker], Estimates]] = {
    "edges": read_edges,
    "moments": read_moments,
}


class Reader:
    """Reads pictures of one lens for one kind of marker; threads may share it."""

    def __init__(self, lens: Lens, marker: Marker, method: str = "edges") -> None:
        """Choose the method.

        Args:
            lens: That took the pictures.
            marker: That the neighbours carry.
            method: ``edges``, our model of the marker, or ``moments``, the paper's.

        Raises:
            ConfigError: If there is no such method.
        """
        if method not in METHODS:
            raise ConfigError(unknown_name("method", method, METHODS))
        self.lens = lens
        self.marker = marker
        self._read = METHODS[method]

    def read(self, image: NDArray[np.uint8]) -> Estimates:
        """Return the neighbours in a picture, nearest first, lens frame, shape ``(k,)``.

        Args:
            image: sRGB, shape ``(h, w, 3)`` as the lens has it, uint8.

        Raises:
            PictureError: If the picture is not of that shape or type.
        """
        if not isinstance(image, np.ndarray) or image.dtype != np.uint8 or image.ndim != 3:
            kind = f"{image.dtype} of shape {image.shape}" if isinstance(image, np.ndarray) else type(image)
            raise PictureError(f"a picture must be uint8 of shape (h, w, 3), got {kind}")
        wanted = (self.lens.height_px, self.lens.width_px, 3)
        if image.shape != wanted:
            raise PictureError(
                f"this lens takes pictures of {wanted[1]} x {wanted[0]} px in 3 channels, "
                f"got shape {image.shape}"
            )
        return self._read(image, self.lens, self.marker)
