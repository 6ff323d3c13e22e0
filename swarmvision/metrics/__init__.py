"""What a swarm did and how well it saw: pure functions of arrays, each with its formula and source."""

from swarmvision.metrics.clusters import (
    cluster_labels,
    dispersion,
    expected_cluster_size,
    in_largest_cluster,
    largest_cluster,
    nearest_distance,
    pair_distance,
    radius_of_gyration,
    social_entropy,
)
from swarmvision.metrics.graph import (
    algebraic_connectivity,
    blind_share,
    strong_components,
    visibility,
    weak_components,
)
from swarmvision.metrics.lattice import deviation_energy, lattice_order
from swarmvision.metrics.ledger import SETTLED, Ledger
from swarmvision.metrics.motion import (
    contacts_per_robot_minute,
    displacement,
    path_efficiency,
    path_length,
    stuck,
)
from swarmvision.metrics.order import milling, order
from swarmvision.metrics.perception import (
    PerceptionErrors,
    TrackSwitches,
    perception_errors,
    perception_table,
)
from swarmvision.metrics.task import (
    gathered_share,
    herding_success,
    transport_distance,
    transport_progress,
)

__all__ = [
    "SETTLED",
    "Ledger",
    "PerceptionErrors",
    "TrackSwitches",
    "algebraic_connectivity",
    "blind_share",
    "cluster_labels",
    "contacts_per_robot_minute",
    "deviation_energy",
    "dispersion",
    "displacement",
    "expected_cluster_size",
    "gathered_share",
    "herding_success",
    "in_largest_cluster",
    "largest_cluster",
    "lattice_order",
    "milling",
    "nearest_distance",
    "order",
    "pair_distance",
    "path_efficiency",
    "path_length",
    "perception_errors",
    "perception_table",
    "radius_of_gyration",
    "social_entropy",
    "strong_components",
    "stuck",
    "transport_distance",
    "transport_progress",
    "visibility",
    "weak_components",
]
