"""Tasks, and the posture of an arm that suits them (the paper's postural optimisation)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidTask
from srs_ik.kernels.entries import task as entries
from srs_ik.kernels.task import posture as kernel
from srs_ik.solve.threads import run_in_threads

if TYPE_CHECKING:
    from srs_ik.arm import Arm

Array = NDArray[np.float64]
Side = Literal["left", "right"]
Tie = Literal["lower", "upper"]

SIDES = {"left": 1.0, "right": -1.0}
TIES = {"lower": -1.0, "upper": 1.0}

_FIELDS = ("position", "velocity", "force", "grasp", "pronosupination")
_FIRST_OPTIONAL = 3
_FLOAT = np.dtype(np.float64)

REACHED = 1e-9
"""A hand this near to its target, metres, has reached it."""


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
        self._given = 0 if grasp is None else kernel.GRASP
        self._given |= 0 if pronosupination is None else kernel.PRONOSUPINATION
        self._raw = np.zeros((1 if self.count is None else self.count, kernel.TASK))
        for i, array in enumerate(arrays):
            if array is not None:
                self._raw[:, 3 * i : 3 * i + 3] = array
        self._rows = np.empty_like(self._raw)
        row, fault = entries.read_tasks(self._raw, self._given, self._rows)
        if fault:
            raise self._invalid(row, fault)

    def _invalid(self, row: int, fault: int) -> InvalidTask:
        which = "" if self.count is None else f" of task {row}"
        if fault == kernel.ROLL_OPEN:
            return InvalidTask(f"grasp and pronosupination{which} are parallel, and leave the roll of the hand open")
        figures = self._raw[row].reshape(-1, 3)
        if fault == kernel.NOT_FINITE:
            name = _FIELDS[int(np.flatnonzero(~np.isfinite(figures).all(axis=1))[0])]
            return InvalidTask(f"{name}{which} has entries that are not finite numbers")
        asked = [True, True, True, bool(self._given & kernel.GRASP), bool(self._given & kernel.PRONOSUPINATION)]
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
        return self._field(kernel.TASK_POSITION)

    @property
    def velocity(self) -> Array:
        """(3,) or (N, 3) direction, of the length that it was given with."""
        return self._field(kernel.TASK_VELOCITY)

    @property
    def force(self) -> Array:
        """(3,) or (N, 3) direction, of the length that it was given with."""
        return self._field(kernel.TASK_FORCE)

    @property
    def grasp(self) -> Array | None:
        """(3,) or (N, 3) direction, of the length that it was given with; None without."""
        return self._field(kernel.TASK_GRASP) if self._given & kernel.GRASP else None

    @property
    def pronosupination(self) -> Array | None:
        """(3,) or (N, 3) direction, of the length that it was given with; None without."""
        return self._field(kernel.TASK_PRONOSUPINATION) if self._given & kernel.PRONOSUPINATION else None

    def __repr__(self) -> str:
        many = "" if self.count is None else f"{self.count} tasks, "
        given = [name for name in _FIELDS[_FIRST_OPTIONAL:] if getattr(self, name) is not None]
        return f"Task({many}position, velocity, force{''.join(f', {name}' for name in given)})"


class Posture:
    """Where the arm goes for a task, in the base frame, metres; for N tasks every field is an array over N.

    It is what the geometry of the arm allows, joint limits apart. On a near limb that of `Arm.posture` is the nearest
    exact limb's, and that of a solved task the true chain's.
    """

    __slots__ = ("_rows", "_shoulder", "side")

    def __init__(self, rows: Array, shoulder: Array, side: Side) -> None:
        self._rows = rows
        self._shoulder = shoulder
        self.side = side
        """Side of the body for which the elbow was chosen."""

    def _point(self, first: int) -> Array:
        return self._rows[..., first : first + 3]

    def _figure(self, index: int) -> Any:
        figure = self._rows[..., index]
        return figure if figure.ndim else float(figure)

    @property
    def shoulder(self) -> Array:
        """(3,) shoulder centre."""
        return np.broadcast_to(self._shoulder, self.elbow.shape)

    @property
    def elbow(self) -> Array:
        """(3,) elbow centre."""
        return self._point(kernel.ELBOW)

    @property
    def wrist(self) -> Array:
        """(3,) wrist centre."""
        return self._point(kernel.WRIST)

    @property
    def hand(self) -> Array:
        """(3,) tip of the hand; the task's position where that is reached."""
        return self._point(kernel.TIP)

    @property
    def normal(self) -> Array:
        """(3,) unit normal of the plane through shoulder, elbow and wrist, on the side of `task_normal`.

        Of all planes through the line from the shoulder to the wrist (without a grasp, to the hand) it is the one whose
        normal is as parallel to `task_normal` as can be. A stretched or folded arm lies in it as it would bend into it.
        """
        return self._point(kernel.NORMAL)

    @property
    def task_normal(self) -> Array:
        """(3,) unit normal of the task's plane: velocity x force, the paper's n."""
        return self._point(kernel.TASK_NORMAL)

    @property
    def direction(self) -> Array:
        """(3,) unit vector in which the hand reaches out: the grasp direction, or without one that of the forearm."""
        return self._point(kernel.DIRECTION)

    @property
    def arm_angle(self) -> Any:
        """Arm angle of the elbow about the line from shoulder to wrist, in [-pi, pi], rad."""
        return self._figure(kernel.ARM_ANGLE)

    @property
    def miss(self) -> Any:
        """How far the hand stays from the task's position, metres: positive where that is too far, negative near."""
        return self._figure(kernel.MISS)

    @property
    def reached(self) -> Any:
        """Whether the hand is at the task's position, to 1e-9 m; else the arm is stretched, or folded, towards it."""
        reached = np.abs(self._rows[..., kernel.MISS]) < REACHED
        return reached if reached.ndim else bool(reached)

    @property
    def message(self) -> str:
        """One sentence for a person."""
        if self._rows.ndim > 1:
            return f"{int(np.sum(self.reached))} of {len(self)} targets reached."
        if self.reached:
            return "The hand reaches the target."
        lie = "stretched towards" if self.miss > 0.0 else "folded towards"
        return f"The arm is {lie} the target, and the hand stays {abs(self.miss):.3g} m from it."

    def __len__(self) -> int:
        if self._rows.ndim == 1:
            raise TypeError("the posture of one task has no length")
        return len(self._rows)

    def __getitem__(self, index: int) -> Posture:
        """The posture of one task of many."""
        if self._rows.ndim == 1:
            raise TypeError("the posture of one task cannot be indexed")
        return Posture(self._rows[index], self._shoulder, self.side)

    def __repr__(self) -> str:
        return f"Posture({self.side}, {self.message})"


def posture(arm: Arm, task: Task, side: Side, tie: Tie, threads: int | None) -> Posture:
    """See `Arm.posture`."""
    sides, ties = signs(task, side, tie)
    family, hand, rows, given = arm._family, arm._packed_hand, task._rows, task._given
    if task.count is None:
        out = np.empty(kernel.POSTURE)
        entries.posture(family, hand, rows[0], given, sides, ties, out)
    else:
        out = np.empty((task.count, kernel.POSTURE))

        def work(first: int, last: int) -> None:
            entries.posture_range(family, hand, rows, first, last, given, sides, ties, out)

        run_in_threads(work, task.count, threads)
    return Posture(out, arm.limb.shoulder, side)


def signs(task: Task, side: Side, tie: Tie) -> tuple[float, float]:
    """Side and tie as the kernels take them.

    Raises:
        InvalidTask: no task, or no such side or tie.
    """
    if not isinstance(task, Task):
        raise InvalidTask(f"a task is a srs_ik.Task, not {type(task).__name__}")
    try:
        return SIDES[side], TIES[tie]
    except (KeyError, TypeError):
        raise InvalidTask(
            f'side is "left" or "right" and tie is "lower" or "upper", not {side!r} and {tie!r}'
        ) from None


def _vectors(name: str, values: Any) -> Array:
    """One vector (3,) or N of them (N, 3)."""
    try:
        array = np.asarray(values)
        if array.dtype is not _FLOAT:
            if array.dtype.kind == "c":
                raise TypeError
            array = array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
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
