"""How regular a formation is."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray


def lattice_order(position: ArrayLike, fold: int, link: float) -> float:
    """Return the mean over robots of ``|mean(exp(i n theta))|`` of the directions to their neighbours.

    With ``n = 6`` (psi_6) 1 is a hexagonal lattice, with ``n = 4`` (psi_4) a square one. A robot with fewer
    than two neighbours shows no lattice and counts 0; so does nobody. D. R. Nelson, B. I. Halperin, Phys.
    Rev. B 19, 1979, doi:10.1103/PhysRevB.19.2457.

    Args:
        position: m, shape ``(r, 2)``.
        fold: ``n``.
        link: Farthest neighbour (m): between the lattice's first and second distance.
    """
    place, pairs = _linked(position, link)
    if len(place) == 0:
        return 0.0
    offset = place[pairs[:, 1]] - place[pairs[:, 0]]
    turned = np.exp(1j * fold * np.arctan2(offset[:, 1], offset[:, 0]))
    total = np.zeros(len(place), dtype=np.complex128)
    np.add.at(total, pairs[:, 0], turned)
    count = np.bincount(pairs[:, 0], minlength=len(place))
    return float(np.mean(np.where(count > 1, np.abs(total) / np.maximum(count, 1), 0.0)))


def deviation_energy(position: ArrayLike, spacing: float, link: float) -> float:
    """Return how far the links are from their spacing, ``sum((l - d)^2) / (n + 1) / d^2``.

    ``l`` are the lengths of the ``n`` links, each counted from both ends. 0 is a lattice, or nobody near
    anybody. R. Olfati-Saber, IEEE Trans. Autom. Control 51, 2006, doi:10.1109/TAC.2005.864190: his deviation
    energy, over ``d^2``.

    Args:
        position: m, shape ``(r, 2)``.
        spacing: ``d`` (m).
        link: Farthest neighbour (m).
    """
    place, pairs = _linked(position, link)
    length = np.hypot(*(place[pairs[:, 1]] - place[pairs[:, 0]]).T)
    return float(np.sum((length - spacing) ** 2) / (len(pairs) + 1) / spacing**2)


def _linked(position: ArrayLike, link: float) -> tuple[FloatArray, IntArray]:
    """Return the places and who is linked to whom ``(n, 2)``, each pair in both orders."""
    place = np.asarray(position, dtype=np.float64).reshape(-1, 2)
    if len(place) == 0:
        return place, np.zeros((0, 2), dtype=np.int64)
    pairs = cKDTree(place).query_pairs(link, output_type="ndarray").reshape(-1, 2)
    return place, np.concatenate([pairs, pairs[:, ::-1]]).astype(np.int64)
