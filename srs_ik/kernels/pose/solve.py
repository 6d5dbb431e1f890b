"""One pose, either kind of limb: the best posture of all arm angles, or at one; and all eight branches at one.

A solving function writes rows laid out as `ROW_*` in `layout`; statuses are numbered as in `srs_ik.Status`. J and
A are work space of near limbs, (6, 7) and (16, 9) (see `chain.starts`).
"""

import math

import numpy as np

from srs_ik.kernels.algebra.lanes import ALL, as_bits, gather, one_of, scatter
from srs_ik.kernels.algebra.pointers import keep, read7, row
from srs_ik.kernels.chain.answer import measure_row, measure_row_at, write_row
from srs_ik.kernels.chain.closest import UPRIGHT, closer_upright, closest, is_alike, is_closer, is_too_far, put_upright
from srs_ik.kernels.chain.eight import put_eight, take_eight, tip_errors
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.chain.newton import CLOSED, clipped
from srs_ik.kernels.exact.farthest import GAIN_OUTSIDE
from srs_ik.kernels.exact.free_splits import worse_by
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import answer as at
from srs_ik.kernels.layout.asked import Goal, Target
from srs_ik.kernels.layout.limb import FAMILY, FREE, IS_NEAR, LIMITED, SHOULDER, SIZE, WRIST
from srs_ik.kernels.limb.branches import NO_BRANCH, best_branch, branch_of, elbow_branches, is_on_border, singular_sines
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, UNMET, tightest_joint, turned
from srs_ik.kernels.limb.in_line import NEARLY_IN_LINE, is_in_line
from srs_ik.kernels.limb.limits import tighten
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.postures_eight import farthest_branches, join_parts
from srs_ik.kernels.limb.triangle import place, read_target
from srs_ik.kernels.near.at_angle import may_reach, solve_all_at_angle, solve_at_angle
from srs_ik.kernels.near.predicted_best import search_true
from srs_ik.kernels.pose.any_bend import at_any_bend, best_at_any_bend, hides_some
from srs_ik.kernels.pose.equals import closest_of_equals, may_have_equals
from srs_ik.kernels.pose.intervals import is_feasible
from srs_ik.kernels.pose.on_limits import BARELY, is_at_angle, put_on_limits
from srs_ik.kernels.pose.search import going_on, going_on_in_branch, search_exact, search_near_seed

WORTH = 1e-4
"""A posture that rounding hides next to a singularity has to be nearer to a seed by this, rad, and as good as exact."""

LOOKS = 16
"""Arm angles from which a near limb is bent towards a pose out of reach, each in another branch than the one before."""


@kernel
def own(values, i):
    """The value of pose i, from one for all, or one a pose."""
    return values[i if values.shape[0] > 1 else 0]


@kernel
def own_goal(seeds, i, respect):
    """What is wanted of pose i: nearness to a seed, one for all or one a pose, or without any to be far from limits."""
    if seeds.shape[0] == 0:
        return Goal(False, NO_SEED, respect)
    return Goal(True, read7(row(seeds, i if seeds.shape[0] > 1 else 0)), respect)


@kernel
def write_closest(P, target, goal, out):
    """Put the closest configuration in the place of one out of reach whose stretched arm breaks the limits."""
    q = closest(P, read7(out), target, goal, np.empty((6, 7)), np.empty((16, 9)))
    q = clipped(P, turned(P, q, goal.seeded, goal.seed, True))
    measure_row(P, target, q, branch_of(P, q), UNMET, True, out)
    out[at.ROW_STATUS] = at.UNREACHABLE


@kernel
def stretch_true(family, target, goal, J, A, out):
    """Bend a near limb, stretched towards a pose out of reach by the closed form, to where it comes closest.

    With a seed, first of all from there: it does not turn its elbow around for what is hardly closer.
    """
    P, F = row(family, LIMITED), row(family, LIMITED if goal.respect else FREE)
    q = read7(out)
    if is_too_far(P, q, target, J):
        return
    best = closer_upright(F, q, (q, math.inf), target, J, A)
    for i in range(LOOKS):
        psi = 2.0 * math.pi * i / LOOKS
        q, _, _ = best_branch(P, target.place, psi, 5 * i % 8, False, NO_SEED, goal.respect)
        best = closer_upright(F, clipped(F, q), best, target, J, A)
    if goal.seeded:
        near = closer_upright(F, clipped(F, goal.seed), (goal.seed, math.inf), target, J, A)
        best = near if is_alike(near[1], best[1], UPRIGHT) else best
    q = put_upright(F, best[0], target, J, A)
    q = clipped(F, turned(F, q, goal.seeded, goal.seed, True))
    measure_row(P, target, q, branch_of(P, q), UNMET, False, out)


@kernel
def nearest_of_exact(family, target, goal, J, A):
    """The posture of a closed limb nearest to a seed, over all branches and arm angles: q, branch, cost."""
    P = row(family, LIMITED)
    found, _ = search_near_seed(family, target, -1, goal, J, A)
    hidden = hides_some(P, target.place)
    if found[2] >= OUTSIDE:
        found = search_exact(family, target, -1, goal)
    elif hidden:
        found = best_at_any_bend(family, target, -1, goal, found)
    s2, _, s6 = singular_sines(P, found[0])
    # There rounding leaves more than arm angles and bends tell apart.
    if (hidden or min(s2, s6) < NEARLY_IN_LINE) and may_reach(P, target.place):
        return going_on(P, target, goal, found, J, A)
    return found


@kernel
def best_posture(family, target, branch, goal, J, A):
    """The best posture of all arm angles: q, branch, cost."""
    P = row(family, LIMITED)
    if P[IS_NEAR] == 0.0 and goal.seeded and branch < 0:
        return nearest_of_exact(family, target, goal, J, A)
    found, told = (goal.seed, 0, 4.0 * NO_BRANCH), False
    if P[IS_NEAR] != 0.0 and goal.seeded:
        found, told = search_near_seed(family, target, branch, goal, J, A)
    in_branch = found[2] < OUTSIDE and (branch < 0 or is_on_border(P, found[0], branch))
    if told and in_branch:
        return found[0], found[1] if branch < 0 else branch, found[2]
    if P[IS_NEAR] != 0.0 and may_reach(P, target.place):
        other = search_true(P, target, branch, goal, J, A)
        if goal.seeded and branch >= 0:
            nearer = found if in_branch and found[2] < other[2] else other
            return going_on_in_branch(family, target, branch, goal, nearer, J, A)
        return going_on(P, target, goal, other, J, A)
    found = search_exact(family, target, branch, goal)
    if goal.seeded and branch >= 0 and found[2] >= OUTSIDE:
        # What locked joints leave next to a singularity is no interval, and met from the seed alone.
        other, _ = search_near_seed(family, target, -1, goal, J, A)
        if other[2] < OUTSIDE and is_on_border(P, other[0], branch):
            return other[0], branch, other[2]
    return found


@kernel
def nearest_of_equals(family, target, branch, goal, found, J, A):
    """The least violating posture of a pose, or of those as good the nearest to a seed: q, branch, cost."""
    wide = np.empty((FAMILY, SIZE))
    for k in range(FAMILY):
        tighten(row(family, k), goal.seed, math.inf, found[2] - OUTSIDE + GAIN_OUTSIDE, row(wide, k))
    q, own, value = best_posture(wide, target, branch, goal, J, A)
    keep(wide)
    return (q, own, found[2]) if value < OUTSIDE else found


@kernel
def solve_row(family, T, branch, goal, J, A, out):
    """Solve one pose into a row of `out`, the best posture of all arm angles; returns the verdict on the pose."""
    P = row(family, LIMITED)
    target, verdict = read_target(P, row(T, 0))
    if verdict != at.GOOD_POSE:
        return verdict
    q, best, lowest = best_posture(family, target, branch, goal, J, A)
    measure_row(P, target, q, best, lowest, goal.respect, row(out, 0))
    if lowest < UNMET and out[at.ROW_STATUS] == at.OUT_OF_LIMITS:
        if goal.seeded:
            q, best, lowest = nearest_of_equals(family, target, branch, goal, (q, best, lowest), J, A)
        elif may_have_equals(P, target, branch, lowest, goal):
            q, best, lowest = closest_of_equals(P, target, (q, best, lowest), goal, True, J)
        measure_row(P, target, q, best, lowest, goal.respect, row(out, 0))
    if P[IS_NEAR] != 0.0 and branch < 0 and lowest >= UNMET and out[at.ROW_STATUS] == at.OUT_OF_LIMITS:
        # Its nearest exact limb reaches the pose; it does not, limits or not.
        out[at.ROW_STATUS] = at.UNREACHABLE
    if P[IS_NEAR] != 0.0 and goal.respect and out[at.ROW_STATUS] == at.UNREACHABLE and may_reach(P, target.place):
        # What a near limb reaches, its limits forbid.
        if lowest < UNMET:
            out[at.ROW_STATUS] = at.OUT_OF_LIMITS
            out[at.ROW_JOINT] = tightest_joint(P, q)
    if goal.respect and branch < 0 and lowest >= OUTSIDE and out[at.ROW_STATUS] == at.UNREACHABLE:
        write_closest(P, target, goal, row(out, 0))
    elif P[IS_NEAR] != 0.0 and branch < 0 and out[at.ROW_STATUS] == at.UNREACHABLE:
        stretch_true(family, target, goal, J, A, out)
    return at.GOOD_POSE


@kernel
def at_its_angle(family, target, psi, branch, found, goal):
    """The best posture of a closed limb in a branch (-1: any), if that is at an arm angle as well as floats tell.

    Or what is known there. Where limits leave single arm angles next to a singularity, rounding decides which: that of
    an interval is the one that a search of all arm angles finds.
    """
    P, q = row(family, LIMITED), found[0]
    if not (is_in_line(P, SHOULDER, q[1], NEARLY_IN_LINE) or is_in_line(P, WRIST, q[5], NEARLY_IN_LINE)):
        return found
    if not is_feasible(family, target, psi, branch):
        return found
    q, own, value = search_exact(family, target, branch, goal)
    q = clipped(P, q)
    met = value < OUTSIDE and max(*pose_error(P, q, target.R, target.p)) < at.SOLVED
    return (q, own, value) if met and is_at_angle(P, q, target, psi, np.empty((16, 9))) else found


@kernel
def put_inside(family, target, psi, branch, found, goal):
    """A posture at an arm angle, in a branch (-1: any), or one inside that rounding hides: q, branch, cost."""
    P = row(family, LIMITED)
    inside = put_on_limits(P, target, psi, found, goal)
    if P[IS_NEAR] == 0.0 and (goal.seeded or inside[2] >= OUTSIDE) and hides_some(P, target.place):
        hidden = at_any_bend(family, target, psi, branch, goal, inside)
        nearer = inside[2] < OUTSIDE and worse_by(hidden[2], inside[2], True) < -WORTH
        if inside[2] >= OUTSIDE or (nearer and max(*pose_error(P, hidden[0], target.R, target.p)) < CLOSED):
            return at_its_angle(family, target, psi, branch, hidden, goal) if hidden[2] >= OUTSIDE else hidden
    return inside


@kernel
def solve_row_at(family, T, psi, branch, goal, J, A, out):
    """Solve one pose at an arm angle, in a branch (-1: any), into a row of `out`; returns the verdict on the pose."""
    R, p, verdict = read_pose(row(T, 0))
    if verdict != at.GOOD_POSE:
        return verdict
    P = row(family, LIMITED)
    target = Target(R, p, place(P, R, p))
    found = put_inside(family, target, psi, branch, solve_at_angle(P, target, psi, branch, goal, J, A), goal)
    if P[IS_NEAR] != 0.0 and found[2] >= NO_BRANCH:
        # No posture at all: the one that the nearest exact limb has may come closer than where Newton's method ended.
        q, own_branch, _ = best_branch(P, target.place, psi, branch, goal.seeded, goal.seed, goal.respect)
        F = row(family, LIMITED if goal.respect else FREE)
        if is_closer(P, clipped(F, q), clipped(F, found[0]), target, J):
            found = (q, own_branch, found[2])
    measure_row_at(P, target, psi, found, goal.respect, row(out, 0))
    if out[at.ROW_STATUS] == at.OUT_OF_LIMITS and may_have_equals(P, target, branch, found[2], goal):
        found = closest_of_equals(P, target, found, goal, False, J)
        measure_row_at(P, target, psi, found, goal.respect, row(out, 0))
    return at.GOOD_POSE


@kernel
def put_branches(P, place_, psi, respect, out, first):
    """The angles of an exact limb's branches at an arm angle, and their costs, into rows of `out` from `first` on."""
    q, sure, parts = farthest_branches(P, place_, psi, respect)
    if sure:
        put_eight(row(out, first), at.ROW, ALL, q)
        scatter(row(out, first), at.ROW_COST, at.ROW, join_parts(parts))
        return
    for elbow in range(2):
        elbow_branches(P, place_, psi, elbow, respect, out, first + 4 * elbow)


@kernel
def all_branches(family, T, asked, J, A, out, first, kept):
    """One row a branch at an arm angle, in the order of branches: rows `first` to `first + 7` of out.

    `asked` holds the arm angle, and whether the limits count; `kept` is as in `solve_all_at_angle`. Returns the verdict
    on the pose, and these curves.
    """
    P = row(family, LIMITED)
    target, verdict = read_target(P, T)
    if verdict != at.GOOD_POSE:
        return verdict, kept
    psi, respect = asked
    R, p, place_ = target
    goal = Goal(False, NO_SEED, respect)
    if P[IS_NEAR] == 0.0:
        put_branches(P, place_, psi, respect, out, first)
    else:
        kept = solve_all_at_angle(P, target, psi, (respect, J, A), out[first : first + 8], kept)
    rows = row(out, first)
    position, orientation, measured = tip_errors(P, take_eight(rows, at.ROW), R, p)
    right = as_bits(measured & (gather(rows, at.ROW_COST, at.ROW) < OUTSIDE))
    # What is farther outside than by rounding and next to no singularity stays as it is.
    most = math.inf if right != ALL and (P[IS_NEAR] != 0.0 or hides_some(P, place_)) else OUTSIDE + BARELY
    for branch in range(8):
        answer = row(out, first + branch)
        q = read7(answer)
        if (right >> branch) & 1 == 1:
            write_row(
                place_, q, branch, psi, (one_of(position, branch), one_of(orientation, branch)), (False, 0), answer
            )
        else:
            found = (q, branch, answer[at.ROW_COST])
            if found[2] <= most:
                found = put_inside(family, target, psi, branch, found, goal)
            measure_row_at(P, target, psi, found, respect, answer)
            answer[at.ROW_BRANCH] = branch
    return at.GOOD_POSE, kept
