"""Feasible arm angles, of one pose and of many: there as many intervals a pose as it has, behind one another."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from srs_ik.inputs.poses import PoseLike, as_matrices, as_matrix, invalid_pose, refuse_bad_poses
from srs_ik.kernels.entries import pose as entries
from srs_ik.kernels.layout.answer import MOST_INTERVALS
from srs_ik.solve.threads import run_in_threads
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

BLOCK = 64 * MOST_INTERVALS
"""Intervals that a thread gathers before it puts them aside: half a megabyte, and hundreds of poses."""


class Interval(NamedTuple):
    """Arm angles that are feasible in a branch, ends included; ``psi in interval`` counts whole turns alike.

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

    def __contains__(self, arm_angle: Any) -> bool:
        turn = 2.0 * np.pi
        return bool(self.lower + (arm_angle - self.lower) % turn <= self.upper) or arm_angle == self.upper


class IntervalsBatch:
    """Feasible arm angles of N poses, those of pose i from `offsets[i]` to `offsets[i + 1]` - 1; `[i]` lists them.

    A slice, a list of numbers or a mask picks poses.

    Attributes:
        branch: (M,) branch of each interval, 0 to 7.
        lower: (M,) first arm angle, in [-pi, pi), rad.
        upper: (M,) last arm angle, rad; it may pass pi. The whole circle is (-pi, pi).
        offsets: (N + 1,) where the intervals of each pose begin, and behind the last one, M.
    """

    __slots__ = ("branch", "lower", "offsets", "upper")

    def __init__(self, branch: NDArray[np.int64], lower: Array, upper: Array, offsets: NDArray[np.int64]) -> None:
        self.branch = branch
        self.lower = lower
        self.upper = upper
        self.offsets = offsets

    @property
    def counts(self) -> NDArray[np.int64]:
        """(N,) number of intervals of each pose; zero where there is no posture."""
        return np.diff(self.offsets)

    @property
    def width(self) -> Array:
        """(M,) length of each interval, rad."""
        return self.upper - self.lower

    def __bool__(self) -> bool:
        raise TypeError("the intervals of many poses have no truth value: their counts have one for each")

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @overload
    def __getitem__(self, index: int) -> list[Interval]: ...
    @overload
    def __getitem__(self, index: slice | Sequence[int] | NDArray[Any]) -> IntervalsBatch: ...
    def __getitem__(self, index: int | slice | Sequence[int] | NDArray[Any]) -> list[Interval] | IntervalsBatch:
        """Those of one pose, or of the poses of a slice, of a list of numbers or of a mask."""
        try:
            pose = operator.index(index)  # type: ignore[arg-type]
        except TypeError:
            return self._of(np.arange(len(self))[index].ravel())
        count = len(self)
        if not -count <= pose < count:
            raise IndexError(f"there is no pose {pose} of {count}")
        first = pose % count
        of_pose = slice(self.offsets[first], self.offsets[first + 1])
        return listed(self.branch[of_pose], self.lower[of_pose], self.upper[of_pose])

    def _of(self, poses: NDArray[np.int64]) -> IntervalsBatch:
        """Those of some poses, by their numbers."""
        counts = self.counts[poses]
        offsets = np.append(0, np.cumsum(counts))
        rows = np.arange(offsets[-1]) + np.repeat(self.offsets[poses] - offsets[:-1], counts)
        return IntervalsBatch(self.branch[rows], self.lower[rows], self.upper[rows], offsets)

    def __iter__(self) -> Iterator[list[Interval]]:
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        return f"IntervalsBatch({len(self.branch)} intervals of {len(self)} poses)"


def intervals(arm: PackedArm, pose: PoseLike, respect_limits: bool) -> list[Interval]:
    """Feasible arm angles of one pose; see `Arm.intervals`."""
    out = np.empty((MOST_INTERVALS, 3))
    count = entries.intervals(arm.family, as_matrix(pose), respect_limits, out)
    if count < 0:
        raise invalid_pose(-count)
    branch, lower, upper = out[:count].T
    return listed(branch.astype(np.int64), lower, upper)


def listed(branch: NDArray[np.int64], lower: Array, upper: Array) -> list[Interval]:
    """Intervals of which branches (n,) and ends (n,), (n,) are given."""
    return list(map(Interval._make, zip(branch.tolist(), lower.tolist(), upper.tolist(), strict=True)))


def intervals_batch(arm: PackedArm, poses: Any, respect_limits: bool, threads: int | None) -> IntervalsBatch:
    """Feasible arm angles of many poses; see `Arm.intervals_batch`."""
    T = as_matrices(poses)

    def write(first: int, last: int, respect: bool, *out: Any) -> tuple[int, int]:
        return entries.intervals_range(arm.family, T, first, last, respect, *out)

    return gathered(len(T), threads, write, respect_limits)


Writer = Callable[..., tuple[int, int]]
"""Writes intervals: of first pose, last pose, respect, rows, counts, verdicts the next pose, and the rows used."""


def gathered(n: int, threads: int | None, write: Writer, respect: bool) -> IntervalsBatch:
    """The intervals of n poses, by what writes those of some of them.

    Raises:
        InvalidPose: a pose is no finite rigid transform; the message names the first one.
    """
    verdicts = np.zeros(n, np.int8)
    offsets = np.zeros(n + 1, np.int64)
    blocks: list[tuple[int, Array]] = []

    def work(first: int, last: int) -> None:
        rows = np.empty((BLOCK, 3))
        while first < last:
            begin = first
            first, used = write(begin, last, respect, rows, offsets[1:], verdicts)
            blocks.append((begin, rows[:used].copy()))

    run_in_threads(work, n, threads)
    refuse_bad_poses(verdicts)
    np.cumsum(offsets, out=offsets)
    m = int(offsets[-1])
    branch, lower, upper = np.empty(m, np.int64), np.empty(m), np.empty(m)
    blocks.sort(key=lambda block: block[0])
    while blocks:
        begin, rows = blocks.pop()
        at = slice(offsets[begin], offsets[begin] + len(rows))
        branch[at], lower[at], upper[at] = rows.T
    return IntervalsBatch(branch, lower, upper, offsets)
