"""Who of the candidates is measured in a picture, how wrong, and whether its track goes on.

A measurement within the tracker's gate goes on with its neighbour's track. A jump beyond it begins the
track anew, and one beyond a robot's size begins another and leaves the old one behind as a ghost.
"""

from __future__ import annotations

from swarmvision.compiled import apart, leaf
from swarmvision.geometry import FloatArray
from swarmvision.perception.planar import NEAREST_AXES
from swarmvision.sensing.error_chance import QUANTILES, entry, mixed, of_other, picked, share
from swarmvision.sensing.error_memory import (
    AGE,
    LASTING_BEARING,
    LASTING_HEADING,
    LASTING_RANGE,
    MEASURED,
    SPIN,
    STATE,
    VX,
    VY,
    YAW,
    Slots,
    X,
    Y,
)
from swarmvision.sensing.error_numbers import TRACKER, Tables
from swarmvision.sensing.error_rows import Candidates, Observers
from swarmvision.sensing.error_table import RANGES
from swarmvision.sensing.error_tracks import TURN_BINS, growth, unforeseen
from swarmvision.sensing.error_views import VIEWS, WHOLE, view_of
from swarmvision.trigonometry import wrapped

NEAREST = 0.01  # m; nobody is believed nearer
GATE, ACCELERATION, TURN_ACCELERATION = TRACKER.gate, TRACKER.acceleration, TRACKER.turn_acceleration
CELLS = (len(RANGES) + 1) * TURN_BINS * VIEWS


@leaf
def range_bin(distance: float) -> int:
    """Return the bin of a range (m), as :func:`swarmvision.sensing.error_chance.bin_of`."""
    below = 0
    for n in range(len(RANGES)):
        below += 1 if distance >= RANGES[n] else 0
    return below


@apart
def measure(
    first: int,
    count: int,
    each: int,
    slots: int,
    pose: FloatArray,
    passed: float,
    limits: tuple[float, float, float],
    tables: Tables,
    observers: Observers,
    old: Slots,
    some: Candidates,
) -> None:
    """Fill in who of the candidates of some observers is measured, and how.

    Args:
        first: The first observer's number among all robots.
        count: Of the observers.
        each: How many candidates each has, ``m``.
        slots: How many slots, ``k``.
        pose: Of all robots, ``(o * 3,)``.
        passed: Since the last call (s).
        limits: Reach, beyond which estimates are dropped (m), time between pictures (s), markers' radius (m).
        tables: Of the errors.
        observers: Of these robots.
        old: Slots of the last call, after :func:`swarmvision.sensing.error_tracks.carry_on`.
        some: In, from :func:`swarmvision.sensing.error_tracks.link`; out.
    """
    reach, period, radius = limits
    chance, fresh, variance, grip = tables.chance, tables.fresh, tables.variance, tables.grip
    normals, weights, marks, held = tables.normals, tables.weights, old.marks, old.numbers
    keep0, renew0, last0, once0 = weights[0], weights[1], weights[2], weights[3]
    keep1, renew1, last1, once1 = weights[6], weights[7], weights[8], weights[9]
    keep2, renew2, last2, once2 = weights[12], weights[13], weights[14], weights[15]
    soon_aside, soon_round = unforeseen(ACCELERATION, period), unforeseen(TURN_ACCELERATION, period)
    soon, rate = 1.5 * period, 1.0 / period
    for c in range(each):
        for b in range(count):
            i, j, past = first + b, some.who[c, b], some.past[c, b]
            gap, bearing, visible = some.range[c, b], some.bearing[c, b], some.share[c, b]
            has, track = past >= 0, i * slots + max(past, 0)
            view, side = view_of(gap, bearing, visible, radius)
            sign = side if view > WHOLE else observers.side[b]
            cell = (range_bin(gap) * TURN_BINS + observers.turn[b]) * VIEWS + view
            bits, again = of_other(observers.seed[b], j), has & (marks[track, STATE] == MEASURED)
            found = (j >= 0) & (share(bits) < chance[cell + (CELLS if again else 0)])

            z0, z1, z2 = (
                normals[entry(bits, 0)],
                sign * normals[entry(bits, 1)],
                sign * normals[entry(bits, 2)],
            )
            z0 = keep0 * held[track, LASTING_RANGE] + renew0 * z0 if has else z0
            z1 = keep1 * held[track, LASTING_BEARING] + renew1 * z1 if has else z1
            z2 = keep2 * held[track, LASTING_HEADING] + renew2 * z2 if has else z2
            some.lasting_range[c, b], some.lasting_bearing[c, b], some.lasting_heading[c, b] = z0, z1, z2

            bits, row = mixed(bits), cell * (3 * QUANTILES)
            z = last0 * z0 + once0 * normals[entry(bits, 0)] + observers.shared_range[b]
            away = max(gap + gap * gap * picked(fresh, row, z), NEAREST)
            z = sign * (last1 * z1 + observers.shared_bearing[b]) + once1 * normals[entry(bits, 1)]
            off = sign * picked(fresh, row + QUANTILES, z)
            z = sign * (last2 * z2 + observers.shared_heading[b]) + once2 * normals[entry(bits, 2)]
            facing = some.heading[c, b] + sign * picked(fresh, row + 2 * QUANTILES, z)
            some.found[c, b], some.cell[c, b] = 1 if found & (away <= reach) else 0, cell
            some.range[c, b], some.bearing[c, b], some.heading[c, b] = (
                away,
                wrapped(bearing + off),
                wrapped(facing),
            )

            # Where it is believed to be: errors of bearing are small enough to go straight aside.
            along, my_x, my_y, there = away / max(gap, NEAREST), observers.x[b], observers.y[b], 3 * max(j, 0)
            there += 3 * observers.home[b]
            dx, dy = along * (pose[there] - my_x), along * (pose[there + 1] - my_y)
            x, y, yaw = my_x + dx - off * dy, my_y + dy + off * dx, observers.yaw[b] + facing
            some.x[c, b], some.y[c, b], some.yaw[c, b] = x, y, yaw
            dx, dy = x - held[track, X], y - held[track, Y]
            turned = wrapped(yaw - held[track, YAW])
            square, since = dx * dx + dy * dy, held[track, AGE] + passed
            periods = since * rate if since > soon else 1.0
            more = growth(periods)
            aside, around = soon_aside * more + variance[3 * cell], soon_round * more + variance[3 * cell + 2]
            inside = has & (square * around + turned * turned * aside <= GATE * aside * around)
            some.follows[c, b] = 1 if inside | (has & (square < NEAREST_AXES * NEAREST_AXES)) else 0
            per_time = rate / periods
            vx, vy, spin = held[track, VX], held[track, VY], held[track, SPIN]
            still = (vx == 0.0) & (vy == 0.0)
            gain = (1.0 if still else grip[2 * cell]) * per_time
            turn_gain = (1.0 if still else grip[2 * cell + 1]) * per_time
            some.vx[c, b] = vx + gain * dx if inside else 0.0
            some.vy[c, b] = vy + gain * dy if inside else 0.0
            some.spin[c, b] = spin + turn_gain * turned if inside else 0.0
