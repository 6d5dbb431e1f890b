"""Rows of an array as pointers: one machine word to pass on, and nothing to count references of.

As an array, a row would be seven words, and an atomic count up and down, in every kernel that takes it: about a third
of the time of a solve. A pointer keeps nothing alive: the array has to be an argument of the entry point, or to be
kept.
"""

from __future__ import annotations

import math
from typing import Any

from numba import config, types
from numba.core.errors import TypingError
from numba.extending import intrinsic

from srs_ik.kernels.jit import kernel


@kernel
def keep(array):
    """Any use of an array keeps it until there."""
    return array.size


def _row(array: Any, index: int) -> Any:
    return array.reshape(-1)[index * math.prod(array.shape[1:]) :]


def _typed_row(typing_context: Any, array: Any, index: Any) -> Any:
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


row = _row if config.DISABLE_JIT else intrinsic(_typed_row)
"""row(array, index): the figures of array[index] and of the rows behind it, as a pointer to the first.

The row 0 of a pointer is the pointer itself.
"""
