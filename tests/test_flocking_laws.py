"""What each law of motion does by hand calculation: forces, zones, links, views."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from test_controllers import keys_of, played, seen

from swarmvision.config.controller import (
    AvoidanceConfig,
    ConnectivityConfig,
    CouzinConfig,
    ElasticConfig,
    FerranteConfig,
    FollowConfig,
    GregoireConfig,
    InformedConfig,
    KobotConfig,
    MoshtaghConfig,
    OlfatiSaberConfig,
    RandomWalkConfig,
    TannerConfig,
    VicsekConfig,
    VisualConfig,
)
from swarmvision.config.model import validated
from swarmvision.controllers import controller, gregoire, moshtagh, visual
from swarmvision.controllers.connectivity import stay_in_sight
from swarmvision.controllers.ferrante import lennard_jones
from swarmvision.controllers.olfati_saber import phi_alpha
from swarmvision.data import Commands, Estimates, Senses
from swarmvision.errors import ConfigError
from swarmvision.geometry import compose, inverse, polar

ONE = np.array(7, dtype=np.uint64)


def act(config: Any, *rows: tuple[float, float, float], **senses: Any) -> tuple[float, float]:
    """First speed and turn rate of one robot."""
    control = controller(config)
    command, _ = control.step(Senses.of(seen(*rows), **senses), control.begin(ONE))
    return float(command.speed), float(command.turn_rate)


def test_ferrante_needs_no_headings_and_no_force_at_the_desired_range() -> None:
    config = FerranteConfig()
    assert act(config, (0.25, 1.0, np.nan)) == pytest.approx((0.06, 0.0), abs=1e-12)
    assert act(config, (0.3, 1.0, 0.5), (0.2, 0.3, -2.0)) == act(config, (0.3, 1.0, np.nan), (0.2, 0.3, 0.0))
    near, far = act(config, (0.2, 0.5, np.nan)), act(config, (0.35, 0.5, np.nan))
    assert near[0] < 0.06 < far[0]
    assert near[1] < 0.0 < far[1]


def test_the_lennard_jones_force_is_that_of_the_formula_and_limited() -> None:
    # d = 0.25, a = 2: sigma^2 = d^2/2; at r = 0.5 (sigma/r)^2 = 1/8, F = 8*0.02/0.5*(1/8 - 2/64) = 0.03
    config = FerranteConfig(exponent=2.0, strength=0.02, force_limit=2.0)
    force = lennard_jones(np.array([0.5, 0.25, 0.01]), config)
    np.testing.assert_allclose(force, [0.03, 0.0, -2.0], atol=1e-12)


def test_a_spring_of_the_elastic_sheet_pulls_with_its_stretch() -> None:
    # 0.375 m is half again 0.25 m: force 0.5 to the left.
    assert act(ElasticConfig(), (0.375, np.pi / 2, np.nan)) == pytest.approx((0.06, 2.0))


def test_the_informed_turn_to_the_goal_and_the_others_are_kobots() -> None:
    rows = [(0.3, 0.5, 0.4), (0.2, -1.0, np.nan)]
    assert act(InformedConfig(), *rows) == act(KobotConfig(), *rows)
    # Alone with the goal straight left: h + 0.5 g = 1 + 0.5 i.
    _, turn_rate = act(InformedConfig(goal_gain=0.5), goal=(0.0, 2.0))
    assert turn_rate == pytest.approx(2.0 * np.arctan2(0.5, 1.0))


def test_an_obstacle_in_the_ring_pushes_but_a_robot_in_it_does_not() -> None:
    near = np.full(8, np.inf)
    near[1] = 0.15  # ahead to the left
    for config in (KobotConfig(), FerranteConfig()):
        _, away = act(config, proximity=near)
        assert away < 0.0
        ignored = act(config, proximity=near, proximity_robot=np.ones(8, dtype=bool))
        assert ignored[1] == 0.0


def test_vicsek_takes_the_mean_heading_and_its_noise_is_even() -> None:
    config = VicsekConfig(noise=0.0, turn_gain=1.0)
    assert act(config, (0.3, 0.0, np.pi / 2)) == pytest.approx((0.10, np.pi / 4))
    noisy = controller(VicsekConfig(noise=0.6, turn_gain=1.0, turn_limit=10.0))
    crowd = Estimates.stack([seen((0.3, 0.0, 0.0))] * 4000)
    command, _ = noisy.step(Senses.of(crowd), noisy.begin(keys_of(4000)))
    assert np.abs(command.turn_rate).max() <= 0.3
    # An even distribution of width w has the standard deviation w / sqrt(12).
    assert np.std(command.turn_rate) == pytest.approx(0.6 / np.sqrt(12.0), rel=0.05)


def test_couzins_zones_flee_align_and_approach() -> None:
    config = CouzinConfig(noise=0.0, turn_gain=1.0, turn_limit_deg=1000.0)
    flee = act(config, (0.1, 0.5, 0.0), (0.3, 1.0, 1.0))  # the other one does not matter
    assert flee[1] == pytest.approx(0.5 - np.pi)
    assert act(config, (0.3, -1.0, 0.7))[1] == pytest.approx(0.7)
    assert act(config, (0.8, -1.0, 0.7))[1] == pytest.approx(-1.0)
    assert act(config, (0.3, 0.0, 0.4), (0.8, 1.0, 0.0))[1] == pytest.approx(0.7)
    blind = config.replace(fov_deg=180.0)
    assert act(blind, (0.8, 2.0, 0.7))[1] == 0.0
    assert act(blind, (0.1, 2.0, 0.7))[1] == pytest.approx(2.0 - np.pi)


def test_gregoires_force_is_core_line_and_plateau() -> None:
    force = gregoire.force(np.array([0.1, 0.25, 0.325, 0.5]), GregoireConfig())
    np.testing.assert_allclose(force, [-gregoire.CORE, 0.0, 0.125, 1.0])


def test_olfati_sabers_force_is_nought_at_the_spacing_and_beyond_the_reach() -> None:
    force = phi_alpha(np.array([4.0, 7.0, 8.0, 8.4, 20.0]))
    assert force[0] < 0.0 < force[2]
    np.testing.assert_allclose(force[[1, 3, 4]], 0.0, atol=1e-12)


def test_olfati_saber_holds_its_course_in_the_lattice_and_slows_before_a_wall() -> None:
    config = OlfatiSaberConfig()
    level = act(config, (0.25, 1.0, 0.0), speed=config.speed)
    assert level == pytest.approx((config.speed, 0.0), abs=1e-9)
    wall = np.full(8, np.inf)
    wall[0] = 0.12
    assert act(config, (0.25, 1.0, 0.0), speed=config.speed, proximity=wall)[0] < config.speed


def test_a_fixed_topology_does_not_take_in_newcomers() -> None:
    first = Senses.of(seen((0.25, 0.0, 0.0)), speed=0.1)
    second = Senses.of(seen((0.25, 0.0, 0.0), (0.15, 1.0, 0.0)), speed=0.1)
    turned = {
        topology: played(controller(TannerConfig(topology=topology)), [first, second], ONE)[1][1]
        for topology in ("fixed", "dynamic")
    }
    assert turned["fixed"] == pytest.approx(0.0, abs=1e-9)
    assert turned["dynamic"] < -0.01


def test_moshtagh_finds_the_sine_of_a_heading_it_never_sees() -> None:
    config, dt, speed = MoshtaghConfig(smoothing=0.0), 0.02, 0.10
    me, other = np.array([0.0, 0.0, 0.3]), np.array([0.4, 0.2, 1.2])
    own_turn = 0.4
    flow = moshtagh.begin(config, ONE)
    for _ in range(2):
        distance, bearing, heading = polar(compose(inverse(me), other))
        senses = Senses.of(
            seen((float(distance), float(bearing), np.nan)), dt, speed=speed, turn_rate=own_turn
        )
        _, flow = moshtagh.align(senses, flow, config)
        me = me + dt * np.array([speed * np.cos(me[2]), speed * np.sin(me[2]), own_turn])
        other = other + dt * np.array([speed * np.cos(other[2]), speed * np.sin(other[2]), 0.0])
    # A difference over dt is off by about dt times the rates, here 0.02 s * 1 rad/s.
    np.testing.assert_allclose(moshtagh.sine_of_heading(flow, speed), [np.sin(heading)], atol=0.03)


def test_a_robot_ahead_is_at_rest_at_the_width_that_the_edges_weight_tells() -> None:
    phi = (np.arange(7200) + 0.5) * 2.0 * np.pi / 7200 - np.pi
    for half, sign in ((0.06, 1.0), (0.12, -1.0)):
        area, edges = visual.view(np.abs(phi) < half)
        np.testing.assert_allclose(area, 2.0 * np.sin(half), atol=1e-3)
        np.testing.assert_allclose(edges, 2.0 * np.cos(half), atol=1e-3)
        assert np.sign(np.tan(0.09) * edges.real - area.real) == sign
    senses = {"silhouette": np.abs(phi - 1.0) < 0.3, "speed": 0.1}
    assert act(VisualConfig(), **senses)[1] < 0.0  # wide on the left: away to the right


def test_a_follower_follows_the_nearest_ahead_that_goes_its_way() -> None:
    config = FollowConfig()
    assert act(config, (0.25, 0.0, 0.0)) == pytest.approx((0.10, 0.0))
    behind, towards_me, ahead = (0.2, 3.0, 0.0), (0.28, -0.3, 3.0), (0.3, 0.2, 0.1)
    assert act(config, behind, towards_me, ahead) == pytest.approx(
        (0.10 + 0.8 * 0.05 * np.cos(0.2), 2.0 * 0.2)
    )
    assert act(config, behind) == (0.0, 1.0)  # it looks about


def test_random_walks_are_their_robots_own_and_last() -> None:
    walk = controller(RandomWalkConfig(persistence=1.0))
    nobody = Senses.of(Estimates.empty((50, 0)))
    speed, turn_rate = played(walk, [nobody] * 30, keys_of(50))
    assert (speed == 0.10).all()
    changes = np.count_nonzero(np.diff(turn_rate, axis=0), axis=0)
    assert set(changes.tolist()) <= {2, 3}  # in 2.9 s, once a second
    assert len(np.unique(turn_rate[0])) == 50
    np.testing.assert_array_equal(
        played(walk, [nobody.select(slice(3, 5))] * 30, keys_of(50)[3:5])[1], turn_rate[:, 3:5]
    )


def test_robots_under_the_connectivity_layer_never_lose_each_other() -> None:
    rng, config, dt = np.random.default_rng(3), ConnectivityConfig(reach=0.8, horizon=0.1), 0.1
    pose = np.concatenate([rng.uniform(-0.2, 0.2, (200, 2, 2)), rng.uniform(-3, 3, (200, 2, 1))], axis=-1)
    held = 0
    for _ in range(100):
        other = pose[:, ::-1]
        distance, bearing, heading = polar(compose(inverse(pose), other))
        assert distance.max() <= config.reach + 1e-9
        rows = Estimates.empty((200, 2, 1))
        there = replace(
            rows,
            seen=np.ones((200, 2, 1), dtype=bool),
            range=distance[..., None],
            bearing=bearing[..., None],
            heading=heading[..., None],
        )
        asked = Commands(rng.uniform(0.0, 0.4, (200, 2)), np.zeros((200, 2)))
        got = stay_in_sight(asked, Senses.of(there, dt), config)
        held += int(np.count_nonzero(got.speed < asked.speed))
        step = np.stack([got.speed * dt, np.zeros_like(got.speed), np.zeros_like(got.speed)], axis=-1)
        pose = compose(pose, step)
        pose[..., 2] += got.turn_rate * dt
    assert held > 1000


def test_layers_go_by_their_names() -> None:
    near, law = seen((0.15, 0.0, 0.0)), VicsekConfig()
    braked = controller(law, [AvoidanceConfig(), ConnectivityConfig()]).act(near)
    assert float(braked.speed) == pytest.approx(law.speed / 2.0)  # half way from 0.20 m to 0.10 m


def test_settings_that_contradict_each_other_are_refused() -> None:
    with pytest.raises(ConfigError, match="speed <= top_speed"):
        validated(FerranteConfig, {"speed": 0.3, "top_speed": 0.1}, "test")
    with pytest.raises(ConfigError, match="core < desired_range < attraction < reach"):
        validated(GregoireConfig, {"core": 0.5}, "test")
