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
from srs_ik.kernels.exact.bends import best_of_bends, best_on_circles
from srs_ik.kernels.exact.nearest import slid
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import (
    BOTTOM_GAP,
    LOWER,
    SHOULDER,
    SIZE,
    TOP_GAP,
    UPPER,
    WRIST,
)
from srs_ik.kernels.limb.branches import branch_of, side_posture
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, cost
from srs_ik.kernels.limb.in_line import NEARLY_IN_LINE, closest, may_split, wide_limb
from srs_ik.kernels.limb.triangle import elbow_side

NEARLY_FLAT = 3e-6
"""Bends of the elbow below this, rad from straight or from folded, cannot be told apart within 1e-11 of reach."""

SMALLEST_BEND = 2.5e-10
"""The smallest bend that is tried where the limits leave none of those that a pose may have."""

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
def keep_better(P, R, p, start, branch, value, wanted, seeded, seed, respect, q, best, lowest, J, A):
    """The better of a split, closed on the true chain, and the best posture so far: q, branch, cost."""
    position, orientation = pose_error(P, start, R, p)
    off = max(position, orientation)
    if value >= OUTSIDE or off < CLOSED:
        return (start, branch, value) if value < lowest else (q, best, lowest)
    if is_hopeless(value, lowest, seeded):
        return q, best, lowest
    closed, error = close_gently(P, start, R, p, respect, J, A)
    if error > CLOSED:
        # With three joints singular at once, not all of a tiny error can be closed.
        return (start, branch, value) if off < LOOSELY and value < lowest else (q, best, lowest)
    if seeded:
        closed, value, _ = slid(P, closed, R, p, seed, respect, J, A)
    else:
        value = cost(P, closed, seeded, seed, respect)
    branch = branch_of(P, closed)
    if value < lowest and (wanted < 0 or branch == wanted):
        return closed, branch, value
    return q, best, lowest


@kernel
def search_near_line(P, wide, place_, R, p, wanted, seed, respect, q, best, lowest, J, A):
    """The best posture of a pose, or a split that is better: q, branch, cost, and whether axes stay in line.

    `wide` takes axes almost in line so; in line at all arm angles they lie along the line S-W.
    """
    seeded = seed is not None
    goal = NO_SEED if seed is None else seed
    circles = False
    for elbow in range(2):
        side = elbow_side(P, place_, elbow)
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
                    start, _, value = side_posture(wide, side, psi, (b >> 1) & 1, b & 1, seeded, goal, respect)
                    q, best, lowest = keep_better(
                        P, R, p, start, b, value, wanted, seeded, goal, respect, q, best, lowest, J, A
                    )
    if circles:
        start, b, value = best_on_circles(wide, place_, wanted, seed, respect)
        q, best, lowest = keep_better(P, R, p, start, b, value, wanted, seeded, goal, respect, q, best, lowest, J, A)
    return q, best, lowest, circles


@kernel
def with_splits(P, place_, R, p, wanted, seed, respect, q, best, lowest):
    """The best posture of a pose as known so far, or a free split that is better: q, branch, cost.

    Args:
        P: packed limb.
        place_: the pose, from `triangle.place`.
        R: rotation of the tip pose.
        p: position of the tip pose.
        wanted: the only branch that counts; -1: all.
        seed: seven angles to be near, or None to be far from the limits.
        respect: whether the limits have to be kept.
        q: best posture so far.
        best: its branch.
        lowest: its cost.
    """
    if not may_split(P, place_):
        return q, best, lowest
    goal = NO_SEED if seed is None else seed
    t, h0, bend_c, bend_s, hand, miss = place_
    boxes = np.empty((1, SIZE))
    wide = row(boxes, 0)
    wide_limb(P, wide)
    J, A = np.empty((6, 7)), np.empty((16, 9))
    q, best, lowest, along = search_near_line(P, wide, place_, R, p, wanted, seed, respect, q, best, lowest, J, A)
    if bend_s < NEARLY_FLAT:
        flat = (t, h0, math.copysign(1.0, bend_c), 0.0, hand, miss)
        q, best, lowest, alike = search_near_line(P, wide, flat, R, p, wanted, seed, respect, q, best, lowest, J, A)
        along = along or alike
    if along:
        start, b, value = best_of_bends(P, place_, wanted, seed, respect, lowest)
        seeded = seed is not None
        q, best, lowest = keep_better(P, R, p, start, b, value, wanted, seeded, goal, respect, q, best, lowest, J, A)
    keep(boxes)
    return q, best, lowest


@kernel
def settled_split(P, place_, R, p, q, branch, lowest, seed, respect):
    """A posture next to a singular one, or the nearer one around it that no arm angle can tell apart from it."""
    if not may_split(P, place_) or lowest >= OUTSIDE:
        return q, branch, lowest
    nearer, value, _ = slid(P, q, R, p, seed, respect, np.empty((6, 7)), np.empty((16, 9)))
    return (nearer, branch_of(P, nearer), value) if value < lowest else (q, branch, lowest)
