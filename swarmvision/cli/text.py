"""What the command prints: a run's summary as a table, estimates as text or JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from swarmvision.data import Estimates

RUN = ("scenario", "seed", "robots", "seconds", "order", "largest_cluster", "contacts", "state_sha256")
ERRORS = ("range_percent", "bearing_deg", "heading_deg")
HEAD = """
perceived against true: absolute errors, median / 95th percentile
range (m)      neighbours   found      range %      bearing deg       heading deg"""


def summary_text(summary: dict[str, Any]) -> str:
    """Return a run's figures, and what was perceived if anybody was there, as lines."""
    lines = [_figure(key, summary[key], 16) for key in RUN]
    lines += [_figure(key, value, 27) for key, value in summary["outcome"].items()]
    return "\n".join([*lines, *_perceived(summary["perception"])])


def estimates_text(path: Path, estimates: Estimates) -> str:
    """Return the neighbours ``(k,)`` read out of a picture as lines."""
    lines = [f"{path}: {len(estimates.seen)} neighbours"]
    for row in _rows(estimates):
        heading = "not told"
        if row["heading"] is not None:
            heading = f"{math.degrees(row['heading']):+7.1f} deg"
        bearing = math.degrees(row["bearing"] or 0.0)
        lines.append(f"  range {row['range']:.3f} m  bearing {bearing:+6.2f} deg  heading {heading}")
    return "\n".join(lines)


def estimates_json(path: Path, estimates: Estimates) -> str:
    """Return the neighbours ``(k,)`` read out of a picture as one line of JSON."""
    return json.dumps({"image": str(path), "neighbours": list(_rows(estimates))})


def _figure(key: str, value: object, width: int) -> str:
    return f"{key:{width}s} {value:.4g}" if isinstance(value, float) else f"{key:{width}s} {value}"


def _perceived(table: list[dict[str, Any]]) -> Iterator[str]:
    if not table or not table[-1]["neighbours"]:
        return
    yield HEAD
    for row in table:
        to = "" if row["to_m"] is None else f"{row['to_m']:.2f}"
        found = 100.0 * row["found"] / row["neighbours"]
        cells = "  ".join(f"{_cell(row[f'{name}_median'])} /{_cell(row[f'{name}_p95'])}" for name in ERRORS)
        yield f"{row['from_m']:.2f} - {to:5s} {row['neighbours']:11d} {found:6.1f} %  {cells}"
    yield f"phantoms: {table[-1]['phantoms']}"


def _cell(value: float | None) -> str:
    return "      -" if value is None else f"{value:7.3f}"


def _rows(estimates: Estimates) -> Iterator[dict[str, float | None]]:
    std = np.sqrt(np.diagonal(estimates.covariance, axis1=-2, axis2=-1))
    for i in range(len(estimates.seen)):
        told = bool(np.isfinite(estimates.heading[i]))
        yield {
            "range": float(estimates.range[i]),
            "bearing": float(estimates.bearing[i]),
            "heading": float(estimates.heading[i]) if told else None,
            "range_std": float(std[i, 0]),
            "bearing_std": float(std[i, 1]),
            "heading_std": float(std[i, 2]) if told else None,
            "visible": float(estimates.visible[i]),
        }
