"""The posture nearest to a seed within feasible intervals of an exact limb.

An interval is looked at in steps that follow the joints: between two postures that are a way apart, none is nearer to
the seed than the distances of the two, less that way, allow. So most of an interval needs no closer look, and nothing
that could be nearer is passed over, however fast the joints turn next to a singularity.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import difference, dot7
from srs_ik.kernels.exact.farthest import branch_at, climb
from srs_ik.kernels.exact.samples import MAX_SAMPLES, add_turns, spread_evenly
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.search import STATE
from srs_ik.kernels.limb.branches import NO_BRANCH
from srs_ik.kernels.limb.goal import OUTSIDE, elbow_part
from srs_ik.kernels.limb.in_line import may_split
from srs_ik.kernels.limb.triangle import elbow_side

WIDEST = 2.0 * math.pi / 24.0
"""Widest spacing of the arm angles at which an interval is first looked at."""

FEWEST = 4
"""Fewest parts into which an interval is cut."""

LONGEST = 0.1
"""Postures whose neighbours may be nearer than the nearest so far are no farther apart than this, rad ..."""

CLOSEST = 1e-7
"""... unless their arm angles are so close: a joint changes turns there, or has none of its own ..."""

CLOSEST_OF_ALL = 1e-14
"""... and next to a singular pose no closer than this: there, half a turn may lie between arm angles as close."""

ARC = 1.1
"""The way between two such postures along their curve, at most, for their distance."""

MOST = 256
DEPTH = 48
"""Room for the samples of an interval, and for those on hold while the gap before them is filled."""

PEAKS = 32
"""So many of the most hopeful minima are closed in on."""


@kernel
def height(value):
    """A cost as a distance: of a posture from the seed, or far above all of these from its limits."""
    return math.sqrt(value) if value < OUTSIDE else value


@kernel
def least_between(a, b, way):
    """A distance below all on a way between two postures with distances a and b.

    Where these differ by more than the way, a joint has changed turns, or left its limits.
    """
    return 0.5 * (a + b - way) if abs(a - b) <= way else min(a, b) - way


@kernel
def way_between(a, b):
    """The way between two postures along their curve, at most; each joint the short way round."""
    d = difference(a, b)
    return ARC * math.sqrt(dot7(d, d))


@kernel
def sample(P, side, branch, ends, goal, bounds, work):
    """Fill in rows (MOST, 3) of an interval: arm angle, distance, way from the row before; their number.

    `bounds` are the distance that is to be undercut and the least gap of arm angles, `work` is space for arm angles,
    for those on hold, and the rows.
    """
    lower, upper = ends
    _, seed, respect = goal
    lowest, closest = bounds
    wanted, held, rows = work
    count = add_turns(P, side, True, lower, upper, wanted, spread_evenly(lower, upper, WIDEST, FEWEST, wanted))
    q, value = branch_at(P, side, lower, branch, True, seed, respect)
    rows[0, 0], rows[0, 1], rows[0, 2] = lower, height(value), 0.0
    n = 1
    lowest = min(lowest, rows[0, 1])
    for i in range(1, count):
        held[0] = wanted[i]
        on_hold = 1
        while on_hold > 0 and n < MOST:
            x = held[on_hold - 1]
            next_q, value = branch_at(P, side, x, branch, True, seed, respect)
            here = height(value)
            lowest = min(lowest, here)
            way = way_between(q, next_q)
            before = rows[n - 1, 1]
            gap = x - rows[n - 1, 0]
            too_far = way > LONGEST or abs(here - before) > way
            if too_far and on_hold < DEPTH and gap > closest and least_between(before, here, way) < lowest:
                held[on_hold] = x - 0.5 * gap
                on_hold += 1
                continue
            on_hold -= 1
            rows[n, 0], rows[n, 1], rows[n, 2] = x, here, way
            q = next_q
            n += 1
    return n


@kernel
def keep_peak(peaks, n, hope, branch, lower, peak, upper):
    """Keep a minimum among the most hopeful, sorted by the distance that may hide there; return how many are kept."""
    if n == PEAKS and hope >= peaks[n - 1, 0]:
        return n
    i = min(n, PEAKS - 1)
    while i > 0 and peaks[i - 1, 0] > hope:
        for j in range(5):
            peaks[i, j] = peaks[i - 1, j]
        i -= 1
    peaks[i, 0] = hope
    peaks[i, 1] = branch
    peaks[i, 2] = lower
    peaks[i, 3] = peak
    peaks[i, 4] = upper
    return min(n + 1, PEAKS)


@kernel
def find_peaks(rows, count, branch, lowest, peaks, n):
    """Keep the minima among samples that may undercut a distance; return how many are kept in all."""
    for i in range(count):
        here = rows[i, 1]
        before = rows[max(i - 1, 0), 1]
        behind = rows[min(i + 1, count - 1), 1]
        if here > before or here > behind:
            continue
        hope = here
        if i > 0:
            hope = min(hope, least_between(before, here, rows[i, 2]))
        if i + 1 < count:
            hope = min(hope, least_between(here, behind, rows[i + 1, 2]))
        if hope < lowest:
            n = keep_peak(peaks, n, hope, branch, rows[max(i - 1, 0), 0], rows[i, 0], rows[min(i + 1, count - 1), 0])
    return n


@kernel
def nearest_within(P, place_, found, branch, goal, lowest):
    """The posture nearest to a seed over the intervals in rows of found: q, branch, cost.

    Looks for a cost below `lowest` alone. Where no posture keeps its limits, the least violating one is the nearest.
    """
    _, seed, respect = goal
    rows = np.empty((MOST, 3))
    wanted = np.empty(MAX_SAMPLES)
    held = np.empty(DEPTH)
    peaks = np.empty((PEAKS, 5))
    S = np.empty(STATE)
    sides = (elbow_side(P, place_, 0), elbow_side(P, place_, 1))
    closest = CLOSEST_OF_ALL if may_split(P, place_) else CLOSEST
    reached = height(lowest)
    kept = 0
    for i in range(found.shape[0]):
        b = int(found[i, 0])
        if branch >= 0 and b != branch:
            continue
        side = sides[b >> 2]
        _, floor = elbow_part(P, side[0], True, seed[3], respect)
        if height(floor) >= reached:
            continue
        count = sample(P, side, b, (found[i, 1], found[i, 2]), goal, (reached, closest), (wanted, held, rows))
        kept = find_peaks(rows, count, b, reached, peaks, kept)
        for k in range(count):
            # A little more than the sample, which is to be found again itself.
            reached = min(reached, rows[k, 1] * (1.0 + 1e-12))
    best_q, best, least = seed, 0, 4.0 * NO_BRANCH
    for i in range(kept):
        if peaks[i, 0] >= height(least):
            break
        b = int(peaks[i, 1])
        q, value = climb(P, sides[b >> 2], b, (peaks[i, 2], peaks[i, 3], peaks[i, 4]), goal, S)
        if value < least:
            best_q, best, least = q, b, value
    return best_q, best, least
