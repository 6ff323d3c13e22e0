"""Settings of the laws from control theory, which come with a proof for ideal agents."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from swarmvision.config.controller.base import Alone, Gain, Range, Seconds, Speed
from swarmvision.config.model import Settings


class ParticleDrive(Settings):
    """How a robot follows a law that was made for particles that are accelerated at will."""

    speed: Speed = 0.10
    """Cruise speed, and the speed that neighbours are taken to have (m/s)."""

    top_speed: Speed = 0.20
    """m/s"""

    cruise_gain: Gain = 1.0
    """How fast the own speed returns to the cruise speed (1/s); ours, for a swarm without a goal."""

    look_ahead: Range = 0.06
    """The point that obeys the law lies this far ahead of the axle (m)."""

    horizon: Seconds = 0.2
    """Acceleration is asked for as the velocity after this time (s)."""


class OlfatiSaberConfig(ParticleDrive):
    """Flocking in a lattice, round obstacles, to a goal."""

    law: Literal["olfati-saber"] = "olfati-saber"

    desired_range: Range = 0.25
    """Range that neighbours keep, the paper's d = 7 (m); every other length follows from it."""

    position_gain: Gain = 1.0
    """Of the lattice, the paper's c1 of alpha agents (1/s^2)."""

    velocity_gain: Gain = 2.0
    """Of matching velocities, c2 of alpha agents (1/s)."""

    obstacle_gain: Gain = 4.5
    """Of obstacles, c1 of beta agents (1/s^2)."""

    obstacle_damping: Gain = 4.2
    """Of the speed towards them, c2 of beta agents (1/s)."""

    goal_gain: Gain = 1.2
    """Of the goal, c1 of the gamma agent (1/s^2)."""

    goal_damping: Gain = 2.2
    """Of the speed, for those who know the goal, c2 of the gamma agent (1/s)."""

    alone: Alone = "keep"
    """With nobody in sight, no goal and no obstacle."""


class TannerConfig(ParticleDrive):
    """Match velocities, and descend a potential of the ranges."""

    law: Literal["tanner"] = "tanner"

    topology: Literal["dynamic", "fixed"] = "dynamic"
    """Whether neighbours are all within reach now, or those that were when the run began."""

    desired_range: Range = 0.25
    """Range at which the potential is least (m)."""

    reach: Range = 0.50
    """Neighbours farther away do not count, or are not taken at first (m)."""

    velocity_gain: Gain = 2.0
    """Of matching velocities (1/s)."""

    potential_gain: Gain = 0.03
    """Of the potential (m^2/s^2)."""

    force_limit: Gain = 0.5
    """Largest acceleration by the potential of one neighbour (m/s^2)."""

    alone: Alone = "keep"
    """With no neighbour."""


class MoshtaghConfig(Settings):
    """Align without seeing headings: from how bearings turn and how neighbours loom."""

    law: Literal["moshtagh"] = "moshtagh"

    speed: Speed = 0.10
    """Constant speed (m/s)."""

    alignment_gain: Gain = 1.5
    """Turn rate for a neighbour that faces 90 deg away, the paper's kappa (rad/s)."""

    smoothing: Seconds = 0.4
    """Time over which rates of bearing and range are smoothed (s)."""

    reach: Range = 1.0
    """Neighbours farther away are ignored (m)."""

    proximal_gain: Gain = 1.5
    """Turn rate and share of the speed for a full pull or push; ours, 0 is the paper's law alone (rad/s)."""

    desired_range: Range = 0.25
    """Range that neighbours keep (m)."""

    contact_range: Range = 0.12
    """Range at which the push is fully felt (m)."""

    alone: Alone = "keep"
    """With nobody in sight."""

    @model_validator(mode="after")
    def _ranges_ascend(self) -> MoshtaghConfig:
        if not self.contact_range < self.desired_range < self.reach:
            raise ValueError(
                "contact_range < desired_range < reach (m) must hold, "
                f"got {self.contact_range}, {self.desired_range}, {self.reach}"
            )
        return self


ConsensusLaw = MoshtaghConfig | OlfatiSaberConfig | TannerConfig
