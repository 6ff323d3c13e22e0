"""What robots do with what they see: one settings model for each law, told apart by ``law``.

A law is declared in the module of its family and joins that family's union; this file joins the families.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from swarmvision.config.controller.base import Alone
from swarmvision.config.controller.consensus import (
    ConsensusLaw,
    MoshtaghConfig,
    OlfatiSaberConfig,
    ParticleDrive,
    TannerConfig,
)
from swarmvision.config.controller.custom import CustomConfig
from swarmvision.config.controller.flocking import (
    ElasticConfig,
    FerranteConfig,
    FlockingLaw,
    InformedConfig,
    KobotConfig,
)
from swarmvision.config.controller.formation import ChainConfig, FormationLaw, HanadaConfig, SpearsConfig
from swarmvision.config.controller.gathering import (
    BeeclustConfig,
    CohesionConfig,
    GatheringLaw,
    GauciConfig,
    SoysalConfig,
)
from swarmvision.config.controller.layers import AvoidanceConfig, ConnectivityConfig, LayerConfig
from swarmvision.config.controller.particles import (
    CouzinConfig,
    GregoireConfig,
    ParticleLaw,
    RandomWalkConfig,
    VicsekConfig,
)
from swarmvision.config.controller.tasks import DogConfig, SheepConfig, TaskLaw, TransportConfig
from swarmvision.config.controller.visual import FollowConfig, VisualConfig, VisualLaw

ControllerConfig = Annotated[
    ConsensusLaw
    | CustomConfig
    | FlockingLaw
    | FormationLaw
    | GatheringLaw
    | ParticleLaw
    | TaskLaw
    | VisualLaw,
    Field(discriminator="law"),
]

__all__ = [
    "Alone",
    "AvoidanceConfig",
    "BeeclustConfig",
    "ChainConfig",
    "CohesionConfig",
    "ConnectivityConfig",
    "ControllerConfig",
    "CouzinConfig",
    "CustomConfig",
    "DogConfig",
    "ElasticConfig",
    "FerranteConfig",
    "FollowConfig",
    "GauciConfig",
    "GregoireConfig",
    "HanadaConfig",
    "InformedConfig",
    "KobotConfig",
    "LayerConfig",
    "MoshtaghConfig",
    "OlfatiSaberConfig",
    "ParticleDrive",
    "RandomWalkConfig",
    "SheepConfig",
    "SoysalConfig",
    "SpearsConfig",
    "TannerConfig",
    "TransportConfig",
    "VicsekConfig",
    "VisualConfig",
]
