"""Numbers as callers give them, alone and in arrays: complex ones, text and integers beyond floats are none."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def real_array(values: Any) -> Array:
    """A new C-ordered array of floats.

    Raises:
        TypeError: complex numbers, whose imaginary part NumPy would drop.
        ValueError: not numbers, or integers that no float can hold.
    """
    raw = np.asarray(values)
    if raw.dtype.kind == "c":
        raise TypeError("complex numbers")
    try:
        return np.array(raw, dtype=np.float64, order="C")
    except OverflowError as error:
        raise ValueError(str(error)) from None


def real_number(value: Any) -> float:
    """A number as a float; NaN for what is none."""
    if isinstance(value, float):
        return float(value)
    # NumPy drops an imaginary part with no more than a warning, and float() reads text.
    if isinstance(value, str | bytes | bytearray):
        return math.nan
    try:
        return math.nan if np.iscomplexobj(value) else float(value)
    except Exception:  # of the object's own making
        return math.nan
