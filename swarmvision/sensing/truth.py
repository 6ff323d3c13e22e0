"""Perfect range, bearing and heading of every neighbour in line of sight.

The upper bound that every real sensor is held against. Line of sight is computed in the plane
(:mod:`swarmvision.sensing.sight`): a marker is hidden where a nearer marker, or an object taller
than the markers' base, stands before it.
"""

from __future__ import annotations

import numpy as np

from swarmvision import recycling
from swarmvision.compiled import compiled
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import TruthSensorConfig
from swarmvision.data import BoolArray, Estimates, IntArray, Picture, Scene
from swarmvision.geometry import FloatArray
from swarmvision.sensing.abreast import FEW as ABREAST_ROBOTS
from swarmvision.sensing.abreast import look_abreast
from swarmvision.sensing.in_turn import look_in_turn
from swarmvision.sensing.sight import (
    BEARING,
    ENOUGH,
    HEADING,
    RANGE,
    VISIBLE,
    View,
)

VARIANCE = 1e-12  # of a perfect sensor: covariances stay positive definite


class TruthSensor:
    """Line of sight without error; a neighbour's track is its number, its kind its team.

    Without a limit of neighbours, neighbour ``j`` keeps its slot; with one, the nearest come first.
    """

    pictures: tuple[Picture, ...] = ()

    def __init__(
        self,
        config: TruthSensorConfig,
        robot: RobotConfig,
        arena: ArenaConfig,
        team_sizes: tuple[int, ...] = (),
    ) -> None:
        """Make the sensor; robots that no team counts are of a kind that is not told."""
        self._teams = Teams(team_sizes)
        self._neighbours = config.neighbours
        self.view = View.of(
            robot, arena, config.reach, np.radians(config.fov_deg), occlusion=config.occlusion
        )

    def sense(self, scene: Scene) -> Estimates:
        """Return the true neighbours of every robot, shape ``(r, k)``.

        ``k`` is the configured number of neighbours, or ``r - 1`` where all are asked for.
        """
        k = max(scene.robots - 1, 0) if self._neighbours is None else self._neighbours
        who, seen = sight(scene.pose[None], scene.object_pose[None], self.view, k)
        who, seen = who[0], seen[0]
        if self._neighbours is None:
            who, seen = _own_slots(who, seen)
        return truth_estimates(who, seen, self._teams.of(who))


class Teams:
    """Which team each robot is of, for sensors that can tell."""

    def __init__(self, sizes: tuple[int, ...]) -> None:
        self._team = np.append(np.repeat(np.arange(len(sizes)), sizes), -1)

    def of(self, who: IntArray) -> IntArray:
        """Return the team of each number ``(...)``; -1 for nobody and for robots that no team counts."""
        beyond = len(self._team) - 1  # where nobody's team stands, -1
        return self._team[np.where(who < 0, beyond, np.minimum(who, beyond))]


def sight(
    pose: FloatArray, objects: FloatArray, view: View, most: int, least: float = ENOUGH
) -> tuple[IntArray, FloatArray]:
    """Return whom every robot of every world sees, nearest first.

    Args:
        pose: Shape ``(w, r, 3)``.
        objects: Shape ``(w, m, 3)``.
        view: Of the sensor.
        most: Slots ``k``.
        least: Fraction of a marker's width that must be in sight.

    Returns:
        Numbers, -1 where the slot is empty, ``(w, r, k)``; range, bearing, heading and visible fraction,
        nan where empty but for the fraction, which is 0 there, ``(w, r, k, 4)``.
    """
    who, seen = looked(pose, objects, view, most, least)
    return who, seen.transpose(1, 2, 3, 0)


def looked(
    pose: FloatArray, objects: FloatArray, view: View, most: int, least: float
) -> tuple[IntArray, FloatArray]:
    """Return the same as :func:`sight`, but range, bearing and so on come first, ``(4, w, r, k)``."""
    shape = (*pose.shape[:2], most)
    who, seen = recycling.empty(shape, np.int64), recycling.empty((4, *shape))
    look = look_abreast if pose.shape[1] <= ABREAST_ROBOTS else look_in_turn
    limits = (view.reach, view.limit, view.radius, view.occlusion, view.ahead, least)
    look(pose, objects, limits, view.things, most, who.reshape(-1), seen.reshape(4, -1))
    return who, seen


def truth_estimates(who: IntArray, seen: FloatArray, kind: IntArray | None = None) -> Estimates:
    """Return what :func:`sight` found, and of which kind, as estimates without error, shape ``(..., k)``."""
    there, age = recycling.empty(who.shape, bool), recycling.empty(who.shape)
    covariance = recycling.empty((*who.shape, 3, 3))
    _fill_perfect(who.reshape(-1), there.reshape(-1), age.reshape(-1), covariance.reshape(-1, 9))
    return Estimates.given(
        seen=there,
        range=seen[..., RANGE],
        bearing=seen[..., BEARING],
        heading=seen[..., HEADING],
        covariance=covariance,
        age=age,
        track=who,
        visible=seen[..., VISIBLE],
        kind=kind,
    )


@compiled
def _fill_perfect(who: IntArray, there: BoolArray, age: FloatArray, covariance: FloatArray) -> None:
    """Fill in who is there, new, and with the covariance ``(n, 9)`` of a perfect sensor; nan for nobody."""
    for n in range(len(who)):
        there[n] = who[n] >= 0
        age[n] = 0.0 if there[n] else np.nan
        for c in range(9):
            covariance[n, c] = np.nan if not there[n] else (VARIANCE if c % 4 == 0 else 0.0)


def _own_slots(who: IntArray, seen: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the same with neighbour ``j`` in slot ``j``, or ``j - 1`` after the observer itself."""
    robot, slot = np.nonzero(who >= 0)
    number = who[robot, slot]
    own = number - (number > robot)
    placed, values = np.full_like(who, -1), np.full_like(seen, np.nan)
    values[..., VISIBLE] = 0.0
    placed[robot, own] = number
    values[robot, own] = seen[robot, slot]
    return placed, values
