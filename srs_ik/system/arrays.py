"""The type of what is computed with, and tuples of it."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""An array of floats."""

OfArrays = TypeVar("OfArrays", bound=type[Any])


def equal_to_itself(own: OfArrays) -> OfArrays:
    """Make a class of tuples equal by identity: those of arrays have no truth value when they are compared."""
    for name in ("__eq__", "__ne__", "__hash__"):
        setattr(own, name, getattr(object, name))
    return own
