"""What a robot's body tells beside its neighbours: its own motion, what is close, the goal, the ground.

All but the proximity ring is true: encoders, compass and ground sensor are not what this project studies.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from swarmvision.config.scenario import ScenarioConfig
from swarmvision.data import Estimates, Scene, Senses
from swarmvision.drive import Drive
from swarmvision.geometry import FloatArray, rotate
from swarmvision.sensing.proximity import ProximityRing


class Body:
    """The senses of all robots' bodies."""

    def __init__(self, scenario: ScenarioConfig, seed: int = 0) -> None:
        self._drive = Drive.from_config(scenario.robot)
        self._cues = scenario.arena.cues
        self._goal = scenario.goal
        self._dt = 1.0 / scenario.control_hz
        self._ring = (
            ProximityRing(scenario.proximity, scenario.robot, scenario.arena, seed)
            if scenario.proximity is not None
            else None
        )
        share = scenario.goal.informed if scenario.goal is not None else 0.0
        self._informed = math.ceil(share * scenario.team_sizes[0])

    def feel(self, scene: Scene, neighbours: Estimates) -> Senses:
        """Return all that the robots know in a scene, given what they see of each other, ``(r, k)``."""
        speed, turn_rate = self._drive.twist(scene.wheel_speed)
        near: dict[str, Any] = {}
        if self._ring is not None:
            near["proximity"], near["proximity_robot"] = self._ring.sense(scene)
        return Senses.of(
            neighbours,
            self._dt,
            speed=speed,
            turn_rate=turn_rate,
            goal=self._goal_seen(scene),
            cue=self.cue(scene.pose[:, :2]),
            **near,
        )

    def cue(self, place: FloatArray) -> FloatArray:
        """Return what a ground sensor reads at places ``(..., 2)`` (m), 0..1, shape ``(...)``."""
        reading = np.zeros(place.shape[:-1])
        for cue in self._cues:
            distance = np.hypot(place[..., 0] - cue.x, place[..., 1] - cue.y)
            reading = np.maximum(reading, cue.strength * np.maximum(1.0 - distance / cue.radius, 0.0))
        return reading

    def _goal_seen(self, scene: Scene) -> FloatArray:
        goal = np.full((scene.robots, 2), np.nan)
        if self._goal is not None:
            some = slice(self._informed)
            offset = (self._goal.x, self._goal.y) - scene.pose[some, :2]
            goal[some] = rotate(offset, -scene.pose[some, 2])
        return goal
