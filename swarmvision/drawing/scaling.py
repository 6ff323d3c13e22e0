"""How cost grows: four panels over robots, neighbours in view, picture size and workers."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from swarmvision.errors import OutputError

LOOKS = {
    "camera": ("camera", "#1f6fb4"),
    "truth": ("truth", "#8a8f94"),
    "error_model": ("error model", "#2a9d5c"),
    "loop": ("drawn, spoiled, read, tracked", "#1f6fb4"),
    "render": ("draw", "#1f6fb4"),
    "spoil": ("spoil (pi-v1)", "#8a5fb4"),
    "edges": ("read (edges)", "#2a9d5c"),
    "pyrender_flat": ("pyrender, flat", "#d1651a"),
}
"""Name in the legend and colour of every line."""

PANELS = (
    ("robots", "ms per robot and step", "Whole simulation, one worker"),
    ("neighbours in view", "ms per picture", "640x460 px"),
    ("picture width (px)", "ms per picture", "8 neighbours in view"),
    ("workers", "ms per picture", "Cameras of 32 robots"),
)


def plot_scaling(path: Path, curves: Mapping[str, Mapping[str, Any]]) -> None:
    """Write the curves of a benchmark, both axes logarithmic; no neighbours stand at a half.

    Args:
        path: PNG to write.
        curves: For each abscissa ``x`` and ``lines`` by name (ms), None where absent.

    Raises:
        OutputError: If it cannot be written.
    """
    figure = Figure(figsize=(11, 7.6), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    for axes, (name, unit, title) in zip(figure.subplots(2, 2).flat, PANELS, strict=True):
        _panel(axes, curves[name])
        axes.set(xlabel=name, ylabel=unit, title=title)
    try:
        figure.savefig(path, metadata={"Software": None})
    except OSError as fault:
        raise OutputError(f"{path}: cannot be written: {fault.strerror or fault}") from None


def _panel(axes: Axes, curve: Mapping[str, Any]) -> None:
    places = np.maximum(np.array(curve["x"], dtype=np.float64), 0.5)
    axes.set(xscale="log", yscale="log")
    for name, values in curve["lines"].items():
        costs = np.array([np.nan if value is None else value for value in values])
        if np.isfinite(costs).any():
            label, colour = LOOKS[name]
            axes.plot(places, costs, "o-", color=colour, markersize=4, label=label)
    if list(curve["lines"]) == ["loop"] and len(places):
        ideal = curve["lines"]["loop"][0] / places
        axes.plot(places, ideal, "--", color="#8a8f94", label="a fair share each")
    axes.set_xticks(places, [f"{x:,d}" for x in curve["x"]])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
