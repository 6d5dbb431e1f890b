"""Postures of a pose that its strips miss: from those of the pose before, by least squares inside the limits.

Where joints lie on several limits at once, or an elbow is straight, a pose may have a single posture, or an interval
that rounding takes away. Whoever comes from a posture next to it finds it: by the method of Levenberg and Marquardt, in
which joints on a limit that want to pass it stay there. Steps of least squares are defined where Newton's are not.
Where eight postures in a row are for one pose, eight are taken there in step first, by Newton's method.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.algebra.lanes import ALL, as_bits
from srs_ik.kernels.algebra.linear import solve_linear
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import norm
from srs_ik.kernels.chain.eight import put_eight, take_eight
from srs_ik.kernels.chain.newton import CLOSED, LEFT, clipped, longest, moved, pose_step
from srs_ik.kernels.chain.newton_eight import largest
from srs_ik.kernels.curves.in_step import to_curves
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import LOWER, UPPER
from srs_ik.kernels.limb.poses import read_pose

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


STEPS_IN_STEP = 6
"""Steps of eight in step, at most: those that need more are led to their pose one by one ..."""

FARTHEST = 0.1
"""... as those that a joint of which would go farther, rad: next to a singularity, where steps have to be damped."""


@kernel
def of_one_pose(poses, first):
    """Whether eight poses from one on are the same."""
    for i in range(first + 1, first + 8):
        for r in range(3):
            for c in range(4):
                if poses[i, r, c] != poses[first, r, c]:
                    return False
    return True


@kernel
def is_inside(P, joint, angles):
    """Which of eight angles of a joint lie inside its limits, and not on them, as bits."""
    return as_bits((angles > P[LOWER + joint]) & (angles < P[UPPER + joint]))


@kernel
def inside_limits(P, q):
    """Which of eight postures lie inside all joint limits, as bits."""
    arm = is_inside(P, 0, q[0]) & is_inside(P, 1, q[1]) & is_inside(P, 2, q[2]) & is_inside(P, 3, q[3])
    return arm & is_inside(P, 4, q[4]) & is_inside(P, 5, q[5]) & is_inside(P, 6, q[6])


@kernel
def bridge_all(P, poses, starts, met, J, A):
    """Take postures (n, 7), in place, to poses (n, 4, 4) inside the limits; `met` (n,) says which meet theirs then."""
    count = starts.shape[0]
    i = 0
    while i < count:
        R, p, _ = read_pose(row(poses, i))
        together, there = 1, 0
        if i + 8 <= count and of_one_pose(poses, i):
            together = 8
            start = take_eight(row(starts, i), 7)
            q, _, there = to_curves(P, R, p, start, ALL, (STEPS_IN_STEP, 0.0))
            there &= inside_limits(P, q) & as_bits(largest(along7(q, -1.0, start)) < FARTHEST)
            put_eight(row(starts, i), 7, there, q)
        for k in range(together):
            met[i + k] = (there >> k) & 1 == 1 or bridge_to(P, R, p, row(starts, i + k), J, A)
        i += together
