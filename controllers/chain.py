"""A straight chain of standing robots from a nest outwards.

Source: S. Nouyan, A. Campo, M. Dorigo, "Path formation in a robot swarm: self-organized strategies to find
your way home", Swarm Intelligence 2, 2008, doi:10.1007/s11721-007-0009-6: explorers go along the chain to
its end and become its next member with some probability; the last member leaves with another.

Where we differ: the paper's robots find the nest and the way along the chain by the colours of its members;
ours carry no lamps and know the nest's place instead, as the goal. The chain lies on the ray from the nest
through the robot nearest to it, its places a spacing apart. A place counts as taken where a robot stands,
where a nearer robot hides it, and between the nest and the robot nearest to it. Explorers go to the first
places that are free, in the order of how far they have to the first of them. A member before whom a place
becomes free explores again. Probabilities are rates; their values and the tolerance's are ours. Who knows
of no nest stands still.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from swarmvision.config.controller import ChainConfig
from swarmvision.controllers.chance import Switch, begin_off
from swarmvision.controllers.crowd import FARTHEST, ComplexArray, Crowd, crowd, goal_offset, unit
from swarmvision.controllers.law import Law
from swarmvision.controllers.motion import turn_and_go
from swarmvision.data import BoolArray, Commands, IntArray, Senses
from swarmvision.geometry import FloatArray

ARRIVED = 0.05  # m from its place at which an explorer may become a member: ours
HALF_HIDDEN = 0.04  # m to either side of a robot's middle, where it hides what stands behind it: ours
TIE = 1e-6  # m: distances that differ by less are alike


class Chain(NamedTuple):
    """The chain as each robot sees it, without itself, shape ``(...)``."""

    place: ComplexArray
    """Of its ``n`` places from the nest outwards (m), shape ``(..., n)``; more than there are robots."""
    taken: BoolArray
    """Whether somebody stands there, or it is hidden, shape ``(..., n)``."""
    exploring: BoolArray
    """Who stands on none of the places before the first that is free, shape ``(..., k)``."""

    @property
    def length(self) -> IntArray:
        """Places before the first that is free."""
        return np.asarray(np.cumprod(self.taken, axis=-1).sum(axis=-1))

    def at(self, number: IntArray) -> ComplexArray:
        """Return the place of a number, the last for numbers beyond."""
        number = np.minimum(number, self.place.shape[-1] - 1)
        return np.asarray(np.take_along_axis(self.place, number[..., None], axis=-1)[..., 0])


def step(senses: Senses, memory: Switch, config: ChainConfig) -> tuple[Commands, Switch]:
    """Return the commands ``(...)``, and the memory after them: whether a robot stands in the chain."""
    others = crowd(senses.neighbours, FARTHEST)
    nest, known = goal_offset(senses)
    chain = chain_of(others, nest, config)
    first = chain.at(chain.length)
    waiting = chain.exploring & (np.abs(others.offset - first[..., None]) < np.abs(first)[..., None] - TIE)
    target = chain.at(chain.length + np.count_nonzero(waiting, axis=-1))
    joins = known & (np.abs(target) < ARRIVED) & memory.chance.happens(config.join_rate, senses.dt, 0)
    held = np.abs(first) <= config.tolerance * config.spacing
    last = chain.at(chain.length + 1)
    followed = (others.counts & _near(others, last[..., None], config)[..., 0, :]).any(axis=-1)
    leaves = ~held | (~followed & memory.chance.happens(config.leave_rate, senses.dt, 1))
    walking = _walk(target, others, config)
    moves = known & ~memory.on
    commands = Commands(np.where(moves, walking.speed, 0.0), np.where(moves, walking.turn_rate, 0.0))
    return commands, Switch(memory.chance.after(), np.where(memory.on, ~leaves, joins))


def chain_of(others: Crowd, nest: ComplexArray, config: ChainConfig) -> Chain:
    """Return the chain as each robot sees it.

    Args:
        others: In sight, ``(..., k)``.
        nest: Its place in the robot's frame (m), ``(...)``.
        config: Spacing and tolerance.
    """
    numbers = np.arange(1, others.distance.shape[-1] + 3)
    place = nest[..., None] + config.spacing * numbers * _direction(others, nest)[..., None]
    stands = _near(others, place, config) & others.counts[..., None, :]
    taken = (
        stands.any(axis=-1) | _hidden(others, place) | (numbers < _begins(others, nest, config)[..., None])
    )
    before = np.cumprod(taken, axis=-1).astype(bool)
    exploring = others.counts & ~(stands & before[..., None]).any(axis=-2)
    return Chain(place, taken, exploring)


def _direction(others: Crowd, nest: ComplexArray) -> ComplexArray:
    """Return the direction, of length 1, from the nest to the robot nearest to it; of such, their mean."""
    out = np.concatenate([others.offset - nest[..., None], -nest[..., None]], axis=-1)
    counts = np.concatenate([others.counts, np.ones((*nest.shape, 1), dtype=bool)], axis=-1)
    away = np.where(counts, np.abs(out), np.inf)
    nearest = away <= away.min(axis=-1, keepdims=True) + TIE
    return unit(np.sum(np.where(nearest, unit(out), 0.0), axis=-1))


def _begins(others: Crowd, nest: ComplexArray, config: ChainConfig) -> FloatArray:
    """Return the number of the place of the robot nearest to the nest; 0 where it is the robot itself.

    Seen from the end of a chain that is not quite straight, it hides those before it, but not their places.
    """
    away = np.where(others.counts, np.abs(others.offset - nest[..., None]), np.inf)
    nearest = away.min(axis=-1, initial=np.inf)
    number: FloatArray = np.where(nearest < np.abs(nest) - TIE, np.rint(nearest / config.spacing), 0.0)
    return number


def _near(others: Crowd, place: ComplexArray, config: ChainConfig) -> BoolArray:
    """Return who is at which place, shape ``(..., n, k)``."""
    apart: FloatArray = np.abs(place[..., None] - others.offset[..., None, :])
    return np.asarray(apart <= config.tolerance * config.spacing)


def _hidden(others: Crowd, place: ComplexArray) -> BoolArray:
    """Return which places ``(..., n)`` stand behind somebody."""
    across = place[..., None] * others.towards.conjugate()[..., None, :]
    behind = (across.real > others.distance[..., None, :]) & (np.abs(across.imag) < HALF_HIDDEN)
    return np.asarray((behind & others.counts[..., None, :]).any(axis=-1))


def _walk(target: ComplexArray, others: Crowd, config: ChainConfig) -> Commands:
    """Return the commands that lead to a place ``(...)``, slowly at its end, past robots that are near."""
    near = others.within(config.clearance)
    aside = near.total(np.maximum(near.towards.real, 0.0) * near.towards)
    bent = unit(target) - aside
    moving = turn_and_go(bent.real, bent.imag, config.speed, config.turn_gain)
    pace = np.minimum(np.abs(target) / (0.5 * config.spacing), 1.0)
    return Commands(moving.speed * pace, moving.turn_rate * np.minimum(pace * 4.0, 1.0))


LAW = Law(ChainConfig, frozenset({"range", "bearing", "goal"}), step, begin_off)
