"""Entry point for the free splits of a pose: the segments of postures that hang at single arm angles."""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import store7
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.jit import entry, kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.layout import search
from srs_ik.kernels.layout.answer import GOOD_POSE, SOLVED
from srs_ik.kernels.limb.branches import NO_BRANCH, side_posture
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.in_line import NEARLY_IN_LINE, closest, is_in_line, may_split, toward_of, wide_limb
from srs_ik.kernels.limb.limits import violation
from srs_ik.kernels.limb.splits import TURN, split_range, with_outer
from srs_ik.kernels.limb.triangle import elbow_side, read_target

IN_LINE = 3e-11
"""Outer axes this close to one line, rad, leave their split free: all postures along it meet the pose within 1e-10."""

EVERYWHERE = 3e-8
"""Where they are never farther from one line than this, rad, as far as rounding can tell, any arm angle will do."""

MOST_TURNS = 8


@kernel
def is_kept(P, q, first, respect):
    """Whether all joints but the two that are free keep their limits."""
    for j in range(7):
        if j != first and j != first + 2 and respect and violation(P, j, q[j]) > P[at.SLACK_LIMIT]:
            return False
    return True


@kernel
def ends(P, first, total, toward, respect):
    """What toward q1 may be with q3 making the sum: first and last; a turn where nothing limits either."""
    low, high = split_range(P, first, total, toward)
    if not respect or (low == -math.inf and high == math.inf):
        return -math.pi, math.pi
    return low, high


@kernel
def first_turn(P, first, total, toward, respect):
    """The sum to begin with, and how many turns of it are told apart by the limits."""
    low_1 = P[at.LOWER + first] if toward > 0.0 else -P[at.UPPER + first]
    high_1 = P[at.UPPER + first] if toward > 0.0 else -P[at.LOWER + first]
    least, most = low_1 + P[at.LOWER + first + 2], high_1 + P[at.UPPER + first + 2]
    if not respect or not math.isfinite(least) or not math.isfinite(most):
        # The joint without limits makes any turn: take the sum next to zero.
        return total - TURN * math.floor(total / TURN + 0.5), 1
    return total + TURN * math.ceil((least - total - P[at.SLACK_LIMIT]) / TURN), MOST_TURNS


@kernel
def write_segments(P, q, k, first, respect, branch, both, psi, everywhere, out, n):
    """Write the segments of a posture whose spherical joint at block k is singular; return the rows in use."""
    toward = toward_of(P, k, q[first + 1])
    total, turns = first_turn(P, first, toward * q[first] + q[first + 2], toward, respect)
    for i in range(turns):
        whole = total + TURN * i
        low, high = ends(P, first, whole, toward, respect)
        if low > high + P[at.SLACK_LIMIT] or n >= out.shape[0]:
            break
        a, b = (low, high) if toward > 0.0 else (high, low)
        r = row(out, n)
        r[search.SPLIT_BRANCH] = branch
        r[search.SPLIT_BOTH] = 1.0 if both else 0.0
        r[search.SPLIT_ARM_ANGLE] = psi
        r[search.SPLIT_EVERYWHERE] = 1.0 if everywhere else 0.0
        r[search.SPLIT_FIRST] = first
        for end in range(2):
            x = a if end == 0 else b
            q1, q3 = toward * x, whole - x
            if respect:
                q1 = min(max(q1, P[at.LOWER + first]), P[at.UPPER + first])
                q3 = min(max(q3, P[at.LOWER + first + 2]), P[at.UPPER + first + 2])
            store7(r, search.SPLIT_LOWER if end == 0 else search.SPLIT_UPPER, with_outer(q, first, q1, q3))
        n += 1
    return n


@entry
def free_splits(family, T, respect, out):
    """Write the free splits of a pose into the rows of out (n, SPLIT_ROW): their number, or minus the verdict."""
    P = row(family, at.LIMITED)
    target, verdict = read_target(P, row(T, 0))
    if verdict != GOOD_POSE:
        return -verdict
    place_ = target.place
    if P[at.IS_CLOSED] != 1.0 or abs(place_[5]) >= SOLVED or not may_split(P, place_):
        return 0
    boxes = np.empty((1, at.SIZE))
    wide = row(boxes, 0)
    wide_limb(P, wide)
    wide[at.SLACK_SINGULAR] = IN_LINE
    n = 0
    for elbow in range(2):
        side = elbow_side(P, place_, elbow)
        for i in range(4):
            k = at.SHOULDER if i < 2 else at.WRIST
            if P[k + (at.TOP_GAP if i % 2 == 0 else at.BOTTOM_GAP)] != 0.0:
                continue
            psi, least, most = closest(P, k, side[1] if i < 2 else side[2], i % 2)
            if least > NEARLY_IN_LINE:
                continue
            for sign in range(2):
                branch = 4 * elbow + (sign if i < 2 else 2 * sign)
                q, _, value = side_posture(wide, side, psi, (branch >> 1) & 1, branch & 1, False, NO_SEED, False)
                first = 0 if i < 2 else 4
                other, other_k = (5, at.WRIST) if i < 2 else (1, at.SHOULDER)
                both = is_in_line(P, other_k, q[other], IN_LINE)
                if value >= NO_BRANCH or not is_in_line(P, k, q[first + 1], IN_LINE) or (both and sign == 1):
                    continue
                if is_kept(P, q, first, respect):
                    n = write_segments(P, q, k, first, respect, branch, both, psi, most < EVERYWHERE, out, n)
    keep(boxes)
    return n
