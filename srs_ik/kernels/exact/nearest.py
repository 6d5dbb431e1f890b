"""The posture nearest to a seed, over all branches and arm angles.

A local search gives a posture at some distance D. A nearer one would have every joint within D of the seed: so the
exact intervals for limits tightened to that box hold all that can still be better, which is little or nothing.
"""

import math

from srs_ik.kernels.algebra.vectors import dot, load3, rotate
from srs_ik.kernels.chain.descent import slid, slide
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.chain.newton import CLOSED, clipped, close_free
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Goal
from srs_ik.kernels.layout.limb import A1, A2, A3, ACROSS_3, FAR, IS_CLOSED, MISS, PHASE, SHOULDER, WRIST
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of, is_unsure, side_posture, singular_sines
from srs_ik.kernels.limb.goal import OUTSIDE, cost, turned
from srs_ik.kernels.limb.triangle import elbow_side

NEWTON_STEPS = 12
"""Steps of a local search, at most."""

BETWEEN_LIMBS = 0.05
NEARNESS = 10.0
"""A near limb's joints are no farther from those of its nearest exact limb, rad, away from singularities: the former at
most, the latter for each part of its reach by which it misses."""

TURNS_AROUND = 2e-3
"""Where a curve turns around at a straight elbow, closer than this, rad, local searches may all end on one side."""

CLOSE = 0.1
"""The search across singularities is for seeds no farther than this from a posture, rad."""

VALLEY = 0.3
MOST_STARTS = 24
"""Local searches start this far apart in arm angle, rad; more of them than this are no better than to follow curves."""

MOST_LEVERAGE = 4.0
"""A seed farther from its nearest posture than so many times the pose error asks for a closer look."""

HARDLY = 1e-5
"""A limb that misses by less than this part of its reach is one with rounded figures."""


@kernel
def spherical_columns(P, k, q1, q2, q3):
    """R a3 and R ACROSS_3 of the spherical joint at block k at three angles."""
    a1, a2, a3 = load3(P, k + A1), load3(P, k + A2), load3(P, k + A3)
    c1, s1, c2, s2 = math.cos(q1), math.sin(q1), math.cos(q2), math.sin(q2)
    y = rotate(a3, math.cos(q3), math.sin(q3), load3(P, k + ACROSS_3))
    return rotate(a1, c1, s1, rotate(a2, c2, s2, a3)), rotate(a1, c1, s1, rotate(a2, c2, s2, y))


@kernel
def seed_angle(P, side, seed):
    """The arm angle at which shoulder and wrist are turned most like the seed's."""
    v, y = spherical_columns(P, SHOULDER, seed[0], seed[1], seed[2])
    circle_v, circle_y, _ = side[1]
    c = dot(v, circle_v[1]) + dot(y, circle_y[1])
    s = dot(v, circle_v[2]) + dot(y, circle_y[2])
    v, y = spherical_columns(P, WRIST, seed[4], seed[5], seed[6])
    circle_v, circle_y, _ = side[2]
    c += dot(v, circle_v[1]) + dot(y, circle_y[1])
    s += dot(v, circle_v[2]) + dot(y, circle_y[2])
    return math.atan2(s, c)


@kernel
def most_like(P, place_, seed, respect):
    """The posture of the exact limb whose shoulder and wrist are turned most like a seed's: q, cost."""
    best, lowest = seed, 4.0 * NO_BRANCH
    for elbow in range(2):
        side = elbow_side(P, place_, elbow)
        q, _, value = side_posture(P, side, seed_angle(P, side, seed), -1, -1, True, seed, respect)
        if value < lowest:
            best, lowest = q, value
    return best, lowest


@kernel
def settle_inside(P, target, q, goal, J, A):
    """From a posture to one inside the limits that closes, and from there to the nearest one around: q, cost."""
    q, error = close_free(P, clipped(P, q), target.R, target.p, True, 40, J, A)
    if error > CLOSED:
        return q, NO_BRANCH
    q, value, _ = slid(P, target, q, goal, J, A)
    return q, value


@kernel
def settled(P, target, q, goal, free_minimum, J, A):
    """A posture of the true chain in its best turn, or one inside the limits: q, cost, and whether it is a minimum."""
    q = turned(P, q, True, goal.seed, False)
    value = cost(P, q, True, goal.seed, goal.respect)
    if value < OUTSIDE:
        return q, value, free_minimum
    # The free minimum breaks a limit: any posture inside still bounds the distance, next to it or in another turn.
    other, value = settle_inside(P, target, q, goal, J, A)
    q = turned(P, q, True, goal.seed, True)
    elsewhere = cost(P, q, True, goal.seed, True)
    return (q, elsewhere, False) if elsewhere < value else (other, value, False)


@kernel
def settle_slowly(P, target, q, goal, J, A):
    """From a posture to one that closes, and from there to the nearest one around: q, cost, whether it is a minimum."""
    q, error = close_free(P, q, target.R, target.p, False, NEWTON_STEPS, J, A)
    if error > CLOSED:
        return q, NO_BRANCH, False
    q, _, minimum = slid(P, target, q, Goal(True, goal.seed, False), J, A)
    return settled(P, target, q, goal, minimum, J, A)


@kernel
def settle_near(P, target, q, goal, J, A):
    """From a posture to the nearest one around it on the true chain: q, cost, and whether it is a local minimum."""
    better, minimum = slide(P, target, q, Goal(True, goal.seed, False), J, A)
    if minimum:
        return settled(P, target, better, goal, True, J, A)
    return settle_slowly(P, target, q, goal, J, A)


@kernel
def between_limbs(P):
    """How far a posture may be from one of the nearest exact limb, rad, away from singularities."""
    return 1e-12 if P[IS_CLOSED] == 1.0 else min(BETWEEN_LIMBS, NEARNESS * P[MISS] / P[FAR])


@kernel
def is_alone(P, seed, lowest):
    """Whether a local minimum this near to a seed (squared distance) is the only one that near.

    Two postures of a pose no farther from the seed than D turn the upper arm by no more than 2 sqrt(3) D apart, and so
    are within that arm angle of each other; and they are of one branch if no middle angle of the seed is within D of
    where branches meet.
    """
    distance = math.sqrt(lowest)
    if 4.0 * math.sqrt(3.0) * distance > VALLEY:
        return False
    return min(singular_sines(P, seed)) > distance + between_limbs(P)


@kernel
def guess(P, target, goal, J, A):
    """A posture near a seed by local search on the true chain: q, cost, and whether it is a local minimum.

    From the seed itself, where that is close enough; else from the posture most like it. Next to a singularity the
    seed's own neighbourhood may hold a nearer one all the same, and where limits matter the seed put inside them.
    """
    seed = goal.seed
    q, minimum = slide(P, target, seed, Goal(True, seed, False), J, A)
    if minimum:
        q, lowest, minimum = settled(P, target, q, goal, True, J, A)
        if minimum:
            return q, lowest, True
    elif P[IS_CLOSED] == 1.0:
        q, lowest = most_like(P, target.place, seed, goal.respect)
        position, orientation = pose_error(P, seed, target.R, target.p)
        if lowest < (MOST_LEVERAGE * max(position / P[FAR], orientation)) ** 2:
            return q, lowest, False
        other, value, minimum = settle_slowly(P, target, seed, goal, J, A)
        if value < lowest:
            q, lowest = other, value
        else:
            minimum = False
    else:
        start = most_like(P, target.place, seed, False)[0] if P[MISS] < HARDLY * P[FAR] else seed
        q, lowest, minimum = settle_slowly(P, target, start, goal, J, A)
    if goal.respect and not minimum:
        other, value = settle_inside(P, target, seed, goal, J, A)
        if value < lowest:
            q, lowest = other, value
    return q, lowest, minimum


@kernel
def mirrored_angle(q, phase):
    """A middle angle on the other side of the singularity that it is nearest to."""
    twice = 2.0 * math.asin(math.sin(q - phase))
    return q - twice if math.cos(q - phase) > 0.0 else q + twice


@kernel
def look_across(P, target, found, minimum, goal, J, A):
    """Local searches on the true chain from a close seed, mirrored at the singularities that it is close to.

    Where the true chain's elbow is straight depends on all its joints. Two bends that are as close as what is known
    have it between them: so from either end of what is close, searches lead to either of them.
    `found` is the best posture so far, its branch and cost. Returns them, and whether all searches ended in minima:
    then they tell all, but for an elbow as good as straight.
    """
    q, best, lowest = found
    seed = goal.seed
    reach = math.sqrt(lowest) + between_limbs(P)
    s2, s4, s6 = singular_sines(P, seed)
    sure = minimum
    for sides in range(8):
        across_2, across_4, across_6 = sides & 1, sides & 2, sides & 4
        if (across_2 and s2 >= reach) or (across_4 and s4 >= reach) or (across_6 and s6 >= reach):
            continue
        bend = seed[3]
        if s4 < reach:
            bend += reach if across_4 else -reach
        start = (
            seed[0],
            mirrored_angle(seed[1], P[SHOULDER + PHASE]) if across_2 else seed[1],
            seed[2],
            bend,
            seed[4],
            mirrored_angle(seed[5], P[WRIST + PHASE]) if across_6 else seed[5],
            seed[6],
        )
        other, value, converged = settle_slowly(P, target, start, goal, J, A)
        sure = sure and converged
        if value < lowest:
            q, best, lowest = other, branch_of(P, other), value
        other, value, _ = settle_near(P, target, start, goal, J, A)
        if value < lowest:
            q, best, lowest = other, branch_of(P, other), value
    return (q, best, lowest), sure and s4 >= min(math.sqrt(lowest), TURNS_AROUND)


@kernel
def look_beside(P, target, found, known, goal, J, A):
    """Local searches on the true chain from the nearest exact limb's postures in the intervals of found.

    `known` is the best posture so far, its branch and cost. Returns them, and whether they tell all: not next to a
    singularity, where the true postures are elsewhere.
    """
    R, p, place_ = target
    q, best, lowest = known
    _, seed, respect = goal
    n = found.shape[0]
    starts = 0
    for i in range(n):
        starts += math.ceil((found[i, 2] - found[i, 1]) / VALLEY)
    if starts > MOST_STARTS or is_unsure(P, q):
        return known, False
    for i in range(n):
        branch = int(found[i, 0])
        side = elbow_side(P, place_, branch >> 2)
        width = found[i, 2] - found[i, 1]
        count = max(math.ceil(width / VALLEY), 1)
        for k in range(count):
            psi = found[i, 1] + width * (k + 0.5) / count
            start, _, value = side_posture(P, side, psi, (branch >> 1) & 1, branch & 1, True, seed, False)
            if value >= NO_BRANCH or is_unsure(P, start):
                return (q, best, lowest), False
            start, error = close_free(P, start, R, p, False, NEWTON_STEPS, J, A)
            other, minimum = slide(P, target, start, Goal(True, seed, False), J, A)
            if error > CLOSED or not minimum:
                return (q, best, lowest), False
            other = turned(P, other, True, seed, False)
            if cost(P, other, True, seed, False) >= lowest:
                continue
            value = cost(P, other, True, seed, respect)
            if value >= OUTSIDE:
                # The nearest posture of this valley may be on a limit.
                return (q, best, lowest), False
            q, best, lowest = other, branch_of(P, other), value
    return (q, best, lowest), True
