"""The state of all bodies of a pymunk space as arrays: read, pushed, and who touches whom.

pymunk's batch interface does it in microseconds but is declared experimental; where it is missing
or has changed, plain loops over the bodies do the same. Nothing else knows about either.
"""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import pymunk

from swarmvision.geometry import FloatArray

try:
    from pymunk import batch
except ImportError:  # pragma: no cover
    batch = None  # type: ignore[assignment]


class Bodies(Protocol):
    """Access to the bodies of a space, in the order in which they were given."""

    state: FloatArray
    """x, y (m), angle (rad), velocity (m/s) and spin (rad/s) as last read, shape ``(n, 6)``."""
    force: FloatArray
    """x and y of the force (N) and the torque (N m) in the next substep, to fill in, shape ``(n, 3)``."""

    def read(self) -> None:
        """Fill in :attr:`state`."""
        ...

    def push(self) -> None:
        """Hand :attr:`force` over."""
        ...

    def touch(self) -> None:
        """Note who touches whom after a substep."""
        ...

    def touched(self) -> set[tuple[int, int]]:
        """Return the pairs noted since the last call, lower number first."""
        ...


def bodies_of(space: pymunk.Space, bodies: Sequence[pymunk.Body]) -> Bodies:
    """Return the fastest access that this pymunk offers; ``bodies`` are all of the space's, as added."""
    if batch is not None and BatchedBodies.works(space, bodies):
        return BatchedBodies(space, bodies)
    return LoopedBodies(space, bodies)


class BatchedBodies:
    """Through ``pymunk.batch``."""

    def __init__(self, space: pymunk.Space, bodies: Sequence[pymunk.Body]) -> None:
        if _ids(space) != [body.id for body in bodies]:
            raise ValueError("pymunk's own order is not the order of adding")
        self._space = space
        self._number = {body.id: i for i, body in enumerate(bodies)}
        n = len(bodies)
        # pymunk writes into our memory; it never grows it, for there is one row more than it fills.
        room = np.zeros((n + 1, 6))
        self.state = room[:n]
        self.force = np.zeros((n, 3))
        buffers: tuple[Any, Any, Any] = (
            _SPARE.pop() if _SPARE else (batch.Buffer(), batch.Buffer(), batch.Buffer())
        )
        weakref.finalize(self, _SPARE.append, buffers)  # pymunk never frees one
        self._state, self._force, self._pairs = buffers
        self._state.set_float_buf(room)
        self._force.set_float_buf(self.force)
        self._pairs.clear()
        self.read()

    @staticmethod
    def works(space: pymunk.Space, bodies: Sequence[pymunk.Body]) -> bool:
        """Return whether the batch interface does what it did in pymunk 7.3."""
        try:
            state = BatchedBodies(space, bodies).state
        except (AttributeError, TypeError, ValueError):
            return False
        return np.array_equal(state, LoopedBodies(space, bodies, listen=False).state)

    def read(self) -> None:
        """Fill in the state of every body."""
        self._state.clear()
        batch.get_space_bodies(self._space, _STATE, self._state)

    def push(self) -> None:
        """Hand the force and torque on every body over."""
        batch.set_space_bodies(self._space, _FORCE, self._force)

    def touch(self) -> None:
        """Note who touches whom; the buffer grows until it is asked for."""
        batch.get_space_arbiters(self._space, _PAIR, self._pairs)

    def touched(self) -> set[tuple[int, int]]:
        """Return the pairs noted since the last call."""
        ids = np.frombuffer(self._pairs.int_buf(), dtype=np.uintp).tolist()
        self._pairs.clear()
        pairs = set(zip(ids[::2], ids[1::2], strict=True))
        numbers = [(self._number[one], self._number[two]) for one, two in pairs]
        return {(min(pair), max(pair)) for pair in numbers}


class LoopedBodies:
    """Body by body, through pymunk's plain interface."""

    def __init__(self, space: pymunk.Space, bodies: Sequence[pymunk.Body], *, listen: bool = True) -> None:
        self._bodies = tuple(bodies)
        self._number = {body: i for i, body in enumerate(bodies)}
        self._pairs: set[tuple[int, int]] = set()
        self.state, self.force = np.zeros((len(bodies), 6)), np.zeros((len(bodies), 3))
        self.read()
        if listen:
            space.on_collision(None, None, pre_solve=self._note)

    def read(self) -> None:
        """Fill in the state of every body."""
        for row, body in zip(self.state, self._bodies, strict=True):
            row[:] = (*body.position, body.angle, *body.velocity, body.angular_velocity)

    def push(self) -> None:
        """Hand the force and torque on every body over."""
        for body, (x, y, torque) in zip(self._bodies, self.force.tolist(), strict=True):
            body.force, body.torque = (x, y), torque

    def touch(self) -> None:
        """Do nothing: pymunk tells."""

    def touched(self) -> set[tuple[int, int]]:
        """Return the pairs noted since the last call."""
        pairs, self._pairs = self._pairs, set()
        return pairs

    def _note(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        one, two = (self._number[body] for body in arbiter.bodies)
        self._pairs.add((min(one, two), max(one, two)))


def _ids(space: pymunk.Space) -> list[int]:
    buffer = batch.Buffer()
    batch.get_space_bodies(space, batch.BodyFields.BODY_ID, buffer)
    return [int(i) for i in np.frombuffer(buffer.int_buf(), dtype=np.uintp)]


_SPARE: list[tuple[Any, Any, Any]] = []  # buffers of worlds that are gone

if batch is not None:
    _STATE = (
        batch.BodyFields.POSITION
        | batch.BodyFields.ANGLE
        | batch.BodyFields.VELOCITY
        | batch.BodyFields.ANGULAR_VELOCITY
    )
    _FORCE = batch.BodyFields.FORCE | batch.BodyFields.TORQUE
    _PAIR = batch.ArbiterFields.BODY_A_ID | batch.ArbiterFields.BODY_B_ID
