"""The tables of the error model from a record of flights: frequencies, quantiles and correlations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from swarmvision.experiments.flights import (
    COLUMNS,
    ERRORS,
    GHOST,
    MEASURED,
    PHANTOM,
    REMEMBERED,
    STDS,
    UNSEEN,
    Record,
)
from swarmvision.geometry import FloatArray
from swarmvision.sensing.error_table import AGES, DEVIATES, RANGES, TURNS, ErrorTable
from swarmvision.sensing.error_views import VIEWS, WHOLE, view_of

ENOUGH = 300  # samples of a bin's quantiles; with fewer, its neighbours' are taken in too
ENOUGH_SHARES = 20  # samples of a bin's chances, likewise
LAGS = np.array([1, 2, 3, 4, 6, 8])  # pictures, at which correlations in time are taken


def fit(rows: Record, radius: float) -> ErrorTable:
    """Return the tables of a record of markers of some radius (m)."""
    column = dict(zip(COLUMNS, rows.T, strict=True))
    state = column["state"].astype(int)
    pair = (state != GHOST) & (state != PHANTOM)
    bins = (len(RANGES) + 1, len(TURNS) + 1, VIEWS)
    view, sign = _views(column["range"], column["bearing"], column["visible"], column["turn"], radius)
    place = np.stack(
        [
            np.searchsorted(RANGES, column["range"], side="right"),
            np.searchsorted(TURNS, np.abs(column["turn"]), side="right"),
            view,
        ],
        axis=1,
    )
    errors = rows[:, [COLUMNS.index(name) for name in ERRORS]]
    errors[:, 1:] *= sign[:, None]
    stds = rows[:, [COLUMNS.index(name) for name in STDS]]
    scaled = errors / np.column_stack([column["range"] ** 2, np.ones((len(rows), 2))])
    before = _state_before(rows)
    measured = state == MEASURED
    again, anew = np.zeros(bins), np.zeros(bins)
    fresh, fresh_std = np.zeros((*bins, 3, len(DEVIATES))), np.zeros((*bins, 3))
    for index in np.ndindex(*bins):
        for table, rest in ((again, before == MEASURED), (anew, (before >= 0) & (before != MEASURED))):
            some = _pooled(place, index, pair & rest, ENOUGH_SHARES, SHARE_POOLS)
            table[index] = float(np.mean(measured[some])) if len(some) else 0.0
        some = _pooled(place, index, measured)
        fresh[index], fresh_std[index] = _quantiles(scaled[some]), np.sqrt(np.mean(stds[some] ** 2, axis=0))
    ages, t = np.searchsorted(AGES, column["age"], side="right"), place[:, 1]
    aged_std = np.zeros((len(AGES) + 1, bins[1], 3))
    at = np.stack([ages, t, np.zeros_like(t)], axis=1)
    for a, turn in np.ndindex(*aged_std.shape[:2]):
        some = _pooled(at, (a, turn, 0), state == REMEMBERED)
        aged_std[a, turn] = np.sqrt(np.mean(stds[some] ** 2, axis=0))
    pictures = len(np.unique(rows[:, :3], axis=0))
    nobody = errors[state == PHANTOM]
    lasting, memory, common = _correlations(rows, scaled, place, sign, measured, fresh)
    return ErrorTable(
        again=again,
        anew=anew,
        fresh=fresh,
        fresh_std=fresh_std,
        aged_std=aged_std,
        phantom=np.array([len(nobody) / max(pictures, 1)]),
        phantom_place=_quantiles(nobody[:, :2]),
        lasting=lasting,
        memory=memory,
        common=common,
    )


def _views(
    distance: FloatArray, bearing: FloatArray, visible: FloatArray, turn: FloatArray, radius: float
) -> tuple[NDArray[np.int64], FloatArray]:
    """Return how each row's marker is seen, and the sign that its errors are stored with, ``(rows,)``."""
    seen = [view_of(*row, radius) for row in zip(distance, bearing, visible, strict=True)]
    view, side = np.array(seen).reshape(-1, 2).T
    return view.astype(np.int64), np.where(view > WHOLE, side, np.where(turn >= 0.0, 1.0, -1.0))


POOLS = ((0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 2, 1), (2, 2, 2), (4, 4, 4), (99,) * 3)
"""How far around a bin to go for its errors: the visible fraction is let go first, then turn and range."""
SHARE_POOLS = ((0, 0, 0), (0, 1, 0), (0, 4, 0), (1, 1, 0), (1, 4, 0), (2, 4, 0), (99, 99, 0), (99, 99, 99))
"""And for its chances, which depend most of all on the visible fraction."""


def _pooled(
    place: NDArray[np.int64],
    index: tuple[int, ...],
    mask: NDArray[np.bool_],
    enough: int = ENOUGH,
    pools: tuple[tuple[int, ...], ...] = POOLS,
) -> NDArray[np.int64]:
    """Return the rows of a bin, with those of bins around it until there are enough."""
    off = np.abs(place - index)
    rows = np.empty(0, np.int64)
    for reach in pools:
        rows = np.flatnonzero(mask & (off <= reach).all(axis=1))
        if len(rows) >= enough:
            break
    return rows


def _quantiles(errors: FloatArray) -> FloatArray:
    """Return the quantiles of each column at :data:`DEVIATES`, shape ``(columns, q)``; 0 for no rows."""
    if len(errors) == 0:
        return np.zeros((errors.shape[1], len(DEVIATES)))
    return np.asarray(np.quantile(errors, ndtr(DEVIATES), axis=0).T)


def _numbers(rows: Record) -> NDArray[np.int64]:
    """Return one number for each (flight, observer, neighbour, time) such that time counts by one."""
    flight, time, observer, neighbour = rows[:, :4].astype(np.int64).T
    numbers: NDArray[np.int64] = ((flight * 1000 + observer) * 1000 + neighbour) * 100_000 + time
    return numbers


def _state_before(rows: Record) -> NDArray[np.int64]:
    """Return the state of the same pair one picture before, UNSEEN in the first; -1 beyond reach."""
    pair = np.isin(rows[:, COLUMNS.index("state")], (UNSEEN, MEASURED, REMEMBERED))
    numbers, known = _numbers(rows), _numbers(rows[pair])
    order = np.argsort(known)
    known, states = known[order], rows[pair][order, COLUMNS.index("state")].astype(np.int64)
    at = np.clip(np.searchsorted(known, numbers - 1), 0, len(known) - 1)
    before = np.where(known[at] == numbers - 1, states[at], -1)
    return np.where(rows[:, 1] == 0, UNSEEN, before)


def _correlations(
    rows: Record,
    errors: FloatArray,
    place: NDArray[np.int64],
    sign: FloatArray,
    measured: NDArray[np.bool_],
    fresh: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how much of the normal deviates lasts, how long, and what neighbours share, each ``(3,)``."""
    z = np.full((int(np.count_nonzero(measured)), 3), np.nan)
    where, values = place[measured], errors[measured]
    for n, (index, error) in enumerate(zip(where, values, strict=True)):
        for q in range(3):
            z[n, q] = np.interp(error[q], fresh[(*index, q)], DEVIATES)
    z[:, 1:] *= sign[measured][:, None]  # an error outlasts a change of the observer's turn
    lasting, memory = np.array([_decay(_numbers(rows[measured]), z[:, q]) for q in range(3)]).T
    flight, time, observer = rows[measured][:, :3].astype(np.int64).T
    look = (flight * 1000 + observer) * 100_000 + time
    order = np.lexsort((rows[measured][:, 3], look))
    same = np.flatnonzero(np.diff(look[order]) == 0)
    common = [_correlation(z[order[same], q], z[order[same + 1], q]) for q in range(3)]
    return lasting, memory, np.clip(common, 0.0, 0.99)


def _decay(numbers: NDArray[np.int64], values: FloatArray) -> tuple[float, float]:
    """Return share and correlation from picture to picture of what lasts, that fit the correlation best.

    Args:
        numbers: From :func:`_numbers`.
        values: As many.
    """
    order = np.argsort(numbers)
    numbers, values = numbers[order], values[order]
    found = []
    for lag in LAGS:
        later = np.clip(np.searchsorted(numbers, numbers + lag), 0, len(numbers) - 1)
        pairs = np.flatnonzero(numbers[later] == numbers + lag)
        found.append(_correlation(values[pairs], values[later[pairs]]))
    shares, keeps = np.meshgrid(np.linspace(0.0, 1.0, 101), np.linspace(0.0, 0.99, 100))
    misfit = np.sum((shares[..., None] * keeps[..., None] ** LAGS - np.array(found)) ** 2, axis=-1)
    best = np.unravel_index(np.argmin(misfit), misfit.shape)
    return float(shares[best]), float(keeps[best])


def _correlation(one: FloatArray, two: FloatArray) -> float:
    return float(np.corrcoef(one, two)[0, 1]) if len(one) > 2 and one.std() > 0 and two.std() > 0 else 0.0
