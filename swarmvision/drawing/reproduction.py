"""The paper's figures drawn anew, ours over the published ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from swarmvision.errors import OutputError
from swarmvision.geometry import FloatArray

OURS, PAPER = "#1f6fb4", "#d1651a"


def plot_range_constant(path: Path, ranges: FloatArray, rows: FloatArray, k: float, published: float) -> None:
    """Write figure 10: rows between the rings and k over range.

    Args:
        path: PNG to write.
        ranges: d_v (cm), shape ``(n,)``.
        rows: P (px), nan where it cannot be told, ``(n,)``.
        k: Fitted (cm px).
        published: The paper's k.
    """
    figure = _figure(10)
    left, right = figure.subplots(1, 2)
    left.plot(ranges, rows, "o", color=OURS, markersize=4, label="simulated")
    left.plot(ranges, published / ranges, color=PAPER, label=f"published: {published:.1f} / d")
    left.set(xlabel="surface range d_v (cm)", ylabel="rows between the rings P (px)", title="Figure 10")
    right.plot(ranges, rows * ranges, "o-", color=OURS, markersize=4, label="simulated P d_v")
    right.axhline(k, color=OURS, linestyle="--", label=f"one k: {k:.0f}")
    right.axhline(published, color=PAPER, label=f"published: {published:.1f}")
    right.set(xlabel="surface range d_v (cm)", ylabel="k (cm px)", title="k is not one number")
    _finish(figure, (left, right), path)


def plot_heading_constants(
    path: Path,
    ranges: FloatArray,
    k1: FloatArray,
    k2: FloatArray,
    published_k1: tuple[float, float],
    published_k2: tuple[float, float],
) -> None:
    """Write figure 11: k1 (deg/px) and k2 (deg) over range (cm), each ``(m,)``, and the paper's ends."""
    figure = _figure(10)
    axes = figure.subplots(1, 2)
    ends = ranges[[0, -1]]
    for panel, ours, paper, name in (
        (axes[0], k1, published_k1, "k1 (deg/px)"),
        (axes[1], k2, published_k2, "k2 (deg)"),
    ):
        panel.plot(ranges, ours, "o-", color=OURS, markersize=4, label="simulated")
        panel.plot(ends, paper, "s--", color=PAPER, label="published ends")
        panel.set(xlabel="surface range d_v (cm)", ylabel=name, title="Figure 11")
    axes[1].set_ylim(80.0, 115.0)
    _finish(figure, tuple(axes), path)


def plot_offset_constant(
    path: Path, aside: FloatArray, k: FloatArray, published: tuple[float, float]
) -> None:
    """Write figure 12: k of eq. 8 (cm/px) over the offset (cm), each ``(a,)``, and the paper's ends."""
    figure = _figure(5.5)
    axes = figure.subplots()
    axes.plot(aside, k, "o-", color=OURS, markersize=4, label="simulated")
    axes.plot(aside[[0, -1]], published, "s--", color=PAPER, label="published ends")
    axes.set(xlabel="offset d_h (cm)", ylabel="k (cm/px)", title="Figure 12")
    _finish(figure, (axes,), path)


def plot_filters(path: Path, rows: tuple[tuple[str | float | None, ...], ...]) -> None:
    """Write error and time of each filter over its size; rows are kind, px, percent, share read, ms."""
    figure = _figure(10)
    left, right = figure.subplots(1, 2)
    for kind, colour in (("gaussian", "#2a9d5c"), ("median", OURS), ("bilateral", PAPER)):
        mine = [row for row in rows if row[0] == kind]
        size = np.array([float(row[1] or 0) for row in mine])
        error = np.array([np.nan if row[2] is None else float(row[2]) for row in mine])
        left.plot(size, error, "o-", color=colour, markersize=4, label=kind)
        right.plot(size, [float(row[4] or 0) for row in mine], "o-", color=colour, markersize=4, label=kind)
    left.set(xlabel="window (px)", ylabel="rms error of range (%)", title="Filters: error")
    left.set_ylim(bottom=0.0)
    right.set(xlabel="window (px)", ylabel="time per picture (ms)", yscale="log", title="Filters: time")
    _finish(figure, (left, right), path)


def plot_patterns(path: Path, rows: tuple[tuple[str | float | None, ...], ...]) -> None:
    """Write how many degrees each pattern tells; rows are name, kind, by centroid, by fit."""
    figure = _figure(8)
    axes = figure.subplots()
    places = np.arange(len(rows))
    centroid = [float(row[2] or 0.0) for row in rows]
    fit = [float(row[3] or 0.0) for row in rows]
    axes.bar(places - 0.2, centroid, 0.4, color=PAPER, label="one centroid (the paper's)")
    axes.bar(places + 0.2, fit, 0.4, color=OURS, label="fit")
    axes.set_xticks(places, [f"{row[0]}\n{row[1]}" for row in rows], fontsize=8)
    axes.set(ylabel="headings told (deg)", title="What each pattern tells", ylim=(0, 400))
    _finish(figure, (axes,), path)


def plot_sizes_and_lights(
    path: Path,
    sizes: tuple[tuple[str | float | None, ...], ...],
    lights: tuple[tuple[str | float | None, ...], ...],
) -> None:
    """Write greatest range errors by marker size and by light, of both methods."""
    figure = _figure(10)
    left, right = figure.subplots(1, 2)
    labels = [f"{row[0]:.0f}x{row[1]:.0f}" for row in sizes]
    for panel, ticks, rows, columns in (
        (left, labels, sizes, (3, 4)),
        (right, [f"{row[0]:g}" for row in lights], lights, (2, 4)),
    ):
        for column, colour, name in zip(columns, (PAPER, OURS), ("moments", "fit"), strict=True):
            values = [np.nan if row[column] is None else float(row[column] or 0.0) for row in rows]
            panel.plot(np.arange(len(rows)), values, "o-", color=colour, label=name)
        panel.set_xticks(np.arange(len(rows)), ticks, fontsize=8)
        panel.set(ylabel="greatest error of range (%)", yscale="log")
    left.set(xlabel="marker: diameter x height (cm)", title="Sizes")
    right.set(xlabel="light, of full", title="Light; a gap is a marker not found")
    _finish(figure, (left, right), path)


def _figure(width: float) -> Figure:
    figure = Figure(figsize=(width, 4.2), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _finish(figure: Figure, panels: tuple[Axes, ...], path: Path) -> None:
    for axes in panels:
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    try:
        figure.savefig(path, metadata={"Software": None})
    except OSError as fault:
        raise OutputError(f"{path}: cannot be written: {fault.strerror or fault}") from None
