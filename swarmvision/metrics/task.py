"""What a swarm did of its task."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from swarmvision.geometry import FloatArray


def gathered_share(position: ArrayLike, goal: ArrayLike, radius: float) -> FloatArray:
    """Return the share of a flock ``(..., r, 2)`` that is within a radius of a place (m), shape ``(...)``.

    Herding has succeeded where it is 1, as D. Strombom et al. have it (J. R. Soc. Interface 11, 2014,
    doi:10.1098/rsif.2014.0719); an empty flock is home.
    """
    off = np.asarray(position, dtype=np.float64) - np.asarray(goal, dtype=np.float64)
    if off.shape[-2] == 0:
        return np.ones(off.shape[:-2])
    share: FloatArray = np.mean(np.hypot(off[..., 0], off[..., 1]) <= radius, axis=-1)
    return share


def herding_success(position: ArrayLike, goal: ArrayLike, radius: float) -> bool:
    """Return whether the whole flock was home at one instant or more, from its course ``(t, r, 2)`` (m)."""
    return bool(np.any(gathered_share(position, goal, radius) >= 1.0))


def transport_distance(object_position: ArrayLike) -> float:
    """Return how far a thing came, first to last (m), from its course ``(t, 2)``; 0 without a course."""
    course = np.asarray(object_position, dtype=np.float64).reshape(-1, 2)
    return float(np.hypot(*(course[-1] - course[0]))) if len(course) else 0.0


def transport_progress(object_position: ArrayLike, goal: ArrayLike) -> float:
    """Return by how much a thing came nearer to a goal (m), negative if it went away, from ``(t, 2)``."""
    off = np.asarray(object_position, dtype=np.float64).reshape(-1, 2) - np.asarray(goal, dtype=np.float64)
    if len(off) == 0:
        return 0.0
    return float(np.hypot(*off[0]) - np.hypot(*off[-1]))
