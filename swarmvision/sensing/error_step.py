"""One call of the error model for all robots of all worlds, some of them at a time."""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.data import BoolArray, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.sensing.error_measure import measure
from swarmvision.sensing.error_memory import Minds, Slots, minds_from
from swarmvision.sensing.error_numbers import Tables, Told, tell_nobody
from swarmvision.sensing.error_observers import look_round
from swarmvision.sensing.error_phantoms import imagine
from swarmvision.sensing.error_rows import room_for_observers, rows_of
from swarmvision.sensing.error_tracks import carry_on, link, remember, take

TOGETHER = 256  # candidates: their rows fit the nearest cache
LANES = 16  # observers: what is left over by vectors of eight is taken one by one


@compiled
def believe(
    robots: int,
    slots: int,
    each: int,
    pose: FloatArray,
    turn_rate: FloatArray,
    travel: FloatArray,
    drive: tuple[float, float],
    who: IntArray,
    sight: FloatArray,
    exposed: BoolArray,
    passed: FloatArray,
    limits: tuple[float, float, float],
    chances: tuple[float, float],
    tables: Tables,
    old: Slots,
    minds: Minds,
    new: Slots,
    told: Told,
) -> None:
    """Let the robots ``o`` of worlds ``w`` look, one world's after another's.

    Args:
        robots: Of each world.
        slots: Of each robot, ``k``.
        each: How many candidates each robot has, ``m``.
        pose: Of the robots, ``(o * 3,)``.
        turn_rate: Of the robots (rad/s), ``(o,)``.
        travel: Way of their left and right track by the encoders since the start (m), ``(2, o)``.
        drive: Distance of the tracks (m), and the slip of a turn.
        who: Whom each robot of the exposed worlds may see, nearest first, -1 behind, ``(x * m,)``.
        sight: Their true range, bearing, heading and visible fraction, ``(4, x * m)``.
        exposed: Which worlds take a picture, ``(w,)``.
        passed: Since the last call (s), ``(w,)``.
        limits: Reach, beyond which estimates are dropped (m), time between pictures (s), markers' radius (m).
        chances: How long a neighbour is remembered (s), and the chance of a phantom in a picture.
        tables: Of the errors.
        old: Slots of the last call.
        minds: Of the observers; they go on.
        new: Out: slots of this call.
        told: Out.
    """
    span, likely = chances
    n, room = len(turn_rate), LANES * max(TOGETHER // (LANES * max(each, 1)), 1)
    observers = room_for_observers(room)
    whole, numbers = np.empty((5, each, room), np.int64), np.empty((13, each, room))
    some = rows_of(whole, numbers)
    slot_of, gone = np.full(robots, -1), np.zeros((room, slots), np.int64)
    first, begin = 0, 0
    while first < n:
        w = first // robots
        now, ago, last = exposed[w], passed[w], first
        while last < n and last - first < room and exposed[w] == now and passed[w] == ago:
            for i in range(last, min((w + 1) * robots, first + room)):
                observers.home[i - first], observers.picture[i - first] = w * robots, minds.picture[w]
            last = min((w + 1) * robots, first + room)
            w = min(last // robots, len(exposed) - 1)
        look_round(
            last - first,
            now,
            likely,
            pose[3 * first :],
            turn_rate[first:],
            travel[0][first:],
            travel[1][first:],
            drive,
            tables,
            minds_from(minds, first),
            observers,
        )
        count = last - first
        carry_on(first, count, slots, ago, observers, old)
        gone[:] = 0
        if now:
            link(first, count, slots, each, who, sight, begin * each, old, slot_of, whole, numbers)
            measure(first, count, each, slots, pose, ago, limits, tables, observers, old, some)
            take(
                first,
                count,
                slots,
                each,
                whole,
                numbers,
                tables.variance,
                old,
                minds.following,
                gone,
                new,
                told,
            )
        else:
            new.used[first:last] = 0
        for i in range(first, last):
            count, b = new.used[i], i - first
            if count == slots:
                continue
            count = remember(
                i,
                count,
                slots,
                pose,
                now,
                ago,
                observers.turn[b],
                span,
                tables.aged_variance,
                old,
                gone[b],
                new,
                told,
            )
            if now and observers.odd[b] and count < slots:
                s, seed, side = i * slots + count, observers.seed[b], observers.side[b]
                odd = imagine(i, s, seed, side, pose, limits[0], tables, minds.following, new, told)
                count += 1 if odd else 0
            new.used[i] = count
            tell_nobody(i * slots + count, (i + 1) * slots, told)
        begin += last - first if now else 0
        first = last
    for w in range(len(exposed)):
        minds.picture[w] += 1 if exposed[w] else 0
