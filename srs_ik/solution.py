"""Answers of inverse kinematics: a posture with its status and its measured errors, alone or many in arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels import layout as at

Array = NDArray[np.float64]


class Status(IntEnum):
    """What an answer is worth."""

    OK = 0
    """The posture reaches the pose: both errors are below 1e-9 (m, rad), limits kept if they were to be."""
    UNREACHABLE = 1
    """No posture reaches the pose; the closest one is given: the arm stretched, or folded, towards the target."""
    OUT_OF_LIMITS = 2
    """Postures reach the pose, but none inside the joint limits; the least violating one is given, put on limits."""


_STATUSES = tuple(Status)


class Solution:
    """One posture for one pose; true in a boolean test if and only if its status is `Status.OK`."""

    __slots__ = ("_joint_names", "_row")

    def __init__(self, row: Array, joint_names: Sequence[str]) -> None:
        self._row = row
        self._joint_names = joint_names

    @property
    def q(self) -> Array:
        """(7,) joint angles, rad; finite in every status."""
        return self._row[: at.ROW_POSITION_ERROR]

    @property
    def status(self) -> Status:
        """Whether the pose is reached, and if not, why."""
        return _STATUSES[int(self._row[at.ROW_STATUS])]

    @property
    def branch(self) -> int:
        """Branch, 4 elbow + 2 shoulder + wrist, each 0 or 1: the side of its middle angle on which the joint lies."""
        return int(self._row[at.ROW_BRANCH])

    @property
    def arm_angle(self) -> float:
        """Arm angle (swivel angle, SEW angle) in [-pi, pi), rad: right-handed about shoulder-wrist."""
        return float(self._row[at.ROW_ARM_ANGLE])

    @property
    def position_error(self) -> float:
        """Distance of the tip at `q` from the pose, metres, by forward kinematics of the chain as described."""
        return float(self._row[at.ROW_POSITION_ERROR])

    @property
    def orientation_error(self) -> float:
        """Angle between the tip at `q` and the pose, rad."""
        return float(self._row[at.ROW_ORIENTATION_ERROR])

    @property
    def message(self) -> str:
        """One sentence for a person."""
        errors = f"{self.position_error:.3g} m and {self.orientation_error:.3g} rad"
        if self.status is Status.OK:
            return f"Solved in branch {self.branch} at arm angle {self.arm_angle:.6g} rad, within {errors}."
        if self.status is Status.OUT_OF_LIMITS:
            blocking = self._joint_names[int(self._row[at.ROW_JOINT]) - 1]
            return f"No posture sought keeps the joint limits; {blocking} blocks, and q put on them leaves {errors}."
        return f"The pose is out of reach for the postures that were sought; the closest one leaves {errors}."

    def as_dict(self) -> dict[str, float]:
        """Joint angles by joint name, rad, in the order of the joints."""
        return dict(zip(self._joint_names, self.q.tolist(), strict=True))

    def __bool__(self) -> bool:
        return bool(self._row[at.ROW_STATUS] == Status.OK)

    def __repr__(self) -> str:
        return (
            f"Solution(status={self.status.name}, q={np.array2string(self.q, precision=6)}, branch={self.branch}, "
            f"arm_angle={self.arm_angle:.6g}, position_error={self.position_error:.3g}, "
            f"orientation_error={self.orientation_error:.3g})"
        )


class _Rows:
    """Arrays over solution rows, named as the fields of `Solution`."""

    def __init__(self, rows: Array, joint_names: Sequence[str]) -> None:
        self._rows = rows
        self._joint_names = joint_names

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

    def __len__(self) -> int:
        return len(self._rows)


class Solutions(_Rows, Sequence[Solution]):
    """All postures that answer one pose: a sequence of `Solution` over arrays (`q` is (n, 7)).

    Where it is empty, `status` is empty too; `message` says why.
    """

    def __init__(self, rows: Array, joint_names: Sequence[str], failure: Solution | None = None) -> None:
        super().__init__(rows, joint_names)
        self.failure = failure
        """The best posture that is no solution, where there is no solution; else None."""

    @property
    def message(self) -> str:
        """One sentence for a person: how many postures, or why there is none."""
        if self.failure is not None:
            return self.failure.message
        return f"{len(self)} {'posture' if len(self) == 1 else 'postures'} found."

    @overload
    def __getitem__(self, index: int) -> Solution: ...
    @overload
    def __getitem__(self, index: slice) -> Solutions: ...
    def __getitem__(self, index: int | slice) -> Solution | Solutions:
        if isinstance(index, slice):
            return Solutions(self._rows[index], self._joint_names, self.failure)
        return Solution(self._rows[index], self._joint_names)

    def __iter__(self) -> Iterator[Solution]:
        return (Solution(row, self._joint_names) for row in self._rows)

    def __repr__(self) -> str:
        return f"Solutions({self.message})"


class BatchSolution(_Rows):
    """Answers to N poses: every field of `Solution` as an array over N, or over (N, 8) with all branches."""

    def message(self, *index: int) -> str:
        """The sentence for one answer."""
        return self[index if len(index) > 1 else index[0]].message

    def __getitem__(self, index: int | tuple[int, ...]) -> Any:
        row = self._rows[index]
        return Solution(row, self._joint_names) if row.ndim == 1 else BatchSolution(row, self._joint_names)

    @cached_property
    def solved(self) -> int:
        """How many answers have the status `Status.OK`."""
        return int(self.ok.sum())

    def __repr__(self) -> str:
        return f"BatchSolution({self.solved} of {self.ok.size} solved)"


@dataclass(frozen=True, slots=True)
class Interval:
    """Arm angles that are feasible in a branch, ends included.

    Attributes:
        branch: 0 to 7.
        lower: first arm angle, in [-pi, pi), rad.
        upper: last arm angle, rad; it may pass pi. The whole circle is (-pi, pi).
    """

    branch: int
    lower: float
    upper: float

    @property
    def width(self) -> float:
        """Length of the interval, rad."""
        return self.upper - self.lower

    def __contains__(self, arm_angle: float) -> bool:
        turn = 2.0 * np.pi
        return bool(self.lower + (arm_angle - self.lower) % turn <= self.upper) or arm_angle == self.upper
