"""Postures at an arm angle, also of a near limb where Newton's method from the closed form does not lead to them.

Next to a singularity a branch may have several postures at one arm angle, or none. All of them lie where the curves
that `follow` follows pass the arm angle.
"""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.chain.starts import FIRST, best_of_all, close_all
from srs_ik.kernels.curves.surface import has_surface
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import ROW_COST
from srs_ik.kernels.layout.asked import Best, Goal
from srs_ik.kernels.layout.limb import COSINE_OFF, FAR, MISS, NEAR, SHIFT
from srs_ik.kernels.limb.branches import NO_BRANCH, best_branch, branch_of, is_on_border, is_unsure
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.in_line import ROUNDED
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.near.band import ALMOST_NOTHING, is_oblique, is_told
from srs_ik.kernels.near.branch_search import search_branch
from srs_ik.kernels.near.on_curves import (
    SAME_ANGLE,
    best_found,
    best_on_curves,
    find_at_angle,
    followed_curves,
    setting_of,
)
from srs_ik.kernels.near.second_attempts import ATTEMPTS, STRETCHED, evaluate_again, is_near_line, stretched

AT_SEED = 1e-12
"""A posture this close to a seed, rad squared, is the nearest one."""

REACH_SLACK = 8.0
BEND_SLACK = 2.0
"""A near limb reaches no farther than its nearest exact limb and so many times its largest miss, nor than the cosine of
the elbow's bend may be off: over 10^5 straight elbows of a limb, it is off by up to 1.3 times what is packed."""

ROUNDING = 1e-9
"""Of the reach."""

BESIDE = (0.0, 0.5 * SAME_ANGLE, -0.5 * SAME_ANGLE)
"""Where else a branch is looked for that ends at an arm angle, rad."""

ON_LINE = 1e-3
"""The elbow of a limb that misses by more than this part of its reach does not come to lie on the line S-W."""


@kernel
def may_reach(P, place_):
    """Whether a pose is not so far out of reach that a near limb cannot have a posture for it."""
    miss = place_[5]
    if miss == 0.0:
        return True
    if abs(miss) > REACH_SLACK * P[MISS] + ROUNDING * P[FAR]:
        return False
    # By how much the cosine of the bend would have to be larger than 1, or smaller than -1.
    edge = P[FAR] if miss > 0.0 else P[NEAR]
    beyond = 2.0 * miss * (2.0 * edge + miss) / ((P[FAR] - P[NEAR]) * (P[FAR] + P[NEAR]))
    return abs(beyond) <= BEND_SLACK * P[COSINE_OFF] + ROUNDING


@kernel
def is_crowded(P):
    """Whether a branch may have two postures at an arm angle also away from singularities: oblique axes that miss."""
    return is_oblique(P) and P[SHIFT] > ALMOST_NOTHING


@kernel
def may_have_others(P, target, psi, q):
    """Whether there may be other postures than one at its arm angle, in its branch or next to it."""
    return is_unsure(P, q) and not is_told(P, target.place, psi)


@kernel
def settle_branch(P, target, psi, branch, best, goal, A):
    """A second look at a branch that has no posture yet, or one outside its limits: the best, whether it is final."""
    q, lowest = best
    crowded = is_crowded(P)
    alone = lowest < NO_BRANCH and not crowded and not may_have_others(P, target, psi, q)
    if lowest < OUTSIDE or alone or not may_reach(P, target.place):
        return best, True
    other, complete = search_branch(P, target, psi, branch, goal, A)
    if other.cost < lowest:
        best = other
    return best, best.cost < OUTSIDE or (complete and not crowded)


@kernel
def settle_all(P, target, psi, goal, found, A):
    """A second look at every branch that `close_all` has left in A, into rows of found (8, 8): whether it is final."""
    for branch in range(8):
        for i in range(8):
            found[branch, i] = A[FIRST + branch, i]
    final = True
    for branch in range(8):
        best = Best(read7(found[branch]), found[branch, ROW_COST])
        best, settled = settle_branch(P, target, psi, branch, best, goal, A)
        final = final and settled
        for i in range(7):
            found[branch, i] = best.q[i]
        found[branch, ROW_COST] = best.cost
    return final


@kernel
def put_better(other, found):
    """Take over the rows of `other` (8, 8), a branch each, that are better than those found so far."""
    for branch in range(8):
        if other[branch, ROW_COST] < found[branch, ROW_COST]:
            for i in range(8):
                found[branch, i] = other[branch, i]


@kernel
def on_border(P, found, wanted, goal):
    """The best of other branches' postures, rows of found (8, 8), on the border of one: q, branch, cost."""
    best = Best(goal.seed, 2.0 * NO_BRANCH)
    for branch in range(8):
        if branch != wanted and found[branch, ROW_COST] < best.cost:
            q = read7(found[branch])
            if is_on_border(P, q, wanted):
                best = Best(q, found[branch, ROW_COST])
    return best.q, wanted, best.cost


@kernel
def put_found(q, value, out):
    """Write a posture and its cost into a row."""
    for j in range(7):
        out[j] = q[j]
    out[ROW_COST] = value


@kernel
def put_borders(P, goal, found):
    """Give branches without a posture inside the limits one of another branch on their border, in rows of found."""
    taken = np.empty((8, 8))
    for branch in range(8):
        taken[branch, ROW_COST] = 2.0 * NO_BRANCH
        if found[branch, ROW_COST] >= OUTSIDE:
            q, _, value = on_border(P, found, branch, goal)
            put_found(q, value, taken[branch])
    put_better(taken, found)


@kernel
def highest_cost(found):
    """The largest cost of a branch, in rows of found (8, 8)."""
    highest = found[0, ROW_COST]
    for branch in range(1, 8):
        highest = max(highest, found[branch, ROW_COST])
    return highest


@kernel
def solve_all_at_angle(P, target, psi, respect, J, A, found):
    """The posture of every branch at an arm angle, and its cost, into the rows of found (8, 8)."""
    goal = Goal(False, NO_SEED, respect)
    close_all(P, target, psi, -1, goal, A)
    final = settle_all(P, target, psi, goal, found, A)
    highest, reached = highest_cost(found), may_reach(P, target.place)
    ends = highest >= NO_BRANCH and reached and not is_told(P, target.place, psi)
    if ends or not final or (highest >= OUTSIDE and reached and has_surface(P, target.place)):
        other = np.empty((8, 8))
        by = setting_of(P, target, J, A)
        followed = followed_curves(P, by)
        for side in range(3 if highest >= OUTSIDE else 1):
            find_at_angle(P, by, followed, psi + BESIDE[side], -1, goal, other)
            put_better(other, found)
        put_borders(P, goal, found)
        for branch in range(8):
            # The curves of an almost exact limb are not the only postures there: it has surfaces of them.
            if P[MISS] < ROUNDED * P[FAR] and OUTSIDE <= found[branch, ROW_COST] < NO_BRANCH:
                q, value = evaluate_again(P, target, psi, branch, goal, 1, A)
                if value < OUTSIDE:
                    put_found(q, value, found[branch])


@kernel
def settle_at_angle(P, target, psi, wanted, goal, A):
    """Best posture at an arm angle over all branches, or in one (0 to 7), by Newton's method: q, branch, cost.

    Also whether it is final: nothing better is found by following curves.
    """
    q, best, lowest = best_of_all(P, target, psi, wanted, goal, A)
    if wanted >= 0:
        (q, lowest), final = settle_branch(P, target, psi, wanted, Best(q, lowest), goal, A)
        if final and not goal.seeded:
            return q, best, lowest, True
    elif lowest >= OUTSIDE:
        found = np.empty((8, 8))
        settle_all(P, target, psi, goal, found, A)
        other, b, value = best_found(found, wanted, goal.seed)
        if value < lowest:
            q, best, lowest = other, b, value
    # Next to a singularity, Newton's method may have missed the branch that is nearest to a seed.
    if lowest < OUTSIDE and not (goal.seeded and lowest > AT_SEED):
        return q, best, lowest, True
    unsure = may_have_others(P, target, psi, q)
    if lowest < NO_BRANCH and not unsure and (lowest < OUTSIDE or not is_crowded(P)):
        return q, best, lowest, True
    return q, best, lowest, False


@kernel
def from_curves(P, by, followed, psi, wanted, goal, best):
    """The best posture of curves at an arm angle, or in a branch or on its border, if better than one known.

    Each is given as q, branch, cost.
    """
    found = np.empty((8, 8))
    sides = 3 if wanted >= 0 and best[2] >= OUTSIDE else 1
    for side in range(sides):
        other = best_on_curves(P, by, followed, psi + BESIDE[side], wanted, goal, found)
        if other[2] >= NO_BRANCH and sides > 1:
            other = on_border(P, found, wanted, goal)
        if other[2] < best[2]:
            best = other
        if best[2] < OUTSIDE:
            break
    return best


@kernel
def solve_at_angle(P, target, psi, wanted, goal, J, A):
    """Best posture at an arm angle over all branches, or in one (0 to 7), by all means there are: q, branch, cost.

    A branch of a near limb ends where its curve turns around or goes over into another one, and rounding decides about
    postures there: one at an arm angle that is the same with it is as good, and so is one of the other branch there.
    """
    place_ = target.place
    seeded, seed, respect = goal
    if J is None:
        return best_branch(P, place_, psi, wanted, seeded, seed, respect)
    q, best, lowest, final = settle_at_angle(P, target, psi, wanted, goal, A)
    if not may_reach(P, place_):
        return q, best, lowest
    missing = wanted >= 0 and lowest >= NO_BRANCH
    ends = missing and not is_told(P, place_, psi)
    # Where several joints are singular at once, a branch has many postures: others may keep the limits.
    final = final and not ends and (lowest < OUTSIDE or not has_surface(P, place_))
    if final or (lowest < OUTSIDE and not seeded):
        return q, best, lowest
    by = setting_of(P, target, J, A)
    q, best, lowest = from_curves(P, by, followed_curves(P, by), psi, wanted, goal, (q, best, lowest))
    if lowest >= OUTSIDE:
        attempts = ATTEMPTS if lowest >= NO_BRANCH else 1
        for side in range(3 if ends and is_near_line(P, target, psi, wanted) else 1):
            other, value = evaluate_again(P, target, psi + BESIDE[side], wanted, goal, attempts, A)
            if value < lowest:
                q, best, lowest = other, branch_of(P, other), value
            if lowest < OUTSIDE:
                break
    if lowest >= OUTSIDE and abs(place_[3]) < STRETCHED and P[MISS] < ON_LINE * P[FAR]:
        other, b, value = stretched(P, target, wanted, goal, J, A)
        if value < lowest:
            q, best, lowest = other, b, value
    return q, best, lowest
