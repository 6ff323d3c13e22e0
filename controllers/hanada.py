"""Equilateral triangles with two neighbours, on the way to a goal and among obstacles.

Source: Y. Hanada, G. Lee, N. Y. Chong, "Adaptive flocking of a swarm of robots based on local
interactions", IEEE Swarm Intelligence Symposium 2007, doi:10.1109/SIS.2007.367935: the partners are the
nearest neighbour and the one that makes the shortest way round the three; the place to go to lies
``d_u / sqrt(3)`` from their common centroid, straight off the line through the partners.

Where we differ: we have the paper's rule at second hand, and all gains are ours; the goal and the obstacles
(read by a proximity ring) are added as velocities instead of as roles of the robots; with one neighbour in
sight a robot keeps the side's length from it.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import HanadaConfig
from swarmvision.controllers.crowd import ComplexArray, Crowd, crowd, goal_offset, push_of_obstacles, unit
from swarmvision.controllers.law import Law, Memory
from swarmvision.controllers.motion import with_alone
from swarmvision.data import Commands, Senses


def step(senses: Senses, memory: Memory, config: HanadaConfig) -> tuple[Commands, Memory]:
    """Return the commands ``(...)`` of robots; there is nothing to remember."""
    near = crowd(senses.neighbours, config.reach)
    goal, informed = goal_offset(senses)
    push = push_of_obstacles(senses, config.obstacle_range)
    wanted = (
        config.gain * out_of_place(near, config.spacing)
        + config.goal_speed * unit(goal)
        + config.obstacle_speed * push
    )
    wanted = wanted * np.minimum(1.0, config.speed / np.maximum(np.abs(wanted), 1e-9))
    commands = Commands(wanted.real, config.turn_gain * wanted.imag)
    return with_alone(commands, near.anybody | informed, config.alone, config.goal_speed), memory


def out_of_place(near: Crowd, spacing: float) -> ComplexArray:
    """Return the way to the robot's place in its triangle (m), shape ``(...)``; 0 with nobody near.

    Where partners tie, their places are averaged, so that the order of the neighbours does not matter.
    """
    distance = np.where(near.counts, near.distance, np.inf)
    place = np.where(near.counts, near.offset, 0.0)
    nearest = near.counts & (distance == np.min(distance, axis=-1, initial=np.inf)[..., None])
    apart = np.abs(place[..., :, None] - place[..., None, :])  # (..., k, k): first and second partner
    way_round = distance[..., :, None] + distance[..., None, :] + apart
    way_round = np.where(np.eye(place.shape[-1], dtype=bool), np.inf, way_round)
    shortest = np.min(way_round, axis=-1, initial=np.inf)[..., None]
    chosen = nearest[..., :, None] & np.isfinite(way_round) & (way_round == shortest)
    apex = _apex(place, spacing)
    pairs = np.count_nonzero(chosen, axis=(-2, -1))
    in_triangle = np.sum(np.where(chosen, apex, 0.0), axis=(-2, -1)) / np.maximum(pairs, 1)
    alone_with = np.where(nearest, place - spacing * near.towards, 0.0).sum(axis=-1)
    alone_with = alone_with / np.maximum(np.count_nonzero(nearest, axis=-1), 1)
    offset: ComplexArray = np.where(pairs > 0, in_triangle, alone_with)
    return offset


def _apex(place: ComplexArray, spacing: float) -> ComplexArray:
    """Return where a robot at 0 stands in its triangle with two of the places ``(..., k)``."""
    one, two = place[..., :, None], place[..., None, :]
    along = (two - one) / np.maximum(np.abs(two - one), 1e-9)
    height = (-one * along.conjugate()).imag  # of the robot over the line through both, signed
    centroid = (one + two) / 3.0
    apex: ComplexArray = centroid + np.sign(height) * 1j * along * spacing / 3.0**0.5
    return apex


LAW = Law(HanadaConfig, frozenset({"range", "bearing", "proximity", "goal"}), step, lambda config, keys: ())
