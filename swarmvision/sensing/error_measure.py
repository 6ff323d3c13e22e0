"""Who is measured in a picture, and how wrong.

A measurement within the tracker's gate goes on with its neighbour's track. A jump beyond it begins the
track anew, and one beyond a robot's size begins another and leaves the old one behind as a ghost.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.data import BoolArray, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.perception.planar import NEAREST_AXES
from swarmvision.sensing.error_chance import (
    QUANTILES,
    between,
    bin_of,
    entry,
    mixed,
    of_other,
    of_picture,
    share,
)
from swarmvision.sensing.error_memory import GHOST, MEASURED, Minds, Slots
from swarmvision.sensing.error_numbers import TRACKER, Tables, Told
from swarmvision.sensing.error_table import RANGES, TURNS
from swarmvision.sensing.error_tracks import LEFT_BEHIND, ON, TURN_BINS, unforeseen
from swarmvision.sensing.error_views import VIEWS, WHOLE, view_of
from swarmvision.sensing.sight import BEARING, HEADING, RANGE, VISIBLE
from swarmvision.trigonometry import wrapped

NOBODY = -1  # instead of a neighbour's number, in the chance of what all neighbours share
NEAREST = 0.01  # m; nobody is believed nearer
GATE, ACCELERATION, TURN_ACCELERATION = TRACKER.gate, TRACKER.acceleration, TRACKER.turn_acceleration


@compiled
def range_bin(distance: float) -> int:
    """Return the bin of a range (m), as :func:`bin_of`."""
    below = 0
    for n in range(len(RANGES)):
        below += distance >= RANGES[n]
    return below


@compiled
def measure(
    pose: FloatArray,
    who: IntArray,
    sight: FloatArray,
    exposed: BoolArray,
    passed: FloatArray,
    turn_rate: FloatArray,
    limits: tuple[float, float, float],
    tables: Tables,
    old: Slots,
    minds: Minds,
    new: Slots,
    gone: IntArray,
    told: Told,
) -> None:
    """Decide who is measured in a picture, nearest first, and begin every robot's slots with them.

    Args:
        pose: Of the robots, ``(w, r, 3)``.
        who: Of the exposed worlds ``x`` whom each robot may see, nearest first, -1 behind, ``(x, r, m)``.
        sight: Their true range, bearing, heading and visible fraction, ``(x, r, m, 4)``.
        exposed: Which worlds take a picture, ``(w,)``.
        passed: Since the last call (s), ``(w,)``.
        turn_rate: Of the robots (rad/s), ``(w, r)``.
        limits: Reach, beyond which estimates are dropped (m), time between pictures (s), markers' radius (m).
        tables: Of the errors.
        old: Slots of the last call, after :func:`carry_on`.
        minds: Of the observers; they go on.
        new: Out: slots of this call.
        gone: Out: which old slots are not to be remembered, ``(w, r, k)``.
        told: Out.
    """
    reach, period, radius = limits
    again, anew, fresh, variance = tables.again, tables.anew, tables.fresh, tables.variance
    grip, normals, weights = tables.grip, tables.normals, tables.weights
    common, following, picture, keys = minds.common, minds.following, minds.picture, minds.keys
    old_used, old_who, old_state, old_age, _, old_number, old_deviate, old_place, old_pace = old
    used, new_who, state, age, visible, number, deviate, place, pace = new
    told_range, told_bearing, told_heading, covariance = told
    keep0, renew0, last0, once0, both0, bothonce0 = weights[0]
    keep1, renew1, last1, once1, both1, bothonce1 = weights[1]
    keep2, renew2, last2, once2, both2, bothonce2 = weights[2]
    worlds, robots, slots = new_who.shape
    slot_of = np.full(robots, -1)
    soon_aside, soon_round = (
        unforeseen(ACCELERATION, period, period),
        unforeseen(TURN_ACCELERATION, period, period),
    )
    soon, rate = 1.5 * period, 1.0 / period
    x = -1
    for w in range(worlds):
        for i in range(robots):
            used[w, i] = 0
            for n in range(old_used[w, i]):
                gone[w, i, n] = 0
        if not exposed[w]:
            continue
        x += 1
        begun = picture[w] > 0
        for i in range(robots):
            for n in range(old_used[w, i]):
                if old_who[w, i, n] >= 0 and old_state[w, i, n] != GHOST:
                    slot_of[old_who[w, i, n]] = n
            turn = turn_rate[w, i]
            # Tables are of left turns; what lasts is kept as it is, for an error outlives a turn's change.
            t, turned_to = bin_of(TURNS, abs(turn)), 1.0 if turn >= 0.0 else -1.0
            seed = of_picture(keys[w, i], picture[w])
            bits = of_other(seed, NOBODY)
            z0, z1, z2 = (
                normals[entry(bits, 0)],
                turned_to * normals[entry(bits, 1)],
                turned_to * normals[entry(bits, 2)],
            )
            if begun:
                z0 = keep0 * common[w, i, 0] + renew0 * z0
                z1 = keep1 * common[w, i, 1] + renew1 * z1
                z2 = keep2 * common[w, i, 2] + renew2 * z2
            common[w, i, 0], common[w, i, 1], common[w, i, 2] = z0, z1, z2
            bits = mixed(bits)
            shared0 = both0 * z0 + bothonce0 * normals[entry(bits, 0)]
            shared1 = both1 * z1 + bothonce1 * turned_to * normals[entry(bits, 1)]
            shared2 = both2 * z2 + bothonce2 * turned_to * normals[entry(bits, 2)]
            my_x, my_y, yaw = pose[w, i, 0], pose[w, i, 1], pose[w, i, 2]
            count, following_number = 0, following[w, i]
            for c in range(who.shape[2]):
                j = who[x, i, c]
                if j < 0 or count == slots:
                    break
                gap, seen = sight[x, i, c, RANGE], sight[x, i, c, VISIBLE]
                view, side = view_of(gap, sight[x, i, c, BEARING], seen, radius)
                sign = side if view > WHOLE else turned_to
                cell = (range_bin(gap) * TURN_BINS + t) * VIEWS + view
                past = slot_of[j]
                bits, likely = of_other(seed, j), anew[cell]
                if past >= 0 and old_state[w, i, past] == MEASURED:
                    likely = again[cell]
                if share(bits) >= likely:
                    continue
                z0, z1, z2 = (
                    normals[entry(bits, 0)],
                    sign * normals[entry(bits, 1)],
                    sign * normals[entry(bits, 2)],
                )
                if past >= 0:
                    z0 = keep0 * old_deviate[w, i, past, 0] + renew0 * z0
                    z1 = keep1 * old_deviate[w, i, past, 1] + renew1 * z1
                    z2 = keep2 * old_deviate[w, i, past, 2] + renew2 * z2
                bits = mixed(bits)
                first = cell * (3 * QUANTILES)
                z = last0 * z0 + once0 * normals[entry(bits, 0)] + shared0
                n, part = between(z)
                low, high = fresh[first + n], fresh[first + n + 1]
                away = max(gap + gap * gap * (low + part * (high - low)), NEAREST)
                if away > reach:
                    continue
                z = sign * (last1 * z1 + shared1) + once1 * normals[entry(bits, 1)]
                n, part = between(z)
                low, high = fresh[first + QUANTILES + n], fresh[first + QUANTILES + n + 1]
                off = sign * (low + part * (high - low))
                z = sign * (last2 * z2 + shared2) + once2 * normals[entry(bits, 2)]
                n, part = between(z)
                low, high = fresh[first + 2 * QUANTILES + n], fresh[first + 2 * QUANTILES + n + 1]
                heading = sight[x, i, c, HEADING] + sign * (low + part * (high - low))
                told_range[w, i, count], told_heading[w, i, count] = away, wrapped(heading)
                told_bearing[w, i, count] = wrapped(sight[x, i, c, BEARING] + off)
                for n in range(9):
                    covariance[w, i, count, n] = 0.0
                for n in range(3):
                    covariance[w, i, count, 4 * n] = variance[3 * cell + n]
                deviate[w, i, count, 0], deviate[w, i, count, 1], deviate[w, i, count, 2] = z0, z1, z2
                new_who[w, i, count], age[w, i, count], state[w, i, count] = j, 0.0, MEASURED
                visible[w, i, count] = seen
                # Where it is believed to be: errors of bearing are small enough to go straight aside.
                along = away / max(gap, NEAREST)
                dx, dy = along * (pose[w, j, 0] - my_x), along * (pose[w, j, 1] - my_y)
                spot_x, spot_y = my_x + dx - off * dy, my_y + dy + off * dx
                place[w, i, count, 0], place[w, i, count, 1], place[w, i, count, 2] = (
                    spot_x,
                    spot_y,
                    yaw + heading,
                )
                pace[w, i, count, 0] = pace[w, i, count, 1] = pace[w, i, count, 2] = 0.0
                follows = past >= 0
                if follows:
                    dx, dy = spot_x - old_place[w, i, past, 0], spot_y - old_place[w, i, past, 1]
                    turned = wrapped(yaw + heading - old_place[w, i, past, 2])
                    since, square = old_age[w, i, past] + passed[w], dx * dx + dy * dy
                    aside, round_, per_time = soon_aside, soon_round, rate
                    if since > soon:
                        aside = unforeseen(ACCELERATION, period, since)
                        round_, per_time = unforeseen(TURN_ACCELERATION, period, since), 1.0 / since
                    aside, round_ = aside + variance[3 * cell], round_ + variance[3 * cell + 2]
                    if square * round_ + turned * turned * aside <= GATE * aside * round_:
                        vx, vy, spin = (
                            old_pace[w, i, past, 0],
                            old_pace[w, i, past, 1],
                            old_pace[w, i, past, 2],
                        )
                        first_pace = vx == 0.0 and vy == 0.0
                        gain = (1.0 if first_pace else grip[2 * cell]) * per_time
                        turn_gain = (1.0 if first_pace else grip[2 * cell + 1]) * per_time
                        pace[w, i, count, 0], pace[w, i, count, 1] = vx + gain * dx, vy + gain * dy
                        pace[w, i, count, 2] = spin + turn_gain * turned
                    elif square >= NEAREST_AXES * NEAREST_AXES:
                        follows = False
                    gone[w, i, past] = ON if follows else LEFT_BEHIND
                if follows:
                    number[w, i, count] = old_number[w, i, past]
                else:
                    number[w, i, count] = following_number
                    following_number += 1
                count += 1
            used[w, i], following[w, i] = count, following_number
            for n in range(old_used[w, i]):
                if old_who[w, i, n] >= 0:
                    slot_of[old_who[w, i, n]] = -1
