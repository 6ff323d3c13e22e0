"""What a real sensor does to a perfect picture. So far: noise.

A long stream of rounded Gaussian noise is drawn once per level; a picture gets a window of it that
starts at a hashed place, so there is no random draw per pixel and the key alone decides. Positive
and negative noise are kept apart, because saturating byte arithmetic is what processors do fastest.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

STARTS = 1 << 20  # places where a window may start: how many pictures differ
STREAM_SEED = 20  # the stream is the same in every run; what varies is where windows start


def add_noise(image: NDArray[np.uint8], std: float, key: int) -> None:
    """Add Gaussian noise to a picture in place, saturating at 0 and 255.

    Args:
        image: sRGB, shape ``(h, w, 3)``, contiguous.
        std: Standard deviation (grey levels of 255); 0 changes nothing.
        key: Decides the noise: the same key, the same noise.
    """
    if std <= 0.0 or image.size == 0:
        return
    more, less = _stream(std, image.size)
    window = slice(key % STARTS, key % STARTS + image.size)
    flat = image.reshape(1, -1)
    cv2.add(flat, more[None, window], dst=flat)
    cv2.subtract(flat, less[None, window], dst=flat)


@lru_cache(maxsize=8)
def _stream(std: float, size: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the positive and the negative part of the noise, long enough for every window."""
    noise = np.rint(np.random.default_rng(STREAM_SEED).normal(0.0, std, STARTS + size))
    noise = np.clip(noise, -255, 255)
    return np.maximum(noise, 0).astype(np.uint8), np.maximum(-noise, 0).astype(np.uint8)
