"""The whole redundancy of a pose: its feasible intervals, and the best posture over all of them."""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import difference, dot7, short_way
from srs_ik.kernels.algebra.pointers import read7, row, scratch
from srs_ik.kernels.chain.descent import THOROUGH, descend, slid
from srs_ik.kernels.chain.newton import CLOSED, clipped, close_free
from srs_ik.kernels.chain.starts import SPLITS, put_splits
from srs_ik.kernels.curves.best import search_followed
from srs_ik.kernels.curves.follow import BLURRED
from srs_ik.kernels.exact import nearest
from srs_ik.kernels.exact.farthest import farthest, farthest_of_all, whole_circles
from srs_ik.kernels.exact.free_splits import settled_split, with_splits
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.exact.nearest_within import nearest_within
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES, SOLVED
from srs_ik.kernels.layout.asked import Goal
from srs_ik.kernels.layout.limb import (
    FAR,
    FIRST_JOINT,
    FREE,
    IS_NEAR,
    LIMITED,
    LOOSE,
    MISS,
    SHOULDER,
    SIZE,
    WRIST,
)
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of, draw_to_branch, is_on_border, is_unsure, singular_sines
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, UNMET, cost, turned
from srs_ik.kernels.limb.in_line import NEARLY_IN_LINE, is_in_line, may_line_up, toward_of
from srs_ik.kernels.limb.limits import tighten
from srs_ik.kernels.limb.splits import nearest_split, with_outer
from srs_ik.kernels.limb.surface import has_surface
from srs_ik.kernels.near.at_angle import is_crowded, may_be_unsure_within
from srs_ik.kernels.near.band import WIDER, band_of, is_well_bent, widest
from srs_ik.kernels.near.many_singular import nearest_among_splits, try_from
from srs_ik.kernels.near.second_attempts import may_be_on_line
from srs_ik.kernels.pose.any_bend import best_at_any_bend, hides_some, nearest_alone

HARDLY_FARTHER = 1e-4
FEW_STEPS = 12
"""Its nearest posture is found in a few steps, and no farther from a seed, in squared rad, than this."""

MOST_STARTS = 16 * SPLITS
"""Postures along all the free splits of a pose: of shoulder and wrist, both ways, on either side of the elbow."""

APART = 1e-6
"""Splits farther apart than this, rad, are two."""


@kernel
def search_hardly_near(P, target, found, known, goal, J, A):
    """The nearest posture in intervals of a limb that hardly differs from its nearest exact limb: q, branch, cost.

    That limb's own nearest posture, settled on the true chain, and whether it is told: not next to a singularity.
    `known` is the best posture so far, its branch and cost. Where the limits leave points or little more, one of the
    two limbs may have postures alone; so they are as far apart wider for that limb as its postures may be from these.
    """
    q, _, lowest = known
    wide = row(scratch(1, SIZE), 0)
    tighten(P, goal.seed, math.inf, nearest.between_limbs(P), wide)
    start, _, value = nearest_within(wide, target.place, found, -1, goal, 4.0 * NO_BRANCH)
    if value >= OUTSIDE and not is_unsure(P, q):
        return known, True
    if value < OUTSIDE:
        told = not is_unsure(P, start) and not is_unsure(P, q)
        if told and value >= lowest:
            return known, True
        start, error = close_free(P, start, target.R, target.p, goal.respect, FEW_STEPS, J, A)
        settled, there, _ = slid(P, target, start, goal, J, A)
        if error < CLOSED and there < lowest:
            known = (settled, branch_of(P, settled), there)
        if told and error < CLOSED and there < value + HARDLY_FARTHER:
            return known, True
    return known, False


@kernel
def is_many_singular(P, target, seed, distance):
    """Whether shoulder and wrist of a near limb may both come into line no farther than some distance from a seed."""
    s2, _, s6 = singular_sines(P, seed)
    return max(s2, s6) < distance + nearest.between_limbs(P) and has_surface(P, target.place)


@kernel
def search_splits(P, target, known, goal, J, A):
    """The best posture so far, or a nearer one where the true chain splits a sum of two joints: q, branch, cost.

    Such postures are a curve at a single arm angle of the nearest exact limb, far from its own postures but for those
    at which both cross: searches start from the nearest of all splits of each sum that is close.
    """
    seed, distance = goal.seed, math.sqrt(known[2])
    within = distance + max(nearest.between_limbs(P), WIDER * widest(band_of(P, target.place)))
    s2, _, s6 = singular_sines(P, seed)
    if min(s2, s6) >= within:
        return known
    starts = np.empty((MOST_STARTS, 7))
    n = put_splits(P, target, J, starts, 0)
    for i in range(0, n, SPLITS):
        q = read7(row(starts, i))
        k, first = (SHOULDER, 0) if is_in_line(P, SHOULDER, q[1], NEARLY_IN_LINE) else (WRIST, 4)
        toward = toward_of(P, k, q[first + 1])
        # Of the sum, the nearest split takes half with each joint.
        off = difference(seed, q)
        total = short_way(toward * off[first] + off[first + 2])
        rest = with_outer(off, first, 0.0, 0.0)
        if dot7(rest, rest) + 0.5 * total * total < within * within:
            total = toward * q[first] + q[first + 2]
            q1, q3 = nearest_split(P, k, first, total, toward, seed[first], seed[first + 2])
            known = try_from(P, with_outer(q, first, q1, q3), target, goal, known, (J, A))
    return known


@kernel
def may_be_in_line(P, place_, seed, distance):
    """Whether outer axes of a near limb alone may come into line at a pose, no farther than a distance from a seed.

    There the true chain has postures where the nearest exact limb has none.
    """
    s2, _, s6 = singular_sines(P, seed)
    within = nearest.between_limbs(P)
    return min(s2, s6) < distance + within and may_line_up(P, place_, within)


@kernel
def intervals_within(family, target, known, goal, found):
    """Write the intervals of arm angles at which a posture may be nearer than the best one so far; their number."""
    box = row(scratch(1, SIZE), 0)
    P = row(family, LIMITED if goal.respect else FREE)
    tighten(P, goal.seed, math.sqrt(known[2]) * (1.0 + 1e-9), nearest.between_limbs(P), box)
    return find_intervals(box, target.place, -1, found)


@kernel
def split_behind_limits(P, target, goal, found, work):
    """A posture, or a nearer one along the free splits of its shoulder and wrist, where limits keep steps from it."""
    for k in (SHOULDER, WRIST):
        q, first = found[0], int(P[k + FIRST_JOINT])
        middle = q[1] if k == SHOULDER else q[5]
        if not is_in_line(P, k, middle, NEARLY_IN_LINE):
            continue
        toward = toward_of(P, k, middle)
        total = toward * q[first] + q[first + 2]
        q1, q3 = nearest_split(P, k, first, total, toward, goal.seed[first], goal.seed[first + 2])
        if abs(q1 - q[first]) > APART:
            start = with_outer(q, first, q1, q3)
            found = try_from(P, start, target, goal, found, work)
    return found


@kernel
def going_on(P, target, goal, found, J, A):
    """What a search has found, or what is nearer to a seed around it: q, branch, cost.

    Rounding decides where a curve leaves the limits, and turns around at an elbow as good as straight: searches end
    short of there, steps that each gain something do not.
    """
    if not goal.seeded or found[2] >= OUTSIDE:
        return found
    q, value = descend(P, found[0], target, goal, THOROUGH, (J, A))
    found = (q, branch_of(P, q), value)
    if not goal.respect:
        return found
    q = turned(P, q, True, goal.seed, False)
    if OUTSIDE <= cost(P, q, True, goal.seed, True) < OUTSIDE + BLURRED:
        # In a turn closer to the seed, rounding alone may put it outside the limits.
        found = try_from(P, clipped(P, q), target, goal, found, (J, A))
    nearer = split_behind_limits(P, target, goal, found, (J, A))
    if nearer[2] == found[2]:
        return found
    q, value = descend(P, nearer[0], target, goal, THOROUGH, (J, A))
    return q, branch_of(P, q), value


@kernel
def going_on_in_branch(family, target, branch, goal, found, J, A):
    """What a search in a branch has found, or what is nearer to a seed in it: q, branch, cost.

    Curves are divided where they leave a branch, to rounding; what rounding does not tell to be on one side of a border
    or on the other is of either branch. So a branch is what limits of joints 2, 4 and 6 keep that reach past its
    borders by as much.
    """
    box = row(scratch(1, SIZE), 0)
    around = found[0] if found[2] < OUTSIDE else goal.seed
    if draw_to_branch(row(family, LIMITED if goal.respect else FREE), branch, around, box):
        within = Goal(True, goal.seed, True)
        found = nearest_among_splits(box, target, within, found)
        q, value = nearest.settle_inside(box, target, goal.seed, within, J, A)
        q, _, value = going_on(box, target, within, (q, branch, value) if value < found[2] else found, J, A)
        found = (q, branch, value)
    return found


@kernel
def search_beside(family, target, minimum, known, goal, J, A):
    """The posture of a near limb nearest to a seed as far as local searches tell, or the best one so far.

    `minimum` tells whether that is a local one. Returns q, branch, cost, and whether this is told, or only curves tell.
    """
    P = row(family, LIMITED)
    if goal.respect and may_be_on_line(P, target.place):
        # A straight elbow leaves limits of several joints one posture, which is found from the seed that it is next to.
        known = try_from(P, goal.seed, target, goal, known, (J, A))
    known = nearest_among_splits(P, target, goal, known)
    if known[2] >= OUTSIDE:
        return known, True
    told = not is_many_singular(P, target, goal.seed, math.sqrt(known[2]))
    if told:
        known = search_splits(P, target, known, goal, J, A)
    if told and math.sqrt(known[2]) < nearest.CLOSE:
        known, sure = nearest.look_across(P, target, known, minimum, goal, J, A)
        if sure:
            return known, True
    found = np.empty((8 * MAX_PIECES, 3))
    n = intervals_within(family, target, known, goal, found)
    # The true chain may reach a pose, and bend its elbow, where the closed form does not; and so may oblique axes.
    told = told and is_well_bent(P, target.place)
    told = told and not (is_crowded(P) and may_be_unsure_within(P, target.place, goal.seed, math.sqrt(known[2])))
    if n == 0 and told and not may_be_in_line(P, target.place, goal.seed, math.sqrt(known[2])):
        return (known if minimum else going_on(P, target, goal, known, J, A)), True
    if P[MISS] < nearest.HARDLY * P[FAR]:
        known, sure = search_hardly_near(P, target, found[:n], known, goal, J, A)
        return (going_on(P, target, goal, known, J, A) if sure else known), sure
    if told and n > 0:
        return nearest.look_beside(P, target, found[:n], known, goal, J, A)
    return known, False


@kernel
def search_near_seed(family, target, branch, goal, J, A):
    """The posture nearest to a seed over all branches and arm angles: q, branch, cost (OUTSIDE if none was found).

    And whether it is told: where the best so far is not in a branch that is wanted, curves are not followed yet.
    """
    P = row(family, LIMITED)
    q, lowest, minimum = nearest.guess(P, target, goal, J, A)
    known = (q, branch_of(P, q), lowest)
    if minimum and nearest.is_alone(P, goal.seed, lowest):
        return known, True
    if lowest < OUTSIDE:
        known = with_splits(P, target, -1, goal, known)
    if P[IS_NEAR] != 0.0:
        known, sure = search_beside(family, target, minimum, known, goal, J, A)
        if sure or (branch >= 0 and not is_on_border(P, known[0], branch)):
            return known, sure
        nearer = search_followed(P, target, -1, goal, goal.respect, J, A)
        return going_on(P, target, goal, nearer if nearer[2] < known[2] else known, J, A), True
    if known[2] >= OUTSIDE:
        return known, True
    found = np.empty((8 * MAX_PIECES, 3))
    n = intervals_within(family, target, known, goal, found)
    if n == 0:
        return known, True
    nearer = nearest_within(P, target.place, found[:n], -1, goal, known[2])
    if nearer[2] < known[2]:
        nearer = settled_split(P, target, nearer, goal)
    nearer = nearest_alone(family, target, found[:n], goal, nearer if nearer[2] < known[2] else known)
    return (nearer if nearer[2] < known[2] else known), True


@kernel
def farthest_exact(family, target, branch, respect):
    """Posture of a closed limb farthest from its limits over all arm angles: q, branch, cost; see `search_exact`."""
    place_, goal = target.place, Goal(False, NO_SEED, respect)
    P, F, loose = row(family, LIMITED), row(family, LIMITED if respect else FREE), row(family, LOOSE)
    best = with_splits(P, target, branch, goal, farthest_of_all(P, F, place_, branch, respect))
    if best[2] >= OUTSIDE:
        best = best_at_any_bend(family, target, branch, goal, best)
    if best[2] >= OUTSIDE:
        circles = np.empty((8, 3))
        whole_circles(circles)
        other = farthest(loose, place_, circles, branch, respect)
        if other[2] < best[2]:
            best = other
    return best


@kernel
def nearest_exact(family, target, branch, goal):
    """Posture of a closed limb nearest to a seed over all arm angles: q, branch, cost; see `search_exact`."""
    place_ = target.place
    P, loose = row(family, LIMITED), row(family, LOOSE)
    found = np.empty((8 * MAX_PIECES, 3))
    n = find_intervals(row(family, LIMITED if goal.respect else FREE), place_, branch, found)
    best = nearest_within(P, place_, found[:n], branch, goal, 4.0 * NO_BRANCH)
    best = with_splits(P, target, branch, goal, best)
    # What rounding hides may be nearer.
    if best[2] >= OUTSIDE or hides_some(P, place_):
        best = best_at_any_bend(family, target, branch, goal, best)
    if best[2] < OUTSIDE:
        return best
    if abs(place_[5]) >= SOLVED:
        whole_circles(found)
        other = nearest_within(loose, place_, found[:8], branch, goal, 4.0 * NO_BRANCH)
        return other if other[2] < best[2] else best
    # What is farthest from the limits is found where it is alone, and so found from every seed.
    q, own, value = farthest_exact(family, target, branch, goal.respect)
    if value >= UNMET:
        return q, own, value
    q = turned(P, q, True, goal.seed, goal.respect)
    return q, own, cost(P, q, True, goal.seed, goal.respect)


@kernel
def search_exact(family, target, branch, goal):
    """Best posture of a closed limb over all arm angles: q, branch, cost; the least violating one if all break limits.

    Rounding may hide a posture from the strict search. So looser tolerances follow in every interval, with the elbow
    almost straight or folded at all the bends that a pose cannot tell from each other.
    """
    if goal.seeded:
        return nearest_exact(family, target, branch, goal)
    return farthest_exact(family, target, branch, goal.respect)
