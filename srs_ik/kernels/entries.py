"""Entry points: thin array wrappers around the kernels, for one pose and for many.

A solving function writes rows laid out as `ROW_*` in `layout`; statuses are numbered as in `srs_ik.Status`.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.branches import NO_BRANCH, branch_of, elbow_branches
from srs_ik.kernels.chain import arm_frame_at, forward_kinematics, frame_error, hand_frame
from srs_ik.kernels.closure import arm_angle
from srs_ik.kernels.elbow import elbow_side, place, shoulder_to_wrist, target_frame
from srs_ik.kernels.intervals import MAX_PIECES
from srs_ik.kernels.jit import entry, inline, kernel
from srs_ik.kernels.layout import (
    FREE,
    IS_CLOSED,
    LIMITED,
    ROW_ARM_ANGLE,
    ROW_JOINT,
    ROW_STATUS,
)
from srs_ik.kernels.limits import set_limits
from srs_ik.kernels.near_intervals import LOOKS, true_intervals
from srs_ik.kernels.poses import GOOD_POSE, read7, read_pose
from srs_ik.kernels.redundancy import find_intervals, search
from srs_ik.kernels.rows import OK, OUT_OF_LIMITS, SOLVED, UNREACHABLE, measure_row, write_row
from srs_ik.kernels.scoring import OUTSIDE, tightest_joint
from srs_ik.kernels.search import (
    ATTEMPTS,
    MAX_SAMPLES,
    evaluate,
    evaluate_again,
    evaluate_branch,
    rescue,
    search_intervals,
)
from srs_ik.kernels.vectors import add, apply, cross

NO_SEED = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@inline
def solve_one(family, T, at_angle, psi, branch, seeded, seed, respect, J, A, out):
    """Solve one pose into a row; returns the verdict on the pose."""
    R, p, verdict = read_pose(T)
    if verdict != GOOD_POSE:
        return verdict
    P = family[LIMITED]
    place_ = place(P, R, p)
    if at_angle:
        q, best, lowest = evaluate(P, place_, R, p, psi, branch, seeded, seed, respect, J, A)
        if lowest >= OUTSIDE and P[IS_CLOSED] != 1.0:
            again, other, value = evaluate_again(P, place_, R, p, psi, branch, seeded, seed, respect, ATTEMPTS, J, A)
            if value < lowest:
                q, best, lowest = again, other, value
    else:
        q, best, lowest = search(family, place_, R, p, branch, seeded, seed, respect, J, A)
    measure_row(P, place_, R, p, q, best, lowest, respect, out)
    if respect and out[ROW_STATUS] == UNREACHABLE and P[IS_CLOSED] != 1.0:
        # Only an attempt without limits can tell what a near limb does not reach from what its limits forbid.
        q, best, lowest = rescue(P, place_, R, p, branch, seeded, seed, False, J, A)
        if lowest < OUTSIDE:
            out[ROW_STATUS] = OUT_OF_LIMITS
            out[ROW_JOINT] = tightest_joint(P, q)
    if at_angle and out[ROW_STATUS] == OK:
        out[ROW_ARM_ANGLE] = psi - 2.0 * math.pi * math.floor((psi + math.pi) / (2.0 * math.pi))
    return GOOD_POSE


@entry
def solve(family, T, at_angle, psi, branch, seeded, seed, respect, out):
    """Solve one pose into a row of `out`; returns the verdict on the pose."""
    J = np.empty((6, 7))
    A = np.empty((7, 9))
    return solve_one(family, T, at_angle, psi, branch, seeded, read7(seed), respect, J, A, out)


@entry
def solve_range(family, poses, first, last, at_angle, psis, branch, seeded, seeds, respect, out, verdicts):
    """Solve the poses first to last - 1; psis and seeds hold one value for all, or one a pose."""
    J = np.empty((6, 7))
    A = np.empty((7, 9))
    for i in range(first, last):
        psi = psis[i if psis.shape[0] > 1 else 0]
        seed = read7(seeds[i if seeds.shape[0] > 1 else 0])
        verdicts[i] = solve_one(family, poses[i], at_angle, psi, branch, seeded, seed, respect, J, A, out[i])


@inline
def all_branches(P, T, psi, respect, J, A, out):
    """One row a branch at an arm angle, in the order of branches."""
    R, p, verdict = read_pose(T)
    if verdict != GOOD_POSE:
        return verdict
    place_ = place(P, R, p)
    if P[IS_CLOSED] == 1.0:
        for elbow in range(2):
            elbow_branches(P, place_, psi, elbow, respect, A)
            hands = (hand_frame(P, read7(A[0])), hand_frame(P, read7(A[1])))
            arms = (arm_frame_at(P, read7(A[0])), arm_frame_at(P, read7(A[2])))
            for i in range(4):
                branch = 4 * elbow + i
                q = read7(A[i])
                if A[i, 7] >= OUTSIDE:
                    measure_row(P, place_, R, p, q, branch, A[i, 7], respect, out[branch])
                    continue
                M, shift = arms[i >> 1]
                x, y, origin = hands[i & 1]
                x = apply(M, x)
                y = apply(M, y)
                position, orientation = frame_error(x, y, cross(x, y), add(apply(M, origin), shift), R, p)
                write_row(place_, q, branch, psi, False, True, position, orientation, 0, out[branch])
        return GOOD_POSE
    for branch in range(8):
        side = elbow_side(P, place_, branch >> 2)
        q, lowest = evaluate_branch(P, place_, side, R, p, psi, branch, False, NO_SEED, respect, J, A)
        if lowest >= NO_BRANCH:
            again, _, value = evaluate_again(P, place_, R, p, psi, branch, False, NO_SEED, respect, 1, J, A)
            if value < lowest:
                q, lowest = again, value
        measure_row(P, place_, R, p, q, branch, lowest, respect, out[branch])
    return GOOD_POSE


@entry
def solve_all(family, T, psi, respect, out):
    """Branches of one pose that are solutions at an arm angle, in order: number of rows, or minus the verdict."""
    verdict = all_branches(family[LIMITED], T, psi, respect, np.empty((6, 7)), np.empty((7, 9)), out)
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
    """All eight branches of the poses first to last - 1."""
    J = np.empty((6, 7))
    A = np.empty((7, 9))
    for i in range(first, last):
        psi = psis[i if psis.shape[0] > 1 else 0]
        verdicts[i] = all_branches(family[LIMITED], poses[i], psi, respect, J, A, out[i])


@kernel
def all_intervals(P, place_, R, p, out):
    """Feasible intervals of one pose on the true chain; none where the pose is out of reach."""
    if P[IS_CLOSED] == 1.0:
        return find_intervals(P, place_, out) if abs(place_[5]) < SOLVED else 0
    found = np.empty((8 * MAX_PIECES, 3))
    n = find_intervals(P, place_, found)
    J = np.empty((6, 7))
    A = np.empty((7, 9))
    return true_intervals(P, place_, R, p, found, n, np.empty(2 * LOOKS), np.empty(2 * LOOKS), out, J, A)


@entry
def intervals(family, T, respect, out):
    """Feasible intervals of one pose: number of rows written to `out` (n, 3), or minus the verdict."""
    R, p, verdict = read_pose(T)
    if verdict != GOOD_POSE:
        return -verdict
    P = family[LIMITED if respect else FREE]
    return all_intervals(P, place(P, R, p), R, p, out)


@entry
def solve_intervals(family, T, respect, out):
    """The best posture of every feasible interval of one pose: number of rows of `out`, or minus the verdict."""
    R, p, verdict = read_pose(T)
    if verdict != GOOD_POSE:
        return -verdict
    J = np.empty((6, 7))
    A = np.empty((7, 9))
    P = family[LIMITED]
    place_ = place(P, R, p)
    found = np.empty((8 * MAX_PIECES, 3))
    n = all_intervals(family[LIMITED if respect else FREE], place_, R, p, found)
    work = np.empty((3, MAX_SAMPLES))
    for i in range(n):
        q, b, lowest = search_intervals(P, place_, R, p, found, i, i + 1, -1, False, NO_SEED, respect, work, J, A)
        measure_row(P, place_, R, p, q, b, lowest, respect, out[i])
    return n


@entry
def configuration_arm_angle(family, q):
    """Arm angle and branch of a configuration."""
    P = family[LIMITED]
    q = read7(q)
    x, y, z, p = forward_kinematics(P, q)
    R = (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])
    _, t, h0 = target_frame(P, shoulder_to_wrist(P, R, p))
    return arm_angle(P, q, t, h0), branch_of(P, q)


@entry
def pack_limits(P, lower, upper):
    """Write the limits (7,) and (7,) into a limb that is being packed."""
    set_limits(P, lower, upper)


@entry
def check_pose(T):
    """Verdict on a pose."""
    return read_pose(T)[2]
