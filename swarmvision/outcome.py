"""What a run came to, by what its scenario measures."""

from __future__ import annotations

from typing import Any

import numpy as np

from swarmvision.config.controller import ChainConfig, SpearsConfig
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.data import Scene
from swarmvision.geometry import FloatArray
from swarmvision.metrics import (
    SETTLED,
    cluster_labels,
    expected_cluster_size,
    gathered_share,
    herding_success,
    largest_cluster,
    lattice_order,
    milling,
    nearest_distance,
    order,
    transport_distance,
    transport_progress,
)

FLOCK_LINK = 0.5  # m; two robots nearer than this belong to one flock
AGGREGATE_LINK = 1.5  # body diagonals; two robots nearer than this touch or nearly so
LATTICE_LINK = 1.2  # spacings: between the first and the second distance of a square and a hexagonal lattice
CHAIN_LINK = 1.3  # spacings


def outcome(scenario: ScenarioConfig, scenes: list[Scene]) -> dict[str, Any]:
    """Return the figures that a scenario's ``measure`` names, from the course of its run; never empty.

    Shares and orders are means over the last fifth of the run, ``*_final`` ones are of its last scene.
    """
    place = np.array([scene.pose[:, :2] for scene in scenes]).reshape(len(scenes), scenario.robots, 2)
    late = slice(-max(round(SETTLED * len(scenes)), 1), None)
    link = cluster_link(scenario)
    match scenario.measure:
        case "flocking":
            yaw = np.array([scene.pose[:, 2] for scene in scenes[late]])
            figures = {"order": float(order(yaw).mean()), "largest_cluster": _largest(place[late], link)}
        case "aggregation":
            expected = expected_cluster_size(place[-1], link)
            figures = {
                "largest_cluster": _largest(place[late], link),
                "expected_cluster_size_final": expected,
            }
        case "milling":
            velocity = np.array([scene.velocity[:, :2] for scene in scenes[late]])
            figures = {"milling": float(np.abs(milling(place[late], velocity)).mean())}
        case "lattice":
            figures = _lattice(scenario, place[-1])
        case "chain":
            figures = _chain(scenario, place[-1])
        case "herding":
            figures = _herding(scenario, place)
        case "transport":
            figures = _transport(scenario, scenes)
    return figures


def cluster_link(scenario: ScenarioConfig) -> float:
    """Return the distance (m) below which two robots of a scenario belong to one cluster."""
    if scenario.measure == "flocking":
        return FLOCK_LINK
    return AGGREGATE_LINK * float(np.hypot(scenario.robot.length, scenario.robot.width))


def _largest(place: FloatArray, link: float) -> float:
    return float(np.mean([largest_cluster(now, link) for now in place]))


def _lattice(scenario: ScenarioConfig, place: FloatArray) -> dict[str, Any]:
    law, nearest = scenario.controller, nearest_distance(place)
    spacing = law.spacing if isinstance(law, SpearsConfig) else nearest
    if not np.isfinite(nearest):  # fewer than two robots
        return {"psi_4_final": 0.0, "psi_6_final": 0.0, "nearest_distance_final": None}
    return {
        "psi_4_final": lattice_order(place, 4, LATTICE_LINK * spacing),
        "psi_6_final": lattice_order(place, 6, LATTICE_LINK * spacing),
        "nearest_distance_final": nearest,
    }


def _chain(scenario: ScenarioConfig, place: FloatArray) -> dict[str, Any]:
    """Return how many robots hang together with the nest, which is the goal, and how far (m) they reach."""
    law, goal = scenario.controller, scenario.goal
    if goal is None or not len(place):
        return {"chain_members_final": 0, "chain_length_final": 0.0}
    link = CHAIN_LINK * law.spacing if isinstance(law, ChainConfig) else FLOCK_LINK
    nest = np.array([[goal.x, goal.y]])
    labels = cluster_labels(np.vstack([place, nest]), link)
    chain = place[labels[:-1] == labels[-1]]
    return {
        "chain_members_final": len(chain),
        "chain_length_final": float(np.hypot(*(chain - nest).T).max(initial=0.0)),
    }


def _herding(scenario: ScenarioConfig, place: FloatArray) -> dict[str, Any]:
    """Return whether, when and for how long all but the main team were home."""
    flock = place[:, scenario.team_sizes[0] :]
    if scenario.goal is None:
        return {"herding_success": False, "home_at": None, "gathered_share_final": 0.0}
    goal, radius = (scenario.goal.x, scenario.goal.y), scenario.goal.radius
    home = np.flatnonzero(gathered_share(flock, goal, radius) >= 1.0)
    return {
        "herding_success": herding_success(flock, goal, radius),
        "home_at": float(home[0] / scenario.control_hz) if len(home) else None,
        "gathered_share_final": float(gathered_share(flock[-1], goal, radius)),
    }


def _transport(scenario: ScenarioConfig, scenes: list[Scene]) -> dict[str, Any]:
    """Return how far the first thing that can be pushed came, and by how much nearer to the goal (m)."""
    loads = [i for i, thing in enumerate(scenario.arena.objects) if thing.mass is not None]
    course = np.array([scene.object_pose[loads[0], :2] for scene in scenes]) if loads else np.zeros((0, 2))
    goal = scenario.goal
    return {
        "transport_distance": transport_distance(course),
        "transport_progress": transport_progress(course, (goal.x, goal.y)) if goal is not None else None,
    }
