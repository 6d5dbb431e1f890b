"""Feasible arm angles of the eight branches, exactly: from roots of linear forms in cosine and sine of the arm angle.

With the elbow angle fixed, every vector that the shoulder or the wrist has to turn moves on a circle with the arm
angle. A joint reaches a limit where one linear form vanishes (method of Shimizu et al. 2008 and Faria et al. 2018, here
for axes in any direction), so the arm angles at which anything can change are known; between two of them one test
decides.
"""

import math

import numpy as np

from srs_ik.kernels.exact.events import PI, TURN, joint_events
from srs_ik.kernels.exact.gaps import almost_fits, end_of_gap, feasible_signs, mark_gaps
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_EVENTS, MAX_PIECES
from srs_ik.kernels.layout.limb import SHOULDER, SLACK_JOIN, WRIST
from srs_ik.kernels.limb.limits import turn_to_middle, violation
from srs_ik.kernels.limb.triangle import elbow_side

SAME = 1e-12
"""Ends closer than this, rad, are one."""

TOUCHING = 1e-7
"""Arm angles that two joints keep apart by less than this, rad, may be one for both; whether it is, is looked at."""

ALONE = 0.01
"""What may be one arm angle ends short of its neighbours by this part of its width at most."""


@kernel
def write_piece(pieces, sign, n, lower, upper):
    """Append an interval to the pieces of a solution."""
    pieces[sign, n, 0], pieces[sign, n, 1] = lower, upper
    return n + 1


@kernel
def may_touch(P, apart):
    """Whether two joints of a limb whose arm angles are known only nearly may meet their limits at the same one.

    The two solutions of a spherical joint meet equal limits of the middle one at the same arm angle anyhow.
    """
    return TOUCHING < P[SLACK_JOIN] > apart > SAME


@kernel
def sign_pieces(P, k, motion, wanted, events, marks, n, sign, pieces):
    """Feasible arm angles of one solution of a spherical joint as circular intervals, from marked gaps; their number.

    A full circle is the single piece (-pi, pi).
    """
    bit = 1 << sign
    start, some = -1, False
    for i in range(n):
        if marks[i] & bit:
            some = True
            if not marks[i - 1 if i > 0 else n - 1] & bit:
                start = i
                break
    if some and start < 0:
        return write_piece(pieces, sign, 0, -PI, PI)
    count, i = 0, 0
    while start >= 0 and i < n:
        length = 0
        while i + length < n and marks[(start + i + length) % n] & bit:
            length += 1
        if length == 0:
            i += 1
            continue
        last = (start + i) % n + length
        count = write_piece(pieces, sign, count, events[(start + i) % n], events[last % n] + TURN * (last // n))
        i += length
    # Single arm angles at which a joint just touches a limit from outside, or may.
    for i in range(n):
        before = marks[i - 1 if i > 0 else n - 1]
        if wanted & bit and (before | marks[i]) & bit == 0:
            end = end_of_gap(events, n, i)
            if may_touch(P, end - events[i]):
                count = write_piece(pieces, sign, count, events[i], end)
            elif feasible_signs(P, k, motion, events[i], bit):
                count = write_piece(pieces, sign, count, events[i], events[i])
    return count


@kernel
def joint_pieces(P, k, motion, wanted, events, marks, pieces):
    """Feasible arm angles of the wanted solutions of a spherical joint (bits); how many pieces each of the two has."""
    n = joint_events(P, k, motion, events)
    mark_gaps(P, k, motion, wanted, events, n, marks)
    if n == 0:
        events[0] = 0.0
        marks[0] = feasible_signs(P, k, motion, 0.0, wanted)
        n = 1
    n0 = sign_pieces(P, k, motion, wanted, events, marks, n, 0, pieces)
    return n0, sign_pieces(P, k, motion, wanted, events, marks, n, 1, pieces)


@kernel
def write_interval(out, first, n, branch, lower, upper):
    """Insert an interval, lower end brought to [-pi, pi), into the sorted rows first to n - 1 of a branch."""
    if n >= out.shape[0]:
        return n
    shift = TURN * math.floor((lower + PI) / TURN)
    lower = max(lower, shift - PI)
    i = n
    while i > first and out[i - 1, 1] > lower - shift:
        out[i, 1] = out[i - 1, 1]
        out[i, 2] = out[i - 1, 2]
        i -= 1
    out[i, 1] = lower - shift
    out[i, 2] = max(upper, lower) - shift
    out[n, 0] = branch
    return n + 1


@kernel
def join_touching(out, first, n):
    """Join the sorted intervals of a branch that touch, also around the circle; return the number of rows in use."""
    last = first
    for i in range(first + 1, n):
        if out[i, 1] <= out[last, 2] + SAME:
            out[last, 2] = max(out[last, 2], out[i, 2])
        else:
            last += 1
            out[last, 1] = out[i, 1]
            out[last, 2] = out[i, 2]
    while last > first and out[first, 1] + TURN <= out[last, 2] + SAME:
        upper = max(out[last, 2], out[first, 2] + TURN)
        for i in range(first, last):
            out[i, 1] = out[i + 1, 1]
            out[i, 2] = out[i + 1, 2]
        last -= 1
        out[last, 2] = upper
    if out[first, 2] - out[first, 1] >= TURN - SAME:
        out[first, 1] = -PI
        out[first, 2] = PI
    return last + 1


@kernel
def touch(P, motions, signs, a, b):
    """The arm angle at which a shoulder and a wrist solution touch that rounding keeps apart, and whether they do.

    Their pieces a and b end (lower, upper) next to each other; one that is a single arm angle by rounding may be right
    at its other end.
    """
    lower, upper = max(a[0], b[0]), min(a[1], b[1])
    middle = 0.5 * (lower + upper)
    for i in range(5):
        psi = middle
        if i > 0:
            psi = (lower if i == 1 else upper) if i < 3 else (min(a[0], b[0]) if i == 3 else max(a[1], b[1]))
        near = abs(psi - middle) <= TOUCHING
        if (
            near
            and almost_fits(P, SHOULDER, motions[0], psi, signs[0])
            and almost_fits(P, WRIST, motions[1], psi, signs[1])
        ):
            return psi, True
    return middle, False


@kernel
def intersect(P, motions, a, b, branch, out, n):
    """Append the arm angles feasible for both a shoulder and a wrist solution: a and b, as pieces, their number, sign.

    Where one begins as the other ends, rounding may part them, the farther the more slowly a joint reaches its end.
    """
    if a[1] == 0 or b[1] == 0:
        return n
    first = n
    of_a, of_b = a[0][a[2]], b[0][b[2]]
    if of_b[0, 1] - of_b[0, 0] >= TURN:
        for i in range(a[1]):
            n = write_interval(out, first, n, branch, of_a[i, 0], of_a[i, 1])
    elif of_a[0, 1] - of_a[0, 0] >= TURN:
        for j in range(b[1]):
            n = write_interval(out, first, n, branch, of_b[j, 0], of_b[j, 1])
    else:
        for i in range(a[1]):
            for j in range(b[1]):
                for turns in range(-1, 2):
                    other = (of_b[j, 0] + turns * TURN, of_b[j, 1] + turns * TURN)
                    lower = max(of_a[i, 0], other[0])
                    upper = min(of_a[i, 1], other[1])
                    if lower <= upper:
                        n = write_interval(out, first, n, branch, lower, upper)
                    elif lower <= upper + max(TOUCHING, P[SLACK_JOIN]):
                        psi, met = touch(P, motions, (a[2], b[2]), (of_a[i, 0], of_a[i, 1]), other)
                        if may_touch(P, lower - upper):
                            # Alone, so that it does not join what two gaps keep apart.
                            spare = min(ALONE * (lower - upper), 2.0 * SAME)
                            n = write_interval(out, first, n, branch, upper + spare, lower - spare)
                        elif met or lower <= upper + P[SLACK_JOIN]:
                            n = write_interval(out, first, n, branch, psi, psi)
    return join_touching(out, first, n) if n > first else n


@kernel
def find_intervals(P, place_, branch, out):
    """Feasible intervals of one pose, as `intervals_of` writes them; their number."""
    return intervals_of(P, (elbow_side(P, place_, 0), elbow_side(P, place_, 1)), branch, out)


@kernel
def intervals_of(P, sides, branch, out):
    """Write (branch, lower, upper) of every feasible interval of arm angles into the rows of out; return their number.

    The limb is packed without limits where they are not to count (the reach of oblique axes always does); `sides` are
    both of a pose, from `triangle.elbow_side`; branch -1 stands for all. The intervals are sorted, branch after branch;
    8 x MAX_PIECES rows always suffice.
    """
    events, marks = np.empty(MAX_EVENTS), np.empty(MAX_EVENTS, np.int64)
    shoulder, wrist = np.empty((2, MAX_PIECES, 2)), np.empty((2, MAX_PIECES, 2))
    n = 0
    wanted_s = 3 if branch < 0 else 1 << ((branch >> 1) & 1)
    wanted_w = 3 if branch < 0 else 1 << (branch & 1)
    for elbow in range(2):
        if branch >= 0 and branch >> 2 != elbow:
            continue
        q4, motion_s, motion_w, _ = sides[elbow]
        if violation(P, 3, turn_to_middle(P, 3, q4)) > 0.0:
            continue
        s = joint_pieces(P, SHOULDER, motion_s, wanted_s, events, marks, shoulder)
        if s[0] + s[1] == 0:
            continue
        w = joint_pieces(P, WRIST, motion_w, wanted_w, events, marks, wrist)
        for i in range(2):
            for j in range(2):
                number = 4 * elbow + 2 * i + j
                n = intersect(P, (motion_s, motion_w), (shoulder, s[i], i), (wrist, w[j], j), number, out, n)
    return n
