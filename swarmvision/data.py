"""The nouns of the loop: scene, picture, estimates, senses, commands.

Each is a frozen struct of arrays, checked once at birth and never again downstream. Letters of the
shapes: ``r`` robots, ``k`` neighbour slots, ``m`` objects; ``...`` stands for any leading axes,
so that one function serves one robot ``(k,)``, a swarm ``(r, k)`` and many worlds
``(worlds, r, k)``. Empty is a normal value.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from swarmvision.errors import DataError
from swarmvision.geometry import FloatArray, cartesian

BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

SECTOR_BEARINGS = np.array([0, 45, 90, 135, 180, -135, -90, -45]) * np.pi / 180.0
"""Where the eight sectors of a proximity ring look (rad), as Kobot's do."""

_DTYPES = {"seen": np.dtype(np.bool_), "track": np.dtype(np.int64), "kind": np.dtype(np.int64)}

Frame = Literal["lens", "robot"]
"""From where an estimate is measured: a lens centre, or a robot's vertical centre line."""


def _adopt(owner: Any, shapes: dict[str, tuple[tuple[int, ...], type]]) -> None:
    """Replace each named field by our own read-only copy of the given shape and type.

    What nobody can write to any more is shared instead.
    """
    for name, (shape, dtype) in shapes.items():
        given = getattr(owner, name)
        if _is_fixed(given) and given.shape == shape and given.dtype == dtype:
            continue
        array: NDArray[Any] = np.array(given, dtype=dtype)
        if array.shape != shape:
            raise DataError(f"{type(owner).__name__}.{name} must have shape {shape}, got {array.shape}")
        array.setflags(write=False)
        object.__setattr__(owner, name, array)


def _is_fixed(array: Any) -> bool:
    """Return whether nobody can write to an array, nor to what it is a view of."""
    while type(array) is np.ndarray:
        if array.flags.writeable:
            return False
        array = array.base
    return array is None


@lru_cache(maxsize=16)
def _neutral(shape: tuple[int, ...]) -> dict[str, NDArray[Any]]:
    """Return the senses of robots of some shape that sense nothing."""
    sectors = (*shape, len(SECTOR_BEARINGS))
    arrays: dict[str, NDArray[Any]] = {
        "speed": np.zeros(shape),
        "turn_rate": np.zeros(shape),
        "proximity": np.full(sectors, np.inf),
        "proximity_robot": np.zeros(sectors, dtype=bool),
        "goal": np.full((*shape, 2), np.nan),
        "cue": np.zeros(shape),
        "silhouette": np.zeros((*shape, 0), dtype=bool),
        "load": np.full((*shape, 2), np.nan),
    }
    for array in arrays.values():
        array.setflags(write=False)
    return arrays


@lru_cache(maxsize=16)
def _untold(shape: tuple[int, ...]) -> IntArray:
    """Return the kinds of neighbours whose kind is not told."""
    return np.full(shape, -1)


@dataclass(frozen=True, eq=False, slots=True)
class Scene:
    """Everything in the arena that moves, at one instant; its fixed shapes are configuration."""

    time: float
    """s since the start of the run."""
    pose: FloatArray
    """Robots: x (m), y (m), yaw (rad) of the vertical centre line, shape ``(r, 3)``."""
    velocity: FloatArray
    """Robots: dx/dt, dy/dt (m/s), dyaw/dt (rad/s) in the world, shape ``(r, 3)``."""
    wheel_speed: FloatArray
    """Left and right track (m/s) as it is driven, before slip, shape ``(r, 2)``."""
    wheel_travel: FloatArray
    """Way of the left and right track (m) since the start, by the encoders: the integral of
    ``wheel_speed``, shape ``(r, 2)``."""
    object_pose: FloatArray
    """Objects of the arena, in the order of its file: x, y, yaw, shape ``(m, 3)``."""
    object_velocity: FloatArray
    """Objects: dx/dt, dy/dt (m/s), dyaw/dt (rad/s), shape ``(m, 3)``."""

    def __post_init__(self) -> None:
        r, m = len(self.pose), len(self.object_pose)
        _adopt(
            self,
            {
                "pose": ((r, 3), np.float64),
                "velocity": ((r, 3), np.float64),
                "wheel_speed": ((r, 2), np.float64),
                "wheel_travel": ((r, 2), np.float64),
                "object_pose": ((m, 3), np.float64),
                "object_velocity": ((m, 3), np.float64),
            },
        )

    @property
    def robots(self) -> int:
        """How many robots there are."""
        return len(self.pose)

    @classmethod
    def given(cls, time: float, **arrays: FloatArray) -> Self:
        """Return a scene that takes over arrays of its world, which lets go of them, instead of copying.

        They have the shapes and the type of the fields; they become read-only.
        """
        given = object.__new__(cls)
        object.__setattr__(given, "time", time)
        for name, array in arrays.items():
            array.setflags(write=False)
            object.__setattr__(given, name, array)
        return given

    @classmethod
    def at_rest(cls, pose: Any, object_pose: Any = ()) -> Self:
        """Return a scene at time 0 in which nothing moves, from poses ``(r, 3)`` and ``(m, 3)``."""
        pose = np.asarray(pose, dtype=np.float64).reshape(-1, 3)
        objects = np.asarray(object_pose, dtype=np.float64).reshape(-1, 3)
        return cls(
            time=0.0,
            pose=pose,
            velocity=np.zeros_like(pose),
            wheel_speed=np.zeros((len(pose), 2)),
            wheel_travel=np.zeros((len(pose), 2)),
            object_pose=objects,
            object_velocity=np.zeros_like(objects),
        )


@dataclass(frozen=True, eq=False, slots=True)
class Estimates:
    """What observers believe about their neighbours, in ``k`` padded slots each.

    A slot that is not ``seen`` holds nan (``track`` -1, ``visible`` 0). Angles are in (-pi, pi].
    """

    seen: BoolArray
    """Whether the slot holds a neighbour, shape ``(..., k)``."""
    range: FloatArray
    """Horizontal distance to the marker's axis (m), positive, shape ``(..., k)``."""
    bearing: FloatArray
    """Direction of the marker's axis (rad), left positive, shape ``(..., k)``."""
    heading: FloatArray
    """Yaw of the neighbour minus that of the observer (rad); nan where not told, shape ``(..., k)``."""
    covariance: FloatArray
    """Of (range, bearing, heading): m^2, m rad, rad^2; positive definite; the rows of a heading that is
    not told are nan, shape ``(..., k, 3, 3)``."""
    age: FloatArray
    """Time since the neighbour was last measured (s), shape ``(..., k)``."""
    track: IntArray
    """A number that stays with a neighbour while it is tracked; -1 without, shape ``(..., k)``."""
    visible: FloatArray
    """Fraction of the marker's width that was in view and not hidden, 0..1, shape ``(..., k)``."""
    frame: Frame = "robot"
    """Where range and bearing start and what heading is relative to."""
    kind: IntArray | None = None
    """Team that the neighbour belongs to; -1 where the sensor cannot tell, as when left out, ``(..., k)``."""

    def __post_init__(self) -> None:
        shape = np.shape(self.seen)
        if not shape:
            raise DataError("Estimates.seen must have at least one axis, the slots; got a scalar")
        if self.kind is None:
            object.__setattr__(self, "kind", np.full(shape, -1))
        _adopt(
            self,
            {
                "seen": (shape, np.bool_),
                "range": (shape, np.float64),
                "bearing": (shape, np.float64),
                "heading": (shape, np.float64),
                "covariance": ((*shape, 3, 3), np.float64),
                "age": (shape, np.float64),
                "track": (shape, np.int64),
                "visible": (shape, np.float64),
                "kind": (shape, np.int64),
            },
        )

    @classmethod
    def given(cls, **arrays: Any) -> Self:
        """Return estimates that take over arrays of their caller, who lets go of them, instead of copying.

        For sensors that fill new arrays in every step. Shapes and types are checked as ever, and the arrays
        become read-only.

        Raises:
            DataError: If an array has not exactly the shape and type of its field.
        """
        shape = arrays["seen"].shape
        given = object.__new__(cls)
        for field in fields(cls):
            value = arrays.get(field.name)
            if field.name == "frame":
                object.__setattr__(given, "frame", value or "robot")
                continue
            if value is None and field.name == "kind":
                value = _untold(shape)
            wanted = (*shape, 3, 3) if field.name == "covariance" else shape
            dtype = _DTYPES.get(field.name, np.dtype(np.float64))
            if value is None or value.shape != wanted or value.dtype != dtype:
                raise DataError(f"Estimates.{field.name} must be given as {dtype} of shape {wanted}")
            value.setflags(write=False)
            object.__setattr__(given, field.name, value)
        return given

    @property
    def positions(self) -> FloatArray:
        """Neighbours in the observer's frame (m), x forward, y left; nan where unseen, ``(..., k, 2)``."""
        return cartesian(self.range, self.bearing)

    @property
    def count(self) -> IntArray:
        """How many neighbours each observer sees, shape ``(...)``."""
        return np.asarray(np.count_nonzero(self.seen, axis=-1), dtype=np.int64)

    @classmethod
    def empty(cls, shape: tuple[int, ...] = (0,), frame: Frame = "robot") -> Self:
        """Return estimates of the given shape ``(..., k)`` in which nobody is seen."""
        return cls(
            seen=np.zeros(shape, dtype=bool),
            range=np.full(shape, np.nan),
            bearing=np.full(shape, np.nan),
            heading=np.full(shape, np.nan),
            covariance=np.full((*shape, 3, 3), np.nan),
            age=np.full(shape, np.nan),
            track=np.full(shape, -1),
            visible=np.zeros(shape),
            frame=frame,
        )

    @classmethod
    def stack(cls, rows: list[Self]) -> Self:
        """Return one ``(r, k)`` from ``r`` rows ``(k_i,)``; k is the longest row's, short ones are padded."""
        return cls.join([row.select(None) for row in rows]) if rows else cls.empty((0, 0))

    @classmethod
    def join(cls, parts: list[Self]) -> Self:
        """Return one ``(r, k)`` from parts ``(r_i, k_i)``; k is the widest part's, the others are padded."""
        frames = {part.frame for part in parts}
        if len(frames) > 1:
            raise DataError("Estimates.join needs parts of one frame, got lens and robot")
        width = max(part.seen.shape[-1] for part in parts)
        joined = cls.empty((sum(len(part.seen) for part in parts), width), frame=parts[0].frame)
        arrays = {f.name: getattr(joined, f.name).copy() for f in fields(cls) if f.name != "frame"}
        first = 0
        for part in parts:
            rows, k = part.seen.shape
            for name, array in arrays.items():
                array[first : first + rows, :k] = getattr(part, name)
            first += rows
        return cls(**arrays, frame=joined.frame)

    def select(self, index: Any) -> Self:
        """Return the estimates at ``index``, applied alike to the axes of ``seen``."""
        arrays = {f.name: getattr(self, f.name)[index] for f in fields(self) if f.name != "frame"}
        return type(self)(**arrays, frame=self.frame)


@dataclass(frozen=True, eq=False, slots=True)
class Senses:
    """All that robots know when they decide: their neighbours, and what their own bodies tell.

    A sense that a robot does not have holds its neutral value; an axis may then be of length 0.
    """

    neighbours: Estimates
    """Robot frame, shape ``(..., k)``."""
    dt: float
    """Time since the last decision (s)."""
    speed: FloatArray
    """Own forward speed by the encoders (m/s), shape ``(...)``."""
    turn_rate: FloatArray
    """Own turn rate by the encoders (rad/s), shape ``(...)``."""
    proximity: FloatArray
    """Range from the robot's centre to the nearest thing in each of the sectors at ``SECTOR_BEARINGS`` (m);
    inf where there is none or no ring, shape ``(..., 8)``."""
    proximity_robot: BoolArray
    """Whether that thing is a robot, shape ``(..., 8)``."""
    goal: FloatArray
    """Place of the goal in the robot frame (m); nan for a robot that is not informed, ``(..., 2)``."""
    cue: FloatArray
    """What the ground sensor reads, 0..1, shape ``(...)``."""
    silhouette: BoolArray
    """Whether a robot is seen in each of ``p`` equal sectors of the horizon, the first beginning straight
    behind and counted to the left, shape ``(..., p)``."""
    load: FloatArray | None = None
    """Place of the middle of the nearest thing that can be pushed, in the robot frame (m); nan where there is
    none, as when left out, ``(..., 2)``."""

    def __post_init__(self) -> None:
        shape = self.neighbours.seen.shape[:-1]
        if self.load is None:
            object.__setattr__(self, "load", _neutral(shape)["load"])
        directions = np.shape(self.silhouette)[-1]
        sectors = len(SECTOR_BEARINGS)
        _adopt(
            self,
            {
                "speed": (shape, np.float64),
                "turn_rate": (shape, np.float64),
                "proximity": ((*shape, sectors), np.float64),
                "proximity_robot": ((*shape, sectors), np.bool_),
                "goal": ((*shape, 2), np.float64),
                "cue": (shape, np.float64),
                "silhouette": ((*shape, directions), np.bool_),
                "load": ((*shape, 2), np.float64),
            },
        )

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the robots."""
        return self.neighbours.seen.shape[:-1]

    @classmethod
    def of(cls, neighbours: Estimates, dt: float = 0.1, **senses: Any) -> Self:
        """Return the senses of robots that know their neighbours and, beside, only what is given."""
        return cls(neighbours=neighbours, dt=dt, **{**_neutral(neighbours.seen.shape[:-1]), **senses})

    def select(self, index: Any) -> Self:
        """Return the senses of some of the robots; ``index`` is applied to the robots' axes."""
        arrays = {
            f.name: getattr(self, f.name)[index] for f in fields(self) if f.name not in ("neighbours", "dt")
        }
        return type(self)(neighbours=self.neighbours.select(index), dt=self.dt, **arrays)


@dataclass(frozen=True, eq=False, slots=True)
class Commands:
    """What the drives are asked for; the drive limits it, once."""

    speed: FloatArray
    """Forward (m/s), shape ``(...)``."""
    turn_rate: FloatArray
    """Counter-clockwise (rad/s), shape ``(...)``."""

    def __post_init__(self) -> None:
        shape = np.shape(self.speed)
        _adopt(self, {"speed": (shape, np.float64), "turn_rate": (shape, np.float64)})

    @classmethod
    def stop(cls, shape: tuple[int, ...] = ()) -> Self:
        """Return commands to stand still."""
        return cls(speed=np.zeros(shape), turn_rate=np.zeros(shape))


@dataclass(frozen=True, eq=False, slots=True)
class Picture:
    """One photograph of the run, with what was read from it."""

    robot: int
    """Whose camera took it."""
    lens: int
    """Which lens of that robot's rig."""
    pose: FloatArray
    """Of the lens in the world: x, y, yaw, shape ``(3,)``."""
    image: NDArray[np.uint8]
    """RGB, shape ``(h, w, 3)``."""
    estimates: Estimates
    """In the lens frame, shape ``(k,)``."""
