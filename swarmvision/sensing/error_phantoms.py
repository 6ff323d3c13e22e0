"""Measurements of nobody."""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import leaf
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray
from swarmvision.sensing.error_chance import QUANTILES, mixed, normal, of_other, picked, share
from swarmvision.sensing.error_memory import NUMBER, PHANTOM, REMEMBERED, SHARE, STATE, WHO, YAW, Slots, X, Y
from swarmvision.sensing.error_numbers import Tables, Told, spread, tell
from swarmvision.trigonometry import wrapped

VISIBLE = 0.5  # of a phantom; ours


@leaf
def imagine(
    i: int,
    s: int,
    seed: np.uint64,
    side: float,
    pose: FloatArray,
    reach: float,
    tables: Tables,
    following: IntArray,
    new: Slots,
    told: Told,
) -> bool:
    """Let a robot see somebody who is not there; return whether it does.

    Args:
        i: The robot.
        s: The place for it, among all slots.
        seed: Of the robot's chance in this picture.
        side: 1.0 if it turns left, else -1.0.
        pose: Of all robots, ``(o * 3,)``.
        reach: Beyond it estimates are dropped (m).
        tables: Of the errors.
        following: Numbers of the observers' next tracks, ``(o,)``; they go on.
        new: Slots of this call; they go on.
        told: Out.
    """
    places, normals, bits = tables.place, tables.normals, of_other(seed, PHANTOM)
    gap = picked(places, 0, normal(bits, 0, normals))
    if gap > reach:
        return False
    bearing = side * picked(places, QUANTILES, normal(bits, 1, normals))
    heading = side * wrapped(2.0 * np.pi * share(mixed(bits)))
    x, y, yaw = pose[3 * i], pose[3 * i + 1], pose[3 * i + 2]
    marks, numbers = new.marks[s], new.numbers[s]
    marks[WHO], marks[STATE], marks[NUMBER] = PHANTOM, REMEMBERED, following[i]
    numbers[:] = 0.0
    numbers[SHARE], numbers[YAW] = VISIBLE, yaw + heading
    numbers[X], numbers[Y] = x + gap * np.cos(yaw + bearing), y + gap * np.sin(yaw + bearing)
    tell(s, gap, bearing, heading, marks, numbers, told)
    spread(told.covariance[s], tables.aged_variance, 0)
    following[i] += 1
    return True
