"""Put a benchmark's table and plot into the README and the docs.

    swarmvision bench --out out/bench
    python benchmarks/publish.py out/bench

What stands between the two comments ``bench`` and ``/bench`` is replaced.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path

from swarmvision.benchmark.table import table_text

ROOT = Path(__file__).parent.parent
PAGES = (ROOT / "README.md", ROOT / "docs" / "benchmarks.md")


def main(folder: Path) -> None:
    """Write both pages and copy the plot."""
    table = table_text(json.loads((folder / "bench.json").read_text()))
    for page in PAGES:
        text, found = re.subn(
            r"(?<=<!-- bench -->\n).*(?=<!-- /bench -->)", lambda _: table, page.read_text(), flags=re.DOTALL
        )
        if found != 1:
            sys.exit(f"{page} must have one place for the table, it has {found}")
        page.write_text(text)
    shutil.copy(folder / "bench.png", ROOT / "docs" / "img" / "bench.png")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/bench"))
