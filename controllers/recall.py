"""What was known of the same neighbour before, by the numbers of tracks, in whatever slot it was."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import leaf
from swarmvision.controllers.crowd import Crowd
from swarmvision.data import IntArray, Senses

NOBODY = NOWHERE = -1  # track number, as of an empty slot of estimates; slot

Scalar = TypeVar("Scalar", np.float64, np.complex128)


def tracked(senses: Senses, others: Crowd) -> IntArray:
    """Return the number of each neighbour that counts, ``NOBODY`` for others, shape ``(..., k)``."""
    return np.where(others.counts, senses.neighbours.track, NOBODY)


def earlier_slot(track: IntArray, before: IntArray) -> IntArray:
    """Return in which of the slots ``(..., m)`` before each neighbour ``(..., k)`` was; -1 for in none."""
    slot = np.empty(track.shape, dtype=np.int64)
    rows = int(np.prod(track.shape[:-1]))
    _find(
        np.ascontiguousarray(track).reshape(rows, track.shape[-1]),
        np.ascontiguousarray(before).reshape(rows, before.shape[-1]),
        slot.reshape(rows, track.shape[-1]),
    )
    return slot


def recalled(values: NDArray[Scalar], slot: IntArray) -> NDArray[Scalar]:
    """Return what values ``(..., m)`` were for each neighbour, nan where there was none, ``(..., k)``."""
    if values.shape[-1] == 0:
        return np.full(slot.shape, np.nan, dtype=values.dtype)
    found = np.take_along_axis(values, np.maximum(slot, 0), axis=-1)
    return np.where(slot == NOWHERE, np.nan, found)


def smoothed(old: NDArray[Scalar], new: NDArray[Scalar], senses: Senses, smoothing: float) -> NDArray[Scalar]:
    """Return an old value drawn to a new one with a time constant (s); the new one where there is no old."""
    share = senses.dt / (senses.dt + smoothing)
    return np.where(np.isnan(old), new, old + share * (new - old))


@leaf
def _find(track: IntArray, before: IntArray, slot: IntArray) -> None:
    """Fill in the slots ``(n, k)`` of numbers ``(n, k)`` among those before ``(n, m)``."""
    most = before.shape[1]
    for n in range(track.shape[0]):
        for k in range(track.shape[1]):
            number, place = track[n, k], NOWHERE
            if number >= 0:
                # Most stay in their slot.
                place = k if k < most and before[n, k] == number else NOWHERE
                m = 0
                while place == NOWHERE and m < most:
                    if before[n, m] == number:
                        place = m
                    m += 1
            slot[n, k] = place
