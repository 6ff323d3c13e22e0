"""Which law a configuration names."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import assert_never

from swarmvision.config.controller import CohesionConfig, ControllerConfig, GauciConfig, KobotConfig
from swarmvision.controllers.cohesion import gather
from swarmvision.controllers.gauci import aggregate
from swarmvision.controllers.kobot import flock
from swarmvision.data import Commands, Estimates

Controller = Callable[[Estimates], Commands]


def controller(config: ControllerConfig) -> Controller:
    """Return the law that a configuration names, with its gains."""
    match config:
        case KobotConfig():
            return partial(flock, config=config)
        case GauciConfig():
            return partial(aggregate, config=config)
        case CohesionConfig():
            return partial(gather, config=config)
    assert_never(config)
