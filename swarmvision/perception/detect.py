"""A picture into marker candidates: the top band over the bottom band, column by column.

In one column the heights of top band, middle and bottom band stand in the marker's own proportion,
however much of the marker's width is hidden; columns that agree with their neighbours make a
candidate. So a marker behind another, or cut by the picture's side, needs no special case. Where the
picture ends before the other band can be seen, one band must do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.perception.look import (
    CHAINS,
    PIECES,
    Address,
    Ints,
    Look,
    LookScratch,
    Proportions,
    everywhere,
    first_look,
    look_down,
    look_on,
)
from swarmvision.perception.order import median_in_place, median_of
from swarmvision.perception.pairs import (
    BOTH,
    BOTTOM_ONLY,
    ROW_SHARE,
    TOP_ONLY,
    ask_beside,
    pair_runs,
)
from swarmvision.perception.segment import Balance, Hues
from swarmvision.perception.steps import COMPARED, step_at

LEAST_COLUMNS = 2  # of the grid
WIDENINGS = 16  # of windows in one picture
ROW_SLACK = 1.6  # rows of the grid that an edge may jump between columns, plus ROW_SHARE of the middle
STEP_SLACK = 1.2  # rows of the grid by which the height of the middle may change within a marker,
STEP_SHARE = 0.04  # and by which share of itself; more is one marker beside another
COLUMN_GAP = 5  # columns of the grid to the next of a candidate; of a wide one each fourth is looked at
STEEPEST = 3.0  # columns of the grid in which an edge may go on falling
P_LEFT, P_RIGHT, P_MIDDLE, P_LEVEL, P_KIND, P_FIRST, P_LAST = range(7)  # what is written of a candidate


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


def candidates(
    image: NDArray[np.uint8], balance: Balance, hues: Hues, marker: Proportions
) -> list[Candidate]:
    """Return the marker candidates of a picture ``(h, w, 3)``, tallest first, by a look at the whole grid."""
    look = Look.of(image.shape[1], image.shape[0], hues, marker)
    windows = everywhere(look)
    scratch = LookScratch.of(image.shape[1])
    if len(look.rows) == 0:
        return []
    found = []
    for piece in scratch.pieces[: find(image, balance.address, look, windows, scratch)]:
        own = slice(int(piece[P_FIRST]), int(piece[P_LAST]))
        if own.start >= own.stop:  # merged into another
            continue
        found.append(
            Candidate(
                float(piece[P_LEFT]),
                float(piece[P_RIGHT]),
                float(piece[P_MIDDLE]),
                float(piece[P_LEVEL]),
                scratch.columns[own].copy(),
                scratch.rows[own].copy(),
                int(piece[P_KIND]),
            )
        )
    return found


@leaf
def find(image: NDArray[np.uint8], address: Address, look: Look, windows: Ints, scratch: LookScratch) -> int:
    """Write the candidates of a picture, tallest first, into ``scratch.pieces``; return how many.

    Windows are those of :func:`swarmvision.perception.look.first_look`; they are widened where a marker
    stands at their sides.
    """
    width = image.shape[1] // look.across
    for column in range(width):
        scratch.links[column, 0] = -1
        scratch.wanted[column, 0], scratch.wanted[column, 1] = 1 << 30, -1
    count = first_look(image, address, look, windows, scratch)
    if count == 0:
        return 0
    found = pair_runs(look, width, scratch)
    if found == 0:
        return 0
    for _ in range(WIDENINGS):
        count, wider = look_on(image, address, look, windows, found, count, scratch)
        if not wider:
            break
        found = pair_runs(look, width, scratch)
    if ask_beside(found, look, width, scratch):
        for column in range(width):
            if scratch.wanted[column, 1] >= 0:
                count = look_down(image, address, look, column, count, scratch)
        found = pair_runs(look, width, scratch)
    chains = chain_pairs(found, look, scratch)
    pieces = split_chains(found, chains, look, scratch)
    return merge_pieces(found, pieces, look, scratch)


@leaf
def chain_pairs(found: int, look: Look, scratch: LookScratch) -> int:
    """Write to which chain each pair belongs; return how many chains there are.

    A chain is pairs, sorted by column, whose inner edges run on smoothly.
    """
    pairs, chain, tails = scratch.pairs, scratch.chain[0], scratch.tails
    chains = 0
    for i in range(found):
        best, nearest = -1, np.inf
        pair = pairs[i]
        for c in range(chains):
            before = pairs[tails[c]]
            step = pair[0] - before[0]
            if step <= 0.0 or step > COLUMN_GAP or pair[5] != before[5]:
                continue
            slack = ROW_SLACK * look.down * min(step, STEEPEST) + ROW_SHARE * (pair[3] - pair[2])
            jump = abs(pair[2] - before[2]) if pair[5] != BOTTOM_ONLY else 0.0
            if pair[5] != TOP_ONLY:
                jump = max(jump, abs(pair[3] - before[3]))
            if jump <= slack and jump + step * look.down < nearest:
                best, nearest = c, jump + step * look.down
        if best < 0:
            if chains == CHAINS:
                chain[i] = CHAINS
                continue
            best = chains
            chains += 1
        chain[i] = best
        tails[best] = i
    return chains


@leaf
def sort_by_chain(found: int, chains: int, scratch: LookScratch) -> None:
    """Write the pairs' numbers in the order of their chains, each chain's by column."""
    chain, order, starts = scratch.chain[0], scratch.chain[1], scratch.tails
    for c in range(chains + 2):
        starts[c] = 0
    for i in range(found):
        starts[chain[i] + 1] += 1
    for c in range(chains):
        starts[c + 1] += starts[c]
    for i in range(found):
        if chain[i] < chains:
            order[starts[chain[i]]] = i
            starts[chain[i]] += 1


@leaf
def alike(middle: float, down: int) -> float:
    """Return by how many px the middles of one marker may differ between neighbouring columns."""
    return STEP_SLACK * down + STEP_SHARE * middle


@leaf
def split_chains(found: int, chains: int, look: Look, scratch: LookScratch) -> int:
    """Cut chains where the height of the middle steps: there one marker stands before another.

    Writes every piece of :data:`LEAST_COLUMNS` or more, and to which piece every pair belongs; returns
    how many pieces there are.
    """
    pairs, chain, order, pieces = scratch.pairs, scratch.chain[0], scratch.chain[1], scratch.pieces
    heights, spare = scratch.spare[0], scratch.spare[1]
    sort_by_chain(found, chains, scratch)
    total = scratch.tails[chains - 1] if chains > 0 else 0
    for k in range(total):
        heights[k] = pairs[order[k], 3] - pairs[order[k], 2]
    count = start = 0
    while start < total:
        end = start
        own = chain[order[start]]
        while end < total and chain[order[end]] == own:
            end += 1
        first = start
        while first < end:
            last = end
            worst = 0.0
            # Where one band must do, the middle is a guess.
            both = pairs[order[first], 5] == BOTH
            cuts = end - COMPARED + 1 if both else first
            for k in range(first + COMPARED, cuts):
                step, lower = step_at(heights, first, k, end, spare)
                step -= alike(lower, look.down)
                if step > worst:
                    worst, last = step, k
                elif worst > 0.0:
                    break
            keep = last - first >= LEAST_COLUMNS and count < PIECES
            if keep:
                piece = pieces[count]
                piece[P_LEFT] = pairs[order[first], 0] * look.across
                piece[P_RIGHT] = (pairs[order[last - 1], 0] + 1.0) * look.across
                piece[P_KIND] = pairs[order[first], 5]
                piece[P_MIDDLE] = median_of(heights[first:last], last - first, spare)
                for k in range(first, last):
                    spare[k - first] = pairs[order[k], 2]
                piece[P_LEVEL] = median_in_place(spare, last - first)
            for k in range(first, last):
                # Negative: of a piece, for chains are told apart by the numbers from 0.
                chain[order[k]] = -1 - count if keep else chains
            count += 1 if keep else 0
            first = last
        start = end
    for i in range(found):
        chain[i] = -1 - chain[i] if chain[i] < 0 else count
    return count


@leaf
def merge_pieces(found: int, pieces: int, look: Look, scratch: LookScratch) -> int:
    """Join pieces of one marker: of one height, in line, together no wider than it; return how many are left.

    Writes columns and rows of every candidate, and the candidates tallest first.
    """
    piece, order, owner = scratch.pieces, scratch.order[0], scratch.order[1]
    for i in range(pieces):  # by their left ends
        j = i
        while j > 0 and piece[order[j - 1], P_LEFT] > piece[i, P_LEFT]:
            order[j] = order[j - 1]
            j -= 1
        order[j] = i
    kept = 0
    for i in range(pieces):
        number = order[i]
        this = piece[number]
        owner[number] = number
        for j in range(kept):
            other = piece[order[j]]
            # Near the lens a cylinder looks wider than its far proportion; 1.35 covers 0.1 m.
            widest = 1.35 * look.width * max(this[P_MIDDLE], other[P_MIDDLE]) + 4.0
            slack = alike(other[P_MIDDLE], look.down)
            if (
                abs(this[P_MIDDLE] - other[P_MIDDLE]) < slack
                and this[P_KIND] == other[P_KIND]
                and abs(this[P_LEVEL] - other[P_LEVEL]) < 2.0 * slack
                and this[P_RIGHT] - other[P_LEFT] <= widest
            ):
                other[P_RIGHT] = max(this[P_RIGHT], other[P_RIGHT])
                owner[number] = order[j]
                break
        if owner[number] == number:
            order[kept] = number
            kept += 1
    _gather(found, pieces, look, scratch)
    # Tallest first: selection, for the rows themselves are to be in order.
    for i in range(kept):
        best = i
        for j in range(i + 1, kept):
            one, two = piece[order[j]], piece[order[best]]
            if one[P_MIDDLE] > two[P_MIDDLE] or (
                one[P_MIDDLE] == two[P_MIDDLE] and one[P_LEFT] < two[P_LEFT]
            ):
                best = j
        held = order[i]
        order[i] = order[best]
        order[best] = held
    return kept


@leaf
def _gather(found: int, pieces: int, look: Look, scratch: LookScratch) -> None:
    """Write columns and rows (px) of every candidate, one candidate after the other."""
    pairs, chain, piece, owner = scratch.pairs, scratch.chain[0], scratch.pieces, scratch.order[1]
    for i in range(found):
        chain[i] = owner[chain[i]] if chain[i] < pieces else pieces
    sort_by_chain(found, pieces, scratch)
    start = 0
    for number in range(pieces):
        piece[number, P_FIRST], piece[number, P_LAST] = start, scratch.tails[number]
        start = scratch.tails[number]
    for k in range(start):
        pair = pairs[scratch.chain[1, k]]
        scratch.columns[k] = (pair[0] + 0.5) * look.across
        for edge in range(4):
            scratch.rows[k, edge] = pair[1 + edge]
