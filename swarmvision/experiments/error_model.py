"""The error model of the state-only sensor, fitted from camera runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from subprocess import CalledProcessError, run
from typing import Any

import numpy as np

from swarmvision.config.sensor import CameraSensorConfig
from swarmvision.experiments.error_fit import fit
from swarmvision.experiments.flights import COLUMNS, FLIGHTS, REACH, REMEMBERED, Record, flown, record


def error_model_text(
    rounds: int, seed: int, workers: int | None = None, tell: Callable[[str], None] = lambda line: None
) -> str:
    """Return the text of the error model's file, from camera runs made now.

    Args:
        rounds: How often each of :data:`FLIGHTS` is flown, each time with another seed.
        seed: Of the first round.
        workers: Threads; change nothing.
        tell: Is told of every flight that is over.
    """
    commit = _commit()
    records: list[Record] = []
    for n in range(rounds):
        for f, flight in enumerate(FLIGHTS):
            number = n * len(FLIGHTS) + f
            records.append(record(flight, seed + number, number, workers=workers))
            tell(f"{number + 1} of {rounds * len(FLIGHTS)}: {flight}")
    rows = np.concatenate(records)
    scenario = flown(FLIGHTS[0], "camera", REACH)
    camera = scenario.sensor
    assert isinstance(camera, CameraSensorConfig)
    lenses = len(camera.rig.yaws_deg)
    told: dict[str, Any] = {
        "command": f"swarmvision fit-error-model --rounds {rounds} --seed {seed}",
        "method": "frequencies and quantiles of what trackers believed, set beside the truth",
        "flights": [asdict(flight) for flight in FLIGHTS],
        "seeds": [seed, seed + rounds * len(FLIGHTS) - 1],
        "pictures": rounds * lenses * sum(flight.robots * flight.steps for flight in FLIGHTS),
        "neighbours": int(np.count_nonzero(rows[:, COLUMNS.index("state")] <= REMEMBERED)),
        "date": datetime.now(UTC).date().isoformat(),
        "commit": commit,
        "versions": {name: version(name) for name in ("swarmvision", "numpy", "opencv-python-headless")},
        "sensor": camera.model_dump(mode="json"),
    }
    return fit(rows, scenario.robot.marker.radius).as_json(told)


def _commit() -> str | None:
    """Return the commit that runs; None outside of a clone."""
    try:
        told = run(
            ("git", "describe", "--always", "--dirty"),
            cwd=Path(__file__).parent,
            capture_output=True,
            text=True,
            check=True,
        )
    except (OSError, CalledProcessError):
        return None
    return told.stdout.strip()
