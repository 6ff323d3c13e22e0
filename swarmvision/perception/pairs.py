"""Pairs of runs in one column: a top band over a bottom band, or one of them at the picture's border."""

from __future__ import annotations

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.perception.look import PAIRS, Look, LookScratch

ROW_SHARE = 0.06  # of the middle's height that an edge may jump between columns, plus some rows
HEIGHT_SLACK = 1.6  # rows of the grid by which a band may be too thick or thin
HEIGHT_SHARE = 0.35  # and by which share of itself
REACH_OUT = 1.25  # of the middle: no farther is the border where the other band is out of the picture
LEAST_SHOWN = 0.35  # of a band's thickness: a band cut thinner by the border is out of the picture
LEAST_THICK = 4.0  # rows of the grid of a band that must do without the other
WIDE = 24.0  # columns of the grid: beside a pair of a wider marker there is no need to look
BESIDE_PAIR = 4.0  # rows of the grid, above and below a pair, that are looked at in the next column
BOTH, TOP_ONLY, BOTTOM_ONLY = 0, 1, 2  # which bands a pair has


@leaf
def ask_beside(found: int, look: Look, width: int, scratch: LookScratch) -> bool:
    """Write in which columns beside the pairs, and between which rows, to look; return whether any."""
    slack = int(BESIDE_PAIR * look.down)
    asked = False
    for i in range(found):
        pair = scratch.pairs[i]
        if look.width * (pair[3] - pair[2]) > WIDE * look.across:
            continue
        margin = slack + int(ROW_SHARE * (pair[3] - pair[2]))
        low, high = int(pair[1]) - margin, int(pair[4]) + margin
        for column in (int(pair[0]) - 1, int(pair[0]) + 1):
            if 0 <= column < width:
                asked = True
                scratch.wanted[column, 0] = min(scratch.wanted[column, 0], low)
                scratch.wanted[column, 1] = max(scratch.wanted[column, 1], high)
    return asked


@leaf
def pair_runs(look: Look, width: int, scratch: LookScratch) -> int:
    """Write the pairs of a top band's run over a bottom band's, column by column; return how many."""
    runs, pairs, down = scratch.runs, scratch.pairs, float(look.down)
    above = look.rows[0] - look.down // 2  # rows that are looked at end here
    below = look.rows[len(look.rows) - 1] - look.down // 2 + look.down
    found = 0
    for column in range(width):
        a = scratch.links[column, 0]
        while a >= 0:
            start, end = float(runs[a, 2]), float(runs[a, 3])
            thick = end - start
            if runs[a, 1] == look.top:
                paired = False
                b = runs[a, 4]
                while b >= 0:
                    if runs[b, 1] == look.bottom and found < PAIRS:
                        under, foot = float(runs[b, 2]), float(runs[b, 3])
                        middle = under - end
                        fits = middle >= down
                        off = thick - middle * look.upper
                        slack = HEIGHT_SLACK * down + HEIGHT_SHARE * middle * look.upper
                        least = -slack if start > above else (LEAST_SHOWN - 1.0) * middle * look.upper
                        if off > slack or off < least:
                            fits = False
                        off = foot - under - middle * look.lower
                        slack = HEIGHT_SLACK * down + HEIGHT_SHARE * middle * look.lower
                        least = -slack if foot < below else (LEAST_SHOWN - 1.0) * middle * look.lower
                        if off > slack or off < least:
                            fits = False
                        if fits:
                            _write_pair(pairs[found], column, start, end, under, foot, BOTH)
                            found += 1
                            paired = True
                    b = runs[b, 4]
                middle = thick / look.upper
                cut = start > above and end + REACH_OUT * middle >= below
                if not paired and cut and thick >= LEAST_THICK * down and found < PAIRS:
                    under = end + middle
                    _write_pair(
                        pairs[found], column, start, end, under, under + middle * look.lower, TOP_ONLY
                    )
                    found += 1
            if runs[a, 1] == look.bottom:
                middle = thick / look.lower
                cut = end < below and start - REACH_OUT * middle <= above
                if cut and thick >= LEAST_THICK * down and found < PAIRS:
                    over = start - middle
                    _write_pair(
                        pairs[found], column, over - middle * look.upper, over, start, end, BOTTOM_ONLY
                    )
                    found += 1
            a = runs[a, 4]
    return found


@leaf
def _write_pair(
    pair: FloatArray, column: int, start: float, end: float, below: float, foot: float, bands: int
) -> None:
    pair[0], pair[1], pair[2], pair[3], pair[4], pair[5] = column, start, end, below, foot, bands
