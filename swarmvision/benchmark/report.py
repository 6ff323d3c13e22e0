"""The whole benchmark as one object: every figure by name, reasons for those that are absent, curves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from swarmvision.benchmark import growth, many_worlds, pictures, process, swarms
from swarmvision.benchmark.stage import READ
from swarmvision.benchmark.timing import Absent, Effort, Figure, difference, ratio

Report = dict[str, Any]
KILO = 1000.0  # ms in a second


def measure(effort: Effort, say: Callable[[str], None]) -> Report:
    """Return every figure flat by name, None with an entry in ``reasons`` where it is absent.

    ``curves`` holds what the plot shows: for each abscissa its values ``x`` and lines of the same length.

    Args:
        effort: How much is measured.
        say: Told what is being done.
    """
    say("one picture: drawn, spoiled and read")
    figures = {**drawing(pictures.drawing(effort)), **reading(pictures.reading(effort))}
    say("pictures by neighbours in view and by size")
    curves = {
        "neighbours in view": pictures.by_neighbours(effort),
        "picture width (px)": pictures.by_width(effort),
    }
    say("the cameras of a swarm, by workers")
    chain = swarms.chain(effort)
    curves["workers"] = swarms.by_workers(chain)
    say("whole simulations, by robots")
    by_robots = swarms.by_robots(effort)
    curves["robots"] = by_robots
    say("a thousand robots and ten, by density")
    grown = growing(by_robots, effort.seconds)
    say("a hundred robots, many worlds, memory and first pictures")
    figures |= {
        **loop(chain),
        **grown,
        **swarming(effort),
        **process.figures(effort),
    }
    return {
        **{name: None if isinstance(figure, Absent) else figure for name, figure in figures.items()},
        "reasons": {name: figure.reason for name, figure in figures.items() if isinstance(figure, Absent)},
        "curves": {x: plotted(rows) for x, rows in curves.items()},
        "machine": process.machine(),
    }


def drawing(ms: Mapping[str, Figure]) -> dict[str, Figure]:
    """Return costs of drawing, and the rivals' over ours; ours includes the sensor's noise."""
    ours = ms["render_with_noise"]
    return {
        **{f"{name}_ms": cost for name, cost in ms.items()},
        "imperfections_ms": difference(ms["render_and_spoil"], ms["render"]),
        **{
            f"{name}_over_raycast": ratio(ms[name], ours)
            for name in ("pyrender_flat", "pyrender_shaded", "vizdoom", "pybullet")
        },
    }


def reading(ms: Mapping[str, Figure]) -> dict[str, Figure]:
    """Return costs of reading, and the rivals' over ``edges``."""
    ours = ms["edges"]
    polish = difference(ms["fit"], ours)
    return {
        **{f"{name}_ms": cost for name, cost in ms.items()},
        "fit_ms_per_neighbour": polish if isinstance(polish, Absent) else polish / READ,
        "paper_over_perceive": ratio(ms["moments"], ours),
        **{
            f"{name}_over_perceive": ratio(ms[name], ours)
            for name in ("aruco", "aruco_on_markers", "apriltag", "locus")
        },
    }


def loop(ms: Mapping[str, Figure]) -> dict[str, Figure]:
    """Return what follows from the cost of a swarm's pictures."""
    ours = ms["loop"]
    two = ms.get("workers_2", Absent("two workers need two cores, and this machine lends one"))
    return {
        "loop_ms": ours,
        "naive_loop_ms": ms["naive"],
        "naive_over_loop": ratio(ms["naive"], ours),
        "two_workers_over_one": ratio(ms["workers_1"], two),
        "camera_pictures_per_second_core": ratio(KILO, ours),
    }


def growing(rows: Mapping[int, Mapping[str, Figure]], seconds: float) -> dict[str, Figure]:
    """Return by which factor a robot's cost grows from a small swarm to a large one, and what is in view."""
    few, many = growth.FEW, growth.MANY
    missing = Absent(f"only a full run has swarms of {few} and {many}")
    full = few in rows and many in rows
    figures: dict[str, Figure] = {}
    for name in ("truth", "error_model"):
        cost = ratio(rows[many][name], rows[few][name]) if full else missing
        figures[f"{name}_cost_per_robot_1000_over_10"] = cost
    for density in growth.DENSITIES:
        where = "" if density == growth.DENSITIES[0] else f"_at_{density:g}_per_m2"
        figures |= {
            f"camera_cost_per_robot_1000_over_10{where}": (
                growth.at_density(density, seconds) if full else missing
            ),
            f"neighbours_in_view_of_10_robots{where}": growth.neighbours_in_view(few, density),
            f"neighbours_in_view_of_1000_robots{where}": growth.neighbours_in_view(many, density),
        }
    crowd = growth.in_one_crowd(seconds) if full else missing
    return {**figures, "camera_cost_per_picture_1000_over_10_in_one_crowd": crowd}


def swarming(effort: Effort) -> dict[str, Figure]:
    """Return how fast a hundred robots are simulated by each sensor, and many worlds."""
    steps = {
        f"{name}_robot_steps_per_second_core": ratio(
            KILO, swarms.per_robot(effort.swarm, swarms.SENSORS[name], effort.seconds)
        )
        for name in ("truth", "error_model")
    }
    return {**steps, "realtime_100_robots": swarms.real_time(effort), **many_worlds.figures(effort)}


def plotted(rows: Mapping[int, Mapping[str, Figure]]) -> dict[str, Any]:
    """Return rows by abscissa as columns; None where a value is absent."""
    names = list(next(iter(rows.values())))
    lines = {
        name: [None if isinstance(row[name], Absent) else row[name] for row in rows.values()]
        for name in names
    }
    return {"x": list(rows), "lines": lines}
