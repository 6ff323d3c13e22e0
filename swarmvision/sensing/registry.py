"""From a sensor's settings to the sensor."""

from __future__ import annotations

from collections.abc import Collection

from swarmvision.config.scenario import ScenarioConfig
from swarmvision.config.sensor import (
    CameraSensorConfig,
    DeliveryConfig,
    ErrorModelSensorConfig,
    InfraredRingSensorConfig,
    InfraredSensorConfig,
    SensorConfig,
    TruthSensorConfig,
    UltrasonicSensorConfig,
)
from swarmvision.sensing.camera import CameraSensor
from swarmvision.sensing.delivery import Delivery
from swarmvision.sensing.error_model import ErrorModelSensor
from swarmvision.sensing.infrared import InfraredSensor
from swarmvision.sensing.infrared_ring import InfraredRingSensor
from swarmvision.sensing.protocol import Sensor
from swarmvision.sensing.truth import TruthSensor
from swarmvision.sensing.ultrasonic import UltrasonicSensor

AT_ONCE = DeliveryConfig()
NEXT = 0.999  # of a picture's period: just before the next one


def sensor_of(
    config: SensorConfig,
    scenario: ScenarioConfig,
    seed: int,
    *,
    keep_pictures: bool = False,
    workers: int | None = None,
    idle: Collection[int] = (),
) -> Sensor:
    """Return the sensor of all robots of a scenario.

    Args:
        config: Which, and how good; the scenario's own or a team's.
        scenario: Robots and arena.
        seed: Of the run.
        keep_pictures: Whether a camera keeps its pictures.
        workers: Threads of a camera; changes no result.
        idle: Robots whom nobody asks what they see; they take no pictures.
    """
    if isinstance(config, CameraSensorConfig):
        return CameraSensor(
            config,
            scenario.robot,
            scenario.arena,
            scenario.robots,
            seed,
            keep_pictures=keep_pictures,
            workers=workers,
            idle=idle,
        )
    if isinstance(config, ErrorModelSensorConfig):  # lateness and memory are part of its tables
        return ErrorModelSensor(config, scenario.robot, scenario.arena, scenario.robots, seed)
    sensor = _reading(config, scenario, seed)
    return Delivery(sensor, config, scenario.robot, seed) if has_own_way(config) else sensor


def has_own_way(config: DeliveryConfig) -> bool:
    """Return whether readings are late, lost, remembered or from broken sensors."""
    return any(getattr(config, name) != getattr(AT_ONCE, name) for name in DeliveryConfig.model_fields)


def newest_age(config: SensorConfig) -> float:
    """Return the age (s) up to which an estimate is of the newest reading that can have arrived.

    A picture's neighbours are as old as its latency, and stay the newest until the next picture.
    """
    rate_hz: float | None = getattr(config, "rate_hz", None)  # a camera's
    latency: float = getattr(config, "latency", 0.0)
    return latency + (NEXT / rate_hz if rate_hz is not None else 0.0)


def _reading(config: DeliveryConfig, scenario: ScenarioConfig, seed: int) -> Sensor:
    robot, arena = scenario.robot, scenario.arena
    match config:
        case InfraredSensorConfig():
            return InfraredSensor(config, robot, arena, seed, scenario.team_sizes)
        case UltrasonicSensorConfig():
            return UltrasonicSensor(config, robot, arena, seed, scenario.team_sizes)
        case InfraredRingSensorConfig():
            return InfraredRingSensor(config, robot, arena, seed)
        case TruthSensorConfig():
            return TruthSensor(config, robot, arena, scenario.team_sizes)
    raise TypeError(f"no sensor for {type(config).__name__}")
