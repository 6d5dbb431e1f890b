"""Postures at an arm angle, also of a near limb where Newton's method from the closed form does not lead to them.

Next to a singularity a branch may have several postures at one arm angle, or none. All of them lie where the curves
that `follow` follows pass the arm angle.
"""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import difference, dot7, short_way
from srs_ik.kernels.chain.newton import STEPS, close_at_angle
from srs_ik.kernels.chain.starts import FIRST, best_of_all, best_row, close_all
from srs_ik.kernels.curves.best import cost_of_turn
from srs_ik.kernels.curves.follow import between
from srs_ik.kernels.curves.in_step import load_sample
from srs_ik.kernels.curves.runs import near_runs
from srs_ik.kernels.curves.spans import angle_at, turn_at
from srs_ik.kernels.curves.surface import has_surface
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import ROW_COST
from srs_ik.kernels.layout.asked import Best, Goal, Setting
from srs_ik.kernels.layout.limb import COSINE_OFF, FAR, MISS, NEAR, SHIFT
from srs_ik.kernels.layout.search import MAX_RUNS, RUN
from srs_ik.kernels.limb.branches import NO_BRANCH, best_branch, branch_of, is_unsure
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.near.band import ALMOST_NOTHING, band_of, is_oblique, is_told, may_predict
from srs_ik.kernels.near.branch_search import search_branch
from srs_ik.kernels.near.second_attempts import ATTEMPTS, STRETCHED, evaluate_again, is_near_line, stretched

HALVINGS = 30
"""Steps that close in on an arm angle between two samples, before Newton's method takes over."""

NEAR_TURN = 0.5
AT_TURN = 1e-9
"""An arm angle that turns around is looked for this close to the one that is wanted, rad; there it is the one, up to
the second."""

CLOSE_BY = 1e-4
"""Newton's method moves a posture no farther than this, rad, squared."""

AT_SEED = 1e-12
"""A posture this close to a seed, rad squared, is the nearest one."""

REACH_SLACK = 8.0
BEND_SLACK = 2.0
"""A near limb reaches no farther than its nearest exact limb and so many times its largest miss, nor than the cosine of
the elbow's bend may be off: over 10^5 straight elbows of a limb, it is off by up to 1.3 times what is packed."""

ROUNDING = 1e-9
"""Of the reach."""

SAME_ANGLE = 1e-9
"""Arm angles closer than this, rad, are one where rounding decides about limits."""

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
def passing(P, by, psi, a, b):
    """The posture between two of a curve at an arm angle that lies between theirs, and whether it is met.

    Postures are given with how far their arm angles are ahead.
    """
    q_a, ahead_a = a
    q_b, ahead_b = b
    low = 0.0
    high = 1.0
    q = q_a
    for i in range(HALVINGS):
        share = low + (high - low) * (ahead_a / (ahead_a - ahead_b) if i % 3 != 2 else 0.5)
        q, met = between(P, by, q_a, q_b, share)
        if not met:
            return q, False
        ahead = short_way(angle_at(P, by, q) - psi)
        if abs(ahead) < 1e-9 or high - low < 1e-12:
            break
        if ahead * ahead_a > 0.0:
            low, ahead_a = share, ahead
        else:
            high, ahead_b = share, ahead
    R, p, place_ = by.target
    exact, met = close_at_angle(P, q, R, p, place_[0], place_[1], psi, STEPS, by.A)
    moved = difference(q, exact)
    return exact, met and dot7(moved, moved) < CLOSE_BY


@kernel
def keep_found(P, q, goal, out):
    """Keep a posture in the row of its branch, if it is the best one there."""
    branch = branch_of(P, q)
    q, value = cost_of_turn(P, q, goal)
    if value < out[branch, ROW_COST]:
        for j in range(7):
            out[branch, j] = q[j]
        out[branch, ROW_COST] = value


@kernel
def put_passing(P, by, psi, ends, goal, out):
    """Keep the posture at an arm angle between two of a curve, given with how far they are ahead, if it lies there."""
    a, b = ends
    if a[1] * b[1] <= 0.0 and a[1] != b[1]:
        q, met = passing(P, by, psi, a, b)
        if met:
            keep_found(P, q, goal, out)


@kernel
def turning_between(P, by, a, b, rise):
    """The posture of a curve at which the arm angle turns around between two; `rise` is its sign at the first."""
    low, high = 0.0, 1.0
    best = a
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        q, met = between(P, by, a, b, share)
        if not met:
            break
        best = q
        if turn_at(P, by, q) == rise:
            low = share
        else:
            high = share
    return best


@kernel
def find_at_angle(P, by, rows, runs, psi, goal, out):
    """Write the best posture of every branch at an arm angle, and its cost, into the rows of out (8, 8).

    `rows` and `runs` hold all curves of the pose, as `near_runs` writes them.
    """
    for branch in range(8):
        out[branch, ROW_COST] = 2.0 * NO_BRANCH
    for index in range(runs.shape[0]):
        first = int(runs[index, 3])
        a = load_sample(rows[first])
        at_a = angle_at(P, by, a)
        rise_a = turn_at(P, by, a)
        for i in range(first + 1, int(runs[index, 4])):
            b = load_sample(rows[i])
            at_b = angle_at(P, by, b)
            rise_b = turn_at(P, by, b)
            ahead_a = short_way(at_a - psi)
            ahead_b = ahead_a + short_way(at_b - at_a)
            if rise_a != rise_b and min(abs(ahead_a), abs(ahead_b)) < NEAR_TURN:
                turning = turning_between(P, by, a, b, rise_a)
                ahead = ahead_a + short_way(angle_at(P, by, turning) - at_a)
                put_passing(P, by, psi, ((a, ahead_a), (turning, ahead)), goal, out)
                put_passing(P, by, psi, ((turning, ahead), (b, ahead_b)), goal, out)
                if abs(ahead) < AT_TURN:
                    keep_found(P, turning, goal, out)
            else:
                put_passing(P, by, psi, ((a, ahead_a), (b, ahead_b)), goal, out)
            a, at_a, rise_a = b, at_b, rise_b


@kernel
def best_found(found, wanted, seed):
    """Best of the postures in the rows of found (8, 8), or that of one branch (0 to 7): q, branch, cost."""
    best = best_row(found, 0, wanted)
    lowest = found[best, ROW_COST]
    return (read7(found[best]) if lowest < NO_BRANCH else seed), best, lowest


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
    return best, best.cost < OUTSIDE or (not crowded and (complete or best.cost < NO_BRANCH))


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
def setting_of(P, target, J, A):
    """The setting in which all curves of a pose are followed, whatever the limits."""
    return Setting(target, elbow_side(P, target.place, 0), False, J, A)


@kernel
def solve_all_at_angle(P, target, psi, respect, J, A, found):
    """The posture of every branch at an arm angle, and its cost, into the rows of found (8, 8)."""
    goal = Goal(False, NO_SEED, respect)
    close_all(P, target, psi, -1, goal, A)
    if not settle_all(P, target, psi, goal, found, A):
        followed, runs = np.empty((8, 8)), np.empty((MAX_RUNS, RUN))
        by = setting_of(P, target, J, A)
        rows, _, k, _ = near_runs(P, by, runs)
        find_at_angle(P, by, rows, runs[:k], psi, goal, followed)
        for branch in range(8):
            if followed[branch, ROW_COST] < found[branch, ROW_COST]:
                found[branch] = followed[branch]


@kernel
def are_curves_followed(P, place_):
    """Whether the arm angles that a pose has are told by curves that are followed."""
    return not may_predict(P, place_, band_of(P, place_)) or has_surface(P, place_)


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
def solve_at_angle(P, target, psi, wanted, goal, J, A):
    """Best posture at an arm angle over all branches, or in one (0 to 7), by all means there are: q, branch, cost.

    A branch of a near limb ends where its curve turns around or goes over into another one, and rounding decides about
    postures there: one at an arm angle that is the same with it is as good.
    """
    place_ = target.place
    seeded, seed, respect = goal
    if J is None:
        return best_branch(P, place_, psi, wanted, seeded, seed, respect)
    q, best, lowest, final = settle_at_angle(P, target, psi, wanted, goal, A)
    if not may_reach(P, place_):
        return q, best, lowest
    missing = lowest >= NO_BRANCH
    sides = 3 if wanted >= 0 and missing else 1
    for side in range(1, sides):
        other, _, value, _ = settle_at_angle(P, target, psi + BESIDE[side], wanted, goal, A)
        if value < lowest:
            q, lowest = other, value
        if lowest < OUTSIDE:
            break
    final = final and not (missing and wanted >= 0 and are_curves_followed(P, place_))
    if final or (lowest < OUTSIDE and not seeded):
        return q, best, lowest
    followed, runs = np.empty((8, 8)), np.empty((MAX_RUNS, RUN))
    by = setting_of(P, target, J, A)
    rows, _, k, _ = near_runs(P, by, runs)
    for side in range(sides):
        find_at_angle(P, by, rows, runs[:k], psi + BESIDE[side], goal, followed)
        other, b, value = best_found(followed, wanted, seed)
        if value < lowest:
            q, best, lowest = other, b, value
        if lowest < OUTSIDE:
            break
    if lowest >= OUTSIDE:
        attempts = ATTEMPTS if missing else 1
        for side in range(sides if is_near_line(P, target, psi, wanted) else 1):
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
