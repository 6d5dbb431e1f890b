"""Numbers and flags as callers give them: flags, complex ones, text and integers beyond floats are no numbers."""

from __future__ import annotations

import math
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidConfiguration, SrsIkError, quoted
from srs_ik.system.arrays import Array

_REAL = "iufO"
"""Kinds of arrays that hold numbers, or objects that may be some; masks, text and records would be read as figures."""

FLOAT = np.dtype(np.float64)

LARGEST_GRAVITY = 1e6
"""m/s^2; torques of larger ones are no figures of an arm."""


def is_plain(values: Any) -> TypeGuard[Array]:
    """Whether a kernel can read an array as it is: floats in C order, in writeable memory."""
    return type(values) is np.ndarray and values.dtype is FLOAT and values.flags.carray


def real_array(values: Any) -> Array:
    """A new C-ordered array of floats; what a masked array hides is NaN.

    Raises:
        TypeError: not numbers, but flags, say, or complex ones, whose imaginary part NumPy would drop.
        ValueError: lists of different lengths, or integers that no float can hold.
    """
    try:
        raw = np.asarray(values)
        if raw.dtype.kind not in _REAL:
            raise TypeError(f"not real numbers, but {raw.dtype}")
        array = np.array(raw, dtype=np.float64, order="C")
        if isinstance(values, np.ma.MaskedArray):
            array[np.ma.getmaskarray(values)] = np.nan
        return array
    except (TypeError, ValueError):
        raise
    except Exception as error:  # OverflowError, and those of the object's own making
        raise ValueError(str(error)) from None


def array_or_empty(values: Any) -> Array:
    """The same, and an array (0,) for what is none: its shape is wrong wherever figures are expected."""
    try:
        return real_array(values)
    except (TypeError, ValueError):
        return np.empty(0)


def vector_of(value: Any, size: int, what: str, error: type[SrsIkError]) -> Array:
    """(size,) floats, finite or not; raises the error, which `what` begins, for anything else."""
    try:
        vector = real_array(value)
    except (TypeError, ValueError):
        raise error(f"{what} must be {size} numbers, not {type(value).__name__}") from None
    if vector.shape != (size,):
        raise error(f"{what} must be {size} numbers, not an array of shape {vector.shape}")
    return vector


def real_number(value: Any) -> float:
    """A number as a float; NaN for what is none."""
    if isinstance(value, float):
        return float(value)
    # NumPy drops an imaginary part with no more than a warning, and float() reads text, and flags as 0 and 1.
    if isinstance(value, str | bytes | bytearray | bool | np.bool_):
        return math.nan
    try:
        is_flag = isinstance(value, np.ndarray) and value.dtype == np.bool_
        return math.nan if is_flag or np.iscomplexobj(value) else float(value)
    except Exception:  # of the object's own making
        return math.nan


def what_is(values: Any) -> str:
    """What was given in place of numbers or of an array of another shape, for the end of a message."""
    if values is None or isinstance(values, str | bytes | bool):
        return quoted(values)
    try:
        raw = np.asarray(values)
    except Exception:  # of the object's own making
        return "lists of different lengths" if isinstance(values, list | tuple) else type(values).__name__
    if raw.dtype.kind not in _REAL:
        kinds = {"c": "complex numbers", "U": "text", "S": "text", "b": "flags, True and False"}
        return kinds.get(raw.dtype.kind, f"an array of {raw.dtype}")
    if raw.dtype == object:
        odd = [each for each in raw.flat if math.isnan(real_number(each))]
        if odd:
            return f"{type(values).__name__}{f' with {quoted(odd[0])} in it' if raw.ndim else ''}"
    return f"an array of shape {raw.shape}" if raw.ndim else quoted(values)


def per_joint(given: Any, what: str, most: float, endless: bool = False) -> Array:
    """(7,) positive figures up to `most`, of one for all joints or of 7; `endless`: inf stands for none.

    Raises:
        InvalidConfiguration: anything else; `what` names it.
    """
    values = array_or_empty(given)
    good = (values > 0.0) & ((values <= most) | (endless & np.isinf(values)))
    if values.shape not in ((), (7,)) or not good.all():
        none = " (inf: none)" if endless else ""
        expected = f"{what} must be a positive number{none}, or 7 of them, one a joint, {most:g} at most"
        raise InvalidConfiguration(f"{expected}; not {what_is(given) if values.size != 7 else quoted(given)}")
    return np.full(7, values)


def as_flag(value: Any, what: str, error: type[SrsIkError] = InvalidConfiguration) -> bool:
    """True or False, of Python or NumPy: text such as "no" would be true. Raises the error, which `what` begins."""
    if value is True or value is False:
        return value
    if isinstance(value, np.bool_):
        return bool(value)
    raise error(f"{what} must be True or False, not {quoted(value)}")


def as_positive(value: Any, what: str, unit: str, error: type[SrsIkError] = InvalidConfiguration) -> float:
    """A finite number above zero; raises the error, in which `what` names it, for anything else, True among it."""
    number = real_number(value)
    if not 0.0 < number < math.inf:
        raise error(f"{what} must be a positive number of {unit}, not {quoted(value)}")
    return number


def as_gravity(gravity: ArrayLike) -> Array:
    """The acceleration of gravity as a (3,) array of floats.

    Raises:
        InvalidConfiguration: not three finite numbers, or one beyond `LARGEST_GRAVITY`.
    """
    array = array_or_empty(gravity)
    if array.shape != (3,) or not np.abs(array).max() <= LARGEST_GRAVITY:
        usual = f"m/s^2, up to {LARGEST_GRAVITY:g}, such as [0, 0, -9.81]"
        raise InvalidConfiguration(f"gravity must be 3 numbers, {usual}, not {quoted(gravity)}")
    return array
