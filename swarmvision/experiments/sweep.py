"""Many runs: each is a scenario, changes to it and a seed; the outcome does not depend on who runs it.

Runs are dealt to processes that are started fresh (``spawn``: OpenCV and OpenGL do not survive a fork), one
run a process at a time, each with one worker. A finished run may be kept as a line of a file, so that a
sweep that was stopped goes on where it was.
"""

from __future__ import annotations

import json
import multiprocessing
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from swarmvision.config.scenario import ScenarioConfig, packaged_scenario
from swarmvision.errors import ConfigError, OutputError
from swarmvision.simulation import run

Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class RunSpec:
    """One run of a sweep."""

    label: str
    """The condition that it belongs to; runs of one label differ in seed alone."""
    scenario: str
    """A packaged scenario's name."""
    changes: tuple[str, ...] = ()
    """As for ``swarmvision run --set``."""
    seed: int = 0

    def scenario_config(self) -> ScenarioConfig:
        """Return the scenario with its changes.

        Raises:
            ConfigError: If there is no such scenario, or a change is wrong.
        """
        return packaged_scenario(self.scenario, self.changes)


def repeated(label: str, scenario: str, changes: Iterable[str], seeds: Iterable[int]) -> list[RunSpec]:
    """Return one run of a condition for each seed."""
    changes = tuple(changes)
    return [RunSpec(label, scenario, changes, seed) for seed in seeds]


def run_one(spec: RunSpec) -> Row:
    """Return the summary of a run, without its perception table."""
    summary = run(spec.scenario_config(), spec.seed, workers=1).summary
    return {key: value for key, value in summary.items() if key != "perception"}


def sweep(
    specs: Sequence[RunSpec],
    processes: int = 1,
    kept: Path | None = None,
    tell: Callable[[int, int], None] | None = None,
) -> list[Row]:
    """Return what every run came to, in the order of the specs, with label and seed.

    Args:
        specs: The runs.
        processes: How many at a time; changes no result.
        kept: File of finished runs, read first and added to; a run found there is not done again.
        tell: Called with how many runs are done, of how many.

    Raises:
        ConfigError: If a scenario is wrong; nothing has been run then.
        OutputError: If the file cannot be read or written.
    """
    for spec in specs:
        spec.scenario_config()
    done = _read(kept) if kept is not None else {}
    waiting = [spec for spec in dict.fromkeys(specs) if _key(spec) not in done]

    def finish(spec: RunSpec, summary: Row) -> None:
        done[_key(spec)] = summary
        if kept is not None:
            _append(kept, {"spec": asdict(spec), "summary": summary})
        if tell is not None:
            tell(len(specs) - len(waiting) + sum(_key(s) in done for s in waiting), len(specs))

    if processes <= 1:
        for spec in waiting:
            finish(spec, run_one(spec))
    else:
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(processes, mp_context=context) as pool:
            futures = {pool.submit(run_one, spec): spec for spec in waiting}
            for future in as_completed(futures):
                finish(futures[future], future.result())
    return [{"label": spec.label, **done[_key(spec)]} for spec in specs]


def _key(spec: RunSpec) -> str:
    return json.dumps([spec.scenario, spec.changes, spec.seed])


def _read(path: Path) -> dict[str, Row]:
    done: dict[str, Row] = {}
    if not path.exists():
        return done
    try:
        for line in path.read_text().splitlines():
            entry = json.loads(line)
            spec = RunSpec(**{**entry["spec"], "changes": tuple(entry["spec"]["changes"])})
            done[_key(spec)] = entry["summary"]
    except (OSError, ValueError, KeyError, TypeError) as fault:
        raise ConfigError(f"{path}: not a file of finished runs: {fault}") from None
    return done


def _append(path: Path, entry: Row) -> None:
    try:
        with path.open("a") as file:
            file.write(json.dumps(entry) + "\n")
    except OSError as fault:
        raise OutputError(f"{path}: cannot be written: {fault.strerror or fault}") from None
