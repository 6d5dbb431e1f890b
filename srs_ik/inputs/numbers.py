"""Numbers and flags as callers give them: complex ones, text and integers beyond floats are no numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from srs_ik.errors import InvalidConfiguration, SrsIkError, quoted
from srs_ik.system.arrays import Array

_REAL = "biufO"
"""Kinds of arrays that hold numbers, or objects that may be some; text and records would be read as figures."""


def real_array(values: Any) -> Array:
    """A new C-ordered array of floats.

    Raises:
        TypeError: not numbers, or complex ones, whose imaginary part NumPy would drop.
        ValueError: lists of different lengths, or integers that no float can hold.
    """
    try:
        raw = np.asarray(values)
        if raw.dtype.kind not in _REAL:
            raise TypeError(f"not real numbers, but {raw.dtype}")
        return np.array(raw, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise
    except Exception as error:  # OverflowError, and those of the object's own making
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


def as_flag(value: Any, what: str, error: type[SrsIkError] = InvalidConfiguration) -> bool:
    """True or False, of Python or NumPy: text such as "no" would be true. Raises the error, which `what` begins."""
    if value is True or value is False:
        return value
    if isinstance(value, np.bool_):
        return bool(value)
    raise error(f"{what} must be True or False, not {quoted(value)}")
