"""Range and bearing between robots by a signal from one to the other: what infrared and sound share.

Whom a signal reaches is line of sight (:mod:`swarmvision.sensing.sight`); what is measured has errors that
are normal, independent and without bias. A message names its sender, so a track is a robot's number and a
kind its team, and it may carry the sender's compass. A sensor adds whose signals arrive.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmvision.config.sensor import RangingConfig
from swarmvision.data import BoolArray, Estimates, IntArray, Picture, Scene
from swarmvision.geometry import FloatArray, wrap
from swarmvision.randomness import RobotKeys, Subsystem, normal
from swarmvision.sensing.sight import BEARING, HEADING, RANGE, VISIBLE, View
from swarmvision.sensing.truth import Teams, sight

NEAREST = 1e-3  # m; no reading is nearer


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviations of a reading."""

    range: float
    """m"""
    range_share: float
    """Of the range; the greater of the two counts."""
    bearing: float
    """rad"""
    heading: float | None
    """rad; None where no heading is told."""

    @classmethod
    def of(cls, config: RangingConfig, range_noise: float, range_share: float) -> Spread:
        """Return the spread of a range that a sensor tells in its own way, and of the angles."""
        heading = float(np.radians(config.heading_noise_deg)) if config.heading else None
        return cls(range_noise, range_share, float(np.radians(config.bearing_noise_deg)), heading)


class RangingSensor(ABC):
    """The links of all robots, the nearest neighbours first; a track is a number, a kind a team."""

    pictures: tuple[Picture, ...] = ()

    def __init__(
        self, config: RangingConfig, view: View, spread: Spread, seed: int, team_sizes: tuple[int, ...]
    ) -> None:
        """Set up the links.

        Args:
            config: How many are read at once.
            view: Whom a signal reaches.
            spread: Of the errors.
            seed: Of the run.
            team_sizes: Robots of each team, in the order of their numbers.
        """
        self._view, self._spread, self._teams = view, spread, Teams(team_sizes)
        self._most = config.neighbours
        self._keys = RobotKeys(seed, Subsystem.SENSOR)
        self._reading = 0

    def sense(self, scene: Scene) -> Estimates:
        """Return what each robot reads of the neighbours whose signals arrive now, shape ``(r, k)``."""
        most = max(scene.robots - 1, 0)
        if self._most is not None:
            most = min(most, self._most)
        keys = self._keys.of(scene.robots)
        seen_by = sight(scene.pose[None], scene.object_pose[None], self._view, most)
        who, seen = only(seen_by[0][0], seen_by[1][0], self.arrives(scene, seen_by[0][0], keys))
        estimates = measured(who, seen, self._teams.of(who), self._spread, keys, self._reading)
        self._reading += 1
        return estimates

    @abstractmethod
    def arrives(self, scene: Scene, who: IntArray, keys: NDArray[np.uint64]) -> BoolArray:
        """Return whose signals arrive, of those in line of sight.

        Args:
            scene: Now.
            who: Their numbers, -1 where a slot is empty, shape ``(r, k)``.
            keys: Of the observers, shape ``(r,)``.
        """


def measured(
    who: IntArray, seen: FloatArray, kind: IntArray, spread: Spread, keys: NDArray[np.uint64], reading: int
) -> Estimates:
    """Return what robots read of the neighbours in their line of sight.

    Args:
        who: Numbers, -1 where a slot is empty, shape ``(r, k)``.
        seen: Range, bearing, heading and visible fraction, shape ``(r, k, 4)``.
        kind: Their teams, shape ``(r, k)``.
        spread: Of the errors.
        keys: Of the observers, shape ``(r,)``; errors depend on observer, neighbour and reading alone.
        reading: Its number.
    """
    there = who >= 0
    chance = [normal(keys[:, None], reading, who, channel) for channel in range(3)]
    true_range = seen[..., RANGE]
    deviation = np.maximum(spread.range, spread.range_share * true_range)
    covariance = np.full((*who.shape, 3, 3), np.nan)
    covariance[there] = 0.0
    covariance[there, 0, 0] = np.maximum(deviation[there], NEAREST) ** 2
    covariance[there, 1, 1] = max(spread.bearing, NEAREST) ** 2
    heading = np.full(who.shape, np.nan)
    if spread.heading is None:
        covariance[there, 2] = np.nan
        covariance[there, :, 2] = np.nan
    else:
        heading = wrap(seen[..., HEADING] + spread.heading * chance[2])
        covariance[there, 2, 2] = max(spread.heading, NEAREST) ** 2
    return Estimates(
        seen=there,
        range=np.maximum(true_range + deviation * chance[0], NEAREST),
        bearing=wrap(seen[..., BEARING] + spread.bearing * chance[1]),
        heading=heading,
        covariance=covariance,
        age=np.where(there, 0.0, np.nan),
        track=who,
        visible=np.where(there, seen[..., VISIBLE], 0.0),
        kind=kind,
    )


def only(who: IntArray, seen: FloatArray, kept: BoolArray) -> tuple[IntArray, FloatArray]:
    """Return whom to keep ``(r, k)`` and what is seen of them, in the first slots of each robot."""
    kept = kept & (who >= 0)
    width = int(kept.sum(axis=1).max(initial=0))
    first = np.argsort(~kept, axis=1, kind="stable")[:, :width]
    chosen = np.take_along_axis(kept, first, axis=1)
    who = np.where(chosen, np.take_along_axis(who, first, axis=1), -1)
    seen = np.take_along_axis(seen, first[..., None], axis=1)
    return who, np.where(chosen[..., None], seen, np.nan)
