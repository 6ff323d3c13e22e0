"""One robot's neighbours over time: prediction, gating, assignment, age.

Each neighbour is a constant-velocity track in the observer's own frame: place (x, y), heading psi
and their rates over ground, with an extended Kalman filter (Joseph form, so covariances stay
positive definite). The observer's own motion, by its encoders, turns and shifts the frame.
Measurements are assigned all at once by least total Mahalanobis distance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from swarmvision.data import Estimates
from swarmvision.geometry import FloatArray, wrap

if TYPE_CHECKING:
    from swarmvision.config.sensor import TrackerConfig

FIRST_SPEED_STD = 0.15  # m/s: spread of a new neighbour's velocity, about a Zumo's cruise
FIRST_TURN_STD = 1.0  # rad/s
UNTOLD_HEADING_STD = math.pi  # rad: a heading that was never told
OWN_PLACE = 0.02  # m: a track predicted into the observer itself is wrong
POSITION_GATE_SHARE = 0.846  # 99.9 % of chi-squared with 2 over that with 3 degrees of freedom


@dataclass(eq=False, slots=True)
class _Track:
    """A neighbour: state x, y, psi, vx, vy, psi rate, in the observer's frame."""

    number: int
    state: FloatArray
    covariance: FloatArray
    age: float
    hits: int
    visible: float
    told_heading: bool


class Tracker:
    """Remembers the neighbours of one robot between pictures."""

    def __init__(self, config: TrackerConfig) -> None:
        self._config = config
        self._tracks: tuple[_Track, ...] = ()
        self._next = 0

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
        tracks = [self._predicted(track, speed, turn_rate, dt) for track in self._tracks]
        if estimates is not None:
            tracks = self._taken_in(tracks, estimates.select(estimates.seen))
        memory = self._config.memory
        self._tracks = tuple(
            track
            for track in tracks
            if track.age <= memory and math.hypot(track.state[0], track.state[1]) > OWN_PLACE
        )
        return _believed([track for track in self._tracks if track.hits >= self._config.confirm])

    def _predicted(self, track: _Track, speed: float, turn_rate: float, dt: float) -> _Track:
        if dt <= 0.0:
            return track
        turn = turn_rate * dt
        # The observer's way in its old frame: an arc.
        chord = speed * dt * math.sin(turn / 2.0) / (turn / 2.0) if abs(turn) > 1e-9 else speed * dt
        ahead, aside = chord * math.cos(turn / 2.0), chord * math.sin(turn / 2.0)
        cos, sin = math.cos(turn), math.sin(turn)
        back = np.array([[cos, sin], [-sin, cos]])
        move = np.zeros((6, 6))
        move[:2, :2] = move[3:5, 3:5] = back
        move[:2, 3:5] = back * dt
        move[2, 2] = move[5, 5] = 1.0
        move[2, 5] = dt
        state = move @ track.state
        state[:2] -= back @ (ahead, aside)
        state[2] = wrap(state[2] - turn)
        noise = np.zeros((6, 6))
        for place, rate, acceleration in (
            (0, 3, self._config.acceleration),
            (1, 4, self._config.acceleration),
            (2, 5, self._config.turn_acceleration),
        ):
            # White acceleration over the step.
            noise[place, place] = acceleration**2 * dt**4 / 4.0
            noise[place, rate] = noise[rate, place] = acceleration**2 * dt**3 / 2.0
            noise[rate, rate] = acceleration**2 * dt**2
        covariance = move @ track.covariance @ move.T + noise
        return _Track(
            track.number, state, covariance, track.age + dt, track.hits, track.visible, track.told_heading
        )

    def _taken_in(self, tracks: list[_Track], seen: Estimates) -> list[_Track]:
        rank = np.lexsort((seen.bearing, seen.range))  # so that the order of detections does not matter
        rows = [_Measurement.of(seen, int(i)) for i in rank]
        pairs = _assigned(tracks, rows, self._config.gate)
        out = [_updated(track, rows[pairs[i]]) if i in pairs else track for i, track in enumerate(tracks)]
        for j, row in enumerate(rows):
            if j not in pairs.values():
                out.append(row.born(self._next))
                self._next += 1
        return out


@dataclass(frozen=True, eq=False, slots=True)
class _Measurement:
    """A detection as x, y, psi with its covariance; psi nan where heading is not told."""

    value: FloatArray
    covariance: FloatArray
    visible: float

    @classmethod
    def of(cls, seen: Estimates, i: int) -> _Measurement:
        distance, bearing, heading = seen.range[i], seen.bearing[i], seen.heading[i]
        cos, sin = math.cos(bearing), math.sin(bearing)
        change = np.array([[cos, -distance * sin, 0.0], [sin, distance * cos, 0.0], [0.0, 0.0, 1.0]])
        covariance = np.nan_to_num(seen.covariance[i], nan=0.0)
        value = np.array([distance * cos, distance * sin, heading])
        return cls(value, change @ covariance @ change.T, float(seen.visible[i]))

    @property
    def told(self) -> int:
        """How many of x, y, psi are told."""
        return 2 if math.isnan(self.value[2]) else 3

    def born(self, number: int) -> _Track:
        state = np.zeros(6)
        state[: self.told] = self.value[: self.told]
        covariance = np.zeros((6, 6))
        covariance[:3, :3] = self.covariance
        if self.told == 2:
            covariance[2, :] = covariance[:, 2] = 0.0
            covariance[2, 2] = UNTOLD_HEADING_STD**2
        covariance[3, 3] = covariance[4, 4] = FIRST_SPEED_STD**2
        covariance[5, 5] = FIRST_TURN_STD**2
        return _Track(number, state, covariance, 0.0, 1, self.visible, self.told == 3)


def _innovation(track: _Track, row: _Measurement) -> tuple[FloatArray, FloatArray]:
    n = row.told
    difference = row.value[:n] - track.state[:n]
    if n == 3:
        difference[2] = float(wrap(difference[2]))
    return difference, track.covariance[:n, :n] + row.covariance[:n, :n]


def _updated(track: _Track, row: _Measurement) -> _Track:
    difference, spread = _innovation(track, row)
    n = row.told
    gain = track.covariance[:, :n] @ np.linalg.inv(spread)
    state = track.state + gain @ difference
    state[2] = wrap(state[2])
    rest = np.eye(6)
    rest[:, :n] -= gain
    covariance = rest @ track.covariance @ rest.T + gain @ row.covariance[:n, :n] @ gain.T
    covariance = (covariance + covariance.T) / 2.0
    told = track.told_heading or n == 3
    return _Track(track.number, state, covariance, 0.0, track.hits + 1, row.visible, told)


def _assigned(tracks: list[_Track], rows: list[_Measurement], gate: float) -> dict[int, int]:
    """Return track index -> measurement index of the cheapest assignment within the gate."""
    if not tracks or not rows:
        return {}
    cost = np.full((len(tracks), len(rows)), np.inf)
    for i, track in enumerate(tracks):
        for j, row in enumerate(rows):
            difference, spread = _innovation(track, row)
            square = float(difference @ np.linalg.solve(spread, difference))
            if square <= (gate if row.told == 3 else gate * POSITION_GATE_SHARE):
                cost[i, j] = square
    # An unmatched pair costs more than any match, so as many as possible are matched.
    wall = gate * (len(tracks) + len(rows) + 1.0)
    columns = assignment(np.where(np.isfinite(cost), cost, wall))
    return {i: int(j) for i, j in enumerate(columns) if j >= 0 and np.isfinite(cost[i, j])}


def assignment(cost: FloatArray) -> list[int]:
    """Return for each row its column in the assignment of least total cost; -1 for a row without one.

    The shortest augmenting path method in O(n^3): R. Jonker, A. Volgenant, Computing 38, 1987,
    doi:10.1007/BF02278710, without their start heuristics.

    Args:
        cost: Finite, shape ``(rows, columns)``.
    """
    rows, columns = cost.shape
    if rows > columns:
        partner = assignment(cost.T)
        back = [-1] * rows
        for column, row in enumerate(partner):
            back[row] = column
        return back
    u, v = np.zeros(rows + 1), np.zeros(columns + 1)
    row_of = np.zeros(columns + 1, dtype=int)  # 1-based; 0 is free
    for row in range(1, rows + 1):
        row_of[0] = row
        column = 0
        least = np.full(columns + 1, np.inf)
        came_from = np.zeros(columns + 1, dtype=int)
        used = np.zeros(columns + 1, dtype=bool)
        while row_of[column] != 0:
            used[column] = True
            reduced = cost[row_of[column] - 1] - u[row_of[column]] - v[1:]
            better = ~used[1:] & (reduced < least[1:])
            least[1:][better] = reduced[better]
            came_from[1:][better] = column
            after = 1 + int(np.argmin(np.where(used[1:], np.inf, least[1:])))
            step = least[after]
            u[row_of[used]] += step
            v[used] -= step
            least[1:][~used[1:]] -= step
            column = after
        while column != 0:
            row_of[column] = row_of[came_from[column]]
            column = int(came_from[column])
    partner_of = [-1] * rows
    for column in range(1, columns + 1):
        if row_of[column]:
            partner_of[row_of[column] - 1] = column - 1
    return partner_of


def _believed(tracks: list[_Track]) -> Estimates:
    """Return tracks as estimates."""
    k = len(tracks)
    if k == 0:
        return Estimates.empty((0,))
    state = np.array([track.state for track in tracks])
    covariance = np.array([track.covariance[:3, :3] for track in tracks])
    distance = np.hypot(state[:, 0], state[:, 1])
    bearing = np.arctan2(state[:, 1], state[:, 0])
    cos, sin = np.cos(bearing), np.sin(bearing)
    change = np.zeros((k, 3, 3))
    change[:, 0, 0], change[:, 0, 1] = cos, sin
    change[:, 1, 0], change[:, 1, 1] = -sin / distance, cos / distance
    change[:, 2, 2] = 1.0
    covariance = change @ covariance @ np.swapaxes(change, -1, -2)
    untold = ~np.array([track.told_heading for track in tracks])
    covariance[untold, 2, :] = covariance[untold, :, 2] = np.nan
    return Estimates(
        seen=np.ones(k, dtype=bool),
        range=distance,
        bearing=bearing,
        heading=np.where(untold, np.nan, wrap(state[:, 2])),
        covariance=covariance,
        age=np.array([track.age for track in tracks]),
        track=np.array([track.number for track in tracks]),
        visible=np.array([track.visible for track in tracks]),
    )
