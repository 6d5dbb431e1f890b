"""From a configuration of a pose to the one nearest to a seed around it, on the true chain.

Steps of Gauss and Newton end there in a few, where nothing is singular and limits are no matter (`slid`). Steps that
each have to gain something (`descend`) go on where those do not: along limits, next to singularities, and where a
curve of configurations turns around in a needle whose sides floats hardly tell apart.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import along7, dot7, largest, store7, with_joint
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

SMALL = 1e-2
"""Where a step of the first kind gains less than this part of what a whole one promises, the second kind follows."""

ON_LIMIT = 1e-8
"""Joints this close to a limit, rad, are on it: what closes a posture takes them off by less."""

FULL_STEPS = 9
"""Postures, the first one included, to which steps without damping lead that take out what gentle ones have left."""

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
def closest_way(J, way, lost, A):
    """The way closest to one that moves the tip by the twist in column 6 of A, to first order; J and it are used up.

    By the method of Gram and Schmidt. Directions of the tip that are lost but for a part do not count.
    """
    for i in range(6):
        most, longest_row = -1.0, i
        for k in range(i, 6):
            rest = read7(row(J, k))
            if dot7(rest, rest) > most:
                most, longest_row = dot7(rest, rest), k
        if most <= lost * lost:
            break
        size = math.sqrt(most)
        unit, along_unit = along7(NO_SEED, 1.0 / size, read7(row(J, longest_row))), A[longest_row, 6] / size
        store7(row(J, longest_row), 0, read7(row(J, i)))
        A[longest_row, 6] = A[i, 6]
        # Twice each: the second time takes out what rounding has left.
        for k in range(i + 1, 6):
            for _ in range(2):
                rest = read7(row(J, k))
                part = dot7(unit, rest)
                store7(row(J, k), 0, along7(rest, -part, unit))
                A[k, 6] -= part * along_unit
        for _ in range(2):
            way = along7(way, along_unit - dot7(unit, way), unit)
    return way


@kernel
def hold(J, blocked):
    """Joints in the bit set `blocked` move the tip no more."""
    for i in range(6 if blocked != 0 else 0):
        store7(row(J, i), 0, newton.with_zeros(read7(row(J, i)), blocked))


@kernel
def toward_seed(P, q, target, goal, lost, J, A):
    """The way from a posture to the seed, as far as it keeps the pose and the limits, to first order.

    Joints that are on limits but for what closing has taken them off go all the way: next to singularities that matters
    to the others, and where they went beyond and were clipped each step would have to be small.
    """
    blocked = 0
    way = onto = NO_SEED
    for _ in range(7):
        newton.pose_step(P, q, target.R, target.p, J)
        for i in range(6):
            A[i, 6] = -dot7(onto, row(J, i))
        hold(J, blocked)
        way = closest_way(J, newton.with_zeros(along7(goal.seed, -1.0, q), blocked), lost, A)
        again = blocked
        for j in range(7 if goal.respect else 0):
            end = P[LOWER + j] if way[j] < 0.0 else P[UPPER + j]
            if way[j] * (end - q[j]) <= abs(way[j]) * ON_LIMIT and way[j] != 0.0:
                again |= 1 << j
                onto = with_joint(onto, j, end - q[j])
        if again == blocked:
            break
        blocked = again
    return along7(way, 1.0, onto)


@kernel
def close_fully(P, q, target, respect, J, A):
    """Shortest steps without damping from a posture that is closed: the one with the least error, and that error.

    Gentle steps leave what of an error is along directions that are as good as lost. From one step along the postures
    to the next that adds up, to far more than the joints that it is worth, until none is closed any more. The first
    step along such a direction may leave more than there was, of second order; each of the others has to leave less.
    """
    blocked = 0
    best, least = q, math.inf
    first, most = True, math.inf
    for _ in range(FULL_STEPS):
        linear, angular = newton.pose_step(P, q, target.R, target.p, J)
        error = max(norm(linear), norm(angular))
        if error < least:
            best, least = q, error
        if error < newton.ROUNDING or error > most:
            break
        hold(J, blocked)
        newton.put_twist(linear, angular, A)
        step = closest_way(J, NO_SEED, LOST[1], A)
        if largest(step) > newton.MAX_STEP:
            break
        there = along7(q, 1.0, step)
        again = blocked
        for j in range(7 if respect else 0):
            if there[j] < P[LOWER + j] or there[j] > P[UPPER + j]:
                again |= 1 << j
        if again == blocked:
            q = there
            first, most = False, math.inf if first else newton.STALLED * error
        else:
            blocked, first, most = again, True, math.inf
    return best, least


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
        way = toward_seed(P, q, target, goal, LOST[kind], J, A)
        long = dot7(way, way)
        gained = 0.0
        for _ in range(TRIALS):
            if size * long < gain * lowest:
                break
            there = along7(q, size, way)
            if goal.respect:
                there = newton.clipped(P, there)
            there, error = newton.close_gently(P, there, target.R, target.p, goal.respect, J, A)
            if error <= newton.LEFT:
                there, error = close_fully(P, there, target, goal.respect, J, A)
            value = cost(P, there, True, goal.seed, goal.respect)
            if error <= most and value < (1.0 - gain) * lowest:
                gained = lowest - value
                q, lowest = there, value
                break
            size *= SHORTER
        size = min(2.0 * size, 1.0)
        if gained == 0.0 or (kind == 0 and gained < SMALL * long):
            kind, size = kind + 1, 1.0
            if kind == len(LOST):
                break
    return q, lowest
