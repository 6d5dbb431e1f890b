"""Postures at an arm angle, also of a near limb where Newton's method from the closed form does not lead to them.

Next to a singularity a branch may have several postures at one arm angle, or none. All of them lie where the curves
that `follow` follows pass the arm angle.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import short_way
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.chain.starts import FIRST, bent_place, best_in, close_all, put_around
from srs_ik.kernels.curves.lowest import cost_of_turn
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import ROW_COST
from srs_ik.kernels.layout.asked import Best, Goal, Setting
from srs_ik.kernels.layout.limb import COSINE_OFF, FAR, IS_NEAR, MISS, NEAR, SHIFT
from srs_ik.kernels.limb.branches import NO_BRANCH, UNSURE, best_branch, branch_of, is_on_border, is_unsure
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.in_line import ROUNDED
from srs_ik.kernels.limb.surface import has_surface
from srs_ik.kernels.near import band, on_curves
from srs_ik.kernels.near.branch_search import search_branch
from srs_ik.kernels.near.second_attempts import (
    ATTEMPTS,
    STRETCHED,
    evaluate_again,
    found_again,
    may_be_on_line,
    nearest_on_line,
    stretched,
)

AT_SEED = 1e-12
"""A posture this close to a seed, rad squared, is the nearest one."""

REACH_SLACK = 8.0
BEND_SLACK = 2.0
"""A near limb reaches no farther than its nearest exact limb and so many times its largest miss, nor than the cosine of
the elbow's bend may be off: over 10^5 straight elbows of a limb, it is off by up to 1.3 times what is packed."""

ROUNDING = 1e-9
"""Of the reach."""

BESIDE = (0.0, 0.5 * on_curves.SAME_ANGLE, -0.5 * on_curves.SAME_ANGLE)
BARELY = 1e-2
"""Where else a branch is looked for that ends at an arm angle, rad; where no curve turns around or goes over into
another branch next to it, only if a posture is no farther outside its limits than the last. Next to a singular wrist
arm angles that floats do not tell apart may be as far apart as that in the outer joints."""

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
    return band.is_oblique(P) and P[SHIFT] > band.ALMOST_NOTHING


@kernel
def is_almost_straight(P, place_):
    """Whether the elbow of a pose is so straight that starts with it bent further lead to more postures."""
    return bent_place(P, place_)[3] != place_[3]


@kernel
def close_branches(P, target, psi, wanted, goal, each, A):
    """`close_all`, and what it may miss where an almost straight elbow has left a branch without a posture.

    Each branch that is missed is looked for on curves afterwards (`each`), or none unless all are: these tell more.
    """
    straight = is_almost_straight(P, target.place)
    met = close_all(P, target, psi, wanted, goal, straight == each, A)
    if straight and not met and best_in(A, wanted)[2] < OUTSIDE and may_reach(P, target.place):
        put_around(P, target, psi, wanted, goal, each, A)


@kernel
def is_barely(value):
    """Whether a posture of a cost is barely outside its limits."""
    return OUTSIDE <= value < OUTSIDE + BARELY


@kernel
def may_have_others(P, target, psi, q, value):
    """Whether there may be other postures than one of a cost at its arm angle, in its branch or next to it.

    Also where its own elbow is well bent: another posture of the pose may have an almost straight one.
    """
    unsure = is_unsure(P, q)
    if unsure and is_barely(value):
        # Rounding of the arm angle alone may have put it outside: what is told of that angle tells nothing beside it.
        return True
    return (unsure or band.least_bend(P, target.place) == 0.0) and not band.is_told(P, target.place, psi)


@kernel
def is_any_barely(found):
    """Whether a branch is barely outside its limits, in rows of found (8, 8)."""
    barely = False
    for branch in range(8):
        barely = barely or is_barely(found[branch, ROW_COST])
    return barely


@kernel
def branches_to_look_at(P, target, psi, wanted, A):
    """Branches, as bits, (or the wanted one, 0 to 7) that may have a better posture.

    `close_all` has left them in A outside their limits or without a posture.
    """
    branches = 0
    for branch in range(8):
        value = A[FIRST + branch, ROW_COST]
        if value < OUTSIDE or (wanted >= 0 and branch != wanted):
            continue
        q = read7(row(A, FIRST + branch))
        if value >= NO_BRANCH or is_crowded(P) or may_have_others(P, target, psi, q, value):
            branches |= 1 << branch
    return branches


@kernel
def is_any_unsure(P, wanted, A):
    """Whether a branch (or the wanted one, 0 to 7) has no posture in A, or one next to a singularity."""
    unsure = False
    for branch in range(8):
        if wanted in (-1, branch):
            unsure = unsure or A[FIRST + branch, ROW_COST] >= NO_BRANCH
            unsure = unsure or is_unsure(P, read7(row(A, FIRST + branch)))
    return unsure


@kernel
def may_be_unsure_within(P, place_, seed, distance):
    """Whether a posture no farther than this from a seed may be so close to a singularity: see `is_unsure`."""
    if not band.is_well_bent(P, place_):
        return True
    s2, s6 = band.sines_of_middles(P, seed)
    width = UNSURE * P[SHIFT] / place_[3]
    return min(s2, s6) < distance + width or place_[3] < width


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
def put_searched(P, target, psi, wanted, goal, found, A):
    """Search branches (or the wanted one, 0 to 7) without a posture in rows of found (8, 8)."""
    for branch in range(8):
        if found[branch, ROW_COST] >= NO_BRANCH and wanted in (-1, branch):
            q, value = search_branch(P, target, psi, branch, goal, A)
            if value < found[branch, ROW_COST]:
                put_found(q, value, found[branch])


@kernel
def put_passed(P, by, followed, psi, goal, found):
    """Take over what is better where curves pass an arm angle, or barely beside it, in rows of found (8, 8).

    Returns whether there are no others for certain.
    """
    other = np.empty((8, 8))
    certain = False
    for side in range(3 if followed.runs.shape[0] > 0 else 0):
        nearest = on_curves.find_at_angle(P, by, followed, psi + BESIDE[side], -1, goal, other)
        put_better(other, found)
        certain = on_curves.is_certain(by, followed, nearest) if side == 0 else certain
        if certain and not is_any_barely(found):
            break
    return certain


@kernel
def solve_all_at_angle(P, target, psi, work, found, kept):
    """The posture of every branch at an arm angle, and its cost, into the rows of found (8, 8).

    `work` holds whether limits count, J and A. `kept` are all curves of the pose, if they have been followed; they are
    returned, or those that have been now.
    """
    respect, J, A = work
    goal = Goal(False, NO_SEED, respect)
    close_branches(P, target, psi, -1, goal, True, A)
    for branch in range(8):
        for i in range(8):
            found[branch, i] = A[FIRST + branch, i]
    if highest_cost(found) < OUTSIDE or not may_reach(P, target.place):
        return kept
    branches = on_curves.EVERY_BRANCH
    if not has_surface(P, target.place):
        branches = band.leave_out_met(P, target, psi, branches_to_look_at(P, target, psi, -1, A), A)
    if branches != 0:
        on_line = may_be_on_line(P, target.place)
        by = on_curves.setting_of(P, target, J, A)
        certain = put_passed(P, by, on_curves.curves_on_arcs(P, by, psi, branches), psi, goal, found)
        if highest_cost(found) < OUTSIDE:
            return kept
        if not certain:
            # Those of every branch, though few may need them: so other arm angles of the pose have the same answers.
            if kept.runs.shape[0] == 0:
                kept = on_curves.followed_curves(P, by, on_curves.EVERY_BRANCH)
            certain = put_passed(P, by, kept, psi, goal, found)
        unsure = is_any_barely(found) or (abs(target.place[3]) < STRETCHED and highest_cost(found) >= OUTSIDE)
        if respect and not certain and unsure and P[MISS] < ON_LINE * P[FAR]:
            # As they are cut for intervals, curves pass what next to several singularities floats hardly tell apart.
            within = Setting(target, by.side, True, J, A)
            put_passed(P, within, on_curves.followed_curves(P, within, on_curves.EVERY_BRANCH), psi, goal, found)
        if not certain:
            put_searched(P, target, psi, -1, goal, found, A)
        put_borders(P, goal, found)
        for branch in range(8):
            # The curves of an almost exact limb are not the only postures there: it has surfaces of them.
            if P[MISS] < ROUNDED * P[FAR] and found[branch, ROW_COST] >= OUTSIDE:
                q, value = evaluate_again(P, target, psi, branch, goal, 1, A)
                if value >= OUTSIDE and on_line:
                    q, _, value = stretched(P, target, psi, branch, goal, J, A)
                if value < OUTSIDE:
                    put_found(q, value, found[branch])
    return kept


@kernel
def from_curves(P, by, followed, psi, wanted, goal, best):
    """The best posture of curves at an arm angle, or in a branch or on its border, if better than one known.

    Each is given as q, branch, cost. Returns whether there is no other for certain, too.
    """
    found = np.empty((8, 8))
    certain = False
    sides = 3 if wanted >= 0 and best[2] >= OUTSIDE else 1
    for side in range(sides if followed.runs.shape[0] > 0 else 0):
        other, sure = on_curves.best_on_curves(P, by, followed, psi + BESIDE[side], wanted, goal, found)
        certain = sure if side == 0 else certain
        if other[2] >= NO_BRANCH and sides > 1:
            other = on_border(P, found, wanted, goal)
        if other[2] < best[2]:
            best = other
        if best[2] < OUTSIDE or (certain and not is_barely(best[2])):
            break
    return best, certain


@kernel
def branches_in_question(P, target, psi, wanted, goal, lowest, A):
    """Branches, as bits, whose curves may pass an arm angle at better postures than one of a cost."""
    asked = on_curves.EVERY_BRANCH if wanted < 0 else 1 << wanted
    if lowest < OUTSIDE:
        # Next to a singularity, Newton's method may have missed the posture that is nearest to a seed.
        missed = goal.seeded and lowest > AT_SEED and is_any_unsure(P, wanted, A)
        if missed and may_be_unsure_within(P, target.place, goal.seed, math.sqrt(lowest)):
            elbows = band.untold_elbows(P, target.place, psi)
            return asked & ((0b1111 if elbows & 1 == 1 else 0) | (0b11110000 if elbows & 2 == 2 else 0))
        return 0
    return branches_to_look_at(P, target, psi, wanted, A)


@kernel
def solve_at_angle(P, target, psi, wanted, goal, J, A):
    """Best posture at an arm angle over all branches, or in one (0 to 7), by all means there are: q, branch, cost.

    An elbow on the line S-W is at every arm angle at once, and may be nearer to a seed than any that is not.
    """
    found = look_at_angle(P, target, psi, wanted, goal, J, A)
    if not goal.seeded or not may_be_on_line(P, target.place):
        return found
    other = nearest_on_line(P, target, psi, wanted, goal, J, A)
    return other if other[2] < found[2] else found


@kernel
def look_at_angle(P, target, psi, wanted, goal, J, A):
    """`solve_at_angle`, but for elbows on the line S-W that are nearer to a seed.

    A branch of a near limb ends where its curve turns around or goes over into another one, and rounding decides about
    postures there: one at an arm angle that is the same with it is as good, and so is one of the other branch there.
    """
    place_ = target.place
    seeded, seed, respect = goal
    if P[IS_NEAR] == 0.0:
        return best_branch(P, place_, psi, wanted, seeded, seed, respect)
    close_branches(P, target, psi, wanted, goal, wanted >= 0, A)
    q, best, lowest = best_in(A, wanted)
    if not may_reach(P, place_):
        return q, best, lowest
    branches = branches_in_question(P, target, psi, wanted, goal, lowest, A)
    branches = band.leave_out_met(P, target, psi, branches, A) if branches != 0 else 0
    if branches == 0:
        return q, best, lowest
    if lowest >= OUTSIDE and not seeded and may_be_on_line(P, place_):
        on_line = stretched(P, target, psi, wanted, goal, J, A)
        if on_line[2] < OUTSIDE:
            return on_line
    by = on_curves.setting_of(P, target, J, A)
    followed = on_curves.curves_on_arcs(P, by, psi, branches)
    (q, best, lowest), certain = from_curves(P, by, followed, psi, wanted, goal, (q, best, lowest))
    if not certain and (lowest >= OUTSIDE or seeded or wanted < 0):
        followed = on_curves.followed_curves(P, by, branches)
        (q, best, lowest), certain = from_curves(P, by, followed, psi, wanted, goal, (q, best, lowest))
    if lowest < OUTSIDE or (certain and not is_barely(lowest)):
        return q, best, lowest
    within, kept = Setting(target, by.side, True, J, A), followed.runs.shape[0]
    if respect:
        # As they are cut for intervals, curves pass what next to several singularities floats hardly tell apart.
        inside = on_curves.followed_curves(P, within, on_curves.EVERY_BRANCH)
        kept = inside.runs.shape[0]
        (q, best, lowest), _ = from_curves(P, within, inside, psi, wanted, goal, (q, best, lowest))
        if lowest < OUTSIDE or certain:
            return q, best, lowest
    if lowest >= NO_BRANCH:
        found = np.full((8, 8), 2.0 * NO_BRANCH)
        put_searched(P, target, psi, wanted, goal, found, A)
        q, best, lowest = on_curves.best_found(found, wanted, seed)
        if lowest < OUTSIDE:
            return q, best, lowest
    attempts = ATTEMPTS if lowest >= NO_BRANCH else 1
    other, value = evaluate_again(P, target, psi, wanted, goal, attempts, A)
    if value < lowest:
        q, best, lowest = other, branch_of(P, other), value
    if lowest >= OUTSIDE and abs(place_[3]) < STRETCHED and P[MISS] < ON_LINE * P[FAR]:
        other, b, value = stretched(P, target, psi, wanted, goal, J, A)
        if value < lowest:
            q, best, lowest = other, b, value
        if lowest >= OUTSIDE and respect and kept == 0:
            # Where no curve keeps the limits, an interval is that of a posture beside them.
            other, own, value = found_again(P, target, -1, Goal(False, NO_SEED, True), J, A)
            ahead = short_way(arm_angle(P, other, place_[0], place_[1]) - psi)
            there = value < OUTSIDE and on_curves.is_here(P, within, other, ahead)
            if there and (wanted < 0 or is_on_border(P, other, wanted)):
                other, value = cost_of_turn(P, other, goal)
                q, best, lowest = other, (wanted if wanted >= 0 else own), value
    return q, best, lowest
