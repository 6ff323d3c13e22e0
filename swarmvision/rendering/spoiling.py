"""The faults of a camera as kernels take them: tables that all pictures share, and one thread's memory."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.rendering import effects
from swarmvision.rendering.blur import BLOCK, LINES, PHASES, WORD, Image, Longs
from swarmvision.rendering.curve import PIECE, Levels, Places, Words
from swarmvision.rendering.effects import LEHMER_PRIME
from swarmvision.rendering.sheet import as_above

LINE = 64  # bytes of a line of the cache; loads across two cost twice
Number = TypeVar("Number", np.uint8, np.uint16, np.int16)


class Faults(NamedTuple):
    """What stays the same from picture to picture; see :func:`swarmvision.rendering.effects.spoil`."""

    idle: bool
    """Whether a lens that does not turn takes perfect pictures."""
    height_px: int
    focal_px: float
    exposure_time: float
    """How long a row collects light (s)."""
    readout_time: float
    """From the first row to the last (s)."""
    farthest: float
    """No pixel comes from farther away in its row (px)."""
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
    curve: Levels


class Dirt(NamedTuple):
    """Memory of one thread, see the scratch of :func:`swarmvision.rendering.effects.spoil`."""

    kept: Image
    mask: Image
    told: Image
    changes: Longs
    origin: Places
    window: Longs
    marks: Longs
    light: Levels
    level: Levels
    total: Levels
    words: Words
    line: Levels
    gain: Levels
    box: FloatArray
    taps: Places
    weights: Levels
    places: Places
    lists: Places

    @classmethod
    def of(cls, width_px: int, faults: Faults) -> Dirt:
        """Return memory for pictures of a width."""
        kernel, m = len(faults.psf), -(-3 * width_px // BLOCK) * BLOCK
        longs, pieces, reach = -(-m // (64 * WORD)), m // PIECE, width_px + 2 * kernel + 16
        lists = np.zeros((3, pieces), np.int64)
        lists[2] = np.arange(pieces).reshape(2, -1).T.ravel()
        return cls(
            kept=aligned((2, m), np.uint8),
            mask=aligned((m,), np.uint8),
            told=aligned((2, 64 * longs), np.uint8),
            changes=np.zeros((faults.height_px, 2, longs), np.uint64),
            origin=np.zeros(faults.height_px, np.int64),
            window=np.zeros((2, 3 * longs), np.uint64),
            marks=np.zeros((3, longs), np.uint64),
            light=aligned((kernel + 1, m), np.uint16),
            level=aligned((3 * m + 4 * PIECE,), np.uint16),
            total=aligned((m,), np.uint16),
            words=aligned((4, m), np.int16),
            line=aligned((m // 2,), np.uint16),
            gain=aligned((m,), np.uint16),
            box=np.zeros(reach),
            taps=np.zeros(reach, np.int64),
            weights=aligned((PHASES, reach * PIECE), np.uint16),
            places=np.zeros((4, max(PHASES, kernel + LINES)), np.int64),
            lists=lists,
        )


def aligned(shape: tuple[int, ...], kind: type[Number]) -> NDArray[Number]:
    """Return zeros that begin where a line of the cache does."""
    size = int(np.prod(shape)) * np.dtype(kind).itemsize
    memory = np.zeros(size + LINE, np.uint8)
    begin = -memory.ctypes.data % LINE
    return memory[begin : begin + size].view(kind).reshape(shape)


@leaf
def spoil_picture(
    image: Image, alike: Places, key: int, turn_rate: float, faults: Faults, dirt: Dirt
) -> None:
    """Spoil a picture in place, without the interpreter; may be called by compiled code.

    Args:
        image: sRGB, ``(h, 3 w)``, contiguous.
        alike: Tells which rows are as the one above (:func:`swarmvision.rendering.sheet.as_above`); they need
            not be there.
        key: Decides all chance: the same key, the same picture.
        turn_rate: Of the lens in the world (rad/s), left positive.
        faults: Of the camera.
        dirt: Of this thread alone.
    """
    height, speed = faults.height_px, faults.focal_px * turn_rate
    shear = speed * faults.readout_time / height
    shear = math.copysign(2.0 * min(abs(shear) * height / 2.0, faults.farthest) / height, shear)
    length = min(abs(speed) * faults.exposure_time, faults.farthest)
    if image.size == 0:
        return
    if faults.idle and shear == 0.0 and length == 0.0:
        for y in range(1, height):
            if as_above(y, alike):
                for i in range(image.shape[1]):
                    image[y, i] = image[y - 1, i]
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
        faults.curve,
        alike,
        dirt.kept,
        dirt.mask,
        dirt.told,
        dirt.changes,
        dirt.origin,
        dirt.window,
        dirt.marks,
        dirt.light,
        dirt.level,
        dirt.total,
        dirt.words,
        dirt.line,
        dirt.gain,
        dirt.box,
        dirt.taps,
        dirt.weights,
        dirt.places,
        dirt.lists,
    )
