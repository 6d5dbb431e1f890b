"""The type of what is computed with, tuples of it, rows of it, and how JSON has it."""

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


def rows_at(rows: Array, index: Any) -> Array:
    """Those of some rows (..., columns) that an index of rows names; raises IndexError for one that names columns."""
    if not isinstance(index, tuple):
        return rows[index]
    np.broadcast_to(0, rows.shape[:-1])[index]
    found: Array = rows[(*index, slice(None))]
    return found


def plain(value: Any) -> Any:
    """Figures as JSON has them: arrays as lists, and None for what is infinite or does not exist."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
