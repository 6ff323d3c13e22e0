"""What every settings model has in common, and the one door through which user files come in."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Self, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from swarmvision.errors import ConfigError, unknown_name

MAX_FILE_BYTES = 1_000_000  # a settings file is a few kB; more is a mistake


class Settings(BaseModel):
    """A frozen model that refuses unknown keys, nan and infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def replace(self, **changes: Any) -> Self:
        """Return a validated copy with some fields changed."""
        return validated(type(self), {**self.model_dump(), **changes}, type(self).__name__)


Model = TypeVar("Model", bound=BaseModel)


def validated(model: type[Model], values: Any, source: str) -> Model:
    """Return the model of ``values``.

    Raises:
        ConfigError: One line that names source, field, rule and value of the first fault.
    """
    try:
        return model.model_validate(values)
    except ValidationError as fault:
        raise ConfigError(_one_line(model, fault, source)) from None


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file.

    Raises:
        ConfigError: If the file is missing, too large, or not TOML.
    """
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise ConfigError(f"{path}: a settings file has at most {MAX_FILE_BYTES} bytes")
        with path.open("rb") as file:
            return tomllib.load(file)
    except OSError as fault:
        raise ConfigError(f"{path}: cannot be read: {fault.strerror or fault}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as fault:
        raise ConfigError(f"{path}: not valid TOML: {fault}") from None


def _one_line(model: type[BaseModel], fault: ValidationError, source: str) -> str:
    # A misspelt key is also a missing one; the misspelling is what helps.
    errors = sorted(fault.errors(include_url=False), key=lambda error: error["type"] != "extra_forbidden")
    error = errors[0]
    field = ".".join(str(part) for part in error["loc"])
    more = f" (and {fault.error_count() - 1} more)" if fault.error_count() > 1 else ""
    if error["type"] == "extra_forbidden":
        known = _fields_at(model, error["loc"][:-1])
        text = unknown_name("setting", str(error["loc"][-1]), known)
        place = ".".join(str(part) for part in error["loc"][:-1])
        return f"{source}: {place + ': ' if place else ''}{text}{more}"
    rule = error["msg"].removeprefix("Value error, ")
    shown = "" if error["type"] == "missing" else f", got {error['input']!r}"
    if len(shown) > 80:
        shown = shown[:77] + "..."
    return f"{source}: {field + ': ' if field else ''}{rule}{shown}{more}"


def _fields_at(model: type[BaseModel], path: tuple[int | str, ...]) -> list[str]:
    """Return the field names of the nested model at ``path``; walks the JSON Schema, which knows unions."""
    schema: dict[str, Any] = model.model_json_schema()
    definitions = schema.get("$defs", {})
    nodes = [schema]
    for part in path:
        nodes = _resolve(nodes, definitions)
        inner = []
        for node in nodes:
            if isinstance(part, int):
                inner.extend([node["items"]] if "items" in node else [])
            elif part in node.get("properties", {}):
                inner.append(node["properties"][part])
            elif node.get("properties", {}).keys() & {"kind", "law"}:
                inner.append(node)  # the tag of a discriminated union stands in the path
        tagged = [node for node in inner if _tag(node, definitions) == part]
        nodes = tagged or inner
    names = [name for node in _resolve(nodes, definitions) for name in node.get("properties", {})]
    return sorted(set(names))


def _resolve(nodes: list[dict[str, Any]], definitions: dict[str, Any]) -> list[dict[str, Any]]:
    resolved: list[dict[str, Any]] = []
    for node in nodes:
        if "$ref" in node:
            resolved += _resolve([definitions[node["$ref"].rsplit("/", 1)[-1]]], definitions)
        elif "anyOf" in node or "oneOf" in node or "allOf" in node:
            choices = node.get("anyOf", []) + node.get("oneOf", []) + node.get("allOf", [])
            resolved += _resolve(choices, definitions)
        else:
            resolved.append(node)
    return resolved


def _tag(node: dict[str, Any], definitions: dict[str, Any]) -> Any:
    for resolved in _resolve([node], definitions):
        for tag in ("kind", "law"):
            if "const" in resolved.get("properties", {}).get(tag, {}):
                return resolved["properties"][tag]["const"]
    return None
