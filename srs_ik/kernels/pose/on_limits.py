"""Postures that rounding alone leaves outside their limits, next to a singularity: put inside."""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import short_way
from srs_ik.kernels.algebra.linear import solve_linear
from srs_ik.kernels.algebra.vectors import along, cross, norm, scale
from srs_ik.kernels.chain import newton
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.limb import FAR, FIRST_JOINT, LOWER, SHOULDER, UPPER, WRIST
from srs_ik.kernels.limb.goal import OUTSIDE, UNMET, cost
from srs_ik.kernels.limb.in_line import NEARLY_IN_LINE, is_in_line, may_split, toward_of
from srs_ik.kernels.limb.splits import nearest_split
from srs_ik.kernels.near.on_curves import SAME_ANGLE

BARELY = 1e-3
"""A posture farther outside its limits than this, rad, is not so by rounding."""

CLOSING_STEPS = 12

APART = 4.0
"""An answer, the end of an interval and the posture inside are each off by what is vague, and rounding by any signs."""


@kernel
def meets(P, q, target):
    """Whether a posture meets its pose but for rounding: a position is told the worse, the longer the arm is."""
    position, orientation = pose_error(P, q, target.R, target.p)
    return position < min(newton.LEFT * max(P[FAR], 1.0), SOLVED) and orientation < newton.LEFT


@kernel
def split_inside(P, k, q1, q2, q3):
    """The outer angles of a spherical joint, what one is outside its limits moved to the other: q1, q3.

    They are as they were, unless the joint is next to its singularity, where a pose tells their sum alone.
    """
    if not is_in_line(P, k, q2, NEARLY_IN_LINE):
        return q1, q3
    first = int(P[k + FIRST_JOINT])
    toward = toward_of(P, k, q2)
    q1, q3 = nearest_split(P, k, first, toward * q1 + q3, toward, q1, q3)
    # Limits of both that leave one split may leave none to the last bit.
    return min(max(q1, P[LOWER + first]), P[UPPER + first]), min(max(q3, P[LOWER + first + 2]), P[UPPER + first + 2])


@kernel
def vagueness(P, q, target, psi, A):
    """How far apart, rad, postures at an arm angle may be that meet a pose as well as floats tell."""
    t, h0 = target.place[0], target.place[1]
    across = along(scale(math.cos(psi), cross(t, h0)), -math.sin(psi), h0)
    newton.equations_at_angle(P, q, target.R, target.p, across, A)
    for i in range(6):
        A[i, 7] = newton.ROUNDING if i % 2 == 0 else -newton.ROUNDING
    A[6, 7] = 0.0
    return newton.longest(A) if solve_linear(A, 7) != 0.0 else math.inf


@kernel
def is_at_angle(P, q, target, psi, A):
    """Whether a posture is at an arm angle as well as floats tell."""
    away = abs(short_way(newton.arm_angle(P, q, target.place[0], target.place[1]) - psi))
    if away <= SAME_ANGLE:
        return True
    on_line = away * norm(newton.elbow_across(P, q, target.place[0])) <= newton.ON_LINE * P[FAR]
    return on_line and away <= SAME_ANGLE + APART * vagueness(P, q, target, psi, A)


@kernel
def put_on_limits(P, target, psi, found, goal):
    """A posture at an arm angle, or one inside the limits where rounding alone leaves it outside: q, branch, cost.

    Next to a singularity, the rounding of an arm angle turns joints farther than that of the limits allows.
    """
    q, branch, value = found
    # The cost of what is outside by less than the rounding of large figures is `OUTSIDE` itself.
    if not (goal.respect and OUTSIDE <= value < UNMET):
        return found
    R, p, place_ = target
    in_line = is_in_line(P, SHOULDER, q[1], NEARLY_IN_LINE) or is_in_line(P, WRIST, q[5], NEARLY_IN_LINE)
    if in_line and may_split(P, place_):
        q1, q3 = split_inside(P, SHOULDER, q[0], q[1], q[2])
        q5, q7 = split_inside(P, WRIST, q[4], q[5], q[6])
        inside = (q1, q[1], q3, q[3], q5, q[5], q7)
        at_split = cost(P, inside, goal.seeded, goal.seed, True)
        if at_split < OUTSIDE and meets(P, inside, target):
            return inside, branch, at_split
    if value > OUTSIDE + BARELY:
        return found
    J, A = np.empty((6, 7)), np.empty((16, 9))
    q, error = newton.close_free(P, newton.clipped(P, q), R, p, True, CLOSING_STEPS, J, A)
    if error > newton.CLOSED or not is_at_angle(P, q, target, psi, A):
        return found
    return q, branch, cost(P, q, goal.seeded, goal.seed, True)
