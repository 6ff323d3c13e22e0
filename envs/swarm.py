"""A PettingZoo environment around the simulation: agents command, the loop is the simulation's.

Observations and actions: :mod:`swarmvision.envs.observation`. All robots stay to the end and are truncated
together; randomness comes from ``reset(seed=...)`` alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import gymnasium
import numpy as np
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from swarmvision.config.scenario import ScenarioConfig, packaged_scenario
from swarmvision.data import Estimates, Scene
from swarmvision.drawing.topview import TopView
from swarmvision.drive import Drive
from swarmvision.envs.observation import SIZE, Observation, commanded, limited, observe
from swarmvision.errors import ConfigError
from swarmvision.geometry import FloatArray
from swarmvision.simulation import Simulation

RENDER_PX = 480
Rewarded = tuple[FloatArray, dict[str, FloatArray]]
Reward = Callable[[FloatArray, FloatArray, FloatArray, Any], Rewarded]
"""``(pose (..., r, 3), velocity (..., r, 3), change of actions (..., r, 2), contacts begun (...))`` to each
robot's reward and its named parts, ``(..., r)``."""


class SwarmEnv(ParallelEnv):  # type: ignore[misc]
    """What the environments share; a task adds its reward."""

    metadata: ClassVar[dict[str, Any]] = {
        "render_modes": ["rgb_array"],
        "name": "swarm",
        "is_parallelizable": True,
        "render_fps": 10,
    }

    def __init__(
        self, scenario: ScenarioConfig, *, max_cycles: int = 600, render_mode: str | None = None
    ) -> None:
        """Prepare spaces; nothing runs before :meth:`reset`.

        Args:
            scenario: Robots, arena and sensor; its controller is not used.
            max_cycles: Control steps until all are truncated.
            render_mode: ``rgb_array`` or None.

        Raises:
            ConfigError: If the render mode is unknown or there is no robot.
        """
        if render_mode not in (None, "rgb_array"):
            raise ConfigError(f"render_mode must be 'rgb_array' or None, got {render_mode!r}")
        if scenario.robots < 1:
            raise ConfigError(f"an environment needs at least one robot, got {scenario.robots}")
        self.scenario = scenario
        self.max_cycles = max_cycles
        self.render_mode = render_mode
        self.possible_agents = [f"robot_{i}" for i in range(scenario.robots)]
        self.agents: list[str] = []
        self._observation = gymnasium.spaces.Box(-1.0, 1.0, (SIZE,), np.float32)
        self._action = gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.state_space = gymnasium.spaces.Box(-1.0, 1.0, (7 * scenario.robots,), np.float32)
        self._drive = Drive.from_config(scenario.robot)
        self._seeds = np.random.default_rng()
        self._simulation: Simulation | None = None
        self._view: TopView | None = None

    def observation_space(self, agent: str) -> gymnasium.spaces.Box:
        """Return the space of one agent's observations; the same object every time."""
        return self._observation

    def action_space(self, agent: str) -> gymnasium.spaces.Box:
        """Return the space of one agent's actions; the same object every time."""
        return self._action

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begin an episode; without a seed the next of the sequence that the last seed began."""
        if seed is not None:
            self._seeds = np.random.default_rng(seed)
        self.agents = list(self.possible_agents)
        self._simulation = Simulation(self.scenario, int(self._seeds.integers(1 << 31)))
        self._view = None
        self._cycle = 0
        self._last = np.zeros((len(self.agents), 2))
        self._contacts = 0
        rows = self._observed(self._simulation.sense())
        return dict(zip(self.agents, rows, strict=True)), {agent: {} for agent in self.agents}

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[
        dict[str, Observation],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """Drive all robots through one control period.

        Raises:
            PhysicsError: If an action is not finite.
        """
        simulation = self._running()
        agents = self.agents
        if not agents:
            return {}, {}, {}, {}, {}
        wanted = np.array([np.asarray(actions[agent], dtype=np.float64) for agent in agents])
        wanted = limited(wanted)
        scene = simulation.act(commanded(wanted))
        change = wanted - self._last
        self._last = wanted
        self._cycle += 1
        rewards, parts = self.reward(scene, change, simulation.contacts - self._contacts)
        self._contacts = simulation.contacts
        rows = self._observed(simulation.sense())
        over = self._cycle >= self.max_cycles
        infos = {
            agent: {name: float(values[i]) for name, values in parts.items()}
            for i, agent in enumerate(agents)
        }
        if over:
            self.agents = []
        return (
            dict(zip(agents, rows, strict=True)),
            {agent: float(rewards[i]) for i, agent in enumerate(agents)},
            dict.fromkeys(agents, False),
            dict.fromkeys(agents, over),
            infos,
        )

    def reward(
        self, scene: Scene, change: FloatArray, contacts: int
    ) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Return each robot's reward ``(r,)`` and its named parts, from the truth.

        Args:
            scene: After the step.
            change: Of the actions since the last step, shape ``(r, 2)``.
            contacts: Begun in this step.
        """
        raise NotImplementedError

    def state(self) -> Observation:
        """Return the truth about all robots for a centralised critic, in [-1, 1], shape ``(7 r,)``."""
        scene = self._running().scene
        half = np.array([self.scenario.arena.width, self.scenario.arena.depth]) / 2.0
        yaw = scene.pose[:, 2:]
        velocity = scene.velocity / [1.0, 1.0, 10.0]
        columns = [scene.pose[:, :2] / half, np.cos(yaw), np.sin(yaw), velocity]
        flat: Observation = np.clip(np.hstack(columns), -1.0, 1.0).astype(np.float32).ravel()
        return flat

    def render(self) -> NDArray[np.uint8] | None:
        """Return the top view, ``(h, w, 3)`` uint8, in the mode ``rgb_array``."""
        if self.render_mode is None:
            return None
        if self._view is None:
            self._view = TopView(self.scenario.arena, self.scenario.robot, RENDER_PX, RENDER_PX)
        return self._view.draw(self._running().scene)

    def close(self) -> None:
        """Let go of the simulation."""
        self._simulation = None

    def _running(self) -> Simulation:
        if self._simulation is None:
            raise ConfigError("reset() must be called before the environment is used")
        return self._simulation

    def _observed(self, estimates: Estimates) -> Observation:
        """Return the observations of all robots, shape ``(r, SIZE)``."""
        speed, turn_rate = self._drive.twist(self._running().scene.wheel_speed)
        return observe(estimates, speed, turn_rate, self._last, self.scenario.sensor.reach)


def task_scenario(name: str, robots: int, sensor: str, overrides: tuple[str, ...]) -> ScenarioConfig:
    """Return a packaged scenario as the ground of a task.

    Args:
        name: Of the scenario.
        robots: How many.
        sensor: ``camera`` for the scenario's own cameras, ``error_model`` for what they would tell without
            pictures, ``truth`` for perfect sensing.
        overrides: As for ``swarmvision run --set``.
    """
    changes = [f"robots={robots}"]
    if sensor != "camera":
        changes.append(f'sensor={{kind="{sensor}"}}')
    return packaged_scenario(name, [*changes, *overrides])
