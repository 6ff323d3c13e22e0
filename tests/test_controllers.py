"""Laws that every law keeps: mirror, rotation, order, empty, batches, finite for anything.

The tests run over the registry, so a new law is held to them by being there. A law that turns to one side
by declaration is named in ``ONE_SIDED``; what a law draws by chance is switched off by its ``noise``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmvision.config.controller import (
    AvoidanceConfig,
    CohesionConfig,
    ConnectivityConfig,
    GauciConfig,
    KobotConfig,
    LayerConfig,
)
from swarmvision.config.model import validated
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.controllers import LAWS, Controller, controller
from swarmvision.controllers.avoidance import avoid
from swarmvision.controllers.proximal import proximal_force
from swarmvision.data import SECTOR_BEARINGS, Commands, Estimates, Scene, Senses
from swarmvision.geometry import compose
from swarmvision.simulation import Simulation

ONE_SIDED = {"beeclust", "gauci", "random-walk"}
"""Laws that are not their own mirror image, by declaration or by chance."""

EVERY_LAW = pytest.mark.parametrize("name", sorted(LAWS))
STEPS, ROBOTS, SLOTS, DIRECTIONS = 4, 60, 5, 720


def quiet(name: str, **changes: Any) -> Any:
    """Settings of a law without chance, that goes straight on when it is alone."""
    config = LAWS[name].config
    still = {"noise": 0.0, "alone": "keep"}
    return config(**{key: value for key, value in still.items() if key in config.model_fields}, **changes)


def usual(name: str) -> Any:
    return LAWS[name].config()


def keys_of(robots: int) -> np.ndarray:
    return np.arange(1, robots + 1, dtype=np.uint64) * np.uint64(0x1234567)


def played(control: Controller, senses: list[Senses], keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Speeds and turn rates of a run over given senses, ``(steps, ...)`` each."""
    memory, commands = control.begin(keys), []
    for now in senses:
        command, memory = control.step(now, memory)
        commands.append(command)
    return np.array([c.speed for c in commands]), np.array([c.turn_rate for c in commands])


def some_senses(seed: int = 0) -> list[Senses]:
    """What ``ROBOTS`` robots sense in ``STEPS`` steps: neighbours that move a little, all else anyhow."""
    rng = np.random.default_rng(seed)
    shape = (ROBOTS, SLOTS)
    seen = rng.random(shape) < 0.8
    distance, bearing = rng.uniform(0.06, 1.2, shape), rng.uniform(-3.1, 3.1, shape)
    heading = np.where(rng.random(shape) < 0.2, np.nan, rng.uniform(-3.1, 3.1, shape))
    track, kind = np.tile(np.arange(SLOTS), (ROBOTS, 1)), rng.integers(-1, 2, shape)
    run = []
    for _ in range(STEPS):
        distance = np.maximum(distance + rng.uniform(-0.02, 0.02, shape), 0.06)
        bearing = bearing + rng.uniform(-0.05, 0.05, shape)
        neighbours = Estimates(
            seen=seen,
            range=np.where(seen, distance, np.nan),
            bearing=np.where(seen, bearing, np.nan),
            heading=np.where(seen, heading, np.nan),
            covariance=np.where(seen[..., None, None], np.eye(3) * 1e-4, np.nan),
            age=np.where(seen, rng.uniform(0.0, 0.5, shape), np.nan),
            track=np.where(seen, track, -1),
            visible=np.where(seen, 1.0, 0.0),
            kind=np.where(seen, kind, -1),
        )
        near = rng.uniform(0.08, 0.4, (ROBOTS, len(SECTOR_BEARINGS)))
        has_ring = rng.random((ROBOTS, 1)) < 0.5
        knows = rng.random((ROBOTS, 1)) < 0.5
        run.append(
            Senses(
                neighbours,
                dt=0.1,
                speed=rng.uniform(0.0, 0.2, ROBOTS),
                turn_rate=rng.uniform(-1.0, 1.0, ROBOTS),
                proximity=np.where(has_ring, near, np.inf),
                proximity_robot=rng.random(near.shape) < 0.2,
                goal=np.where(knows, rng.uniform(-3.0, 3.0, (ROBOTS, 2)), np.nan),
                load=np.where(has_ring, rng.uniform(-2.0, 2.0, (ROBOTS, 2)), np.nan),
                cue=rng.random(ROBOTS),
                silhouette=rng.random((ROBOTS, DIRECTIONS // 20)).repeat(20, axis=-1) < 0.15,
            )
        )
    return run


def mirrored(senses: Senses) -> Senses:
    """What the robots would sense in a mirror that stands along their heading."""
    there = replace(senses.neighbours, bearing=-senses.neighbours.bearing, heading=-senses.neighbours.heading)
    sectors = [0, 7, 6, 5, 4, 3, 2, 1]
    return replace(
        senses,
        neighbours=there,
        turn_rate=-senses.turn_rate,
        proximity=senses.proximity[..., sectors],
        proximity_robot=senses.proximity_robot[..., sectors],
        goal=senses.goal * (1.0, -1.0),
        load=np.asarray(senses.load) * (1.0, -1.0),
        silhouette=senses.silhouette[..., ::-1],
    )


def shuffled(senses: Senses) -> Senses:
    slots = np.random.default_rng(1).permutation(SLOTS)
    return replace(senses, neighbours=senses.neighbours.select((slice(None), slots)))


@pytest.mark.parametrize("name", sorted(set(LAWS) - ONE_SIDED))
def test_a_mirrored_world_gives_a_mirrored_command(name: str) -> None:
    control, here = controller(quiet(name)), some_senses()
    speed, turn_rate = played(control, here, keys_of(ROBOTS))
    speed_there, turn_rate_there = played(control, [mirrored(s) for s in here], keys_of(ROBOTS))
    np.testing.assert_allclose(speed_there, speed, atol=1e-9)
    np.testing.assert_allclose(turn_rate_there, -turn_rate, atol=1e-9)


@EVERY_LAW
def test_the_order_of_neighbours_does_not_matter(name: str) -> None:
    control, here = controller(usual(name)), some_senses()
    other = played(control, [shuffled(s) for s in here], keys_of(ROBOTS))
    np.testing.assert_allclose(other, played(control, here, keys_of(ROBOTS)), atol=1e-9)


@EVERY_LAW
def test_a_batch_is_its_members(name: str) -> None:
    control, here, keys = controller(usual(name)), some_senses(), keys_of(ROBOTS)
    together = np.array(played(control, here, keys))
    for robot in range(0, ROBOTS, 7):
        alone = played(control, [s.select(robot) for s in here], keys[robot])
        np.testing.assert_allclose(alone, together[..., robot], atol=1e-12)
    worlds = played(control, [s.select(None) for s in here], keys[None])
    np.testing.assert_allclose(worlds, together[:, :, None], atol=1e-12)


@EVERY_LAW
@pytest.mark.parametrize("shape", [(0,), (4, 0), (0, 3), (2, 4, 3)], ids=str)
def test_nobody_to_see_and_nobody_to_steer_are_normal(name: str, shape: tuple[int, ...]) -> None:
    nobody = Senses.of(Estimates.empty(shape))
    keys = np.zeros(shape[:-1], dtype=np.uint64)
    speed, turn_rate = played(controller(usual(name)), [nobody] * 3, keys)
    assert speed.shape == turn_rate.shape == (3, *shape[:-1])
    assert np.isfinite(speed).all()
    assert np.isfinite(turn_rate).all()


@pytest.mark.parametrize("name", sorted(n for n in LAWS if "alone" in LAWS[n].config.model_fields))
def test_a_lone_robot_does_what_was_declared(name: str) -> None:
    nobody = Estimates.empty((4,))

    def lone(alone: str) -> Commands:
        return controller(quiet(name).replace(alone=alone)).act(nobody)

    assert lone("keep").speed > 0.0
    assert float(lone("keep").turn_rate) == 0.0
    assert (float(lone("stop").speed), float(lone("stop").turn_rate)) == (0.0, 0.0)
    assert float(lone("scan").speed) == 0.0
    assert lone("scan").turn_rate > 0.0


anything = st.floats(allow_nan=False, allow_infinity=False)
slot = st.tuples(
    st.floats(1e-300, 1e300), anything, st.one_of(st.floats(-4.0, 4.0), st.just(np.nan), anything)
)


@EVERY_LAW
@settings(max_examples=30, deadline=None)
@given(
    rows=st.lists(slot, max_size=5),
    near=st.lists(st.floats(0.0), min_size=8, max_size=8),
    goal=st.tuples(anything, anything),
    age=st.floats(0.0, 1e6),
    speed=st.floats(-10.0, 10.0),
    dt=st.floats(1e-3, 1.0),
)
def test_commands_are_finite_for_anything(
    name: str,
    rows: list[tuple[float, float, float]],
    near: list[float],
    goal: tuple[float, float],
    age: float,
    speed: float,
    dt: float,
) -> None:
    neighbours = seen(*rows, age=age)
    silhouette = np.arange(DIRECTIONS) % 7 < len(rows)
    senses = Senses.of(
        neighbours,
        dt,
        speed=speed,
        turn_rate=-speed,
        proximity=near,
        goal=goal,
        load=goal[::-1],
        silhouette=silhouette,
    )
    key = np.zeros((), dtype=np.uint64)
    layers: list[LayerConfig] = [AvoidanceConfig(), ConnectivityConfig()]
    commands = played(controller(usual(name), layers), [senses, mirrored(senses), senses], key)
    assert np.isfinite(commands).all()


@pytest.mark.parametrize(
    "layer", [AvoidanceConfig(slow_range=0.5), ConnectivityConfig()], ids=lambda c: c.layer
)
def test_a_layer_keeps_the_mirror_and_ignores_the_order(layer: LayerConfig) -> None:
    control, bare, here = controller(quiet("kobot"), [layer]), controller(quiet("kobot")), some_senses()
    speed, turn_rate = played(control, here, keys_of(ROBOTS))
    assert (played(bare, here, keys_of(ROBOTS))[0] != speed).any()
    for there, sign in ((mirrored, -1.0), (shuffled, 1.0)):
        speed_there, turn_rate_there = played(control, [there(s) for s in here], keys_of(ROBOTS))
        np.testing.assert_allclose(speed_there, speed, atol=1e-9)
        np.testing.assert_allclose(turn_rate_there, sign * turn_rate, atol=1e-9)


@pytest.mark.parametrize(
    ("going", "turning", "place", "braked_to", "turned_by"),
    [
        (0.2, 0.0, (0.30, 0.5), 0.2, 0.0),  # beyond slow_range
        (0.2, 0.0, (0.15, np.pi / 2), 0.2, 0.0),  # beside
        (0.2, 0.0, (0.15, np.pi), 0.2, 0.0),  # behind
        (0.2, 0.0, (0.10, 0.0), 0.0, 2.0),  # exactly ahead: stands, and turns left
        (0.2, -0.1, (0.10, 0.0), 0.0, -2.0),  # exactly ahead, but it turns right already
        (0.2, 0.0, (0.15, np.pi / 3), 0.15, -0.5),  # half way in, half of that through the cosine
        (-0.2, 0.0, (0.15, np.pi - np.pi / 3), -0.15, 0.5),  # the same, backwards
    ],
)
def test_avoidance_brakes_before_what_is_ahead_and_turns_away(
    going: float, turning: float, place: tuple[float, float], braked_to: float, turned_by: float
) -> None:
    config = AvoidanceConfig(stop_range=0.10, slow_range=0.20, turn_gain=2.0)
    asked = Commands(np.array(going), np.array(turning))
    got = avoid(asked, Senses.of(seen((*place, 0.0))), config)
    assert float(got.speed) == pytest.approx(braked_to, abs=1e-12)
    assert float(got.turn_rate - turning) == pytest.approx(turned_by)


@EVERY_LAW
def test_a_turned_and_shifted_world_gives_the_same_commands(name: str) -> None:
    move = np.array([3.0, -2.0, 2.2])
    goal = np.array([1.0, 2.0, 0.0])

    def commands(moved: bool) -> tuple[np.ndarray, np.ndarray]:
        x, y, _ = compose(move, goal) if moved else goal
        values = {
            "robots": 6,
            "sensor": {"kind": "truth"},
            "start": {"radius": 0.4},
            "controller": usual(name).model_dump(),
            "goal": {"x": float(x), "y": float(y)},
        }
        simulation = Simulation(validated(ScenarioConfig, values, "test"), 8)
        pose = simulation.scene.pose
        simulation.scene = Scene.at_rest(compose(move, pose) if moved else pose)
        decided = simulation.decide(simulation.feel(simulation.sense()))
        return decided.speed, decided.turn_rate

    np.testing.assert_allclose(commands(True), commands(False), atol=1e-9)


def seen(*neighbours: tuple[float, float, float], slots: int | None = None, age: float = 0.0) -> Estimates:
    """Estimates ``(k,)`` of range, bearing, heading; the other slots are empty."""
    k = slots or len(neighbours)
    empty = Estimates.empty((k,))
    names = ("seen", "range", "bearing", "heading", "age", "track")
    columns = {name: getattr(empty, name).copy() for name in names}
    for i, row in enumerate(neighbours):
        columns["seen"][i], columns["age"][i], columns["track"][i] = True, age, i
        columns["range"][i], columns["bearing"][i], columns["heading"][i] = row
    return Estimates(**columns, covariance=empty.covariance, visible=empty.visible)


def test_kobot_turns_towards_its_neighbours_heading() -> None:
    # At the desired range nothing pulls; with itself at 0 and one neighbour at 90 deg the mean is 45 deg.
    command = controller(KobotConfig()).act(seen((0.25, 0.0, np.pi / 2)))
    assert command.turn_rate == pytest.approx(2.0 * np.pi / 4)
    assert command.speed == pytest.approx(0.10 * np.cos(np.pi / 4))


def test_the_proximal_force_pushes_near_and_pulls_far() -> None:
    force = proximal_force(np.array([0.12, 0.185, 0.25, 0.425, 0.60]), KobotConfig())
    np.testing.assert_allclose(force, [-1, -0.25, 0, 0.25, 1])


def test_gauci_sends_the_two_pairs_of_wheel_speeds() -> None:
    law = controller(GauciConfig(speed=0.1, track=0.1)).act
    ahead, aside = law(seen((1.0, 0.05, 0.0))), law(seen((1.0, 0.2, 0.0)))
    assert (ahead.speed, ahead.turn_rate) == pytest.approx((0.0, -2.0))
    assert (aside.speed, aside.turn_rate) == pytest.approx((-0.085, -0.3))


def test_padding_does_not_matter() -> None:
    for config in (KobotConfig(), CohesionConfig()):
        rows = [(0.3, 0.2, 1.0), (0.5, -1.0, np.nan)]
        short, padded = controller(config).act(seen(*rows)), controller(config).act(seen(*rows, slots=9))
        np.testing.assert_allclose(
            (short.speed, short.turn_rate), (padded.speed, padded.turn_rate), atol=1e-12
        )
