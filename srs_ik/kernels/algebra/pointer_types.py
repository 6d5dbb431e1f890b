"""How Numba makes a pointer of a row, see `pointers`."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.np.arrayobj import make_array, populate_array


def typed_row(typing_context: Any, array: Any, index: Any) -> Any:
    """Type and code of `pointers.row`."""
    is_pointer = isinstance(array, types.CPointer)
    if not is_pointer and (not isinstance(array, types.Array) or array.layout != "C"):
        raise TypingError(f"only an array in C order has rows in one piece, not {array}")

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first, offset = arguments
        if not is_pointer:
            view = context.make_array(array)(context, builder, first)
            first = view.data
            for axis in range(1, array.ndim):
                offset = builder.mul(offset, builder.extract_value(view.shape, axis))
        return builder.gep(first, [offset])

    return types.CPointer(array.dtype)(array, types.intp), generate


def typed_copy(typing_context: Any, source: Any, target: Any, count: Any) -> Any:
    """Type and code of `pointers.copy`."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        a, b = (
            data if isinstance(kind, types.CPointer) else make_array(kind)(context, builder, data).data
            for data, kind in zip(arguments, (source, target), strict=False)
        )
        cgutils.raw_memmove(builder, b, a, arguments[2], itemsize=8)
        return context.get_dummy_value()

    return types.none(source, target, types.intp), generate


def typed_scratch(typing_context: Any, rows: Any, columns: Any) -> Any:
    """Type and code of `pointers.scratch`."""
    if not isinstance(rows, types.IntegerLiteral) or not isinstance(columns, types.IntegerLiteral):
        raise TypingError("the sizes of an array on the stack are constants")
    shape = rows.literal_value, columns.literal_value
    kind = types.Array(types.float64, 2, "C")

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word, item = ir.IntType(64), ir.DoubleType()
        room = cgutils.alloca_once(builder, ir.ArrayType(item, shape[0] * shape[1]))
        array = make_array(kind)(context, builder)
        populate_array(
            array,
            data=builder.bitcast(room, item.as_pointer()),
            shape=[word(n) for n in shape],
            strides=[word(8 * shape[1]), word(8)],
            itemsize=word(8),
            meminfo=None,
        )
        return array._getvalue()

    return kind(rows, columns), generate
