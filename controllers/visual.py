"""Purely visual flocking: no ranges, no bearings, nobody told from anybody.

Source: R. Bastien, P. Romanczuk, "A model of collective behavior based purely on vision", Science Advances
6(6), 2020, doi:10.1126/sciadv.aay0792: with ``V(phi)`` 1 where a robot is seen, and ``phi_e`` its edges,

    v' = gamma (v0 - v) + alpha0 (-int cos(phi) V dphi + alpha1 sum cos(phi_e))
    w  =                  beta0  (-int sin(phi) V dphi + beta1  sum sin(phi_e))

What is wide pushes, edges pull: ``atan(alpha1)`` is the half width of a robot ahead at rest.

Where we differ: the terms in the rate of ``V``, which the paper leaves at 0, are left out; the speed is
limited. The gains are ours, for a marker of a Zumo's size.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import VisualConfig
from swarmvision.controllers.crowd import ComplexArray
from swarmvision.controllers.law import reflex_of_senses
from swarmvision.controllers.motion import with_alone
from swarmvision.data import BoolArray, Commands, Senses


def flock(senses: Senses, config: VisualConfig) -> Commands:
    """Return the commands of robots from silhouettes.

    Args:
        senses: Shape ``(...)``; a silhouette of no directions is nobody in sight.
        config: Gains and the weights of edges.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    area, edges = view(senses.silhouette)
    push = config.speed_gain * (config.speed_edges * edges.real - area.real)
    acceleration = config.relaxation * (config.speed - senses.speed) + push
    speed = np.clip(senses.speed + senses.dt * acceleration, -config.top_speed, config.top_speed)
    turn_rate = config.turn_gain * (config.turn_edges * edges.imag - area.imag)
    anybody = np.any(senses.silhouette, axis=-1)
    return with_alone(Commands(speed, turn_rate), anybody, config.alone, config.speed)


def view(silhouette: BoolArray) -> tuple[ComplexArray, ComplexArray]:
    """Return the integral of ``exp(i phi) V`` and the sum of ``exp(i phi)`` over the edges, ``(...)``.

    Args:
        silhouette: Sectors of the horizon, from straight behind to the left, shape ``(..., p)``.
    """
    sectors = silhouette.shape[-1]
    width = 2.0 * np.pi / max(sectors, 1)
    begins = np.exp(1j * (-np.pi + width * np.arange(sectors)))
    # The integral of exp(i phi) over a sector, exactly.
    inside = begins * (np.exp(1j * width) - 1.0) / 1j
    changes = silhouette != np.roll(silhouette, 1, axis=-1)
    return np.sum(silhouette * inside, axis=-1), np.sum(changes * begins, axis=-1)


LAW = reflex_of_senses(flock, VisualConfig, {"silhouette", "motion"})
