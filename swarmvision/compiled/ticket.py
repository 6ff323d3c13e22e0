"""Tickets for threads that share work: each takes the next one until there is nothing left to do."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import HAS_NUMBA, leaf

Counter = NDArray[np.int64]
"""What the next ticket says, shape ``(1,)``."""

if HAS_NUMBA:
    from llvmlite import ir  # type: ignore[import-untyped]
    from numba.core import types
    from numba.extending import intrinsic

    @intrinsic  # type: ignore[untyped-decorator]
    def _count_on(typingctx: Any, counter: Any) -> Any:
        """Return the first number of an array and add 1 to it, in one step for all threads."""

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            view = context.make_array(signature.args[0])(context, builder, arguments[0])
            return builder.atomic_rmw("add", view.data, ir.Constant(ir.IntType(64), 1), "monotonic")

        return types.int64(counter), generate

else:
    _LOCK = threading.Lock()

    def _count_on(counter: Counter) -> int:
        with _LOCK:
            number = int(counter[0])
            counter[0] = number + 1
            return number


@leaf
def ticket(counter: Counter) -> int:
    """Return a number that no other thread gets: 0, 1, 2, ..."""
    number: int = _count_on(counter)
    return number
