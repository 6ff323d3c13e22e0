"""A run as curves."""

from __future__ import annotations

from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from swarmvision.errors import OutputError
from swarmvision.geometry import FloatArray


def plot_course(path: Path, time: FloatArray, order: FloatArray, largest: FloatArray, title: str) -> None:
    """Write a picture of order and largest cluster over time.

    Args:
        path: PNG to write.
        time: s, shape ``(t,)``.
        order: Polar order, shape ``(t,)``.
        largest: Fraction of the robots in the largest cluster, shape ``(t,)``.
        title: Over the plot.

    Raises:
        OutputError: If it cannot be written.
    """
    figure = Figure(figsize=(8, 4.5), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.plot(time, order, label="order |mean(exp(i yaw))|", color="#1f6fb4", linewidth=2)
    axes.plot(time, largest, label="largest cluster / robots", color="#d1651a", linewidth=2)
    axes.set(xlabel="time (s)", ylim=(0, 1.05), xlim=(0, max(float(time[-1]), 1e-3)), title=title)
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right")
    try:
        figure.savefig(path, metadata={"Software": None})
    except OSError as fault:
        raise OutputError(f"{path}: cannot be written: {fault.strerror or fault}") from None
