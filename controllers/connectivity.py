"""Never go where a neighbour in sight would be lost: a layer under any law.

Sources: A. Cezayirli, F. Kerestecioglu, "Navigation of non-communicating autonomous mobile robots with
guaranteed connectivity", Robotica 31(5), 2013: local steering by range sensors keeps a group
connected, without communication. The set that a robot may move in is that of H. Ando, Y. Oasa, I. Suzuki,
M. Yamashita, "Distributed memoryless point convergence algorithm for mobile robots with limited visibility",
IEEE Transactions on Robotics and Automation 15(5), 1999, doi:10.1109/70.795787: while two robots both
stay in the disc of radius ``reach / 2`` about the point between them, they are never farther apart
than the reach.

Where we differ: a robot on tracks moves along its heading alone, so the layer limits its speed and turns it
towards those who are nearly lost; who is a tenth beyond the reach is lost, and does not count.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import ConnectivityConfig
from swarmvision.controllers.crowd import crowd
from swarmvision.controllers.law import Layer
from swarmvision.data import Commands, Senses

GONE = 1.1  # of the reach: a neighbour farther away is given up


def stay_in_sight(commands: Commands, senses: Senses, config: ConnectivityConfig) -> Commands:
    """Return the commands ``(...)`` with no more speed than keeps every neighbour within reach."""
    others = crowd(senses.neighbours, GONE * config.reach)
    horizon = max(config.horizon, senses.dt)
    way = np.where(commands.speed < 0.0, -1.0, 1.0)  # along which the robot goes
    half = others.distance / 2.0 * others.towards * way[..., None]
    # From inside the disc about the midpoint, straight on to its edge.
    room = half.real + np.sqrt(np.maximum((config.reach / 2.0) ** 2 - half.imag**2, 0.0))
    room = np.where(others.counts, np.maximum(room, 0.0), np.inf)
    limit = np.min(room, axis=-1, initial=np.inf) / horizon
    speed = way * np.minimum(np.abs(commands.speed), limit)
    pressed = np.where(others.counts, np.maximum(1.0 - room / config.reach, 0.0), 0.0)
    lost = np.sum(pressed**2 * others.towards, axis=-1)
    back = config.turn_gain * way * lost.imag / np.maximum(np.abs(lost), 1.0)
    held = np.abs(speed) < np.abs(commands.speed)
    return Commands(speed, commands.turn_rate + np.where(held, back, 0.0))


LAYER = Layer(frozenset({"range", "bearing"}), stay_in_sight)
