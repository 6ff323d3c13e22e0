"""The map of the project is true: imports point down only, and siblings do not know each other."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

# Lowest first. Rooms on one floor do not know each other; inside a room everything may.
FLOORS: tuple[tuple[str, ...], ...] = (
    ("errors", "geometry", "compiled", "randomness"),
    ("colour", "trigonometry", "recycling"),
    ("data", "config"),
    ("marker", "camera", "drive", "ground", "bodies"),
    ("world", "contacts", "placement", "rendering", "perception", "controllers", "metrics", "pictures"),
    ("sensing", "outcome"),
    ("simulation", "worlds", "recording", "drawing"),
    ("envs", "experiments"),
    ("showcase", "doctor", "calibration"),
    ("reproduction", "benchmark"),
    ("cli",),
    ("__main__",),
)
FLOOR_OF = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
# Formulas without numbers of their own may be shared on the two lowest floors.
FOUNDATION_MAY_SHARE = {"errors", "geometry", "compiled", "randomness"}


def modules() -> list[tuple[str, Path]]:
    """Every module of the package as (room, path)."""
    found = []
    for base, prefix in (
        (ROOT / "swarmvision", None),
        (ROOT / "envs", "envs"),
        (ROOT / "controllers", "controllers"),
    ):
        for path in sorted(base.rglob("*.py")):
            parts = path.relative_to(base).parts
            if prefix is None and parts[0] in ("envs", "controllers"):
                continue  # the links
            room = prefix or parts[0].removesuffix(".py")
            if room not in ("__init__", "scenarios"):
                found.append((room, path))
    return found


def imported_rooms(path: Path) -> set[str]:
    """Rooms that a module imports at run time; imports for type checkers alone do not count."""
    rooms = set()
    waiting: list[ast.AST] = [ast.parse(path.read_text())]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            waiting.extend(node.orelse)
            continue
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            parts = name.split(".")
            if parts[0] == "swarmvision" and len(parts) > 1 and parts[1] in FLOOR_OF:
                rooms.add(parts[1])
        waiting.extend(ast.iter_child_nodes(node))
    return rooms


@pytest.mark.parametrize(("room", "path"), modules(), ids=lambda value: str(value).removeprefix(str(ROOT)))
def test_imports_point_down(room: str, path: Path) -> None:
    assert room in FLOOR_OF, f"{path} stands in no room of the map"
    for other in imported_rooms(path) - {room}:
        if other in FOUNDATION_MAY_SHARE:
            continue
        assert FLOOR_OF[other] < FLOOR_OF[room], f"{path}: {room} imports {other}, which is not below it"


def test_a_controller_cannot_reach_the_world() -> None:
    for room, path in modules():
        if room == "controllers":
            assert not imported_rooms(path) & {"world", "rendering", "perception", "simulation", "sensing"}


def test_there_are_no_import_circles() -> None:
    names = {_module_name(path): str(path) for _, path in modules()}
    edges = {
        str(path): {names[name] for name in _imported_modules(path) if name in names} for _, path in modules()
    }
    state: dict[str, int] = {}

    def visit(node: str, trail: tuple[str, ...]) -> None:
        assert state.get(node) != 1, f"circle: {' -> '.join((*trail, node))}"
        if state.get(node) == 2:
            return
        state[node] = 1
        for after in sorted(edges[node]):
            visit(after, (*trail, node))
        state[node] = 2

    for node in edges:
        visit(node, ())


def _module_name(path: Path) -> str:
    parts = list(path.relative_to(ROOT).with_suffix("").parts)
    if parts[0] in ("envs", "controllers"):
        parts.insert(0, "swarmvision")
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imported_modules(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("swarmvision"):
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return names - {_module_name(path)}
