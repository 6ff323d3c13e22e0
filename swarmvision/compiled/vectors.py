"""What a processor does to many bytes at once in a few instructions that no loop becomes by itself.

Bytes are compared ``BLOCK`` at a time; bits stand for *words* of ``WORD`` bytes, the lowest for the first.
Arrays are of two axes, rows contiguous; nothing is asked about borders. Uncompiled, the same is plain NumPy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmvision.compiled import HAS_NUMBA

Image = NDArray[np.uint8]
WORD = 8
BLOCK = 8 * WORD

if HAS_NUMBA:
    from llvmlite import ir  # type: ignore[import-untyped]
    from numba.core import cgutils, types
    from numba.extending import intrinsic

    BIT, BYTE, LONG = ir.IntType(1), ir.IntType(8), ir.IntType(64)
    BYTES, WORDS = ir.VectorType(BYTE, BLOCK), ir.VectorType(LONG, BLOCK // WORD)

    def _place(context: Any, builder: Any, kind: Any, array: Any, places: Any, type_: Any) -> Any:
        """Return the address of an element as one of another type, which begins anywhere."""
        view = context.make_array(kind)(context, builder, array)
        pointer = cgutils.get_item_pointer(context, builder, kind, view, places)
        return builder.bitcast(pointer, type_.as_pointer())

    def _marked(builder: Any, one: Any, two: Any) -> Any:
        """Return in which words two vectors differ, as a number."""
        return builder.zext(builder.bitcast(builder.icmp_unsigned("!=", one, two), BYTE), LONG)

    @intrinsic  # type: ignore[untyped-decorator]
    def differing(typingctx: Any, lines: Any, one: Any, other: Any, place: Any) -> Any:
        """Return in which words from a place on two rows of bytes differ."""

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            array, row, other_row, at = arguments
            places = [
                _place(context, builder, signature.args[0], array, [y, at], WORDS) for y in (row, other_row)
            ]
            return _marked(builder, *(builder.load(each, align=1) for each in places))

        return types.uint64(lines, types.intp, types.intp, types.intp), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def uneven(typingctx: Any, lines: Any, row: Any, place: Any, step: Any) -> Any:
        """Return in which words from a place on a byte is not as the one ``step`` on, give or take 1."""

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            array, y, at, far = arguments
            one, two = (
                builder.load(_place(context, builder, signature.args[0], array, [y, x], BYTES), align=1)
                for x in (at, builder.add(at, far))
            )
            more = builder.icmp_unsigned(">", one, two)
            apart = builder.select(more, builder.sub(one, two), builder.sub(two, one))
            large = builder.and_(apart, ir.Constant(BYTES, [254] * BLOCK))
            return _marked(builder, builder.bitcast(large, WORDS), ir.Constant(WORDS, [0] * (BLOCK // WORD)))

        return types.uint64(lines, types.intp, types.intp, types.intp), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def lowest(typingctx: Any, bits: Any) -> Any:
        """Return the place of the lowest bit that is set; of no bits it is 64."""

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.cttz(arguments[0], ir.Constant(BIT, 0))

        return types.int64(types.uint64), generate

else:

    def differing(lines: Image, one: int, other: int, place: int) -> np.uint64:
        """Return in which words from a place on two rows of bytes differ."""
        return _words_of(lines[one, place : place + BLOCK] != lines[other, place : place + BLOCK])

    def uneven(lines: Image, row: int, place: int, step: int) -> np.uint64:
        """Return in which words from a place on a byte is not as the one ``step`` on, give or take 1."""
        here = lines[row, place : place + BLOCK].astype(np.int64)
        return _words_of(np.abs(here - lines[row, place + step : place + step + BLOCK]) > 1)

    def _words_of(off: NDArray[np.bool_]) -> np.uint64:
        return np.uint64(np.packbits(off.reshape(-1, WORD).any(axis=1), bitorder="little")[0])

    def lowest(bits: np.uint64) -> int:
        """Return the place of the lowest bit that is set; of no bits it is 64."""
        return (int(bits) & -int(bits)).bit_length() - 1 if bits else 64
