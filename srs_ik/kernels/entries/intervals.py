"""Entry point for the feasible arm angles of many poses, whose number is known only once they are found."""

from __future__ import annotations

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.answer import GOOD_POSE, MOST_INTERVALS
from srs_ik.kernels.layout.asked import Target
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import place
from srs_ik.kernels.pose.intervals import all_intervals


@entry
def intervals_range(family, poses, first, last, respect, J, A, rows, counts, verdicts):
    """Intervals of the poses from first to last - 1, as far as rows suffice; returns the next pose and the rows used.

    Args:
        family: packed limbs.
        poses: (N, 4, 4) poses.
        first: first pose to be answered.
        last: one behind the last.
        respect: whether the joint limits have to be kept.
        J: (6, 7) work space, or None.
        A: (16, 9) work space, or None.
        rows: (n, 3) output: branch, lower and upper end of each interval, pose after pose; n at least MOST_INTERVALS.
        counts: (N,) output: intervals of each pose.
        verdicts: (N,) output: verdict on each pose.
    """
    used = 0
    i = first
    while i < last and used + MOST_INTERVALS <= rows.shape[0]:
        R, p, verdicts[i] = read_pose(row(poses, i))
        counts[i] = 0
        if verdicts[i] == GOOD_POSE:
            place_ = place(row(family, LIMITED), R, p)
            counts[i] = all_intervals(family, Target(R, p, place_), respect, J, A, rows[used : used + MOST_INTERVALS])
        used += counts[i]
        i += 1
    return i, used


@entry
def intervals(family, T, respect, J, A, out):
    """Feasible intervals of one pose: number of rows written to `out` (n, 3), or minus the verdict."""
    R, p, verdict = read_pose(row(T, 0))
    if verdict != GOOD_POSE:
        return -verdict
    return all_intervals(family, Target(R, p, place(row(family, LIMITED), R, p)), respect, J, A, out)
