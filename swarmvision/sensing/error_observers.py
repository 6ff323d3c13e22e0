"""What is an observer's own in a picture: its chance, what its errors have in common, its encoders."""

from __future__ import annotations

from swarmvision.compiled import apart
from swarmvision.drive import over_ground
from swarmvision.geometry import FloatArray
from swarmvision.sensing.error_chance import bin_of, entry, mixed, of_other, of_picture, share
from swarmvision.sensing.error_memory import NOBODY, PHANTOM, Minds
from swarmvision.sensing.error_numbers import Tables
from swarmvision.sensing.error_rows import Observers
from swarmvision.sensing.error_table import TURNS
from swarmvision.trigonometry import sine_cosine, wrapped


@apart
def look_round(
    count: int,
    now: bool,
    likely: float,
    pose: FloatArray,
    turn_rate: FloatArray,
    left: FloatArray,
    right: FloatArray,
    drive: tuple[float, float],
    tables: Tables,
    minds: Minds,
    some: Observers,
) -> None:
    """Fill in some observers, and let their minds go on.

    Args:
        count: How many, ``b``.
        now: Whether they take a picture.
        likely: Chance of a phantom in a picture.
        pose: Of these robots, ``(b * 3,)``.
        turn_rate: Of these (rad/s), ``(b,)``.
        left: Way of their left tracks by the encoders since the start (m), ``(b,)``.
        right: And of the right ones.
        drive: Distance of the tracks (m), and the slip of a turn.
        tables: Of the errors.
        minds: In and out, of these robots; the number of the picture is in ``some``.
        some: In, home and picture; out, all else.
    """
    normals, weights = tables.normals, tables.weights
    for b in range(count):
        seed, rate, begun = of_picture(minds.keys[b], some.picture[b]), turn_rate[b], some.picture[b] > 0
        # Tables are of left turns; what lasts is kept as it is, for an error outlives a turn's change.
        side = 1.0 if rate >= 0.0 else -1.0
        some.seed[b], some.side[b], some.turn[b] = seed, side, bin_of(TURNS, abs(rate))
        some.odd[b] = 1 if share(of_other(seed, PHANTOM)) < likely else 0
        bits = of_other(seed, NOBODY)
        z0, z1, z2 = normals[entry(bits, 0)], side * normals[entry(bits, 1)], side * normals[entry(bits, 2)]
        was0, was1, was2 = minds.common_range[b], minds.common_bearing[b], minds.common_heading[b]
        z0 = weights[0] * was0 + weights[1] * z0 if begun else z0
        z1 = weights[6] * was1 + weights[7] * z1 if begun else z1
        z2 = weights[12] * was2 + weights[13] * z2 if begun else z2
        minds.common_range[b], minds.common_bearing[b] = z0 if now else was0, z1 if now else was1
        minds.common_heading[b] = z2 if now else was2
        bits = mixed(bits)
        some.shared_range[b] = weights[4] * z0 + weights[5] * normals[entry(bits, 0)]
        some.shared_bearing[b] = weights[10] * z1 + weights[11] * side * normals[entry(bits, 1)]
        some.shared_heading[b] = weights[16] * z2 + weights[17] * side * normals[entry(bits, 2)]

        x, y, yaw = pose[3 * b], pose[3 * b + 1], pose[3 * b + 2]
        forward, turn = over_ground(left[b], right[b], drive[0], drive[1])
        ahead, turned = forward - minds.forward[b], turn - minds.turn[b]
        sine, cosine = sine_cosine(minds.yaw[b] + turned / 2.0)
        some.from_x[b], some.from_y[b] = minds.x[b] + ahead * cosine, minds.y[b] + ahead * sine
        slip = wrapped(yaw - minds.yaw[b] - turned)
        some.x[b], some.y[b], some.yaw[b], some.slip[b] = x, y, yaw, slip
        some.sine[b], some.cosine[b] = sine_cosine(slip)
        minds.x[b], minds.y[b], minds.yaw[b] = x, y, yaw
        minds.forward[b], minds.turn[b] = forward, turn
