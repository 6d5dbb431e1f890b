"""Eight floats as one: a vector register, on which the kernels of `vectors` work as on floats.

A number among eight floats stands for eight equal ones.
"""

from __future__ import annotations

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
from srs_ik.kernels.jit import BY_NUMBA

if BY_NUMBA:
    import srs_ik.kernels.algebra.lane_types  # noqa: F401

__all__ = ["LANES", "as_bits", "as_mask", "eight_of", "gather", "one_of", "root", "scatter", "where", "whole_number"]
