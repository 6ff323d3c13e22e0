"""What robots do with what they see: one settings model for each law, told apart by ``law``.

A law is declared in the module of its family and joins that family's union; this file joins the families.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from swarmvision.config.controller.base import Alone
from swarmvision.config.controller.custom import CustomConfig
from swarmvision.config.controller.flocking import FlockingLaw, KobotConfig
from swarmvision.config.controller.gathering import CohesionConfig, GatheringLaw, GauciConfig
from swarmvision.config.controller.layers import AvoidanceConfig, LayerConfig

ControllerConfig = Annotated[FlockingLaw | GatheringLaw | CustomConfig, Field(discriminator="law")]

__all__ = [
    "Alone",
    "AvoidanceConfig",
    "CohesionConfig",
    "ControllerConfig",
    "CustomConfig",
    "GauciConfig",
    "KobotConfig",
    "LayerConfig",
]
