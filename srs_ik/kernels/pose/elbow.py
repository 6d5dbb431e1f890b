"""One pose with the elbow where it is wanted, or as near to it as limits leave.

All elbows of a pose lie on a circle about the line from shoulder to wrist. The nearest one to a point lies in the half
plane of that line and the point, and others are the farther the more their arm angle differs from it. So the nearest
that is feasible lies at the feasible arm angle nearest to that of the half plane.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import across, load3, norm, sub
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import GOOD_POSE, MOST_INTERVALS, OK, ROW_STATUS
from srs_ik.kernels.layout.limb import LIMITED, SHOULDER_CENTRE
from srs_ik.kernels.limb.triangle import arm_angle_of_direction, target_of
from srs_ik.kernels.pose.intervals import all_intervals
from srs_ik.kernels.pose.solve import solve_row, solve_row_at

ANY_ANGLE = math.inf
"""The wanted arm angle of a point that is as near to all elbows."""

ON_LINE = 1e-9
"""A point this near to the line from shoulder to wrist, metres, is as near to all elbows."""

SMALLEST_NUDGE = 1e-13
"""First step, rad, into an interval whose end is on the wrong side of a limit by rounding."""


@kernel
def angle_towards(P, place_, point):
    """The arm angle of the elbow that is nearest to a point (base frame)."""
    away = across(sub(point, load3(P, SHOULDER_CENTRE)), place_[0])
    return ANY_ANGLE if norm(away) < ON_LINE else arm_angle_of_direction(place_[0], place_[1], away)


@kernel
def nearest_angle(psi, lower, upper):
    """The arm angle of an interval nearest to psi, and how far it is."""
    turn = 2.0 * math.pi
    ahead = (psi - lower) - turn * math.floor((psi - lower) / turn)
    width = upper - lower
    if ahead <= width:
        return lower + ahead, 0.0
    if ahead - width <= turn - ahead:
        return upper, ahead - width
    return lower, turn - ahead


@kernel
def take_nearest(found, n, branch, psi):
    """The interval nearest to an arm angle, of a branch (-1: of any), struck out of found: nearest angle, both ends.

    The upper end is below the lower one where none is left.
    """
    best, nearest, least = -1, 0.0, 4.0 * math.pi
    for i in range(n):
        x, far = nearest_angle(psi, found[i, 1], found[i, 2])
        if found[i, 0] >= 0.0 and (branch < 0 or found[i, 0] == branch) and far < least:
            best, nearest, least = i, x, far
    if best < 0:
        return 0.0, 0.0, -1.0
    found[best, 0] = -1.0
    return nearest, found[best, 1], found[best, 2]


@kernel
def solve_row_near(family, T, psi, branch, goal, J, A, out):
    """Solve one pose at the feasible arm angle nearest to a wanted one, into a row of out; the verdict on the pose.

    At it, the best posture of a branch (-1: of all). Where none is feasible, the answer is that of `solve_row`.
    """
    if psi == ANY_ANGLE:
        return solve_row(family, T, branch, goal, J, A, out)
    verdict = solve_row_at(family, T, psi, branch, goal, J, A, out)
    if verdict != GOOD_POSE or out[ROW_STATUS] == OK:
        return verdict
    found = np.empty((MOST_INTERVALS, 3))
    n = all_intervals(family, target_of(row(family, LIMITED), T), goal.respect, J, A, found)
    for _ in range(n):
        nearest, lower, upper = take_nearest(found, n, branch, psi)
        inward = 1.0 if nearest - lower < upper - nearest else -1.0
        nudge = 0.0
        while nudge <= upper - lower:
            solve_row_at(family, T, nearest + inward * nudge, branch, goal, J, A, out)
            if out[ROW_STATUS] == OK:
                return GOOD_POSE
            nudge = max(SMALLEST_NUDGE, 8.0 * nudge)
    return solve_row(family, T, branch, goal, J, A, out)
