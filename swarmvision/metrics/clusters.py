"""How close together a swarm is: distances, clusters, entropy."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.cluster.hierarchy import linkage
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist

from swarmvision.data import BoolArray, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.metrics.groups import groups_of_places


def cluster_labels(position: ArrayLike, link: float) -> IntArray:
    """Return for each place ``(r, 2)`` (m) the number of its cluster, shape ``(r,)``.

    Two places within ``link`` (m) are of one cluster, and so is whoever is linked to either. Clusters are
    numbered in the order of their first members.
    """
    place = _places(position)
    return groups_of_places(place, np.argsort(place[:, 0], kind="stable"), link)


def in_largest_cluster(position: ArrayLike, link: float) -> BoolArray:
    """Return which places ``(r, 2)`` (m) are in the largest cluster, of equals the first, shape ``(r,)``."""
    labels = cluster_labels(position, link)
    largest: BoolArray = labels == np.argmax(np.bincount(labels, minlength=1))
    return largest


def largest_cluster(position: ArrayLike, link: float) -> float:
    """Return the fraction of places ``(r, 2)`` (m) that are in the largest cluster; 1 for nobody."""
    largest = in_largest_cluster(position, link)
    return float(largest.mean()) if len(largest) else 1.0


def expected_cluster_size(position: ArrayLike, link: float) -> float:
    """Return the size of the cluster in which a robot finds itself on average: ``sum(s^2) / r``.

    ``s`` are the sizes of the clusters; 0 for nobody. O. Soysal, E. Sahin, "Probabilistic aggregation
    strategies in swarm robotic systems", IEEE SIS 2005, doi:10.1109/SIS.2005.1501639.
    """
    labels = cluster_labels(position, link)
    return float(np.sum(np.bincount(labels).astype(np.float64) ** 2) / len(labels)) if len(labels) else 0.0


def dispersion(position: ArrayLike, radius: float) -> FloatArray:
    """Return the spread of a swarm about its centroid, ``sum |x - mean(x)|^2 / (4 R^2)``, shape ``(...)``.

    Equation 1 of M. Gauci et al., "Self-organized aggregation without computation", Int. J. Robot. Res. 33,
    2014, doi:10.1177/0278364914525244, with the sum as it stands there, so it grows with the robots.

    Args:
        position: m, shape ``(..., r, 2)``.
        radius: Of a robot, ``R`` (m).
    """
    place = np.asarray(position, dtype=np.float64)
    if place.shape[-2] == 0:
        return np.zeros(place.shape[:-2])
    off = place - place.mean(axis=-2, keepdims=True)
    spread: FloatArray = np.sum(off**2, axis=(-2, -1)) / (4.0 * radius**2)
    return spread


def radius_of_gyration(position: ArrayLike) -> FloatArray:
    """Return the root of the mean square distance from the centroid (m) of places ``(..., r, 2)``."""
    robots = np.asarray(position).shape[-2]
    gyration: FloatArray = np.sqrt(4.0 * dispersion(position, 1.0) / max(robots, 1))
    return gyration


def nearest_distance(position: ArrayLike) -> float:
    """Return the mean distance to the nearest other (m) of places ``(r, 2)``; nan for fewer than two."""
    place = _places(position)
    if len(place) < 2:
        return float("nan")
    distance = np.asarray(cKDTree(place).query(place, k=2)[0])  # to oneself and to the nearest other
    return float(distance[:, 1].mean())


def pair_distance(position: ArrayLike) -> float:
    """Return the mean distance between two robots (m) of places ``(r, 2)``; nan for fewer than two."""
    place = _places(position)
    return float(pdist(place).mean()) if len(place) > 1 else float("nan")


def social_entropy(position: ArrayLike) -> float:
    """Return the hierarchic social entropy of places ``(r, 2)``: the integral over ``h`` of ``H(h)`` (m bit).

    ``H(h) = -sum(p log2 p)`` over the shares ``p`` of the clusters that links of length ``h`` make, and falls
    in steps, at the lengths at which clusters merge, so the integral is an exact sum. 0 for nobody or one. T.
    Balch, "Hierarchic social entropy", Autonomous Robots 8, 2000, doi:10.1023/A:1008973424594; we merge by
    single linkage, where his clusters may overlap.
    """
    place = _places(position)
    r = len(place)
    if r < 2:
        return 0.0
    tree = linkage(place, method="single")  # rows: cluster, cluster, length, size, by growing length
    size = np.ones(2 * r - 1)
    entropy, total, reached = np.log2(r), 0.0, 0.0
    for row, (one, two, length, members) in enumerate(tree):
        total += entropy * (length - reached)
        reached = length
        entropy += _share(size[int(one)], r) + _share(size[int(two)], r) - _share(members, r)
        size[r + row] = members
    return float(total)


def _share(members: float, robots: int) -> float:
    """Return ``p log2 p`` of a cluster."""
    return float(members / robots * np.log2(members / robots))


def _places(position: ArrayLike) -> FloatArray:
    return np.asarray(position, dtype=np.float64).reshape(-1, 2)
