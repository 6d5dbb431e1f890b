"""How Numba makes a pointer of a row, see `pointers`."""

from __future__ import annotations

from typing import Any

from numba import types
from numba.core.errors import TypingError


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
