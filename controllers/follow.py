"""Follow the neighbour ahead, and so make columns: the flock that one forward camera can hold.

Source: range and bearing set points of a leader-follower pair as in A. K. Das, R. Fierro, V. Kumar,
J. P. Ostrowski, J. Spletzer, C. J. Taylor, "A vision-based formation control framework", IEEE Transactions
on Robotics and Automation 18(5), 2002, doi:10.1109/TRA.2002.803463.

Where we differ: nobody is appointed: a robot follows the nearest neighbour in a cone ahead that does not
come towards it; the leader's speed is taken as the cruise speed; the bearing's set point is 0, so that who is
followed stays in the middle of the picture; who comes too near pushes. The gains are ours.
"""

from __future__ import annotations

import numpy as np

from swarmvision.config.controller import FollowConfig
from swarmvision.controllers.crowd import crowd
from swarmvision.controllers.law import reflex
from swarmvision.controllers.motion import with_alone
from swarmvision.data import Commands, Estimates


def follow(estimates: Estimates, config: FollowConfig) -> Commands:
    """Return the commands of robots that follow.

    Args:
        estimates: Robot frame, shape ``(..., k)``; may be empty.
        config: Speeds, gains and ranges.

    Returns:
        Before the limits of the drive, shape ``(...)``.
    """
    others = crowd(estimates, config.reach)
    bearing = np.angle(others.towards)
    same_way = others.facing.real >= np.cos(np.radians(config.same_way_deg)) * np.abs(others.facing)
    ahead = np.abs(bearing) <= np.radians(config.cone_deg) / 2.0
    candidate = np.where(others.counts & same_way & ahead, others.distance, np.inf)
    nearest = np.min(candidate, axis=-1, initial=np.inf)
    chosen = np.isfinite(candidate) & (candidate == nearest[..., None])
    distance = np.where(np.isfinite(nearest), nearest, config.desired_range)
    # Two at one range count half each, so that their order does not matter.
    number = np.maximum(np.count_nonzero(chosen, axis=-1), 1)
    aim = np.angle(np.sum(np.where(chosen, others.towards, 0.0), axis=-1) / number)
    speed = config.speed + config.range_gain * (distance - config.desired_range) * np.cos(aim)
    pushed = np.clip(1.0 - others.distance / config.clearance, 0.0, 1.0)
    push = -others.total(pushed * others.towards)
    speed = np.clip(speed + config.speed * push.real, 0.0, config.top_speed)
    turn_rate = config.turn_gain * aim + config.push_gain * push.imag
    return with_alone(Commands(speed, turn_rate), np.isfinite(nearest), config.alone, config.speed)


LAW = reflex(follow, FollowConfig, {"range", "bearing", "heading"})
