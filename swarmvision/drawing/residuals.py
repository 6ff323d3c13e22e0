"""What a calibration leaves unexplained, as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from swarmvision.errors import OutputError
from swarmvision.geometry import FloatArray

FEWEST = 0.05  # px: least range of the colours, so that tiny residuals look tiny


def plot_residuals(
    path: Path,
    size_px: tuple[int, int],
    points_px: Sequence[FloatArray],
    residuals_px: Sequence[FloatArray],
    names: Sequence[str],
) -> None:
    """Write where in the picture the points miss the model and by how much, and the rms of each picture.

    Args:
        path: PNG to write.
        size_px: Width and height of the pictures.
        points_px: Columns and rows of the points of each picture, each ``(n, 2)``.
        residuals_px: By how much each misses the model (px), each ``(n,)``.
        names: Of the pictures.

    Raises:
        OutputError: If it cannot be written.
    """
    figure = Figure(figsize=(10, 4.5), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    where, each = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
    points, residuals = np.concatenate(list(points_px)), np.concatenate(list(residuals_px))
    most = max(float(np.percentile(np.abs(residuals), 98.0)), FEWEST)
    dots = where.scatter(*points.T, c=residuals, s=4, cmap="coolwarm", vmin=-most, vmax=most)
    where.set(
        xlim=(0, size_px[0]), ylim=(size_px[1], 0), aspect="equal", xlabel="column (px)", ylabel="row (px)"
    )
    where.set_title("where the points miss the model")
    figure.colorbar(dots, ax=where, label="residual (px)", shrink=0.8)
    rms = [float(np.sqrt(np.mean(np.square(r)))) for r in residuals_px]
    each.barh(range(len(rms)), rms, color="#1f6fb4")
    each.set_yticks(range(len(rms)), list(names))
    each.invert_yaxis()
    each.set(xlabel="rms residual (px)", title="picture by picture")
    try:
        figure.savefig(path, metadata={"Software": None})
    except OSError as fault:
        raise OutputError(f"{path}: cannot be written: {fault.strerror or fault}") from None
