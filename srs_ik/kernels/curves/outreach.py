"""Small closed curves of a pose next to the end of the reach, which arm angles all around pass by.

With the elbow almost straight or folded, how far the true chain reaches differs from one turn of the elbow about the
line S-W to another, by what the axes miss. Close to the farthest it reaches a pose at some of these turns alone: about
a turn at which its reach, with the best bend of the elbow, is greater than at all others near it.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7, largest, store7
from srs_ik.kernels.algebra.linear import solve_linear
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.newton import pose_step
from srs_ik.kernels.chain.starts import almost_straight
from srs_ik.kernels.curves.surface import level_place
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FAR, NEAR
from srs_ik.kernels.limb.branches import side_posture, sine_of
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.triangle import elbow_side

TURNS = 12
"""Turns, all around, between which the greatest reaches are looked for."""

STEPS = 8
"""Newton's steps to the best bend at a turn, at most ..."""

SETTLED = 1e-5
"""... and the step, rad, that is the last one."""

CUTS = 12
"""Steps to a greatest reach between two turns, at most."""

LEVEL = 1e-10
"""The rise with a turn, m/rad, that is none."""

NARROWEST = 1e-9
"""Two turns closer than this, rad, are one."""

LEAST_BEND = 5e-5
ROOM = 1e-2
"""Where the best bend leaves less room than this, rad, to both sides, Newton's method closes no posture for certain:
the greatest reach tells then by itself what there is around it (`rank_five`). With the second one, it does without the
very greatest reach."""

HIGHEST = 2.0
"""Between two turns reaches are no greater than either goes on to rise, so many times, and parts of the reach ..."""

HIGHER = 1e-3
"""... above that."""

CLEAR = 2.0
"""Where the elbow is almost straight, shoulder and wrist are clear of singularities that are so many bends away."""

LONGEST_STEP = 0.5
"""A longer step, rad, leads to no posture nearby."""


@kernel
def answer_to(J, t, right, A):
    """Steps of joints 1, 2, 5, 6 and 7 that make up for a twist `right`, but for a way along S-W, and for the bend's.

    They end in columns 6 and 7, the ways along S-W below them (`answer`). Returns whether there are any.
    """
    for i in range(6):
        A[i, 0], A[i, 1] = J[i, 0], J[i, 1]
        A[i, 2], A[i, 3], A[i, 4] = J[i, 4], J[i, 5], J[i, 6]
        A[i, 5] = -t[i] if i < 3 else 0.0
        A[i, 6], A[i, 7] = right[i], -J[i, 3]
    return solve_linear(A, 6) != 0.0


@kernel
def answer(A, column, turn, bend):
    """The steps in a column, with those of joints 3 and 4 given, and the way along S-W."""
    return (A[0, column], A[1, column], turn, bend, A[2, column], A[3, column], A[4, column]), A[5, column]


@kernel
def best_bend(P, by, q, curvature):
    """The posture at a turn whose bend reaches farthest along S-W: how far past the pose, and how that goes on.

    Returned are the posture, the reach past the pose, its rise with the turn, the ways of the joints with the turn and
    with the bend, and whether there is one.
    """
    R, p, place_ = by.target
    J, t = by.J, place_[0]
    bending = NO_SEED
    past = 0.0
    for _ in range(STEPS):
        linear, angular = pose_step(P, q, R, p, J)
        good = answer_to(J, t, (linear[0], linear[1], linear[2], angular[0], angular[1], angular[2]), by.A)
        step, past = answer(by.A, 6, 0.0, 0.0)
        bending, slope = answer(by.A, 7, 0.0, 1.0)
        step = along7(step, -slope / curvature, bending)
        size = largest(step)
        if not (good and size < LONGEST_STEP):
            return q, past, 0.0, NO_SEED, bending, False
        q = along7(q, 1.0, step)
        if size < SETTLED:
            break
    good = answer_to(J, t, (-J[0, 2], -J[1, 2], -J[2, 2], -J[3, 2], -J[4, 2], -J[5, 2]), by.A)
    turning, rise = answer(by.A, 6, 1.0, 0.0)
    return q, past, rise, turning, bending, good


@kernel
def put_outermost(P, by, which, starts, n):
    """Append postures of the curves about the greatest reaches that are past a pose, or those of these; their number.

    `which` are, as bits, the signs of shoulder and wrist with which the pose is not reached all around. Returned too
    are those of them that have no other curves: away from other singularities a pose is reached with the turns at which
    the reach is past it, about these greatest ones. Where it is past it, or not, by rounding, nothing is told.
    """
    place_ = by.target.place
    told = 0
    if place_[3] >= almost_straight(P) or P[NEAR] < NARROWEST:
        return n, told
    level = level_place(place_)
    reach = P[FAR] if level[2] > 0.0 else -P[NEAR]
    curvature = (P[NEAR] - P[FAR]) * (P[NEAR] + P[FAR]) / (2.0 * reach)
    away = math.copysign(1.0, reach)
    width = HIGHEST * 2.0 * math.pi / TURNS
    side = elbow_side(P, level, 0)
    for signs in range(4):
        if not which >> signs & 1:
            continue
        q, _, _ = side_posture(P, side, 0.0, signs >> 1, signs & 1, False, NO_SEED, False)
        # The sines of shoulder and wrist change with the turn by no more than the bend.
        clear = min(abs(sine_of(P, q, 0)), abs(sine_of(P, q, 2))) > CLEAR * almost_straight(P)
        q, past, rise, turning, _, good = best_bend(P, by, q, curvature)
        first, parts, reached = n, 0, 0
        for _ in range(TURNS):
            if not good:
                break
            begin, past_before = (q, rise, turning), past * away
            q = along7(q, 2.0 * math.pi / TURNS, turning)
            q, past, rise, turning, _, good = best_bend(P, by, q, curvature)
            clear = clear and abs(2.0 * past / curvature) > LEAST_BEND**2
            parts += 1 if past_before <= 0.0 < past * away else 0
            reached += 1 if past * away > 0.0 else 0
            top = min(past_before + width * abs(begin[1]), past * away + width * abs(rise))
            between = away * begin[1] > 0.0 and away * rise <= 0.0 and top > -HIGHER * P[FAR]
            if good and between and n + 2 <= starts.shape[0]:
                n = put_pair(P, by, begin, (q[2], rise), curvature, starts, n)
        if good and clear and reached < TURNS and n - first >= 2 * parts:
            told |= 1 << signs
    return n, told


@kernel
def put_pair(P, by, before, behind, curvature, starts, n):
    """Append both bends of the greatest reach between two turns, if it is past the pose; if only just, itself.

    The first is given by its best posture, rise and way with the turn, the second by joint 3 and its rise.
    """
    best, low, turning = before
    begin, (end, high) = best[2], behind
    past, bending, good = 0.0, NO_SEED, False
    for _ in range(CUTS):
        part = begin + (end - begin) * low / (low - high)
        there = along7(best, part - best[2], turning)
        best, past, rise, turning, bending, good = best_bend(P, by, there, curvature)
        enough = past * curvature < -0.5 * (ROOM * curvature) ** 2
        if not good or enough or abs(rise) < LEVEL or end - begin < NARROWEST:
            break
        if (rise > 0.0) == (low > 0.0):
            begin, low, high = part, rise, 0.5 * high
        else:
            end, high, low = part, rise, 0.5 * low
    room = -2.0 * past / curvature
    if good and abs(room) < LEAST_BEND**2:
        store7(row(starts, n), 0, best)
        n += 1
    elif good and room > 0.0:
        bend = math.sqrt(room)
        for sign in range(2):
            there = along7(best, bend if sign == 0 else -bend, bending)
            store7(row(starts, n), 0, there)
            n += 1
    return n
