"""What callers give to torque controllers and simulations, checked: figures, and things of some class.

Each function gives back what its docstring says, or raises InvalidController; `what` names it in the message.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import numpy as np

from srs_ik.errors import InvalidController, listed, quoted
from srs_ik.inputs.numbers import array_or_empty, as_flag, real_array, real_number
from srs_ik.system.arrays import Array

Thing = TypeVar("Thing")

MOST = 10_000_000
"""Samples of a motion or a response."""


def positive(value: Any, what: str) -> float:
    """A positive number."""
    return _within(value, what, math.nextafter(0.0, 1.0), "a positive number")


def not_negative(value: Any, what: str) -> float:
    """A number from 0 on."""
    return _within(value, what, 0.0, "a number from 0 on")


def number(value: Any, what: str) -> float:
    """A finite number."""
    return _within(value, what, -sys.float_info.max, "a finite number")


def _within(value: Any, what: str, least: float, wanted: str) -> float:
    found = real_number(value)
    if not least <= found < math.inf:
        raise InvalidController(f"the {what} has to be {wanted}, not {quoted(value)}")
    return found


def count(value: Any, what: str) -> int:
    """A whole number from 1 to `MOST`."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 1 <= value <= MOST:
        raise InvalidController(f"the {what} has to be a whole number from 1 to {MOST:,}, not {quoted(value)}")
    return int(value)


def flag(value: Any, what: str) -> bool:
    """True or False."""
    return as_flag(value, what, InvalidController)


def one_of(value: Any, names: Iterable[str], what: str) -> str:
    """One of some names; `what` is what has to be one."""
    if not (isinstance(value, str) and value in names):
        raise InvalidController(f"{what} one of {listed(list(names))}, not {quoted(value)}")
    return value


def thing(value: Any, kind: type[Thing], what: str, made: str = "") -> Thing:
    """A thing of a class; `made` says how to make one."""
    if not isinstance(value, kind):
        hint = f", as {made} makes it" if made else ""
        raise InvalidController(f"the {what} has to be of class {kind.__name__}{hint}, not {quoted(value)}")
    return value


def things(values: Any, kind: type[Thing], what: str) -> tuple[Thing, ...]:
    """Several things of a class."""
    try:
        found = tuple(values)
    except Exception:  # of the object's own making
        raise InvalidController(f"the {what} have to be a list of {kind.__name__}, not {quoted(values)}") from None
    for value in found:
        if not isinstance(value, kind):
            raise InvalidController(f"the {what} have to be a list of {kind.__name__}; {quoted(value)} is none")
    return found


def called(value: Any, what: str) -> Callable[..., Any]:
    """Something to call."""
    if not callable(value):
        raise InvalidController(f"the {what} has to be a function, not {quoted(value)}")
    return value


def vector(value: Any, what: str, size: int = 3) -> Array:
    """Three finite numbers, or as many as are wanted."""
    numbers = array_or_empty(value)
    if numbers.shape != (size,) or not np.isfinite(numbers).all():
        raise InvalidController(f"the {what} has to be {size} finite numbers, not {quoted(value)}")
    return numbers


def distances(value: Any, what: str) -> Array:
    """Finite numbers in any shape."""
    try:
        numbers = real_array(value)
    except (TypeError, ValueError):
        numbers = np.array(np.nan)
    if not np.isfinite(numbers).all():
        raise InvalidController(f"{what} has to be a finite number, or an array of them, not {quoted(value)}")
    return numbers


def seven_positive(value: Any, what: str) -> Array:
    """(7,) positive figures from one or seven; infinite ones too."""
    values = _seven(value)
    if not (values > 0.0).all():
        raise InvalidController(f"{what} has to be one or seven positive figures, not {quoted(value)}")
    return values


def seven_not_negative(value: Any, what: str) -> Array:
    """(7,) finite figures from 0 on, from one or seven."""
    values = _seven(value)
    if not ((values >= 0.0) & np.isfinite(values)).all():
        raise InvalidController(f"{what} has to be one or seven figures, none negative, not {quoted(value)}")
    return values


def torques(value: Any) -> Array:
    """(7,) finite torques."""
    numbers = value if type(value) is np.ndarray and value.dtype == np.float64 else array_or_empty(value)
    if numbers.shape != (7,) or not math.isfinite(sum(numbers.tolist())):
        raise InvalidController(f"a torque has to be 7 finite numbers, N m, not {quoted(value)}")
    return numbers


def _seven(value: Any) -> Array:
    """(7,) figures, of one or of seven; NaN for anything else."""
    values = array_or_empty(value)
    return np.full(7, values if values.shape in ((), (1,), (7,)) else np.nan)
