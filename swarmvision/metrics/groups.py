"""Who belongs together: groups that links make, by union and find. Kernels."""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray


@compiled
def groups_of_links(one: IntArray, two: IntArray, members: int) -> IntArray:
    """Return the group of each member, shape ``(members,)``, when ``one[n]`` and ``two[n]`` are linked.

    Groups are numbered in the order of their first members.
    """
    parent = np.arange(members)
    for n in range(len(one)):
        _join(parent, one[n], two[n])
    return _numbered(parent)


@compiled
def groups_of_places(place: FloatArray, by_x: IntArray, link: float) -> IntArray:
    """Return the group of each place, shape ``(r,)``, when those within ``link`` (m) are linked.

    Args:
        place: m, shape ``(r, 2)``.
        by_x: The places in the order of their x, shape ``(r,)``.
        link: m.
    """
    parent = np.arange(len(place))
    for a in range(len(by_x)):
        for b in range(a + 1, len(by_x)):
            dx = place[by_x[b], 0] - place[by_x[a], 0]
            if dx > link:
                break
            dy = place[by_x[b], 1] - place[by_x[a], 1]
            if np.hypot(dx, dy) <= link:
                _join(parent, by_x[a], by_x[b])
    return _numbered(parent)


@compiled
def _root(parent: IntArray, member: int) -> int:
    while parent[member] != member:
        parent[member] = parent[parent[member]]
        member = parent[member]
    return member


@compiled
def _join(parent: IntArray, one: int, two: int) -> None:
    """Make two members' groups one; its root is its first member."""
    first, second = _root(parent, one), _root(parent, two)
    parent[max(first, second)] = min(first, second)


@compiled
def _numbered(parent: IntArray) -> IntArray:
    group = np.empty(len(parent), np.int64)
    count = 0
    for member in range(len(parent)):
        root = _root(parent, member)
        if root == member:
            group[member] = count
            count += 1
        else:
            group[member] = group[root]
    return group
