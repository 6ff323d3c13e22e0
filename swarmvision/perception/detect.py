"""A picture into marker candidates: the top band over the bottom band, column by column.

In one column the heights of top band, middle and bottom band stand in the marker's own proportion,
however much of the marker's width is hidden; columns that agree with their neighbours make a
candidate. So a marker behind another, or cut by the picture's side, needs no special case. Where the
picture ends before the other band can be seen, one band must do.

The look is coarse: every second or third pixel of every second row, each by one look into a table.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import compiled
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception.segment import Balance, Hues

COARSE_WIDTH, COARSE_HEIGHT = 320, 230  # px: about so many are looked at
RUNS = 8192  # runs of colour that one picture may hold
PAIRS = 4096  # pairs of runs that one picture may hold
CHAINS = 256  # candidates that one picture may hold
LEAST_COLUMNS = 2  # of the coarse picture
RUN_GAP = 2  # steps down to the next pixel of a run; 1 would break it at a single lost pixel
ROW_SLACK = 1.6  # coarse rows that an edge may jump between columns, plus a share of the middle
ROW_SHARE = 0.06
HEIGHT_SLACK = 1.6  # coarse rows by which a band may be too thick or thin
HEIGHT_SHARE = 0.35  # and by which share of itself
STEP_SLACK = 1.2  # coarse rows by which the height of the middle may change within a marker,
STEP_SHARE = 0.04  # and by which share of itself; more is one marker beside another
STEP_COLUMNS = 3  # coarse columns before and after that are compared for it
COLUMN_GAP = 3  # coarse columns that a candidate may lack
REACH_OUT = 1.25  # of the middle: no farther is the border where the other band is out of the picture
LEAST_SHOWN = 0.35  # of a band's thickness: a band cut thinner by the border is out of the picture
LEAST_THICK = 4.0  # coarse rows of a band that must do without the other
BOTH, TOP_ONLY, BOTTOM_ONLY = 0, 1, 2  # which bands a candidate has


@dataclass(frozen=True, eq=False, slots=True)
class Candidate:
    """Columns of one marker, in px of the picture."""

    left: float
    right: float
    middle: float
    """Height of what lies between the two bands, and the row where it begins (px)."""
    level: float
    columns: FloatArray
    """Centres of the columns, ascending, shape ``(n,)``."""
    rows: FloatArray
    """Top and bottom row of the top band, then of the bottom band, shape ``(n, 4)``."""
    bands: int
    """``BOTH``, or the one that is in the picture; the rows of the other are where it should be."""


@dataclass(frozen=True, slots=True)
class Proportions:
    """What the pairing of runs knows of a marker."""

    top: int
    """Class of the top band."""
    bottom: int
    """Class of the bottom band."""
    upper: float
    """Height of the top band over that of the middle."""
    lower: float
    """Height of the bottom band over that of the middle."""
    width: float
    """Width of the marker over the height of the middle, far away."""

    @classmethod
    def of(cls, marker: Marker, hues: Hues) -> Proportions | None:
        """Return a marker's; None if its top or bottom band has no hue."""
        top, bottom = hues.number(marker.bands[0].colour), hues.number(marker.bands[-1].colour)
        if top is None or bottom is None:
            return None
        middle = marker.bands[0].bottom - marker.bands[-1].top
        return cls(
            top,
            bottom,
            (marker.height - marker.bands[0].bottom) / middle,
            marker.bands[-1].top / middle,
            2.0 * marker.radius / middle,
        )


def candidates(
    image: NDArray[np.uint8], balance: Balance, hues: Hues, marker: Proportions
) -> list[Candidate]:
    """Return the marker candidates of a picture ``(h, w, 3)``, tallest first."""
    across = max(1, round(image.shape[1] / COARSE_WIDTH))
    down = max(1, round(image.shape[0] / COARSE_HEIGHT))
    columns, rows = image.shape[1] // across, image.shape[0] // down
    runs = np.empty((RUNS, 4), dtype=np.int32)
    state = np.zeros((columns, 3), dtype=np.int32)
    count = coarse_runs(
        image, balance.address, hues.classes, marker.top, marker.bottom, across, down, runs, state
    )
    if count == 0:
        return []
    pairs, chain = np.empty((PAIRS, 6)), np.empty(PAIRS, dtype=np.int64)
    found = pair_runs(
        runs[:count], columns, rows, marker.top, marker.bottom, marker.upper, marker.lower, pairs
    )
    chains = chain_pairs(pairs[:found], chain)
    order = np.argsort(chain[:found], kind="stable")
    pairs, chain = pairs[order], chain[order]
    bounds = np.empty((2 * CHAINS + 1, 2), dtype=np.int64)
    middles = np.empty((2 * CHAINS + 1, 2))
    pieces = []
    for i in range(split_chains(pairs, chain, chains, bounds, middles)):
        piece = pairs[bounds[i, 0] : bounds[i, 1]]
        middle, level = middles[i] * down
        pieces.append(
            Candidate(
                left=float(piece[0, 0] * across),
                right=float((piece[-1, 0] + 1.0) * across),
                middle=float(middle),
                level=float(level),
                columns=(piece[:, 0] + 0.5) * across,
                rows=piece[:, 1:5] * down,
                bands=int(piece[0, 5]),
            )
        )
    return sorted(_merged(pieces, marker, down), key=lambda c: (-c.middle, c.left))


def _merged(found: list[Candidate], marker: Proportions, down: int) -> list[Candidate]:
    """Join candidates that are pieces of one marker: of one height, in line, together no wider than it."""
    if len(found) < 2:
        return found
    merged: list[Candidate] = []
    for piece in sorted(found, key=lambda c: c.left):
        for i, other in enumerate(merged):
            # Near the lens a cylinder looks wider than its far proportion; 1.35 covers 0.1 m.
            widest = 1.35 * marker.width * max(piece.middle, other.middle) + 4.0
            slack = _alike(other.middle / down) * down
            level = abs(piece.level - other.level) < 2.0 * slack
            alike = abs(piece.middle - other.middle) < slack and piece.bands == other.bands
            if alike and level and piece.right - other.left <= widest:
                columns = np.concatenate([other.columns, piece.columns])
                rank = np.argsort(columns, kind="stable")
                rows = np.concatenate([other.rows, piece.rows])[rank]
                right = max(piece.right, other.right)
                merged[i] = replace(other, right=right, columns=columns[rank], rows=rows)
                break
        else:
            merged.append(piece)
    return merged


@compiled
def _alike(middle: float) -> float:
    """Return by how many coarse rows the middles of one marker may differ between neighbouring columns."""
    return STEP_SLACK + STEP_SHARE * middle


@compiled
def coarse_runs(
    image: NDArray[np.uint8],
    address: NDArray[np.int32],
    classes: NDArray[np.uint8],
    top: int,
    bottom: int,
    across: int,
    down: int,
    runs: NDArray[np.int32],
    state: NDArray[np.int32],
) -> int:
    """Write column, class, first and last + 1 row of every run of the two colours; return how many.

    Rows and columns are coarse. The picture is read row by row, as it lies in memory; ``state`` holds
    class, first and last row of the run that each column is in.
    """
    columns, rows = len(state), image.shape[0] // down
    count = 0
    for row in range(rows + 1):
        v = min(row * down + down // 2, image.shape[0] - 1)
        for column in range(columns):
            kind = 0
            if row < rows:
                u = column * across + across // 2
                place = address[0, image[v, u, 0]] + address[1, image[v, u, 1]] + address[2, image[v, u, 2]]
                kind = classes[place]
            held = state[column, 0]
            if kind == held:
                state[column, 2] = row
                continue
            if kind not in (top, bottom):
                kind = 0
                if held == 0 or (row < rows and row - state[column, 2] < RUN_GAP):
                    continue
            if held != 0 and count < RUNS:
                runs[count, 0], runs[count, 1] = column, held
                runs[count, 2], runs[count, 3] = state[column, 1], state[column, 2] + 1
                count += 1
            state[column, 0], state[column, 1], state[column, 2] = kind, row, row
    return count


@compiled
def pair_runs(
    runs: NDArray[np.int32],
    columns: int,
    height: int,
    top: int,
    bottom: int,
    upper: float,
    lower: float,
    pairs: FloatArray,
) -> int:
    """Write column, rows of the top band, rows of the bottom band and which bands; return how many."""
    # Runs of one column, chained in their order from the top down.
    first, following = np.full(columns, -1), np.full(len(runs), -1)
    last = np.full(columns, -1)
    for i in range(len(runs)):
        column = runs[i, 0]
        if first[column] < 0:
            first[column] = i
        else:
            following[last[column]] = i
        last[column] = i
    found = 0
    for column in range(columns):
        a = first[column]
        while a >= 0:
            thick = float(runs[a, 3] - runs[a, 2])
            if runs[a, 1] == top:
                paired = False
                b = following[a]
                while b >= 0:
                    if runs[b, 1] == bottom and found < PAIRS:
                        middle = float(runs[b, 2] - runs[a, 3])
                        fits = middle >= 1.0
                        off = thick - middle * upper
                        slack = HEIGHT_SLACK + HEIGHT_SHARE * middle * upper
                        least = -slack if runs[a, 2] > 0 else (LEAST_SHOWN - 1.0) * middle * upper
                        if off > slack or off < least:
                            fits = False
                        off = float(runs[b, 3] - runs[b, 2]) - middle * lower
                        slack = HEIGHT_SLACK + HEIGHT_SHARE * middle * lower
                        least = -slack if runs[b, 3] < height else (LEAST_SHOWN - 1.0) * middle * lower
                        if off > slack or off < least:
                            fits = False
                        if fits:
                            _write_pair(
                                pairs[found], column, runs[a, 2], runs[a, 3], runs[b, 2], runs[b, 3], BOTH
                            )
                            found += 1
                            paired = True
                    b = following[b]
                middle = thick / upper
                cut = runs[a, 2] > 0 and runs[a, 3] + REACH_OUT * middle >= height
                if not paired and cut and thick >= LEAST_THICK and found < PAIRS:
                    start = runs[a, 3] + middle
                    foot = start + middle * lower
                    _write_pair(pairs[found], column, runs[a, 2], runs[a, 3], start, foot, TOP_ONLY)
                    found += 1
            if runs[a, 1] == bottom:
                middle = thick / lower
                cut = runs[a, 3] < height and runs[a, 2] - REACH_OUT * middle <= 0.0
                if cut and thick >= LEAST_THICK and found < PAIRS:
                    end = runs[a, 2] - middle
                    start = end - middle * upper
                    _write_pair(pairs[found], column, start, end, runs[a, 2], runs[a, 3], BOTTOM_ONLY)
                    found += 1
            a = following[a]
    return found


@compiled
def _write_pair(
    pair: FloatArray, column: int, start: float, end: float, below: float, foot: float, bands: int
) -> None:
    pair[0], pair[1], pair[2], pair[3], pair[4], pair[5] = column, start, end, below, foot, bands


@compiled
def chain_pairs(pairs: FloatArray, chain: NDArray[np.int64]) -> int:
    """Write to which chain each pair belongs; return how many chains there are.

    A chain is pairs, sorted by column, whose inner edges run on smoothly.
    """
    last = np.empty(CHAINS, dtype=np.int64)
    chains = 0
    for i in range(len(pairs)):
        best, nearest = -1, np.inf
        for c in range(chains):
            before = last[c]
            step = pairs[i, 0] - pairs[before, 0]
            if step <= 0.0 or step > COLUMN_GAP or pairs[i, 5] != pairs[before, 5]:
                continue
            slack = ROW_SLACK * step + ROW_SHARE * (pairs[i, 3] - pairs[i, 2])
            jump = abs(pairs[i, 2] - pairs[before, 2]) if pairs[i, 5] != BOTTOM_ONLY else 0.0
            if pairs[i, 5] != TOP_ONLY:
                jump = max(jump, abs(pairs[i, 3] - pairs[before, 3]))
            if jump <= slack and jump + step < nearest:
                best, nearest = c, jump + step
        if best < 0:
            if chains == CHAINS:
                chain[i] = CHAINS
                continue
            best = chains
            chains += 1
        chain[i] = best
        last[best] = i
    return chains


@compiled
def split_chains(
    pairs: FloatArray,
    chain: NDArray[np.int64],
    chains: int,
    bounds: NDArray[np.int64],
    middles: FloatArray,
) -> int:
    """Cut chains where the height of the middle steps: there one marker stands before another.

    Writes first and last + 1 pair of every piece, and the medians of its middle's height and of the
    row where that begins (coarse rows); returns how many pieces there are.
    """
    heights = pairs[:, 3] - pairs[:, 2]
    count = 0
    start = 0
    while start < len(chain) and chain[start] < chains:
        end = start
        while end < len(chain) and chain[end] == chain[start]:
            end += 1
        first = start
        while first < end:
            last = end
            worst = 0.0
            # Where one band must do, the middle is a guess.
            cuts = end - STEP_COLUMNS + 1 if pairs[first, 5] == BOTH else first
            for k in range(first + STEP_COLUMNS, cuts):
                before = np.median(heights[k - STEP_COLUMNS : k])
                after = np.median(heights[k : k + STEP_COLUMNS])
                step = abs(after - before) - _alike(min(before, after))
                if step > worst:
                    worst, last = step, k
                elif worst > 0.0:
                    break
            if last - first >= LEAST_COLUMNS and count < len(bounds):
                bounds[count, 0], bounds[count, 1] = first, last
                middles[count, 0] = np.median(heights[first:last])
                middles[count, 1] = np.median(pairs[first:last, 2])
                count += 1
            first = last
        start = end
    return count
