"""Settings of the law that sees silhouettes alone, and of the law that follows."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from swarmvision.config.controller.base import Alone, Gain, Range, Speed
from swarmvision.config.model import Settings


class VisualConfig(Settings):
    """Purely visual flocking: speed and turn rate from where a robot is seen, and where its edges are."""

    law: Literal["visual"] = "visual"

    speed: Annotated[float, Field(ge=0, le=5)] = 0.10
    """That the robot returns to, the paper's v0 (m/s)."""

    relaxation: Gain = 0.5
    """How fast it returns to it, the paper's gamma (1/s)."""

    speed_gain: Gain = 0.6
    """Of the speed on the view, the paper's alpha0 (m/s^2)."""

    turn_gain: Gain = 3.0
    """Of the turn rate on the view, the paper's beta0 (rad/s)."""

    speed_edges: Gain = 0.08
    """Weight of edges against areas for the speed, the paper's alpha1: tan of half the width at rest."""

    turn_edges: Gain = 0.08
    """The same for the turn rate, the paper's beta1."""

    top_speed: Speed = 0.20
    """m/s"""

    alone: Alone = "keep"
    """With nobody in sight."""


class FollowConfig(Settings):
    """Follow the neighbour ahead, and so make columns."""

    law: Literal["follow"] = "follow"

    speed: Speed = 0.10
    """Speed at the wanted range (m/s)."""

    top_speed: Speed = 0.18
    """m/s"""

    desired_range: Range = 0.25
    """Behind the neighbour that is followed (m)."""

    range_gain: Gain = 0.8
    """Of the speed on the deviation from that range (1/s)."""

    turn_gain: Gain = 2.0
    """Of the turn rate on the bearing (1/s)."""

    cone_deg: Annotated[float, Field(gt=0, le=360)] = 120.0
    """Only neighbours within this field ahead are followed (deg)."""

    reach: Range = 1.0
    """Neighbours farther away are not followed (m)."""

    same_way_deg: Annotated[float, Field(gt=0, le=180)] = 100.0
    """Who is known to face farther away than this from the own heading is not followed (deg)."""

    clearance: Range = 0.18
    """Range below which anybody pushes (m)."""

    push_gain: Gain = 1.5
    """Turn rate away from who is nearly touched (rad/s)."""

    alone: Alone = "scan"
    """With nobody to follow."""


VisualLaw = FollowConfig | VisualConfig
