"""Where to put the base of an arm so that it reaches the poses of its task."""

from __future__ import annotations

import operator
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from srs_ik.errors import InvalidTask, did_you_mean, quoted
from srs_ik.inputs.poses import as_matrices, refuse_bad_poses
from srs_ik.kernels.entries.pose import check_pose
from srs_ik.kernels.layout.maps import CELL_WIDTH
from srs_ik.kinematics import check_arm
from srs_ik.solve.reachable import largest_margins, measured, reachable_batch
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm

Measure = Literal["share", "width", "margin", "manipulability"]

AT_ONCE = 65_536
"""Poses in the frames of candidates that are held at once: 8 MB."""


class RankedBase(NamedTuple):
    """One candidate of a `Placement`."""

    candidate: int
    """Its place among the candidates."""
    share: float
    """Share of the poses that it reaches, 0 to 1."""
    value: float
    """What it is ranked by."""


@dataclass(frozen=True, eq=False)
class Placement:
    """Candidates for the base, best first when indexed or iterated over.

    The arrays are in the order in which candidates were given.

    Attributes:
        candidates: (M, 4, 4) poses of the base.
        by: what they are ranked by.
        value: (M,) mean of it over all poses, where a pose that is not reached counts 0. The share of poses reached;
            the width of the feasible arm angles, rad, all branches together; the margin to the limits, 0 to 1; or the
            largest manipulability.
        share: (M,) share of the poses that are reached, 0 to 1.
        reached: (M, N) which of them.
        order: (M,) places of the candidates, best first.
    """

    candidates: Array
    by: Measure
    value: Array
    share: Array
    reached: NDArray[np.bool_]
    order: NDArray[np.int64]

    @property
    def best(self) -> Array:
        """(4, 4) the best candidate."""
        best: Array = self.candidates[self.order[0]]
        return best

    def __bool__(self) -> bool:
        raise TypeError("a ranking has no truth value: placement[0].share is what the best reaches")

    def __len__(self) -> int:
        return len(self.order)

    def __getitem__(self, rank: int) -> RankedBase:
        """A candidate by its rank, 0 for the best."""
        i = self.order[operator.index(rank)]
        return RankedBase(int(i), float(self.share[i]), float(self.value[i]))

    def __iter__(self) -> Iterator[RankedBase]:
        return (self[rank] for rank in range(len(self)))

    def __repr__(self) -> str:
        best = self.order[0]
        poses = self.reached.shape[1]
        return f"Placement({len(self)} candidates, best {best}: {self.reached[best].sum()} of {poses} poses reached)"


def base_placement(
    arm: Arm, poses: Any, candidates: Any, by: Measure = "share", threads: int | None = None
) -> Placement:
    """Rank places for the base of an arm by how well it reaches poses from there. Every answer is exact.

    Args:
        arm: the arm.
        poses: (N, 4, 4) array or list of poses of its tip, in the frame of the room.
        candidates: (M, 4, 4) array or list of poses of its base, in the same frame.
        by: "share" of the poses reached; mean "width" of the feasible arm angles, mean "margin" to the limits or mean
            "manipulability", of the best posture each, where poses that are not reached count 0. Ties go to the larger
            share, then to the candidate that was given first.
        threads: at most so many; all processors if not given.

    Raises:
        InvalidPose: a pose or candidate is no finite rigid transform.
        InvalidConfiguration: `threads` is no positive integer.
        InvalidTask: there is no pose or no candidate, or another measure.
    """
    check_arm(arm)
    if not isinstance(by, str) or by not in get_args(Measure):
        known = get_args(Measure)
        raise InvalidTask(
            f"candidates are ranked by {', '.join(known)}, not by {quoted(by)}{did_you_mean(str(by), known)}"
        )
    T_room_tip, T_room_base = _checked(poses), _checked(candidates)
    if not len(T_room_tip) or not len(T_room_base):
        raise InvalidTask("a base is placed for one pose and among one candidate at least")
    m, n = len(T_room_base), len(T_room_tip)
    T_base_room = _inverses(T_room_base)
    reached, value = np.empty((m, n), bool), np.empty(m)
    block = max(1, AT_ONCE // n)
    for first in range(0, m, block):
        some = slice(first, min(first + block, m))
        T = np.matmul(T_base_room[some, None], T_room_tip[None]).reshape(-1, 4, 4)
        met = reachable_batch(arm.packed, T, threads)
        reached[some] = met.reshape(-1, n)
        values = met.astype(float)
        if by != "share":
            values[met] = _values(arm, T[met], by, threads)
        value[some] = values.reshape(-1, n).mean(axis=1)
    share = reached.mean(axis=1)
    order = np.lexsort((-share, -value))
    return Placement(T_room_base, by, value, share, reached, order)


def _checked(poses: Any) -> Array:
    T = as_matrices(poses)
    refuse_no_poses(T)
    return T


def refuse_no_poses(T: Array) -> None:
    """Raise InvalidPose for the first of (N, 4, 4) that is no finite rigid transform."""
    refuse_bad_poses(np.array([check_pose(each) for each in T], np.int8))


def _inverses(T: Array) -> Array:
    inverse = np.zeros_like(T)
    R = T[:, :3, :3].transpose(0, 2, 1)
    inverse[:, :3, :3] = R
    inverse[:, :3, 3] = -np.einsum("nij,nj->ni", R, T[:, :3, 3])
    inverse[:, 3, 3] = 1.0
    return inverse


def _values(arm: Arm, T: Array, by: Measure, threads: int | None) -> Array:
    """(N,) the measure of poses that are reached."""
    if by == "manipulability":
        from srs_ik.solve.optimise import optimise

        return np.array([optimise(arm.packed, arm, each, by).value for each in T])
    T = np.ascontiguousarray(T)
    if by == "margin":
        return largest_margins(arm.packed, T, threads)
    found: Array = measured(arm.packed, T, threads=threads)[:, CELL_WIDTH]
    return found
