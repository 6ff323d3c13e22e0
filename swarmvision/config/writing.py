"""Settings as TOML: the way back from :func:`swarmvision.config.model.read_toml`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from swarmvision.config.model import Settings


def as_toml(settings: Settings, remark: str = "") -> str:
    """Return settings as a TOML file that reads back to the same; what is None is left out.

    Args:
        settings: Any settings model.
        remark: Comment at the head of the file, one or more lines.
    """
    lines = [f"# {line}".rstrip() for line in remark.splitlines()]
    return "\n".join([*lines, *_table(settings.model_dump(mode="json"), ""), ""])


def _table(values: Mapping[str, Any], path: str) -> list[str]:
    """Return the lines of one table: plain values first, for a table's head ends the one before."""
    lines, inner = [], []
    for key, value in values.items():
        name = f"{path}.{key}" if path else key
        if isinstance(value, Mapping):
            inner += ["", f"[{name}]", *_table(value, name)]
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            for item in value:
                inner += ["", f"[[{name}]]", *_table(item, name)]
        elif value is not None:
            lines.append(f"{key} = {_value(value)}")
    return lines + inner


def _value(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(_value(item) for item in value)}]"
    # JSON writes strings, numbers and booleans as TOML does; TOML wants DEL escaped too.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
