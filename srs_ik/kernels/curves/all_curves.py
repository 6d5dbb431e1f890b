"""All curves of a pose on the true chain of a near limb, from starts that the closed form gives."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, dot7, short_way, store7
from srs_ik.kernels.algebra.lanes import ALL, eight_of, one_of, scatter
from srs_ik.kernels.algebra.pointers import copy, read7, row
from srs_ik.kernels.chain import newton
from srs_ik.kernels.chain.eight import put_eight, take_eight
from srs_ik.kernels.chain.newton_eight import close_eight
from srs_ik.kernels.chain.rank_five import BLUR, CENTRE, is_among, put_amid
from srs_ik.kernels.chain.starts import FIRST, WIDTH, bent_place, put_splits, start_all, width_of_splits
from srs_ik.kernels.curves import in_step, outreach
from srs_ik.kernels.curves.ends import inside_of_blur
from srs_ik.kernels.curves.follow import (
    CURVE,
    correct,
    extend_back,
    follow_through,
    is_known,
    put,
    tangent_at,
    vagueness,
)
from srs_ik.kernels.curves.in_step import CORRECTIONS, SAMPLE, load_sample, on_way, one_of_seven, to_curves
from srs_ik.kernels.curves.laid import lay_curves
from srs_ik.kernels.curves.marks import MARK, MARK_NEXT, MARK_WAY, follow_marks, join_pieces, put_behind_ends, put_mark
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import BOTTOM_GAP, FAR, SHOULDER, TOP_GAP, WRIST
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.limits import turn_to_middle, violation
from srs_ik.kernels.limb.surface import EVERY_SPLIT, level_place, put_midway, put_starts

STARTS = 8
STARTS_OBLIQUE = 48
"""Arm angles, all around, at which the closed form gives starts; a branch of oblique axes may be a short arc."""

MOST_ANGLES = STARTS_OBLIQUE + 16
"""And others between these."""

ASIDE = 2.0
"""Where shoulder or wrist come within so many of the widths at which they count as singular, there are others."""

MOST_BOUNCED, BOUNCED = 6, 1e-2
"""Of starts with the same signs of shoulder and wrist, so many one after the other may end with an error above the
second one, m and rad: they are led about where no posture is, and so are most likely the others."""

MORE_STARTS = 512
"""Room for starts where several parts of a limb are singular."""

OBLIQUE = 1e-3
"""Axes are oblique where this part of all directions, as a cosine, is beyond the reach of a shoulder or wrist."""

CLOSING_STEPS = 16
"""Newton's steps from a start to a curve, at most."""

MAX_CURVES = 32
MOST_LEFT = 8
"""Curves of a pose, and those on which an error is left (`LEFT`), at most."""

LONGER = 4.0
"""Curves are longer by this than what rounding makes of their postures."""

POINT = 1e-12
"""Length of a curve that is one posture, rad."""

ELBOW_SPARE = 0.5
"""By so much, rad, q4 of a start may be outside its limits where limits count."""


CUTS = 12
"""Steps to a greatest reach between two turns, at most."""

LEVEL = 1e-10
"""The rise of the room with a turn, rad, that is none."""

NARROWEST_TURN = 1e-9
"""Two turns closer than this, rad, are one."""

HIGHEST = 2.0
"""Between two turns reaches are no greater than either goes on to rise, so many times, and parts of the reach ..."""

HIGHER = 1e-3
"""... above that."""

WELL_TOLD = 1e-3
"""Where the greatest room is within the square of this, rad, of none, rounding decides what there is."""

ROOM = 1e-2
"""Where the best bend leaves so much room, rad, to both sides, Newton's method does without the very greatest reach."""


@kernel
def put_angles(P, place_, around, angles):
    """Write the arm angles at which the closed form gives starts: some all around, and others; their number."""
    for i in range(around):
        angles[i] = (2.0 * i / around - 1.0) * math.pi
    near = ASIDE * width_of_splits(P, place_), 2.0 * math.pi / around
    return put_midway(P, place_, near, angles, around)


@kernel
def put_marks(P, by, angles, oblique, marks, missed):
    """Marks on all curves, from the closed form at some arm angles; how many, and how many starts are missed.

    `missed` takes the postures from which Newton's method in step does not reach the pose. Returned last are, as bits,
    the signs of shoulder and wrist of which some are.
    """
    R, p, place_ = by.target
    A = by.A
    starts = row(A, FIRST)
    count = 0
    n_missed, signs = 0, 0
    for i in range(angles.shape[0]):
        psi = angles[i]
        exist = start_all(P, bent_place(P, place_), psi, False, NO_SEED, False, A)
        closed, met = close_eight(P, take_eight(starts, WIDTH), R, p, place_[0], place_[1], psi, newton.STEPS)
        put_eight(starts, WIDTH, met, closed)
        # Where a branch has no posture at the arm angle, there may be one next to it.
        which = ALL if oblique else exist
        closed, t, met = to_curves(P, R, p, take_eight(starts, WIDTH), which, (CORRECTIONS, 0.0))
        put_eight(starts, WIDTH, met, closed)
        for branch in range(8):
            q = read7(row(A, FIRST + branch))
            spare = ELBOW_SPARE - violation(P, 3, turn_to_middle(P, 3, q[3])) if by.respect else ELBOW_SPARE
            # At the edge of the reach of oblique axes, the true chain may have postures where the closed form has none.
            if spare < 0.0 or not (oblique or (exist >> branch) & 1 == 1):
                continue
            if (met >> branch) & 1 == 1:
                count = put_mark(marks, 0, count, q, one_of_seven(t, branch))
            else:
                for j in range(7):
                    missed[n_missed, j] = q[j]
                n_missed += 1
                signs |= 1 << (branch & 3)
    return count, n_missed, signs


@kernel
def bring_to_curves(P, by, starts, first, n):
    """Bring the starts in rows first to n - 1 to curves, eight in step; those that are have 1 for the mark behind."""
    R, p, _ = by.target
    for i in range(first, n, 8):
        # The last eight rows there are may begin before.
        k = min(i, starts.shape[0] - 8)
        rows = row(starts, k)
        which = (1 << min(n - k, 8)) - 1
        q, t, met = to_curves(P, R, p, take_eight(rows, MARK), which, (CLOSING_STEPS, 0.0))
        put_eight(rows, MARK, met, q)
        for j in range(7):
            scatter(rows, MARK_WAY + j, MARK, t[j])
        for m in range(8):
            starts[k + m, MARK_NEXT] = (met >> m) & 1


@kernel
def extend_open(P, by, rows, curves, n, count):
    """Follow open curves back from where they begin, before their first mark; rows and curves in use.

    They begin where curves cross, or almost. One that is a part of another before it is left out.
    """
    left = 0
    for k in range(count):
        if curves[k, 2] == 0.0:
            q = load_sample(rows[int(curves[k, 0])])
            t, _ = tangent_at(P, by, q)
            if is_known(P, by, q, t, rows, curves, left):
                continue
            n = extend_back(P, by, rows, curves, k, n)
        copy(row(curves, k), row(curves, left), CURVE)
        left += 1
    return n, left


@kernel
def put_outermost(P, by, which, reaches, starts, n):
    """Append postures of the curves about the greatest reaches that are past a pose, or those of these; their number.

    `which` are, as bits, the signs of shoulder and wrist with which the pose is not reached all around; `reaches` is
    what is known at all turns.
    """
    curvature = outreach.curvature_of(P, level_place(by.target.place))
    lowest = -2.0 * HIGHER * P[FAR] / abs(curvature)
    for signs in range(4):
        for k in range(outreach.TURNS if (which >> signs) & 1 == 1 else 0):
            i = outreach.TURNS * signs + k
            a, b = reaches[i], reaches[outreach.next_turn(i)]
            if greatest_between(a, b) > lowest and n + 2 <= starts.shape[0]:
                n = put_pair(P, by, (a, a[2] + short_way(b[2] - a[2]), b[outreach.REACH_RISE]), curvature, starts, n)
    return n


@kernel
def greatest_between(a, b):
    """What no room between two turns exceeds, if it is greatest between them; minus infinity where it is not."""
    width = HIGHEST * 2.0 * math.pi / outreach.TURNS
    ahead = short_way(b[2] - a[2])
    rises = ahead * a[outreach.REACH_RISE] > 0.0 and ahead * b[outreach.REACH_RISE] <= 0.0
    top = min(
        a[outreach.REACH_ROOM] + width * abs(a[outreach.REACH_RISE]),
        b[outreach.REACH_ROOM] + width * abs(b[outreach.REACH_RISE]),
    )
    return top if rises else -math.inf


@kernel
def well_told(reaches, known):
    """Of the known pairs of signs, as bits, those whose greatest room is well above nothing, or well below."""
    told = known
    for signs in range(4):
        most = top = -math.inf
        for i in range(outreach.TURNS * signs, outreach.TURNS * (signs + 1)):
            most = max(most, reaches[i, outreach.REACH_ROOM])
            top = max(top, greatest_between(reaches[i], reaches[outreach.next_turn(i)]))
        if most < WELL_TOLD**2 and max(most, top) > -(WELL_TOLD**2):
            told &= ~(1 << signs)
    return told


@kernel
def put_pair(P, by, turns, curvature, starts, n):
    """Append both bends of the greatest reach between two turns, if it is past the pose; if only just, itself.

    The first is given by what is known there, the second by joint 3 and its rise.
    """
    before, end, high = turns
    begin, low = before[2], before[outreach.REACH_RISE]
    best, room, turning, bending = read7(before), 0.0, outreach.way_of(before, outreach.REACH_TURNING), NO_SEED
    none = eight_of(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    met = 0
    for _ in range(CUTS):
        part = begin + (end - begin) * low / (low - high)
        there = on_way(best, turning, none + (part - best[2]))
        q, rooms, rises, turnings, bendings, met = outreach.best_bends(P, by.target, there, curvature, False)
        best, room, rise = one_of_seven(q, 0), one_of(rooms, 0), one_of(rises, 0)
        turning, bending = one_of_seven(turnings, 0), one_of_seven(bendings, 0)
        if met != ALL or room > ROOM**2 or abs(rise) < LEVEL or abs(end - begin) < NARROWEST_TURN:
            break
        if (rise > 0.0) == (low > 0.0):
            begin, low, high = part, rise, 0.5 * high
        else:
            end, high, low = part, rise, 0.5 * low
    if met == ALL and abs(room) < outreach.LEAST_BEND**2:
        store7(row(starts, n), 0, best)
        n += 1
    elif met == ALL and room > 0.0:
        bend = math.sqrt(room)
        for sign in range(2):
            store7(row(starts, n), 0, along7(best, bend if sign == 0 else -bend, bending))
            n += 1
    return n


@kernel
def follow_all(P, by, which, rows, curves):
    """Follow every curve of a pose that the closed form of the nearest exact limb leads to.

    Curves that stay with one pair of signs of shoulder and wrist may be those of some pairs alone, named by bits.
    Returns the number of curves, and as bits the pairs of which they are all there are for certain: reaches of an
    almost straight elbow are known all around.
    """
    R, p, _ = by.target
    oblique = P[SHOULDER + TOP_GAP] + P[SHOULDER + BOTTOM_GAP] + P[WRIST + TOP_GAP] + P[WRIST + BOTTOM_GAP] > OBLIQUE
    reaches = np.empty((4 * outreach.TURNS, outreach.REACH))
    known = 0
    ends = EVERY_SPLIT if outreach.is_almost_straight(P, by.target.place) else 0
    if outreach.may_be_straight(P, by.target.place):
        known, clear = outreach.put_reaches(P, by.target, which, reaches)
        ends = outreach.splits_with_ends(reaches)
        if clear == which and not oblique:
            count = lay_curves(P, by, which, reaches, rows, curves)
            if count >= 0:
                return count, which
        if which != outreach.EVERY_PAIR:
            known, _ = outreach.put_reaches(P, by.target, outreach.EVERY_PAIR, reaches)
            ends = outreach.splits_with_ends(reaches)
    told = 0 if oblique else well_told(reaches, known)
    angles = np.empty(MOST_ANGLES)
    n_angles = put_angles(P, by.target.place, STARTS_OBLIQUE if oblique else STARTS, angles)
    marks = np.empty((8 * n_angles, MARK))
    missed = np.zeros((8 * n_angles + MORE_STARTS, MARK))
    pieces = np.empty((rows.shape[0], SAMPLE))
    n = 0
    count = 0
    n_marks, n_off, signs = put_marks(P, by, angles[:n_angles], oblique, marks, missed)
    n_splits = put_splits(P, by.target, by.J, missed, n_off)
    n_surface = put_starts(P, by.target.place, ends, missed, n_splits)
    alone = np.empty((MOST_LEFT, CENTRE))
    n_outer = put_outermost(P, by, signs & known, reaches, missed, n_surface)
    n_missed, n_alone = put_amid(P, by.target, missed, n_off, n_outer, alone, (by.J, by.A))
    if n_marks > 0:
        follow_marks(P, by.target, in_step.LONGEST_STEP, marks[:n_marks], n_marks, pieces)
        n, count = join_pieces(marks, n_marks, pieces, rows, curves)
    n, count = extend_open(P, by, rows, curves, n, count)
    n_missed = put_behind_ends(P, by, rows, curves, count, missed, n_missed)
    vague = 0
    bounced = np.zeros(4, np.int64)
    bring_to_curves(P, by, missed, n_off, n_missed)
    for i in range(n_missed):
        if count >= curves.shape[0]:
            break
        q, t = read7(missed[i]), read7(row(missed[i], MARK_WAY))
        brought = missed[i, MARK_NEXT] == 1.0
        if brought and is_known(P, by, q, t, rows, curves, count):
            continue
        own = branch_of(P, q) & 3
        # Where all reaches are known, they tell what these starts might lead to.
        if not brought and i < n_off and (bounced[own] >= MOST_BOUNCED or (told >> own) & 1 == 1):
            continue
        q, error = newton.close_gently(P, q, R, p, False, by.J, by.A)
        bounced[own] = bounced[own] + 1 if error > BOUNCED else 0
        if error > newton.LEFT or (error > newton.CLOSED and vague >= MOST_LEFT):
            continue
        t, sign = tangent_at(P, by, q)
        # As close to the curve as floats tell, so that it is known where the curve closes.
        q, met = correct(P, by, q, t, dot7(t, q))
        if sign == 0.0 or not met or is_among(q, alone, n_alone):
            continue
        if not brought and is_known(P, by, q, t, rows, curves, count):
            continue
        first = n
        shortest = LONGER * vagueness(by.J, t, by.A)
        n, closed = follow_through(P, by, q, t, rows, n)
        if n - first < 2 or rows[n - 1, 0] < shortest:
            n = first
            continue
        curves[count, 0], curves[count, 1], curves[count, 2] = first, n, 1.0 if closed else 0.0
        count += 1
        vague += 1 if error > newton.CLOSED else 0
    for i in range(n_alone if n + 2 * n_alone <= rows.shape[0] else 0):
        if count < curves.shape[0]:
            curves[count, 0], curves[count, 1], curves[count, 2] = n, n + 2, 0.0
            q = inside_of_blur(P, by, read7(row(alone, i)), alone[i, BLUR])
            for x in range(2):
                n = put(rows, n, x * POINT, q)
            count += 1
    return count, outreach.EVERY_PAIR if told == outreach.EVERY_PAIR else 0
