"""What a track of the error model does of itself, in plain numbers instead of covariances.

It keeps its pace and turns with its observer's encoders, so who is hidden is believed where it would be if
it went on as before, and an observer that is pushed believes that everybody jumped.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.data import BoolArray, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.perception.track import OWN_PLACE
from swarmvision.sensing.error_chance import bin_of
from swarmvision.sensing.error_memory import GHOST, MEASURED, REMEMBERED, Minds, Slots
from swarmvision.sensing.error_numbers import Tables, Told, spread
from swarmvision.sensing.error_table import AGES, TURNS
from swarmvision.trigonometry import direction, sine_cosine, wrapped

CLOCK_SLACK = 1e-9  # s; sums of control periods are not exact
ON, LEFT_BEHIND = 1, 2  # whether a slot's neighbour goes on in another, or leaves a ghost in it
TURN_BINS = len(TURNS) + 1


@compiled
def carry_on(pose: FloatArray, way: FloatArray, passed: FloatArray, slots: Slots, minds: Minds) -> None:
    """Move all that is believed on to now, by its own pace and by the observers' encoders.

    Args:
        pose: Of the robots, ``(w, r, 3)``.
        way: Forward way (m) and turn (rad) by their encoders since the start, ``(w, r, 2)``.
        passed: Since the last call (s), ``(w,)``.
        slots: Of the last call; places and paces go on.
        minds: Of the observers; pose and way go on.
    """
    used, place, pace = slots.used, slots.place, slots.pace
    last, last_way = minds.pose, minds.way
    for w in range(pose.shape[0]):
        for i in range(pose.shape[1]):
            forward, turn = way[w, i, 0] - last_way[w, i, 0], way[w, i, 1] - last_way[w, i, 1]
            course = last[w, i, 2] + turn / 2.0
            sin, cos = sine_cosine(course)
            from_x, from_y = last[w, i, 0] + forward * cos, last[w, i, 1] + forward * sin
            slip = wrapped(pose[w, i, 2] - last[w, i, 2] - turn)
            sin, cos = sine_cosine(slip)
            for n in range(used[w, i]):
                x = place[w, i, n, 0] + passed[w] * pace[w, i, n, 0] - from_x
                y = place[w, i, n, 1] + passed[w] * pace[w, i, n, 1] - from_y
                place[w, i, n, 0] = pose[w, i, 0] + cos * x - sin * y
                place[w, i, n, 1] = pose[w, i, 1] + sin * x + cos * y
                place[w, i, n, 2] += passed[w] * pace[w, i, n, 2] + slip
                x, y = pace[w, i, n, 0], pace[w, i, n, 1]
                pace[w, i, n, 0], pace[w, i, n, 1] = cos * x - sin * y, sin * x + cos * y
            for c in range(3):
                last[w, i, c] = pose[w, i, c]
            last_way[w, i, 0], last_way[w, i, 1] = way[w, i, 0], way[w, i, 1]


@compiled
def unforeseen(spread: float, period: float, age: float) -> float:
    """Return the variance that a random acceleration, constant in each period, gives to a place in a time."""
    periods = max(age / period, 1.0)
    return (spread * period * period) ** 2 * periods * (4.0 * periods * periods - 1.0) / 12.0


@compiled
def remember(
    pose: FloatArray,
    exposed: BoolArray,
    passed: FloatArray,
    turn_rate: FloatArray,
    span: float,
    tables: Tables,
    old: Slots,
    gone: IntArray,
    new: Slots,
    told: Told,
) -> None:
    """Keep, behind those who are measured, who is not and was not too long ago.

    Args:
        pose: Of the robots, ``(w, r, 3)``.
        exposed: Which worlds take a picture, ``(w,)``.
        passed: Since the last call (s), ``(w,)``.
        turn_rate: Of the robots (rad/s), ``(w, r)``.
        span: How long is remembered (s).
        tables: Of the errors.
        old: Slots of the last call, after :func:`carry_on`.
        gone: From :func:`measure`.
        new: Slots of this call; they go on.
        told: Out.
    """
    variance = tables.aged_variance
    old_used, old_who, old_state, old_age, old_visible, old_number, old_deviate, old_place, old_pace = old
    used, who, state, age, visible, number, deviate, place, pace = new
    told_range, told_bearing, told_heading, covariance = told
    worlds, robots, slots = who.shape
    for w in range(worlds):
        for i in range(robots):
            count = used[w, i]
            for n in range(old_used[w, i]):
                older = old_age[w, i, n] + passed[w]
                if gone[w, i, n] == ON or older > span + CLOCK_SLACK or count == slots:
                    continue
                dx, dy = old_place[w, i, n, 0] - pose[w, i, 0], old_place[w, i, n, 1] - pose[w, i, 1]
                gap = np.sqrt(dx * dx + dy * dy)
                if gap <= OWN_PLACE:
                    continue
                now = old_state[w, i, n]
                if gone[w, i, n] == LEFT_BEHIND:
                    now = GHOST
                elif exposed[w] and now == MEASURED:
                    now = REMEMBERED
                who[w, i, count], age[w, i, count], state[w, i, count] = old_who[w, i, n], older, now
                visible[w, i, count], number[w, i, count] = old_visible[w, i, n], old_number[w, i, n]
                for c in range(3):
                    deviate[w, i, count, c] = old_deviate[w, i, n, c]
                    place[w, i, count, c], pace[w, i, count, c] = old_place[w, i, n, c], old_pace[w, i, n, c]
                told_range[w, i, count] = gap
                told_bearing[w, i, count] = wrapped(direction(dy, dx) - pose[w, i, 2])
                told_heading[w, i, count] = wrapped(old_place[w, i, n, 2] - pose[w, i, 2])
                cell = bin_of(AGES, older) * TURN_BINS + bin_of(TURNS, abs(turn_rate[w, i]))
                spread(covariance, w, i, count, variance, 3 * cell)
                count += 1
            used[w, i] = count
