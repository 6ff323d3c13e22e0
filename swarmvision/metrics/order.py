"""Whether a swarm goes one way, or round."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from swarmvision.geometry import FloatArray


def order(yaw: ArrayLike) -> FloatArray:
    """Return the polar order ``|mean(exp(i yaw))|`` of headings ``(..., r)``: 1 is aligned.

    Random headings give about ``1/sqrt(r)``; a swarm of nobody is aligned. T. Vicsek et al., Phys. Rev.
    Lett. 75, 1995, doi:10.1103/PhysRevLett.75.1226.
    """
    yaw = np.asarray(yaw, dtype=np.float64)
    if yaw.shape[-1] == 0:
        return np.ones(yaw.shape[:-1])
    aligned: FloatArray = np.abs(np.exp(1j * yaw).mean(axis=-1))
    return aligned


def milling(position: ArrayLike, velocity: ArrayLike) -> FloatArray:
    """Return how much a swarm turns about its centroid, ``|mean(r x v)|`` of unit vectors: 1 is a mill.

    ``r`` points from the centroid to a robot, ``v`` is its velocity; who stands, or stands on the centroid,
    counts as not turning. Nobody does not turn. The group's angular momentum ``m_group`` of I. D. Couzin et
    al., J. Theor. Biol. 218, 2002, doi:10.1006/jtbi.2002.3065.

    Args:
        position: m, shape ``(..., r, 2)``.
        velocity: m/s, shape ``(..., r, 2)``.
    """
    place, going = np.asarray(position, dtype=np.float64), np.asarray(velocity, dtype=np.float64)
    if place.shape[-2] == 0:
        return np.zeros(place.shape[:-2])
    out = _unit(place - place.mean(axis=-2, keepdims=True))
    going = _unit(going)
    spin = out[..., 0] * going[..., 1] - out[..., 1] * going[..., 0]
    turning: FloatArray = np.abs(spin.mean(axis=-1))
    return turning


def _unit(vector: FloatArray) -> FloatArray:
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.where(length > 1e-9, vector / np.maximum(length, 1e-9), 0.0)
