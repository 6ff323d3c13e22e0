"""Many episodes of a task at once, as arrays: no dictionaries, no processes.

``w`` worlds of ``r`` robots are stepped together by :class:`swarmvision.worlds.Worlds`; observations,
actions and rewards mean what they mean in the PettingZoo environments of the same name. All episodes
are of one length; when they are over, the next ones have begun, and the observation is theirs.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from swarmvision.envs import aggregation_v0, flocking_v0
from swarmvision.envs.observation import SIZE, Observation, commanded, limited, observe
from swarmvision.envs.swarm import Reward, task_scenario
from swarmvision.errors import ConfigError, unknown_name
from swarmvision.geometry import FloatArray
from swarmvision.worlds import Worlds

REWARDS: dict[str, Reward] = {"aggregation": aggregation_v0.reward_of, "flocking": flocking_v0.reward_of}


class Step(NamedTuple):
    """What a step gives."""

    observation: Observation
    """Shape ``(w, r, SIZE)``."""
    reward: FloatArray
    """Shape ``(w, r)``."""
    over: bool
    """Whether the episodes are over and new ones have begun."""
    last: Observation | None
    """The last observation of those that are over, shape ``(w, r, SIZE)``."""


class VectorEnv:
    """``worlds`` episodes of a task."""

    def __init__(
        self,
        task: str,
        worlds: int,
        *,
        robots: int = 8,
        sensor: str = "error_model",
        max_cycles: int = 600,
        overrides: tuple[str, ...] = (),
    ) -> None:
        """Prepare; nothing runs before :meth:`reset`.

        Args:
            task: ``flocking`` or ``aggregation``.
            worlds: How many.
            robots: In each.
            sensor: ``error_model`` or ``truth``.
            max_cycles: Control steps of an episode.
            overrides: As for ``swarmvision run --set``.

        Raises:
            ConfigError: If there is no such task or robot, or many worlds do not have such a sensor.
        """
        if task not in REWARDS:
            raise ConfigError(unknown_name("task", task, REWARDS))
        if robots < 1:
            raise ConfigError(f"an environment needs at least one robot, got {robots}")
        self.scenario = task_scenario(task, robots, sensor, overrides)
        self.shape = (worlds, robots, SIZE)
        """Of the observations."""
        self.max_cycles = max_cycles
        self._reward = REWARDS[task]
        self._worlds: Worlds | None = None
        self._cycle = 0
        self._last = np.zeros((worlds, robots, 2))

    def reset(self, seed: int = 0) -> Observation:
        """Begin the first episodes of a seed; return what the robots see, shape ``(w, r, SIZE)``."""
        worlds = self._worlds = Worlds(self.scenario, self.shape[0], seed)
        self._begin()
        return self._observed(worlds)

    def step(self, actions: Any) -> Step:
        """Drive all robots of all worlds through one control period.

        Args:
            actions: Shape ``(w, r, 2)``, in [-1, 1].

        Raises:
            PhysicsError: If an action is not finite.
        """
        worlds = self._worlds
        if worlds is None:
            raise ConfigError("reset() must be called before the environment is used")
        wanted = limited(actions)
        change, before = wanted - self._last, worlds.contacts
        worlds.act(commanded(wanted))
        self._last = wanted
        self._cycle += 1
        reward, _ = self._reward(worlds.pose, worlds.velocity, change, worlds.contacts - before)
        observation = self._observed(worlds)
        if self._cycle < self.max_cycles:
            return Step(observation, reward, False, None)
        worlds.reset()
        self._begin()
        return Step(self._observed(worlds), reward, True, observation)

    def _begin(self) -> None:
        self._cycle = 0
        self._last = np.zeros((*self.shape[:2], 2))

    def _observed(self, worlds: Worlds) -> Observation:
        senses = worlds.feel(worlds.sense())
        reach = self.scenario.sensor.reach
        return observe(senses.neighbours, senses.speed, senses.turn_rate, self._last, reach)
