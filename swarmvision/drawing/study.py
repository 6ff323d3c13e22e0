"""What a sweep found, as curves over what was changed: medians over seeds, with the middle half shaded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from swarmvision.errors import OutputError

COLOURS = ("#1f6fb4", "#d1651a", "#3a923a", "#8a4fa3", "#b8323a", "#6b6b6b", "#17a2a2", "#c49a00")


@dataclass(frozen=True, slots=True)
class Outcome:
    """One condition's runs."""

    series: str
    """Which curve it is of."""
    place: float | str
    """Where on the curve: a number, or a name."""
    values: dict[str, list[float]]
    """What was measured, a number for each seed."""


def plot_outcomes(
    path: Path, title: str, axis: str, measures: dict[str, str], outcomes: Sequence[Outcome]
) -> None:
    """Write a picture with one panel for each measure.

    Args:
        path: PNG to write.
        title: Over all.
        axis: What was changed, with its unit.
        measures: Keys of the outcomes' values, and how each is called.
        outcomes: In the order in which they are to stand.

    Raises:
        OutputError: If it cannot be written.
    """
    figure = Figure(figsize=(4.6 * len(measures), 4.2), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, len(measures), squeeze=False)[0]
    for panel, (key, name) in zip(panels, measures.items(), strict=True):
        _panel(panel, key, outcomes)
        panel.set(xlabel=axis, title=name)
        panel.grid(alpha=0.3)
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=max(len(names), 1), fontsize=9)
    figure.suptitle(title)
    try:
        figure.savefig(path, metadata={"Software": None})
    except OSError as fault:
        raise OutputError(f"{path}: cannot be written: {fault.strerror or fault}") from None


def _panel(panel: Axes, key: str, outcomes: Sequence[Outcome]) -> None:
    names = list(dict.fromkeys(o.place for o in outcomes if isinstance(o.place, str)))
    all_series = list(dict.fromkeys(o.series for o in outcomes))
    for number, series in enumerate(all_series):
        mine = [o for o in outcomes if o.series == series and o.values.get(key)]
        if not mine:
            continue
        x = [float(names.index(o.place)) if isinstance(o.place, str) else o.place for o in mine]
        low, middle, high = np.array([np.percentile(o.values[key], (25, 50, 75)) for o in mine]).T
        colour = COLOURS[number % len(COLOURS)]
        if names:  # names have no order that a line could follow
            shift = 0.1 * (number - (len(all_series) - 1) / 2.0)
            spread = (middle - low, high - middle)
            panel.errorbar(
                np.array(x) + shift, middle, spread, fmt="o", color=colour, label=series, capsize=3
            )
        else:
            panel.plot(x, middle, "o-", color=colour, label=series, markersize=4)
            panel.fill_between(x, low, high, color=colour, alpha=0.15)
    if names:
        panel.set_xticks(range(len(names)), names, rotation=20, ha="right", fontsize=8)
