"""Align without seeing headings: from how bearings turn and how neighbours loom.

Source: N. Moshtagh, N. Michael, A. Jadbabaie, K. Daniilidis, "Vision-based, distributed control laws for
motion coordination of nonholonomic robots", IEEE Transactions on Robotics 25(4), 2009,
doi:10.1109/TRO.2009.2022439: ``w = kappa sum sin psi_j``, where the heading ``psi_j`` of a neighbour is not
measured but follows from bearing ``b``, its rate and the time to collision ``tau``. With equal speeds ``v``
the sideways part of the relative velocity gives ``v sin psi = r ((b' + w) cos b - sin b / tau)``, with
the own turn rate ``w`` and ``1 / tau = -r'/r``: no pattern on the marker is needed.

Where we differ: rates are differences of tracked estimates, smoothed; ranges are known, so each sine is
whole and not only up to the factor ``r``; the mean instead of the sum; a proximal force, which is ours, keeps
the robots together and apart.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from swarmvision.config.controller import MoshtaghConfig
from swarmvision.controllers.crowd import crowd
from swarmvision.controllers.law import Keys, Law
from swarmvision.controllers.motion import glide, with_alone
from swarmvision.controllers.proximal import proximal_force
from swarmvision.controllers.recall import earlier_slot, recalled, smoothed, tracked
from swarmvision.data import Commands, IntArray, Senses
from swarmvision.geometry import FloatArray, wrap


class Flow(NamedTuple):
    """What a robot saw last, by slot, shape ``(..., k)`` each."""

    track: IntArray
    """Track number, as :func:`tracked` gives it."""
    range: FloatArray
    """m"""
    bearing: FloatArray
    """rad"""
    line_rate: FloatArray
    """Turn rate of the line to the neighbour over ground (rad/s), smoothed; nan before the second look."""
    looming: FloatArray
    """Relative rate of the range, ``r'/r`` (1/s), smoothed; nan before the second look."""


def align(senses: Senses, flow: Flow, config: MoshtaghConfig) -> tuple[Commands, Flow]:
    """Return the commands of robots from ranges and bearings now and before.

    Args:
        senses: Shape ``(..., k)``; may be empty.
        flow: What was seen before.
        config: Gains and ranges.

    Returns:
        Before the limits of the drive, shape ``(...)``, and what is seen now.
    """
    others = crowd(senses.neighbours, config.reach)
    flow = _seen(senses, flow, config)
    sine = np.nan_to_num(sine_of_heading(flow, config.speed), nan=0.0)
    aligning = config.alignment_gain * others.mean(sine).real
    force = others.mean(proximal_force(others.distance, config) * others.towards)
    gains = (config.speed, config.proximal_gain)
    keeping = glide(force.real, force.imag, config.speed, 2.0 * config.speed, gains)
    commands = Commands(keeping.speed, keeping.turn_rate + aligning)
    return with_alone(commands, others.anybody, config.alone, config.speed), flow


def sine_of_heading(flow: Flow, speed: float) -> FloatArray:
    """Return the sine of each neighbour's heading, if it goes at ``speed`` (m/s); nan where not known."""
    sideways = flow.line_rate * np.cos(flow.bearing) + flow.looming * np.sin(flow.bearing)
    return np.clip(flow.range * sideways / speed, -1.0, 1.0)


def _seen(senses: Senses, before: Flow, config: MoshtaghConfig) -> Flow:
    others = crowd(senses.neighbours, np.inf)
    track, bearing = tracked(senses, others), np.angle(others.towards)
    slot = earlier_slot(track, before.track)
    turned = wrap(bearing - recalled(before.bearing, slot)) / senses.dt
    line_rate = turned + senses.turn_rate[..., None]
    looming = (others.distance / recalled(before.range, slot) - 1.0) / senses.dt
    return Flow(
        track,
        others.distance,
        bearing,
        smoothed(recalled(before.line_rate, slot), line_rate, senses, config.smoothing),
        smoothed(recalled(before.looming, slot), looming, senses, config.smoothing),
    )


def begin(config: MoshtaghConfig, keys: Keys) -> Flow:
    """Return that nothing was seen."""
    nothing = np.zeros((*keys.shape, 0))
    return Flow(np.zeros((*keys.shape, 0), dtype=np.int64), nothing, nothing, nothing, nothing)


LAW = Law(MoshtaghConfig, frozenset({"range", "bearing", "motion"}), align, begin)
