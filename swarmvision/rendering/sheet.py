"""What kernels agree on about a *sheet*: one object as a stack of coloured bands over some columns.

A sheet is what an upright solid is seen as: edges of constant height, whose rows are straight lines of
what one over the depth is, and between two borders of a column that is a straight line too. An edge is
sampled twice in a column, at the middles of its two parts; where a pattern jumps inside a column the
parts are what is before and behind the jump, else they are halves. A pixel that edges cross is the
mean of the light under them, weighed by how much of it lies below the samples. All others are copies.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import inner, leaf
from swarmvision.rendering.ink import ONE, ZERO

Image = NDArray[np.uint8]
Places = NDArray[np.int64]
Singles = NDArray[np.float32]
Pixels = NDArray[np.int32]
LANES = 16  # columns of a block; of shorter loops the compiler makes no vectors
STEP = 8  # numbers of a row that are computed together; rows have room for a multiple
NEAR, FAR, SHADE, GLOW, SPLIT = range(5)  # rows of a profile, see paint_sheet
PROFILE = 5  # numbers
RISE, BASE, GAIN = 0, 1, 2  # rows of a plan
PLAN = 3  # numbers


@leaf
def room(columns: int) -> int:
    """Return how many numbers a row of a profile has for so many columns."""
    return (columns + 1 + LANES + STEP - 1) // STEP * STEP


@inner
def as_above(y: int, alike: Places) -> bool:
    """Return whether a row is known to be as the one above: before the first number, behind the second."""
    known: bool = 0 < y < alike[0] or y > alike[1]
    return known


@leaf
def below(row: np.float32, end: np.float32) -> np.float32:
    """Return the share of a pixel that ends at a row (px) which lies below another row."""
    return min(ONE, max(ZERO, end - row))


@inner
def share_below(profile: Singles, rows: Singles, edge: int, i: int, bottom: np.float32) -> np.float32:
    """Return how much of a pixel lies below an edge in a column."""
    other = below(rows[2 * edge + 1, i], bottom)
    share: np.float32 = other + profile[SPLIT, i] * (below(rows[2 * edge, i], bottom) - other)
    return share


@inner
def _within(row: np.float32, window: Places) -> np.float32:
    return min(max(row, np.float32(window[0])), np.float32(window[1]))


@inner
def note_span(spans: Places, e: int, low: np.float32, high: np.float32, window: Places) -> None:
    """Note which rows an edge crosses that lies between two."""
    spans[e, 0] = int(_within(low, window))
    high = _within(high, window)
    spans[e, 1] = int(high) + (1 if high > np.float32(int(high)) else 0)
