"""Measurements of nobody."""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.data import BoolArray
from swarmvision.geometry import FloatArray
from swarmvision.sensing.error_chance import QUANTILES, mixed, normal, of_other, of_picture, picked, share
from swarmvision.sensing.error_memory import PHANTOM, REMEMBERED, Minds, Slots
from swarmvision.sensing.error_numbers import Tables, Told, spread
from swarmvision.trigonometry import wrapped

VISIBLE = 0.5  # of a phantom; ours


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
    places, variance, normals = tables.place, tables.aged_variance, tables.normals
    following, picture, keys = minds.following, minds.picture, minds.keys
    used, who, state, age, visible, number, deviate, spot, pace = new
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
            gap = picked(places, 0, normal(bits, 0, normals))
            bearing = sign * picked(places, QUANTILES, normal(bits, 1, normals))
            heading = sign * wrapped(2.0 * np.pi * share(mixed(bits)))
            if gap > reach:
                continue
            yaw = pose[w, i, 2]
            told_range[w, i, n], told_bearing[w, i, n], told_heading[w, i, n] = gap, bearing, heading
            spot[w, i, n, 0] = pose[w, i, 0] + gap * np.cos(yaw + bearing)
            spot[w, i, n, 1] = pose[w, i, 1] + gap * np.sin(yaw + bearing)
            spot[w, i, n, 2] = yaw + heading
            for c in range(3):
                deviate[w, i, n, c] = pace[w, i, n, c] = 0.0
            who[w, i, n], age[w, i, n], state[w, i, n] = PHANTOM, 0.0, REMEMBERED
            visible[w, i, n], number[w, i, n] = VISIBLE, following[w, i]
            spread(covariance, w, i, n, variance, 0)
            following[w, i] += 1
            used[w, i] = n + 1
        picture[w] += 1
