"""The neighbours of many robots over time: prediction, gating, assignment, birth, age.

Each neighbour is a constant-velocity track in its observer's own frame, see
:mod:`swarmvision.perception.kalman`; the observer's own motion, by its encoders, turns and shifts
the frame. Measurements are assigned all at once, where a match costs its squared Mahalanobis
distance and a track that goes without costs the gate. Who is seen beyond the gate, but where no second
robot has room beside the track, is the same robot after a push: the track begins anew with its number.
The tracks of all robots are one set of
arrays; kernels work on one robot's row of them, so that threads may share it robot by robot.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.data import BoolArray, Estimates, IntArray
from swarmvision.geometry import FloatArray
from swarmvision.perception.assignment import assignment
from swarmvision.perception.kalman import STATE, carry_on, improve, squared_distance
from swarmvision.perception.planar import NEAREST_AXES, plane_from_polar, polar_from_plane, take_over

if TYPE_CHECKING:
    from swarmvision.config.sensor import TrackerConfig

MOST_TRACKS = 128  # of one robot; who would be one more is not taken up
FIRST_SPEED_STD = 0.15  # m/s: spread of a new neighbour's velocity, about a Zumo's cruise
FIRST_TURN_STD = 1.0  # rad/s
UNTOLD_HEADING_STD = math.pi  # rad: a heading that was never told
OWN_PLACE = 0.02  # m: a track predicted into the observer itself is wrong
POSITION_GATE_SHARE = 0.846  # 99.9 % of chi-squared with 2 over that with 3 degrees of freedom


class Tracks(NamedTuple):
    """What robots remember, ``t`` slots each; the first ``used`` hold somebody, by rising number."""

    used: IntArray
    """Shape ``(r,)``."""
    issued: IntArray
    """How many numbers have been given so far, shape ``(r,)``."""
    state: FloatArray
    """x, y, psi and their rates, shape ``(r, t, 6)``."""
    covariance: FloatArray
    """Shape ``(r, t, 6, 6)``."""
    age: FloatArray
    """Since the last measurement (s), shape ``(r, t)``."""
    visible: FloatArray
    """At that measurement, shape ``(r, t)``."""
    number: IntArray
    """Shape ``(r, t)``."""
    hits: IntArray
    """Measurements so far, shape ``(r, t)``."""
    looks: IntArray
    """Looks since birth, that of birth counted, shape ``(r, t)``."""
    missed: IntArray
    """Looks since the last measurement, shape ``(r, t)``."""
    told: BoolArray
    """Whether a heading was ever told, shape ``(r, t)``."""
    sure: BoolArray
    """Whether it is confirmed, shape ``(r, t)``."""

    @classmethod
    def of(cls, robots: int, slots: int = MOST_TRACKS) -> Tracks:
        """Return the tracks of robots who know nobody yet."""
        shape = (robots, slots)
        return cls(
            used=np.zeros(robots, np.int64),
            issued=np.zeros(robots, np.int64),
            state=np.empty((*shape, STATE)),
            covariance=np.empty((*shape, STATE, STATE)),
            age=np.empty(shape),
            visible=np.empty(shape),
            number=np.empty(shape, np.int64),
            hits=np.empty(shape, np.int64),
            looks=np.empty(shape, np.int64),
            missed=np.empty(shape, np.int64),
            told=np.empty(shape, np.bool_),
            sure=np.empty(shape, np.bool_),
        )


class Law(NamedTuple):
    """The settings of a tracker as kernels take them; the names are those of the settings."""

    memory: float
    gate: float
    confirm: int
    confirm_within: int
    acceleration: float
    turn_acceleration: float

    @classmethod
    def of(cls, config: TrackerConfig) -> Law:
        """Return the law that settings describe."""
        return cls(
            float(config.memory),
            float(config.gate),
            int(config.confirm),
            int(config.confirm_within),
            float(config.acceleration),
            float(config.turn_acceleration),
        )


class Beliefs(NamedTuple):
    """What robots believe, before it is padded: the first ``used`` of ``t`` slots; as :class:`Estimates`."""

    used: IntArray
    """Shape ``(r,)``."""
    polar: FloatArray
    """Range, bearing, heading, age, visible, shape ``(r, t, 5)``."""
    covariance: FloatArray
    """Shape ``(r, t, 3, 3)``."""
    number: IntArray
    """Shape ``(r, t)``."""

    @classmethod
    def of(cls, robots: int, slots: int = MOST_TRACKS) -> Beliefs:
        """Return room for the beliefs of robots."""
        shape = (robots, slots)
        return cls(
            np.zeros(robots, np.int64),
            np.empty((*shape, 5)),
            np.empty((*shape, 3, 3)),
            np.empty(shape, np.int64),
        )

    def estimates(self) -> Estimates:
        """Return them padded, robot frame, shape ``(r, k)``; k is the most that one robot believes in."""
        k = int(self.used.max(initial=0))
        seen = np.arange(k) < self.used[:, None]
        reach, bearing, heading, age = (np.where(seen, self.polar[:, :k, i], math.nan) for i in range(4))
        return Estimates.given(
            seen=seen,
            range=reach,
            bearing=bearing,
            heading=heading,
            covariance=np.where(seen[..., None, None], self.covariance[:, :k], math.nan),
            age=age,
            track=np.where(seen, self.number[:, :k], -1),
            visible=np.where(seen, self.polar[:, :k, 4], 0.0),
        )


class Tracker:
    """Remembers the neighbours of one robot between pictures."""

    def __init__(self, config: TrackerConfig) -> None:
        self._law = Law.of(config)
        self._tracks = Tracks.of(1)
        self._beliefs = Beliefs.of(1)

    def step(self, estimates: Estimates | None, speed: float, turn_rate: float, dt: float) -> Estimates:
        """Carry the tracks on, take in what was seen, and return what is believed now.

        Args:
            estimates: What the newest pictures show, robot frame, ``(k,)``; None without pictures.
            speed: The observer's own mean speed since the last step (m/s).
            turn_rate: And turn rate (rad/s).
            dt: Time since the last step (s).

        Returns:
            Every neighbour that is remembered, in the order of its track number, robot frame, ``(n,)``.
        """
        predict(self._tracks, 0, float(speed), float(turn_rate), float(dt), self._law)
        if estimates is not None:
            take_in(self._tracks, 0, *plane_rows(estimates.select(estimates.seen)), self._law)
        forget(self._tracks, 0, self._law)
        believe(self._tracks, 0, 0.0, 0.0, 0.0, self._law, self._beliefs)
        return self._beliefs.estimates().select(0)


def plane_rows(seen: Estimates) -> tuple[FloatArray, FloatArray]:
    """Return robot-frame estimates ``(k,)`` as x, y, psi, visible ``(k, 4)`` and covariances."""
    k = len(seen.seen)
    rows, spreads = np.empty((k, 4)), np.empty((k, 3, 3))
    polar = np.column_stack([seen.range, seen.bearing, seen.heading])
    for i in range(k):
        plane_from_polar(polar[i], seen.covariance[i], np.zeros(3), rows[i], spreads[i])
    rows[:, 3] = seen.visible
    return rows, spreads


@compiled
def predict(tracks: Tracks, r: int, speed: float, turn_rate: float, dt: float, law: Law) -> None:
    """Carry a robot's tracks on by ``dt`` (s) while it drives at a speed (m/s) and turn rate (rad/s)."""
    for i in range(tracks.used[r]):
        carry_on(
            tracks.state[r, i],
            tracks.covariance[r, i],
            speed,
            turn_rate,
            dt,
            law.acceleration,
            law.turn_acceleration,
        )
        tracks.age[r, i] += dt


@compiled
def take_in(tracks: Tracks, r: int, rows: FloatArray, spreads: FloatArray, law: Law) -> None:
    """Improve a robot's tracks by what it sees, and begin new ones; the order of rows does not matter.

    Args:
        tracks: Of all robots, as predicted to the time of the picture.
        r: Which robot.
        rows: x, y, psi (nan where not told), visible, shape ``(k, 4)``.
        spreads: Covariances, shape ``(k, 3, 3)``.
        law: Gate and birth.
    """
    count = tracks.used[r]
    order = _nearest_first(rows)
    partner = _partners(tracks, r, rows, spreads, order, law)
    free = np.ones(count, np.bool_)
    for k in range(len(order)):
        if partner[k] >= 0:
            free[partner[k]] = False
    for i in range(count):
        tracks.looks[r, i] += 1
        tracks.missed[r, i] += 1
    for k in range(len(order)):
        row, spread, i = rows[order[k]], spreads[order[k]], partner[k]
        told = 2 if math.isnan(row[2]) else 3
        if i < 0:
            i = _same_place(tracks, r, row, free)
            if i >= 0:
                free[i] = False
                _start(tracks, r, i, row, spread, told)
                tracks.hits[r, i] += 1
            else:
                _begin(tracks, r, row, spread, told)
            continue
        improve(tracks.state[r, i], tracks.covariance[r, i], row, spread, told)
        tracks.age[r, i], tracks.visible[r, i], tracks.missed[r, i] = 0.0, row[3], 0
        tracks.hits[r, i] += 1
        tracks.told[r, i] |= told == 3
    for i in range(tracks.used[r]):
        if tracks.hits[r, i] >= law.confirm:
            tracks.sure[r, i] = True


@compiled
def forget(tracks: Tracks, r: int, law: Law) -> None:
    """Drop a robot's tracks that are too old, that were not confirmed in time or that lie in itself."""
    kept = 0
    for i in range(tracks.used[r]):
        near = math.hypot(tracks.state[r, i, 0], tracks.state[r, i, 1]) <= OWN_PLACE
        unconfirmed = not tracks.sure[r, i] and tracks.looks[r, i] >= law.confirm_within
        if near or unconfirmed or tracks.age[r, i] > law.memory:
            continue
        if kept < i:
            take_over(
                tracks.state[r, kept], tracks.covariance[r, kept], tracks.state[r, i], tracks.covariance[r, i]
            )
            tracks.age[r, kept], tracks.visible[r, kept] = tracks.age[r, i], tracks.visible[r, i]
            tracks.number[r, kept] = tracks.number[r, i]
            tracks.hits[r, kept], tracks.looks[r, kept] = tracks.hits[r, i], tracks.looks[r, i]
            tracks.missed[r, kept] = tracks.missed[r, i]
            tracks.told[r, kept], tracks.sure[r, kept] = tracks.told[r, i], tracks.sure[r, i]
        kept += 1
    tracks.used[r] = kept


@compiled
def believe(
    tracks: Tracks, r: int, speed: float, turn_rate: float, dt: float, law: Law, beliefs: Beliefs
) -> None:
    """Write what a robot believes ``dt`` (s) after its tracks' time; the tracks stay as they are."""
    state, covariance = np.empty(STATE), np.empty((STATE, STATE))
    count = 0
    for i in range(tracks.used[r]):
        age = tracks.age[r, i] + dt
        if not tracks.sure[r, i] or age > law.memory:
            continue
        take_over(state, covariance, tracks.state[r, i], tracks.covariance[r, i])
        carry_on(state, covariance, speed, turn_rate, dt, law.acceleration, law.turn_acceleration)
        if math.hypot(state[0], state[1]) <= OWN_PLACE:
            continue
        polar = beliefs.polar[r, count]
        polar_from_plane(state, covariance, tracks.told[r, i], polar, beliefs.covariance[r, count])
        polar[3], polar[4] = age, tracks.visible[r, i]
        beliefs.number[r, count] = tracks.number[r, i]
        count += 1
    beliefs.used[r] = count


@compiled
def _nearest_first(rows: FloatArray) -> IntArray:
    """Return the order of rows by distance, then by x: it decides numbers, so chance must not."""
    order = np.empty(len(rows), np.int64)
    for k in range(len(rows)):
        place, far = k, rows[k, 0] ** 2 + rows[k, 1] ** 2
        while place > 0:
            other = rows[order[place - 1]]
            away = other[0] ** 2 + other[1] ** 2
            if away < far or (away == far and other[0] <= rows[k, 0]):
                break
            order[place] = order[place - 1]
            place -= 1
        order[place] = k
    return order


@compiled
def _partners(
    tracks: Tracks, r: int, rows: FloatArray, spreads: FloatArray, order: IntArray, law: Law
) -> IntArray:
    """Return the track of each row, in order; -1 for a row that is nobody's."""
    count = tracks.used[r]
    cost = np.empty((len(order), count))
    clear = True  # nobody wants what another one wants
    suitors = np.zeros(count, np.int64)
    partner = np.full(len(order), -1, np.int64)
    for k in range(len(order)):
        row, spread = rows[order[k]], spreads[order[k]]
        told = 2 if math.isnan(row[2]) else 3
        limit = law.gate if told == 3 else law.gate * POSITION_GATE_SHARE
        for i in range(count):
            square = squared_distance(tracks.state[r, i], tracks.covariance[r, i], row, spread, told, limit)
            cost[k, i] = law.gate
            if square <= limit:
                cost[k, i] = square
                clear = clear and partner[k] < 0 and suitors[i] == 0
                partner[k] = i
                suitors[i] += 1
    if clear:
        return partner
    partner = assignment(cost)
    for k in range(len(order)):
        if partner[k] >= 0 and cost[k, partner[k]] >= law.gate:
            partner[k] = -1
    return partner


@compiled
def _same_place(tracks: Tracks, r: int, row: FloatArray, free: BoolArray) -> int:
    """Return the free track that is nearest to a row, where only one robot has room; -1 for none."""
    nearest, best = NEAREST_AXES, -1
    for i in range(len(free)):
        away = math.hypot(tracks.state[r, i, 0] - row[0], tracks.state[r, i, 1] - row[1])
        if free[i] and away < nearest:
            nearest, best = away, i
    return best


@compiled
def _begin(tracks: Tracks, r: int, row: FloatArray, spread: FloatArray, told: int) -> None:
    """Begin a track with a measurement, if there is room."""
    i = tracks.used[r]
    if i == tracks.state.shape[1]:
        return
    _start(tracks, r, i, row, spread, told)
    tracks.hits[r, i] = tracks.looks[r, i] = 1
    tracks.sure[r, i] = False
    tracks.number[r, i] = tracks.issued[r]
    tracks.issued[r] += 1
    tracks.used[r] = i + 1


@compiled
def _start(tracks: Tracks, r: int, i: int, row: FloatArray, spread: FloatArray, told: int) -> None:
    """Set a track to a measurement, at rest for all that is known."""
    state, covariance = tracks.state[r, i], tracks.covariance[r, i]
    state[:] = 0.0
    covariance[:, :] = 0.0
    for a in range(told):
        state[a] = row[a]
        for b in range(told):
            covariance[a, b] = spread[a, b]
    if told == 2:
        covariance[2, 2] = UNTOLD_HEADING_STD**2
    covariance[3, 3] = covariance[4, 4] = FIRST_SPEED_STD**2
    covariance[5, 5] = FIRST_TURN_STD**2
    tracks.age[r, i], tracks.visible[r, i], tracks.told[r, i] = 0.0, row[3], told == 3
    tracks.missed[r, i] = 0
