"""Searches that start from the seed itself, before the grid: the posture nearest to it, or one to choose from.

Where joints are almost singular, the equations of a pose almost depend on each other, and a step that meets them leads
far away. So springs draw the seed to its pose: they give way there, and have a posture of least strain however singular
it is. They stiffen until a search ends what is left.

Where the axis of joint 7 is free, that joint makes the roll alone, and the others are nearest over arm angle and branch
at the roll that leaves joint 7 where the seed has it. With this roll held a pose has nothing free, and its nearest
posture of all is known: in other branches, too, and where the elbow of a near limb passes its limit to and fro.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, between, with_joint
from srs_ik.kernels.algebra.lanes import gather, scatter
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.freedom import allowed, free_error
from srs_ik.kernels.chain.kinematics import forward_kinematics
from srs_ik.kernels.exact.nearest import HARDLY, between_limbs
from srs_ik.kernels.freedom.constraints import NONE, THIN, equations, fill
from srs_ik.kernels.freedom.elimination import RHS
from srs_ik.kernels.freedom.nearest import searched
from srs_ik.kernels.freedom.settle import MAX_STEP, NO_FORCE, SHORTER, bounded_step, distance, settle
from srs_ik.kernels.freedom.starts import NONE_LEFT, is_loose
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.asked import Target
from srs_ik.kernels.layout.freedom import Found, Freedom
from srs_ik.kernels.layout.limb import FAR, IS_CLOSED, MISS, PHASE, SHOULDER, STRAIGHT, WRIST
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.in_line import closest, comes_in_line
from srs_ik.kernels.limb.limits import beyond, turn_to_middle
from srs_ik.kernels.limb.triangle import elbow_side, place
from srs_ik.kernels.pose.solve import best_posture

CLOSE = 0.15
CLEAR = 2.0
"""A posture this close to a seed, rad, is the nearest one if no joint is singular within so many times its distance."""

STIFF = (1e2, 1e4, 1e8)
"""What the square of a miss of the pose costs, m and rad, by squared radians of distance, one after the other."""

STEPS, SHORT = 4, 1e-3
"""Steps at most with each, and how short one is, rad, that is the last of them."""

TIGHT = 5e-3
"""Where two of these are so at once, rad, searches may pass over what is nearest: outer axes of the shoulder this close
to one line, or of the wrist, and an elbow bent by less. Or with an elbow this close to a limit, on exact limbs and
those with rounded figures, whose elbow passes it to and fro."""

ROUNDS, GAIN, AWAY = 4, 1e-6, 1e-3
"""Times that the roll follows joint 7, and the least that this is worth, squared rad. A joint 7 that the pose keeps
farther from the seed's, rad, makes the roll where it is, too: rounded figures may leave an elbow's limit no other."""


@kernel
def is_clear(P, q, way):
    """Whether no joint is singular within some times so far of a posture, rad."""
    s2 = abs(math.sin(q[1] - P[SHOULDER + PHASE]))
    s4 = abs(math.sin(q[3] - P[STRAIGHT]))
    s6 = abs(math.sin(q[5] - P[WRIST + PHASE]))
    return min(s2, s4, s6) > CLEAR * way + between_limbs(P)


@kernel
def strain(K, m):
    """Sum of squares of what m equations are missed by."""
    total = 0.0
    for r in range(m):
        total += K[7 + r, RHS] * K[7 + r, RHS]
    return total


@kernel
def add_springs(K, m, stiff):
    """Add what springs to m equations weigh to rows 0 to 6 of the system."""
    for i in range(7):
        here = gather(row(K, i), 0, 1)
        for r in range(m):
            share = stiff * K[7 + r, i]
            here = here + share * gather(row(K, 7 + r), 0, 1)
            K[i, RHS] += share * K[7 + r, RHS]
        scatter(row(K, i), 0, 1, here)


@kernel
def drawn(P, pose, freedom, liking, desk):
    """The posture to which springs draw a seed."""
    K = desk.system
    q = between(liking.posture, liking.lower, liking.upper)
    for stiff in STIFF:
        before, step, worth, size = q, NO_SEED, math.inf, math.inf
        for _ in range(STEPS):
            m, _, turns = equations(P, q, pose, freedom, NO_FORCE, desk)
            value = distance(q, liking) + stiff * strain(K, m)
            if value > worth:
                step = along7(NO_SEED, SHORTER, step)
                q = along7(before, 1.0, step)
                continue
            if size < SHORT:
                break
            fill(desk.J, K, q, liking, (NONE, NONE, turns[1]), (0.0, 1.0, 1.0))
            add_springs(K, m, stiff)
            step, _, _, _ = bounded_step(K, desk.copy, 0, q, (0, 0), liking)
            size = 0.0
            for j in range(7):
                size = max(size, abs(step[j]))
            step = along7(NO_SEED, min(1.0, MAX_STEP / max(size, MAX_STEP)), step)
            before, worth = q, value
            q = between(along7(q, 1.0, step), liking.lower, liking.upper)
    return q


@kernel
def lines_up(P, k, motion, width):
    """Whether the outer axes of a spherical joint come this close to one line at some arm angle."""
    one = comes_in_line(P, k, 0) and closest(P, k, motion, 0)[1] < width
    return one or (comes_in_line(P, k, 1) and closest(P, k, motion, 1)[1] < width)


@kernel
def hides_postures(P, pose):
    """Whether searches from a grid of arm angles, and from those where a joint is singular, may pass over postures.

    On exact limbs it takes little to be sure, where nothing is singular. Of two singular joints the elbow has to be one
    there: starts are the best splits of shoulder and wrist.
    """
    place_ = place(P, pose[0], pose[1])
    width = TIGHT + between_limbs(P)
    one, shoulder, wrist, _ = elbow_side(P, place_, 0)
    other, other_shoulder, other_wrist, _ = elbow_side(P, place_, 1)
    straight = abs(math.sin(one - P[STRAIGHT])) < width
    singular = 1 if straight else 0
    singular += 1 if lines_up(P, SHOULDER, shoulder, width) or lines_up(P, SHOULDER, other_shoulder, width) else 0
    singular += 1 if lines_up(P, WRIST, wrist, width) or lines_up(P, WRIST, other_wrist, width) else 0
    off, other_off = beyond(P, 3, turn_to_middle(P, 3, one)), beyond(P, 3, turn_to_middle(P, 3, other))
    on_limit = P[MISS] < HARDLY * P[FAR] and min(abs(off), abs(other_off)) < width
    if P[IS_CLOSED] == 1.0:
        return on_limit or singular == 0 or (straight and singular > 1)
    return on_limit or singular > 1


@kernel
def with_roll_held(family, P, pose, freedom, goal, liking, best, desk):
    """The nearest posture at rolls that leave joint 7 where the seed has it, and around it, or the best known one."""
    roll = Freedom(freedom.axis, 0.0)
    J, A = np.empty((6, 7)), np.empty((16, 9))
    seventh = min(max(liking.posture[6], liking.lower[6]), liking.upper[6])
    for _ in range(ROUNDS):
        x, y, z, _ = forward_kinematics(P, with_joint(best.q, 6, seventh))
        R = allowed(roll, (x, y, z), pose[0])
        q, _, value = best_posture(family, Target(R, pose[1], place(P, R, pose[1])), -1, goal, J, A)
        there, cost, error, _ = settle(P, q, pose, roll, liking, desk)
        if error < SOLVED and cost < value:
            q, value = there, cost
        gained = best.cost - value
        if value < OUTSIDE and gained > 0.0:
            best = Found(q, value, True)
        if value >= OUTSIDE or gained < GAIN:
            if abs(best.q[6] - seventh) < AWAY:
                break
            seventh = best.q[6]
    return best


@kernel
def from_seed(family, P, pose, freedom, goal, liking, desk):
    """The posture that searches from the seed lead to, if any; and whether it is so close that none is nearer."""
    off, turned = free_error(P, liking.posture, pose[0], pose[1], freedom)
    if max(off, turned) < SOLVED and between(liking.posture, liking.lower, liking.upper) == liking.posture:
        return Found(liking.posture, 0.0, True), True
    found = Found(liking.posture, NONE_LEFT, False)
    if max(off, turned) < CLOSE:
        q, cost, error, at_rest = settle(P, liking.posture, pose, freedom, liking, desk)
        if error < SOLVED:
            found = Found(q, cost, True)
            if at_rest and cost < CLOSE * CLOSE and is_clear(P, liking.posture, math.sqrt(cost)):
                return found, True
    q, cost, error, _ = searched(P, drawn(P, pose, freedom, liking, desk), pose, freedom, liking, desk)
    if error < SOLVED and cost < found.cost:
        found = Found(q, cost, True)
    if freedom.cone <= THIN and is_loose(P, freedom.axis) and hides_postures(P, pose):
        found = with_roll_held(family, P, pose, freedom, goal, liking, found, desk)
    return found, False
