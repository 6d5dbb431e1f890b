"""From a task to joint angles: its posture, the tip pose that belongs to it, and the arm angle that comes nearest.

Joint angles come from the whole rotation of the hand by way of the general closed form, where the paper (eqs.
IKShoulder, IKElbow, Wrist) takes one dot product after the other. So four errata have no place here: q_3 from a point
on the axis of joint 3 (erratum 3), q_4 from a difference of unit vectors (4), a frame that is not printed (5), and q_5
that keeps the sign of the pronosupination only half of the time (6).
"""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import short_way
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import add, along, cross, load3, norm, scale, store3, sub, swing, times_transposed
from srs_ik.kernels.chain.answer import measure_row, write_row
from srs_ik.kernels.chain.kinematics import forward_kinematics, pose_error
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import answer
from srs_ik.kernels.layout import task as at
from srs_ik.kernels.layout.asked import Goal, Target
from srs_ik.kernels.layout.limb import FREE, IS_NEAR, LIMITED, LOOSE, NEAR
from srs_ik.kernels.limb.branches import NO_BRANCH, best_branch, branch_of
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, tightest_joint
from srs_ik.kernels.limb.triangle import elbow_bend, hand_rotation, shoulder_to_wrist, target_frame, unit_across
from srs_ik.kernels.near.at_angle import may_reach, solve_at_angle
from srs_ik.kernels.near.predicted_best import search_true
from srs_ik.kernels.pose.elbow import SMALLEST_NUDGE, take_nearest
from srs_ik.kernels.pose.intervals import all_intervals
from srs_ik.kernels.pose.search import search_exact
from srs_ik.kernels.task.near_posture import settle_posture
from srs_ik.kernels.task.posture import (
    AT_SHOULDER,
    PARALLEL,
    lengths_of,
    plan,
    planned_arm_angle,
    tip_axes,
    write_posture,
)
from srs_ik.kernels.task.roll import best_roll

OFF_AXIS = 1e-9
"""A wrist this far from the line through the tip about which the hand rolls, metres, moves with the roll."""

FLAT_BEND = 3e-12
"""Sine of the bend of a flat arm: outside a limit at the straight arm by more than rounding, and no error by itself."""

FOLD_GAP = 1e-6
"""Nearer than this to the shoulder, metres, the wrist of a folded arm is moved by a trace of a bend."""

AIMS = 4
"""Corrections of the aim of a near limb at a target out of reach."""

ROLL_PASSES = 3
"""So often the roll is chosen anew where it moves the wrist."""

NARROW = 1e-9
"""Postures of an interval narrower than this, rad, are on their limits by rounding at best."""


@kernel
def task_place(P, R, p):
    """As `triangle.place`, but a wrist at the shoulder to rounding has one direction, and a flat arm a trace of a bend.

    The bend says to which side of a stretched or folded arm the elbow would go, so that a side that limits forbid is
    not taken, and the joints move continuously as the arm comes to lie flat.
    """
    sw = shoulder_to_wrist(P, R, p)
    if norm(sw) < AT_SHOULDER:
        sw = (0.0, 0.0, 0.0)
    d, t, h0 = target_frame(P, sw)
    c, s, miss = elbow_bend(P, d)
    if c > 0.0 or P[NEAR] > FOLD_GAP:
        s = max(s, FLAT_BEND)
    return t, h0, c, s, hand_rotation(P, R), miss


@kernel
def out_of_reach(P, target, psi, branch, respect):
    """The posture of a near limb that lies flat towards a wrist out of reach, the hand as wanted: q, branch, cost.

    It is that of the nearest exact limb, aimed beside the target by as much as the true chain ends beside its own.
    """
    R, p, place_ = target
    end = along(p, -place_[5], place_[0])
    aim = end
    q, b, cost = best_branch(P, place_, psi, branch, False, NO_SEED, respect)
    for _ in range(AIMS):
        _, _, _, tip = forward_kinematics(P, q)
        aim = add(aim, sub(end, tip))
        q, b, cost = best_branch(P, task_place(P, R, aim), psi, branch, False, NO_SEED, respect)
    return q, b, cost


@kernel
def is_beyond(P, place_):
    """Whether a wrist is beyond the reach of a near limb, whatever its arm angle.

    It may be beyond that of the nearest exact limb, and some arm angles meet it on the true chain all the same.
    """
    return P[IS_NEAR] != 0.0 and not may_reach(P, place_)


@kernel
def in_branch(P, target, psi, branch, goal, J, A):
    """Best posture at an arm angle, of a branch (-1: of all): q, branch, cost.

    Where a near limb cannot reach, nothing closes on its true chain: there it lies as its nearest exact limb would.
    """
    place_, respect = target.place, goal.respect
    if is_beyond(P, place_):
        return out_of_reach(P, target, psi, branch, respect)
    return solve_at_angle(P, target, psi, branch, goal, J, A)


@kernel
def at_angle(P, target, psi, branch, goal, J, A):
    """Best posture at an arm angle, in the branch that is preferred (-1: none) if that has one: q, branch, cost."""
    q, b, cost = in_branch(P, target, psi, branch, goal, J, A)
    if branch >= 0 and cost >= OUTSIDE:
        return in_branch(P, target, psi, -1, goal, J, A)
    return q, b, cost


@kernel
def nearest_feasible(family, target, psi, branch, goal, J, A):
    """The posture at the feasible arm angle nearest to a wanted one.

    Returns:
        q, branch, cost; of the best posture of any kind where none is feasible.
    """
    place_, respect = target.place, goal.respect
    is_near, beyond = family[LIMITED, IS_NEAR] != 0.0, is_beyond(row(family, LIMITED), place_)
    found = np.empty((8 * answer.MAX_PIECES, 3))
    if beyond or (not is_near and place_[5] != 0.0):
        n = find_intervals(row(family, LIMITED if respect else FREE), place_, -1, found)
    else:
        n = all_intervals(family, target, respect, J, A, found)
    for _ in range(n):
        nearest, lower, upper = take_nearest(found, n, -1, psi)
        P = row(family, LOOSE if upper - lower < NARROW else LIMITED)
        inward = 1.0 if nearest - lower < upper - nearest else -1.0
        nudge = 0.0
        while nudge <= upper - lower:
            q, b, cost = at_angle(P, target, nearest + inward * nudge, branch, goal, J, A)
            if cost < OUTSIDE:
                return q, b, cost
            nudge = max(SMALLEST_NUDGE, 8.0 * nudge)
    P = row(family, LIMITED)
    if not is_near:
        return search_exact(family, target, -1, goal)
    if not beyond:
        q, b, cost = search_true(P, target, -1, goal, J, A)
        if cost < OUTSIDE or place_[5] == 0.0:
            return q, b, cost
    return out_of_reach(P, target, psi, -1, respect)


@kernel
def solve_posed(family, pose, m, branch, goal, work, out):
    """Solve a pose with the elbow in the plane with signed normal m, or as near as can be; the arm angle given up.

    A branch other than -1 is preferred where it is feasible there.
    """
    R, p = pose
    J, A = work
    P = row(family, LIMITED)
    place_ = task_place(P, R, p)
    target = Target(R, p, place_)
    psi = planned_arm_angle(place_[0], place_[1], m)
    q, b, cost = at_angle(P, target, psi, branch, goal, J, A)
    if cost < OUTSIDE:
        write_row(place_, q, b, psi, pose_error(P, q, R, p), (False, 0), out)
        return 0.0
    q, b, cost = nearest_feasible(family, target, psi, branch, goal, J, A)
    measure_row(P, target, q, b, cost, goal.respect, out)
    if P[IS_NEAR] != 0.0 and goal.respect and out[answer.ROW_STATUS] == answer.UNREACHABLE and not is_beyond(P, place_):
        # On a near limb, only an attempt without limits tells what they forbid from what is out of reach.
        free, _, value = at_angle(P, target, psi, -1, Goal(goal.seeded, goal.seed, False), J, A)
        if value < OUTSIDE:
            out[answer.ROW_STATUS] = answer.OUT_OF_LIMITS
            out[answer.ROW_JOINT] = tightest_joint(P, free)
    return abs(short_way(out[answer.ROW_ARM_ANGLE] - psi))


@kernel
def choose_roll(P, H, x, grasped, found, hand_axes, side, tie, seeded, seed, respect):
    """A pronosupination for a hand that leaves it free, the posture that goes with it, and its branch."""
    p = load3(x, at.TASK_POSITION)
    direction = found[5]
    towards = (0.0, 0.0, 1.0)
    if seeded:
        tip_x, tip_y, tip_z, _ = forward_kinematics(P, seed)
        towards = swing((scale(hand_axes[1], tip_x), tip_y, tip_z), hand_axes[4], hand_axes[7])
    phi = unit_across(towards, direction, (1.0, 0.0, 0.0))
    moves_wrist = grasped and norm(cross(load3(H, at.HAND_WRIST), load3(H, at.HAND_GRASP))) >= OFF_AXIS
    branch = -1
    for _ in range(ROLL_PASSES if moves_wrist else 1):
        place_ = task_place(P, times_transposed(tip_axes(direction, phi), hand_axes), p)
        psi = planned_arm_angle(place_[0], place_[1], found[3])
        roll, branch = best_roll(P, place_, psi, direction, seeded, seed, respect)
        phi = swing(((0.0, 0.0, 0.0), phi, cross(direction, phi)), math.cos(roll), math.sin(roll))
        if moves_wrist:
            found = plan(P, H, x, grasped, phi, True, side, tie, lengths_of(H, grasped))
    return phi, found, branch


@kernel
def solve_true(family, H, x, grasped, phi, side, tie, found, hand_axes, branch, seeded, seed, respect, J, A, out):
    """Solve the task of a near limb for the posture of its true chain.

    Where limits push the elbow away, that is the posture without them, in the branch of the nearest exact limb's best;
    where the true chain has none, out of reach say, it is that of the nearest exact limb.

    Returns:
        The posture, the rotation of the tip, and the arm angle given up.
    """
    P = row(family, LIMITED)
    p = load3(x, at.TASK_POSITION)
    R = times_transposed(tip_axes(found[5], phi), hand_axes)
    place_ = task_place(P, R, p)
    psi = planned_arm_angle(place_[0], place_[1], found[3])
    start, _, _ = best_branch(P, place_, psi, branch, seeded, seed, respect)
    q, lowest, lost, exact = start, NO_BRANCH, 0.0, found
    # From the closed form; next to a singularity, where that may lead astray, from the seed too; then from any posture.
    for attempt in range(3):
        if attempt == 1 and seeded:
            start = seed
        elif attempt == 2:
            if lowest < OUTSIDE:
                break
            lost = solve_posed(family, (R, p), found[3], branch, Goal(seeded, seed, respect), (J, A), out)
            if out[answer.ROW_STATUS] != answer.OK or lost > 0.0:
                return found, R, lost
            start = read7(out)
        if may_reach(P, place_) and (attempt != 1 or seeded):
            there, R_there, q_there, value = settle_posture(
                P, H, x, grasped, phi, side, tie, exact, hand_axes, start, seeded, seed, respect, A
            )
            if value < lowest:
                found, R, q, lowest = there, R_there, q_there, value
    if lowest < OUTSIDE:
        place_ = task_place(P, R, p)
        psi = planned_arm_angle(place_[0], place_[1], found[3])
        write_row(place_, q, branch_of(P, q), psi, pose_error(P, q, R, p), (False, 0), out)
    return found, R, lost


@kernel
def solve_task_one(family, H, x, given, side, tie, goal, J, A, out):
    """Solve one task row into a task solution row."""
    P = row(family, LIMITED)
    seeded, seed, respect = goal
    grasped = given & at.GRASP != 0
    phi = load3(x, at.TASK_PRONOSUPINATION)
    rolled = given & at.PRONOSUPINATION != 0
    found = plan(P, H, x, grasped, phi, rolled, side, tie, lengths_of(H, grasped))
    in_tip = load3(H, at.HAND_GRASP if grasped else at.HAND_REACH)
    across_tip = load3(H, at.HAND_ACROSS)
    if min(norm(cross(found[5], phi)), norm(cross(in_tip, across_tip))) < PARALLEL:
        rolled = False
    hand_axes = tip_axes(in_tip, unit_across(across_tip, in_tip, load3(H, at.HAND_GRASP)))
    branch = -1
    if not rolled:
        phi, found, branch = choose_roll(P, H, x, grasped, found, hand_axes, side, tie, seeded, seed, respect)
    p = load3(x, at.TASK_POSITION)
    if P[IS_NEAR] == 0.0:
        R = times_transposed(tip_axes(found[5], phi), hand_axes)
        out[at.ANGLE_LOST] = solve_posed(family, (R, p), found[3], branch, goal, (J, A), out)
    else:
        found, R, lost = solve_true(
            family, H, x, grasped, phi, side, tie, found, hand_axes, branch, seeded, seed, respect, J, A, out
        )
        out[at.ANGLE_LOST] = lost
    write_posture(P, found, row(out, at.TASK_POSTURE))
    for k in range(9):
        out[at.TASK_ROTATION + k] = R[k]
    store3(out, at.TASK_TIP, p)
