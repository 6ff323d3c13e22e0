"""Classes into marker candidates: the top band over the bottom band, column by column.

In one column the heights of top band, middle and bottom band stand in the marker's own proportion,
however much of the marker's width is hidden; columns that agree with their neighbours make a
candidate. So a marker behind another, or cut by the picture's border, needs no special case.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception.segment import Hues

MOST = 4096  # pairs that one picture may hold
RUNS = 64  # runs of one colour that one column may hold
LEAST_COLUMNS = 2  # of the coarse picture
ROW_SLACK = 1.6  # px of the coarse picture that an edge may jump between columns, plus a share of the middle
ROW_SHARE = 0.06
HEIGHT_SLACK = 1.6  # px of the coarse picture by which a band may be too thick or thin
HEIGHT_SHARE = 0.35  # and by which share of itself
COLUMN_GAP = 3  # columns that a candidate may lack


@dataclass(frozen=True, eq=False, slots=True)
class Candidate:
    """Columns of one marker, in px of the full picture."""

    left: float
    right: float
    columns: FloatArray
    """Centres of the columns, ascending, shape ``(n,)``."""
    rows: FloatArray
    """Top and bottom row of the top band, then of the bottom band, shape ``(n, 4)``."""

    @property
    def middle(self) -> float:
        """Height of what lies between the two bands (px)."""
        return float(np.median(self.rows[:, 2] - self.rows[:, 1]))


def candidates(classes: NDArray[np.uint8], marker: Marker, hues: Hues, scale: int) -> list[Candidate]:
    """Return the marker candidates of a coarse picture, widest first.

    Args:
        classes: From :func:`swarmvision.perception.segment.classify`, shape ``(h, w)``.
        marker: What to look for; its top and bottom band must be coloured.
        hues: Of that marker.
        scale: Pixels of the full picture in one of the coarse picture, each way.
    """
    top, bottom = hues.number(marker.bands[0].colour), hues.number(marker.bands[-1].colour)
    if top is None or bottom is None:
        return []
    middle = marker.bands[0].bottom - marker.bands[-1].top
    upper = (marker.height - marker.bands[0].bottom) / middle
    lower = marker.bands[-1].top / middle
    pairs = np.empty((MOST, 5))
    busy = np.flatnonzero((classes == top).any(axis=0) & (classes == bottom).any(axis=0))
    count = _pair_columns(classes, busy, top, bottom, upper, lower, pairs)
    groups = _chain(pairs[:count])
    found = [_candidate(pairs[group], scale) for group in groups if len(group) >= LEAST_COLUMNS]
    return sorted(_merged(found, marker), key=lambda c: (-c.middle, c.left))


def _candidate(pairs: FloatArray, scale: int) -> Candidate:
    columns = (pairs[:, 0] + 0.5) * scale
    return Candidate(
        left=float(columns[0] - scale / 2.0),
        right=float(columns[-1] + scale / 2.0),
        columns=columns,
        rows=pairs[:, 1:] * scale,
    )


def _merged(found: list[Candidate], marker: Marker) -> list[Candidate]:
    """Join candidates that are pieces of one marker: of one height, in line, together no wider than it."""
    middle = marker.bands[0].bottom - marker.bands[-1].top
    merged: list[Candidate] = []
    for piece in sorted(found, key=lambda c: c.left):
        for i, other in enumerate(merged):
            # Near the lens a cylinder looks wider than its far proportion; 1.35 covers 0.1 m.
            widest = 1.35 * 2.0 * marker.radius / middle * max(piece.middle, other.middle) + 4.0
            level = abs(np.median(piece.rows[:, 1]) - np.median(other.rows[:, 1]))
            alike = abs(piece.middle - other.middle) < 4.0 + 0.06 * other.middle
            if alike and level < 4.0 + 0.08 * other.middle and piece.right - other.left <= widest:
                columns = np.concatenate([other.columns, piece.columns])
                rank = np.argsort(columns, kind="stable")
                rows = np.concatenate([other.rows, piece.rows])[rank]
                merged[i] = Candidate(other.left, max(piece.right, other.right), columns[rank], rows)
                break
        else:
            merged.append(piece)
    return merged


def _chain(pairs: FloatArray) -> list[NDArray[np.int64]]:
    """Group pairs ``(n, 5)`` of column and four rows, sorted by column, into chains that run smoothly."""
    chains: list[list[int]] = []
    for i, pair in enumerate(pairs):
        best, nearest = -1, np.inf
        for c, chain in enumerate(chains):
            last = pairs[chain[-1]]
            step = pair[0] - last[0]
            if not 0 < step <= COLUMN_GAP:
                continue
            slack = ROW_SLACK * step + ROW_SHARE * (pair[3] - pair[2])
            jump = max(abs(pair[2] - last[2]), abs(pair[3] - last[3]))
            if jump <= slack and jump + step < nearest:
                best, nearest = c, jump + step
        if best < 0:
            chains.append([i])
        else:
            chains[best].append(i)
    return [np.array(chain) for chain in chains]


@compiled
def _pair_columns(
    classes: NDArray[np.uint8],
    columns: NDArray[np.int64],
    top: int,
    bottom: int,
    upper: float,
    lower: float,
    pairs: FloatArray,
) -> int:
    """Write column, rows of the top band, rows of the bottom band of every fitting pair; return how many."""
    height = classes.shape[0]
    runs = np.empty((2, RUNS, 2))
    counts = np.zeros(2, dtype=np.int64)
    found = 0
    for column in columns:
        counts[:] = 0
        row = 0
        while row < height:
            kind = classes[row, column]
            if kind not in (top, bottom):
                row += 1
                continue
            start = row
            while row < height and classes[row, column] == kind:
                row += 1
            which = 0 if kind == top else 1
            if counts[which] < RUNS:
                runs[which, counts[which], 0] = start
                runs[which, counts[which], 1] = row
                counts[which] += 1
        for a in range(counts[0]):
            for b in range(counts[1]):
                middle = runs[1, b, 0] - runs[0, a, 1]
                if middle < 2.0 or found >= MOST:
                    continue
                fits = True
                for which in range(2):
                    run = runs[which, a if which == 0 else b]
                    wanted = middle * (upper if which == 0 else lower)
                    cut = (which == 0 and run[0] == 0) or (which == 1 and run[1] == height)
                    off = run[1] - run[0] - wanted
                    slack = HEIGHT_SLACK + HEIGHT_SHARE * wanted
                    if off > slack or (off < -slack and not cut):
                        fits = False
                if fits:
                    pairs[found, 0] = column
                    pairs[found, 1], pairs[found, 2] = runs[0, a, 0], runs[0, a, 1]
                    pairs[found, 3], pairs[found, 4] = runs[1, b, 0], runs[1, b, 1]
                    found += 1
    return found
