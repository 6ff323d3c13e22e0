"""The robot: a Pololu Zumo with a marker on a mast.

That it is a Zumo, tracked and under 10 cm on each side, is the paper's word (Majidi Balanji et al.);
length, width and track follow Pololu's drawing of the chassis. Mass with computer and camera, wheel
speed, motor lag, slip and frictions are start values of ours: measure your own robot and set them.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from swarmvision.config.marker import MarkerConfig
from swarmvision.config.model import Settings

Length = Annotated[float, Field(gt=0, le=2)]


class RobotConfig(Settings):
    """Body, drive and marker of every robot of a swarm."""

    length: Length = 0.098
    """Along x (m)."""

    width: Length = 0.098
    """Across (m)."""

    body_height: Length = 0.044
    """Of the chassis above the ground (m)."""

    mast_radius: Annotated[float, Field(ge=0, le=1)] = 0.008
    """Of the rod between chassis and marker (m)."""

    mass: Annotated[float, Field(gt=0, le=100)] = 0.5
    """With battery, computer and camera (kg)."""

    track: Length = 0.085
    """Between the centre lines of the two tracks (m)."""

    max_wheel_speed: Annotated[float, Field(gt=0, le=5)] = 0.4
    """m/s"""

    motor_time_constant: Annotated[float, Field(ge=0, le=5)] = 0.06
    """First-order lag of the wheels (s)."""

    turn_slip: Annotated[float, Field(ge=0, lt=1)] = 0.1
    """Fraction of turn rate that the tracks lose by scrubbing."""

    traction: Annotated[float, Field(gt=0, le=5)] = 0.8
    """Coulomb friction of the tracks on the floor; the most that they can pull is this times the weight."""

    friction: Annotated[float, Field(ge=0, le=5)] = 0.4
    """Coulomb friction of the body against bodies and walls."""

    marker: MarkerConfig = MarkerConfig()
    """What the robot carries."""
