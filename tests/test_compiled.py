"""Kernels that are kept on disk are those of today's sources."""

from __future__ import annotations

import gc
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
import pytest

from swarmvision.camera import Lens
from swarmvision.compiled import compiled, leaf, steady, wide
from swarmvision.compiled.prefetch import prefetch
from swarmvision.config.arena import ArenaConfig, DiscConfig
from swarmvision.config.camera import LENSES, LensConfig
from swarmvision.config.imperfections import IMPERFECTIONS, ImperfectionsConfig
from swarmvision.config.marker import PRESETS
from swarmvision.config.robot import RobotConfig
from swarmvision.marker import Marker
from swarmvision.perception.gaze import Gaze
from swarmvision.perception.plan import Plan, Scratch, Task
from swarmvision.rendering.appearance import Appearance
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.rendering.stage import Scratch as Brushes
from swarmvision.rendering.stage import Stage

NullCache = pytest.importorskip("numba.core.caching").NullCache

CALLEE = "from swarmvision.compiled import compiled\n@compiled\ndef inner(x):\n    return x * {factor}\n"
CALLER = (
    "from swarmvision.compiled import compiled\nfrom pack.inner import inner\n"
    "@compiled\ndef outer(x):\n    return later(x)\n"
    "@compiled\ndef later(x):\n    return inner(x) + 1.0\n"
)
ASK = (
    "from numba.core import event; import pack.outer\n"
    "with event.install_recorder('numba:compile') as seen: value = pack.outer.outer(3.0)\n"
    "print(value, len(seen.buffer) > 0)"
)


def test_a_kernel_is_compiled_anew_when_what_it_calls_has_changed(tmp_path: Path) -> None:
    package = tmp_path / "pack"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "outer.py").write_text(CALLER)

    def answer(factor: float) -> list[str]:
        (package / "inner.py").write_text(CALLEE.format(factor=factor))
        result = subprocess.run(
            [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n{ASK}"],
            capture_output=True,
            text=True,
            check=True,
        )
        return result.stdout.split()

    assert answer(2.0) == ["7.0", "True"]
    assert answer(2.0) == ["7.0", "False"]  # kept
    assert answer(5.0) == ["16.0", "True"]


@leaf
def _twice(x: float) -> float:
    return 2.0 * x


@compiled
def _once_more(x: float, number: int) -> float:
    return _twice(x) + number


@compiled
def _row(x: float) -> Any:
    row = np.zeros((2, 2))
    row[0] = np.full(2, _once_more(x, 3))  # a row by a row: numba calls functions of its own
    return row[0]


@compiled
def _all_of_it(x: float) -> Any:
    return _twice(x) + _once_more(x, 1) + _once_more(x, 2) + _row(x)[1]


@wide
def _sum_of_halves(halves: Any) -> float:
    total = 0.0
    for i in range(halves.shape[1]):
        prefetch(halves, 1, i)
        total += halves[0, i] - halves[1, i]
    return total


def test_a_kernel_of_a_module_that_nobody_can_import_works_in_every_process(tmp_path: Path) -> None:
    file = tmp_path / "apart.py"
    file.write_text(
        "from swarmvision.compiled import compiled\n@compiled\ndef twice(x):\n    return 2.0 * x\n"
    )
    load = (
        "import importlib.util as i\n"
        f"spec = i.spec_from_file_location('apart', {str(file)!r})\n"
        "module = i.module_from_spec(spec); spec.loader.exec_module(module); print(module.twice(3.0))"
    )
    for _ in range(2):
        told = subprocess.run([sys.executable, "-P", "-c", load], capture_output=True, text=True, check=True)
        assert told.stdout == "6.0\n"


def test_what_is_kept_is_fetched_without_all_that_compiling_needs(tmp_path: Path) -> None:
    (tmp_path / "kept.py").write_text(
        "from swarmvision.compiled import compiled\n@compiled\ndef first(x):\n    return x[0]\n"
    )
    ask = "import sys, numpy, kept; print(kept.first(numpy.ones(3)), 'numba.np.linalg' in sys.modules)"
    told = [
        subprocess.run(
            [sys.executable, "-c", ask], cwd=tmp_path, capture_output=True, text=True, check=True
        ).stdout
        for _ in range(2)
    ]
    assert told == ["1.0 True\n", "1.0 False\n"]


def test_a_wide_kernel_keeps_its_attributes_and_asking_ahead_changes_nothing() -> None:
    kernel: Any = _sum_of_halves
    assert kernel(np.arange(10.0).reshape(2, 5)) == -25.0
    fresh: Any = wide(kernel.py_func)
    fresh._cache = NullCache()  # for what comes from disk cannot be looked at
    fresh.compile("float64(float64[:, ::1])")
    code = fresh.inspect_llvm(fresh.signatures[-1])
    assert '"prefer-vector-width"="512"' in code
    assert "llvm.prefetch" in code


@pytest.mark.parametrize("collects", [True, False])
def test_compiling_leaves_the_collection_of_garbage_as_it_was(collects: bool) -> None:
    before, kernel = gc.isenabled(), cast("Any", _sum_of_halves)
    fresh: Any = wide(kernel.py_func)
    fresh._cache = NullCache()
    try:
        (gc.enable if collects else gc.disable)()
        fresh.compile("float64(float64[:, ::1])")
        assert gc.isenabled() == collects
        with pytest.raises(Exception, match="astray"):
            compiled(_astray)(1.0)
        assert gc.isenabled() == collects
    finally:
        (gc.enable if before else gc.disable)()


def _astray(value: float) -> float:
    return value + astray  # type: ignore[name-defined,no-any-return]  # noqa: F821


def test_a_whole_has_every_part_that_its_parts_call() -> None:
    compiled_parts: Any = _once_more
    assert _all_of_it(5.0) == 10.0 + 11.0 + 12.0 + 13.0
    assert _once_more(5.0, 1) == 11.0  # a part of others is a whole for Python
    assert len(compiled_parts._parts) <= 1  # not one for each constant


class _Pair(NamedTuple):
    weights: Any
    gain: float


@leaf
def _weighed(row: Any, pair: _Pair) -> float:
    total = 0.0
    for i in range(len(row)):
        total += row[i] * pair.weights[i]
    return total * pair.gain


def test_a_steady_kernel_asks_named_tuples_once_and_everything_else_always(tmp_path: Path) -> None:
    door: Any = steady(_weighed)
    rows = np.arange(12.0).reshape(3, 4)
    pairs = [_Pair(np.full(4, weight), 2.0) for weight in (1.0, 3.0)]
    for row in (rows[0], rows[:, 1], rows[0, ::-1], rows[0].astype(np.float32)):
        for pair in pairs:
            assert door(row, pair) == 2.0 * float(row @ pair.weights[: len(row)])
    mapped = np.memmap(tmp_path / "rows", np.float32, "w+", shape=4)  # a class of arrays of any type
    for row in (mapped, mapped.astype(np.float64), mapped[::2]):
        row[:] = np.arange(len(row)) + 1.0
        assert door(row, pairs[1]) == 6.0 * float(row.sum())
    with pytest.raises(Exception, match="non-precise type"):
        door(rows[0].astype(">f8"), pairs[0])  # bytes the other way round: as the kernel does itself
    with pytest.raises(TypeError, match="named"):
        door(rows[0], (np.ones(4), 2.0))


def _eyes() -> Iterator[tuple[Lens, ImperfectionsConfig, RobotConfig, ArenaConfig]]:
    """Every lens and marker that is packaged, a small picture, faults of all kinds and things in the way."""
    small = LensConfig(width_px=7, height_px=5, focal_px=6.0)
    thing = ArenaConfig(objects=(DiscConfig(x=1.0, y=0.0),))
    for config in (*LENSES.values(), small):
        for faults in IMPERFECTIONS.values():
            for marker in PRESETS.values():
                for arena in (ArenaConfig(), thing):
                    yield Lens.from_config(config), faults, RobotConfig(marker=marker), arena


def test_what_pictures_are_made_and_read_with_has_one_type_whatever_the_settings() -> None:
    typeof = pytest.importorskip("numba").typeof
    kinds: dict[str, set[Any]] = {}
    for lens, faults, robot, arena in _eyes():
        camera, stage = Imperfections(faults, lens), Stage.of(lens, robot, arena, Appearance())
        task = Task.of(Plan.of(Marker.from_config(robot.marker)), lens)
        told: dict[str, Any] = {
            "stage": stage,
            "faults": camera.faults,
            "brushes": Brushes.of(lens, stage, 3),
            "dirt": camera.dirt,
            "reading": Scratch.of(lens.width_px, lens.height_px),
        }
        if task is not None:
            told |= {"task": task, "gaze": Gaze.at_all(task)}
        for name, value in told.items():
            kinds.setdefault(name, set()).add(typeof(value))
    assert len(kinds) == 7
    assert {name: len(kind) for name, kind in kinds.items()} == dict.fromkeys(kinds, 1)
