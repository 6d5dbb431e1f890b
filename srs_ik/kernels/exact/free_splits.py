"""Postures of singular poses that no curve over the arm angle passes: free splits of a sum of two joints.

Where the outer axes of the shoulder or of the wrist come into line at some arm angle, a whole segment of postures hangs
there: the pose fixes the sum or the difference of two joints, and leaves its split open. Next to such a pose the
segment is a stretch of a curve so steep that arm angles cannot tell its postures apart. Both are searched here as if
the axes were in line, where the best split is known in closed form, and the posture is then closed on the true chain.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.algebra.vectors import norm
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.chain.newton import CLOSED, clipped, close_free, moved, pose_step, shortest_step
from srs_ik.kernels.exact.farthest import farthest
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.exact.nearest import slid
from srs_ik.kernels.exact.nearest_within import nearest_within
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.asked import Goal, Target
from srs_ik.kernels.layout.limb import (
    BOTTOM_GAP,
    LOWER,
    SHOULDER,
    SIZE,
    TOP_GAP,
    UPPER,
    WRIST,
)
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of, side_posture
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, cost
from srs_ik.kernels.limb.in_line import NEARLY_IN_LINE, closest, may_split, wide_limb
from srs_ik.kernels.limb.triangle import elbow_side

NEARLY_FLAT = 3e-6
"""Bends of the elbow below this, rad from straight or from folded, cannot be told apart within 1e-11 of reach."""

SMALLEST_BEND = 2.5e-10
BENDS = 7
"""So many bends that cannot be told apart are tried where the elbow is as good as flat, each four times the last."""

CLOSING_STEPS = 20
GENTLE = 1e-13
"""Steps to close a posture, and their least damping."""

LOOSELY = 3e-11
"""A split whose posture cannot be closed is one all the same if it meets its pose within this, m and rad."""

GIVE = 3e-4
"""A split that is worse by less than this, rad or of a range, may be better once its posture is closed."""


@kernel
def is_hopeless(value, lowest, seeded):
    """Whether a split of some cost stays worse than the best, however its posture is closed."""
    if seeded:
        return math.sqrt(value) > math.sqrt(lowest) + GIVE
    return value > lowest + GIVE


@kernel
def close_gently(P, q, R, p, respect, J, A):
    """Damped steps from a posture to one that meets its pose: q, and the larger of its errors (m, rad).

    Where more than one joint is singular some directions are as good as lost, and rounding alone would lead far along
    them; the damping leaves them out, as long as the error has no part in them.
    """
    blocked = 0
    for _ in range(CLOSING_STEPS):
        linear, angular = pose_step(P, q, R, p, J)
        error = max(norm(linear), norm(angular))
        if error < 0.1 * CLOSED:
            return q, error
        shortest_step(J, linear, angular, blocked, max(GENTLE, 1e-2 * error * error), A)
        q = moved(q, A, 1.0)
        if respect:
            for j in range(7):
                if q[j] < P[LOWER + j] or q[j] > P[UPPER + j]:
                    blocked |= 1 << j
            q = clipped(P, q)
    return close_free(P, q, R, p, respect, CLOSING_STEPS, J, A)


@kernel
def keep_better(P, target, split, wanted, goal, best, work):
    """The better of a split, closed on the true chain, and the best posture so far, each a posture, branch and cost."""
    start, branch, value = split
    lowest = best[2]
    position, orientation = pose_error(P, start, target.R, target.p)
    off = max(position, orientation)
    if value >= OUTSIDE or off < CLOSED:
        return split if value < lowest else best
    if is_hopeless(value, lowest, goal.seeded):
        return best
    J, A = work
    closed, error = close_gently(P, start, target.R, target.p, goal.respect, J, A)
    if error > CLOSED:
        # With three joints singular at once, not all of a tiny error can be closed.
        return split if off < LOOSELY and value < lowest else best
    if goal.seeded:
        closed, value, _ = slid(P, target, closed, goal, J, A)
    else:
        value = cost(P, closed, goal.seeded, goal.seed, goal.respect)
    branch = branch_of(P, closed)
    if value < lowest and (wanted < 0 or branch == wanted):
        return closed, branch, value
    return best


@kernel
def best_on_circles(P, place_, branch, seed, respect):
    """The best posture over all arm angles: q, branch, cost."""
    found = np.empty((8 * MAX_PIECES, 3))
    n = 0
    if respect:
        n = find_intervals(P, place_, branch, found)
    else:
        for b in range(8):
            if branch < 0 or b == branch:
                found[n, 0], found[n, 1], found[n, 2] = b, -math.pi, math.pi
                n += 1
    if seed is None:
        return farthest(P, place_, found, 0, n, branch, respect)
    return nearest_within(P, place_, found[:n], branch, Goal(True, seed, respect), 4.0 * NO_BRANCH)


@kernel
def search_near_line(limbs, target, wanted, seed, respect, best, work):
    """The best posture of a pose, or a split that is better; the second of two limbs takes axes almost in line so."""
    P, wide = limbs
    goal = Goal(seed is not None, NO_SEED if seed is None else seed, respect)
    circles = False
    for elbow in range(2):
        side = elbow_side(P, target.place, elbow)
        for i in range(4):
            k = SHOULDER if i < 2 else WRIST
            end = i % 2
            if P[k + (TOP_GAP if end == 0 else BOTTOM_GAP)] != 0.0:
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
    if circles:
        best = keep_better(
            P, target, best_on_circles(wide, target.place, wanted, seed, respect), wanted, goal, best, work
        )
    return best


@kernel
def with_splits(P, target, wanted, seed, respect, best):
    """The best posture of a pose as known so far, or a free split that is better, each a posture, branch and cost.

    Args:
        P: packed limb.
        target: the pose.
        wanted: the only branch that counts; -1: all.
        seed: seven angles to be near, or None to be far from the limits.
        respect: whether the limits have to be kept.
        best: best posture so far, its branch and its cost.
    """
    if not may_split(P, target.place):
        return best
    goal = Goal(seed is not None, NO_SEED if seed is None else seed, respect)
    t, h0, bend_c, bend_s, hand, miss = target.place
    boxes = np.empty((1, SIZE))
    wide = row(boxes, 0)
    wide_limb(P, wide)
    work = (np.empty((6, 7)), np.empty((16, 9)))
    best = search_near_line((P, wide), target, wanted, seed, respect, best, work)
    if bend_s < NEARLY_FLAT:
        straight = math.copysign(1.0, bend_c)
        flat = Target(target.R, target.p, (t, h0, straight, 0.0, hand, miss))
        best = search_near_line((P, wide), flat, wanted, seed, respect, best, work)
        for i in range(BENDS):
            bent = (t, h0, straight, SMALLEST_BEND * 4.0**i, hand, miss)
            best = keep_better(P, target, best_on_circles(P, bent, wanted, seed, respect), wanted, goal, best, work)
    keep(boxes)
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
