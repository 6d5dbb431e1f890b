"""Postures of singular poses that no curve over the arm angle passes: free splits of a sum of two joints.

Where the outer axes of the shoulder or of the wrist come into line at some arm angle, a whole segment of postures hangs
there: the pose fixes the sum or the difference of two joints, and leaves its split open. Next to such a pose the
segment is a stretch of a curve so steep that arm angles cannot tell its postures apart. Both are searched here as if
the axes were in line, where the best split is known in closed form, and the posture is then closed on the true chain.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row, scratch
from srs_ik.kernels.chain.descent import slid
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.chain.newton import CLOSED, LEFT, close_gently
from srs_ik.kernels.exact.bends import best_of_bends, best_on_circles
from srs_ik.kernels.exact.flat import is_as_good_as_flat
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Target
from srs_ik.kernels.layout.limb import SHOULDER, SIZE, WRIST
from srs_ik.kernels.limb.branches import branch_of, is_on_border, side_posture
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, cost, turned
from srs_ik.kernels.limb.in_line import NEARLY_IN_LINE, closest, comes_in_line, may_split, wide_limb
from srs_ik.kernels.limb.surface import level_place
from srs_ik.kernels.limb.triangle import elbow_side

LOOSELY = 3e-11
"""A split whose posture cannot be closed is one all the same if it meets its pose within this, m and rad."""

GIVE = 3e-4
"""A split that is worse by less than this, rad or of a range, may be better once its posture is closed."""

FAR_SPLIT = 1e3
"""The split nearest to joints this far out, rad, is the last one inside the limits."""


@kernel
def worse_by(value, lowest, seeded):
    """By how much one cost is worse than another: as distances from a seed, rad, or as margins."""
    return math.sqrt(value) - math.sqrt(lowest) if seeded else value - lowest


@kernel
def keep_better(P, target, split, wanted, goal, best, work):
    """The better of a split, closed on the true chain, and the best posture so far, each a posture, branch and cost."""
    start, _, value = split
    lowest = best[2]
    position, orientation = pose_error(P, start, target.R, target.p)
    off = max(position, orientation)
    if value >= OUTSIDE + GIVE or off < CLOSED:
        return split if value < lowest else best
    if worse_by(value, lowest, goal.seeded) > GIVE:
        return best
    J, A = work
    closed, error = close_gently(P, start, target.R, target.p, goal.respect, J, A)
    if error > LEFT:
        # With three joints singular at once, not all of a tiny error can be closed.
        known = off < LOOSELY or value >= OUTSIDE
        return split if known and value < lowest else best
    if goal.seeded:
        closed, value, _ = slid(P, target, closed, goal, J, A)
    else:
        value = cost(P, closed, goal.seeded, goal.seed, goal.respect)
    if value < lowest and (wanted < 0 or is_on_border(P, closed, wanted)):
        return closed, branch_of(P, closed) if wanted < 0 else wanted, value
    return best


@kernel
def split_end(P, wide, side, psi, branch, i, last):
    """The posture of a branch whose split is the first (last 0) or the last (1) inside the limits: q, cost.

    Bits of i: the shoulder (0) or the wrist (2), its outer axes pointing the same way (0) or opposite ways (1).
    """
    far = FAR_SPLIT if last == 1 else -FAR_SPLIT
    other = far if i % 2 == 1 else -far
    seed = (far, 0.0, other, 0.0, far, 0.0, other)
    q, _, _ = side_posture(wide, side, psi, (branch >> 1) & 1, branch & 1, True, seed, True)
    q = turned(P, q, False, NO_SEED, True)
    return q, cost(P, q, False, NO_SEED, True)


@kernel
def search_near_line(limbs, target, wanted, goal, best, work):
    """The best posture of a pose, or a split that is better, and whether axes stay in line.

    The second of two limbs takes axes almost in line so; in line at all arm angles they lie along the line S-W.
    """
    P, wide = limbs
    circles = False
    for elbow in range(2):
        side = elbow_side(P, target.place, elbow)
        for i in range(4):
            k = SHOULDER if i < 2 else WRIST
            end = i % 2
            if not comes_in_line(P, k, end):
                continue
            psi, least, most = closest(P, k, side[1] if i < 2 else side[2], end)
            circles = circles or most < NEARLY_IN_LINE
            if least > NEARLY_IN_LINE or most < NEARLY_IN_LINE:
                continue
            for b in range(4 * elbow, 4 * elbow + 4):
                if wanted < 0 or b == wanted:
                    start, _, value = side_posture(
                        wide, side, psi, (b >> 1) & 1, b & 1, goal.seeded, goal.seed, goal.respect
                    )
                    best = keep_better(P, target, (start, b, value), wanted, goal, best, work)
                    # A posture with several joints on their limits may hang at an end of the split alone.
                    for last in range(2 if goal.respect and best[2] >= OUTSIDE else 0):
                        start, value = split_end(P, wide, side, psi, b, i, last)
                        best = keep_better(P, target, (start, b, value), wanted, goal, best, work)
    if circles:
        split = best_on_circles(wide, target.place, wanted, goal)
        best = keep_better(P, target, split, wanted, goal, best, work)
    return best, circles


@kernel
def with_splits(P, target, wanted, goal, best):
    """The best posture of a pose as known so far, or a free split that is better, each a posture, branch and cost.

    Only the branch that is wanted counts; -1: all.
    """
    if not may_split(P, target.place):
        return best
    wide = row(scratch(1, SIZE), 0)
    wide_limb(P, wide)
    work = (np.empty((6, 7)), np.empty((16, 9)))
    limbs = (P, wide)
    best, along = search_near_line(limbs, target, wanted, goal, best, work)
    if is_as_good_as_flat(target.place):
        flat = Target(target.R, target.p, level_place(target.place))
        best, alike = search_near_line(limbs, flat, wanted, goal, best, work)
        along = along or alike
    if along:
        split = best_of_bends(P, target.place, wanted, goal, best[2])
        best = keep_better(P, target, split, wanted, goal, best, work)
    return best


@kernel
def settled_split(P, target, found, goal):
    """A posture next to a singular one, or the nearer one around it that no arm angle can tell apart from it.

    Each is given as a posture, its branch and its cost.
    """
    q, _, lowest = found
    if not may_split(P, target.place) or lowest >= OUTSIDE:
        return found
    nearer, value, _ = slid(P, target, q, goal, np.empty((6, 7)), np.empty((16, 9)))
    return (nearer, branch_of(P, nearer), value) if value < lowest else found
