"""Newton closure: from a posture that almost reaches a pose to one that reaches it, on the true chain.

Two forms. At a given arm angle the step is square: six equations of the pose, and one that keeps the elbow in its
half-plane. With the arm angle free, the step is the shortest one, damped, and stays inside the limits.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import along7, dot7
from srs_ik.kernels.algebra.linear import solve_definite, solve_linear
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import across, add, along, cross, dot, load3, norm, rotate, scale, sub
from srs_ik.kernels.chain.kinematics import (
    half_turn,
    joint_lines,
    pose_error,
    tip_lines,
    turn_about_line,
    turn_between,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import AXES, ELBOW_CENTRE, FAR, IS_CLOSED, LOWER, SHOULDER_CENTRE, UPPER
from srs_ik.kernels.limb.triangle import arm_angle_of_direction, arm_frame, straight_offset

CLOSED = 1e-12
"""A posture whose position (m) and orientation (rad) errors are both below this needs no step."""

LEFT = 1e-10
"""Next to several singularities at once, a direction in which the tip stands still to first order may hide so much of
an error (m, rad) from Newton's method: a posture meets its pose where no step makes less of it."""

ROUNDING = 4e-15
"""What rounding makes of the errors of a pose (m, rad)."""

ON_LINE = 1e-6
"""An elbow this close to the line S-W, as a part of the reach, is at every arm angle."""

STEPS = 12
"""Steps of Newton's method at an arm angle, from the closed form."""

MANY_STEPS = 40
"""What so many steps leave of an error is left for good."""

BOUNCES = 16
"""Newton's method at an arm angle without a posture bounces: it ends where so many steps do not halve the error."""

STALL = 10
"""After so many steps the error must have come down by a third, or the start was a bad one."""

LAST_STEP = 3e-8
"""A Newton step this short, rad, leaves an error of the order of its square: nothing."""

CLOSING_STEPS = 30
GENTLE = 1e-13
STALLED = 0.9
"""Gentle steps to close a posture, their least damping, and the part of an error that a step leaves where it ends."""

MAX_STEP = 0.5
"""Longest change of a joint in one step, rad."""


@kernel
def twist_to(x, y, z, position, R, p):
    """Twist (linear, of the tip point, then angular; base axes) that leads from a frame to a pose."""
    sine2, cosine2 = turn_between(x, y, z, R)
    twice_sine = norm(sine2)
    to_position = sub(p, position)
    if twice_sine > 1e-9:
        return to_position, scale(math.atan2(twice_sine, cosine2) / twice_sine, sine2)
    if cosine2 > 0.0:
        return to_position, scale(0.5, sine2)
    axis = half_turn(x, y, z, R)
    return to_position, scale(math.copysign(math.pi, dot(axis, sine2)), axis)


@kernel
def pose_step(P, q, R, p, J):
    """Twist (linear then angular, tip point, base axes) that leads from the tip at q to the pose; fills J for it."""
    x, y, z, position = tip_lines(P, q, J)
    return twist_to(x, y, z, position, R, p)


@kernel
def elbow_position(P, q):
    """The elbow centre in the base frame: a point of axis 4, moved by joints 1 to 3."""
    e = load3(P, ELBOW_CENTRE)
    for k in range(3):
        joint = 2 - k
        angle = q[joint]
        e = turn_about_line(P, joint, math.cos(angle), math.sin(angle), e)
    return e


@kernel
def elbow_across(P, q, t):
    """The vector from the line S-W, with direction t, to the elbow centre."""
    return across(sub(elbow_position(P, q), load3(P, SHOULDER_CENTRE)), t)


@kernel
def upper_arm_rotation(P, q, v):
    """A vector of the upper arm's frame in the base frame."""
    for k in range(3):
        joint = 2 - k
        angle = q[joint]
        v = rotate(load3(P, AXES + 3 * joint), math.cos(angle), math.sin(angle), v)
    return v


@kernel
def arm_angle(P, q, t, h0):
    """Arm angle of a configuration whose S-W direction is t and whose zero direction is h0.

    On an exact limb it is read off the rotation of the upper arm, which keeps its digits when the elbow is almost
    straight; on a near limb off the position of the elbow centre.
    """
    if P[IS_CLOSED] == 1.0:
        x = straight_offset(P, q[3])
        _, h, _ = arm_frame(P, math.cos(x), math.sin(x))
        return arm_angle_of_direction(t, h0, upper_arm_rotation(P, q, h))
    return arm_angle_of_direction(t, h0, elbow_across(P, q, t))


@kernel
def moved(q, A, factor):
    """The posture q plus a multiple of column 7 of A."""
    return along7(q, factor, (A[0, 7], A[1, 7], A[2, 7], A[3, 7], A[4, 7], A[5, 7], A[6, 7]))


@kernel
def longest(A):
    """Largest magnitude in column 7 of A."""
    size = 0.0
    for i in range(7):
        size = max(size, abs(A[i, 7]))
    return size


@kernel
def equations_at_angle(P, q, R, p, b, A):
    """Write the seven equations of a Newton step at q into A: the pose, and no way across the half-plane with normal b.

    Returns the error of the pose (m, rad) and the vector from the shoulder to the elbow centre.
    """
    x, y, z, position = joint_lines(P, q, A)
    linear, angular = twist_to(x, y, z, position, R, p)
    # The joint lines give velocities at the base origin.
    at_origin = add(linear, cross(position, angular))
    for i in range(3):
        A[i, 7] = at_origin[i]
        A[i + 3, 7] = angular[i]
    elbow = elbow_position(P, q)
    lever = cross(elbow, b)
    for j in range(3):
        A[6, j] = dot(b, (A[0, j], A[1, j], A[2, j])) + dot(lever, (A[3, j], A[4, j], A[5, j]))
        A[6, j + 3] = 0.0
    A[6, 6] = 0.0
    reach = sub(elbow, load3(P, SHOULDER_CENTRE))
    A[6, 7] = -dot(b, reach)
    return max(norm(linear), norm(angular)), reach


@kernel
def close_at_angle(P, q, R, p, t, h0, psi, steps, A):
    """Newton's method from a posture to the pose and the arm angle together: the posture, and whether both are met."""
    h = along(scale(math.cos(psi), h0), math.sin(psi), cross(t, h0))
    b = cross(t, h)
    checkpoint = least = math.inf
    for step in range(steps):
        error, reach = equations_at_angle(P, q, R, p, b, A)
        if error < 0.1 * CLOSED and abs(A[6, 7]) < CLOSED:
            return q, dot(h, reach) > -ON_LINE * P[FAR]
        least = min(least, error)
        if step % BOUNCES == BOUNCES - 1:
            if least > 0.5 * checkpoint:
                break
            checkpoint = least
        if solve_linear(A, 7) == 0.0:
            return q, False
        size = longest(A)
        q = moved(q, A, 1.0 if size < MAX_STEP else MAX_STEP / size)
        if size < LAST_STEP:
            return q, dot(h, reach) > -ON_LINE * P[FAR]
    error, reach = equations_at_angle(P, q, R, p, b, A)
    most = LEFT if steps >= MANY_STEPS else CLOSED
    return q, error < most and abs(A[6, 7]) < 1e3 * CLOSED and dot(h, reach) > -ON_LINE * P[FAR]


@kernel
def close_free(P, q, R, p, respect, steps, J, A):
    """Shortest damped steps from a posture towards the pose, the arm angle left free, inside the limits if respected.

    Returns the posture, and the larger of its position (m) and orientation (rad) errors, or those of one a step before.
    """
    error = 0.0
    checkpoint = 1e9
    kept, least = q, CLOSED
    for step in range(steps):
        linear, angular = pose_step(P, q, R, p, J)
        error = max(norm(linear), norm(angular))
        if error < least:
            kept, least = q, error
        if error < 0.1 * CLOSED:
            break
        if step % STALL == 0:
            if error > 0.7 * checkpoint:
                break
            checkpoint = error
        damping = min(1e-4, 1e-2 * error * error)
        blocked = 0
        q_next = q
        for _ in range(7):
            shortest_step(J, linear, angular, blocked, damping, A)
            size = longest(A)
            q_next = moved(q, A, 1.0 if size < MAX_STEP else MAX_STEP / size)
            if not respect:
                break
            again = 0
            for j in range(7):
                if (blocked >> j) & 1 == 0:
                    low = q_next[j] < P[LOWER + j] and q[j] <= P[LOWER + j] + 1e-9
                    high = q_next[j] > P[UPPER + j] and q[j] >= P[UPPER + j] - 1e-9
                    if low or high:
                        again |= 1 << j
            if again == 0:
                break
            blocked |= again
        q = clipped(P, q_next) if respect else q_next
    if 0.1 * CLOSED <= least < CLOSED:
        # Next to a singularity a step from what is closed may lead away from it.
        position, orientation = pose_error(P, q, R, p)
        if max(position, orientation) >= CLOSED:
            return kept, least
    return q, error


@kernel
def close_gently(P, q, R, p, respect, J, A):
    """Damped steps from a posture to one that meets its pose: q, and the larger of its errors (m, rad).

    Where more than one joint is singular some directions are as good as lost, and rounding alone would lead far along
    them; the damping leaves them out, as long as the error has no part in them. What is `LEFT` is left where no step
    makes it less.
    """
    blocked = 0
    last = math.inf
    for _ in range(CLOSING_STEPS):
        linear, angular = pose_step(P, q, R, p, J)
        error = max(norm(linear), norm(angular))
        if error < 0.1 * CLOSED or STALLED * last < error < LEFT:
            return q, error
        last = error
        shortest_step(J, linear, angular, blocked, max(GENTLE, 1e-2 * error * error), A)
        q = moved(q, A, 1.0)
        if respect:
            for j in range(7):
                if q[j] < P[LOWER + j] or q[j] > P[UPPER + j]:
                    blocked |= 1 << j
            q = clipped(P, q)
    q, _ = close_free(P, q, R, p, respect, CLOSING_STEPS, J, A)
    # Next to several singularities its last step may have led away.
    position, orientation = pose_error(P, q, R, p)
    return q, max(position, orientation)


@kernel
def closed_better(P, q, target, respect, J, A):
    """A posture, or the one that closes to less of an error."""
    position, orientation = pose_error(P, q, target.R, target.p)
    closed, error = close_gently(P, q, target.R, target.p, respect, J, A)
    return closed if error < max(position, orientation) else q


@kernel
def with_zeros(a, which):
    """Seven numbers, zero where a bit is set."""
    return (
        a[0] if which & 1 == 0 else 0.0,
        a[1] if which & 2 == 0 else 0.0,
        a[2] if which & 4 == 0 else 0.0,
        a[3] if which & 8 == 0 else 0.0,
        a[4] if which & 16 == 0 else 0.0,
        a[5] if which & 32 == 0 else 0.0,
        a[6] if which & 64 == 0 else 0.0,
    )


@kernel
def load_square(J, blocked, damping, A):
    """Write J times its transpose into A, damped, joints in the bit set `blocked` left out."""
    for i in range(6):
        free = read7(row(J, i))
        if blocked != 0:
            free = with_zeros(free, blocked)
        for k in range(i + 1):
            A[i, k] = dot7(free, row(J, k))
            A[k, i] = A[i, k]
        A[i, i] += damping + 1e-16


@kernel
def put_twist(linear, angular, A):
    """Write a twist into column 6 of A."""
    for i in range(3):
        A[i, 6] = linear[i]
        A[i + 3, 6] = angular[i]


@kernel
def shortest_step(J, linear, angular, blocked, damping, A):
    """Write into column 7 of A the shortest joint step for a twist, joints in the bit set `blocked` held still."""
    load_square(J, blocked, damping, A)
    put_twist(linear, angular, A)
    solve_definite(A, damping + 1e-16)
    y0, y1, y2, y3, y4, y5 = A[0, 6], A[1, 6], A[2, 6], A[3, 6], A[4, 6], A[5, 6]
    for j in range(7):
        s = J[0, j] * y0 + J[1, j] * y1 + J[2, j] * y2 + J[3, j] * y3 + J[4, j] * y4 + J[5, j] * y5
        A[j, 7] = s if (blocked >> j) & 1 == 0 else 0.0


@kernel
def clipped(P, q):
    """The posture with every joint inside its limits."""
    return (
        min(max(q[0], P[LOWER]), P[UPPER]),
        min(max(q[1], P[LOWER + 1]), P[UPPER + 1]),
        min(max(q[2], P[LOWER + 2]), P[UPPER + 2]),
        min(max(q[3], P[LOWER + 3]), P[UPPER + 3]),
        min(max(q[4], P[LOWER + 4]), P[UPPER + 4]),
        min(max(q[5], P[LOWER + 5]), P[UPPER + 5]),
        min(max(q[6], P[LOWER + 6]), P[UPPER + 6]),
    )


@kernel
def load_system(J, d, A):
    """Write J and a last row d into A, right-hand side zero."""
    for j in range(7):
        for i in range(6):
            A[i, j] = J[i, j]
        A[6, j] = d[j]
    for i in range(7):
        A[i, 7] = 0.0
