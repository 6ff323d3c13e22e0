"""Noise for test pictures that does not come from the code under test."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def add_noise(image: NDArray[np.uint8], std: float, seed: int) -> None:
    """Add rounded Gaussian noise (grey levels) to a picture in place."""
    noise = np.random.default_rng(seed).normal(0.0, std, image.shape)
    image[:] = np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)
