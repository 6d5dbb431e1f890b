"""Postures at which the Jacobian has rank five: two ways of the joints keep the pose, to first order.

What the tip does there in the one direction that is lost is a quadratic form of the two ways. If that is definite, the
posture is the only one of its pose around, or amid a small closed curve of them; else two curves cross, or almost.
Steps towards a pose halve what is left at best next to one. To the posture itself Newton's method leads in a
few steps: five equations of the pose, and two that make the form's slope zero.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, largest, store7
from srs_ik.kernels.algebra.linear import solve_linear
from srs_ik.kernels.algebra.pointers import keep, read7, row
from srs_ik.kernels.algebra.vectors import add, along, cross, dot, norm, scale
from srs_ik.kernels.chain.newton import MAX_STEP, load_square, longest, moved, pose_step, shortest_step
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.limb.goal import NO_SEED

STEPS, MOST_STEPS = 12, 20
SHRINKS = 0.5
SETTLED = 1e-8
"""So many of Newton's steps, and others up to the second number as long as each is shorter by this factor than the one
before; and the size of the last one, rad."""

DAMPING = 1e-14
FIRST_DAMPING = 1e-4
"""What is lost is left out of steps by so much of damping; of the first one, which only comes closer to the pose, all
in which the tip moves little."""

STEADY_STEPS = 120
NEXT_TO = 1e-10
"""Steps, each of which leaves less of the error, at most, and the error (m, rad) that they leave: half of the way to a
posture of rank five each, they end next to it."""

STEADY_DAMPING, GENTLER, STIFFER = 1e-2, 0.25, 4.0
"""The first one's damping, and by how much a step that comes closer makes less of it, one that does not more."""

ANY_WAYS = ((0.35, -0.25, 0.45, 0.15, 0.5, -0.4, 0.3), (0.3, 0.4, -0.5, 0.25, 0.15, 0.45, -0.35))
ANY_TWIST = ((0.35, -0.25, 0.45), (0.15, 0.5, -0.4))
"""Any ways of the joints, and any twist: what is wanted of them is left of them."""

ASTRAY = (math.inf, math.inf, 2e-2, 1e-2, 5e-3, 2e-3)
"""Where so many steps leave a larger error of the pose, m or rad, the others lead nowhere; the last is for more."""

SMALLEST = 1e-12
"""A form that is flatter than this along a way, m or rad, has no posture that its slope tells."""

ALONE = 1e-14
"""A tip that is no farther past its pose than this, m or rad, meets it: rounding is some part of that."""

SAME = 1e-5
MOST_CENTRES = 32
"""Two postures of rank five are one if they are this close, rad; and how many are kept."""

MORE_TRIALS = 48
"""So many times what lies between two of them is tried."""

CENTRE = 8
BLUR = 7
"""A posture of rank five, and how far around it, rad, postures meet its pose as well as floats tell, if it is alone."""


@kernel
def times_twist(J, u, joint):
    """How far a joint moves the tip along a twist."""
    return dot(u[0], (J[0, joint], J[1, joint], J[2, joint])) + dot(u[1], (J[3, joint], J[4, joint], J[5, joint]))


@kernel
def second_order(J, u, x, y):
    """What two ways of the joints make together of the tip along a twist, but for what each makes: a bilinear form."""
    before_x = before_y = (0.0, 0.0, 0.0)
    linear = angular = (0.0, 0.0, 0.0)
    for j in range(7):
        v, w = (J[0, j], J[1, j], J[2, j]), (J[3, j], J[4, j], J[5, j])
        turned = along(scale(y[j], before_x), x[j], before_y)
        linear = add(linear, cross(along(turned, x[j] * y[j], w), v))
        angular = along(angular, 0.5, cross(turned, w))
        before_x, before_y = along(before_x, x[j], w), along(before_y, y[j], w)
    return dot(u[0], linear) + dot(u[1], angular)


@kernel
def lost_twist(J, u, A):
    """The twist along which the tip moves least, closer than one to start from."""
    shortest_step(J, u[0], u[1], 0, DAMPING, A)
    linear, angular = (A[0, 6], A[1, 6], A[2, 6]), (A[3, 6], A[4, 6], A[5, 6])
    size = math.sqrt(dot(linear, linear) + dot(angular, angular))
    return scale(1.0 / size, linear), scale(1.0 / size, angular)


@kernel
def but_for(u, linear, angular):
    """A twist but for what of it is along another one."""
    share = dot(u[0], linear) + dot(u[1], angular)
    return along(linear, -share, u[0]), along(angular, -share, u[1])


@kernel
def own_ways(J, u, A):
    """The two unit ways that keep the pose but along a twist, across each other, along which the form is simple.

    Returned with how much the form bends along each.
    """
    load_square(J, 0, DAMPING, A)
    for k in range(2):
        linear = angular = (0.0, 0.0, 0.0)
        for j in range(7):
            linear = along(linear, ANY_WAYS[k][j], (J[0, j], J[1, j], J[2, j]))
            angular = along(angular, ANY_WAYS[k][j], (J[3, j], J[4, j], J[5, j]))
        linear, angular = but_for(u, linear, angular)
        for i in range(3):
            A[i, 6 + k], A[i + 3, 6 + k] = linear[i], angular[i]
    solve_linear(A, 6)
    # What is left of any two ways.
    for k in range(2):
        answer = (A[0, 6 + k], A[1, 6 + k], A[2, 6 + k]), (A[3, 6 + k], A[4, 6 + k], A[5, 6 + k])
        for j in range(7):
            A[8 + k, j] = ANY_WAYS[k][j] - times_twist(J, answer, j)
    x, y = read7(row(A, 8)), read7(row(A, 9))
    x = along7(NO_SEED, 1.0 / math.sqrt(dot7(x, x)), x)
    y = along7(y, -dot7(x, y), x)
    y = along7(NO_SEED, 1.0 / math.sqrt(dot7(y, y)), y)
    xx, xy, yy = second_order(J, u, x, x), second_order(J, u, x, y), second_order(J, u, y, y)
    turn = 0.5 * math.atan2(2.0 * xy, xx - yy)
    c, s = math.cos(turn), math.sin(turn)
    ways = along7(along7(NO_SEED, c, x), s, y), along7(along7(NO_SEED, c, y), -s, x)
    return ways, (c * c * xx + 2.0 * c * s * xy + s * s * yy, s * s * xx - 2.0 * c * s * xy + c * c * yy)


@kernel
def squared_error(twist):
    """What is left to a pose, squared, m and rad alike."""
    return dot(twist[0], twist[0]) + dot(twist[1], twist[1])


@kernel
def steadily_closer(P, q, target, J, A):
    """Steps from a posture, each of which leaves less of the error, to one that meets its pose or next to it.

    Where several directions are as good as lost, others lead to farther postures of the pose, past a single one.
    """
    damping = STEADY_DAMPING
    twist = pose_step(P, q, target.R, target.p, J)
    for _ in range(STEADY_STEPS):
        if squared_error(twist) < NEXT_TO * NEXT_TO:
            break
        shortest_step(J, twist[0], twist[1], 0, damping, A)
        there = moved(q, A, 1.0)
        left = pose_step(P, there, target.R, target.p, J)
        if squared_error(left) < squared_error(twist):
            q, twist = there, left
            damping *= GENTLER
        else:
            damping *= STIFFER
            twist = pose_step(P, q, target.R, target.p, J)
    return q


@kernel
def to_rank_five(P, q, target, J, A):
    """Newton's method to the posture of rank five next to one: whether there is one, it, and its form.

    That is how far past its pose the tip is along the lost twist, and own ways with how much the form bends along them.
    """
    u = ANY_TWIST
    past = 0.0
    ways, bends = ANY_WAYS, (0.0, 0.0)
    linear, angular = pose_step(P, q, target.R, target.p, J)
    shortest_step(J, linear, angular, 0, FIRST_DAMPING, A)
    size = longest(A)
    q = moved(q, A, 1.0 if size < MAX_STEP else MAX_STEP / size)
    for i in range(MOST_STEPS):
        linear, angular = pose_step(P, q, target.R, target.p, J)
        if max(norm(linear), norm(angular)) > ASTRAY[min(i, len(ASTRAY) - 1)]:
            break
        for _ in range(2 if i == 0 else 1):
            u = lost_twist(J, u, A)
        ways, bends = own_ways(J, u, A)
        if not min(abs(bends[0]), abs(bends[1])) > SMALLEST:
            break
        rest = but_for(u, linear, angular)
        shortest_step(J, rest[0], rest[1], 0, DAMPING, A)
        step = moved(NO_SEED, A, 1.0)
        past = 0.5 * second_order(J, u, step, step) - dot(u[0], linear) - dot(u[1], angular)
        slopes = second_order(J, u, step, ways[0]), second_order(J, u, step, ways[1])
        for j in range(7):
            rate = times_twist(J, u, j)
            slopes = slopes[0] + rate * ways[0][j], slopes[1] + rate * ways[1][j]
        step = along7(along7(step, -slopes[0] / bends[0], ways[0]), -slopes[1] / bends[1], ways[1])
        last, size = size, largest(step)
        q = along7(q, 1.0 if size < MAX_STEP else MAX_STEP / size, step)
        if size < SETTLED:
            return True, q, past, ways, bends
        if i >= STEPS - 1 and size > SHRINKS * last:
            break
    return False, q, past, ways, bends


@kernel
def is_among(q, postures, n):
    """Whether a posture is one of the first n rows, but for whole turns."""
    found = False
    for i in range(n):
        found = found or largest(difference(q, read7(row(postures, i)))) < max(SAME, postures[i, BLUR])
    return found


@kernel
def put_amid(P, target, starts, first, n, alone, work):
    """Append postures of small closed curves next to those in rows first to n - 1; how many rows are in use then.

    And how many postures that are the only ones around are put into the rows of `alone`, with their blur.
    """
    J, A = work
    centres = np.zeros((MOST_CENTRES, CENTRE))
    trials = np.empty((n - first + MORE_TRIALS, CENTRE))
    for i in range(n - first):
        store7(row(trials, i), 0, read7(row(starts, first + i)))
    used, found, n_alone, last = n, 0, 0, n - first
    for i in range(trials.shape[0]):
        if i >= last:
            break
        met, q, past, ways, bends = to_rank_five(P, read7(row(trials, i)), target, J, A)
        if not met or is_among(q, centres, found):
            continue
        if found < MOST_CENTRES:
            for k in range(min(found, trials.shape[0] - last)):
                # Few steps lead to a small closed curve; it lies between two postures at which curves cross, or almost.
                store7(row(trials, last), 0, along7(q, 0.5, difference(q, read7(row(centres, k)))))
                last += 1
            store7(row(centres, found), 0, q)
            found += 1
        if not bends[0] * bends[1] > 0.0 or past * bends[0] > ALONE * abs(bends[0]):
            continue
        if abs(past) < ALONE:
            if n_alone < alone.shape[0]:
                store7(row(alone, n_alone), 0, q)
                alone[n_alone, BLUR] = math.sqrt(2.0 * ALONE / min(abs(bends[0]), abs(bends[1])))
                n_alone += 1
        elif used < starts.shape[0]:
            # Where the curve is closest it bends least.
            short = 0 if abs(bends[0]) > abs(bends[1]) else 1
            there = along7(q, math.sqrt(-2.0 * past / bends[short]), ways[short])
            store7(row(starts, used), 0, there)
            used += 1
    keep(centres)
    keep(trials)
    return used, n_alone
