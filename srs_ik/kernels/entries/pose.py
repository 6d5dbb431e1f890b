"""Entry points: thin array wrappers around the kernels, for one pose and for many.

A solving function writes rows laid out as `ROW_*` in `layout`; statuses are numbered as in `srs_ik.Status`.
"""

import numpy as np

from srs_ik.kernels.algebra.pointers import read7, row, scratch
from srs_ik.kernels.algebra.vectors import load3
from srs_ik.kernels.chain.answer import measure_row
from srs_ik.kernels.exact.flat import exact_intervals
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.answer import GOOD_POSE, MAX_PIECES, MOST_INTERVALS, OK, ROW_STATUS
from srs_ik.kernels.layout.asked import Goal
from srs_ik.kernels.layout.limb import IS_NEAR, LIMITED
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.limits import set_limits
from srs_ik.kernels.limb.poses import is_same_pose, read_pose
from srs_ik.kernels.limb.triangle import read_target, target_of
from srs_ik.kernels.near.band import put_shift
from srs_ik.kernels.near.intervals import best_of_true_intervals
from srs_ik.kernels.near.led import lead_row
from srs_ik.kernels.near.on_curves import no_curves
from srs_ik.kernels.near.predicted_best import predicted_best_of_intervals
from srs_ik.kernels.pose.any_bend import best_of
from srs_ik.kernels.pose.elbow import angle_towards, solve_row_near
from srs_ik.kernels.pose.intervals import all_intervals
from srs_ik.kernels.pose.self_motion import self_motion_rows
from srs_ik.kernels.pose.solve import all_branches, own, own_goal, solve_row, solve_row_at


@entry
def solve(family, T, branch, seed, seeded, respect, out):
    """`solve_row` of one pose; `seeded` tells whether the seed counts."""
    goal = Goal(seeded, read7(row(seed, 0)), respect)
    return solve_row(family, row(T, 0), branch, goal, scratch(6, 7), scratch(16, 9), row(out, 0))


@entry
def solve_at(family, T, psi, branch, seed, seeded, respect, out):
    """`solve_row_at` of one pose; `seeded` tells whether the seed counts."""
    goal = Goal(seeded, read7(row(seed, 0)), respect)
    return solve_row_at(family, row(T, 0), psi, branch, goal, scratch(6, 7), scratch(16, 9), row(out, 0))


@entry
def lead(family, T, psi, branch, before, seed, seeded, respect, out):
    """Write the row of a near limb's posture at an arm angle, next to one of its branch; whether it is a solution."""
    P = row(family, LIMITED)
    goal = Goal(seeded, read7(row(seed, 0)), respect)
    return lead_row(P, target_of(P, row(T, 0)), (psi, branch), read7(row(before, 0)), goal, scratch(16, 9), row(out, 0))


@entry
def solve_range(family, poses, first, last, branch, seeds, respect, out, verdicts):
    """`solve` for the poses first to last - 1; seeds hold one for all, one a pose, or none."""
    J, A = scratch(6, 7), scratch(16, 9)
    for i in range(first, last):
        verdicts[i] = solve_row(family, row(poses, i), branch, own_goal(seeds, i, respect), J, A, row(out, i))


@entry
def solve_at_range(family, poses, first, last, psis, branch, seeds, respect, out, verdicts):
    """`solve_at` for the poses first to last - 1; psis hold one for all, or one a pose, and seeds may hold none."""
    J, A = scratch(6, 7), scratch(16, 9)
    for i in range(first, last):
        goal = own_goal(seeds, i, respect)
        verdicts[i] = solve_row_at(family, row(poses, i), own(psis, i), branch, goal, J, A, row(out, i))


@entry
def angles_towards(family, poses, points, out):
    """Write the arm angles of the elbows of all poses that are nearest to a point, one for all or one a pose."""
    P = row(family, LIMITED)
    for i in range(poses.shape[0]):
        place_ = target_of(P, row(poses, i)).place
        out[i] = angle_towards(P, place_, load3(row(points, i if points.shape[0] > 1 else 0), 0))


@entry
def solve_near(family, T, psi, branch, seed, seeded, respect, out):
    """`solve_row_near` of one pose; `seeded` tells whether the seed counts."""
    goal = Goal(seeded, read7(row(seed, 0)), respect)
    return solve_row_near(family, row(T, 0), psi, branch, goal, scratch(6, 7), scratch(16, 9), row(out, 0))


@entry
def solve_near_range(family, poses, first, last, psis, branch, seeds, respect, out, verdicts):
    """`solve_near` for the poses first to last - 1; psis hold one for all, or one a pose, and seeds may hold none."""
    J, A = scratch(6, 7), scratch(16, 9)
    for i in range(first, last):
        goal = own_goal(seeds, i, respect)
        verdicts[i] = solve_row_near(family, row(poses, i), own(psis, i), branch, goal, J, A, row(out, i))


@entry
def solve_all(family, T, psi, respect, out):
    """Branches of one pose that are solutions at an arm angle, in order: number of rows, or minus the verdict."""
    work = (scratch(6, 7), scratch(16, 9))
    verdict, _ = all_branches(family, row(T, 0), (psi, respect), work[0], work[1], out, 0, no_curves())
    if verdict != GOOD_POSE:
        return -verdict
    n = 0
    for i in range(8):
        if out[i, ROW_STATUS] == OK:
            if n < i:
                out[n] = out[i]
            n += 1
    return n


@entry
def solve_all_range(family, poses, first, last, psis, respect, out, verdicts):
    """All eight branches of the poses first to last - 1, in eight rows of `out` a pose.

    As long as a pose stays the same, its curves are followed once.
    """
    J, A = scratch(6, 7), scratch(16, 9)
    kept = no_curves()
    for i in range(first, last):
        if kept.runs.shape[0] > 0 and not is_same_pose(row(poses, i - 1), row(poses, i)):
            kept = no_curves()
        asked = (own(psis, i), respect)
        verdicts[i], kept = all_branches(family, row(poses, i), asked, J, A, out, 8 * i, kept)


@entry
def intervals(family, T, respect, out):
    """Feasible intervals of one pose: number of rows written to `out` (n, 3), or minus the verdict."""
    target, verdict = read_target(row(family, LIMITED), row(T, 0))
    if verdict != GOOD_POSE:
        return -verdict
    return all_intervals(family, target, respect, scratch(6, 7), scratch(16, 9), out)


@entry
def self_motion(family, T, found, respect, out):
    """Postures through intervals of a pose, rows of found, as many as `out` (n, ROW) has room for."""
    return self_motion_rows(family, row(T, 0), found, respect, scratch(6, 7), scratch(16, 9), out)


@entry
def intervals_range(family, poses, first, last, respect, rows, counts, verdicts):
    """Intervals of the poses from first to last - 1, as far as rows suffice; returns the next pose and the rows used.

    Rows, at least MOST_INTERVALS of them, take branch, lower and upper end of each interval, pose after pose; counts
    take how many each pose has, verdicts those on the poses.
    """
    J, A = scratch(6, 7), scratch(16, 9)
    used, i = 0, first
    while i < last and used + MOST_INTERVALS <= rows.shape[0]:
        target, verdicts[i] = read_target(row(family, LIMITED), row(poses, i))
        counts[i] = 0
        if verdicts[i] == GOOD_POSE:
            counts[i] = all_intervals(family, target, respect, J, A, rows[used : used + MOST_INTERVALS])
        used += counts[i]
        i += 1
    return i, used


@entry
def solve_intervals(family, T, respect, out):
    """The best posture of every feasible interval of one pose: number of rows of `out`, or minus the verdict."""
    P = row(family, LIMITED)
    target, verdict = read_target(P, row(T, 0))
    if verdict != GOOD_POSE:
        return -verdict
    found = np.empty((8 * MAX_PIECES, 3))
    if P[IS_NEAR] != 0.0:
        J, A = scratch(6, 7), scratch(16, 9)
        n = predicted_best_of_intervals(P, target, respect, out, J, A)
        if n < 0:
            n = all_intervals(family, target, respect, J, A, found)
            best_of_true_intervals(P, target, respect, found[:n], out, J, A)
        return n
    n, _ = exact_intervals(family, target, respect, found)
    for i in range(n):
        q, b, lowest = best_of(family, target, found[i : i + 1], -1, Goal(False, NO_SEED, respect))
        measure_row(P, target, q, b, lowest, respect, row(out, i))
    return n


@entry
def pack_limits(P, lower, upper):
    """Write the limits (7,) and (7,) into a limb that is being packed."""
    set_limits(row(P, 0), lower, upper)


@entry
def measure_shifts(P, configurations, shifts):
    """Write `band.put_shift` of configurations (N, 7) of a limb that is being packed into shifts (N, SHIFTS)."""
    for i in range(configurations.shape[0]):
        put_shift(row(P, 0), read7(row(configurations, i)), row(shifts, i))


@entry
def check_pose(T):
    """Verdict on a pose."""
    return read_pose(row(T, 0))[2]
