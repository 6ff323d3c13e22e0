"""A chain of standing robots from a nest outwards.

Source: S. Nouyan, A. Campo, M. Dorigo, "Path formation in a robot swarm: self-organized strategies to find
your way home", Swarm Intelligence 2, 2008, doi:10.1007/s11721-007-0009-6: explorers go along the chain to
its end and become its next member with some probability; the last member leaves with another.

Where we differ: the paper's robots find the nest by the colours of the members; ours carry no lamps and
know the nest's place instead, as the goal. Whoever hangs together with the nest, by links of about the
spacing, is taken for the chain; beyond each of them, straight away from the nest, is the place of the next,
so the chain is straight; a place is for the robot in sight that is nearest to it. A member that is linked
to nobody nearer to the nest explores again. Probabilities are rates; their values and the tolerance's are
ours. Who knows of no nest, or sees no place left, stands still.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import ChainConfig
from swarmvision.controllers.chance import Switch, begin_off
from swarmvision.controllers.crowd import FARTHEST, ComplexArray, Crowd, crowd, goal_offset, unit
from swarmvision.controllers.law import Law
from swarmvision.controllers.motion import turn_and_go
from swarmvision.data import BoolArray, Commands, Senses

ARRIVED = 0.05  # m from its place at which an explorer may become a member: ours


def step(senses: Senses, memory: Switch, config: ChainConfig) -> tuple[Commands, Switch]:
    """Return the commands ``(...)``, and the memory after them: whether a robot stands in the chain."""
    others = crowd(senses.neighbours, FARTHEST)
    nest, known = goal_offset(senses)
    link = (1.0 + config.tolerance) * config.spacing
    chain = _chain(others, nest, link)
    away = np.abs(others.offset - nest[..., None])
    own_away = np.abs(nest)
    mine = others.counts & (others.distance <= link)
    held = (mine & chain & (away < own_away[..., None])).any(axis=-1) | (own_away <= link)
    last = ~(mine & (away > own_away[..., None])).any(axis=-1)
    target = _next_place(others, nest, chain, config)
    joins = known & held & (np.abs(target) < ARRIVED) & memory.chance.happens(config.join_rate, senses.dt, 0)
    leaves = ~held | (last & memory.chance.happens(config.leave_rate, senses.dt, 1))
    walking = _walk(target, others, config)
    moves = known & ~memory.on
    commands = Commands(np.where(moves, walking.speed, 0.0), np.where(moves, walking.turn_rate, 0.0))
    return commands, Switch(memory.chance.after(), np.where(memory.on, ~leaves, joins))


def _chain(others: Crowd, nest: ComplexArray, link: float) -> BoolArray:
    """Return who of those in sight hangs together with the nest, shape ``(..., k)``."""
    linked = np.abs(others.offset[..., :, None] - others.offset[..., None, :]) <= link
    linked &= others.counts[..., :, None] & others.counts[..., None, :]
    away = np.where(others.counts, np.abs(others.offset - nest[..., None]), np.inf)
    # In a straight chain those nearer to the nest are hidden, so the nearest in sight is taken for one of it.
    chain: BoolArray = others.counts & (
        away <= np.maximum(away.min(axis=-1, initial=np.inf), link)[..., None]
    )
    for _ in range(chain.shape[-1]):  # the longest chain takes as many rounds as there are robots
        chain = chain | (linked & chain[..., None, :]).any(axis=-1)
    return chain


def _next_place(others: Crowd, nest: ComplexArray, chain: BoolArray, config: ChainConfig) -> ComplexArray:
    """Return the place that the robot is to take (m), 0 where none is left to it, shape ``(...)``.

    Each place is for the robot nearest to it. Of those that are left to it, a robot takes the one nearest to
    the nest; where such tie, their mean.
    """
    out = others.offset - nest[..., None]
    place = others.offset + config.spacing * unit(out)
    apart = np.abs(place[..., :, None] - others.offset[..., None, :])  # (..., k, k): place, robot
    other = others.counts[..., None, :] & ~np.eye(place.shape[-1], dtype=bool)
    rival = np.min(np.where(other, apart, np.inf), axis=-1, initial=np.inf)
    left = chain & (np.abs(place) < rival)
    away = np.where(left, np.abs(out), np.inf)
    first = left & (away <= away.min(axis=-1, initial=np.inf)[..., None])
    taken = np.sum(np.where(first, place, 0.0), axis=-1) / np.maximum(first.sum(axis=-1), 1)
    begins = ~(others.counts & (np.abs(out) < np.abs(nest)[..., None])).any(axis=-1)
    return np.asarray(np.where(begins, nest - config.spacing * unit(nest), taken))


def _walk(target: ComplexArray, others: Crowd, config: ChainConfig) -> Commands:
    """Return the commands that lead to a place ``(...)``, slowly at its end, past robots that are near."""
    near = others.within(config.clearance)
    aside = near.total(np.maximum(near.towards.real, 0.0) * near.towards)
    bent = unit(target) - aside
    moving = turn_and_go(bent.real, bent.imag, config.speed, config.turn_gain)
    pace = np.minimum(np.abs(target) / (0.5 * config.spacing), 1.0)
    return Commands(moving.speed * pace, moving.turn_rate * np.minimum(pace * 4.0, 1.0))


LAW = Law(ChainConfig, frozenset({"range", "bearing", "goal"}), step, begin_off)
