"""What a robot's body tells beside its neighbours: its own motion, what is close, the goal, the ground.

All but the proximity ring is true: encoders, compass and ground sensor are not what this project studies.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from swarmvision.config.scenario import GoalConfig, ScenarioConfig
from swarmvision.data import BoolArray, Estimates, Scene, Senses
from swarmvision.drive import Drive
from swarmvision.geometry import FloatArray, compose, inverse, polar, rotate
from swarmvision.sensing.proximity import ProximityRing
from swarmvision.sensing.shadows import thing_shadow
from swarmvision.sensing.sight import View


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
        self._view = View.of(scenario.robot, scenario.arena, np.inf, 2.0 * np.pi)
        self._loads = [i for i, thing in enumerate(scenario.arena.objects) if thing.mass is not None]
        share = scenario.goal.informed if scenario.goal is not None else 0.0
        self._informed = math.ceil(share * scenario.team_sizes[0])

    def feel(self, scene: Scene, neighbours: Estimates) -> Senses:
        """Return all that the robots know in a scene, given what they see of each other, ``(r, k)``."""
        speed, turn_rate = self._drive.twist(scene.wheel_speed)
        more: dict[str, Any] = {}
        if self._ring is not None:
            more["proximity"], more["proximity_robot"] = self._ring.sense(scene)
        if self._goal is not None:
            more["goal"] = self._goal_seen(scene, self._goal)
        if self._cues:
            more["cue"] = self.cue(scene.pose[:, :2])
        if self._loads:
            more["load"] = self._nearest_load(scene)
        return Senses.of(
            neighbours,
            self._dt,
            speed=speed,
            turn_rate=turn_rate,
            **more,
        )

    def cue(self, place: FloatArray) -> FloatArray:
        """Return what a ground sensor reads at places ``(..., 2)`` (m), 0..1, shape ``(...)``."""
        reading = np.zeros(place.shape[:-1])
        for cue in self._cues:
            distance = np.hypot(place[..., 0] - cue.x, place[..., 1] - cue.y)
            reading = np.maximum(reading, cue.strength * np.maximum(1.0 - distance / cue.radius, 0.0))
        return reading

    def _goal_seen(self, scene: Scene, there: GoalConfig) -> FloatArray:
        goal = np.full((scene.robots, 2), np.nan)
        some = slice(self._informed)
        goal[some] = rotate((there.x, there.y) - scene.pose[some, :2], -scene.pose[some, 2])
        if there.occlusion:
            goal[self._hidden(scene, goal)] = np.nan
        return goal

    def _hidden(self, scene: Scene, goal: FloatArray) -> BoolArray:
        """Return whether a thing stands between a robot and the goal ``(r, 2)`` that it knows, ``(r,)``."""
        distance, bearing, _ = polar(np.column_stack([goal, np.zeros(scene.robots)]))
        hidden = np.zeros(scene.robots, dtype=bool)
        for number, length, width in self._view.things:
            place = compose(inverse(scene.pose), scene.object_pose[int(number)])
            for robot in np.flatnonzero(np.isfinite(distance)):
                x, y, yaw = place[robot]
                shadow = thing_shadow(bearing[robot], 0.0, distance[robot], x, y, yaw, length, width)
                hidden[robot] |= shadow != 0
        return hidden

    def _nearest_load(self, scene: Scene) -> FloatArray:
        """Return the place of the nearest thing that can be pushed, in each robot's frame, ``(r, 2)``."""
        offset = scene.object_pose[self._loads, :2] - scene.pose[:, None, :2]  # (r, loads, 2)
        nearest = np.argmin(np.hypot(offset[..., 0], offset[..., 1]), axis=1)
        return rotate(offset[np.arange(scene.robots), nearest], -scene.pose[:, 2])
