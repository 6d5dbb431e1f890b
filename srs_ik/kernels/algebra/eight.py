"""One of two, eight times in step."""

from __future__ import annotations

from srs_ik.kernels.algebra.lanes import where
from srs_ik.kernels.jit import kernel

ALL = 0b11111111
"""Eight truths as bits, the first the lowest."""


@kernel
def larger(a, b):
    """The larger of eight floats each."""
    return where(a > b, a, b)


@kernel
def smaller(a, b):
    """The smaller of eight floats each."""
    return where(a < b, a, b)


@kernel
def choose(which, a, b):
    """Eight vectors, each of two, by a mask."""
    return where(which, a[0], b[0]), where(which, a[1], b[1]), where(which, a[2], b[2])
