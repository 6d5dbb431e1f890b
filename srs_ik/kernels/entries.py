"""Entry points: thin array wrappers around the kernels, for one pose and for many.

A solving function writes rows laid out as `ROW_*` in `layout`; statuses are numbered as in `srs_ik.Status`.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.branches import NO_BRANCH, branch_of, elbow_branches
from srs_ik.kernels.chain import arm_frame_at, forward_kinematics, frame_error, hand_frame, pose_error
from srs_ik.kernels.closure import arm_angle, clipped
from srs_ik.kernels.elbow import elbow_side, place, shoulder_to_wrist, target_frame
from srs_ik.kernels.intervals import MAX_EVENTS, MAX_PIECES, feasible_intervals
from srs_ik.kernels.jit import entry, inline, kernel
from srs_ik.kernels.layout import (
    FREE,
    IS_CLOSED,
    LIMITED,
    LOOSE,
    ROW_ARM_ANGLE,
    ROW_BRANCH,
    ROW_JOINT,
    ROW_ORIENTATION_ERROR,
    ROW_POSITION_ERROR,
    ROW_Q,
    ROW_STATUS,
    SIZE,
)
from srs_ik.kernels.limits import set_limits
from srs_ik.kernels.nearest import first_guess, first_guess_near, slid, tighten
from srs_ik.kernels.scoring import OUTSIDE, tightest_joint
from srs_ik.kernels.search import MAX_SAMPLES, evaluate, evaluate_again, evaluate_branch, rescue, search_intervals
from srs_ik.kernels.vectors import add, apply, cross

OK = 0.0
UNREACHABLE = 1.0
OUT_OF_LIMITS = 2.0

SOLVED = 1e-9
"""A posture is a solution if position (m) and orientation (rad) errors on the true chain are below this."""

NOT_A_ROTATION = 1e-6
"""Largest deviation of R'R from the identity that is taken as rounding and removed."""

GOOD_POSE = 0
NOT_FINITE = 1
NOT_RIGID = 2
"""Verdicts on a pose."""

NEARLY_STRAIGHT = 3e-6
"""Bends of the elbow below this, rad, cannot be told apart within 1e-11 of reach."""

BETWEEN_LIMBS = 0.05
"""How far the joints of a near limb may be from those of its nearest exact limb, rad, away from singularities."""

ONE_VALLEY = 0.3
"""An interval shorter than this, rad, whose postures all lie in the box of a seeded search has one minimum."""

NO_SEED = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def read_pose(T):
    """Rotation, position and verdict of a 4 x 4 pose; rounding in the rotation is removed."""
    R = (T[0, 0], T[0, 1], T[0, 2], T[1, 0], T[1, 1], T[1, 2], T[2, 0], T[2, 1], T[2, 2])
    p = (T[0, 3], T[1, 3], T[2, 3])
    total = p[0] + p[1] + p[2]
    for i in range(9):
        total += R[i]
    total += T[3, 0] + T[3, 1] + T[3, 2] + T[3, 3]
    if not math.isfinite(total):
        return R, p, NOT_FINITE
    if max(abs(T[3, 0]), abs(T[3, 1]), abs(T[3, 2]), abs(T[3, 3] - 1.0)) > NOT_A_ROTATION:
        return R, p, NOT_RIGID
    for _ in range(2):
        xx = R[0] * R[0] + R[3] * R[3] + R[6] * R[6] - 1.0
        yy = R[1] * R[1] + R[4] * R[4] + R[7] * R[7] - 1.0
        zz = R[2] * R[2] + R[5] * R[5] + R[8] * R[8] - 1.0
        xy = R[0] * R[1] + R[3] * R[4] + R[6] * R[7]
        yz = R[1] * R[2] + R[4] * R[5] + R[7] * R[8]
        zx = R[2] * R[0] + R[5] * R[3] + R[8] * R[6]
        off = max(abs(xx), abs(yy), abs(zz), abs(xy), abs(yz), abs(zx))
        if off > NOT_A_ROTATION:
            return R, p, NOT_RIGID
        if off < 1e-15:
            break
        # R (3 I - R'R) / 2: the nearest rotation, to second order.
        R = (
            R[0] - 0.5 * (R[0] * xx + R[1] * xy + R[2] * zx),
            R[1] - 0.5 * (R[0] * xy + R[1] * yy + R[2] * yz),
            R[2] - 0.5 * (R[0] * zx + R[1] * yz + R[2] * zz),
            R[3] - 0.5 * (R[3] * xx + R[4] * xy + R[5] * zx),
            R[4] - 0.5 * (R[3] * xy + R[4] * yy + R[5] * yz),
            R[5] - 0.5 * (R[3] * zx + R[4] * yz + R[5] * zz),
            R[6] - 0.5 * (R[6] * xx + R[7] * xy + R[8] * zx),
            R[7] - 0.5 * (R[6] * xy + R[7] * yy + R[8] * yz),
            R[8] - 0.5 * (R[6] * zx + R[7] * yz + R[8] * zz),
        )
    determinant = (
        R[0] * (R[4] * R[8] - R[5] * R[7]) - R[1] * (R[3] * R[8] - R[5] * R[6]) + R[2] * (R[3] * R[7] - R[4] * R[6])
    )
    return R, p, (GOOD_POSE if determinant > 0.0 else NOT_RIGID)


@kernel
def read7(q):
    """Seven figures of an array as a tuple."""
    return (q[0], q[1], q[2], q[3], q[4], q[5], q[6])


@kernel
def write_row(place_, q, branch, psi, outside, exists, position, orientation, joint, out):
    """Write a posture with its measured errors, and the status that follows from them."""
    for i in range(7):
        out[ROW_Q + i] = q[i]
    out[ROW_POSITION_ERROR] = position
    out[ROW_ORIENTATION_ERROR] = orientation
    out[ROW_ARM_ANGLE] = psi - 2.0 * math.pi * math.floor((psi + math.pi) / (2.0 * math.pi))
    out[ROW_BRANCH] = branch
    out[ROW_JOINT] = joint
    if max(position, orientation) < SOLVED:
        out[ROW_STATUS] = OK
    elif outside and exists and place_[5] == 0.0:
        out[ROW_STATUS] = OUT_OF_LIMITS
    else:
        out[ROW_STATUS] = UNREACHABLE


@kernel
def measure_row(P, place_, R, p, q, branch, lowest, respect, out):
    """Measure a posture on the true chain and write its row; outside its limits, it is put on them first."""
    outside = respect and lowest >= OUTSIDE
    joint = 0
    if outside:
        joint = tightest_joint(P, q)
        q = clipped(P, q)
    position, orientation = pose_error(P, q, R, p)
    if P[IS_CLOSED] != 1.0:
        branch = branch_of(P, q)
    psi = arm_angle(P, q, place_[0], place_[1])
    write_row(place_, q, branch, psi, outside, lowest < NO_BRANCH, position, orientation, joint, out)


@kernel
def find_intervals(P, place_, out):
    """Feasible intervals of one pose, with work space of their own."""
    return feasible_intervals(
        P,
        place_,
        np.empty(MAX_EVENTS),
        np.empty(MAX_EVENTS, np.int64),
        np.empty((2, MAX_PIECES, 2)),
        np.empty((2, MAX_PIECES, 2)),
        out,
    )


@kernel
def search_branches(P, F, place_, R, p, branch, seeded, seed, respect, J, A):
    """Best posture over the feasible intervals of F: q, branch, cost (more than any posture's if there is none)."""
    found = np.empty((8 * MAX_PIECES, 3))
    n = find_intervals(F, place_, found)
    work = np.empty((3, MAX_SAMPLES))
    return search_intervals(P, place_, R, p, found, 0, n, branch, seeded, seed, respect, work, J, A)


@kernel
def without(found, n, branch, psi):
    """Drop the short interval around a known minimum; return the number of intervals that are left."""
    left = 0
    for i in range(n):
        ahead = (psi - found[i, 1]) - 2.0 * math.pi * math.floor((psi - found[i, 1]) / (2.0 * math.pi))
        width = found[i, 2] - found[i, 1]
        if int(found[i, 0]) == branch and width < ONE_VALLEY and ahead <= width:
            continue
        found[left, 0] = found[i, 0]
        found[left, 1] = found[i, 1]
        found[left, 2] = found[i, 2]
        left += 1
    return left


@inline
def search(family, place_, R, p, branch, seeded, seed, respect, J, A):
    """Best posture over all arm angles: q, branch, cost."""
    strictness = LIMITED if respect else FREE
    P = family[LIMITED]
    if seeded and branch < 0:
        slack = 1e-12
        if P[IS_CLOSED] == 1.0:
            psi, q, best, lowest, minimum = first_guess(P, place_, seed, respect)
        else:
            psi, q, best, lowest, minimum = first_guess_near(P, place_, R, p, seed, respect, J, A)
            slack = BETWEEN_LIMBS
        if lowest < OUTSIDE:
            box = np.empty(SIZE)
            tighten(family[strictness], seed, math.sqrt(lowest) * (1.0 + 1e-9) + slack, box)
            found = np.empty((8 * MAX_PIECES, 3))
            n = find_intervals(box, place_, found)
            if minimum:
                n = without(found, n, best, psi)
            if n == 0:
                return q, best, lowest
            work = np.empty((3, MAX_SAMPLES))
            nearer_q, nearer, value = search_intervals(
                P, place_, R, p, found, 0, n, branch, seeded, seed, respect, work, J, A
            )
            if value < OUTSIDE and P[IS_CLOSED] != 1.0:
                nearer_q, value, _ = slid(P, nearer_q, R, p, seed, respect, J, A)
            if value < lowest:
                return nearer_q, nearer, value
            return q, best, lowest
    best_q, best, lowest = search_branches(P, family[strictness], place_, R, p, branch, seeded, seed, respect, J, A)
    if lowest < OUTSIDE:
        return best_q, best, lowest
    t, h0, bend_c, bend_s, hand, miss = place_
    if P[IS_CLOSED] == 1.0:
        # Postures that rounding hides: looser tolerances, and, with the elbow almost straight, all the bends that a
        # pose cannot tell from each other (a bend x shortens the arm by x^2 / 8 of its length).
        bend = bend_s
        x = 1e-9
        while True:
            near = (t, h0, math.sqrt(1.0 - bend * bend) if bend_c > 0.0 else bend_c, bend, hand, miss)
            q, b, value = search_branches(
                family[LOOSE], family[LOOSE + strictness], near, R, p, branch, seeded, seed, respect, J, A
            )
            if value < OUTSIDE:
                return q, b, value
            if bend_c < 0.0 or bend_s > NEARLY_STRAIGHT or x > NEARLY_STRAIGHT:
                break
            bend = 0.0 if x == 1e-9 else x
            x *= 2.0
    else:
        q, b, value = rescue(P, place_, R, p, branch, seeded, seed, respect, J, A)
        if value < lowest:
            best_q = q
            best = b
            lowest = value
        if lowest < OUTSIDE:
            return best_q, best, lowest
    # No posture inside the limits: the least violating one.
    circles = np.empty((8, 3))
    for b in range(8):
        circles[b, 0] = b
        circles[b, 1] = -math.pi
        circles[b, 2] = math.pi
    work = np.empty((3, MAX_SAMPLES))
    q, b, value = search_intervals(P, place_, R, p, circles, 0, 8, branch, seeded, seed, respect, work, J, A)
    if value < lowest:
        return q, b, value
    return best_q, best, lowest


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
            again, other, value = evaluate_again(P, place_, R, p, psi, branch, seeded, seed, respect, J, A)
            if value < lowest:
                q, best, lowest = again, other, value
    else:
        q, best, lowest = search(family, place_, R, p, branch, seeded, seed, respect, J, A)
    measure_row(P, place_, R, p, q, best, lowest, respect, out)
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


@entry
def intervals(family, T, respect, out):
    """Feasible intervals of one pose on the exact limb: number of rows of `out` (n, 3), or minus the verdict."""
    R, p, verdict = read_pose(T)
    if verdict != GOOD_POSE:
        return -verdict
    P = family[LIMITED if respect else FREE]
    return find_intervals(P, place(P, R, p), out)


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
    n = find_intervals(family[LIMITED if respect else FREE], place_, found)
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
