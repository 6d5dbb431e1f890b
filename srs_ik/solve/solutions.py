"""Answers of inverse kinematics, many at a time: those to one pose, or to many, in arrays."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.layout import answer as at
from srs_ik.solve.solution import Collision, ElbowRange, Solution, Status
from srs_ik.system.arrays import Array, rows_at

SHOWN = 5
"""Messages that are printed of either end of many."""


class _Rows:
    """Arrays over solution rows, named as the fields of `Solution`."""

    def __init__(self, rows: Array, joint_names: Sequence[str], elbow: ElbowRange | None = None) -> None:
        self._rows = rows
        self._joint_names = joint_names
        self._elbow = elbow

    def _solution(self, row: Array) -> Solution:
        return Solution(row, self._joint_names, self._elbow)

    @property
    def q(self) -> Array:
        """(..., 7) joint angles, rad."""
        return self._rows[..., : at.ROW_POSITION_ERROR]

    @property
    def status(self) -> NDArray[np.int64]:
        """(...) values of `Status`."""
        return self._rows[..., at.ROW_STATUS].astype(np.int64)

    @property
    def ok(self) -> NDArray[np.bool_]:
        """(...) true where the status is `Status.OK`."""
        return self._rows[..., at.ROW_STATUS] == float(Status.OK)

    @property
    def branch(self) -> NDArray[np.int64]:
        """(...) branches, 0 to 7."""
        return self._rows[..., at.ROW_BRANCH].astype(np.int64)

    @property
    def arm_angle(self) -> Array:
        """(...) arm angles, rad."""
        return self._rows[..., at.ROW_ARM_ANGLE]

    @property
    def position_error(self) -> Array:
        """(...) metres."""
        return self._rows[..., at.ROW_POSITION_ERROR]

    @property
    def orientation_error(self) -> Array:
        """(...) rad."""
        return self._rows[..., at.ROW_ORIENTATION_ERROR]

    def as_dict(self) -> dict[str, Array]:
        """(...) joint angles by joint name, rad, in the order of the joints, whatever their status; see `as_table`."""
        return {name: self.q[..., k] for k, name in enumerate(self._joint_names)}

    def as_table(self) -> dict[str, NDArray[Any]]:
        """Columns (n,), a row for each answer: joint angles by joint name (rad), and what became of the answer.

        That is "status" (the name of the `Status`), "branch", "arm_angle" (rad), "position_error" (m) and
        "orientation_error" (rad), as `srs-ik solve --out` writes them. `pandas.DataFrame` takes it as it is.
        """
        names = np.array([status.name for status in Status])
        columns = {name: angles.ravel() for name, angles in self.as_dict().items()}
        columns["status"] = names[self.status.ravel()]
        for field in ("branch", "arm_angle", "position_error", "orientation_error"):
            columns[field] = getattr(self, field).ravel()
        return columns

    def __len__(self) -> int:
        return len(self._rows)


class Solutions(_Rows, Sequence[Solution]):
    """All postures that answer one pose: a sequence of `Solution` over arrays (`q` is (n, 7)).

    Where it is empty, `status` is empty too; `message` says why.
    """

    def __init__(
        self, rows: Array, joint_names: Sequence[str], failure: Solution | None = None, elbow: ElbowRange | None = None
    ) -> None:
        super().__init__(rows, joint_names, elbow)
        self.failure = failure
        """The best posture that is no solution, where there is no solution; else None."""

    @property
    def message(self) -> str:
        """One sentence for a person: how many postures, or why there is none."""
        if self.failure is not None:
            return self.failure.message
        return f"{len(self)} {'posture' if len(self) == 1 else 'postures'} found."

    @classmethod
    def of_one(cls, solution: Solution) -> Solutions:
        """The sequence of this solution alone."""
        return cls(solution._row[None], solution._joint_names, elbow=solution._elbow)

    @overload
    def __getitem__(self, index: int) -> Solution: ...
    @overload
    def __getitem__(self, index: slice | Sequence[int] | NDArray[Any]) -> Solutions: ...
    def __getitem__(self, index: int | slice | Sequence[int] | NDArray[Any]) -> Solution | Solutions:
        """One posture, or those of a slice, of a list of numbers or of a mask: ``found[found.q[:, 3] < 0]``."""
        if isinstance(index, tuple):
            raise IndexError(f"postures have one index, not {len(index)}")
        rows = self._rows[index]
        if rows.ndim > 1:
            return Solutions(rows.reshape(-1, rows.shape[-1]), self._joint_names, self.failure, self._elbow)
        return self._solution(rows)

    def __iter__(self) -> Iterator[Solution]:
        return map(self._solution, self._rows)

    def __repr__(self) -> str:
        return f"Solutions({self.message})"


class BatchSolution(_Rows):
    """Answers to N poses: every field of `Solution` as an array over N, or over (N, 8) with all branches.

    It has no truth value: ``batch.ok.all()`` and ``batch.ok.any()`` say what is meant.
    """

    def __init__(
        self,
        rows: Array,
        joint_names: Sequence[str],
        elbow: ElbowRange | None = None,
        collisions: Mapping[tuple[int, ...], Collision] | None = None,
    ) -> None:
        super().__init__(rows, joint_names, elbow)
        self.collisions = dict(collisions or {})
        """What hits what, by the index of the pose (and of the branch), where the status is `Status.COLLISION`."""

    @property
    def message(self) -> Messages:
        """The sentences for a person: ``message[i]``, ``message[:3]``, or ``message(i)``."""
        return Messages(self)

    def __getitem__(self, index: Any) -> Any:
        row = rows_at(self._rows, index)
        if row.ndim > 1:
            return BatchSolution(row, self._joint_names, self._elbow, self._collisions_of(index))
        numbers = [i for i in index if i is not Ellipsis] if isinstance(index, tuple) else [index]
        place = tuple(range(n)[int(i)] for n, i in zip(self._rows.shape, numbers, strict=False))
        return Solution(row, self._joint_names, self._elbow, self.collisions.get(place))

    def _collisions_of(self, index: Any) -> dict[tuple[int, ...], Collision]:
        """Those of a part of the answers."""
        if not self.collisions:
            return {}
        numbers = np.arange(self._rows[..., 0].size).reshape(self._rows.shape[:-1])
        whole = {int(numbers[place]): hit for place, hit in self.collisions.items()}
        part = numbers[index]
        return {place: whole[int(k)] for place, k in np.ndenumerate(part) if int(k) in whole}

    def __bool__(self) -> bool:
        raise TypeError("many answers have no truth value: write .ok.all() or .ok.any(), or test one of them")

    @cached_property
    def solved(self) -> int:
        """How many answers have the status `Status.OK`."""
        return int(self.ok.sum())

    def __repr__(self) -> str:
        return f"BatchSolution({self.solved} of {self.ok.size} solved)"


class Messages:
    """The sentences of many answers, in arrays of text over N or (N, 8); each is written when it is read.

    Called with an index, of a pose or of pose and branch, it gives one of them.
    """

    def __init__(self, answers: BatchSolution) -> None:
        self._answers = answers

    def __call__(self, *index: int) -> str:
        """The sentence for one answer.

        Raises:
            IndexError: another number of indices than `status` has axes, or one out of range.
        """
        axes = self._answers._rows.ndim - 1
        if len(index) != axes:
            raise IndexError(f"message takes {axes} indices here, not {len(index)}")
        found: str = self._answers[index].message
        return found

    def __getitem__(self, index: Any) -> Any:
        found = self._answers[index].message
        return found if isinstance(found, str) else np.asarray(found)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        found = np.empty(self._answers._rows.shape[:-1], object)
        for place in np.ndindex(found.shape):
            found[place] = self(*place)
        return found if dtype is None else found.astype(dtype)

    def __len__(self) -> int:
        return len(self._answers)

    def __iter__(self) -> Iterator[Any]:
        return (self[k] for k in range(len(self)))

    def __repr__(self) -> str:
        shape = self._answers._rows.shape[:-1]
        count = math.prod(shape)
        # `range` ends in its last ones without listing those between.
        numbers = [*range(count)[:SHOWN], *range(count)[SHOWN:][-SHOWN:]]
        places = [tuple(map(int, np.unravel_index(k, shape))) for k in numbers]
        lines = [f"{', '.join(map(str, place))}: {self(*place)}" for place in places]
        if count > len(lines):
            lines.insert(SHOWN, "...")
        return "\n".join([f"Messages of {count} answers", *lines])
