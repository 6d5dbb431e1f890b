"""What is asked of the elbow: an arm angle, or the way on which an objective falls."""

from srs_ik.kernels.algebra.joint_vectors import short_way, with_joint
from srs_ik.kernels.algebra.pointers import read7, row, scratch
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.exact.farthest import branch_at
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.track import ANGLE, ANGLE_WANTED, ELBOW, KEEP
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import OUTSIDE
from srs_ik.kernels.limb.triangle import elbow_side, place
from srs_ik.kernels.optimum.objectives import objective

STEP = 0.12
"""Objectives are compared at arm angles this far apart, rad."""

FARTHEST = 0.36
"""The elbow is not asked to go farther than this at a time, rad."""

PULL = 30.0
"""What a radian away from the arm angle that is asked for costs, squared."""

TINY = 1e-6
"""Difference of joint angles for slopes, rad."""


@kernel
def vertex(below, middle, above):
    """Where a parabola through three values a step apart is least, in steps from the middle one; at most one."""
    bend = above - 2.0 * middle + below
    rise = 0.5 * (above - below)
    if bend > abs(rise):
        return -rise / bend
    return -1.0 if rise > 0.0 else (1.0 if rise < 0.0 else 0.0)


@kernel
def downhill(P, C, task, q, place_, psi, J):
    """How far an objective falls with the arm angle, rad: to the end of a parabola, or a step."""
    kind, branch = int(C[ELBOW]), branch_of(P, q)
    side = elbow_side(P, place_, branch >> 2)
    below, one = branch_at(P, side, psi - STEP, branch, True, q, True)
    middle, two = branch_at(P, side, psi, branch, True, q, True)
    above, three = branch_at(P, side, psi + STEP, branch, True, q, True)
    if max(one, two, three) >= OUTSIDE:
        return 0.0
    return STEP * vertex(
        objective(P, kind, task, below, J), objective(P, kind, task, middle, J), objective(P, kind, task, above, J)
    )


@kernel
def wish(P, C, task, q, pose, J):
    """How far the elbow should go by what is asked of it, rad, and how much that counts."""
    if C[ELBOW] == KEEP:
        return 0.0, 0.0
    place_ = place(P, pose[0], pose[1])
    psi = arm_angle(P, q, place_[0], place_[1])
    way = short_way(C[ANGLE_WANTED] - psi) if C[ELBOW] == ANGLE else downhill(P, C, task, q, place_, psi, J)
    return min(max(way, -FARTHEST), FARTHEST), PULL


@kernel
def slope_by(P, q, place_, psi, j):
    """How fast the arm angle changes with a joint."""
    moved = with_joint(q, j, q[j] + TINY)
    return short_way(arm_angle(P, moved, place_[0], place_[1]) - psi) / TINY


@kernel
def slope(P, q, pose):
    """How fast the arm angle changes with each joint."""
    place_ = place(P, pose[0], pose[1])
    psi = arm_angle(P, q, place_[0], place_[1])
    found = row(scratch(1, 7), 0)
    for joint in range(7):
        found[joint] = slope_by(P, q, place_, psi, joint)
    return read7(found)
