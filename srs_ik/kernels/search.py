"""One posture for a pose: at an arm angle, or the best over the whole redundancy.

`evaluate` is the one place where a posture is made: closed form on the exact limb, then, on a near limb, Newton's
method on the true chain. The search above it works on arm angles alone. Without a seed it is that of `margin`; for a
seed it looks at every feasible interval at a spacing that follows the joints (`samples`), and closes in on each peak
that may be the best.

Where a kernel takes the work spaces J (6, 7) and A (7, 9), None stands for them on a limb that the closed form answers:
what a near limb needs is then not compiled at all.
"""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.branches import NO_BRANCH, best_branch, branch_of, side_posture
from srs_ik.kernels.closure import close_at_angle
from srs_ik.kernels.elbow import elbow_side
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import INVERSE_HALF_RANGE, RANGE_KIND
from srs_ik.kernels.line_search import STATE
from srs_ik.kernels.margin import branch_at, climb, farthest
from srs_ik.kernels.samples import take_samples
from srs_ik.kernels.scoring import OUTSIDE, cost, elbow_part, turn

PEAKS = 32
"""So many of the most hopeful peaks are closed in on, as long as they may beat the best so far."""

MOST_RISE = 4.0
"""A neighbour outside the limits tells nothing of the slope; the cost falls no more than this below a sample."""

STEPS = 12
"""Steps of Newton's method at an arm angle, from the closed form."""


@kernel
def turned(P, q, seeded, seed, respect):
    """Every joint in the turn that suits the goal."""
    return (
        turn(P, 0, q[0], seeded, seed[0], respect),
        turn(P, 1, q[1], seeded, seed[1], respect),
        turn(P, 2, q[2], seeded, seed[2], respect),
        turn(P, 3, q[3], seeded, seed[3], respect),
        turn(P, 4, q[4], seeded, seed[4], respect),
        turn(P, 5, q[5], seeded, seed[5], respect),
        turn(P, 6, q[6], seeded, seed[6], respect),
    )


@kernel
def evaluate_branch(P, place_, side, R, p, psi, branch, seeded, seed, respect, J, A):
    """Posture of one branch at an arm angle on the true chain: q, cost (NO_BRANCH where there is none)."""
    q, _, lowest = side_posture(P, side, psi, (branch >> 1) & 1, branch & 1, seeded, seed, respect)
    if J is None:
        return q, lowest
    if lowest >= NO_BRANCH:
        return q, lowest
    closed_q, closed = close_at_angle(P, q, R, p, place_[0], place_[1], psi, STEPS, J, A)
    if not closed or branch_of(P, closed_q) != branch:
        # Newton's method may have met the pose, but elsewhere: that is no answer.
        return q, NO_BRANCH
    q = turned(P, closed_q, seeded, seed, respect)
    return q, cost(P, q, seeded, seed, respect)


@kernel
def evaluate(P, place_, R, p, psi, branch, seeded, seed, respect, J, A):
    """Best posture at an arm angle over all branches, or in one (0 to 7): q, branch, cost."""
    if J is None:
        return best_branch(P, place_, psi, branch, seeded, seed, respect)
    best_q = seed
    best = 0
    lowest = 4.0 * NO_BRANCH
    for elbow in range(2):
        if branch >= 0 and branch >> 2 != elbow:
            continue
        side = elbow_side(P, place_, elbow)
        for b in range(4 * elbow, 4 * elbow + 4):
            if branch >= 0 and b != branch:
                continue
            q, value = evaluate_branch(P, place_, side, R, p, psi, b, seeded, seed, respect, J, A)
            if value < lowest:
                best_q = q
                best = b
                lowest = value
    return best_q, best, lowest


@kernel
def keep_peak(peaks, n, hope, branch, lower, peak, upper):
    """Keep a peak among the most hopeful, sorted by the cost that may hide there; return how many are kept."""
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
def scan(P, side, branch, lower, upper, seed, respect, samples, values, peaks, n):
    """Look at an interval of a branch and keep its peaks; return how many are kept in all."""
    count = take_samples(P, side, lower, upper, True, seed, samples)
    for i in range(count):
        _, values[i] = branch_at(P, side, samples[i], branch, True, seed, respect)
    for i in range(count):
        before = values[i - 1] if i > 0 else values[i]
        behind = values[i + 1] if i + 1 < count else values[i]
        if values[i] <= before and values[i] <= behind:
            # Between the neighbours the cost falls no deeper below the sample than they rise above it.
            rise = max(min(before, OUTSIDE) - values[i], min(behind, OUTSIDE) - values[i], 0.0)
            hope = values[i] - min(rise, MOST_RISE)
            n = keep_peak(peaks, n, hope, branch, samples[max(i - 1, 0)], samples[i], samples[min(i + 1, count - 1)])
    return n


@kernel
def has_wide_range(P):
    """Whether a joint has limits more than a turn apart: its nearest turn may jump within an interval."""
    wide = False
    for j in range(7):
        wide = wide or (P[RANGE_KIND + j] == 0.0 and P[INVERSE_HALF_RANGE + j] > 0.0)
    return wide


@kernel
def search_peaks(P, place_, seed, respect, peaks, n):
    """Close in on peaks: q, branch, cost of the best."""
    best_q = seed
    best = 0
    lowest = 4.0 * NO_BRANCH
    wide = has_wide_range(P)
    S = np.empty(STATE)
    for i in range(n):
        if peaks[i, 0] >= lowest:
            break
        branch = int(peaks[i, 1])
        side = elbow_side(P, place_, branch >> 2)
        a, x, b = peaks[i, 2], peaks[i, 3], peaks[i, 4]
        q, value = climb(P, side, branch, a, x, b, True, seed, respect, S)
        if wide and a < x < b:
            # The cost may jump at the peak itself, where a joint changes turns.
            for y, z in ((a, x), (x, b)):
                other, f = climb(P, side, branch, y, 0.5 * (y + z), z, True, seed, respect, S)
                if f < value:
                    q, value = other, f
        if value < lowest:
            best_q = q
            best = branch
            lowest = value
    return best_q, best, lowest


@kernel
def search_intervals(P, place_, found, first, last, branch, seeded, seed, respect, work):
    """Best posture over the intervals in rows first to last - 1 of found: q, branch, cost.

    work is (3, MAX_SAMPLES) work space.
    """
    if not seeded:
        return farthest(P, place_, found, first, last, branch, respect)
    samples = work[0]
    values = work[1]
    peaks = work[2, : 5 * PEAKS].reshape((PEAKS, 5))
    n = 0
    elbow = -1
    side = elbow_side(P, place_, 0)
    for i in range(first, last):
        b = int(found[i, 0])
        if branch >= 0 and b != branch:
            continue
        if b >> 2 != elbow:
            elbow = b >> 2
            side = elbow_side(P, place_, elbow)
        _, floor = elbow_part(P, side[0], True, seed[3], respect)
        if n == PEAKS and floor >= peaks[n - 1, 0]:
            continue
        n = scan(P, side, b, found[i, 1], found[i, 2], seed, respect, samples, values, peaks, n)
    return search_peaks(P, place_, seed, respect, peaks, n)
