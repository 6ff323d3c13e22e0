"""A sheep: grazes, flees a dog, keeps with the others.

Source: D. Strombom, R. P. Mann, A. M. Wilson, et al., "Solving the shepherding problem: heuristics for
herding autonomous, interacting agents", J. R. Soc. Interface 11, 2014, doi:10.1098/rsif.2014.0719:
the direction is the sum of the old one, the pull to the middle of the flock, the push of sheep that are too
near, the push of the dog, and chance.

Where we differ: the ranges are those of a robot of 10 cm instead of the paper's metres, so r_s is less than
five r_a, not 32; the middle is that of all sheep in sight, not of the nearest n; sheep cannot step sideways;
walls push. The weights of chance and grazing are ours. With nobody in sight a sheep grazes.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import SheepConfig
from swarmvision.controllers.chance import Chance, begin
from swarmvision.controllers.crowd import FARTHEST, OBSTACLE_GAIN, crowd, push_of_obstacles, unit
from swarmvision.controllers.law import Law
from swarmvision.controllers.motion import turn_and_go
from swarmvision.data import Commands, Senses


def step(senses: Senses, memory: Chance, config: SheepConfig) -> tuple[Commands, Chance]:
    """Return the commands ``(...)``, and the memory after them."""
    kind = np.asarray(senses.neighbours.kind)
    others = crowd(senses.neighbours, FARTHEST)
    dogs = others.within((kind != config.own_kind) & (kind >= 0)).within(config.dog_range)
    sheep = others.within((kind == config.own_kind) | (kind < 0))
    near = sheep.within(config.sheep_range)
    push = push_of_obstacles(senses, config.obstacle_range)
    way = (
        config.inertia
        + np.where(dogs.anybody, config.attraction, 0.0) * unit(sheep.total(sheep.offset))
        - config.repulsion * unit(near.total(near.towards))
        - config.fear * unit(dogs.total(dogs.towards))
        + config.noise * np.exp(2j * np.pi * memory.even(0))
        + OBSTACLE_GAIN * push
    )
    grazes = memory.even(1) < config.graze
    moves = dogs.anybody | near.anybody | grazes
    commands = turn_and_go(way.real, way.imag, config.speed, config.turn_gain)
    commands = Commands(np.where(moves, commands.speed, 0.0), np.where(moves, commands.turn_rate, 0.0))
    return commands, memory.after()


LAW = Law(SheepConfig, frozenset({"range", "bearing", "kind", "proximity"}), step, begin)
