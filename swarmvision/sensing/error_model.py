"""What a tracked camera would believe, drawn from tables instead of from pictures.

Modelled is the outcome of the tracker, not the single reading: an extended Kalman filter for every
neighbour costs more than the whole of this sensor, and what a controller gets is the outcome. For each
neighbour in reach a robot remembers whether the last picture measured it, since when not, and three
normal deviates that drift from picture to picture; part of them is common to all that one robot sees,
for most of the error is its own turn. The deviates pick quantiles of the error by true range, turn rate
and visible fraction, or by age once a neighbour is only remembered. Now and then a track splits and
leaves a ghost, and rarer still there is a phantom; both are forgotten after the tracker's memory.

Chance is hashed from the observer's key, the picture's number and the neighbour's, so it shifts with
nobody else's. The tables are in :mod:`swarmvision.sensing.error_table`; what they leave out: the error
does not depend on the neighbour's own aspect, nor on which lens of the ring sees it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import compiled
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.camera import RIGS
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import ErrorModelSensorConfig
from swarmvision.data import BoolArray, Estimates, IntArray, Picture, Scene
from swarmvision.geometry import FloatArray
from swarmvision.randomness import Subsystem, hashed
from swarmvision.sensing.error_table import AGES, DEVIATES, RANGES, TURNS, VISIBLES, ErrorTable
from swarmvision.sensing.sight import FEW, View, cells, look, measure_pairs, wrapped

Keys = NDArray[np.uint64]
Slots = tuple[IntArray, FloatArray, IntArray, FloatArray, FloatArray, IntArray]
"""who, age, state, visible, deviate and number of :class:`ErrorMemory`, of one robot or of all."""
Minds = tuple[FloatArray, IntArray, IntArray, Keys]
"""common, next, picture and keys of it."""
Told = tuple[BoolArray, FloatArray, FloatArray, IntArray, FloatArray]
"""seen; range, bearing, heading and age; covariance; track; visible: all worlds' slots in a row."""
NOBODY, PHANTOM = -1, -2  # instead of a neighbour's number
MEASURED, REMEMBERED, GHOST = 0, 1, 2  # states of a slot
GHOSTLY = 1 << 32  # beside neighbours' numbers, in the chance of ghosts
NEAREST = 0.01  # m; nobody is believed nearer
MARGIN = 1.1  # candidates are looked for a little beyond the reach: an estimate may be nearer than the truth
CANDIDATES = 4  # of the nearest for each slot; in a crowd those behind are hidden anyway
SLOTS_EACH = 2  # where the slots are not limited: one for everybody, and as many for ghosts
CLOCK_SLACK = 1e-9  # s; sums of control periods are not exact
NORMALS = 4096
"""Equal shares of the normal distribution, each by its middle."""


def _normal_table() -> FloatArray:
    from scipy.special import ndtri

    middles = ndtri((np.arange(NORMALS) + 0.5) / NORMALS)
    table: FloatArray = middles / middles.std()
    return table


@dataclass(eq=False, slots=True)
class ErrorMemory:
    """What the robots ``r`` of worlds ``w`` remember of their neighbours in ``k`` slots."""

    who: IntArray
    """Number of the neighbour, -1 for an empty slot, -2 for a phantom, ``(w, r, k)``."""
    age: FloatArray
    """Since it was measured (s), ``(w, r, k)``."""
    state: IntArray
    """Whether the last picture measured it, or whether it is a ghost, ``(w, r, k)``."""
    visible: FloatArray
    """Fraction in sight when it was measured, ``(w, r, k)``."""
    deviate: FloatArray
    """Normal deviates of range, bearing, heading; of a phantom its pose in the world, ``(w, r, k, 3)``."""
    number: IntArray
    """Of the track, as a tracker counts them, ``(w, r, k)``."""
    common: FloatArray
    """Deviates that all of an observer's neighbours share, ``(w, r, 3)``."""
    next: IntArray
    """Number of the observer's next track, ``(w, r)``."""
    picture: IntArray
    """Number of the next picture, ``(w,)``."""
    keys: Keys
    """Of the observers' chance, ``(w, r)``."""

    @classmethod
    def blank(cls, keys: Keys, slots: int) -> ErrorMemory:
        """Return the memory of robots that have seen nothing, from their keys ``(w, r)``."""
        memory = cls(
            who=np.empty((*keys.shape, slots), np.int64),
            age=np.empty((*keys.shape, slots)),
            state=np.empty((*keys.shape, slots), np.int64),
            visible=np.empty((*keys.shape, slots)),
            deviate=np.empty((*keys.shape, slots, 3)),
            number=np.empty((*keys.shape, slots), np.int64),
            common=np.empty((*keys.shape, 3)),
            next=np.empty(keys.shape, np.int64),
            picture=np.empty(len(keys), np.int64),
            keys=keys.astype(np.uint64),
        )
        for world in range(len(keys)):
            memory.forget(world, keys[world])
        return memory

    def forget(self, world: int, keys: Keys) -> None:
        """Begin anew in one world, with other keys ``(r,)``."""
        self.who[world] = NOBODY
        self.state[world] = MEASURED
        self.age[world] = self.visible[world] = self.deviate[world] = self.common[world] = 0.0
        self.number[world] = self.next[world] = self.picture[world] = 0
        self.keys[world] = keys


class ErrorModel:
    """Draws estimates for every robot of every world."""

    def __init__(self, table: ErrorTable, view: View, memory: float) -> None:
        """Prepare the tables.

        Args:
            table: Of the errors.
            view: Reach, field of view and what hides.
            memory: How long a neighbour that is not measured is remembered (s).
        """
        keep, common = table.memory, table.common
        roots = (np.sqrt(1.0 - keep**2), np.sqrt(1.0 - common), np.sqrt(common))
        flat = (table.fresh.ravel(), table.aged.ravel(), table.ghost.ravel(), table.phantom_place.ravel())
        self._tables = (*table.arrays(), *roots, *flat)
        self._view = view
        self._memory = memory
        self._normals = _normal_table()

    def believe(
        self,
        pose: FloatArray,
        turn_rate: FloatArray,
        objects: FloatArray,
        memory: ErrorMemory,
        exposed: BoolArray,
        passed: FloatArray,
    ) -> Estimates:
        """Return what the robots believe now; their memory goes on.

        Args:
            pose: Shape ``(w, r, 3)``.
            turn_rate: Of the robots (rad/s), shape ``(w, r)``.
            objects: Poses, shape ``(w, m, 3)``.
            memory: Of the worlds.
            exposed: Whether a picture has been taken since the last call, shape ``(w,)``.
            passed: Time since the last call (s), shape ``(w,)``.

        Returns:
            Measured neighbours first, nearest first, shape ``(w, r, k)``.
        """
        shape = memory.who.shape
        told, covariance = np.empty((4, *shape)), np.empty((*shape, 3, 3))
        seen, track, visible = np.empty(shape, bool), np.empty(shape, np.int64), np.empty(shape)
        view, m = self._view, memory
        with np.errstate(over="ignore"):  # hashes are meant to wrap, where no compiler makes them
            _believe_all(
                (pose, turn_rate, objects),
                (exposed, passed),
                (view.reach, view.limit, view.radius, view.occlusion, view.ahead, view.things, self._memory),
                self._tables,
                self._normals,
                (m.who, m.age, m.state, m.visible, m.deviate, m.number),
                (m.common, m.next, m.picture, m.keys),
                (
                    seen.reshape(-1),
                    told.reshape(4, -1),
                    covariance.reshape(-1, 9),
                    track.reshape(-1),
                    visible.reshape(-1),
                ),
            )
        return Estimates.given(
            seen=seen,
            range=told[0],
            bearing=told[1],
            heading=told[2],
            covariance=covariance,
            age=told[3],
            track=track,
            visible=visible,
        )


class ErrorModelSensor:
    """The error model as the sensor of one swarm."""

    pictures: tuple[Picture, ...] = ()

    def __init__(
        self, config: ErrorModelSensorConfig, robot: RobotConfig, arena: ArenaConfig, robots: int, seed: int
    ) -> None:
        """Load the tables.

        Args:
            config: Reach, field of view, rate, memory and slots.
            robot: Whose markers are seen.
            arena: Whose objects hide them.
            robots: How many.
            seed: Of the run.
        """
        self._rate = config.rate_hz
        self._model = error_model(config, robot, arena)
        self._memory = ErrorMemory.blank(observer_keys(seed, robots)[None], slots_of(config, robots))
        self._exposures = 0
        self._time: float | None = None

    def sense(self, scene: Scene) -> Estimates:
        """Return what each robot believes at the scene's time, robot frame, shape ``(r, k)``."""
        # Of several pictures since the last call the newest counts.
        due = exposures_until(scene.time, self._rate)
        passed = 0.0 if self._time is None else scene.time - self._time
        estimates = self._model.believe(
            scene.pose[None],
            scene.velocity[None, :, 2],
            scene.object_pose[None],
            self._memory,
            np.array([due > self._exposures]),
            np.array([passed]),
        )
        self._exposures, self._time = due, scene.time
        return estimates.select(0)


def error_model(config: ErrorModelSensorConfig, robot: RobotConfig, arena: ArenaConfig) -> ErrorModel:
    """Return the model of a configured sensor, with the tables that ship with the package."""
    view = camera_view(robot, arena, config.reach, np.radians(config.fov_deg))
    return ErrorModel(ErrorTable.load(), view, config.memory)


def camera_view(robot: RobotConfig, arena: ArenaConfig, reach: float, fov: float = 2.0 * np.pi) -> View:
    """Return the view from the lenses of a ring, which stand before the robot's axis."""
    return replace(View.of(robot, arena, reach, fov), ahead=RIGS["ring-7"].forward)


def slots_of(config: ErrorModelSensorConfig, robots: int) -> int:
    """Return how many slots a robot has: the configured ones, or enough for everybody and ghosts."""
    if config.neighbours is not None:
        return config.neighbours
    return SLOTS_EACH * max(robots - 1, 0)


def observer_keys(seed: int, robots: int) -> Keys:
    """Return the keys of the chance of a run's robots, shape ``(r,)``."""
    return np.array([hashed(seed, Subsystem.SENSOR, robot) for robot in range(robots)], dtype=np.uint64)


def exposures_until(time: float, rate_hz: float) -> int:
    """Return how many pictures have been taken at a time (s), the first one at 0."""
    return math.floor((time + CLOCK_SLACK) * rate_hz) + 1


@compiled
def mixed(value: np.uint64) -> np.uint64:
    """Return a hash of 64 bits: SplitMix64, as :func:`swarmvision.randomness.draw`."""
    one = (value ^ (value >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    two = (one ^ (one >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return two ^ (two >> np.uint64(31))


@compiled
def chance(key: np.uint64, picture: int, other: int) -> np.uint64:
    """Return 64 random bits of an observer for a picture and a neighbour, unsigned."""
    golden = np.uint64(0x9E3779B97F4A7C15)
    return mixed(mixed(key + np.uint64(picture + 1) * golden) + np.uint64(other + 3) * golden)


@compiled
def bin_of(edges: FloatArray, value: float) -> int:
    """Return the bin of a value: how many edges are at or below it."""
    for n in range(len(edges)):
        if value < edges[n]:
            return n
    return len(edges)


@compiled
def picked(quantiles: FloatArray, first: int, deviate: float) -> float:
    """Return the quantile at a normal deviate, of those from ``first`` on; beyond the last, the last."""
    last = len(DEVIATES) - 1
    place = (deviate - DEVIATES[0]) / (DEVIATES[1] - DEVIATES[0])
    if place <= 0.0:
        return float(quantiles[first])
    if place >= last:
        return float(quantiles[first + last])
    n = int(place)
    low, high = quantiles[first + n], quantiles[first + n + 1]
    return float(low + (place - n) * (high - low))


@compiled
def drift(
    deviates: FloatArray,
    row: int,
    kept: FloatArray,
    new: FloatArray,
    bits: np.uint64,
    normals: FloatArray,
    keep: bool,
) -> None:
    """Let three deviates go on by one picture, or begin; ``bits`` gives 12 to each."""
    for n in range(3):
        fresh = normals[int((bits >> np.uint64(12 * n)) & np.uint64(NORMALS - 1))]
        deviates[row, n] = kept[n] * deviates[row, n] + new[n] * fresh if keep else fresh


@compiled
def share(bits: np.uint64) -> float:
    """Return the upper 28 of 64 random bits as a number in [0, 1)."""
    return float(bits >> np.uint64(36)) * 2.0**-28


@compiled
def erred(
    gap: float,
    bearing: float,
    heading: float,
    quantiles: FloatArray,
    first: int,
    deviates: FloatArray,
    row: int,
    common: FloatArray,
    me: int,
    own: FloatArray,
    shared: FloatArray,
    along: float,
    across: float,
    told: FloatArray,
) -> None:
    """Fill in range, bearing and heading with their errors.

    Args:
        gap: True range (m).
        bearing: True (rad).
        heading: True (rad).
        quantiles: Of the errors, those of one bin ``(3, q)`` from ``first`` on.
        first: Where they begin.
        deviates: Of the neighbours, in this ``row``.
        row: Of the neighbour, here and in ``told``.
        common: Deviates of the observers.
        me: The observer.
        own: Weight of the neighbour's own deviates.
        shared: Weight of the common ones.
        along: Unit of the error of range.
        across: Unit of the error of bearing; its sign is that of the observer's turn.
        told: Out, in this ``row``.
    """
    steps = len(DEVIATES)
    z = own[0] * deviates[row, 0] + shared[0] * common[me, 0]
    told[row, 0] = max(gap + along * picked(quantiles, first, z), NEAREST)
    z = own[1] * deviates[row, 1] + shared[1] * common[me, 1]
    told[row, 1] = wrapped(bearing + across * picked(quantiles, first + steps, z))
    z = own[2] * deviates[row, 2] + shared[2] * common[me, 2]
    sign = 1.0 if across >= 0.0 else -1.0
    told[row, 2] = wrapped(heading + sign * picked(quantiles, first + 2 * steps, z))


@compiled
def _measure(
    me: int,
    found: int,
    other: IntArray,
    sight: FloatArray,
    slot_of: IntArray,
    key: np.uint64,
    picture: int,
    turn_rate: float,
    reach: float,
    again: FloatArray,
    anew: FloatArray,
    fresh: FloatArray,
    fresh_std: FloatArray,
    split: FloatArray,
    keep: FloatArray,
    new: FloatArray,
    own: FloatArray,
    shared: FloatArray,
    normals: FloatArray,
    old_state: IntArray,
    old_deviate: FloatArray,
    old_number: IntArray,
    common: FloatArray,
    following: IntArray,
    who: IntArray,
    age: FloatArray,
    state: IntArray,
    visible: FloatArray,
    deviate: FloatArray,
    number: IntArray,
    told: FloatArray,
    std: FloatArray,
    taken: IntArray,
) -> int:
    """Decide who is measured in a picture, fill in their slots, and return how many."""
    t, sign = bin_of(TURNS, abs(turn_rate)), 1.0 if turn_rate >= 0.0 else -1.0
    count = 0
    for c in range(found):
        j = other[c]
        d, v = bin_of(RANGES, sight[c, 0]), bin_of(VISIBLES, sight[c, 3])
        old = slot_of[j]
        kept = old >= 0 and old_state[old] == MEASURED
        bits = chance(key, picture, j)
        if count == len(who) or share(bits) >= (again[d, t, v] if kept else anew[d, t, v]):
            continue
        if old >= 0:
            for n in range(3):
                deviate[count, n] = old_deviate[old, n]
        drift(deviate, count, keep, new, bits, normals, old >= 0)
        first = ((d * again.shape[1] + t) * again.shape[2] + v) * 3 * len(DEVIATES)
        gap = sight[c, 0]
        erred(
            gap,
            sight[c, 1],
            sight[c, 2],
            fresh,
            first,
            deviate,
            count,
            common,
            me,
            own,
            shared,
            gap * gap,
            sign,
            told,
        )
        if told[count, 0] > reach:
            continue
        who[count], age[count], state[count], visible[count] = j, 0.0, MEASURED, sight[c, 3]
        for n in range(3):
            std[count, n] = fresh_std[d, t, v, n]
        if old >= 0:
            taken[old] = 2 if share(mixed(bits)) < split[t] else 1
        if old >= 0 and taken[old] == 1:
            number[count] = old_number[old]
        else:
            number[count] = following[me]
            following[me] += 1
        count += 1
    return count


@compiled
def _remember(
    pose: FloatArray,
    me: int,
    key: np.uint64,
    picture: int,
    turn_rate: float,
    exposed: bool,
    passed: float,
    memory: float,
    count: int,
    aged: FloatArray,
    aged_std: FloatArray,
    ghost: FloatArray,
    stay: FloatArray,
    own: FloatArray,
    shared: FloatArray,
    old_who: IntArray,
    old_age: FloatArray,
    old_state: IntArray,
    old_visible: FloatArray,
    old_deviate: FloatArray,
    old_number: IntArray,
    common: FloatArray,
    who: IntArray,
    age: FloatArray,
    state: IntArray,
    visible: FloatArray,
    deviate: FloatArray,
    number: IntArray,
    told: FloatArray,
    std: FloatArray,
    taken: IntArray,
) -> int:
    """Carry on what was not measured, from slot ``count``; return how many slots are full then."""
    t, sign = bin_of(TURNS, abs(turn_rate)), 1.0 if turn_rate >= 0.0 else -1.0
    turns, steps = aged_std.shape[1], 3 * len(DEVIATES)
    for n in range(len(old_who)):
        older = old_age[n] + passed
        if old_who[n] == NOBODY or taken[n] == 1 or older > memory + 1e-9 or count == len(who):
            continue
        now = old_state[n]
        if exposed and now == GHOST and share(chance(key, picture, GHOSTLY + old_number[n])) >= stay[0]:
            continue
        if taken[n] == 2:
            now = GHOST
        elif exposed and now == MEASURED:
            now = REMEMBERED
        who[count], age[count], state[count] = old_who[n], older, now
        visible[count], number[count] = old_visible[n], old_number[n]
        a = bin_of(AGES, older)
        for c in range(3):
            deviate[count, c], std[count, c] = old_deviate[n, c], aged_std[a, t, c]
        phantom = who[count] == PHANTOM
        x = deviate[count, 0] if phantom else pose[who[count], 0]
        y = deviate[count, 1] if phantom else pose[who[count], 1]
        yaw = deviate[count, 2] if phantom else pose[who[count], 2]
        dx, dy = x - pose[me, 0], y - pose[me, 1]
        gap = max(np.sqrt(dx * dx + dy * dy), NEAREST)
        bearing, heading = wrapped(np.arctan2(dy, dx) - pose[me, 2]), wrapped(yaw - pose[me, 2])
        if phantom:
            told[count, 0], told[count, 1], told[count, 2] = gap, bearing, heading
        elif now == GHOST:
            erred(
                gap,
                bearing,
                heading,
                ghost,
                a * steps,
                deviate,
                count,
                common,
                me,
                own,
                shared,
                1.0,
                sign / gap,
                told,
            )
        else:
            erred(
                gap,
                bearing,
                heading,
                aged,
                (a * turns + t) * steps,
                deviate,
                count,
                common,
                me,
                own,
                shared,
                1.0,
                sign / gap,
                told,
            )
        count += 1
    return count


@compiled
def _imagine(
    pose: FloatArray,
    me: int,
    key: np.uint64,
    picture: int,
    turn_rate: float,
    reach: float,
    following: IntArray,
    count: int,
    phantom: FloatArray,
    place: FloatArray,
    aged_std: FloatArray,
    keep: FloatArray,
    new: FloatArray,
    normals: FloatArray,
    who: IntArray,
    age: FloatArray,
    state: IntArray,
    visible: FloatArray,
    deviate: FloatArray,
    number: IntArray,
    told: FloatArray,
    std: FloatArray,
) -> int:
    """See, rarely, somebody who is not there; return how many slots are full then."""
    bits = chance(key, picture, PHANTOM)
    if count == len(told) or share(bits) >= phantom[0]:
        return count
    sign = 1.0 if turn_rate >= 0.0 else -1.0
    drift(deviate, count, keep, new, bits, normals, False)
    told[count, 0] = picked(place, 0, deviate[count, 0])
    told[count, 1] = sign * picked(place, len(DEVIATES), deviate[count, 1])
    told[count, 2] = sign * wrapped(2.0 * np.pi * share(mixed(bits)))
    if told[count, 0] > reach:
        return count
    direction = pose[me, 2] + told[count, 1]
    number[count] = following[me]
    following[me] += 1
    who[count], age[count], state[count] = PHANTOM, 0.0, REMEMBERED
    visible[count] = 0.5
    deviate[count, 0] = pose[me, 0] + told[count, 0] * np.cos(direction)
    deviate[count, 1] = pose[me, 1] + told[count, 0] * np.sin(direction)
    deviate[count, 2] = pose[me, 2] + told[count, 2]
    for c in range(3):
        std[count, c] = aged_std[0, 0, c]
    return count + 1


@compiled
def _believe_all(
    scene: tuple[FloatArray, FloatArray, FloatArray],
    time: tuple[BoolArray, FloatArray],
    view: tuple[float, float, float, bool, float, FloatArray, float],
    tables: tuple[FloatArray, ...],
    normals: FloatArray,
    memory: Slots,
    minds: Minds,
    out: Told,
) -> None:
    """Let every robot of every world go through a call of :meth:`ErrorModel.believe`."""
    pose, turn_rate, objects = scene
    exposed, passed = time
    reach, half_fov, radius, occlusion, ahead, things, span = view
    common, following, picture, keys = minds
    # Out of their tuples once: numba counts references to what is taken out of one.
    again, anew, fresh_std, aged_std, split = tables[0], tables[1], tables[3], tables[5], tables[6]
    stay, phantom, keep, new, own, mixture = (
        tables[8],
        tables[9],
        tables[11],
        tables[13],
        tables[14],
        tables[15],
    )
    fresh, aged, ghost, place = tables[16], tables[17], tables[18], tables[19]
    all_who, all_age, all_state, all_visible, all_deviate, all_number = memory
    seen, values, covariance, track, fraction = out
    worlds, r, k = all_who.shape
    candidates, order = np.empty(r, np.int64), np.empty(r, np.int64)
    distance, nearer = np.empty(r), np.empty((3, r))
    few = r if r <= FEW else 0
    gaps, angles = np.empty((few, few)), np.zeros((few, few))
    most = min(r, CANDIDATES * k)
    other, sight, slot_of = np.empty(most, np.int64), np.empty((most, 4)), np.full(r, -1)
    who, age, state = np.empty(k, np.int64), np.empty(k), np.empty(k, np.int64)
    visible, deviate, number = np.empty(k), np.empty((k, 3)), np.empty(k, np.int64)
    told, std, taken = np.empty((k, 3)), np.empty((k, 3)), np.empty(k, np.int64)
    for w in range(worlds):
        if w == 0 or r > FEW:
            grid, begin, robots = cells(pose[w], reach * MARGIN)
        here, there, shared, numbers = pose[w], objects[w], common[w], following[w]
        if few and exposed[w]:
            measure_pairs(here, gaps, angles)
        for i in range(r):
            old_who, old_age, old_state = all_who[w, i], all_age[w, i], all_state[w, i]
            old_visible, old_deviate, old_number = all_visible[w, i], all_deviate[w, i], all_number[w, i]
            key, turn = keys[w, i], turn_rate[w, i]
            count = 0
            taken[:] = 0
            if exposed[w]:
                found = look(
                    here,
                    there,
                    i,
                    reach * MARGIN,
                    half_fov,
                    radius,
                    occlusion,
                    ahead,
                    -1.0,
                    things,
                    grid,
                    begin,
                    robots,
                    gaps,
                    angles,
                    other,
                    sight,
                    candidates,
                    order,
                    distance,
                    nearer,
                )
                for n in range(k):
                    if old_who[n] >= 0 and old_state[n] != GHOST:
                        slot_of[old_who[n]] = n
                drift(
                    shared,
                    i,
                    keep,
                    new,
                    chance(key, picture[w], NOBODY),
                    normals,
                    picture[w] > 0,
                )
                count = _measure(
                    i,
                    found,
                    other,
                    sight,
                    slot_of,
                    key,
                    picture[w],
                    turn,
                    reach,
                    again,
                    anew,
                    fresh,
                    fresh_std,
                    split,
                    keep,
                    new,
                    own,
                    mixture,
                    normals,
                    old_state,
                    old_deviate,
                    old_number,
                    shared,
                    numbers,
                    who,
                    age,
                    state,
                    visible,
                    deviate,
                    number,
                    told,
                    std,
                    taken,
                )
                for n in range(k):
                    if old_who[n] >= 0:
                        slot_of[old_who[n]] = -1
            count = _remember(
                here,
                i,
                key,
                picture[w],
                turn,
                exposed[w],
                passed[w],
                span,
                count,
                aged,
                aged_std,
                ghost,
                stay,
                own,
                mixture,
                old_who,
                old_age,
                old_state,
                old_visible,
                old_deviate,
                old_number,
                shared,
                who,
                age,
                state,
                visible,
                deviate,
                number,
                told,
                std,
                taken,
            )
            if exposed[w]:
                count = _imagine(
                    here,
                    i,
                    key,
                    picture[w],
                    turn,
                    reach,
                    numbers,
                    count,
                    phantom,
                    place,
                    aged_std,
                    keep,
                    new,
                    normals,
                    who,
                    age,
                    state,
                    visible,
                    deviate,
                    number,
                    told,
                    std,
                )
            first = (w * r + i) * k
            for n in range(k):
                slot = first + n
                full = n < count
                seen[slot] = full
                fill = 0.0 if full else np.nan
                for c in range(9):
                    covariance[slot, c] = fill
                if not full:
                    old_who[n], track[slot], fraction[slot] = NOBODY, -1, 0.0
                    for c in range(4):
                        values[c, slot] = np.nan
                    continue
                old_who[n], old_age[n], old_state[n] = who[n], age[n], state[n]
                old_visible[n], old_number[n] = visible[n], number[n]
                track[slot], fraction[slot], values[3, slot] = number[n], visible[n], age[n]
                for c in range(3):
                    old_deviate[n, c] = deviate[n, c]
                    values[c, slot] = told[n, c]
                    covariance[slot, 4 * c] = std[n, c] * std[n, c]
        if exposed[w]:
            picture[w] += 1
