"""Curves of a pose, followed eight in step from marks that lie on them, each to the next mark.

Marks are postures to which the closed form leads. Whatever mark comes next, its own piece goes on from there: so no
part of a curve is followed twice, and the pieces from mark to mark make up the curves.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import difference, dot7, short_way
from srs_ik.kernels.algebra.lane_trig import turns_of
from srs_ik.kernels.algebra.lanes import as_bits, gather, one_of, root, scatter, where, whole_number
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.chain.eight import ALL, put_eight, take_eight
from srs_ik.kernels.chain.newton import CLOSED, LAST_STEP, MAX_STEP
from srs_ik.kernels.chain.newton_eight import (
    all_along,
    all_times,
    curve_step,
    dot_seven,
    larger,
    largest,
    turned_by_all,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FAR, MISS, PHASE, SHOULDER, STRAIGHT, WRIST
from srs_ik.kernels.limb.poses import read7

SAMPLE = 8
"""A sample of a curve: its parameter, and seven joint angles."""

LONGEST_STEP = 0.3
"""Length of a step, rad."""

SHORTEST_STEP = 1e-7
"""Steps shorter than this, rad, mean a curve that cannot be followed."""

FINEST = 0.05
"""A step over two singularities at once is no longer than this part of what axes miss, relative to the reach: a jump
from one curve to another there turns the orientation around twice, which is not noticed."""

SMALLEST_COSINE = 0.93
"""Cosine of the largest angle by which a curve turns in one step."""

WELL_STRAIGHT = 0.985
"""Above this cosine, the next step is longer."""

CORRECTIONS = 8
"""Newton's steps back to the curve, at most."""

BENT = 16.0
ASIDE = 4e-4
"""A curve is no farther aside of its way than twice what its turn makes of it, and this part of the step, squared: else
the step has led to another curve."""

SHRINKING = 0.4
"""Steps back to the curve that shrink by less do not lead there."""

BESIDE = 0.08
"""A posture this close to the chord of a step, as a part of its length, is on the curve."""

BEYOND = 1.2 * LONGEST_STEP
"""Farther from a sample, rad, no joint of a posture beside the step from it is: the quicker question."""

AT_THE_END = 1.0 + 1e-12
"""A mark at the end of a step is passed by it."""

MARK = 17
MARK_WAY = 7
MARK_NEXT = 14
MARK_FIRST = 15
MARK_LAST = 16
"""A mark: joint angles, the unit vector along its curve, the mark that comes next (-1: none, -2: not yet followed),
first row of the piece from here to there, and the row behind its last."""

LANE = 15
LANE_STEP = 14
"""One of eight curves: joint angles, the unit vector along it, the next step."""

LONGEST_PIECE = 256
"""Samples of a piece, at most."""


SAME_MARK = 1e-12
SAME_ANGLE = 1e-6
"""Marks closer than this, rad squared, are one; of each angle, rad."""


@kernel
def take_ways(rows, first, width):
    """Seven figures from one on, of eight rows, each as eight floats."""
    return (
        gather(rows, first, width),
        gather(rows, first + 1, width),
        gather(rows, first + 2, width),
        gather(rows, first + 3, width),
        gather(rows, first + 4, width),
        gather(rows, first + 5, width),
        gather(rows, first + 6, width),
    )


@kernel
def load_sample(sample):
    """Joint angles of a sample."""
    return (sample[1], sample[2], sample[3], sample[4], sample[5], sample[6], sample[7])


@kernel
def read_way(mark):
    """The unit vector along the curve of a mark."""
    return (mark[7], mark[8], mark[9], mark[10], mark[11], mark[12], mark[13])


@kernel
def put_sample(rows, n, x, q):
    """Write a sample into row n."""
    rows[n, 0] = x
    for j in range(7):
        rows[n, 1 + j] = q[j]


@kernel
def side_of(q, phase):
    """Half turns of eight middle angles from their phase, down to the last whole one."""
    return whole_number((q - phase) / math.pi - 0.5)


@kernel
def longest_across(P):
    """The longest step that may pass two singularities at once, rad."""
    return max(FINEST * P[MISS] / P[FAR], 4.0 * SHORTEST_STEP)


@kernel
def crosses_two(P, a, b, step):
    """Which of eight steps between postures pass two singularities at once, and are too long for that."""
    across_2 = side_of(a[1], P[SHOULDER + PHASE]) - side_of(b[1], P[SHOULDER + PHASE])
    across_4 = side_of(a[3], P[STRAIGHT]) - side_of(b[3], P[STRAIGHT])
    across_6 = side_of(a[5], P[WRIST + PHASE]) - side_of(b[5], P[WRIST + PHASE])
    passed = abs(across_2) + abs(across_4) + abs(across_6)
    return (passed > 1.5) & (step > longest_across(P))


@kernel
def most_aside(ahead, cosine):
    """How far aside of its way a curve is after some distance ahead, squared, where it has turned by a cosine.

    On a circle it is half of that distance times half of the angle that it has turned by.
    """
    return ahead * ahead * (BENT * (1.0 - cosine) / (1.0 + cosine) + ASIDE) + CLOSED


@kernel
def is_along(made, way, cosine):
    """Which of eight postures may be on the curves that began along a way, given how far they are and how they turn."""
    ahead = dot_seven(made, way)
    return dot_seven(made, made) - ahead * ahead < most_aside(ahead, cosine)


@kernel
def step_in_step(P, R, p, rows, alive):
    """Take eight curves a step on: postures, ways of the curves, which are there (bits), cosines of their turns.

    Only those that are named by the bits `alive` count; one whose steps do not shrink well is not there.
    """
    before = take_eight(rows, LANE)
    way = take_ways(rows, 7, LANE)
    step = gather(rows, LANE_STEP, LANE)
    q = all_along(before, step, way)
    t = way
    turns = turns_of(q)
    none = 0.0 * step
    met = 0
    last = none + MAX_STEP / SHRINKING
    for _ in range(CORRECTIONS):
        d, t, _, right = curve_step(P, turns, R, p, way, none)
        size = largest(d)
        settled = size < LAST_STEP
        q = all_along(q, 1.0, d)
        met = as_bits(settled & right)
        if alive & ~as_bits(settled | (size > SHRINKING * last)) == 0:
            break
        last = size
        turns = turned_by_all(turns, d)
    cosine = dot_seven(way, t)
    made = all_along(q, -1.0, before)
    met &= as_bits((cosine > SMALLEST_COSINE) & is_along(made, way, cosine))
    return q, t, met & ~as_bits(crosses_two(P, before, q, step)), cosine


@kernel
def to_curves(P, R, p, q, which):
    """The shortest way from eight postures to curves of a pose, those that are named by bits.

    Returns postures, the unit vectors along their curves, and which are met, as bits.
    """
    turns = turns_of(q)
    t = q
    met = 0
    for _ in range(CORRECTIONS):
        d, t, _, right = curve_step(P, turns, R, p, q, 0.0 * q[0])
        d = all_along(d, -dot_seven(t, d), t)
        size = largest(d)
        settled = size < LAST_STEP
        d = all_times(MAX_STEP / larger(size, MAX_STEP + 0.0 * size), d)
        q = all_along(q, 1.0, d)
        met = as_bits(settled & right)
        if which & ~as_bits(settled) == 0:
            break
        turns = turned_by_all(turns, d)
    return q, t, met


@kernel
def short_ways(angles):
    """Eight angles, whole turns apart, within half a turn."""
    return angles - 2.0 * math.pi * whole_number(angles * (0.5 / math.pi))


@kernel
def shares_of_ways(P, q, way, chord, length2, mark):
    """The shares of the ways of eight curves, from postures along chords, at which a mark is passed; 2 where it is not.

    The unit vectors along the curves are given, and the squares of the lengths of the chords.
    """
    to_mark = (
        short_ways(mark[0] - q[0]),
        short_ways(mark[1] - q[1]),
        short_ways(mark[2] - q[2]),
        short_ways(mark[3] - q[3]),
        short_ways(mark[4] - q[4]),
        short_ways(mark[5] - q[5]),
        short_ways(mark[6] - q[6]),
    )
    along_chord = dot_seven(to_mark, chord)
    share = along_chord / length2
    off2 = dot_seven(to_mark, to_mark) - share * along_chord
    ahead = dot_seven(read_way(mark), chord)
    beside = (ahead > 0.0) & (off2 < BESIDE * BESIDE * length2) & is_along(to_mark, way, dot_seven(read_way(mark), way))
    jumps = crosses_two(P, q, all_along(q, 1.0, to_mark), share * root(length2))
    share = where(beside & (share > 0.0) & (share < AT_THE_END), share, 2.0 + 0.0 * share)
    return where(jumps, 2.0 + 0.0 * share, share)


@kernel
def find_passed(P, before, after, which, marks, count):
    """The first mark on the way of each of eight curves, of those that are named by bits (-1: none), and its share."""
    q = take_eight(before, LANE)
    chord = all_along(take_eight(after, LANE), -1.0, q)
    way = take_ways(before, 7, LANE)
    length2 = dot_seven(chord, chord)
    shares = 2.0 + 0.0 * length2
    passed = shares - 3.0
    for m in range(count):
        mark = marks[m]
        near = (abs(short_ways(q[1] - mark[1])) < BEYOND) & (abs(short_ways(q[5] - mark[5])) < BEYOND)
        if which & as_bits(near) == 0:
            continue
        share = shares_of_ways(P, q, way, chord, length2, mark)
        earlier = share < shares
        shares = where(earlier, share, shares)
        passed = where(earlier, m + 0.0 * share, passed)
    return passed, shares


@kernel
def load_lane(lanes, i, mark):
    """Begin to follow a curve at a mark."""
    for c in range(14):
        lanes[i, c] = mark[c]
    lanes[i, LANE_STEP] = LONGEST_STEP


@kernel
def keep_piece(line, first, n, pieces, used, mark, following):
    """Copy a piece to where all are kept, for its mark; return the rows in use."""
    mark[MARK_NEXT] = following
    mark[MARK_FIRST] = used
    for i in range(n):
        if used < pieces.shape[0]:
            for c in range(SAMPLE):
                pieces[used, c] = line[first + i, c]
            used += 1
    mark[MARK_LAST] = used
    return used


@kernel
def follow_marks(P, target, marks, starts, pieces):
    """Follow the curve of each of the first marks (`starts` of them) to the next of all, into rows of pieces."""
    count = marks.shape[0]
    lanes = np.empty((8, LANE))
    after = np.empty((8, LANE))
    line = np.empty((8 * LONGEST_PIECE, SAMPLE))
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
            put_sample(line, i * LONGEST_PIECE, 0.0, read7(marks[waiting]))
            alive |= 1 << i
            waiting += 1
    while alive != 0:
        q, t, there, cosine = step_in_step(P, target.R, target.p, row(lanes, 0), alive)
        put_eight(row(after, 0), LANE, ALL, q)
        for j in range(7):
            scatter(row(after, 0), 7 + j, LANE, t[j])
        passed, shares = find_passed(P, row(lanes, 0), row(after, 0), there & alive, marks, count)
        for i in range(8):
            if (alive >> i) & 1 == 0:
                continue
            done = False
            following = -1
            first = i * LONGEST_PIECE
            step = lanes[i, LANE_STEP]
            if (there >> i) & 1 == 0:
                lanes[i, LANE_STEP] = 0.5 * step
                done = 0.5 * step < SHORTEST_STEP
            else:
                n = length[i]
                x = line[first + n - 1, 0]
                following = int(one_of(passed, i))
                if following >= 0:
                    put_sample(line, first + n, x + one_of(shares, i) * step, read7(marks[following]))
                    done = True
                else:
                    put_sample(line, first + n, x + step, read7(row(after, i)))
                    for c in range(14):
                        lanes[i, c] = after[i, c]
                    if one_of(cosine, i) > WELL_STRAIGHT:
                        lanes[i, LANE_STEP] = min(1.5 * step, LONGEST_STEP)
                    done = n + 2 >= LONGEST_PIECE
                length[i] = n + 1
            if done:
                used = keep_piece(line, first, length[i], pieces, used, marks[mark_of[i]], following)
                alive &= ~(1 << i)
                if waiting < starts:
                    load_lane(lanes, i, marks[waiting])
                    mark_of[i], length[i] = waiting, 1
                    put_sample(line, first, 0.0, read7(marks[waiting]))
                    alive |= 1 << i
                    waiting += 1
    keep(lanes)
    keep(after)
    return used


@kernel
def one_of_seven(t, i):
    """One of eight vectors."""
    return (
        one_of(t[0], i),
        one_of(t[1], i),
        one_of(t[2], i),
        one_of(t[3], i),
        one_of(t[4], i),
        one_of(t[5], i),
        one_of(t[6], i),
    )


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
                        put_sample(rows, n, length + pieces[i, 0], load_sample(pieces[i]))
                        n += 1
                if n > first:
                    length = rows[n - 1, 0]
                at = int(marks[at, MARK_NEXT])
            curves[k, 0] = first
            curves[k, 1] = n
            curves[k, 2] = 1.0 if at == m else 0.0
            k += 1
    return n, k
