"""How readings reach the robot: late, lost, from a broken sensor, and carried on by odometry until the next.

One wrapper round any sensor but a camera, whose pictures go a way of their own. Readings wait for the
latency, in order. When one arrives, each robot moves what it already knew, and the reading itself, by its
own way since then as its encoders tell it. Of neighbours that move meanwhile it knows nothing: their
covariance grows as if they walked at ``DRIFT``, a value of ours.
"""

from __future__ import annotations

from collections import deque
from dataclasses import fields

import numpy as np

from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import DeliveryConfig
from swarmvision.data import BoolArray, Estimates, Picture, Scene
from swarmvision.drive import Drive
from swarmvision.geometry import FloatArray, cartesian, polar, rotate
from swarmvision.randomness import RobotKeys, Subsystem, draw
from swarmvision.sensing.protocol import Sensor

CLOCK_SLACK = 1e-9  # s; sums of control periods are not exact
DRIFT = 0.1  # m/s
NEAREST = 1e-3  # m; nobody is carried nearer
CHANCE = 100  # the channel of chance that loses readings; the sensors' own are below


class Delivery:
    """A sensor as its robots have it."""

    pictures: tuple[Picture, ...] = ()

    def __init__(self, sensor: Sensor, config: DeliveryConfig, robot: RobotConfig, seed: int = 0) -> None:
        self._sensor = sensor
        self._config = config
        self._drive = Drive.from_config(robot)
        self._keys = RobotKeys(seed, Subsystem.SENSOR)
        self._readings = 0
        self._stuck: Estimates | None = None
        self._waiting: deque[tuple[Scene, Estimates]] = deque()
        self._known: Estimates | None = None
        self._since: Scene | None = None
        """When what is known was measured."""

    def sense(self, scene: Scene) -> Estimates:
        """Return what each robot believes now from every reading that has arrived, shape ``(r, k)``."""
        self._waiting.append((scene, self._lose(self._break(self._sensor.sense(scene)))))
        self._readings += 1
        while self._waiting and self._waiting[0][0].time + self._config.latency <= scene.time + CLOCK_SLACK:
            taken, reading = self._waiting.popleft()
            self._known = self._joined(reading, self._carried(taken))
            self._since = taken
        return self._carried(scene)

    def _break(self, reading: Estimates) -> Estimates:
        """Return the reading with nothing from dead sensors and always the first from stuck ones."""
        faults, robots = self._config.faults, len(reading.seen)
        stuck = [robot for robot in faults.stuck if robot < robots]
        dead = [robot for robot in faults.dead if robot < robots]
        if not stuck and not dead:
            return reading
        if self._stuck is None:
            self._stuck = reading.select(stuck)
        spare = Estimates.join([reading, self._stuck, Estimates.empty((1, 0), reading.frame)])
        row = np.arange(robots)
        row[stuck] = robots + np.arange(len(stuck))
        row[dead] = robots + len(stuck)
        return spare.select(row)

    def _lose(self, reading: Estimates) -> Estimates:
        """Return the reading without what never arrives; chance is by observer, neighbour and time alone."""
        if self._config.lost == 0.0:
            return reading
        keys = self._keys.of(len(reading.seen))[:, None]
        name = np.where(reading.track >= 0, reading.track, np.arange(reading.seen.shape[1]))
        return _kept(reading, draw(keys, self._readings, name, CHANCE) >= self._config.lost)

    def _carried(self, scene: Scene) -> Estimates:
        """Return what is known, moved by the robots' own way up to a scene."""
        if self._known is None or self._since is None:
            return Estimates.empty((scene.robots, 0))
        dt = scene.time - self._since.time
        if dt <= CLOCK_SLACK:
            return self._known
        way, turn = self._drive.twist(scene.wheel_travel - self._since.wheel_travel)
        return carried(self._known, way, turn, dt)

    def _joined(self, reading: Estimates, known: Estimates) -> Estimates:
        """Return a new reading and, of what was known, those that are not in it and are not too old."""
        if self._config.memory == 0.0:
            return reading
        again = (known.track[:, :, None] == reading.track[:, None, :]).any(axis=2)
        old = _kept(known, known.seen & (known.track >= 0) & ~again & (known.age <= self._config.memory))
        both = _beside(reading, old)
        first = np.argsort(~both.seen, axis=1, kind="stable")[:, : int(both.count.max(initial=0))]
        return both.select((np.arange(len(first))[:, None], first))


def carried(known: Estimates, way: FloatArray, turn: FloatArray, dt: float) -> Estimates:
    """Return estimates as they are after the observers' own motion.

    Args:
        known: Robot frame, shape ``(r, k)``.
        way: How far each observer drove (m), shape ``(r,)``, along an arc.
        turn: By how much it turned on it (rad), shape ``(r,)``.
        dt: In what time (s).
    """
    chord = cartesian(way * np.sinc(turn / (2.0 * np.pi)), turn / 2.0)  # numpy's sinc(x) is sin(pi x)/(pi x)
    place = rotate(known.positions - chord[:, None], -turn[:, None])
    distance, bearing, heading = polar(
        np.concatenate([place, (known.heading - turn[:, None])[..., None]], axis=-1)
    )
    distance = np.maximum(distance, NEAREST)
    age = known.age + dt
    walked = DRIFT**2 * (age**2 - known.age**2)
    covariance = known.covariance.copy()
    covariance[..., 0, 0] += walked
    covariance[..., 1, 1] += walked / distance**2
    return Estimates(
        seen=known.seen,
        range=distance,
        bearing=bearing,
        heading=heading,
        covariance=covariance,
        age=age,
        track=known.track,
        visible=known.visible,
        frame=known.frame,
        kind=known.kind,
    )


def _kept(estimates: Estimates, where: BoolArray) -> Estimates:
    """Return the estimates with the slots emptied that are not to be kept, ``where`` ``(r, k)``."""
    empty = Estimates.empty(estimates.seen.shape, estimates.frame)
    arrays = {
        field.name: np.where(
            where[..., None, None] if field.name == "covariance" else where,
            getattr(estimates, field.name),
            getattr(empty, field.name),
        )
        for field in fields(Estimates)
        if field.name != "frame"
    }
    return Estimates(**arrays, frame=estimates.frame)


def _beside(one: Estimates, two: Estimates) -> Estimates:
    """Return the slots of both, side by side, for the same robots."""
    arrays = {
        field.name: np.concatenate([getattr(one, field.name), getattr(two, field.name)], axis=1)
        for field in fields(Estimates)
        if field.name != "frame"
    }
    return Estimates(**arrays, frame=one.frame)
