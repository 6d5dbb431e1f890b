"""Where callers want the elbow: near a point, or at an arm angle."""

from __future__ import annotations

from typing import Any

import numpy as np

from srs_ik.errors import InvalidConfiguration, quoted
from srs_ik.inputs.angles import as_arm_angle
from srs_ik.inputs.numbers import array_or_empty
from srs_ik.system.arrays import Array

FARTHEST_POINT = 1e6
"""The farthest point, m; squares of it are far from the ends of floats."""


def as_elbow(
    elbow: Any, n: int | None = None, what: str = "a point (3,), m, or an arm angle, rad"
) -> tuple[float | None, Array]:
    """An arm angle, rad, and no points; or None, and points: (1, 3) one for all, or (n, 3) one a pose.

    Raises:
        InvalidConfiguration: neither a number nor points, or not finite.
    """
    array = array_or_empty(elbow)
    if array.ndim == 0 and not np.isnan(array):
        return as_arm_angle(elbow), np.empty((0, 3))
    array = np.atleast_1d(array)
    points = array[None] if array.ndim == 1 else array
    if points.shape != (1, 3) and points.shape != (n, 3):
        several = "" if n is None or n == 1 else f", or {n} points"
        given = quoted(elbow) if array.size <= 4 else f"an array of shape {array.shape}"
        raise InvalidConfiguration(f"elbow must be {what}{several}, not {given}")
    if not np.abs(points).max(initial=0.0) <= FARTHEST_POINT:
        raise InvalidConfiguration(f"elbow must be a point of finite numbers, up to {FARTHEST_POINT:g} m")
    return None, points


def refuse_beside(**others: Any) -> None:
    """Raise InvalidConfiguration for what does not go with an elbow."""
    given = [name for name, value in others.items() if value is not None and value is not False]
    if given:
        raise InvalidConfiguration(f"elbow does not go with {given[0]}: give one of the two")
