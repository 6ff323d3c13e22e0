"""Looking only where known neighbours should be: nobody is read otherwise or lost, and the new are found."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.config.arena import ARENAS
from swarmvision.config.camera import LENSES
from swarmvision.config.robot import RobotConfig
from swarmvision.config.sensor import CameraSensorConfig, TrackerConfig
from swarmvision.data import Commands, Estimates, Scene
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.perception.gaze import DOOR, Aim, Gaze, gaze, windows_room
from swarmvision.perception.plan import Task
from swarmvision.perception.track import Law, Tracks, take_in
from swarmvision.rendering.raycast import Raycaster
from swarmvision.sensing.camera import CameraSensor
from swarmvision.world import World

ROBOT, ARENA = RobotConfig(), ARENAS["open"]
LENS = Lens.from_config(LENSES["pi-v1"])
READER = Reader(LENS, Marker.from_config(ROBOT.marker))
LAW = Law.of(TrackerConfig())
RATE, EVERY = 32.0, 3  # Hz; and every how many pictures are looked at all over by default
PLACES = np.array([[0.35, 0.08, 1.0], [0.5, -0.15, 2.0], [0.9, 0.3, -1.0], [0.3, -0.13, 0.2]])


def task() -> Task:
    assert READER.task is not None
    return READER.task


def tracks_at(places: FloatArray, std: float = 0.003) -> Tracks:
    """What a robot remembers that has just seen neighbours at poses ``(k, 3)`` in its own frame."""
    tracks = Tracks.of(1)
    rows = np.column_stack([places, np.ones(len(places))])
    take_in(tracks, 0, rows, np.tile(np.diag([std, std, 0.05]) ** 2, (len(places), 1, 1)), LAW)
    return tracks


def look(tracks: Tracks, whole: bool = False, farthest: float = 1.5) -> Gaze:
    return gaze(tracks, 0, np.zeros(3), task(), Aim.of(task(), farthest), whole, windows_room())


def picture(places: FloatArray) -> np.ndarray:
    scene = Scene.at_rest(np.vstack([[[-1.0, 0.0, 0.0]], places]))
    return Raycaster(LENS, ROBOT, ARENA).render(scene, np.zeros(3), 0)


def share(looked: Gaze) -> float:
    """How much of a picture is looked at."""
    windows, every = looked.windows.astype(float), Gaze.at_all(task()).windows[0]
    sizes = (windows[:, 1] - windows[:, 0]) * (windows[:, 3] - windows[:, 2])
    return float(sizes.sum()) / float(every[1] * every[3])


@pytest.mark.parametrize("count", [1, 2, 4])
def test_who_is_where_expected_is_read_to_the_same_bits(count: int) -> None:
    image, looked = picture(PLACES[:count]), look(tracks_at(PLACES[:count]))
    assert share(looked) < 0.6
    there, everywhere = READER.read(image, looked), READER.read(image)
    assert len(there.seen) == count
    np.testing.assert_array_equal(there.range, everywhere.range)
    np.testing.assert_array_equal(there.heading, everywhere.heading)
    np.testing.assert_array_equal(there.covariance, everywhere.covariance)


def test_windows_share_no_column_and_hold_every_marker() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        distance, bearing = rng.uniform(0.15, 1.5, 12), rng.uniform(-3.0, 3.0, 12)
        places = np.column_stack([distance * np.cos(bearing), distance * np.sin(bearing), bearing])
        windows = look(tracks_at(places)).windows
        spans = windows[np.argsort(windows[:, 0]), :2]
        assert (spans[1:, 0] >= spans[:-1, 1]).all()
        assert (windows[:, 0] % 4 == 0).all()
        half = np.arcsin(0.02 / distance)
        for angle in (bearing + half, bearing - half):
            seen = np.abs(angle) < LENS.fov / 2.0
            column = LENS.column_from_bearing(angle[seen]) / 2.0  # of the grid
            held = (column[:, None] >= windows[:, 0]) & (column[:, None] <= windows[:, 1])
            assert held.any(axis=1).all()


def test_who_is_unsure_looks_wider() -> None:
    sure, unsure = (share(look(tracks_at(PLACES[:1], std))) for std in (0.002, 0.02))
    assert sure < unsure <= 1.0


def test_everything_is_looked_at_when_asked_alone_or_after_a_loss() -> None:
    tracks = tracks_at(PLACES)
    assert share(look(tracks, whole=True)) == 1.0
    assert share(look(Tracks.of(1))) == 1.0
    take_in(tracks, 0, np.empty((0, 4)), np.empty((0, 3, 3)), LAW)
    assert share(look(tracks)) == 1.0
    take_in(tracks, 0, np.empty((0, 4)), np.empty((0, 3, 3)), LAW)  # long lost: where it should be
    assert share(look(tracks)) < 1.0


def test_neighbours_behind_the_lens_need_no_look_but_at_the_sides() -> None:
    width = task().look.columns.size
    windows = look(tracks_at(PLACES * [-1.0, 1.0, 1.0])).windows
    np.testing.assert_array_equal(windows[:, :2], [[0, DOOR], [width - DOOR, width]])


def test_who_comes_in_at_a_side_or_from_behind_is_read_to_the_same_bits_or_not_at_all() -> None:
    known, read = PLACES[:1], 0
    for bearing in np.linspace(-0.44, 0.44, 23):
        new = [0.6 * np.cos(bearing), 0.6 * np.sin(bearing), 0.5]
        image = picture(np.vstack([known, [new]]))
        there, everywhere = READER.read(image, look(tracks_at(known))), READER.read(image)
        known_only = np.isin(there.range, everywhere.range)
        assert known_only.all()
        read += len(there.seen) == len(everywhere.seen) == 2
    assert read >= 6


def test_who_is_beyond_reach_is_not_read() -> None:
    image = picture(np.array([[0.5, 0.1, 0.0], [1.9, -0.3, 0.0]]))
    assert len(READER.read(image).seen) == 2
    all_of_it = Aim.of(task(), 1.0)
    near = READER.read(image, Gaze(all_of_it.everywhere, all_of_it.least))
    assert len(near.seen) == 1
    assert near.range[0] == pytest.approx(0.5, abs=0.12)


def sensor(robots: int, workers: int = 1, **settings: Any) -> CameraSensor:
    defaults = {"rig": "single", "rate_hz": RATE, "imperfections": {"dropped": 0, "late": 0}}
    config = CameraSensorConfig.model_validate({**defaults, **settings})
    return CameraSensor(config, ROBOT, ARENA, robots, seed=3, workers=workers)


def at(pose: FloatArray, step: int) -> Scene:
    scene = Scene.at_rest(pose)
    names = ("pose", "velocity", "wheel_speed", "wheel_travel", "object_pose", "object_velocity")
    return Scene(time=step / RATE, **{name: getattr(scene, name) for name in names})


@pytest.mark.parametrize("when", range(EVERY))
def test_the_new_are_found_within_every_third_picture(when: int) -> None:
    """Of three observers side by side, who look all over their pictures at different times."""
    observers = np.array([[0.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 6.0, 0.0]])
    old, new = observers + np.array([[0.5, 0.1, 1.0]]), observers + np.array([[0.6, -0.15, 2.0]])
    behind = new - np.array([[2.0, 0.0, 0.0]])
    watching, found = sensor(9), []
    for step in range(8 + when + EVERY):
        there = new if step >= 8 + when else behind
        seen = watching.sense(at(np.vstack([observers, old, there]), step))
        found.append([int((seen.seen[i] & (seen.age[i] == 0.0)).sum()) for i in range(3)])
    assert found[0] == found[7 + when] == [1, 1, 1]
    assert found[-1] == [2, 2, 2]
    turns = {tuple(row) for row in found[8 + when : 7 + when + EVERY]}
    assert turns != {(1, 1, 1)}  # not all of them look at once


CIRCLE = np.array([[0.4 * np.cos(a), 0.4 * np.sin(a), 2.5 * a + 1] for a in np.arange(6) * np.pi / 3])


def dance(watching: CameraSensor, steps: int) -> list[Estimates]:
    """What robots believe who turn and drive in circles, into each other's view and out of it."""
    world, out = World(ARENA, ROBOT, Scene.at_rest(CIRCLE)), []
    drive = Commands(np.full(6, 0.05), np.array([1.5, -1.5, 1.0, -1.0, 0.8, -0.8]))
    for _ in range(steps):
        out.append(watching.sense(world.scene))
        world.step(drive, 1.0 / RATE, 4)
    return out


def fresh(run: list[Estimates]) -> int:
    return sum(int((seen.seen & (seen.age == 0.0)).sum()) for seen in run)


def test_nobody_is_lost_by_it_over_a_run() -> None:
    """Who comes into view is found two pictures later at most; nobody else may be missed, or seen twice."""
    often, seldom = (dance(sensor(6, tracker={"search": s}), 64) for s in (0.0, 0.1))
    numbers = [max(int(seen.track.max(initial=-1)) for seen in run) for run in (often, seldom)]
    assert 0.97 * fresh(often) <= fresh(seldom) <= fresh(often)
    assert abs(numbers[0] - numbers[1]) <= 1


def test_at_ten_hertz_every_picture_is_looked_at_all_over() -> None:
    runs = [dance(sensor(6, rate_hz=10.0, tracker={"search": s}), 20) for s in (0.0, 0.1)]
    for one, two in zip(*runs, strict=True):
        np.testing.assert_array_equal(one.range, two.range)
        np.testing.assert_array_equal(one.covariance, two.covariance)


def test_workers_change_nothing() -> None:
    for one, two in zip(dance(sensor(6), 8), dance(sensor(6, workers=3), 8), strict=True):
        np.testing.assert_array_equal(one.range, two.range)
        np.testing.assert_array_equal(one.track, two.track)
        np.testing.assert_array_equal(one.covariance, two.covariance)
