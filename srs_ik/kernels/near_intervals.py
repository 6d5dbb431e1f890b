"""Feasible arm angles of a near limb, on its true chain.

There the joint angles are no roots of linear forms any more: each branch is followed around the circle, and every end
of an interval is found by bisection of the true postures. The nearest exact limb's intervals say where else to look.
"""

from __future__ import annotations

import math

from srs_ik.kernels.branches import NO_BRANCH
from srs_ik.kernels.elbow import elbow_side
from srs_ik.kernels.intervals import TURN, join_touching, write_interval
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import LOWER, RANGE_KIND, UPPER
from srs_ik.kernels.search import GOLDEN, evaluate_branch

LOOKS = 96
"""Arm angles of a branch that are looked at, and as many again at most where the exact limb has intervals."""

NARROW = 0.2
"""A peak of the margin this little below zero, rad, may hide an interval narrower than the spacing."""

NOWHERE = -10.0
"""Margin where the branch has no posture."""


@kernel
def slack_at(P, place_, side, R, p, psi, branch, J, A):
    """Smallest distance of a joint from its limits at an arm angle, rad; negative outside."""
    none = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    q, value = evaluate_branch(P, place_, side, R, p, psi, branch, False, none, False, J, A)
    if value >= NO_BRANCH:
        return NOWHERE
    smallest = 10.0
    for j in range(7):
        if P[RANGE_KIND + j] != 0.0:
            smallest = min(smallest, q[j] - P[LOWER + j], P[UPPER + j] - q[j])
    return smallest


@kernel
def boundary(P, place_, side, R, p, inside, outside, branch, J, A):
    """The last feasible arm angle on the way from a feasible to an infeasible one, by bisection."""
    for _ in range(48):
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            break
        if slack_at(P, place_, side, R, p, middle, branch, J, A) >= 0.0:
            inside = middle
        else:
            outside = middle
    return inside


@kernel
def peak(P, place_, side, R, p, lower, upper, branch, J, A):
    """The arm angle of the largest slack between two, by golden section, and that slack."""
    a = lower
    b = upper
    for _ in range(32):
        x = b - GOLDEN * (b - a)
        y = a + GOLDEN * (b - a)
        fx = slack_at(P, place_, side, R, p, x, branch, J, A)
        if fx >= 0.0:
            return x, fx
        fy = slack_at(P, place_, side, R, p, y, branch, J, A)
        if fy >= 0.0:
            return y, fy
        if fx >= fy:
            b = y
        else:
            a = x
    return 0.5 * (a + b), NOWHERE


@kernel
def looks(found, n, branch, psis):
    """Fill in the sorted arm angles at which a branch is looked at; found holds the intervals of the exact limb."""
    count = LOOKS
    for i in range(LOOKS):
        psis[i] = -math.pi + TURN * i / LOOKS
    for i in range(n):
        if int(found[i, 0]) == branch and count < psis.shape[0]:
            middle = 0.5 * (found[i, 1] + found[i, 2])
            middle -= TURN * math.floor((middle + math.pi) / TURN)
            k = count
            while k > 0 and psis[k - 1] > middle:
                psis[k] = psis[k - 1]
                k -= 1
            psis[k] = middle
            count += 1
    return count


@kernel
def true_intervals(P, place_, R, p, found, n_found, psis, slacks, out, J, A):
    """Write (branch, lower, upper) of the feasible intervals of a near limb into the rows of out; return their number.

    Args:
        P: packed limb.
        place_: the pose, from `elbow.place`.
        R: rotation of the pose.
        p: position of the pose.
        found: (n_found, 3) intervals of the nearest exact limb.
        n_found: their number.
        psis: (2 LOOKS,) work space.
        slacks: (2 LOOKS,) work space.
        out: (n, 3) output.
        J: (6, 7) work space.
        A: (7, 9) work space.
    """
    n = 0
    for branch in range(8):
        side = elbow_side(P, place_, branch >> 2)
        count = looks(found, n_found, branch, psis)
        feasible = 0
        for i in range(count):
            slacks[i] = slack_at(P, place_, side, R, p, psis[i], branch, J, A)
            if slacks[i] >= 0.0:
                feasible += 1
        first = n
        if feasible == count:
            n = write_interval(out, first, n, branch, -math.pi, math.pi)
            out[n - 1, 2] = math.pi
            continue
        for i in range(count):
            before = psis[i - 1] if i > 0 else psis[count - 1] - TURN
            behind = psis[i + 1] if i + 1 < count else psis[0] + TURN
            slack_before = slacks[i - 1] if i > 0 else slacks[count - 1]
            slack_behind = slacks[i + 1] if i + 1 < count else slacks[0]
            if slacks[i] >= 0.0:
                lower = psis[i]
                if slack_before < 0.0:
                    lower = boundary(P, place_, side, R, p, psis[i], before, branch, J, A)
                upper = behind
                if slack_behind < 0.0:
                    upper = boundary(P, place_, side, R, p, psis[i], behind, branch, J, A)
                n = write_interval(out, first, n, branch, lower, upper)
            elif slacks[i] > -NARROW and slacks[i] >= slack_before and slacks[i] >= slack_behind:
                top, slack = peak(P, place_, side, R, p, before, behind, branch, J, A)
                if slack >= 0.0:
                    lower = boundary(P, place_, side, R, p, top, before, branch, J, A)
                    upper = boundary(P, place_, side, R, p, top, behind, branch, J, A)
                    n = write_interval(out, first, n, branch, lower, upper)
        if n > first:
            n = join_touching(out, first, n)
    return n
