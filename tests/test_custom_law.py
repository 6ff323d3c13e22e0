"""Laws that are not ours: taken by name, fenced, told in one line where they fail."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from swarmvision.config.controller import CustomConfig
from swarmvision.controllers import controller
from swarmvision.data import Estimates, Senses
from swarmvision.errors import ConfigError, ControllerError

LAWS = """
import numpy as np
from typing import NamedTuple
from swarmvision.config.model import Settings
from swarmvision.controllers import Law
from swarmvision.data import Commands

def creep(estimates, pace=0.01):
    return Commands(pace * estimates.count, np.zeros(estimates.count.shape))

def broken(estimates):
    return 1 / 0

def wrong_shape(estimates):
    return Commands.stop((7,))

def wild(estimates):
    return Commands(np.full(estimates.count.shape, np.nan), np.zeros(estimates.count.shape))

def forgetful(estimates):
    return None

number = 3

class Settings3(Settings):
    law: str = "counting"
    pace: float = 0.1

class Count(NamedTuple):
    steps: np.ndarray

counting = Law(
    Settings3,
    frozenset(),
    lambda senses, memory, config: (
        Commands(config.pace * memory.steps, 0 * memory.steps), Count(memory.steps + 1.0)
    ),
    lambda config, keys: Count(np.zeros(keys.shape)),
)
"""


@pytest.fixture
def laws(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "strangers_laws.py").write_text(LAWS)
    monkeypatch.syspath_prepend(str(tmp_path))
    return "strangers_laws"


def test_a_plain_function_is_a_law_and_takes_settings(laws: str) -> None:
    nobody = Estimates.empty((3, 2))
    config = CustomConfig(target=f"{laws}:creep", settings={"pace": 0.5})
    np.testing.assert_array_equal(controller(config).act(nobody).speed, [0.0, 0.0, 0.0])


def test_a_law_with_memory_goes_on_from_it(laws: str) -> None:
    control = controller(CustomConfig(target=f"{laws}:counting"))
    senses, memory = Senses.of(Estimates.empty((2, 0))), control.begin(np.zeros(2, dtype=np.uint64))
    speeds = []
    for _ in range(3):
        commands, memory = control.step(senses, memory)
        speeds.append(commands.speed.tolist())
    np.testing.assert_allclose(speeds, [[0.0, 0.0], [0.1, 0.1], [0.2, 0.2]])


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("broken", r"failed: ZeroDivisionError: division by zero \(.*strangers_laws.py, line 12\)"),
        ("wrong_shape", r"must return commands of shape \(2,\), got \(7,\)"),
        ("wild", "not finite"),
        ("forgetful", "must return Commands, got NoneType"),
    ],
)
def test_a_law_that_fails_is_told_in_one_line(laws: str, name: str, told: str) -> None:
    with pytest.raises(ControllerError, match=told) as fault:
        controller(CustomConfig(target=f"{laws}:{name}")).act(Estimates.empty((2, 1)))
    assert "\n" not in str(fault.value)


@pytest.mark.parametrize(
    ("target", "told"),
    [
        ("no_such_module_at_all:law", "cannot import 'no_such_module_at_all': ModuleNotFoundError"),
        ("strangers_laws:crep", "unknown function 'crep'; did you mean 'creep'"),
        ("strangers_laws:number", "neither a function nor a Law"),
        ("nobody_registered_this", "unknown registered controller"),
    ],
)
def test_a_law_that_is_not_there_is_refused(laws: str, target: str, told: str) -> None:
    with pytest.raises(ConfigError, match=told):
        controller(CustomConfig(target=target))
