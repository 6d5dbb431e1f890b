"""Postures of a pose that its strips miss: from those of the pose before, by least squares inside the limits.

Where joints lie on several limits at once, or an elbow is straight, a pose may have a single posture, or an interval
that rounding takes away. Whoever comes from a posture next to it finds it: by the method of Levenberg and Marquardt, in
which joints on a limit that want to pass it stay there. Steps of least squares are defined where Newton's are not.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.linear import solve_linear
from srs_ik.kernels.algebra.vectors import norm
from srs_ik.kernels.chain.newton import CLOSED, LEFT, clipped, longest, moved, pose_step
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import LOWER, UPPER
from srs_ik.kernels.limb.poses import read7

PATIENCE = 60
"""Most steps."""

LONGEST = 0.3
"""Longest joint step, rad."""

LEAST_DAMPING = 1e-13
MOST_DAMPING = 1e3

AS_GOOD = 1e-3
"""A step that changes the error by less than this part of it is as good as none: it is taken, and damped less, next to
a singularity joints begin to move with little damping alone."""


@kernel
def load_squares(J, twist, blocked, damping, A):
    """Write the damped normal equations of a joint step for a twist; joints of the bit set `blocked` stay."""
    for i in range(7):
        for k in range(8):
            A[i, k] = 0.0
        A[i, i] = 1.0
        if (blocked >> i) & 1:
            continue
        A[i, i] = damping
        for r in range(6):
            A[i, 7] += J[r, i] * twist[r]
            for k in range(7):
                if (blocked >> k) & 1 == 0:
                    A[i, k] += J[r, i] * J[r, k]


@kernel
def outward(P, q, A, blocked):
    """The joints on a limit that a step would take past it, with those that are blocked already."""
    for j in range(7):
        low = q[j] <= P[LOWER + j] and A[j, 7] < 0.0
        high = q[j] >= P[UPPER + j] and A[j, 7] > 0.0
        if low or high:
            blocked |= 1 << j
    return blocked


@kernel
def bridge_to(P, R, p, q, J, A):
    """Write the posture inside the limits that is found from q in place of it; whether it meets the pose."""
    here = clipped(P, read7(q))
    damping = 1e-4
    linear, angular = pose_step(P, here, R, p, J)
    error = math.hypot(norm(linear), norm(angular))
    for _ in range(PATIENCE):
        if error < CLOSED or damping > MOST_DAMPING:
            break
        twist = (linear[0], linear[1], linear[2], angular[0], angular[1], angular[2])
        blocked = 0
        for _ in range(7):
            load_squares(J, twist, blocked, damping, A)
            solve_linear(A, 7)
            more = outward(P, here, A, blocked)
            if more == blocked:
                break
            blocked = more
        size = longest(A)
        there = clipped(P, moved(here, A, min(1.0, LONGEST / max(size, 1e-300))))
        linear, angular = pose_step(P, there, R, p, J)
        error_there = math.hypot(norm(linear), norm(angular))
        if error_there < (1.0 + AS_GOOD) * error:
            is_last = damping == LEAST_DAMPING and error_there > (1.0 - AS_GOOD) * error
            here, error = there, error_there
            damping = max(0.1 * damping, LEAST_DAMPING)
            if is_last:
                break
        else:
            linear, angular = pose_step(P, here, R, p, J)
            damping *= 10.0
    for j in range(7):
        q[j] = here[j]
    return error < LEFT
