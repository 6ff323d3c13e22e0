"""The paper's experiments as a folder: figures, tables and one object of results."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from swarmvision.drawing.reproduction import (
    plot_filters,
    plot_heading_constants,
    plot_offset_constant,
    plot_patterns,
    plot_range_constant,
    plot_sizes_and_lights,
)
from swarmvision.errors import OutputError
from swarmvision.experiments import paper
from swarmvision.experiments.apparatus import Apparatus
from swarmvision.showcase import output_folder

PUBLISHED_OFFSET = (0.0206, 0.0764)  # cm/px at the ends of figure 12


def reproduce(folder: Path | None, say: Callable[[str], None]) -> dict[str, dict[str, float | None]]:
    """Repeat the experiments; return the figures of both methods in the paper's units.

    Args:
        folder: Where figures and tables go; without one only what is returned is computed.
        say: Told what is being done.
    """
    if folder is not None:
        folder = output_folder(folder)
    say("fitting k, k1 and k2 on pictures of the simulated apparatus")
    apparatus = Apparatus()
    fitted = paper.constants(apparatus)
    say("Table 1 of the paper's method and of fit")
    moments = paper.table_of_moments(apparatus, fitted)
    fit = paper.table_of_reader(apparatus, "fit")
    results = {"moments": _row(moments, fitted), "fit": _row(fit, None)}
    if folder is None:
        return results
    say("filters, patterns, sizes and lights")
    filters, patterns = paper.filters(apparatus), paper.patterns()
    sizes, lights = paper.sizes(), paper.lights()
    published = paper.PUBLISHED
    plot_range_constant(folder / "figure10.png", fitted.ranges, fitted.rows, fitted.k, published["k"])
    plot_heading_constants(
        folder / "figure11.png",
        fitted.heading_ranges,
        fitted.k1,
        fitted.k2,
        (published["k1_12"], published["k1_37"]),
        (published["k2_12"], published["k2_37"]),
    )
    plot_offset_constant(folder / "figure12.png", fitted.aside, fitted.aside_k, PUBLISHED_OFFSET)
    plot_filters(folder / "filters.png", filters.rows)
    plot_patterns(folder / "patterns.png", patterns.rows)
    plot_sizes_and_lights(folder / "sizes_and_light.png", sizes.rows, lights.rows)
    everything: dict[str, Any] = {"published": published, **results}
    for name, comparison in (
        ("filters", filters),
        ("patterns", patterns),
        ("sizes", sizes),
        ("lights", lights),
    ):
        everything[name] = [dict(zip(comparison.columns, row, strict=True)) for row in comparison.rows]
    _write(folder / "results.json", json.dumps(everything, indent=2) + "\n")
    _write(folder / "table1.md", table_text(results))
    return results


def table_text(results: dict[str, dict[str, float | None]]) -> str:
    """Return what was found beside what is published, as a table in Markdown."""
    lines = ["| quantity | published | moments | fit |", "|---|---|---|---|"]
    for key in [*paper.PUBLISHED, "single_k_error_percent"]:
        cells = [paper.PUBLISHED.get(key), results["moments"][key], results["fit"][key]]
        lines.append(f"| {key} | " + " | ".join("-" if c is None else f"{c:.4g}" for c in cells) + " |")
    return "\n".join(lines) + "\n"


def _row(table: paper.Table, fitted: paper.Constants | None) -> dict[str, float | None]:
    return {
        "k": None if fitted is None else fitted.k,
        "k1_12": None if fitted is None else float(fitted.k1[0]),
        "k1_37": None if fitted is None else float(fitted.k1[-1]),
        "k2_12": None if fitted is None else float(fitted.k2[0]),
        "k2_37": None if fitted is None else float(fitted.k2[-1]),
        "range_error_percent": table.range_error_percent,
        "bearing_error_percent": table.bearing_error_percent,
        "heading_error_percent": table.heading_error_percent,
        "dead_zone_deg": table.dead_zone_deg,
        "single_k_error_percent": table.single_k_error_percent,
    }


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text)
    except OSError as fault:
        raise OutputError(f"{path}: cannot be written: {fault.strerror or fault}") from None
