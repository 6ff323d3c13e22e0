"""What a run came to: noted step by step, summed up at the end.

Measures that cost the square of the robots are taken at every ``n``-th step only, ``n`` growing with them, so
that they cost a run of a thousand no more a step than ten runs of a hundred.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from swarmvision.data import Estimates, Scene
from swarmvision.geometry import FloatArray
from swarmvision.metrics.clusters import dispersion, in_largest_cluster, social_entropy
from swarmvision.metrics.groups import groups_of_links
from swarmvision.metrics.motion import contacts_per_robot_minute, displacement, path_efficiency, stuck
from swarmvision.metrics.order import milling, order
from swarmvision.metrics.perception import (
    UNKNOWN,
    PerceptionErrors,
    TrackSwitches,
    perception_errors,
    perception_table,
)

SETTLED = 0.2  # the last fifth of a run counts as its outcome
OFTEN = 100  # robots up to which everything is noted at every step
FOLLOWED = 2000  # robots up to which tracks are followed: a number for every pair
STUCK_WINDOW = 5.0  # s


class Ledger:
    """The course of one run."""

    def __init__(
        self, robots: int, reach: float, newest: float = 0.0, judged: Sequence[int] | None = None
    ) -> None:
        """Begin.

        Args:
            robots: How many.
            reach: Of their sensor (m): farther neighbours are not expected to be seen.
            newest: Age up to which an estimate is of the newest reading (s).
            judged: Numbers of the robots whose sensor the figures of perception are about; ``None`` for all.
        """
        self.scenes: list[Scene] = []
        self._robots, self._reach, self._newest = robots, reach, newest
        self._judged = np.ones(robots, np.bool_) if judged is None else np.isin(np.arange(robots), judged)
        self._every = max(round(robots / OFTEN), 1)
        self._errors: list[PerceptionErrors] = []
        self._switches = TrackSwitches(robots) if robots <= FOLLOWED else None
        self._connected: list[bool] = []
        self._seeing: list[int] = []

    def note(self, scene: Scene, estimates: Estimates) -> None:
        """Take in a scene and what was believed in it, robot frame, ``(r, k)``; in order of time."""
        if len(self.scenes) % self._every == 0:
            last = self._switches.last if self._switches is not None else UNKNOWN
            errors = perception_errors(scene.pose, estimates, self._reach, self._newest, last)
            self._errors.append(errors.by(self._judged))
            if self._switches is not None:
                self._switches.note(errors)
            seers, seen = errors.observer[errors.found], errors.neighbour[errors.found]
            self._connected.append(bool(np.all(groups_of_links(seers, seen, self._robots) == 0)))
            self._seeing.append(len(np.unique(seers)))
        self.scenes.append(scene)

    @property
    def time(self) -> FloatArray:
        """s, shape ``(t,)``."""
        return np.array([scene.time for scene in self.scenes])

    @property
    def pose(self) -> FloatArray:
        """Shape ``(t, r, 3)``."""
        return np.array([scene.pose for scene in self.scenes]).reshape(len(self.scenes), self._robots, 3)

    def order(self) -> FloatArray:
        """Return the polar order, shape ``(t,)``."""
        return order(self.pose[..., 2])

    def flock(self, link: float) -> tuple[FloatArray, FloatArray]:
        """Return the fraction of the robots in the largest cluster, 1 of nobody, and the polar order there.

        Args:
            link: Within which two robots are of one cluster (m).

        Returns:
            Shape ``(t,)`` each.
        """
        share, ordered = np.ones(len(self.scenes)), np.ones(len(self.scenes))
        for n, scene in enumerate(self.scenes):
            members = in_largest_cluster(scene.pose[:, :2], link)
            if len(members):
                share[n], ordered[n] = members.mean(), order(scene.pose[members, 2])
        return share, ordered

    def motion(self, contacts: int, body_radius: float) -> dict[str, Any]:
        """Return how the swarm moved; ``milling`` and ``dispersion`` over the last fifth.

        Args:
            contacts: Begun in the run.
            body_radius: Of a robot (m).
        """
        place = self.pose[..., :2]
        velocity = np.array([scene.velocity[:, :2] for scene in self.scenes]).reshape(place.shape)
        settled = slice(-max(round(SETTLED * len(place)), 1), None)
        blocked = self._stuck()
        return {
            "milling": float(milling(place[settled], velocity[settled]).mean()),
            "dispersion": float(dispersion(place[settled], body_radius).mean()),
            "social_entropy_final": social_entropy(place[-1]),
            "displacement": displacement(place),
            "path_efficiency": path_efficiency(place),
            "contacts_per_robot_minute": contacts_per_robot_minute(
                contacts, self._robots, float(self.time[-1])
            ),
            "stuck": int(np.count_nonzero(blocked[-1])),
            "stuck_share": float(blocked.mean()) if blocked.size else 0.0,
        }

    def perception(self) -> dict[str, Any]:
        """Return how well neighbours were seen; None where there was nobody, or too many, to follow.

        Missed neighbours, phantoms, and the table are those of the robots that are judged.
        ``missed`` is a share of the neighbours within reach, hidden ones among them; ``phantoms`` one of the
        estimates; ``connected`` one of the time, in which the graph of who sees whom held together.
        """
        wanted = sum(len(errors.found) for errors in self._errors)
        fresh = sum(errors.fresh for errors in self._errors)
        return {
            "missed": sum(errors.missed for errors in self._errors) / wanted if wanted else None,
            "phantoms": sum(errors.phantoms for errors in self._errors) / fresh if fresh else None,
            "track_switches": self._switches.count if self._switches is not None else None,
            "connected": float(np.mean(self._connected)),
            "blind": 1.0 - float(np.mean(self._seeing)) / self._robots if self._robots else 0.0,
            "perception": perception_table(self._errors),
        }

    def _stuck(self) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Return which robots were stuck in each stretch of ``STUCK_WINDOW``, shape ``(stretches, r)``."""
        place = self.pose[..., :2]
        travel = np.array([scene.wheel_travel for scene in self.scenes]).reshape(*place.shape[:2], 2)
        # Whole stretches, counted back from the end.
        seconds = self.time[-1] - self.time[0]
        stretches = max(int(seconds / STUCK_WINDOW), 1)
        length = (len(place) - 1) // stretches
        first = len(place) - 1 - stretches * length
        starts = [first + n * length for n in range(stretches)]
        return np.array([stuck(place[s : s + length + 1], travel[s : s + length + 1]) for s in starts])
