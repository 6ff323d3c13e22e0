"""How a tracked camera errs, as tables: a file beside this one, fitted from our own camera runs.

Errors are kept as quantiles, not as moments, because their tails are heavy: half of all bearings are
right to a fifth of a milliradian, while a robot that spins is wrong by ten. The quantiles stand at
equal steps of a normal deviate, so a standard normal number picks one without a logarithm.

Signs follow the mirror law: bearing and heading errors are stored times the sign of the observer's turn,
those of a marker that is cut times the sign of its side (:mod:`swarmvision.sensing.error_views`).
Range errors are stored over the square of the range, with which they grow.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from importlib import resources
from pathlib import Path
from typing import Any, Self

import numpy as np

from swarmvision.errors import ConfigError
from swarmvision.geometry import FloatArray

DEVIATES = np.linspace(-3.0, 3.0, 19)  # where the quantiles stand: every third of a standard deviation
RANGES = np.array([0.118, 0.13, 0.15, 0.165, 0.18, 0.2, 0.25, 0.3, 0.45, 0.65, 0.9, 1.2, 1.6, 2.2])
"""Between bins of true range (m)."""
TURNS = np.array([0.1, 0.3, 0.8, 1.5])  # rad/s, between bins of the observer's own turn rate
VISIBLES = np.array([0.05, 0.25, 0.65, 0.95])  # between bins of the fraction in sight
CUTS = 2  # more bins, of those in full sight that the edge of a picture cuts
AGES = np.array([0.15, 0.25, 0.45, 0.75])  # s, between bins of the time since a neighbour was measured
FILE = "error_model.json"


@dataclass(frozen=True, eq=False, slots=True)
class ErrorTable:
    """Bins of range, turn rate and view ``(d, t, v)``, of age ``(a,)``; quantiles ``(q,)``."""

    again: FloatArray
    """Chance that a neighbour measured in the last picture is measured in this one, ``(d, t, v)``."""
    anew: FloatArray
    """Chance that one that was not is, ``(d, t, v)``."""
    fresh: FloatArray
    """Errors of range over its square (1/m), bearing and heading (rad) when measured, ``(d, t, v, 3, q)``."""
    fresh_std: FloatArray
    """Standard deviations that the tracker states, ``(d, t, v, 3)``."""
    aged_std: FloatArray
    """And of a neighbour that is remembered, ``(a, t, 3)``."""
    phantom: FloatArray
    """Measurements of nobody per robot and picture, ``(1,)``."""
    phantom_place: FloatArray
    """Range (m) and bearing (rad) of phantoms, ``(2, q)``."""
    lasting: FloatArray
    """Share of the variance of the deviates of range, bearing, heading that lasts; the rest is new in every
    picture, ``(3,)``."""
    memory: FloatArray
    """Correlation from picture to picture of what lasts, ``(3,)``."""
    common: FloatArray
    """Their correlation between two neighbours of one observer, ``(3,)``."""

    def as_json(self, provenance: dict[str, Any]) -> str:
        """Return the text of an error model's file: where it comes from, then the tables, 4 digits each."""
        content: dict[str, Any] = {"provenance": provenance}
        content["bins"] = {
            "range_m": RANGES.tolist(),
            "turn_rate": TURNS.tolist(),
            "visible": VISIBLES.tolist(),
            "age_s": AGES.tolist(),
            "deviates": DEVIATES.tolist(),
        }
        lines = ",\n".join(f'  "{key}": {json.dumps(value)}' for key, value in content.items())
        for field in fields(self):
            table = getattr(self, field.name)
            numbers = ", ".join(f"{number:.4g}" for number in table.ravel())
            lines += f',\n  "{field.name}": {{"shape": {list(table.shape)}, "values": [{numbers}]}}'
        return "{\n" + lines + "\n}\n"

    @classmethod
    def load(cls, path: Path | None = None) -> Self:
        """Return the tables in a file; those that ship with the package where not given.

        Raises:
            ConfigError: If the file cannot be read or is no error model of these bins.
        """
        try:
            if path is None:
                text = (resources.files("swarmvision.sensing") / FILE).read_text()
            else:
                text = path.read_text()
            content = json.loads(text)
            tables = {
                field.name: np.array(content[field.name]["values"], dtype=np.float64).reshape(
                    content[field.name]["shape"]
                )
                for field in fields(cls)
            }
        except OSError as fault:
            raise ConfigError(f"{path}: cannot be read: {fault.strerror or fault}") from None
        except (ValueError, KeyError, TypeError) as fault:
            raise ConfigError(f"{path}: is no error model: {type(fault).__name__}: {fault}") from None
        return cls(**tables)._checked(path)

    def _checked(self, path: Path | None) -> Self:
        bins = (len(RANGES) + 1, len(TURNS) + 1, len(VISIBLES) + 1 + CUTS)
        ages, q = len(AGES) + 1, len(DEVIATES)
        shapes: dict[str, tuple[int, ...]] = {
            "again": bins,
            "anew": bins,
            "fresh": (*bins, 3, q),
            "fresh_std": (*bins, 3),
            "aged_std": (ages, bins[1], 3),
            "phantom": (1,),
            "phantom_place": (2, q),
            "lasting": (3,),
            "memory": (3,),
            "common": (3,),
        }
        for name, shape in shapes.items():
            table = getattr(self, name)
            if table.shape != shape or not np.isfinite(table).all():
                raise ConfigError(f"{path or FILE}: {name} must be finite numbers of shape {shape}")
        return self


def provenance(path: Path | None = None) -> dict[str, Any]:
    """Return where the numbers of an error model come from."""
    text = path.read_text() if path else (resources.files("swarmvision.sensing") / FILE).read_text()
    told: dict[str, Any] = json.loads(text)["provenance"]
    return told
