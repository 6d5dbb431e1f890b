"""`Task`: what the hand has to do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidTask
from srs_ik.inputs.numbers import real_array
from srs_ik.kernels.entries import task as entries
from srs_ik.kernels.layout import task as at
from srs_ik.system.arrays import Array

_FIELDS = ("position", "velocity", "force", "grasp", "pronosupination")
_FIRST_OPTIONAL = 3
_FLOAT = np.dtype(np.float64)


class Task:
    """What the hand has to do: be somewhere, move one way and push another; one task, or N of them.

    Every argument is (3,), one for all tasks, or (N, 3), in the base frame; with any (N, 3) there are N tasks.
    Directions may have any length but zero. Velocity and force span the plane in which the task happens; they need not
    be orthogonal, and may even be parallel.

    Args:
        position: of the tip, metres.
        velocity: direction in which the hand has to move easily, the paper's v.
        force: direction in which it has to bear or to push, the paper's f.
        grasp: direction in which the hand reaches out, the paper's g; without it the hand lines up with the forearm.
        pronosupination: direction that says how the hand is turned about `grasp`, the paper's phi; its part across
            `grasp` counts. Without it the roll of the hand is free.

    Attributes:
        count: number of tasks; None for one whose fields are all (3,).

    Raises:
        InvalidTask: an argument of another shape, not finite, or without direction; grasp and pronosupination parallel.
    """

    __slots__ = ("_given", "_raw", "_rows", "count")

    def __init__(
        self,
        position: ArrayLike,
        velocity: ArrayLike,
        force: ArrayLike,
        grasp: ArrayLike | None = None,
        pronosupination: ArrayLike | None = None,
    ) -> None:
        arrays = [
            None if values is None and i >= _FIRST_OPTIONAL else _vectors(_FIELDS[i], values)
            for i, values in enumerate((position, velocity, force, grasp, pronosupination))
        ]
        self.count = _common_count(arrays)
        self._given = 0 if grasp is None else at.GRASP
        self._given |= 0 if pronosupination is None else at.PRONOSUPINATION
        self._raw = np.zeros((1 if self.count is None else self.count, at.TASK))
        for i, array in enumerate(arrays):
            if array is not None:
                self._raw[:, 3 * i : 3 * i + 3] = array
        self._rows = np.empty_like(self._raw)
        row, fault = entries.read_tasks(self._raw, self._given, self._rows)
        if fault:
            raise self._invalid(row, fault)

    def _invalid(self, row: int, fault: int) -> InvalidTask:
        which = "" if self.count is None else f" of task {row}"
        if fault == at.ROLL_OPEN:
            return InvalidTask(f"grasp and pronosupination{which} are parallel, and leave the roll of the hand open")
        figures = self._raw[row].reshape(-1, 3)
        if fault == at.NOT_FINITE:
            name = _FIELDS[int(np.flatnonzero(~np.isfinite(figures).all(axis=1))[0])]
            return InvalidTask(f"{name}{which} has entries that are not finite numbers")
        asked = [True, True, True, bool(self._given & at.GRASP), bool(self._given & at.PRONOSUPINATION)]
        zero = ~figures.any(axis=1) & asked & (np.arange(5) > 0)
        return InvalidTask(f"{_FIELDS[int(np.flatnonzero(zero)[0])]}{which} is zero, and no direction")

    def _field(self, first: int) -> Array:
        values = self._raw[:, first : first + 3] if self.count is not None else self._raw[0, first : first + 3]
        view = values.view()
        view.flags.writeable = False
        return view

    @property
    def position(self) -> Array:
        """(3,) or (N, 3) position of the tip, metres; read-only, as are the directions."""
        return self._field(at.TASK_POSITION)

    @property
    def velocity(self) -> Array:
        """(3,) or (N, 3) direction, of the length that it was given with."""
        return self._field(at.TASK_VELOCITY)

    @property
    def force(self) -> Array:
        """(3,) or (N, 3) direction, of the length that it was given with."""
        return self._field(at.TASK_FORCE)

    @property
    def grasp(self) -> Array | None:
        """(3,) or (N, 3) direction, of the length that it was given with; None without."""
        return self._field(at.TASK_GRASP) if self._given & at.GRASP else None

    @property
    def pronosupination(self) -> Array | None:
        """(3,) or (N, 3) direction, of the length that it was given with; None without."""
        return self._field(at.TASK_PRONOSUPINATION) if self._given & at.PRONOSUPINATION else None

    def __repr__(self) -> str:
        many = "" if self.count is None else f"{self.count} tasks, "
        given = [name for name in _FIELDS[_FIRST_OPTIONAL:] if getattr(self, name) is not None]
        return f"Task({many}position, velocity, force{''.join(f', {name}' for name in given)})"


def _vectors(name: str, values: Any) -> Array:
    """One vector (3,) or N of them (N, 3)."""
    try:
        array = values if type(values) is np.ndarray and values.dtype is _FLOAT else real_array(values)
    except (TypeError, ValueError):
        raise InvalidTask(f"{name} of a task is 3 numbers, or an (N, 3) array, not {type(values).__name__}") from None
    if array.ndim not in (1, 2) or array.shape[-1] != 3:
        raise InvalidTask(f"{name} of a task is 3 numbers, or an (N, 3) array, not an array of shape {array.shape}")
    return array


def _common_count(arrays: Sequence[Array | None]) -> int | None:
    """The number of tasks, or None where every field is of one task."""
    counts = {name: len(a) for name, a in zip(_FIELDS, arrays, strict=True) if a is not None and a.ndim == 2}
    if len(set(counts.values())) > 1:
        told = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise InvalidTask(f"the fields of a task are for one task, or all for the same number of them, not {told}")
    return next(iter(counts.values()), None)
