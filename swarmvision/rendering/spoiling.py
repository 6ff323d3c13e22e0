"""The faults of a camera as kernels take them: tables that all pictures share, and one thread's memory."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray
from swarmvision.rendering import effects
from swarmvision.rendering.effects import LEHMER_PRIME, Image, Levels, Sums, Words


class Faults(NamedTuple):
    """What stays the same from picture to picture; see :func:`swarmvision.rendering.effects.spoil`."""

    idle: bool
    """Whether a lens that does not turn takes perfect pictures."""
    psf: FloatArray
    down: Sums
    rows: Words
    columns: Words
    least: Levels
    most: Levels
    law: Words
    step: int
    stream: Words
    bits: int
    decode: Levels
    encode: Words


class Dirt(NamedTuple):
    """Memory of one thread, see the scratch of :func:`swarmvision.rendering.effects.spoil`."""

    kept: Image
    linear: Levels
    blocks: Image
    mask: Image
    mask_words: NDArray[np.uint64]
    level: Levels
    total: Sums
    words: Words
    gain: Levels
    box: FloatArray
    taps: Sums

    @classmethod
    def of(cls, width_px: int, faults: Faults) -> Dirt:
        """Return memory for pictures of a width."""
        n, kernel = 3 * width_px, len(faults.psf)
        blocks, reach = -(-width_px // effects.BLOCK), width_px + 2 * kernel + 16
        mask = np.zeros(3 * effects.BLOCK * blocks, np.uint8)
        return cls(
            np.empty((kernel + 1, n), np.uint8),
            np.empty((kernel + 1, n), np.uint16),
            np.empty((2, kernel + 1, blocks), np.uint8),
            mask,
            mask.view(np.uint64),
            np.zeros(3 * n + 2 * effects.MARGIN, np.uint16),
            np.empty(n, np.int32),
            np.empty((3, n), np.int16),
            np.empty(n, np.uint16),
            np.empty(reach),
            np.empty(reach, np.int32),
        )


@compiled
def spoil_picture(image: Image, key: int, shear: float, length: float, faults: Faults, dirt: Dirt) -> None:
    """Spoil a picture in place, without the interpreter; may be called by compiled code.

    Args:
        image: sRGB, ``(h, 3 w)``, contiguous.
        key: Decides all chance: the same key, the same picture.
        shear: Shift of a row over the one above (px).
        length: Of the motion blur (px).
        faults: Of the camera.
        dirt: Of this thread alone.
    """
    if image.size == 0 or (faults.idle and shear == 0.0 and length == 0.0):
        return
    effects.spoil(
        image,
        faults.psf,
        faults.down,
        shear,
        length,
        faults.rows,
        faults.columns,
        faults.least,
        faults.most,
        faults.law,
        faults.step,
        faults.stream,
        1 + key % (LEHMER_PRIME - 1),
        faults.bits,
        faults.decode,
        faults.encode,
        dirt.kept,
        dirt.linear,
        dirt.blocks,
        dirt.mask,
        dirt.mask_words,
        dirt.level,
        dirt.total,
        dirt.words,
        dirt.gain,
        dirt.box,
        dirt.taps,
    )
