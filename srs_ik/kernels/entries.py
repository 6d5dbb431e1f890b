"""Entry points: thin array wrappers around the kernels, for one pose and for many.

An argument that is not given is None, and Numba compiles no more than the arguments at hand need. On a limb that the
closed form answers, J and A are None; else they are work space, (6, 7) and (16, 9) (see `near_branches`).

A solving function writes rows laid out as `ROW_*` in `layout`; statuses are numbered as in `srs_ik.Status`.
"""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.branches import NO_BRANCH, branch_of, elbow_branches
from srs_ik.kernels.chain import forward_kinematics
from srs_ik.kernels.closure import arm_angle
from srs_ik.kernels.eight import put_some, take_eight, tip_errors
from srs_ik.kernels.elbow import place, shoulder_to_wrist, target_frame
from srs_ik.kernels.followed_angle import solve_all_at_angle, solve_at_angle
from srs_ik.kernels.intervals import MAX_PIECES, find_intervals
from srs_ik.kernels.jit import entry, kernel
from srs_ik.kernels.lanes import as_bits, gather
from srs_ik.kernels.layout import (
    FREE,
    LIMITED,
    LOOSE,
    ROW,
    ROW_BRANCH,
    ROW_COST,
    ROW_JOINT,
    ROW_ORIENTATION_ERROR,
    ROW_POSITION_ERROR,
    ROW_STATUS,
)
from srs_ik.kernels.limits import set_limits
from srs_ik.kernels.margin import farthest
from srs_ik.kernels.memory import row
from srs_ik.kernels.near_intervals import best_of_true_intervals, true_intervals
from srs_ik.kernels.poses import GOOD_POSE, read7, read_pose
from srs_ik.kernels.predicted import predicted_intervals, shift
from srs_ik.kernels.redundancy import search_exact, search_near_seed, search_true
from srs_ik.kernels.rows import OK, OUT_OF_LIMITS, SOLVED, UNREACHABLE, measure_row, measure_row_at, write_row
from srs_ik.kernels.scoring import NO_SEED, OUTSIDE, UNMET, tightest_joint
from srs_ik.kernels.second_attempts import rescue


@kernel
def seed_or_zero(seed):
    """Seven angles of a seed, or zeros if there is none."""
    if seed is None:
        return NO_SEED
    return read7(seed)


@kernel
def own(values, i):
    """The value of pose i, from one for all, or one a pose."""
    return values[i if values.shape[0] > 1 else 0]


@kernel
def own_seed(seeds, i):
    """The seed of pose i, from one for all, or one a pose, or None."""
    if seeds is None:
        return None
    return row(seeds, i if seeds.shape[0] > 1 else 0)


def _solve(family, T, branch, seed, respect, J, A, out):
    """Solve one pose into a row of `out`, the best posture of all arm angles; returns the verdict on the pose."""
    R, p, verdict = read_pose(row(T, 0))
    if verdict != GOOD_POSE:
        return verdict
    P = row(family, LIMITED)
    place_ = place(P, R, p)
    near = seed_or_zero(seed)
    seeded = seed is not None
    q = near
    best = 0
    lowest = 4.0 * NO_BRANCH
    if seed is not None:
        if branch < 0:
            F = row(family, LIMITED if respect else FREE)
            q, best, lowest = search_near_seed(P, F, place_, R, p, near, respect, J, A)
    if lowest >= OUTSIDE:
        if J is not None:
            q, best, lowest = search_true(P, place_, R, p, branch, seeded, near, respect, J, A)
        elif seed is not None:
            q, best, lowest = search_exact(family, place_, branch, near, respect)
        else:
            q, best, lowest = search_exact(family, place_, branch, None, respect)
    measure_row(P, place_, R, p, q, best, lowest, respect, row(out, 0))
    if J is not None:
        if respect and out[ROW_STATUS] == UNREACHABLE:
            # Only a posture without limits can tell what a near limb does not reach from what its limits forbid.
            if lowest >= UNMET:
                q, _, lowest = rescue(P, place_, R, p, branch, seeded, near, False, J, A)
            if lowest < UNMET:
                out[ROW_STATUS] = OUT_OF_LIMITS
                out[ROW_JOINT] = tightest_joint(P, q)
    return GOOD_POSE


def _solve_at(family, T, psi, branch, seed, respect, J, A, out):
    """Solve one pose at an arm angle into a row of `out`; returns the verdict on the pose."""
    R, p, verdict = read_pose(row(T, 0))
    if verdict != GOOD_POSE:
        return verdict
    P = row(family, LIMITED)
    place_ = place(P, R, p)
    near = seed_or_zero(seed)
    q, best, lowest = solve_at_angle(P, place_, R, p, psi, branch, seed is not None, near, respect, J, A)
    measure_row_at(P, place_, R, p, psi, q, best, lowest, respect, row(out, 0))
    return GOOD_POSE


solve = entry(_solve)
solve_row = kernel(_solve)
solve_at = entry(_solve_at)
solve_row_at = kernel(_solve_at)


@entry
def solve_range(family, poses, first, last, branch, seeds, respect, J, A, out, verdicts):
    """`solve` for the poses first to last - 1; seeds hold one for all, or one a pose, or are None."""
    for i in range(first, last):
        verdicts[i] = solve_row(family, row(poses, i), branch, own_seed(seeds, i), respect, J, A, row(out, i))


@entry
def solve_at_range(family, poses, first, last, psis, branch, seeds, respect, J, A, out, verdicts):
    """`solve_at` for the poses first to last - 1; psis and seeds hold one for all, or one a pose."""
    for i in range(first, last):
        verdicts[i] = solve_row_at(
            family, row(poses, i), own(psis, i), branch, own_seed(seeds, i), respect, J, A, row(out, i)
        )


@kernel
def all_branches(P, T, psi, respect, J, A, out, first):
    """One row a branch at an arm angle, in the order of branches: rows `first` to `first + 7` of out."""
    R, p, verdict = read_pose(T)
    if verdict != GOOD_POSE:
        return verdict
    place_ = place(P, R, p)
    if J is None:
        for elbow in range(2):
            elbow_branches(P, place_, psi, elbow, respect, out, first + 4 * elbow)
        rows = row(out, first)
        position, orientation, measured = tip_errors(P, take_eight(rows, ROW), R, p)
        measured = measured & (gather(rows, ROW_COST, ROW) < OUTSIDE)
        put_some(rows, ROW_POSITION_ERROR, ROW, measured, position)
        put_some(rows, ROW_ORIENTATION_ERROR, ROW, measured, orientation)
        right = as_bits(measured)
        for branch in range(8):
            answer = row(out, first + branch)
            q = read7(answer)
            if (right >> branch) & 1 == 1:
                off, turned = answer[ROW_POSITION_ERROR], answer[ROW_ORIENTATION_ERROR]
                write_row(place_, q, branch, psi, False, True, off, turned, 0, answer)
            else:
                measure_row(P, place_, R, p, q, branch, answer[ROW_COST], respect, answer)
        return GOOD_POSE
    found = np.empty((8, 8))
    solve_all_at_angle(P, place_, R, p, psi, respect, J, A, found)
    for branch in range(8):
        q, lowest = read7(found[branch]), found[branch, ROW_COST]
        measure_row(P, place_, R, p, q, branch, lowest, respect, row(out, first + branch))
        out[first + branch, ROW_BRANCH] = branch
    return GOOD_POSE


@entry
def solve_all(family, T, psi, respect, J, A, out):
    """Branches of one pose that are solutions at an arm angle, in order: number of rows, or minus the verdict."""
    verdict = all_branches(row(family, LIMITED), row(T, 0), psi, respect, J, A, out, 0)
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
def solve_all_range(family, poses, first, last, psis, respect, J, A, out, verdicts):
    """All eight branches of the poses first to last - 1, in eight rows of `out` a pose."""
    for i in range(first, last):
        verdicts[i] = all_branches(row(family, LIMITED), row(poses, i), own(psis, i), respect, J, A, out, 8 * i)


@kernel
def all_intervals(family, place_, R, p, respect, J, A, out):
    """Feasible intervals of one pose on the true chain; none where the pose is out of reach."""
    if J is not None:
        n = predicted_intervals(row(family, LIMITED if respect else FREE), place_, R, p, out)
        return n if n >= 0 else true_intervals(row(family, LIMITED), place_, R, p, respect, out, J, A)
    if abs(place_[5]) >= SOLVED:
        return 0
    n = find_intervals(row(family, LIMITED if respect else FREE), place_, -1, out)
    if n == 0 and respect:
        # A pose whose postures all lie on limits leaves room by rounding alone.
        n = find_intervals(row(family, LOOSE), place_, -1, out)
    return n


@entry
def intervals(family, T, respect, J, A, out):
    """Feasible intervals of one pose: number of rows written to `out` (n, 3), or minus the verdict."""
    R, p, verdict = read_pose(row(T, 0))
    if verdict != GOOD_POSE:
        return -verdict
    return all_intervals(family, place(row(family, LIMITED), R, p), R, p, respect, J, A, out)


@entry
def solve_intervals(family, T, respect, J, A, out):
    """The best posture of every feasible interval of one pose: number of rows of `out`, or minus the verdict."""
    R, p, verdict = read_pose(row(T, 0))
    if verdict != GOOD_POSE:
        return -verdict
    P = row(family, LIMITED)
    place_ = place(P, R, p)
    if J is not None:
        return best_of_true_intervals(P, place_, R, p, respect, out, J, A)
    found = np.empty((8 * MAX_PIECES, 3))
    n = all_intervals(family, place_, R, p, respect, J, A, found)
    for i in range(n):
        q, b, lowest = farthest(P, place_, found, i, i + 1, -1, respect)
        measure_row(P, place_, R, p, q, b, lowest, respect, row(out, i))
    return n


@entry
def configuration_arm_angle(family, q):
    """Arm angle and branch of a configuration."""
    P = row(family, LIMITED)
    q = read7(q)
    x, y, z, p = forward_kinematics(P, q)
    R = (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])
    _, t, h0 = target_frame(P, shoulder_to_wrist(P, R, p))
    return arm_angle(P, q, t, h0), branch_of(P, q)


@entry
def pack_limits(P, lower, upper):
    """Write the limits (7,) and (7,) into a limb that is being packed."""
    set_limits(row(P, 0), lower, upper)


@entry
def measure_shifts(P, configurations, shifts):
    """Write `predicted.shift` of configurations (N, 7) of a limb that is being packed into shifts (N,)."""
    for i in range(configurations.shape[0]):
        shifts[i] = shift(row(P, 0), read7(row(configurations, i)))


@entry
def check_pose(T):
    """Verdict on a pose."""
    return read_pose(row(T, 0))[2]
