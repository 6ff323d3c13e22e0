"""The faults of a camera as kernels take them: tables that all pictures share, and one thread's memory."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray
from swarmvision.rendering import effects
from swarmvision.rendering.effects import LEHMER_PRIME, Image, Levels, Places, Words


class Faults(NamedTuple):
    """What stays the same from picture to picture; see :func:`swarmvision.rendering.effects.spoil`."""

    idle: bool
    """Whether a lens that does not turn takes perfect pictures."""
    psf: FloatArray
    down: Levels
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
    kept_words: NDArray[np.uint64]
    linear: Levels
    blocks: Image
    active_words: NDArray[np.uint64]
    mask: Image
    mask_words: NDArray[np.uint64]
    level: Levels
    total: Levels
    words: Words
    gain: Levels
    box: FloatArray
    taps: Levels
    places: Places
    hot: Image
    runs: Places

    @classmethod
    def of(cls, width_px: int, faults: Faults) -> Dirt:
        """Return memory for pictures of a width."""
        kernel, word = len(faults.psf), effects.BLOCK * effects.WORD
        n = -(-3 * width_px // word) * word
        size, reach = n // effects.BLOCK, width_px + 2 * kernel + 16
        kept = np.zeros((kernel + 1, n), np.uint8)
        mask, blocks = np.zeros(n, np.uint8), np.zeros((3, kernel + 1, size), np.uint8)
        return cls(
            kept=kept,
            kept_words=kept.view(np.uint64),
            linear=np.zeros((kernel + 1, n), np.uint16),
            blocks=blocks,
            active_words=blocks[2, 0].view(np.uint64),
            mask=mask,
            mask_words=mask.view(np.uint64),
            level=np.zeros(3 * n + 2 * effects.MARGIN, np.uint16),
            total=np.zeros(n, np.uint16),
            words=np.zeros((3, n), np.int16),
            gain=np.zeros(n, np.uint16),
            box=np.zeros(reach),
            taps=np.zeros((effects.PHASES, reach), np.uint16),
            places=np.zeros((6, max(effects.PHASES, kernel + 1)), np.int64),
            hot=np.zeros(3 * size, np.uint8),
            runs=np.zeros((3, size, 2), np.int64),
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
        dirt.kept_words,
        dirt.linear,
        dirt.blocks,
        dirt.active_words,
        dirt.mask,
        dirt.mask_words,
        dirt.level,
        dirt.total,
        dirt.words,
        dirt.gain,
        dirt.box,
        dirt.taps,
        dirt.places,
        dirt.hot,
        dirt.runs,
    )
