"""Medians of a few numbers, in place and without memory of their own."""

from __future__ import annotations

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray


@leaf
def select(values: FloatArray, count: int, place: int) -> float:
    """Return the number at a place (from 0) of the ascending order of the first ``count``, parting them.

    Hoare's selection (C. A. R. Hoare, Commun. ACM 4, 1961, doi:10.1145/366622.366647): smaller ones come
    to lie before the place, larger ones behind it.
    """
    low, high = 0, count - 1
    while low < high:
        pivot = values[place]
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i <= j:
                held = values[i]
                values[i] = values[j]
                values[j] = held
                i += 1
                j -= 1
        if j < place:
            low = i
        if place < i:
            high = j
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
    """Return the value at which half of the weight is passed; ``keys`` and ``loads`` are written."""
    total = 0.0
    for i in range(count):  # few: sorted by insertion
        value, weight = values[i], weights[i]
        total += weight
        j = i
        while j > 0 and keys[j - 1] > value:
            keys[j], loads[j] = keys[j - 1], loads[j - 1]
            j -= 1
        keys[j], loads[j] = value, weight
    passed = 0.0
    place = count - 1
    for i in range(count):
        passed += loads[i]
        if passed >= 0.5 * total:
            place = i
            break
    middle: float = keys[place]
    return middle
