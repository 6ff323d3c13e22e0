"""Which law a configuration names, and what lies under it."""

from __future__ import annotations

from collections.abc import Sequence

from swarmvision.config.controller import (
    AvoidanceConfig,
    ConnectivityConfig,
    ControllerConfig,
    CustomConfig,
    LayerConfig,
)
from swarmvision.controllers.avoidance import LAYER as AVOIDANCE
from swarmvision.controllers.beeclust import LAW as BEECLUST
from swarmvision.controllers.chain import LAW as CHAIN
from swarmvision.controllers.cohesion import LAW as COHESION
from swarmvision.controllers.connectivity import LAYER as CONNECTIVITY
from swarmvision.controllers.couzin import LAW as COUZIN
from swarmvision.controllers.custom import custom_law
from swarmvision.controllers.dog import LAW as DOG
from swarmvision.controllers.elastic import LAW as ELASTIC
from swarmvision.controllers.ferrante import LAW as FERRANTE
from swarmvision.controllers.follow import LAW as FOLLOW
from swarmvision.controllers.gauci import LAW as GAUCI
from swarmvision.controllers.gregoire import LAW as GREGOIRE
from swarmvision.controllers.hanada import LAW as HANADA
from swarmvision.controllers.informed import LAW as INFORMED
from swarmvision.controllers.kobot import LAW as KOBOT
from swarmvision.controllers.law import Controller, Keys, Law, Memory
from swarmvision.controllers.moshtagh import LAW as MOSHTAGH
from swarmvision.controllers.olfati_saber import LAW as OLFATI_SABER
from swarmvision.controllers.random_walk import LAW as RANDOM_WALK
from swarmvision.controllers.sheep import LAW as SHEEP
from swarmvision.controllers.soysal import LAW as SOYSAL
from swarmvision.controllers.spears import LAW as SPEARS
from swarmvision.controllers.tanner import LAW as TANNER
from swarmvision.controllers.transport import LAW as TRANSPORT
from swarmvision.controllers.vicsek import LAW as VICSEK
from swarmvision.controllers.visual import LAW as VISUAL
from swarmvision.data import Commands, Senses

_LAWS = (
    BEECLUST,
    CHAIN,
    COHESION,
    COUZIN,
    DOG,
    ELASTIC,
    FERRANTE,
    FOLLOW,
    GAUCI,
    GREGOIRE,
    HANADA,
    INFORMED,
    KOBOT,
    MOSHTAGH,
    OLFATI_SABER,
    RANDOM_WALK,
    SHEEP,
    SOYSAL,
    SPEARS,
    TANNER,
    TRANSPORT,
    VICSEK,
    VISUAL,
)

LAWS: dict[str, Law] = {law.config.model_fields["law"].default: law for law in _LAWS}
"""Our own laws by name."""

LAYERS = {AvoidanceConfig: AVOIDANCE, ConnectivityConfig: CONNECTIVITY}


def controller(config: ControllerConfig, layers: Sequence[LayerConfig] = ()) -> Controller:
    """Return the law that a configuration names, with its gains, over the given layers, the lowest last.

    Raises:
        ConfigError: If a custom law cannot be had.
    """
    law = custom_law(config) if isinstance(config, CustomConfig) else LAWS[config.law]
    under = [(LAYERS[type(layer)], layer) for layer in layers]

    def begin(keys: Keys) -> Memory:
        return law.begin(config, keys)

    def step(senses: Senses, memory: Memory) -> tuple[Commands, Memory]:
        commands, memory = law.step(senses, memory, config)
        for layer, settings in under:
            commands = layer.correct(commands, senses, settings)
        return commands, memory

    inputs = frozenset(law.inputs).union(*(layer.inputs for layer, _ in under))
    return Controller(inputs, begin, step)
