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
"""seen; range, bearing, heading and age; covariance; track; visible."""
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
                (seen, told, covariance, track, visible),
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
    weights: tuple[FloatArray, FloatArray],
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
        weights: Of the neighbour's own deviates and of the common ones.
        along: Unit of the error of range.
        across: Unit of the error of bearing; its sign is that of the observer's turn.
        told: Out, in this ``row``.
    """
    own, shared = weights
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
    tables: tuple[FloatArray, ...],
    normals: FloatArray,
    mine: Slots,
    common: FloatArray,
    following: IntArray,
    after: Slots,
    told: FloatArray,
    std: FloatArray,
    taken: IntArray,
) -> int:
    """Decide who is measured in a picture, fill in their slots, and return how many."""
    again, anew, fresh_std, split = tables[0], tables[1], tables[3], tables[6]
    who, age, state, visible, deviate, number = after
    weights = (tables[14], tables[15])
    t, sign = bin_of(TURNS, abs(turn_rate)), 1.0 if turn_rate >= 0.0 else -1.0
    count = 0
    for c in range(found):
        j = other[c]
        d, v = bin_of(RANGES, sight[c, 0]), bin_of(VISIBLES, sight[c, 3])
        old = slot_of[j]
        kept = old >= 0 and mine[2][old] == MEASURED
        bits = chance(key, picture, j)
        if count == len(who) or share(bits) >= (again[d, t, v] if kept else anew[d, t, v]):
            continue
        if old >= 0:
            for n in range(3):
                deviate[count, n] = mine[4][old, n]
        drift(deviate, count, tables[11], tables[13], bits, normals, old >= 0)
        first = ((d * again.shape[1] + t) * again.shape[2] + v) * 3 * len(DEVIATES)
        gap = sight[c, 0]
        erred(
            gap,
            sight[c, 1],
            sight[c, 2],
            tables[16],
            first,
            deviate,
            count,
            common,
            me,
            weights,
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
            number[count] = mine[5][old]
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
    tables: tuple[FloatArray, ...],
    mine: Slots,
    common: FloatArray,
    after: Slots,
    told: FloatArray,
    std: FloatArray,
    taken: IntArray,
) -> int:
    """Carry on what was not measured, from slot ``count``; return how many slots are full then."""
    who, age, state, visible, deviate, number = after
    weights = (tables[14], tables[15])
    t, sign = bin_of(TURNS, abs(turn_rate)), 1.0 if turn_rate >= 0.0 else -1.0
    turns, steps = tables[4].shape[1], 3 * len(DEVIATES)
    for n in range(len(mine[0])):
        older = mine[1][n] + passed
        if mine[0][n] == NOBODY or taken[n] == 1 or older > memory + 1e-9 or count == len(who):
            continue
        now = mine[2][n]
        if exposed and now == GHOST and share(chance(key, picture, GHOSTLY + mine[5][n])) >= tables[8][0]:
            continue
        if taken[n] == 2:
            now = GHOST
        elif exposed and now == MEASURED:
            now = REMEMBERED
        who[count], age[count], state[count] = mine[0][n], older, now
        visible[count], number[count] = mine[3][n], mine[5][n]
        a = bin_of(AGES, older)
        for c in range(3):
            deviate[count, c], std[count, c] = mine[4][n, c], tables[5][a, t, c]
        phantom = who[count] == PHANTOM
        x = deviate[count, 0] if phantom else pose[who[count], 0]
        y = deviate[count, 1] if phantom else pose[who[count], 1]
        yaw = deviate[count, 2] if phantom else pose[who[count], 2]
        dx, dy = x - pose[me, 0], y - pose[me, 1]
        gap = max(np.sqrt(dx * dx + dy * dy), NEAREST)
        bearing, heading = wrapped(np.arctan2(dy, dx) - pose[me, 2]), wrapped(yaw - pose[me, 2])
        if phantom:
            told[count, 0], told[count, 1], told[count, 2] = gap, bearing, heading
        else:
            quantiles, first = tables[17], (a * turns + t) * steps
            if now == GHOST:
                quantiles, first = tables[18], a * steps
            erred(
                gap,
                bearing,
                heading,
                quantiles,
                first,
                deviate,
                count,
                common,
                me,
                weights,
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
    tables: tuple[FloatArray, ...],
    normals: FloatArray,
    after: Slots,
    told: FloatArray,
    std: FloatArray,
) -> int:
    """See, rarely, somebody who is not there; return how many slots are full then."""
    bits = chance(key, picture, PHANTOM)
    if count == len(told) or share(bits) >= tables[9][0]:
        return count
    sign = 1.0 if turn_rate >= 0.0 else -1.0
    drift(after[4], count, tables[11], tables[13], bits, normals, False)
    told[count, 0] = picked(tables[19], 0, after[4][count, 0])
    told[count, 1] = sign * picked(tables[19], len(DEVIATES), after[4][count, 1])
    told[count, 2] = sign * wrapped(2.0 * np.pi * share(mixed(bits)))
    if told[count, 0] > reach:
        return count
    direction = pose[me, 2] + told[count, 1]
    after[5][count] = following[me]
    following[me] += 1
    after[0][count], after[1][count], after[2][count] = PHANTOM, 0.0, REMEMBERED
    after[3][count] = 0.5
    after[4][count, 0] = pose[me, 0] + told[count, 0] * np.cos(direction)
    after[4][count, 1] = pose[me, 1] + told[count, 0] * np.sin(direction)
    after[4][count, 2] = pose[me, 2] + told[count, 2]
    for c in range(3):
        std[count, c] = tables[5][0, 0, c]
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
    worlds, r, k = memory[0].shape
    candidates, order = np.empty(r, np.int64), np.empty(r, np.int64)
    distance, nearer = np.empty(r), np.empty((3, r))
    few = r if r <= FEW else 0
    gaps, angles = np.empty((few, few)), np.zeros((few, few))
    most = min(r, CANDIDATES * k)
    other, sight, slot_of = np.empty(most, np.int64), np.empty((most, 4)), np.full(r, -1)
    after = (
        np.empty(k, np.int64),
        np.empty(k),
        np.empty(k, np.int64),
        np.empty(k),
        np.empty((k, 3)),
        np.empty(k, np.int64),
    )
    told, std, taken = np.empty((k, 3)), np.empty((k, 3)), np.empty(k, np.int64)
    for w in range(worlds):
        if w == 0 or r > FEW:
            grid, begin, robots = cells(pose[w], reach * MARGIN)
        here, there, shared, numbers = pose[w], objects[w], common[w], following[w]
        if few and exposed[w]:
            measure_pairs(here, gaps, angles)
        for i in range(r):
            mine = (
                memory[0][w, i],
                memory[1][w, i],
                memory[2][w, i],
                memory[3][w, i],
                memory[4][w, i],
                memory[5][w, i],
            )
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
                    if mine[0][n] >= 0 and mine[2][n] != GHOST:
                        slot_of[mine[0][n]] = n
                drift(
                    shared,
                    i,
                    tables[11],
                    tables[13],
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
                    tables,
                    normals,
                    mine,
                    shared,
                    numbers,
                    after,
                    told,
                    std,
                    taken,
                )
                for n in range(k):
                    if mine[0][n] >= 0:
                        slot_of[mine[0][n]] = -1
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
                tables,
                mine,
                shared,
                after,
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
                    tables,
                    normals,
                    after,
                    told,
                    std,
                )
            _store(w, i, count, after, told, std, memory, out)
        if exposed[w]:
            picture[w] += 1


@compiled
def _store(
    w: int,
    i: int,
    count: int,
    after: Slots,
    told: FloatArray,
    std: FloatArray,
    memory: Slots,
    out: Told,
) -> None:
    """Write a robot's slots into the memory and into the estimates."""
    seen, values, covariance, track, visible = out
    for n in range(len(told)):
        full = n < count
        who = after[0][n] if full else NOBODY
        memory[0][w, i, n] = who
        seen[w, i, n] = full
        for row in range(3):
            for column in range(3):
                covariance[w, i, n, row, column] = 0.0 if full else np.nan
        if not full:
            for c in range(4):
                values[c, w, i, n] = np.nan
            track[w, i, n], visible[w, i, n] = -1, 0.0
            continue
        memory[1][w, i, n], memory[2][w, i, n], memory[3][w, i, n] = after[1][n], after[2][n], after[3][n]
        memory[5][w, i, n] = track[w, i, n] = after[5][n]
        for c in range(3):
            memory[4][w, i, n, c] = after[4][n, c]
            values[c, w, i, n] = told[n, c]
            covariance[w, i, n, c, c] = std[n, c] * std[n, c]
        values[3, w, i, n], visible[w, i, n] = after[1][n], after[3][n]
