"""How a picture becomes a number, step by step, as one sheet."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.colour import encode
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.perception.detect import candidates
from swarmvision.perception.edges import Reading, readings
from swarmvision.perception.fit import fitted
from swarmvision.perception.gaze import Gaze
from swarmvision.perception.heading import unroll
from swarmvision.perception.model import GROUND, HEADING, ROW, Skin, model
from swarmvision.perception.patch import tangents
from swarmvision.perception.plan import COLUMNS, HEIGHTS, LINES, LOWERS, STRIPE, UPPERS, Plan, Scratch, Task
from swarmvision.perception.plan import GROUND as BAND
from swarmvision.perception.rings import inner_edges
from swarmvision.perception.segment import Balance
from swarmvision.perception.smear import smear_of


def draw_reading(image: NDArray[np.uint8], lens: Lens, marker: Marker) -> Figure:
    """Return a sheet of the steps for the nearest marker in a picture ``(h, w, 3)``.

    Raises:
        ValueError: If no marker is in the picture.
    """
    plan, skin, balance = Plan.of(marker), Skin.of(marker), Balance.of(image)
    task, scratch = Task.of(plan, lens), Scratch.of(lens.width_px, lens.height_px)
    found = readings(image, task, Gaze.at_all(task), scratch) if task is not None else []
    if not found:
        raise ValueError("no marker in the picture")
    figure = Figure(figsize=(13, 7.2), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, 4)
    _picture(panels[0, 0], image, found, lens, skin)
    _classes(panels[0, 1], image, balance, plan)
    _edges(panels[0, 2], image, balance, plan, found[0], lens, skin)
    _stripe(panels[0, 3], image, balance, plan, found[0], lens)
    _fit(panels[1], image, balance, lens, skin, found)
    for panel in panels.ravel():
        panel.set(xticks=[], yticks=[])
    return figure


def _picture(panel: Axes, image: NDArray[np.uint8], found: list[Reading], lens: Lens, skin: Skin) -> None:
    panel.imshow(image, extent=(0, image.shape[1], image.shape[0], 0))
    for reading in found:
        left, right = tangents(lens, skin, reading.range, reading.bearing)
        panel.axvline(left, color="#1f6fb4", linewidth=0.8)
        panel.axvline(right, color="#1f6fb4", linewidth=0.8)
    panel.set_title("1 the picture, and the tangents it ends with", fontsize=9)


def _classes(panel: Axes, image: NDArray[np.uint8], balance: Balance, plan: Plan) -> None:
    address = sum(balance.address[channel][image[::2, ::2, channel]] for channel in range(3))
    classes = plan.hues.classes[address]
    palette = np.array([(235, 235, 235), *plan.hues.names], dtype=np.uint8)
    panel.imshow(palette[classes], extent=(0, image.shape[1], image.shape[0], 0))
    if plan.proportions is not None:
        for candidate in candidates(image, balance, plan.hues, plan.proportions):
            for row in candidate.rows.T:
                panel.plot(candidate.columns, row, "k-", linewidth=0.8)
    panel.set_title("2 classes by a table; runs paired by proportion", fontsize=9)


def _edges(
    panel: Axes,
    image: NDArray[np.uint8],
    balance: Balance,
    plan: Plan,
    reading: Reading,
    lens: Lens,
    skin: Skin,
) -> None:
    columns, upper, lower = _measured(image, balance, plan, reading)
    panel.imshow(image, extent=(0, image.shape[1], image.shape[0], 0))
    panel.plot(columns, upper, "k.", markersize=3)
    panel.plot(columns, lower, "k.", markersize=3)
    for side in tangents(lens, skin, reading.range, reading.bearing):
        panel.axvline(side, color="#1f6fb4", linewidth=1.0)
    margin = 0.25 * (columns[-1] - columns[0]) + 4.0
    reach = 0.6 * float(np.median(lower - upper))
    panel.set_xlim(columns[0] - margin, columns[-1] + margin)
    panel.set_ylim(float(lower.max()) + reach, float(upper.min()) - reach)
    panel.set_title("3 edges by area, to a fraction of a pixel", fontsize=9)


def _stripe(
    panel: Axes, image: NDArray[np.uint8], balance: Balance, plan: Plan, reading: Reading, lens: Lens
) -> None:
    panel.set_title("4 the pattern unrolled; every column votes", fontsize=9)
    if not len(plan.knots):
        return
    columns, upper, lower = _measured(image, balance, plan, reading)
    directions = plan.directions
    rays = lens.bearing_from_column(columns)
    across = np.clip(reading.range * np.sin(rays - reading.bearing) / plan.heights[5], -1.0, 1.0)
    sheet = np.empty((len(columns), HEIGHTS))
    for i, column in enumerate(columns):
        unroll(
            image, balance.light, directions[STRIPE], directions[BAND], int(column), upper[i], lower[i],
            plan.heights, np.empty(image.shape[0] + 2), np.empty(HEIGHTS), sheet[i],
        )  # fmt: skip
    panel.imshow(sheet.T, origin="lower", aspect="auto", cmap="cividis", vmin=-0.1, vmax=1.1)
    azimuth = np.mod(rays + math.pi - np.arcsin(across) - reading.heading, 2.0 * math.pi)
    middle = np.interp(azimuth, plan.knots[:, 0], plan.knots[:, 1:].mean(axis=1))
    place = (middle - plan.heights[2]) / (plan.heights[3] - plan.heights[2]) * HEIGHTS - 0.5
    panel.plot(np.arange(len(columns)), place, "r.", markersize=4)
    panel.set_xlabel(f"heading {math.degrees(reading.heading):.1f} deg", fontsize=9)


def _fit(
    panels: NDArray[np.object_],
    image: NDArray[np.uint8],
    balance: Balance,
    lens: Lens,
    skin: Skin,
    found: list[Reading],
) -> None:
    """Draw picture, model and what is left between them, of the nearest marker."""
    start = found[0]
    smear = smear_of(image, balance.light, lens, skin, found)
    fit = fitted(image, balance.light, lens, skin, start, np.zeros(lens.width_px, dtype=bool), smear)
    if fit is None:
        return
    left, right = tangents(lens, skin, start.range, start.bearing)
    depth = (start.range - skin.radius) * math.cos(start.bearing)
    rows = [lens.centre_px[1] - lens.focal_px * (z - lens.height) / depth for z in (skin.top, skin.base)]
    u = np.arange(max(math.floor(left) - 5, 0), min(math.ceil(right) + 5, lens.width_px))
    v = np.arange(max(math.floor(rows[0]) - 5, 0), min(math.ceil(rows[1]) - 2, lens.height_px))
    grid = np.stack(np.meshgrid(u, v, indexing="ij")).reshape(2, -1).astype(np.float64) + 0.5
    codes = image[v[0] : v[-1] + 1, u[0] : u[-1] + 1]
    data = np.stack([balance.light[c][codes[..., c]].T.ravel() for c in range(3)])  # (3, n)
    drawn = _drawn(fit.theta, data, grid[0].copy(), grid[1].copy(), start, lens, skin)
    shape = (3, len(u), len(v))
    for panel, values, title in (
        (panels[0], data, "5 the marker in linear light"),
        (panels[1], drawn, "6 the model that fits it best"),
        (panels[2], 0.5 + 5.0 * (data - drawn), "7 what is left, five times enlarged"),
    ):
        panel.imshow(encode(values.reshape(shape).transpose(2, 1, 0)).astype(np.uint8))
        panel.set_title(title, fontsize=9)
    std = np.sqrt(np.diag(fit.covariance))
    panels[3].axis("off")
    lines = (
        f"range     {1e3 * math.exp(fit.theta[0]):8.2f} mm",
        f"bearing   {math.degrees(fit.theta[1]):8.3f} deg",
        f"heading   {math.degrees(fit.theta[HEADING]):8.2f} deg",
        f"blur      {fit.theta[5]:8.2f} px",
        f"lean      {math.degrees(fit.theta[4]):8.2f} deg",
        f"residual  {100 * fit.misfit:8.2f} % of white",
        "by the pixels alone:",
        f"  {1e3 * std[0]:.3f} mm, {math.degrees(std[1]):.4f} deg, {math.degrees(std[2]):.3f} deg",
    )
    panels[3].text(0.0, 0.9, "8 the numbers\n\n" + "\n".join(lines), family="monospace", fontsize=9, va="top")


def _drawn(
    theta: FloatArray,
    data: FloatArray,
    columns: FloatArray,
    rows: FloatArray,
    start: Reading,
    lens: Lens,
    skin: Skin,
) -> FloatArray:
    """Return the model ``(3, n)`` with its colours by least squares."""
    width = skin.colours + GROUND
    depth = (start.range - skin.radius) * math.cos(start.bearing)
    view = np.array([lens.focal_px, *lens.centre_px, lens.height])
    middle = lens.centre_px[1] + start.drop - lens.focal_px * (skin.middle - lens.height) / depth
    frame = np.array([middle, lens.focal_px * skin.inner / depth / 2.0, 1.0, 1.0])
    basis, change = np.empty((len(columns), width)), np.empty((3, 0, ROW))
    used = np.empty(len(columns), dtype=np.int64)
    sizes = np.array([skin.radius, skin.top])
    model(
        theta, np.zeros((3, width)), view, sizes, skin.heights, skin.kinds, skin.inks, skin.knots, skin.jumps,
        frame, columns, rows, 1, False, basis, change, used,
    )  # fmt: skip
    return np.linalg.lstsq(basis, data.T, rcond=None)[0].T @ basis.T


def _measured(
    image: NDArray[np.uint8], balance: Balance, plan: Plan, reading: Reading
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return columns and rows (px) of the inner edges of the candidate that a reading came from."""
    assert plan.proportions is not None
    found = candidates(image, balance, plan.hues, plan.proportions)
    candidate = min(found, key=lambda c: abs(c.left - reading.left) + abs(c.right - reading.right))
    columns = np.arange(math.ceil(candidate.columns[0]), int(candidate.columns[-1])) + 0.5
    lines = np.empty((LINES, max(len(columns), 1)))
    lines[COLUMNS, : len(columns)] = columns
    thick = float(np.median(candidate.rows[:, 1] - candidate.rows[:, 0]))
    foot = float(np.median(candidate.rows[:, 3] - candidate.rows[:, 2]))
    used = inner_edges(
        image,
        balance.light,
        plan.directions,
        candidate.bands,
        len(columns),
        candidate.columns,
        candidate.rows,
        thick,
        foot,
        lines,
    )
    return lines[COLUMNS, :used], lines[UPPERS, :used], lines[LOWERS, :used]
