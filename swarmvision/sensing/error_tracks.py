"""What a track of the error model does of itself, in plain numbers instead of covariances.

It keeps its pace and turns with its observer's encoders, so who is hidden is believed where it would be if
it went on as before, and an observer that is pushed believes that everybody jumped.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import leaf
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray
from swarmvision.perception.track import OWN_PLACE
from swarmvision.sensing.error_chance import bin_of
from swarmvision.sensing.error_memory import (
    AGE,
    GHOST,
    LASTING_HEADING,
    MEASURED,
    NUMBER,
    REMEMBERED,
    SHARE,
    SPIN,
    STATE,
    VX,
    VY,
    WHO,
    YAW,
    Slots,
    X,
    Y,
)
from swarmvision.sensing.error_numbers import Told, spread, tell
from swarmvision.sensing.error_rows import (
    AS_TOLD,
    BEARING,
    CELL,
    FOLLOWS,
    FOUND,
    HEADING,
    PAST,
    RANGE,
    WHOM,
    Observers,
)
from swarmvision.sensing.error_table import AGES, TURNS
from swarmvision.trigonometry import direction, wrapped

CLOCK_SLACK = 1e-9  # s; sums of control periods are not exact
ON, LEFT_BEHIND = 1, 2  # whether a slot's neighbour goes on in another, or leaves a ghost in it
TURN_BINS = len(TURNS) + 1


@leaf
def carry_on(
    first: int,
    count: int,
    slots: int,
    passed: float,
    observers: Observers,
    held: Slots,
) -> None:
    """Move all that some robots believe on to now, by its own pace and by the observers' encoders.

    Args:
        first: The first robot.
        count: How many.
        slots: How many each has.
        passed: Since the last call (s).
        observers: These robots.
        held: Slots of the last call; places and paces go on.
    """
    for b in range(count):
        i = first + b
        x, y, from_x, from_y = observers.x[b], observers.y[b], observers.from_x[b], observers.from_y[b]
        cos, sin, slip = observers.cosine[b], observers.sine[b], observers.slip[b]
        for s in range(i * slots, i * slots + held.used[i]):
            row = held.numbers[s]
            vx, vy = row[VX], row[VY]
            ahead, left = row[X] + passed * vx - from_x, row[Y] + passed * vy - from_y
            row[X], row[Y] = x + cos * ahead - sin * left, y + sin * ahead + cos * left
            row[YAW] += passed * row[SPIN] + slip
            row[VX], row[VY] = cos * vx - sin * vy, sin * vx + cos * vy


@leaf
def unforeseen(spread: float, period: float) -> float:
    """Return the variance that a random acceleration gives to a place in a period (s), constant in it."""
    return (spread * period * period) ** 2 / 4.0


@leaf
def growth(periods: float) -> float:
    """Return how many times that it is after so many periods, each with an acceleration of its own."""
    return periods * (4.0 * periods * periods - 1.0) * (1.0 / 3.0)


@leaf
def link(
    first: int,
    count: int,
    slots: int,
    each: int,
    who: IntArray,
    sight: FloatArray,
    begin: int,
    held: Slots,
    slot_of: IntArray,
    whole: IntArray,
    some: FloatArray,
) -> None:
    """Fill in the candidates of some robots, and which slot holds each, -1 where none does.

    Args:
        first: The first robot.
        count: How many, ``b``.
        slots: How many each has.
        each: How many candidates each has, ``m``.
        who: The candidates of all that take a picture, by number in their world, -1 for nobody, ``(x * m,)``.
        sight: Their true range, bearing, heading and visible fraction, ``(4, x * m)``.
        begin: Where the first robot's begin.
        held: Slots of the last call.
        slot_of: All -1, and so again at the end, ``(r,)``.
        whole: Out: rows of :class:`Candidates`, those of whole numbers, ``(5, m, b)``.
        some: Out: and the others, ``(13, m, b)``.
    """
    ranges, bearings, headings, shares = (
        sight[0][begin:],
        sight[1][begin:],
        sight[2][begin:],
        sight[3][begin:],
    )
    whom = who[begin:]
    for b in range(count):
        at, used = (first + b) * slots, held.used[first + b]
        for n in range(used):
            mark = held.marks[at + n]
            if mark[WHO] >= 0 and mark[STATE] != GHOST:
                slot_of[mark[WHO]] = n
        for c in range(each):
            n = b * each + c
            j = whom[n]
            whole[WHOM, c, b], whole[PAST, c, b] = j, slot_of[j] if j >= 0 else -1
            some[RANGE, c, b], some[BEARING, c, b] = ranges[n], bearings[n]
            some[HEADING, c, b], some[AS_TOLD, c, b] = headings[n], shares[n]
        for n in range(used):
            j = held.marks[at + n, WHO]
            if j >= 0:
                slot_of[j] = -1


@leaf
def take(
    first: int,
    robots: int,
    slots: int,
    each: int,
    whole: IntArray,
    some: FloatArray,
    variance: FloatArray,
    old: Slots,
    following: IntArray,
    gone: IntArray,
    new: Slots,
    told: Told,
) -> None:
    """Begin the slots of some robots with those who are measured, nearest first.

    Args:
        first: The first robot.
        robots: How many, ``b``.
        slots: How many each has, ``k``.
        each: How many candidates each has, ``m``.
        whole: The rows of :class:`Candidates` as measured, those of whole numbers, ``(5, m, b)``.
        some: And the others, ``(13, m, b)``.
        variance: Of measurements, as in :class:`Tables`.
        old: Slots of the last call.
        following: Numbers of the observers' next tracks, ``(o,)``; they go on.
        gone: Out: which old slots are not to be remembered; 0 before, ``(b, k)``.
        new: Out: slots of this call.
        told: Out.
    """
    for b in range(robots):
        i, count = first + b, 0
        number = following[i]
        for c in range(each):
            if count == slots:
                break
            if whole[FOUND, c, b] == 0:
                continue
            s, past, follows = i * slots + count, whole[PAST, c, b], whole[FOLLOWS, c, b]
            if past >= 0:
                gone[b, past] = ON if follows else LEFT_BEHIND
            marks, numbers = new.marks[s], new.numbers[s]
            marks[WHO], marks[STATE] = whole[WHOM, c, b], MEASURED
            marks[NUMBER] = old.marks[i * slots + past, NUMBER] if follows else number
            number += 0 if follows else 1
            numbers[AGE] = 0.0
            for n in range(SHARE, LASTING_HEADING + 1):
                numbers[n] = some[AS_TOLD - 1 + n, c, b]
            tell(s, some[RANGE, c, b], some[BEARING, c, b], some[HEADING, c, b], marks, numbers, told)
            spread(told.covariance[s], variance, 3 * whole[CELL, c, b])
            count += 1
        following[i], new.used[i] = number, count


@leaf
def remember(
    i: int,
    count: int,
    slots: int,
    pose: FloatArray,
    exposed: bool,
    passed: float,
    turn: int,
    span: float,
    variance: FloatArray,
    old: Slots,
    gone: IntArray,
    new: Slots,
    told: Told,
) -> int:
    """Keep, behind those who are measured, who is not and was not too long ago; return how many all are.

    Args:
        i: The robot.
        count: How many it measured.
        slots: How many slots it has.
        pose: Of all robots, ``(o * 3,)``.
        exposed: Whether it takes a picture.
        passed: Since the last call (s).
        turn: Bin of its turn rate.
        span: How long is remembered (s).
        variance: Of what is remembered, as in :class:`Tables`.
        old: Slots of the last call, after :func:`carry_on`.
        gone: From :func:`take`.
        new: Slots of this call; they go on.
        told: Out.
    """
    for n in range(old.used[i]):
        if count == slots:
            break
        if gone[n] == ON:
            continue
        s, was, row = i * slots + count, old.marks[i * slots + n], old.numbers[i * slots + n]
        older = row[AGE] + passed
        if older > span + CLOCK_SLACK:
            continue
        dx, dy, yaw = row[X] - pose[3 * i], row[Y] - pose[3 * i + 1], pose[3 * i + 2]
        gap = np.sqrt(dx * dx + dy * dy)
        if gap <= OWN_PLACE:
            continue
        marks, numbers = new.marks[s], new.numbers[s]
        marks[WHO], marks[STATE], marks[NUMBER] = was[WHO], was[STATE], was[NUMBER]
        if gone[n] == LEFT_BEHIND:
            marks[STATE] = GHOST
        elif exposed and was[STATE] == MEASURED:
            marks[STATE] = REMEMBERED
        numbers[AGE] = older
        for c in range(SHARE, LASTING_HEADING + 1):
            numbers[c] = row[c]
        tell(s, gap, wrapped(direction(dy, dx) - yaw), wrapped(row[YAW] - yaw), marks, numbers, told)
        spread(told.covariance[s], variance, 3 * (bin_of(AGES, older) * TURN_BINS + turn))
        count += 1
    return count
