"""Curves of a pose, eight in step: steps along them, and postures brought to them."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7
from srs_ik.kernels.algebra.lane_trig import turns_of
from srs_ik.kernels.algebra.lanes import ALL, as_bits, gather, larger, one_of, where, whole_number
from srs_ik.kernels.chain import newton_eight
from srs_ik.kernels.chain.eight import take_eight, take_ways
from srs_ik.kernels.chain.newton import CLOSED, LAST_STEP, MAX_STEP
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FAR, MISS, PHASE, SHOULDER, STRAIGHT, WRIST
from srs_ik.kernels.limb.goal import NO_SEED

SAMPLE = 15
SAMPLE_WAY = 8
"""A sample of a curve: its parameter, seven joint angles, and the unit vector along the curve, nothing if not known."""

LONGEST_STEP = 0.3
"""Length of a step, rad."""

ARC = 1.1
"""The way along a curve between two samples, at most, for the difference of their parameters."""

SHORTEST_STEP = 1e-7
"""Steps shorter than this, rad, mean a curve that cannot be followed."""

FINEST = 0.05
"""A step over two singularities at once is no longer than this part of what axes miss, relative to the reach: a jump
from one curve to another there turns the orientation around twice, which is not noticed."""

SMALLEST_COSINE = 0.93
"""Cosine of the largest angle by which a curve turns in one step."""

WELL_STRAIGHT = 0.985
GROWTH = 1.5
ALL_BUT_STRAIGHT = 0.998
FAST_GROWTH = 3.0
"""Above the first cosine, the next step is longer by the second, above the third by the fourth: it is soon behind the
sharp turn of a curve that almost crosses another one."""

SHRINKAGE = 0.4
"""A step that has not led along the curve is tried again, shorter by this."""

CORRECTIONS = 8
"""Newton's steps back to the curve, at most."""

HARDLY = 1e-12
"""A step to a curve that is foreseen to be this short, rad, is not taken."""

ASIDE = 1e-5
"""A step is outside of what lies between the ways of its curve at both ends by no more than this part of it, squared:
else it has led to another curve."""

ASTRAY = 0.1
"""What is looked for between two samples is no farther from the way between them, squared and in parts of it."""

VAGUE = 1e-6
"""Where several joints are singular at once, floats tell whether a posture is on a curve no better, rad squared."""

TURNING_WRIST = 1e-4
"""Sine of q6 below which a way along a curve is asked for alone: in step it divides by what axes 5 to 7 span."""

SETTLED = 1e-14
"""A step that has settled is on a curve up to this, rad squared."""

FARTHEST = 0.25
SHRINKING = 0.4
"""Steps back to the curve do not lead there where the first is longer than the first part of the step along it, since
that has turned too far, or where they shrink by less than the second."""

BESIDE = 0.08
"""A posture this close to the chord of a step, as a part of its length, is on the curve."""

BEYOND = 1.2 * LONGEST_STEP
"""Farther from a sample, rad, no joint of a posture beside the step from it is: the quicker question."""


LANE = 29
LANE_BEFORE = 14
LANE_STEP = 28
"""One of eight curves: joint angles, the unit vector along it, both before the last step, the next step."""


@kernel
def are_ways(t):
    """Which of eight vectors along curves are known, as bits; where several joints are singular at once, none is."""
    return as_bits(dot7(t, t) > 0.5)


@kernel
def load_sample(sample):
    """Joint angles of a sample."""
    return (sample[1], sample[2], sample[3], sample[4], sample[5], sample[6], sample[7])


@kernel
def put_sample(rows, n, x, q):
    """Write a sample into row n, whose way is not known."""
    put_on_way(rows, n, x, q, NO_SEED)


@kernel
def put_on_way(rows, n, x, q, t):
    """Write a sample into row n, with the unit vector along the curve."""
    rows[n, 0] = x
    for j in range(7):
        rows[n, 1 + j], rows[n, SAMPLE_WAY + j] = q[j], t[j]


@kernel
def way_of_sample(sample):
    """The unit vector along the curve at a sample; nothing where it is not known."""
    return (sample[8], sample[9], sample[10], sample[11], sample[12], sample[13], sample[14])


@kernel
def load_end(sample):
    """Joint angles of a sample, and the way of its curve."""
    return load_sample(sample), way_of_sample(sample)


@kernel
def step_after(step, cosine, longest):
    """The length of the next step along a curve that has turned on one by a cosine, no longer than given."""
    growth = FAST_GROWTH if cosine > ALL_BUT_STRAIGHT else (GROWTH if cosine > WELL_STRAIGHT else 1.0)
    return min(growth * step, longest)


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
def side_of_one(q, phase):
    """Half turns of a middle angle from its phase, down to the last whole one."""
    return math.floor((q - phase) / math.pi)


@kernel
def passes_two(P, a, b):
    """Whether two singularities or more are passed between two postures."""
    passed = abs(side_of_one(a[1], P[SHOULDER + PHASE]) - side_of_one(b[1], P[SHOULDER + PHASE]))
    passed += abs(side_of_one(a[3], P[STRAIGHT]) - side_of_one(b[3], P[STRAIGHT]))
    passed += abs(side_of_one(a[5], P[WRIST + PHASE]) - side_of_one(b[5], P[WRIST + PHASE]))
    return passed > 1


@kernel
def is_along(made, ahead, way, cosine, vague):
    """Whether steps are along a curve, given how far ahead they are, its way behind them, and by what cosine it turns.

    Of one step, or of eight. Where a curve turns one way, a step lies between its ways at both ends: in the ball about
    the middle of both, by the length ahead. Also those that are off by as much as is vague, rad squared.
    """
    outside = dot7(made, made) - ahead * (dot7(made, way) + ahead * (1.0 - cosine))
    return outside < ASIDE * ahead * ahead + vague


@kernel
def foretold(q, way, last, last_way, step):
    """Postures a step on along eight curves, by the cubic through two of each, which tells how it is off the way.

    Both are given with the ways there. A curve that has not yet been followed is straight.
    """
    made = along7(q, -1.0, last)
    ahead = dot7(made, way)
    begun = ahead > 0.0
    per_step = where(begun, 1.0 / where(begun, ahead, step), 0.0 * step)
    share = step * per_step
    # How the way differs from that of the last step, on the whole and where it began.
    whole = along7(way, -per_step, made)
    first = along7(way, -1.0 / dot7(last_way, way), last_way)
    second = step * share
    q = along7(along7(q, step, way), second * (3.0 + 2.0 * share), whole)
    return along7(q, -second * (1.0 + share), first)


@kernel
def step_in_step(P, R, p, rows, alive):
    """Take eight curves a step on: postures, ways of the curves, which are there (bits), cosines of their turns.

    Only those that are named by the bits `alive` count; one whose steps do not shrink well is not waited for.
    """
    before = take_eight(rows, LANE)
    way = take_ways(rows, 7, LANE)
    step = gather(rows, LANE_STEP, LANE)
    q = foretold(before, way, take_ways(rows, LANE_BEFORE, LANE), take_ways(rows, LANE_BEFORE + 7, LANE), step)
    t = way
    turns = turns_of(q)
    none = 0.0 * step
    met = 0
    left = alive
    last = FARTHEST / SHRINKING * step
    for _ in range(CORRECTIONS):
        d, t, _, right = newton_eight.curve_step(P, turns, R, p, way, none)
        size = newton_eight.largest(d)
        settled = (size < LAST_STEP) | newton_eight.is_foreseen(size, last, HARDLY)
        q = along7(q, 1.0, d)
        met = as_bits(settled & right)
        left &= as_bits(size < SHRINKING * last)
        if left & ~as_bits(settled) == 0:
            break
        last = size
        turns = newton_eight.turned_by_all(turns, d)
    cosine = dot7(way, t)
    made = along7(q, -1.0, before)
    met &= as_bits((cosine > SMALLEST_COSINE) & is_along(made, step, t, cosine, SETTLED))
    return q, t, met & ~as_bits(crosses_two(P, before, q, step)), cosine


@kernel
def to_curves(P, R, p, q, which, until):
    """The shortest way from eight postures to curves of a pose, those that are named by bits.

    `until` holds the largest number of steps, and how short one need not be taken that is foreseen, rad.

    Returns postures, the unit vectors along their curves, and which are met, as bits.
    """
    turns = turns_of(q)
    t = q
    met = 0
    steps, short = until
    last = 0.0 * q[0] + MAX_STEP
    for _ in range(steps):
        d, t, _, right = newton_eight.curve_step(P, turns, R, p, q, 0.0 * q[0])
        d = along7(d, -dot7(t, d), t)
        size = newton_eight.largest(d)
        settled = (size < LAST_STEP) | newton_eight.is_foreseen(size, last, short)
        d = newton_eight.all_times(MAX_STEP / larger(size, MAX_STEP + 0.0 * size), d)
        q = along7(q, 1.0, d)
        met = as_bits(settled & right)
        if which & ~as_bits(settled) == 0:
            break
        last = size
        turns = newton_eight.turned_by_all(turns, d)
    return q, t, met


@kernel
def share_beside(start, end, q):
    """The share of a chord at which a posture that was looked for there is passed, and whether it is not astray."""
    way, to_q = difference(start, end), difference(start, q)
    length2 = dot7(way, way)
    share = dot7(to_q, way) / length2
    off = along7(to_q, -share, way)
    return share, dot7(off, off) <= ASTRAY * length2


@kernel
def share_of_chord(a, b, q):
    """The share of the way from posture a to b at which one beside it is passed; 2 where it is not beside it."""
    chord = difference(a, b)
    to_q = difference(a, q)
    length2 = dot7(chord, chord)
    share = dot7(to_q, chord)
    if length2 == 0.0 or share < -BESIDE * length2 or share > (1.0 + BESIDE) * length2:
        return 2.0
    off = along7(to_q, -share / length2, chord)
    return share / length2 if dot7(off, off) < BESIDE * BESIDE * length2 + CLOSED else 2.0


@kernel
def on_way(a, chord, shares):
    """Eight postures at shares of the straight way along a chord from one posture."""
    none = 0.0 * shares
    return along7(along7((none, none, none, none, none, none, none), 1.0, a), shares, chord)


@kernel
def on_cubic(before, behind, chord, shares):
    """Eight postures of a curve at shares of a chord, by the cubic through two postures.

    These are given each as its share, itself, and the way of the curve there.
    """
    (low, a, way_a), (high, b, way_b) = before, behind
    width = high - low
    more = width * dot7(chord, chord)
    rate_a = along7(NO_SEED, more / dot7(chord, way_a), way_a)
    rate_b = along7(NO_SEED, more / dot7(chord, way_b), way_b)
    change = along7(b, -1.0, a)
    third = along7(along7(rate_a, 1.0, rate_b), -2.0, change)
    second = along7(along7(change, -1.0, rate_a), -1.0, third)
    u = (shares - low) / width
    return along7(along7(on_way(a, rate_a, u), u * u, second), u * u * u, third)


@kernel
def between_eight(P, by, start, chord):
    """The postures of a curve at eight shares of a chord, those of postures to start from, as `follow.between`.

    Returns postures, the unit vectors along the curve, and which are met, as bits.
    """
    R, p, _ = by.target
    q, t = start, start
    turns = turns_of(q)
    met = 0
    last = before = 0.0 * q[0] + math.inf
    for _ in range(CORRECTIONS):
        d, t, _, right = newton_eight.curve_step(P, turns, R, p, chord, dot7(chord, along7(start, -1.0, q)))
        size = newton_eight.largest(d)
        settled = size < LAST_STEP
        q = along7(q, 1.0, d)
        met = as_bits(settled & right)
        # Next to a singularity, a longer step may come first.
        if as_bits(settled | (size > SHRINKING * before)) == ALL:
            break
        before, last = last, size
        turns = newton_eight.turned_by_all(turns, d)
    return q, t, met


@kernel
def short_ways(angles):
    """Eight angles, whole turns apart, within half a turn."""
    return angles - 2.0 * math.pi * whole_number(angles * (0.5 / math.pi))


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
