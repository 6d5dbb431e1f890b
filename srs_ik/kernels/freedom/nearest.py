"""The posture nearest to a seed over all turns that a pose leaves free, all branches and all arm angles.

Local searches on the true chain start from a grid (`starts`), the best of it first; what lies next to a start that was
taken is left out.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7, between, with_joint
from srs_ik.kernels.algebra.lanes import eight_of, gather, one_of, where
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.freedom import as_rotation, free_error
from srs_ik.kernels.chain.kinematics import forward_kinematics
from srs_ik.kernels.freedom.constraints import THIN, equations
from srs_ik.kernels.freedom.elimination import GIVES, RHS, ROOM_ROW, SOFT
from srs_ik.kernels.freedom.settle import (
    HELD_BACK,
    NO_FORCE,
    at_limits,
    bounded_step,
    distance,
    led_to,
    onto_pose,
    settle,
)
from srs_ik.kernels.freedom.starts import APART, NO_NEARER, NONE_LEFT, change_places, line_up, take_next
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.freedom import MOST_TAKEN, START_COST, START_LATE, Found, Freedom, Liking
from srs_ik.kernels.layout.limb import STRAIGHT
from srs_ik.kernels.limb.branches import phase_of
from srs_ik.kernels.limb.goal import turned
from srs_ik.kernels.limb.spherical import mirrored

ALMOST = 0.01
"""A search that ends this close to its pose, m and rad, goes on, or is brought onto it."""

STRAIGHTER, SLUGGISH = 8, 1e-6
"""Steps that turn an axis to the middle of its cone, and what motions cost there, by the square of what it leans."""

FEW = 8
"""Of more searches than these, those are left out whose starts, once inside the limits, are too far from the seed."""

OUTSIDE, WIDELY = 1.5, 1.0
"""Searches that come last. Postures that are pressed between limits may have starts outside these alone: a radian
outside costs no more than it may take to come inside, and what lies within so much, rad, of starts that were taken is
left out."""

OFF_LIMIT = 1.0
"""So far from its limit, rad, a joint of the best posture starts again: another joint may be the one to be held."""

BARELY_BENT = 0.3
"""Where the elbow of the best posture is bent by less, rad, a search starts with it bent as far to the other side: what
is nearest there is almost as near, and too close to be a start of its own."""

DISTANT, BENT_OVER = 2.75, 1.5
"""Where the best posture is farther from the seed, rad, joints 2, 4 and 6 each start again so far to either side of it,
rad: limits may hide a nearer one of another branch from all starts of the grid."""


@kernel
def searched(P, start, pose, freedom, rival, desk):
    """`settle`, and once more where it ends close to its pose; from there at least onto that, or onto a roll in it."""
    there, cost, error, at_rest = settle(P, start, pose, freedom, rival, desk)
    if SOLVED <= error < ALMOST:
        there, cost, error, at_rest = settle(P, there, pose, freedom, rival, desk)
    if SOLVED <= error < ALMOST:
        if freedom.cone <= THIN:
            return within_thin_cone(P, there, pose, freedom, rival, desk)
        there, error = onto_pose(P, there, pose, freedom, rival, desk)
        cost = distance(there, rival)
    return there, cost, error, at_rest


@kernel
def straightened(P, q, pose, freedom, liking, desk):
    """The posture around one, on the place of its pose, whose axis leans least that limits allow."""
    K = desk.system
    K[ROOM_ROW, RHS], K[ROOM_ROW, GIVES] = HELD_BACK, SOFT
    for _ in range(STRAIGHTER):
        equations(P, q, pose, Freedom(freedom.axis, 0.0), NO_FORCE, desk)
        for i in range(7):
            for j in range(7):
                K[i, j] = K[10, i] * K[10, j] + K[11, i] * K[11, j]
            K[i, i] += SLUGGISH
            K[i, RHS] = K[10, i] * K[10, RHS] + K[11, i] * K[11, RHS]
        step, _, _, _ = bounded_step(K, desk.copy, 3, q, (0, 0), liking)
        q = between(along7(q, 1.0, step), liking.lower, liking.upper)
    return q


@kernel
def within_thin_cone(P, q, pose, freedom, rival, desk):
    """`settle` with the axis at the middle of a thin cone, or, where limits keep it from that, where it leans least."""
    there, cost, error, at_rest = settle(P, q, pose, Freedom(freedom.axis, 0.0), rival, desk)
    if SOLVED <= error < ALMOST:
        placed = straightened(P, there, pose, freedom, rival, desk)
        off, rest = free_error(P, placed, pose[0], pose[1], freedom)
        if max(off, rest) < SOLVED:
            x, y, z, _ = forward_kinematics(P, placed)
            turned_there = as_rotation((x, y, z)), pose[1]
            there, cost, error, at_rest = settle(P, placed, turned_there, Freedom(freedom.axis, 0.0), rival, desk)
            if error < SOLVED:
                return there, cost, error, at_rest
            return placed, distance(placed, rival), max(off, rest), at_rest
    return there, cost, error, at_rest


@kernel
def as_eight(q, last):
    """Seven figures as eight lanes."""
    return eight_of(q[0], q[1], q[2], q[3], q[4], q[5], q[6], last)


@kernel
def write_late(starts, n, liking, most):
    """Write what n starts cost late searches, those of a cost up to `most` first; return how many these are."""
    wish, weights = as_eight(liking.posture, 0.0), as_eight(liking.weights, 0.0)
    low, high = as_eight(liking.lower, -math.inf), as_eight(liking.upper, math.inf)
    kept = 0
    for i in range(n):
        q = gather(row(starts, i), 0, 1)
        there = where(q < low, low, where(q > high, high, q))
        each = weights * (there - wish) * (there - wish) + OUTSIDE * abs(q - there)
        cost = 0.0
        for j in range(7):
            cost += one_of(each, j)
        if cost < most:
            change_places(starts, kept, i)
            starts[kept, START_LATE] = cost
            kept += 1
    return kept


@kernel
def search(P, pose, freedom, liking, sizes, order, found, desk):
    """The nearest posture that searches from so many starts lead to, or a known one.

    Args:
        P: packed limb.
        pose: rotation and position.
        freedom: what the pose leaves free.
        liking: what is nearest, and the limits.
        sizes: how many starts there are, searches at most once a posture is known and where none is, and starts that
            are taken already.
        order: column of the costs of starts, how far starts are apart, how much nearer searches come than these, and
            how much nearer than starts that are inside the limits.
        found: the posture that is known.
        desk: work space.

    Returns:
        It; what is nearest, with that as a rival of later searches; how many starts were taken.
    """
    count, enough, most, taken = sizes
    column, width, nearer, shorter = order
    attempts = 0
    line_up(desk.starts, count, column)
    while attempts < (enough if found.met else most) and taken < MOST_TAKEN:
        start, least, count = take_next(desk.starts, count, taken, column, width)
        reached = math.sqrt(found.cost)
        if least >= NONE_LEFT or math.sqrt(least) > reached + nearer:
            break
        start = between(start, liking.lower, liking.upper)
        if found.met and attempts >= FEW and math.sqrt(distance(start, liking)) > reached + shorter:
            taken += 1
            continue
        rival = Liking(liking.posture, liking.weights, liking.lower, liking.upper, found.cost, liking.rival_posture)
        there, cost, error, _ = searched(P, start, pose, freedom, rival, desk)
        if error < SOLVED and cost < found.cost:
            found, liking = Found(there, cost, True), led_to(liking, there)
        attempts += 1
        taken += 1
    return found, liking, taken


@kernel
def nearest(P, pose, freedom, liking, sizes, found, desk):
    """The nearest posture that searches from starts in `desk` lead to, or the one that is known.

    Sizes are how many starts there are; searches at most once a posture is known, those that come late, and how much
    nearer than starts inside the limits these come; and searches where none is known.
    """
    count, (enough, late, shorter), most = sizes
    first = START_COST, APART, NO_NEARER, shorter
    found, liking, taken = search(P, pose, freedom, liking, (count, enough, most, 0), first, found, desk)
    if found.met:
        count = write_late(desk.starts, count, liking, (math.sqrt(found.cost) + shorter) ** 2)
        last = START_LATE, WIDELY, shorter, shorter
        found, _, _ = search(P, pose, freedom, liking, (count, late, late, taken), last, found, desk)
    return found


@kernel
def nearer_from(P, pose, freedom, liking, start, found, desk):
    """The posture that a search from a start leads to, if it is nearer than the one that is known, or that one."""
    rival = Liking(liking.posture, liking.weights, liking.lower, liking.upper, found.cost, found.q)
    there, cost, error, _ = settle(P, start, pose, freedom, rival, desk)
    return Found(there, cost, True) if error < SOLVED and cost < found.cost else found


@kernel
def once_more(P, pose, freedom, liking, found, desk):
    """The nearest posture that searches lead to from the best one, each with a joint moved, or that one.

    Which limits hold a posture is a choice, and so is its branch. Another one may be nearer, behind a rise that no
    descent passes.
    """
    best, held = found.q, at_limits(found.q, liking)
    for j in range(7):
        if (held >> j) & 1 == 1:
            off = OFF_LIMIT if best[j] - liking.lower[j] < liking.upper[j] - best[j] else -OFF_LIMIT
            found = nearer_from(P, pose, freedom, liking, with_joint(best, j, best[j] + off), found, desk)
    bend = best[3] - P[STRAIGHT]
    if abs(bend) < BARELY_BENT:
        found = nearer_from(P, pose, freedom, liking, with_joint(best, 3, best[3] - 2.0 * bend), found, desk)
    if found.cost > DISTANT * DISTANT:
        best = found.q
        for j in range(1, 7, 2):
            found = nearer_from(P, pose, freedom, liking, with_joint(best, j, best[j] + BENT_OVER), found, desk)
            found = nearer_from(P, pose, freedom, liking, with_joint(best, j, best[j] - BENT_OVER), found, desk)
    return found


@kernel
def on_other_side(P, q, middle):
    """A posture with a middle joint on the other side: in the same pose, where neighbouring axes are perpendicular."""
    j = 2 * middle
    before, own, behind = mirrored(phase_of(P, middle), (q[j], q[j + 1], q[j + 2]))
    return with_joint(with_joint(with_joint(q, j, before), j + 1, own), j + 2, behind)


@kernel
def in_other_branches(P, pose, freedom, liking, found, desk):
    """The nearest posture that searches lead to from the best one's own in the seven other branches, or that one."""
    best = found.q
    for other in range(1, 8):
        q = best
        for middle in range(3):
            if (other >> middle) & 1 == 1:
                q = on_other_side(P, q, middle)
        start = between(turned(P, q, True, liking.posture, True), liking.lower, liking.upper)
        if math.sqrt(distance(start, liking)) < math.sqrt(found.cost) + NO_NEARER:
            found = nearer_from(P, pose, freedom, liking, start, found, desk)
    return found
