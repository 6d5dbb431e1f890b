"""Rows of an array as pointers: one machine word to pass on, and nothing to count references of.

As an array, a row would be seven words, and an atomic count up and down, in every kernel that takes it: about a third
of the time of a solve. A pointer keeps nothing alive: the array has to be an argument of the entry point, or to be
kept.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from srs_ik.kernels.jit import BY_NUMBA, kernel

if BY_NUMBA:
    from numba.extending import intrinsic

    from srs_ik.kernels.algebra.pointer_types import typed_copy, typed_row, typed_scratch


@kernel
def keep(array):
    """Any use of an array keeps it until there."""
    return array.size


def _row(array: Any, index: int) -> Any:
    return array.reshape(-1)[index * math.prod(array.shape[1:]) :]


row = intrinsic(typed_row) if BY_NUMBA else _row
"""row(array, index): the figures of array[index] and of the rows behind it, as a pointer to the first.

The row 0 of a pointer is the pointer itself.
"""


@kernel
def read7(q):
    """Seven figures of a row as a tuple."""
    return (q[0], q[1], q[2], q[3], q[4], q[5], q[6])


def _copy(source: Any, target: Any, count: int) -> None:
    target.reshape(-1)[:count] = source.reshape(-1)[:count]


copy = intrinsic(typed_copy) if BY_NUMBA else _copy
"""copy(source, target, count): so many figures of one row written to another, at once."""


def _scratch(rows: int, columns: int) -> Any:
    return np.empty((rows, columns))


scratch = intrinsic(prefer_literal=True)(typed_scratch) if BY_NUMBA else _scratch
"""scratch(rows, columns): an array of floats on the stack of the function that calls it, which is gone when that ends.

It costs nothing, where an array from the heap takes part of a microsecond. Both sizes are constants, and small.
"""
