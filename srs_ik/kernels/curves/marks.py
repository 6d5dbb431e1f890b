"""Curves of a pose, followed from marks that lie on them, each to the next mark.

Marks are postures to which the closed form leads. Whatever mark comes next, its own piece goes on from there: so no
part of a curve is followed twice, and the pieces from mark to mark make up the curves.
"""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, short_way, store7
from srs_ik.kernels.algebra.lanes import ALL, as_bits, one_of, root, scatter, where
from srs_ik.kernels.algebra.pointers import copy, keep, read7, row
from srs_ik.kernels.chain.eight import put_eight, take_eight, take_ways
from srs_ik.kernels.curves import in_step
from srs_ik.kernels.curves.follow import ALMOST_CROSSED, go_along, tangent_at, way_across
from srs_ik.kernels.jit import kernel

MARK = 17
MARK_WAY = 7
MARK_NEXT = 14
MARK_FIRST = 15
MARK_LAST = 16
"""A mark: joint angles, the unit vector along its curve, the mark that comes next (-1: none, -2: not yet followed),
first row of the piece from here to there, and the row behind its last."""

LONGEST_PIECE = 256
"""Samples of a piece, at most."""

SAME_MARK = 1e-12
SAME_ANGLE = 1e-6
"""Marks closer than this, rad squared, are one; of each angle, rad."""

BEHIND_END = 0.1
"""Where curves almost cross, one that ends goes on to either side of it: starts are so far from there, rad."""

AT_THE_END = 1.0 + 1e-12
"""A mark at the end of a step is passed by it."""


@kernel
def read_way(mark):
    """The unit vector along the curve of a mark."""
    return (mark[7], mark[8], mark[9], mark[10], mark[11], mark[12], mark[13])


@kernel
def ways_to(mark, q):
    """The short ways from eight postures to a mark."""
    return (
        in_step.short_ways(mark[0] - q[0]),
        in_step.short_ways(mark[1] - q[1]),
        in_step.short_ways(mark[2] - q[2]),
        in_step.short_ways(mark[3] - q[3]),
        in_step.short_ways(mark[4] - q[4]),
        in_step.short_ways(mark[5] - q[5]),
        in_step.short_ways(mark[6] - q[6]),
    )


@kernel
def shares_of_ways(P, q, way, chord, mark, to_mark):
    """The shares of the ways of eight curves, from postures along chords, at which a mark is passed; 2 where it is not.

    The unit vectors along the curves are given, and the ways to the mark.
    """
    length2 = dot7(chord, chord)
    along_chord = dot7(to_mark, chord)
    share = along_chord / length2
    off2 = dot7(to_mark, to_mark) - share * along_chord
    mark_way = read_way(mark)
    along = in_step.is_along(to_mark, dot7(to_mark, way), mark_way, dot7(mark_way, way), in_step.VAGUE)
    beside = (dot7(mark_way, to_mark) > 0.0) & (off2 < in_step.BESIDE * in_step.BESIDE * length2) & along
    jumps = in_step.crosses_two(P, q, along7(q, 1.0, to_mark), share * root(length2))
    share = where(beside & (share > 0.0) & (share < AT_THE_END), share, 2.0 + 0.0 * share)
    return where(jumps, 2.0 + 0.0 * share, share)


@kernel
def find_passed(P, before, after, which, marks, count):
    """The first mark on the way of each of eight curves, of those that are named by bits (-1: none), and its share."""
    q = take_eight(before, in_step.LANE)
    chord = along7(take_eight(after, in_step.LANE), -1.0, q)
    way = take_ways(before, 7, in_step.LANE)
    # Farther away than the chord is long and a mark may be aside, none is passed.
    reach2 = (1.0 + 2.0 * in_step.BESIDE * in_step.BESIDE) * dot7(chord, chord)
    reach = root(reach2)
    shares = 2.0 + 0.0 * reach
    passed = shares - 3.0
    for m in range(count):
        mark = marks[m]
        near = (abs(in_step.short_ways(q[0] - mark[0])) < reach) & (abs(in_step.short_ways(q[4] - mark[4])) < reach)
        if which & as_bits(near) == 0:
            continue
        to_mark = ways_to(mark, q)
        if which & as_bits(dot7(to_mark, to_mark) < reach2) == 0:
            continue
        share = shares_of_ways(P, q, way, chord, mark, to_mark)
        earlier = share < shares
        shares = where(earlier, share, shares)
        passed = where(earlier, m + 0.0 * share, passed)
    return passed, shares


@kernel
def load_lane(lanes, i, mark):
    """Begin to follow a curve at a mark: straight on."""
    copy(mark, row(lanes, i), in_step.LANE_BEFORE)
    copy(mark, row(lanes[i], in_step.LANE_BEFORE), in_step.LANE_BEFORE)
    lanes[i, in_step.LANE_STEP] = in_step.LONGEST_STEP


@kernel
def put_at_mark(line, n, x, mark):
    """Write a sample with the joint angles and the way of a mark, or of a lane."""
    line[n, 0] = x
    copy(mark, row(line[n], 1), MARK_NEXT)


@kernel
def keep_piece(line, first, n, pieces, used, mark, following):
    """Copy a piece to where all are kept, for its mark; return the rows in use."""
    mark[MARK_NEXT] = following
    mark[MARK_FIRST] = used
    for i in range(n):
        if used < pieces.shape[0]:
            copy(row(line, first + i), row(pieces, used), in_step.SAMPLE)
            used += 1
    mark[MARK_LAST] = used
    return used


@kernel
def follow_marks(P, target, longest, marks, starts, pieces):
    """Follow the curve of each of the first marks (`starts` of them) to the next of all, into rows of pieces.

    In steps no longer than given, rad.
    """
    count = marks.shape[0]
    lanes = np.empty((8, in_step.LANE))
    after = np.empty((8, in_step.LANE))
    line = np.empty((8 * LONGEST_PIECE, in_step.SAMPLE))
    mark_of = np.empty(8, np.int64)
    length = np.empty(8, np.int64)
    waiting = 0
    alive = 0
    used = 0
    for i in range(8):
        # Without a mark of its own, a lane goes along with the first one.
        load_lane(lanes, i, marks[min(waiting, starts - 1)])
        if waiting < starts:
            mark_of[i], length[i] = waiting, 1
            put_at_mark(line, i * LONGEST_PIECE, 0.0, marks[waiting])
            alive |= 1 << i
            waiting += 1
    while alive != 0:
        q, t, there, cosine = in_step.step_in_step(P, target.R, target.p, row(lanes, 0), alive)
        put_eight(row(after, 0), in_step.LANE, ALL, q)
        for j in range(7):
            scatter(row(after, 0), 7 + j, in_step.LANE, t[j])
        passed, shares = find_passed(P, row(lanes, 0), row(after, 0), there & alive, marks, count)
        for i in range(8):
            if (alive >> i) & 1 == 0:
                continue
            done = False
            following = -1
            first = i * LONGEST_PIECE
            step = lanes[i, in_step.LANE_STEP]
            if (there >> i) & 1 == 0:
                lanes[i, in_step.LANE_STEP] = in_step.SHRINKAGE * step
                done = in_step.SHRINKAGE * step < in_step.SHORTEST_STEP
            else:
                n = length[i]
                x = line[first + n - 1, 0]
                following = int(one_of(passed, i))
                if following >= 0:
                    put_at_mark(line, first + n, x + one_of(shares, i) * step, marks[following])
                    done = True
                else:
                    put_at_mark(line, first + n, x + step, after[i])
                    copy(row(lanes, i), row(lanes[i], in_step.LANE_BEFORE), in_step.LANE_BEFORE)
                    copy(row(after, i), row(lanes, i), in_step.LANE_BEFORE)
                    lanes[i, in_step.LANE_STEP] = in_step.step_after(step, one_of(cosine, i), longest)
                    done = n + 2 >= LONGEST_PIECE
                length[i] = n + 1
            if done:
                used = keep_piece(line, first, length[i], pieces, used, marks[mark_of[i]], following)
                alive &= ~(1 << i)
                if waiting < starts:
                    load_lane(lanes, i, marks[waiting])
                    mark_of[i], length[i] = waiting, 1
                    put_at_mark(line, first, 0.0, marks[waiting])
                    alive |= 1 << i
                    waiting += 1
    keep(lanes)
    keep(after)
    return used


@kernel
def put_mark(marks, first, count, q, t):
    """Append a mark, unless it is one of those from `first` on; return how many there are."""
    for m in range(first, count):
        if abs(short_way(marks[m, 1] - q[1])) > SAME_ANGLE:
            continue
        off = difference(read7(marks[m]), q)
        if dot7(off, off) < SAME_MARK:
            return count
    if count >= marks.shape[0]:
        return count
    for j in range(7):
        marks[count, j] = q[j]
        marks[count, MARK_WAY + j] = t[j]
    marks[count, MARK_NEXT] = -2.0
    return count + 1


@kernel
def join_pieces(marks, count, pieces, rows, curves):
    """Put the pieces together to curves, one after the other into rows: rows and curves in use.

    An open curve begins at a mark that no other leads to.
    """
    led_to = np.zeros(count + 1, np.int64)
    for m in range(count):
        if marks[m, MARK_NEXT] >= 0.0:
            led_to[int(marks[m, MARK_NEXT])] += 1
    n = 0
    k = 0
    for closed in range(2):
        for m in range(count):
            if led_to[m] < 0 or (closed == 0 and led_to[m] > 0) or k >= curves.shape[0]:
                continue
            first = n
            at = m
            length = 0.0
            while at >= 0 and led_to[at] >= 0:
                led_to[at] = -1
                for i in range(int(marks[at, MARK_FIRST]), int(marks[at, MARK_LAST])):
                    # The last posture of a piece is the first one of the next.
                    if (n == first or i > int(marks[at, MARK_FIRST])) and n < rows.shape[0]:
                        copy(row(pieces, i), row(rows, n), in_step.SAMPLE)
                        rows[n, 0] += length
                        n += 1
                if n > first:
                    length = rows[n - 1, 0]
                at = int(marks[at, MARK_NEXT])
            curves[k, 0] = first
            curves[k, 1] = n
            curves[k, 2] = 1.0 if at == m else 0.0
            k += 1
    return n, k


@kernel
def put_behind_ends(P, by, rows, curves, count, starts, n):
    """Append starts to both sides of the ends of open curves that almost cross others there; their number."""
    for k in range(count):
        for end in range(2 if curves[k, 2] == 0.0 else 0):
            q = in_step.load_sample(rows[int(curves[k, end]) - end])
            t, sign = tangent_at(P, by, q)
            s, size = way_across(P, by, q, t)
            if sign == 0.0 or size * ALMOST_CROSSED < 1.0:
                continue
            for side in range(2):
                there, met = go_along(P, by, q, s, BEHIND_END if side == 0 else -BEHIND_END)
                if met and n < starts.shape[0]:
                    store7(row(starts, n), 0, there)
                    n += 1
    return n
