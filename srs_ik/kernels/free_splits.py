"""Postures of singular poses that no curve over the arm angle passes: free splits of a sum of two joints.

Where the outer axes of the shoulder or of the wrist come into line at some arm angle, a whole segment of postures hangs
there: the pose fixes the sum or the difference of two joints, and leaves its split open. Next to such a pose the
segment is a stretch of a curve so steep that arm angles cannot tell its postures apart. Both are searched here as if
the axes were in line, where the best split is known in closed form, and the posture is then closed on the true chain.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.branches import NO_BRANCH, branch_of, side_posture
from srs_ik.kernels.chain import pose_error
from srs_ik.kernels.closure import CLOSED, clipped, close_free, moved, pose_step, shortest_step
from srs_ik.kernels.elbow import elbow_side
from srs_ik.kernels.intervals import MAX_PIECES, find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import (
    A1,
    A3,
    AXES,
    BOTTOM_GAP,
    COS_STRAIGHT,
    FAR,
    FOREARM,
    LOWER,
    MISS,
    PHASE,
    SHOULDER,
    SIN_STRAIGHT,
    SIZE,
    SLACK_SINGULAR,
    TOP_GAP,
    UPPER,
    UPPER_ARM,
    WRIST,
)
from srs_ik.kernels.margin import farthest
from srs_ik.kernels.memory import keep, row
from srs_ik.kernels.nearest import slid
from srs_ik.kernels.nearest_within import nearest_within
from srs_ik.kernels.scoring import NO_SEED, OUTSIDE, cost
from srs_ik.kernels.vectors import add, apply, dot, load3, norm, rotate

NEARLY_IN_LINE = 1e-4
"""Outer axes that come this close to one line, rad, are searched as if they did; wider apart, the curves tell all."""

NEARLY_FLAT = 3e-6
"""Bends of the elbow below this, rad from straight or from folded, cannot be told apart within 1e-11 of reach."""

ROUNDED = 1e-5
"""A limb that misses by less than this part of its reach has postures all along such a segment, or next to it."""

CLOSING_STEPS = 20
GENTLE = 1e-13
"""Steps to close a posture, and their least damping."""

LOOSELY = 1e-11
"""A split whose posture cannot be closed is one all the same if it meets its pose within this, m and rad."""

GIVE = 3e-4
"""A split that is worse by less than this, rad or of a range, may be better once its posture is closed."""

SMALLEST_REACH = 1e-300
"""Stands for a reach of zero."""


@kernel
def in_line(x, y, P, k):
    """Whether two axes at cosines x and y from a line that one of them turns about come into line, or almost."""
    return (P[k + TOP_GAP] == 0.0 and abs(x - y) < NEARLY_IN_LINE) or (
        P[k + BOTTOM_GAP] == 0.0 and abs(x + y) < NEARLY_IN_LINE
    )


@kernel
def may_split(P, place_):
    """Whether the outer axes of the shoulder or the wrist may come into line at some arm angle: a quick test.

    One of the two stands still while the arm angle turns the other about the line S-W; they meet if both are at the
    same angle from it.
    """
    t, _, c, s, hand, _ = place_
    if P[MISS] > ROUNDED * P[FAR]:
        return False
    still_s = dot(load3(P, SHOULDER + A1), t)
    still_w = dot(apply(hand, load3(P, WRIST + A3)), t)
    a4 = load3(P, AXES + 9)
    for elbow in range(2):
        sine = -s if elbow == 1 else s
        to_wrist = add(load3(P, UPPER_ARM), rotate(a4, c, sine, load3(P, FOREARM)))
        share = 1.0 / max(norm(to_wrist), SMALLEST_REACH)
        if in_line(still_s, share * dot(to_wrist, load3(P, SHOULDER + A3)), P, SHOULDER):
            return True
        c4 = P[COS_STRAIGHT] * c - P[SIN_STRAIGHT] * sine
        s4 = P[SIN_STRAIGHT] * c + P[COS_STRAIGHT] * sine
        if in_line(still_w, share * dot(to_wrist, rotate(a4, c4, s4, load3(P, WRIST + A1))), P, WRIST):
            return True
    return False


@kernel
def closest(P, k, motion, end):
    """Arm angle at which the outer axes of a spherical joint come closest to one line: it, and how close, rad.

    The end says whether they point the same way there (0) or opposite ways (1). Last, how close they are elsewhere.
    """
    circle = motion[0]
    a1 = load3(P, k + A1)
    sign = 1.0 if end == 0 else -1.0
    constant = sign * dot(a1, circle[0])
    c = sign * dot(a1, circle[1])
    s = sign * dot(a1, circle[2])
    r = math.sqrt(c * c + s * s)
    least = math.sqrt(max(2.0 * (1.0 - constant - r), 0.0))
    most = math.sqrt(max(2.0 * (1.0 - constant + r), 0.0))
    return math.atan2(s, c), least, most


@kernel
def toward_of(P, k, q2):
    """1.0 where the outer axes of a spherical joint next to its singularity point the same way, else -1.0."""
    return 1.0 if math.cos(q2 - P[k + PHASE]) > 0.0 else -1.0


@kernel
def is_in_line(P, k, q2, width):
    """Whether the outer axes of a spherical joint are within some angle of one line."""
    gap = P[k + TOP_GAP] if toward_of(P, k, q2) > 0.0 else P[k + BOTTOM_GAP]
    return gap == 0.0 and abs(math.sin(q2 - P[k + PHASE])) < width


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
def best_on_circles(P, place_, branch, seed, respect):
    """The best posture where every arm angle has free splits: q, branch, cost."""
    found = np.empty((8 * MAX_PIECES, 3))
    n = find_intervals(P, place_, branch, found)
    if seed is None:
        return farthest(P, place_, found, 0, n, branch, respect)
    return nearest_within(P, place_, found, n, branch, seed, respect, 4.0 * NO_BRANCH)


@kernel
def search_near_line(P, wide, place_, R, p, wanted, seed, respect, q, best, lowest, J, A):
    """The best posture of a pose, or a split that is better: q, branch, cost; `wide` takes axes almost in line so."""
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
    return q, best, lowest


@kernel
def wide_limb(P, wide):
    """Copy the packed limb to `wide`, which takes axes for parallel that are almost so."""
    for i in range(SIZE):
        wide[i] = P[i]
    wide[SLACK_SINGULAR] = NEARLY_IN_LINE


@kernel
def with_splits(P, place_, R, p, wanted, seed, respect, q, best, lowest):
    """The best posture of a pose as known so far, or a free split that is better: q, branch, cost.

    Args:
        P: packed limb.
        place_: the pose, from `elbow.place`.
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
    t, h0, bend_c, bend_s, hand, miss = place_
    boxes = np.empty((1, SIZE))
    wide = row(boxes, 0)
    wide_limb(P, wide)
    J, A = np.empty((6, 7)), np.empty((16, 9))
    q, best, lowest = search_near_line(P, wide, place_, R, p, wanted, seed, respect, q, best, lowest, J, A)
    if 0.0 < bend_s < NEARLY_FLAT:
        flat = (t, h0, math.copysign(1.0, bend_c), 0.0, hand, miss)
        q, best, lowest = search_near_line(P, wide, flat, R, p, wanted, seed, respect, q, best, lowest, J, A)
    keep(boxes)
    return q, best, lowest


@kernel
def settled_split(P, place_, R, p, q, branch, lowest, seed, respect):
    """A posture next to a singular one, or the nearer one around it that no arm angle can tell apart from it."""
    if not may_split(P, place_) or lowest >= OUTSIDE:
        return q, branch, lowest
    nearer, value, _ = slid(P, q, R, p, seed, respect, np.empty((6, 7)), np.empty((16, 9)))
    return (nearer, branch_of(P, nearer), value) if value < lowest else (q, branch, lowest)
