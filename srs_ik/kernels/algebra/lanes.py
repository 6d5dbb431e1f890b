"""Eight floats as one: a vector register, on which the kernels of `vectors` work as on floats.

A number among eight floats stands for eight equal ones.
"""

from srs_ik.kernels.algebra.lane_functions import (
    LANES,
    as_bits,
    as_mask,
    eight_of,
    gather,
    one_of,
    root,
    scatter,
    where,
    whole_number,
)
from srs_ik.kernels.jit import BY_NUMBA, kernel

if BY_NUMBA:
    import srs_ik.kernels.algebra.lane_types  # noqa: F401

__all__ = ["LANES", "as_bits", "as_mask", "eight_of", "gather", "one_of", "root", "scatter", "where", "whole_number"]

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
