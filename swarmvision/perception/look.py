"""The coarse look at a picture: runs of the marker's two ring colours, column by column.

Each pixel is one look into a table. Rows are as far apart as the bands that can show there allow: a marker
far below or above the horizon is near, so its bands are thick. Where two rows disagree, rows between them
tell where a band ends. Of the grid's columns every other one is looked at first, and of those every other
one only near the horizon, where a marker may be narrow; those between, only beside a pair of bands.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception.segment import Hues

COARSE_WIDTH, COARSE_HEIGHT = 320, 230  # px: about so fine a grid is looked at
RUNS = 8192  # runs of colour that one picture may hold
PAIRS = 4096  # pairs of runs that one picture may hold
CHAINS = 256  # chains of pairs that one picture may hold
PIECES = 2 * CHAINS + 1  # candidates that one picture may hold
RUN_GAP = 2  # steps down to the next pixel of a run; 1 would break it at a single lost pixel
LOOKS = 2.5  # rows that are looked at in the thinnest band that can show there
NARROW = 12.0  # columns of the grid: a wider marker is looked for in every fourth only
TILT = 0.07  # rad: more than the 3 deg that a camera may look up or down
HORIZON_SLACK = 0.012  # m: by which a marker may stand higher or lower than it should
AT_SIDE, ON = 4, 8  # columns of the grid: pairs so near to a window's side let it be so much wider
Ints = NDArray[np.int32]
Address = NDArray[np.uint16]


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
    radius: float
    """m"""
    spans: tuple[tuple[float, float], tuple[float, float]]
    """Of top and bottom band, bottom and top above the ground (m)."""

    @classmethod
    def of(cls, marker: Marker, hues: Hues) -> Proportions | None:
        """Return a marker's; None if its top or bottom band has no hue."""
        top, bottom = hues.number(marker.bands[0].colour), hues.number(marker.bands[-1].colour)
        if top is None or bottom is None:
            return None
        first, last = marker.bands[0], marker.bands[-1]
        middle = first.bottom - last.top
        return cls(
            top,
            bottom,
            (marker.height - first.bottom) / middle,
            last.top / middle,
            2.0 * marker.radius / middle,
            marker.radius,
            (
                (marker.base + first.bottom, marker.base + first.top),
                (marker.base + last.bottom, marker.base + last.top),
            ),
        )


class Look(NamedTuple):
    """How pictures of one size are looked at; plain arrays and numbers, for kernels."""

    rows: Ints
    """That are looked at, ascending, shape ``(n,)``."""
    near: Ints
    """First and last + 1 of them that are near the horizon, shape ``(2,)``."""
    columns: NDArray[np.uint32]
    """Picture column of every column of the grid, shape ``(c,)``."""
    across: int
    """Picture columns in one of the grid."""
    down: int
    """Picture rows in one of the grid."""
    top: int
    """As in :class:`Proportions`, like the next four."""
    bottom: int
    upper: float
    lower: float
    width: float
    classes: NDArray[np.uint8]
    """Of :class:`swarmvision.perception.segment.Hues`."""

    @classmethod
    def of(
        cls, width_px: int, height_px: int, hues: Hues, marker: Proportions, lens: Lens | None = None
    ) -> Look:
        """Return how to look at pictures of a size; without a lens every row of the grid is looked at."""
        across = max(1, round(width_px / COARSE_WIDTH))
        down = max(1, round(height_px / COARSE_HEIGHT))
        rows = np.arange(height_px // down) * down + down // 2
        columns = (np.arange(width_px // across) * across + across // 2).astype(np.uint32)
        near = (0, len(rows))
        if lens is not None:
            rows = rows[_needed(rows, down, marker, lens)]
            nearest = 2.0 * marker.radius * lens.focal_px / (NARROW * across)
            high = max(abs(z - lens.height) for span in marker.spans for z in span) + HORIZON_SLACK
            reach = lens.focal_px * (TILT + high / nearest)
            near = tuple(np.searchsorted(rows, [lens.centre_px[1] - reach, lens.centre_px[1] + reach]))
        return cls(
            rows.astype(np.int32), np.array(near, np.int32), columns, across, down, marker.top, marker.bottom,
            marker.upper, marker.lower, marker.width, hues.classes,
        )  # fmt: skip


class LookScratch(NamedTuple):
    """Room for the coarse look at pictures of one size; one per thread."""

    state: Ints
    """Class, first and last place in the rows of the run that every column of the grid is in, ``(3, n)``."""
    links: Ints
    """Of every column of the grid: its first and its last run; below 0 for none."""
    wanted: Ints
    """Of every column of the grid: rows (px) between which it is to be looked at next."""
    runs: Ints
    """Column, class, first and last + 1 row (px), next run in the column; ``(RUNS, 5)``."""
    pairs: FloatArray
    """Column, rows of the top band, rows of the bottom band, which bands; ``(PAIRS, 6)``."""
    chain: Ints
    """Chain, and later candidate, that a pair belongs to; the pair at a place; ``(2, PAIRS)``."""
    tails: Ints
    """Last pair of a chain, or where a chain ends in the order of chains; ``(PIECES + 2,)``."""
    pieces: FloatArray
    """Candidates, ``(PIECES, 7)``."""
    order: Ints
    """Numbers of candidates, and whose pieces they are; ``(2, PIECES)``."""
    columns: FloatArray
    """Of all candidates (px), ``(PAIRS,)``."""
    rows: FloatArray
    """Of all candidates (px), ``(PAIRS, 4)``."""
    spare: FloatArray
    """``(2, PAIRS)``."""

    @classmethod
    def of(cls, width_px: int) -> LookScratch:
        """Return room for pictures of a width."""
        return cls(
            np.empty((3, width_px), np.int32),
            np.empty((width_px, 2), np.int32),
            np.empty((width_px, 2), np.int32),
            np.empty((RUNS, 5), np.int32),
            np.empty((PAIRS, 6)),
            np.empty((2, PAIRS), np.int32),
            np.empty(PIECES + 2, np.int32),
            np.empty((PIECES, 7)),
            np.empty((2, PIECES), np.int32),
            np.empty(PAIRS),
            np.empty((PAIRS, 4)),
            np.empty((2, PAIRS)),
        )


def _needed(rows: NDArray[np.int64], down: int, marker: Proportions, lens: Lens) -> NDArray[np.int64]:
    """Return which of the grid's rows are looked at: those that no band which can show there slips by."""
    if len(rows) == 0:
        return np.empty(0, dtype=np.int64)
    steps = np.ones(len(rows), dtype=np.int64)
    for i, row in enumerate(rows):
        rise = max(abs(float(lens.rise_from_row(float(row)))) - TILT, 0.0)
        # A band that shows at this rise is no farther than its height over it.
        thin = min(
            lens.focal_px * (high - low) * rise
            / (max(abs(low - lens.height), abs(high - lens.height)) + HORIZON_SLACK)
            for low, high in marker.spans
        )  # fmt: skip
        steps[i] = max(int(thin / LOOKS / down), 1)
    horizon = int(np.clip(np.searchsorted(rows, lens.centre_px[1]), 0, len(rows) - 1))
    chosen = {0, len(rows) - 1, horizon}
    for way in (-1, 1):  # outwards: the row nearer to the horizon decides
        i = horizon
        while 0 <= i < len(rows):
            chosen.add(i)
            i += way * int(steps[i])
    return np.array(sorted(chosen), dtype=np.int64)


@leaf
def whole(number: int) -> int:
    """Return the same number in 64 bits: for 32 and for 64 what is handed it would be compiled twice."""
    return int(np.int64(number))


@leaf
def class_at(image: NDArray[np.uint8], address: Address, classes: NDArray[np.uint8], v: int, u: int) -> int:
    """Return the class of a pixel."""
    kind: int = classes[address[0, image[v, u, 0]] + address[1, image[v, u, 1]] + address[2, image[v, u, 2]]]
    return kind


def everywhere(look: Look) -> Ints:
    """Return the window that is a whole picture, ``(1, 4)``, see :func:`first_look`."""
    return np.array([[0, len(look.columns), 0, len(look.rows)]], dtype=np.int32)


@leaf
def first_look(
    image: NDArray[np.uint8], address: Address, look: Look, windows: Ints, scratch: LookScratch
) -> int:
    """Write the runs of the two colours in every other column of the grid; return how many.

    The picture is read row by row, as it lies in memory. A window is its first and last + 1 column of the
    grid and place in the rows that are looked at; none shares a column with another, and each begins at a
    fourth one.
    """
    count = 0
    for window in windows:
        left, right = whole(window[0]), whole(window[1])
        count = look_through(image, address, look, left, right, window, count, scratch)
    return count


@leaf
def look_through(
    image: NDArray[np.uint8],
    address: Address,
    look: Look,
    left: int,
    right: int,
    window: Ints,
    count: int,
    scratch: LookScratch,
) -> int:
    """Write the runs in columns, in a window's rows, behind those that there are; return how many then."""
    held, first, last = scratch.state[0], scratch.state[1], scratch.state[2]
    red, green, blue, classes = address[0], address[1], address[2], look.classes
    top, bottom, rows = look.top, look.bottom, look.rows
    for column in range(left, right):
        held[column] = 0
    for i in range(window[2], window[3]):
        line = image[rows[i]]
        stride = 2 if look.near[0] <= i < look.near[1] else 4
        for column in range(left, right, stride):
            u = look.columns[column]
            kind = classes[red[line[u, 0]] + green[line[u, 1]] + blue[line[u, 2]]]
            if kind != top and kind != bottom:  # noqa: PLR1714  # not by a tuple: this line is the whole look
                if held[column] == 0 or i - last[column] < RUN_GAP:
                    continue
                kind = 0
            elif kind == held[column]:
                last[column] = i
                continue
            if held[column] != 0:
                run = whole(held[column]), whole(first[column]), whole(last[column])
                count = end_run(image, address, look, column, run, count, scratch)
            held[column], first[column], last[column] = kind, i, i
    for column in range(left, right, 2):
        if held[column] != 0:
            run = whole(held[column]), whole(first[column]), whole(last[column])
            count = end_run(image, address, look, column, run, count, scratch)
    return count


@leaf
def look_on(
    image: NDArray[np.uint8],
    address: Address,
    look: Look,
    windows: Ints,
    found: int,
    count: int,
    scratch: LookScratch,
) -> tuple[int, bool]:
    """Widen windows at whose sides pairs stand, for the marker may go on there; write the runs in that.

    Returns how many runs there are then, and whether any window is wider.
    """
    width, wider = len(look.columns), False
    for window in windows:
        left = right = False
        begin, end = whole(window[0]), whole(window[1])
        for i in range(found):
            column = int(scratch.pairs[i, 0])
            left |= begin <= column < begin + AT_SIDE
            right |= end - AT_SIDE <= column < end
        low, high = max(0, begin - ON), min(width, end + ON)
        for other in windows:
            if other[1] <= begin:
                low = max(low, whole(other[1]))
            if other[0] >= end:
                high = min(high, whole(other[0]))
        if left and low < begin:
            count = look_through(image, address, look, low, begin, window, count, scratch)
            window[0], wider = low, True
        if right and high > end:
            count = look_through(image, address, look, end, high, window, count, scratch)
            window[1], wider = high, True
    return count, wider


@leaf
def look_down(
    image: NDArray[np.uint8], address: Address, look: Look, column: int, count: int, scratch: LookScratch
) -> int:
    """Write the runs of one column between the rows that are wanted; return how many there are now."""
    rows = look.rows
    held = first = last = 0
    u = column * look.across + look.across // 2
    for i in range(len(rows) + 1):
        kind = 0
        if i < len(rows):
            v = whole(rows[i])
            if v < scratch.wanted[column, 0]:
                continue
            if v <= scratch.wanted[column, 1]:
                kind = class_at(image, address, look.classes, v, u)
        if kind == held:
            last = i
            continue
        if kind not in (look.top, look.bottom):
            kind = 0
            if held == 0 or (i < len(rows) and i - last < RUN_GAP):
                continue
        if held != 0:
            count = end_run(image, address, look, column, (held, first, last), count, scratch)
        held, first, last = kind, i, i
    return count


@leaf
def end_run(
    image: NDArray[np.uint8],
    address: Address,
    look: Look,
    column: int,
    run: tuple[int, int, int],
    count: int,
    scratch: LookScratch,
) -> int:
    """Write a run, its class, first and last place in the rows; return how many there are now."""
    if count == RUNS:
        return count
    kind, first, last = run
    rows, down, classes = look.rows, look.down, look.classes
    u = column * look.across + look.across // 2
    # On, where not every row of this column was looked at.
    while first > 0 and class_at(image, address, classes, whole(rows[first - 1]), u) == kind:
        first -= 1
    while last + 1 < len(rows) and class_at(image, address, classes, whole(rows[last + 1]), u) == kind:
        last += 1
    inside = outside = whole(rows[first])
    if first > 0:
        outside = whole(rows[first - 1])
    while inside - outside > down:
        v = (inside + outside) // 2
        if class_at(image, address, classes, v, u) == kind:
            inside = v
        else:
            outside = v
    start = inside - down // 2
    inside = outside = whole(rows[last])
    if last + 1 < len(rows):
        outside = whole(rows[last + 1])
    while outside - inside > down:
        v = (inside + outside) // 2
        if class_at(image, address, classes, v, u) == kind:
            inside = v
        else:
            outside = v
    line = scratch.runs[count]
    line[0], line[1], line[2], line[3], line[4] = column, kind, start, inside - down // 2 + down, -1
    links = scratch.links[column]
    if links[0] < 0:
        links[0] = count
    else:
        scratch.runs[links[1], 4] = count
    links[1] = count
    return count + 1
