"""The process itself: memory over many pictures, the time to the first one, and what machine this is."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType

from swarmvision.benchmark import rivals
from swarmvision.benchmark.stage import one_camera, swarm
from swarmvision.benchmark.timing import Absent, Effort, Figure
from swarmvision.simulation import Simulation

STATM = Path("/proc/self/statm")
WATCHED = 10  # robots whose pictures fill the memory, or do not
PACKAGES = ("numpy", "numba", "pymunk", "scipy")

FIRST = """
import time
from swarmvision.benchmark.pictures import found
found(5)
print(time.process_time())
"""
"""Tells CPU time from the start of the process to its first picture drawn, spoiled and read."""

GROWN = """
from swarmvision.benchmark.process import grown
print(grown({pictures}))
"""
"""Tells memory's growth in a process that does nothing else."""


def figures(effort: Effort) -> dict[str, Figure]:
    """Return memory's growth (MB), over how many pictures, and the first picture's time (s)."""
    fresh: Figure = Absent("only a full run compiles everything anew")
    return {
        "memory_growth_mb": memory_growth(effort.pictures),
        "memory_watched_pictures": float(effort.pictures),
        "first_picture_s": first_picture(fresh=False),
        "first_picture_after_install_s": first_picture(fresh=True) if effort.fresh else fresh,
    }


def memory_growth(pictures: int) -> Figure:
    """Return by how much (MB) the resident memory of a new process grows over so many pictures."""
    if not STATM.exists():
        return Absent("memory: this system tells no resident size in /proc")
    return alone("memory", GROWN.format(pictures=pictures))


def grown(pictures: int) -> float:
    """Return by how much (MB) this process's resident memory grows over so many pictures in a simulation.

    A tenth as many are taken before, so that buffers are there.
    """
    simulation = Simulation(swarm(WATCHED, one_camera()), 1, workers=1)
    for _ in range(max(pictures // WATCHED // 10, 2)):
        simulation.step()
    before = _resident()
    for _ in range(pictures // WATCHED):
        simulation.step()
    return (_resident() - before) / 1e6


def first_picture(*, fresh: bool) -> Figure:
    """Return the CPU time (s) of a new process until it has drawn, spoiled and read a picture.

    Args:
        fresh: Whether nothing is compiled yet, as after installing.
    """
    with tempfile.TemporaryDirectory() as empty:
        return alone("first picture", FIRST, {"NUMBA_CACHE_DIR": empty} if fresh else {})


def alone(name: str, script: str, settings: Mapping[str, str] = MappingProxyType({})) -> Figure:
    """Return the number that a script prints in a process of its own, or why there is none.

    Args:
        name: Of the figure, told with the reason.
        script: Python.
        settings: Of its environment, beside this process's.
    """
    # The script has no folder of its own; the project is found as this process found it.
    paths = os.pathsep.join(path for path in sys.path if path)
    environment = {**os.environ, **settings, "PYTHONPATH": paths}
    result = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=False
    )
    if result.returncode:
        return Absent(f"{name}: {result.stderr.strip().splitlines()[-1]}")
    return float(result.stdout)


def machine() -> dict[str, object]:
    """Return processor, cores, load in the last minute and versions, and nothing that names the machine."""
    return {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)),
        "load_per_core": round(os.getloadavg()[0] / (os.cpu_count() or 1), 1),
        "system": platform.system(),
        "python": platform.python_version(),
        **{package: version(package) for package in PACKAGES},
        **rivals.versions(),
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _resident() -> int:
    pages = int(STATM.read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")
