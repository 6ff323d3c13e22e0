"""What an agent is shown, and what its actions mean: the same for one swarm and for many worlds.

Observation, float32 in [-1, 1]: six neighbour slots, nearest first, of (seen, range / reach, cos and sin of
bearing, cos and sin of heading, heading told, age in s), then own speed and turn rate over their limits,
the last action, and a constant 1. Action: forward speed from -1 (stand) to 1 (full), turn rate from
-1 to 1 (left).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmvision.data import Commands, Estimates
from swarmvision.geometry import FloatArray

Observation = NDArray[np.float32]
SLOTS, PER_SLOT, OWN = 6, 8, 5
SIZE = SLOTS * PER_SLOT + OWN
TOP_SPEED = 0.25  # m/s at action 1
TOP_TURN = 3.0  # rad/s at action 1


def observe(
    estimates: Estimates, speed: FloatArray, turn_rate: FloatArray, last: FloatArray, reach: float
) -> Observation:
    """Return the observations of all agents, shape ``(..., SIZE)``.

    Args:
        estimates: Robot frame, shape ``(..., k)``.
        speed: Own (m/s), shape ``(...)``.
        turn_rate: Own (rad/s), shape ``(...)``.
        last: Actions, shape ``(..., 2)``.
        reach: Of the sensor (m).
    """
    shape = estimates.seen.shape[:-1]
    slots = np.zeros((*shape, SLOTS, PER_SLOT))
    k = min(SLOTS, estimates.seen.shape[-1])
    if k:
        order = np.argsort(np.where(estimates.seen, estimates.range, np.inf), axis=-1, kind="stable")[..., :k]

        def nearest(values: NDArray[Any]) -> NDArray[Any]:
            return np.take_along_axis(values, order, axis=-1)

        seen, heading, bearing = (
            nearest(values) for values in (estimates.seen, estimates.heading, estimates.bearing)
        )
        told = seen & np.isfinite(heading)
        columns = [
            np.ones_like(heading),
            nearest(estimates.range) / reach,
            np.cos(bearing),
            np.sin(bearing),
            np.where(told, np.cos(heading), 0.0),
            np.where(told, np.sin(heading), 0.0),
            told.astype(np.float64),
            nearest(estimates.age),
        ]
        slots[..., :k, :] = np.where(seen[..., None], np.stack(columns, axis=-1), 0.0)
    own = np.stack(
        [speed / TOP_SPEED, turn_rate / TOP_TURN, last[..., 0], last[..., 1], np.ones(shape)], axis=-1
    )
    rows = np.concatenate([slots.reshape(*shape, SLOTS * PER_SLOT), own], axis=-1)
    bounded: Observation = np.clip(rows, -1.0, 1.0).astype(np.float32)
    return bounded


def limited(actions: Any) -> FloatArray:
    """Return actions ``(..., 2)`` inside their box; a policy's sampling may leave it."""
    inside: FloatArray = np.clip(np.asarray(actions, dtype=np.float64), -1.0, 1.0)
    return inside


def commanded(actions: FloatArray) -> Commands:
    """Return the commands that actions ``(..., 2)`` stand for, shape ``(...)``."""
    return Commands((actions[..., 0] + 1.0) / 2.0 * TOP_SPEED, actions[..., 1] * TOP_TURN)
