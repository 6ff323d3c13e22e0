"""Who sees whom: the directed graph of a swarm's eyes, and how well it holds together.

An adjacency ``(r, r)``, sparse or not, says in row ``i`` whom robot ``i`` sees.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from swarmvision.metrics.perception import PerceptionErrors

Adjacency = Any  # a scipy.sparse.csr_array, whose types differ between versions of its stubs


def visibility(errors: PerceptionErrors, robots: int) -> Adjacency:
    """Return who sees whom by estimates that match the truth, 1 or 0, shape ``(r, r)``, sparse."""
    pairs = errors.observer[errors.found], errors.neighbour[errors.found]
    return csr_array((np.ones(len(pairs[0])), pairs), shape=(robots, robots))


def weak_components(adjacency: ArrayLike | csr_array) -> int:
    """Return into how many groups a swarm falls if a look binds both, the one who looks and the one seen."""
    return _components(adjacency, "weak")


def strong_components(adjacency: ArrayLike | csr_array) -> int:
    """Return into how many groups it falls in which news from anyone reaches everyone, from seen to seer."""
    return _components(adjacency, "strong")


def algebraic_connectivity(adjacency: ArrayLike | csr_array) -> float:
    """Return the second smallest eigenvalue of the Laplacian of ``(A + A^T) / 2``; 0 for fewer than two.

    Positive where the graph is weakly connected, and the larger the more links must be cut to part it. M.
    Fiedler, "Algebraic connectivity of graphs", Czech. Math. J. 23, 1973, doi:10.21136/CMJ.1973.101168.
    """
    sees = _sparse(adjacency).toarray()
    if len(sees) < 2:
        return 0.0
    both = (sees + sees.T) / 2.0
    return float(max(np.linalg.eigvalsh(np.diag(both.sum(axis=1)) - both)[1], 0.0))


def blind_share(adjacency: ArrayLike | csr_array) -> float:
    """Return the share of the robots that see nobody; 0 for nobody."""
    sees = _sparse(adjacency)
    return float(np.mean(sees.sum(axis=1) == 0)) if sees.shape[0] else 0.0


def _components(adjacency: ArrayLike | csr_array, connection: Literal["weak", "strong"]) -> int:
    sees = _sparse(adjacency)
    return int(connected_components(sees, directed=True, connection=connection)[0]) if sees.shape[0] else 0


def _sparse(adjacency: ArrayLike | csr_array) -> Adjacency:
    if isinstance(adjacency, csr_array):
        return adjacency
    sees = np.asarray(adjacency, dtype=np.float64)
    return csr_array(sees.reshape(len(sees), len(sees)))
