"""The benchmark's figures as a table in Markdown: cost, rivals, how many times ours."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from swarmvision.benchmark.stage import DRAWN, READ

ROWS = (
    ("**Draw 640x460 px with noise**, {drawn} neighbours in view", "render_with_noise_ms", None),
    ("without noise", "render_ms", None),
    ("copying a picture, the floor of all drawing", "copy_ms", None),
    ("pyrender, flat", "pyrender_flat_ms", "pyrender_flat_over_raycast"),
    ("pyrender, shaded", "pyrender_shaded_ms", "pyrender_shaded_over_raycast"),
    ("ViZDoom, its own level at 640x480 px", "vizdoom_ms", "vizdoom_over_raycast"),
    ("PyBullet, software renderer", "pybullet_ms", "pybullet_over_raycast"),
    ("**Spoil it**: all imperfections of pi-v1", "imperfections_ms", None),
    ("**Read it** by `edges`, {read} neighbours", "edges_ms", None),
    ("`fit`, for each neighbour on top", "fit_ms_per_neighbour", None),
    ("the paper's method, `moments`", "moments_ms", "paper_over_perceive"),
    ("OpenCV ArUco, {read} tags of that size", "aruco_ms", "aruco_over_perceive"),
    ("OpenCV ArUco on our markers", "aruco_on_markers_ms", "aruco_on_markers_over_perceive"),
    ("AprilTag 3, {read} tags", "apriltag_ms", "apriltag_over_perceive"),
    ("locus-tag, {read} tags", "locus_ms", "locus_over_perceive"),
    ("**The loop**: drawn, spoiled, read, tracked", "loop_ms", None),
    ("naive: pyrender flat and the paper's method", "naive_loop_ms", "naive_over_loop"),
)
"""What it is, its time (ms), and the figure that holds it against ours: the bold one above it."""

NUMBERS = (
    ("camera pictures per second and core", "camera_pictures_per_second_core"),
    ("two workers over one", "two_workers_over_one"),
    ("100 robots, a 32 Hz camera each, two workers: times real time", "realtime_100_robots"),
    ("robot-steps per second and core, 100 robots, `truth`", "truth_robot_steps_per_second_core"),
    ("robot-steps per second and core, 100 robots, `error_model`", "error_model_robot_steps_per_second_core"),
    ("robot-steps per second and core, 256 worlds of 8, `error_model`", "worlds_robot_steps_per_second_core"),
    ("the same with the flocking law", "worlds_flocking_robot_steps_per_second_core"),
    ("VMAS `flocking`, 256 worlds of 8", "vmas_robot_steps_per_second_core"),
    ("worlds over VMAS", "worlds_over_vmas"),
    ("cost per robot, 1,000 over 10 robots, cameras, 7.1 per m²", "camera_cost_per_robot_1000_over_10"),
    ("neighbours in view on average, hidden or not, of 10 robots", "neighbours_in_view_of_10_robots"),
    ("of 1,000 robots", "neighbours_in_view_of_1000_robots"),
    ("cost per robot, 1,000 over 10 robots, 2 per m²", "camera_cost_per_robot_1000_over_10_at_2_per_m2"),
    ("the same, 0.5 per m²", "camera_cost_per_robot_1000_over_10_at_0.5_per_m2"),
    (
        "cost per picture with equally many in view: all of 1,000 robots over 10 among them",
        "camera_cost_per_picture_1000_over_10_in_one_crowd",
    ),
    ("cost per robot, 1,000 over 10 robots, `truth`", "truth_cost_per_robot_1000_over_10"),
    ("the same, `error_model`", "error_model_cost_per_robot_1000_over_10"),
    ("resident memory grown over {pictures} pictures (MB)", "memory_growth_mb"),
    ("a new process to its first picture (s)", "first_picture_s"),
    ("the same with everything to compile, once after installing (s)", "first_picture_after_install_s"),
)


def table_text(report: Mapping[str, Any]) -> str:
    """Return times with their rivals', the other figures, and the machine, in Markdown."""
    words = {"drawn": DRAWN, "read": READ, "pictures": f"{report['memory_watched_pictures']:,.0f}"}
    lines = ["| one core | ms | times ours |", "| --- | ---: | ---: |"]
    for text, time, times in ROWS:
        ours = "" if times is None else _number(report[times])
        lines.append(f"| {text.format(**words)} | {_number(report[time])} | {ours} |")
    lines += ["", "| figure | |", "| --- | ---: |"]
    lines += [f"| {text.format(**words)} | {_number(report[name])} |" for text, name in NUMBERS]
    machine = report["machine"]
    where = f"{machine['processor']}, {machine['cores']} cores, load {machine['load_per_core']} a core"
    lines += ["", f"{where} (this run alone is about 1 in all). {_versions(machine)}"]
    lines += [f"Absent: {reason}." for reason in dict.fromkeys(report["reasons"].values())]
    return "\n".join(lines) + "\n"


def _number(value: float | None) -> str:
    if value is None:
        return "absent"
    return f"{value:,.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"


def _versions(machine: Mapping[str, Any]) -> str:
    told = {
        name: value
        for name, value in machine.items()
        if name not in ("processor", "cores", "load_per_core", "system")
    }
    return ", ".join(f"{name} {value}" for name, value in told.items() if value is not None) + "."
