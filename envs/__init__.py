"""PettingZoo environments around the simulation; importing this room registers them.

``pettingzoo.make("parallel", "swarmvision/flocking-v0")`` and
``swarmvision.envs.flocking_v0.parallel_env()`` give the same.
"""

from pettingzoo import register

from swarmvision.envs import aggregation_v0, flocking_v0

register("parallel", "swarmvision/flocking-v0", entry_point=flocking_v0.parallel_env)
register("parallel", "swarmvision/aggregation-v0", entry_point=aggregation_v0.parallel_env)

__all__ = ["aggregation_v0", "flocking_v0"]
