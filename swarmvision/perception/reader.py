"""A picture in, the neighbours in it out: the door to every method of reading."""

from __future__ import annotations

import threading

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.data import Estimates
from swarmvision.errors import ConfigError, PictureError, unknown_name
from swarmvision.marker import Marker
from swarmvision.perception.edges import read as read_edges
from swarmvision.perception.fit import read as read_fit
from swarmvision.perception.gaze import Gaze
from swarmvision.perception.model import Skin
from swarmvision.perception.moments import read as read_moments
from swarmvision.perception.plan import Plan, Scratch, Task
from swarmvision.perception.straighten import Straightening

METHODS = ("edges", "fit", "moments")
"""Closed form and fast; polished and most accurate; the paper's."""


class Reader:
    """Reads pictures of one lens for one kind of marker; threads may share it.

    A kernel of one's own may call :func:`swarmvision.perception.edges.read_edges_into` with :attr:`task` and
    a scratch for each thread instead.
    """

    def __init__(self, lens: Lens, marker: Marker, method: str = "edges") -> None:
        """Choose the method.

        Args:
            lens: That took the pictures.
            marker: That the neighbours carry.
            method: ``edges``, our model of the marker in closed form; ``fit``, the same polished by
                comparing the picture with the model's; or ``moments``, the paper's.

        Raises:
            ConfigError: If there is no such method.
        """
        if method not in METHODS:
            raise ConfigError(unknown_name("method", method, METHODS))
        self.lens = lens
        self.marker = marker
        self._method = method
        self.task: Task | None = Task.of(Plan.of(marker), lens)
        """What kernels are given; None where there is nothing to look for."""
        self._all = Gaze.at_all(self.task) if self.task is not None else None
        self._skin = Skin.of(marker)
        self._rooms = threading.local()
        self._straightening = Straightening(lens) if lens.is_distorted else None

    def read(self, image: NDArray[np.uint8], gaze: Gaze | None = None) -> Estimates:
        """Return the neighbours in a picture, nearest first, lens frame, shape ``(k,)``.

        Args:
            image: sRGB, shape ``(h, w, 3)`` as the lens has it, uint8.
            gaze: Where to look in the picture without its bends; everywhere where not given, and by
                ``moments``.

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
        image = np.require(image, requirements=["C", "W"])  # one kind of array: one compilation
        if self._straightening is not None:
            image = self._straightening.straight(image)
        if self._method == "moments":
            return read_moments(image, self.lens, self.marker)
        if self.task is None or self._all is None:
            return Estimates.empty(frame="lens")
        if self._method == "fit":
            return read_fit(image, self.lens, self.task, gaze or self._all, self._skin, self._scratch())
        return read_edges(image, self.task, gaze or self._all, self._scratch())

    def _scratch(self) -> Scratch:
        """Return this thread's room to work in."""
        if not hasattr(self._rooms, "scratch"):
            self._rooms.scratch = Scratch.of(self.lens.width_px, self.lens.height_px)
        room: Scratch = self._rooms.scratch
        return room
