"""A hundred thousand pictures through the loop: does memory grow?

    python benchmarks/soak.py [PICTURES]

Prints by how much resident memory has grown, in MB.
"""

from __future__ import annotations

import sys

from swarmvision.benchmark.process import memory_growth
from swarmvision.benchmark.timing import Absent


def main(pictures: int) -> None:
    """Take them all."""
    growth = memory_growth(pictures)
    if isinstance(growth, Absent):
        sys.exit(growth.reason)
    print(f"{pictures} pictures: resident memory has grown by {growth:.2f} MB")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100_000)
