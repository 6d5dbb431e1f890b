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
from srs_ik.kernels.layout.limb import FAR
from srs_ik.kernels.limb.goal import OUTSIDE, UNMET, cost
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
    R, p, _ = target
    if value > OUTSIDE + BARELY:
        return found
    J, A = np.empty((6, 7)), np.empty((16, 9))
    q, error = newton.close_free(P, newton.clipped(P, q), R, p, True, CLOSING_STEPS, J, A)
    if error > newton.CLOSED or not is_at_angle(P, q, target, psi, A):
        return found
    return q, branch, cost(P, q, goal.seeded, goal.seed, True)
