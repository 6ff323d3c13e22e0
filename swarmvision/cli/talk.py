"""What the command says on stderr while it works."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from swarmvision.config.scenario import ScenarioConfig
    from swarmvision.simulation import Frame


def say(text: str) -> None:
    """Print a line on stderr."""
    typer.echo(text, err=True)


@contextmanager
def announced() -> Generator[None]:
    """Say it once where something has to be compiled."""
    from swarmvision.compiled import announced_compilation

    with announced_compilation(lambda: say("compiling the kernels (once; about 20 s, then cached)")):
        yield


@contextmanager
def progress(scenario: ScenarioConfig) -> Generator[Callable[[Frame], None]]:
    """Show a bar on stderr, where that is a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[now]}"),
        TimeRemainingColumn(),
    )
    with announced(), Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task(f"{scenario.name}, {scenario.robots} robots", total=scenario.steps, now="")
        yield lambda frame: bar.update(task, completed=frame.step + 1, now=f"{frame.time:.1f} s")
