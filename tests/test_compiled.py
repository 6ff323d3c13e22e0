"""Kernels that are kept on disk are those of today's sources."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("numba")

CALLEE = "from swarmvision.compiled import compiled\n@compiled\ndef inner(x):\n    return x * {factor}\n"
CALLER = (
    "from swarmvision.compiled import compiled\nfrom pack.inner import inner\n"
    "@compiled\ndef outer(x):\n    return later(x)\n"
    "@compiled\ndef later(x):\n    return inner(x) + 1.0\n"
)
ASK = (
    "from numba.core import event; import pack.outer\n"
    "with event.install_recorder('numba:compile') as seen: value = pack.outer.outer(3.0)\n"
    "print(value, len(seen.buffer) > 0)"
)


def test_a_kernel_is_compiled_anew_when_what_it_calls_has_changed(tmp_path: Path) -> None:
    package = tmp_path / "pack"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "outer.py").write_text(CALLER)

    def answer(factor: float) -> list[str]:
        (package / "inner.py").write_text(CALLEE.format(factor=factor))
        result = subprocess.run(
            [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n{ASK}"],
            capture_output=True,
            text=True,
            check=True,
        )
        return result.stdout.split()

    assert answer(2.0) == ["7.0", "True"]
    assert answer(2.0) == ["7.0", "False"]  # kept
    assert answer(5.0) == ["16.0", "True"]
