"""A benchmark as a folder: one object of figures, the table, the plot."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from swarmvision.benchmark.report import Report, measure
from swarmvision.benchmark.table import table_text
from swarmvision.benchmark.timing import Effort
from swarmvision.drawing.scaling import plot_scaling
from swarmvision.errors import OutputError
from swarmvision.showcase import output_folder


def bench(folder: Path | None, effort: Effort, say: Callable[[str], None]) -> Report:
    """Measure everything and return it, see :func:`swarmvision.benchmark.report.measure`.

    Args:
        folder: Where ``bench.json``, ``bench.md`` and ``bench.png`` go; nothing is written without one.
        effort: How much is measured.
        say: Told what is being done.

    Raises:
        OutputError: If the folder cannot be written.
    """
    if folder is not None:
        folder = output_folder(folder)
    report = measure(effort, say)
    if folder is not None:
        plot_scaling(folder / "bench.png", report["curves"])
        _write(folder / "bench.json", json.dumps(report, indent=2) + "\n")
        _write(folder / "bench.md", table_text(report))
    return report


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text)
    except OSError as fault:
        raise OutputError(f"{path}: cannot be written: {fault.strerror or fault}") from None
