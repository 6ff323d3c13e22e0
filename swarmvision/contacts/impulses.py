"""What contacts do to bodies: sequential impulses with Coulomb friction, and a little room."""

from __future__ import annotations

from swarmvision.compiled import leaf
from swarmvision.contacts.meeting import (
    ARM_AX,
    ARM_AY,
    ARM_BX,
    ARM_BY,
    DEPTH,
    LEVER_A,
    LEVER_B,
    NORMAL_X,
    NORMAL_Y,
    PUSHED,
    RUB,
    RUBBED,
    SIDE_A,
    SIDE_B,
    STIFF,
    STIFF_ASIDE,
)
from swarmvision.data import IntArray
from swarmvision.geometry import FloatArray
from swarmvision.ground import SPIN, VX, VY

ROUNDS = 6  # over the contacts of a substep
STILL = 1e-12  # N s; a round that changes less is the last
OVERLAP = 1e-4  # m that bodies may overlap
LEFT_AFTER_A_SECOND = 0.9**60  # share of an overlap that is left after 1 s: Chipmunk's collision_bias


@leaf
def resolve(
    world: FloatArray, ease: FloatArray, count: int, who: IntArray, contacts: FloatArray, dt: float
) -> None:
    """Stop what approaches, within friction, and move apart some of what overlaps.

    Args:
        world: Bodies, then walls at rest, shape ``(n + 4, 6)``.
        ease: How easily they move (1/kg) and turn (1/(kg m^2)); 0 for what is fixed, ``(n + 4, 2)``.
        count: Of the contacts.
        who: Pairs of bodies.
        contacts: One a row.
        dt: Of the substep (s).
    """
    for c in range(count):
        a, b, row = who[c, 0], who[c, 1], contacts[c]
        nx, ny = row[NORMAL_X], row[NORMAL_Y]
        row[LEVER_A], row[LEVER_B] = row[ARM_AX] * ny - row[ARM_AY] * nx, row[ARM_BX] * ny - row[ARM_BY] * nx
        row[SIDE_A], row[SIDE_B] = row[ARM_AX] * nx + row[ARM_AY] * ny, row[ARM_BX] * nx + row[ARM_BY] * ny
        straight = ease[a, 0] + ease[b, 0]
        along = straight + row[LEVER_A] ** 2 * ease[a, 1] + row[LEVER_B] ** 2 * ease[b, 1]
        aside = straight + row[SIDE_A] ** 2 * ease[a, 1] + row[SIDE_B] ** 2 * ease[b, 1]
        row[STIFF] = 1.0 / along if along > 0.0 else 0.0
        row[STIFF_ASIDE] = 1.0 / aside if aside > 0.0 else 0.0
    for _ in range(ROUNDS):
        change = 0.0
        for c in range(count):
            a, b, row = who[c, 0], who[c, 1], contacts[c]
            mine, theirs, nx, ny = world[a], world[b], row[NORMAL_X], row[NORMAL_Y]
            apart = (theirs[VX] - mine[VX]) * nx + (theirs[VY] - mine[VY]) * ny
            apart += theirs[SPIN] * row[LEVER_B] - mine[SPIN] * row[LEVER_A]
            pushed = max(row[PUSHED] - apart * row[STIFF], 0.0)
            _push(mine, theirs, ease[a], ease[b], nx, ny, row[LEVER_A], row[LEVER_B], pushed - row[PUSHED])
            apart = (theirs[VY] - mine[VY]) * nx - (theirs[VX] - mine[VX]) * ny
            apart += theirs[SPIN] * row[SIDE_B] - mine[SPIN] * row[SIDE_A]
            most = row[RUB] * pushed
            rubbed = min(max(row[RUBBED] - apart * row[STIFF_ASIDE], -most), most)
            _push(mine, theirs, ease[a], ease[b], -ny, nx, row[SIDE_A], row[SIDE_B], rubbed - row[RUBBED])
            change = max(change, abs(pushed - row[PUSHED]), abs(rubbed - row[RUBBED]))
            row[PUSHED], row[RUBBED] = pushed, rubbed
        if change < STILL:
            break
    share = 1.0 - LEFT_AFTER_A_SECOND**dt
    for c in range(count):
        a, b = who[c, 0], who[c, 1]
        easy = ease[a, 0] + ease[b, 0]
        push = share * max(contacts[c, DEPTH] - OVERLAP, 0.0) / easy if easy > 0.0 else 0.0
        for axis in range(2):
            world[a, axis] -= push * ease[a, 0] * contacts[c, axis]
            world[b, axis] += push * ease[b, 0] * contacts[c, axis]


@leaf
def _push(
    mine: FloatArray,
    theirs: FloatArray,
    my_ease: FloatArray,
    their_ease: FloatArray,
    ux: float,
    uy: float,
    my_lever: float,
    their_lever: float,
    push: float,
) -> None:
    """Push two bodies apart along a direction by an impulse (N s) with levers (m) round their middles."""
    mine[VX] -= push * my_ease[0] * ux
    mine[VY] -= push * my_ease[0] * uy
    mine[SPIN] -= push * my_ease[1] * my_lever
    theirs[VX] += push * their_ease[0] * ux
    theirs[VY] += push * their_ease[0] * uy
    theirs[SPIN] += push * their_ease[1] * their_lever
