"""What happens to the error model's neighbours in a picture: measured, remembered, imagined.

Each step is one pass over all robots of all worlds and fills their slots further; the order of the
worlds and robots decides nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from swarmvision import recycling
from swarmvision.compiled import compiled
from swarmvision.data import BoolArray, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.sensing.error_chance import (
    QUANTILES,
    bin_of,
    mixed,
    normal,
    of_other,
    of_picture,
    picked,
    share,
)
from swarmvision.sensing.error_memory import GHOST, MEASURED, PHANTOM, REMEMBERED, Minds, Slots
from swarmvision.sensing.error_table import AGES, RANGES, TURNS, VISIBLES, ErrorTable
from swarmvision.sensing.sight import BEARING, HEADING, RANGE, VISIBLE
from swarmvision.trigonometry import wrapped

NOBODY = -1  # instead of a neighbour's number, in the chance of what all neighbours share
GHOSTLY = 1 << 32  # beside neighbours' numbers, in the chance of ghosts
NEAREST = 0.01  # m; nobody is believed nearer
CLOCK_SLACK = 1e-9  # s; sums of control periods are not exact
ON, LEFT_BEHIND = 1, 2  # whether a slot's neighbour goes on in another, or leaves a ghost in it
TURN_BINS, VISIBLE_BINS = len(TURNS) + 1, len(VISIBLES) + 1
PHANTOM_VISIBLE = 0.5


class Tables(NamedTuple):
    """The tables of :class:`ErrorTable` in a row each, with what follows from them."""

    again: FloatArray
    anew: FloatArray
    fresh: FloatArray
    fresh_variance: FloatArray
    aged: FloatArray
    aged_variance: FloatArray
    split: FloatArray
    ghost: FloatArray
    place: FloatArray
    memory: FloatArray
    renewal: FloatArray
    """Weight of a new deviate beside one that is kept by ``memory``, ``(3,)``."""
    own: FloatArray
    """Weight of a neighbour's own deviates, ``(3,)``."""
    common: FloatArray
    """Weight of those that an observer's neighbours share, ``(3,)``."""
    normals: FloatArray

    @classmethod
    def of(cls, table: ErrorTable, normals: FloatArray) -> Tables:
        """Return them as the kernels take them."""
        return cls(
            again=table.again.ravel(),
            anew=table.anew.ravel(),
            fresh=table.fresh.ravel(),
            fresh_variance=table.fresh_std.ravel() ** 2,
            aged=table.aged.ravel(),
            aged_variance=table.aged_std.ravel() ** 2,
            split=table.split,
            ghost=table.ghost.ravel(),
            place=table.phantom_place.ravel(),
            memory=table.memory,
            renewal=np.sqrt(1.0 - table.memory**2),
            own=np.sqrt(1.0 - table.common),
            common=np.sqrt(table.common),
            normals=normals,
        )


class Told(NamedTuple):
    """As :class:`swarmvision.data.Estimates`, ``(w, r, k)``."""

    range: FloatArray
    bearing: FloatArray
    heading: FloatArray
    covariance: FloatArray
    """Shape ``(w, r, k, 9)``."""

    @classmethod
    def of(cls, shape: tuple[int, ...]) -> Told:
        """Return room for what is told."""
        new = recycling.empty
        return cls(new(shape), new(shape), new(shape), new((*shape, 9)))


@compiled
def measure(
    who: IntArray,
    sight: FloatArray,
    exposed: BoolArray,
    turn_rate: FloatArray,
    reach: float,
    tables: Tables,
    old: Slots,
    minds: Minds,
    new: Slots,
    gone: IntArray,
    told: Told,
) -> None:
    """Decide who is measured in a picture, nearest first, and begin every robot's slots with them.

    Args:
        who: Of the exposed worlds ``x`` whom each robot may see, nearest first, -1 behind, ``(x, r, m)``.
        sight: Their true range, bearing, heading and visible fraction, ``(x, r, m, 4)``.
        exposed: Which worlds take a picture, ``(w,)``.
        turn_rate: Of the robots (rad/s), ``(w, r)``.
        reach: Beyond it estimates are dropped (m).
        tables: Of the errors.
        old: Slots of the last call.
        minds: Of the observers; they go on.
        new: Out: slots of this call.
        gone: Out: which old slots are not to be remembered, ``(w, r, k)``.
        told: Out.
    """
    again, anew, fresh, variance = tables.again, tables.anew, tables.fresh, tables.fresh_variance
    split, normals = tables.split, tables.normals
    keep0, keep1, keep2 = tables.memory
    renew0, renew1, renew2 = tables.renewal
    own0, own1, own2 = tables.own
    weight0, weight1, weight2 = tables.common
    common, following, picture, keys = minds
    old_used, old_who, old_state, _, _, old_number, old_deviate = old
    used, new_who, state, age, visible, number, deviate = new
    told_range, told_bearing, told_heading, covariance = told
    worlds, robots, slots = new_who.shape
    slot_of = np.full(robots, -1)
    x = -1
    for w in range(worlds):
        for i in range(robots):
            used[w, i] = 0
            for n in range(old_used[w, i]):
                gone[w, i, n] = 0
        if not exposed[w]:
            continue
        x += 1
        first_picture = picture[w] == 0
        for i in range(robots):
            for n in range(old_used[w, i]):
                if old_who[w, i, n] >= 0 and old_state[w, i, n] != GHOST:
                    slot_of[old_who[w, i, n]] = n
            seed = of_picture(keys[w, i], picture[w])
            bits = of_other(seed, NOBODY)
            z0, z1, z2 = normal(bits, 0, normals), normal(bits, 1, normals), normal(bits, 2, normals)
            if not first_picture:
                z0 = keep0 * common[w, i, 0] + renew0 * z0
                z1 = keep1 * common[w, i, 1] + renew1 * z1
                z2 = keep2 * common[w, i, 2] + renew2 * z2
            common[w, i, 0], common[w, i, 1], common[w, i, 2] = z0, z1, z2
            shared0, shared1, shared2 = weight0 * z0, weight1 * z1, weight2 * z2
            turn = turn_rate[w, i]
            t, sign = bin_of(TURNS, abs(turn)), 1.0 if turn >= 0.0 else -1.0
            count, following_number = 0, following[w, i]
            for c in range(who.shape[2]):
                j = who[x, i, c]
                if j < 0 or count == slots:
                    break
                gap, seen = sight[x, i, c, RANGE], sight[x, i, c, VISIBLE]
                cell = (bin_of(RANGES, gap) * TURN_BINS + t) * VISIBLE_BINS + bin_of(VISIBLES, seen)
                past = slot_of[j]
                bits, likely = of_other(seed, j), anew[cell]
                if past >= 0 and old_state[w, i, past] == MEASURED:
                    likely = again[cell]
                luck = share(bits)
                if luck >= likely:
                    continue
                z0, z1, z2 = normal(bits, 0, normals), normal(bits, 1, normals), normal(bits, 2, normals)
                if past >= 0:
                    z0 = keep0 * old_deviate[w, i, past, 0] + renew0 * z0
                    z1 = keep1 * old_deviate[w, i, past, 1] + renew1 * z1
                    z2 = keep2 * old_deviate[w, i, past, 2] + renew2 * z2
                first = cell * (3 * QUANTILES)
                away = gap + gap * gap * picked(fresh, first, own0 * z0 + shared0)
                if away > reach:
                    continue
                off = sign * picked(fresh, first + QUANTILES, own1 * z1 + shared1)
                turned = sign * picked(fresh, first + 2 * QUANTILES, own2 * z2 + shared2)
                told_range[w, i, count] = max(away, NEAREST)
                told_bearing[w, i, count] = wrapped(sight[x, i, c, BEARING] + off)
                told_heading[w, i, count] = wrapped(sight[x, i, c, HEADING] + turned)
                deviate[w, i, count, 0], deviate[w, i, count, 1], deviate[w, i, count, 2] = z0, z1, z2
                _spread(covariance, w, i, count, variance, 3 * cell)
                new_who[w, i, count], age[w, i, count], state[w, i, count] = j, 0.0, MEASURED
                visible[w, i, count] = seen
                if past >= 0:
                    # Of chances that are hit, an even share is hit as well by a smaller chance.
                    gone[w, i, past] = LEFT_BEHIND if luck < likely * split[t] else ON
                if past >= 0 and gone[w, i, past] == ON:
                    number[w, i, count] = old_number[w, i, past]
                else:
                    number[w, i, count] = following_number
                    following_number += 1
                count += 1
            used[w, i], following[w, i] = count, following_number
            for n in range(old_used[w, i]):
                if old_who[w, i, n] >= 0:
                    slot_of[old_who[w, i, n]] = -1


@compiled
def _spread(covariance: FloatArray, w: int, i: int, n: int, variance: FloatArray, first: int) -> None:
    """Fill in a diagonal covariance."""
    for c in range(9):
        covariance[w, i, n, c] = 0.0
    covariance[w, i, n, 0] = variance[first]
    covariance[w, i, n, 4] = variance[first + 1]
    covariance[w, i, n, 8] = variance[first + 2]


@compiled
def remember(
    pose: FloatArray,
    exposed: BoolArray,
    passed: FloatArray,
    turn_rate: FloatArray,
    span: float,
    stay: float,
    tables: Tables,
    old: Slots,
    minds: Minds,
    gone: IntArray,
    new: Slots,
    told: Told,
) -> None:
    """Carry on, behind those who are measured, who is not and was not too long ago.

    Args:
        pose: Of the robots, ``(w, r, 3)``.
        exposed: Which worlds take a picture, ``(w,)``.
        passed: Since the last call (s), ``(w,)``.
        turn_rate: Of the robots (rad/s), ``(w, r)``.
        span: How long is remembered (s).
        stay: Chance of a ghost to last for another picture.
        tables: Of the errors.
        old: Slots of the last call.
        minds: Of the observers.
        gone: From :func:`measure`.
        new: Slots of this call; they go on.
        told: Out.
    """
    aged, ghost, variance = tables.aged, tables.ghost, tables.aged_variance
    own0, own1, own2 = tables.own
    weight0, weight1, weight2 = tables.common
    common, _, picture, keys = minds
    old_used, old_who, old_state, old_age, old_visible, old_number, old_deviate = old
    used, who, state, age, visible, number, deviate = new
    told_range, told_bearing, told_heading, covariance = told
    worlds, robots, slots = who.shape
    for w in range(worlds):
        for i in range(robots):
            count = used[w, i]
            for n in range(old_used[w, i]):
                older = old_age[w, i, n] + passed[w]
                if gone[w, i, n] == ON or older > span + CLOCK_SLACK or count == slots:
                    continue
                now = old_state[w, i, n]
                if exposed[w] and now == GHOST:
                    luck = share(of_other(of_picture(keys[w, i], picture[w]), GHOSTLY + old_number[w, i, n]))
                    if luck >= stay:
                        continue
                if gone[w, i, n] == LEFT_BEHIND:
                    now = GHOST
                elif exposed[w] and now == MEASURED:
                    now = REMEMBERED
                j = old_who[w, i, n]
                who[w, i, count], age[w, i, count], state[w, i, count] = j, older, now
                visible[w, i, count], number[w, i, count] = old_visible[w, i, n], old_number[w, i, n]
                z0, z1, z2 = old_deviate[w, i, n, 0], old_deviate[w, i, n, 1], old_deviate[w, i, n, 2]
                deviate[w, i, count, 0], deviate[w, i, count, 1], deviate[w, i, count, 2] = z0, z1, z2
                x, y, yaw = z0, z1, z2
                if j != PHANTOM:
                    x, y, yaw = pose[w, j, 0], pose[w, j, 1], pose[w, j, 2]
                dx, dy = x - pose[w, i, 0], y - pose[w, i, 1]
                gap = max(np.sqrt(dx * dx + dy * dy), NEAREST)
                bearing, heading = np.arctan2(dy, dx) - pose[w, i, 2], yaw - pose[w, i, 2]
                a, t = bin_of(AGES, older), bin_of(TURNS, abs(turn_rate[w, i]))
                sign = 1.0 if turn_rate[w, i] >= 0.0 else -1.0
                if j != PHANTOM:
                    quantiles, first = aged, (a * TURN_BINS + t) * 3 * QUANTILES
                    if now == GHOST:
                        quantiles, first = ghost, a * 3 * QUANTILES
                    z0 = own0 * z0 + weight0 * common[w, i, 0]
                    z1 = own1 * z1 + weight1 * common[w, i, 1]
                    z2 = own2 * z2 + weight2 * common[w, i, 2]
                    bearing += sign * picked(quantiles, first + QUANTILES, z1) / gap
                    heading += sign * picked(quantiles, first + 2 * QUANTILES, z2)
                    gap = max(gap + picked(quantiles, first, z0), NEAREST)
                told_range[w, i, count], told_bearing[w, i, count] = gap, wrapped(bearing)
                told_heading[w, i, count] = wrapped(heading)
                _spread(covariance, w, i, count, variance, (a * TURN_BINS + t) * 3)
                count += 1
            used[w, i] = count


@compiled
def imagine(
    pose: FloatArray,
    exposed: BoolArray,
    turn_rate: FloatArray,
    reach: float,
    likely: float,
    tables: Tables,
    minds: Minds,
    new: Slots,
    told: Told,
) -> None:
    """Let robots see, rarely, somebody who is not there, and close the picture.

    Args:
        pose: Of the robots, ``(w, r, 3)``.
        exposed: Which worlds take a picture, ``(w,)``.
        turn_rate: Of the robots (rad/s), ``(w, r)``.
        reach: Beyond it estimates are dropped (m).
        likely: Chance of a phantom in a picture.
        tables: Of the errors.
        minds: Of the observers; they go on.
        new: Slots of this call; they go on.
        told: Out.
    """
    place, variance, normals = tables.place, tables.aged_variance, tables.normals
    _, following, picture, keys = minds
    used, who, state, age, visible, number, deviate = new
    told_range, told_bearing, told_heading, covariance = told
    for w in range(len(exposed)):
        if not exposed[w]:
            continue
        for i in range(pose.shape[1]):
            bits = of_other(of_picture(keys[w, i], picture[w]), PHANTOM)
            n = used[w, i]
            if share(bits) >= likely or n == who.shape[2]:
                continue
            sign = 1.0 if turn_rate[w, i] >= 0.0 else -1.0
            gap = picked(place, 0, normal(bits, 0, normals))
            bearing = sign * picked(place, QUANTILES, normal(bits, 1, normals))
            heading = sign * wrapped(2.0 * np.pi * share(mixed(bits)))
            if gap > reach:
                continue
            yaw = pose[w, i, 2]
            told_range[w, i, n], told_bearing[w, i, n], told_heading[w, i, n] = gap, bearing, heading
            deviate[w, i, n, 0] = pose[w, i, 0] + gap * np.cos(yaw + bearing)
            deviate[w, i, n, 1] = pose[w, i, 1] + gap * np.sin(yaw + bearing)
            deviate[w, i, n, 2] = yaw + heading
            who[w, i, n], age[w, i, n], state[w, i, n] = PHANTOM, 0.0, REMEMBERED
            visible[w, i, n], number[w, i, n] = PHANTOM_VISIBLE, following[w, i]
            _spread(covariance, w, i, n, variance, 0)
            following[w, i] += 1
            used[w, i] = n + 1
        picture[w] += 1


@compiled
def tell(
    slots: Slots, told: Told, seen: BoolArray, age: FloatArray, track: IntArray, visible: FloatArray
) -> None:
    """Write down whom the slots hold, ``(w, r, k)`` each, and nan into those that hold nobody."""
    used, _, _, old_age, old_visible, number, _ = slots
    told_range, told_bearing, told_heading, covariance = told
    worlds, robots, most = seen.shape
    for w in range(worlds):
        for i in range(robots):
            count = used[w, i]
            for n in range(count):
                seen[w, i, n], age[w, i, n] = True, old_age[w, i, n]
                track[w, i, n], visible[w, i, n] = number[w, i, n], old_visible[w, i, n]
            for n in range(count, most):
                seen[w, i, n], age[w, i, n], track[w, i, n], visible[w, i, n] = False, np.nan, -1, 0.0
                told_range[w, i, n] = told_bearing[w, i, n] = told_heading[w, i, n] = np.nan
                for c in range(9):
                    covariance[w, i, n, c] = np.nan
