"""Medians of a few numbers, in place and without memory of their own."""

from __future__ import annotations

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray


@leaf
def select(values: FloatArray, count: int, place: int) -> float:
    """Return the number at a place (from 0) of the ascending order of the first ``count``, parting them.

    Smaller ones come to lie before the place, and larger ones behind it (C. A. R. Hoare, Commun. ACM 4, 1961,
    doi:10.1145/366622.366647). Parted by N. Lomuto's scheme (J. Bentley, Programming Pearls, 1986): every
    number is moved, and what is compared moves the border alone, so there is no branch that would be guessed
    wrong half of the time.
    """
    low, high = 0, count - 1
    while low < high:
        pivot = values[place]
        values[place], values[high] = values[high], pivot
        border = low
        for i in range(low, high):
            value = values[i]
            values[i] = values[border]
            values[border] = value
            border += 1 if value < pivot else 0
        if border == low:  # none is smaller: past all that are the same at once
            for i in range(low, high):
                value = values[i]
                values[i] = values[border]
                values[border] = value
                border += 1 if value <= pivot else 0
            if place < border:
                break
        values[high] = values[border]
        values[border] = pivot
        if border < place:
            low = border + 1
        elif border > place:
            high = border - 1
        else:
            break
    chosen: float = values[place]
    return chosen


@leaf
def middle_of(a: float, b: float, c: float) -> float:
    """Return the median of three numbers."""
    return max(min(a, b), min(max(a, b), c))


@leaf
def median_of(values: FloatArray, count: int, spare: FloatArray) -> float:
    """Return the median of the first ``count`` numbers; nan of none. ``spare`` is written."""
    if count == 0:
        return float("nan")
    for i in range(count):
        spare[i] = values[i]
    return median_in_place(spare, count)


@leaf
def median_in_place(values: FloatArray, count: int) -> float:
    """Return the median of the first ``count`` numbers, one or more, whose order is lost."""
    half = count // 2
    upper = select(values, count, half)
    if count % 2 == 1:
        return upper
    lower: float = values[0]
    for i in range(1, half):
        lower = max(lower, values[i])
    return 0.5 * (lower + upper)


@leaf
def weighted_median(
    values: FloatArray, weights: FloatArray, count: int, keys: FloatArray, loads: FloatArray
) -> float:
    """Return the value at which half of the weight is passed; ``keys`` and ``loads`` are written.

    By parting as in :func:`select`, going on where the half is.
    """
    half = 0.0
    for i in range(count):
        keys[i], loads[i] = values[i], weights[i]
        half += 0.5 * weights[i]
    low, high, passed = 0, count - 1, 0.0
    while low < high:
        middle = (low + high) // 2
        pivot, load = keys[middle], loads[middle]
        keys[middle], loads[middle] = keys[high], loads[high]
        border, smaller = low, 0.0
        for i in range(low, high):
            key, each = keys[i], loads[i]
            keys[i], loads[i] = keys[border], loads[border]
            keys[border], loads[border] = key, each
            border += 1 if key < pivot else 0
            smaller += each if key < pivot else 0.0
        keys[high], loads[high] = keys[border], loads[border]
        keys[border], loads[border] = pivot, load
        if passed + smaller >= half and border > low:
            high = border - 1
        elif passed + smaller + load >= half or border == high:
            low = high = border
        else:
            passed += smaller + load
            low = border + 1
    chosen: float = keys[low]
    return chosen
