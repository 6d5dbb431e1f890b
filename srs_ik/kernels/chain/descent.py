"""From a configuration of a pose to the one nearest to a seed around it, on the true chain.

Steps of Gauss and Newton end there in a few, where nothing is singular and limits are no matter (`slid`). Steps that
each have to gain something (`descend`) go on where those do not: along limits, next to singularities, and where a
curve of configurations turns around in a needle whose sides floats hardly tell apart.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import along7, dot7, store7
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import along, norm, sub
from srs_ik.kernels.chain import newton
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import IS_NEAR, LOWER, UPPER
from srs_ik.kernels.limb.goal import NO_SEED, cost

NEWTON_STEPS = 12
SLIDE_STEPS = 30
SLID = 1e-11
"""Steps on the true chain, and the size of the last one, rad."""

STRAIGHT_ON = 1e-3
MOST_SHARE = 2.0
"""Below this error of the pose (m, rad) the steps are corrected, and by this factor at most."""

TRIALS, SHORTER = 16, 0.25
"""How often a step that has to gain is made shorter, and by how much."""

LOST = (1e-8, 1e-14)
"""Directions of the tip that other joints leave less of than this count as lost: first those in which floats hardly
tell a step, then those in which they tell nothing."""

FULL_STEPS = 8
"""Steps without damping, each of which leaves less of an error that gentle steps have left."""

QUICK = (24, 1e-5)
THOROUGH = (100, 1e-10)
"""So many of these steps at most, each of which has to gain this part of the squared distance."""


@kernel
def slide(P, target, q, goal, J, A):
    """Gauss-Newton on the true chain to the posture nearest to a seed, from one close to it: q, converged.

    Each step closes the pose to first order and goes towards the seed as far as the pose allows; a joint that would
    leave its limits stays on the limit. How far to go is corrected by the last two steps (a secant): where the curve of
    postures is bent as much as the seed is far, the plain steps would swing around the nearest posture.
    """
    R, p, _ = target
    seed = goal.seed
    blocked = 0
    size = 1.0
    share = 1.0
    way = NO_SEED
    square = 0.0
    for _ in range(SLIDE_STEPS):
        linear, angular = newton.pose_step(P, q, R, p, J)
        error = max(norm(linear), norm(angular))
        if size < SLID and error < newton.CLOSED:
            return q, True
        wish = (0.0, 0.0, 0.0)
        turn_wish = (0.0, 0.0, 0.0)
        for j in range(7):
            d = 0.0 if (blocked >> j) & 1 else seed[j] - q[j]
            wish = along(wish, d, (J[0, j], J[1, j], J[2, j]))
            turn_wish = along(turn_wish, d, (J[3, j], J[4, j], J[5, j]))
        newton.shortest_step(J, sub(linear, wish), sub(angular, turn_wish), blocked, 0.0, A)
        for j in range(7):
            if not (blocked >> j) & 1:
                A[j, 7] += seed[j] - q[j]
        size = newton.longest(A)
        if size > newton.MAX_STEP:
            return q, False
        step = newton.moved(NO_SEED, A, 1.0)
        change = square - dot7(way, step)
        share = min(share * square / change, MOST_SHARE) if error < STRAIGHT_ON and change > 0.0 else 1.0
        way, square = step, dot7(step, step)
        q = newton.moved(q, A, share)
        if goal.respect:
            for j in range(7):
                if q[j] < P[LOWER + j] or q[j] > P[UPPER + j]:
                    blocked |= 1 << j
                    square = 0.0
            q = newton.clipped(P, q)
    return q, False


@kernel
def slid(P, target, q, goal, J, A):
    """A posture, or the nearer one that it slides to on the true chain: q, cost, and whether that is a minimum."""
    lowest = cost(P, q, True, goal.seed, goal.respect)
    nearer, converged = slide(P, target, q, goal, J, A)
    if not converged:
        nearer, error = newton.close_free(P, nearer, target.R, target.p, goal.respect, NEWTON_STEPS, J, A)
        if error > newton.CLOSED:
            return q, lowest, False
    value = cost(P, nearer, True, goal.seed, goal.respect)
    if value < lowest:
        return nearer, value, converged
    return q, lowest, False


@kernel
def keeping_pose(J, way, lost):
    """What of a way keeps the pose, to first order, by the method of Gram and Schmidt; J is used up.

    Directions of the tip that are lost but for a part do not count.
    """
    for i in range(6):
        most, longest_row = -1.0, i
        for k in range(i, 6):
            rest = read7(row(J, k))
            if dot7(rest, rest) > most:
                most, longest_row = dot7(rest, rest), k
        if most <= lost * lost:
            break
        unit = along7(NO_SEED, 1.0 / math.sqrt(most), read7(row(J, longest_row)))
        store7(row(J, longest_row), 0, read7(row(J, i)))
        # Twice each: the second time takes out what rounding has left.
        for k in range(i + 1, 6):
            rest = read7(row(J, k))
            rest = along7(rest, -dot7(unit, rest), unit)
            store7(row(J, k), 0, along7(rest, -dot7(unit, rest), unit))
        way = along7(way, -dot7(unit, way), unit)
        way = along7(way, -dot7(unit, way), unit)
    return way


@kernel
def toward_seed(P, q, target, goal, lost, J):
    """The way from a posture to the seed, as far as it keeps the pose and the limits, to first order."""
    blocked = 0
    way = NO_SEED
    for _ in range(7):
        newton.pose_step(P, q, target.R, target.p, J)
        for i in range(6):
            store7(row(J, i), 0, newton.with_zeros(read7(row(J, i)), blocked))
        way = keeping_pose(J, newton.with_zeros(along7(goal.seed, -1.0, q), blocked), lost)
        again = blocked
        for j in range(7 if goal.respect else 0):
            if (q[j] <= P[LOWER + j] and way[j] < 0.0) or (q[j] >= P[UPPER + j] and way[j] > 0.0):
                again |= 1 << j
        if again == blocked:
            break
        blocked = again
    return way


@kernel
def close_fully(P, q, error, target, respect, J, A):
    """Steps without damping from a posture that is closed, as long as each leaves less of the error: q, error.

    Gentle steps leave what of an error is along directions that are as good as lost. From one step along the postures
    to the next that adds up, to far more than the joints that it is worth, until none is closed any more.
    """
    blocked = 0
    for _ in range(FULL_STEPS):
        if error < newton.ROUNDING:
            break
        linear, angular = newton.pose_step(P, q, target.R, target.p, J)
        newton.shortest_step(J, linear, angular, blocked, 0.0, A)
        there = newton.moved(q, A, 1.0)
        again = blocked
        for j in range(7 if respect else 0):
            if there[j] < P[LOWER + j] or there[j] > P[UPPER + j]:
                again |= 1 << j
        if again != blocked:
            blocked = again
            continue
        left = max(*pose_error(P, there, target.R, target.p))
        if left > newton.STALLED * error:
            break
        q, error = there, left
    return q, error


@kernel
def descend(P, q, target, goal, least, work):
    """Steps from a posture to the one nearest to a seed around: q, cost.

    `least` is the number of steps and the part of the squared distance that each has to gain. None leaves more of an
    error than the posture has itself, but for what is closed: an exact limb's own postures leave less than others.
    """
    J, A = work
    steps, gain = least
    position, orientation = pose_error(P, q, target.R, target.p)
    most = max(newton.CLOSED if P[IS_NEAR] != 0.0 else 0.1 * newton.CLOSED, position, orientation)
    lowest = cost(P, q, True, goal.seed, goal.respect)
    size = 1.0
    kind = 0
    for _ in range(steps):
        way = toward_seed(P, q, target, goal, LOST[kind], J)
        long = dot7(way, way)
        gained = 0.0
        for _ in range(TRIALS):
            if size * long < gain * lowest:
                break
            there = along7(q, size, way)
            if goal.respect:
                there = newton.clipped(P, there)
            there, error = newton.close_gently(P, there, target.R, target.p, goal.respect, J, A)
            if error <= most:
                there, error = close_fully(P, there, error, target, goal.respect, J, A)
            value = cost(P, there, True, goal.seed, goal.respect)
            if error <= most and value < (1.0 - gain) * lowest:
                gained = lowest - value
                q, lowest = there, value
                break
            size *= SHORTER
        size = min(2.0 * size, 1.0)
        if gained == 0.0:
            kind, size = kind + 1, 1.0
            if kind == len(LOST):
                break
    return q, lowest
