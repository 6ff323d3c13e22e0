"""Simulators of swarms by others: each a call that advances all robots by one step."""

from __future__ import annotations

from contextlib import ExitStack

from swarmvision.benchmark.timing import Call


def vmas(_: ExitStack, worlds: int, robots: int) -> Call:
    """Return a step of VMAS's scenario ``flocking`` on one core, rewards and observations included."""
    import torch
    import vmas as library

    torch.set_num_threads(1)
    environment = library.make_env(
        scenario="flocking", num_envs=worlds, device="cpu", continuous_actions=True, seed=0, n_agents=robots
    )
    environment.reset()
    actions = [environment.get_random_action(agent) for agent in environment.agents]
    return lambda: environment.step(actions)
