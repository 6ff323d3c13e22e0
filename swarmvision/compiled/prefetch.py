"""Ask for memory before it is needed.

Processors foresee what a loop reads on, but not beyond a page of 4 KiB: two rows of a picture.
"""

from __future__ import annotations

from typing import Any

try:
    from numba.core import cgutils, config, types
    from numba.extending import intrinsic
except ImportError:
    WITH_NUMBA = False
else:
    WITH_NUMBA = not config.DISABLE_JIT

if WITH_NUMBA:
    from llvmlite import ir  # type: ignore[import-untyped]

    TO_WRITE, KEEP, DATA = 1, 3, 1  # arguments of LLVM's prefetch

    @intrinsic  # type: ignore[untyped-decorator]
    def prefetch(typingctx: Any, array: Any, row: Any, column: Any) -> Any:
        """Ask for the line of the cache with an element of an array of two axes, to read and to write it."""

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            kind = signature.args[0]
            view = context.make_array(kind)(context, builder, arguments[0])
            places = [
                context.cast(builder, place, given, types.intp)
                for place, given in zip(arguments[1:], signature.args[1:], strict=True)
            ]
            element = cgutils.get_item_pointer(context, builder, kind, view, places)
            pointer, number = cgutils.voidptr_t, ir.IntType(32)
            ask = builder.module.declare_intrinsic(
                "llvm.prefetch", [pointer], ir.FunctionType(ir.VoidType(), [pointer, number, number, number])
            )
            builder.call(
                ask,
                [
                    builder.bitcast(element, pointer),
                    *(ir.Constant(number, n) for n in (TO_WRITE, KEEP, DATA)),
                ],
            )
            return context.get_dummy_value()

        return types.none(array, row, column), generate

else:

    def prefetch(array: Any, row: int, column: int) -> None:
        """Do nothing: uncompiled there is nothing to be won."""
