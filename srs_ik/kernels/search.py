"""One posture for a pose: at an arm angle, or the best over the whole redundancy.

`evaluate` is the one place where a posture is made: closed form on the exact limb, then, on a near limb, Newton's
method on the true chain. The search above it works on arm angles alone: it looks at every feasible interval at a
spacing that follows the joints, and closes in on each peak that may be the best.

Where a kernel takes the work spaces J (6, 7) and A (7, 9), None stands for them on a limb that the closed form answers:
what a near limb needs is then not compiled at all.
"""

from __future__ import annotations

import math

from srs_ik.kernels.branches import NO_BRANCH, best_branch, branch_of, side_posture
from srs_ik.kernels.closure import close_at_angle
from srs_ik.kernels.elbow import elbow_side
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import (
    A1,
    A1_A2,
    A2,
    A2_A3,
    A3,
    FIRST_JOINT,
    INVERSE_HALF_RANGE,
    LOWER,
    MIDDLE,
    RANGE_KIND,
    SHOULDER,
    UPPER,
    WRIST,
)
from srs_ik.kernels.scoring import OUTSIDE, cost, elbow_part, turn
from srs_ik.kernels.vectors import dot, load3, rotate

STEP = 2.0 * math.pi / 48.0
"""Widest spacing of the arm angles at which an interval is first looked at."""

SMALLEST_COUNT = 8
"""Fewest parts into which an interval is cut."""

PEAKS = 32
"""So many of the most hopeful peaks are closed in on, as long as they may beat the best so far."""

MOST_RISE = 4.0
"""A neighbour outside the limits tells nothing of the slope; the cost falls no more than this below a sample."""

BESIDE = 1e-8
"""So close on either side of a change of turns a sample is taken, rad: the cost may jump there."""

MAX_SAMPLES = 256
"""Most arm angles at which an interval is looked at first."""

REFINE_STEPS = 60
"""Golden-section steps at most; each leaves 62 % of the bracket."""

GOLDEN = 0.6180339887498949

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
def branch_at(P, side, psi, branch, seeded, seed, respect):
    """Posture of one branch at an arm angle on the exact limb: q, cost."""
    q, _, lowest = side_posture(P, side, psi, (branch >> 1) & 1, branch & 1, seeded, seed, respect)
    return q, lowest


@kernel
def refine(P, side, branch, lower, upper, seeded, seed, respect):
    """Golden-section search for the best arm angle of a branch between two arm angles: psi, q, cost."""
    a = lower
    b = upper
    x = b - GOLDEN * (b - a)
    y = a + GOLDEN * (b - a)
    qx, fx = branch_at(P, side, x, branch, seeded, seed, respect)
    qy, fy = branch_at(P, side, y, branch, seeded, seed, respect)
    for _ in range(REFINE_STEPS):
        if b - a < 1e-10:
            break
        if fx <= fy:
            b = y
            y = x
            qy = qx
            fy = fx
            x = b - GOLDEN * (b - a)
            qx, fx = branch_at(P, side, x, branch, seeded, seed, respect)
        else:
            a = x
            x = y
            qx = qy
            fx = fy
            y = a + GOLDEN * (b - a)
            qy, fy = branch_at(P, side, y, branch, seeded, seed, respect)
    if fx <= fy:
        return x, qx, fx
    return y, qy, fy


@kernel
def add_sample(samples, n, x, lower, upper):
    """Insert an arm angle, if it lies inside, into the sorted first n samples."""
    if not lower < x < upper or n >= MAX_SAMPLES:
        return n
    i = n
    while i > 0 and samples[i - 1] > x:
        samples[i] = samples[i - 1]
        i -= 1
    samples[i] = x
    return n + 1


@kernel
def add_swings(P, k, motion, lower, upper, samples, n):
    """Samples where a spherical joint passes close to its singularity, and joints 1 and 3 turn fast.

    There they move like the arc tangent of the distance over the closest distance, so the samples follow a tangent.
    """
    circle = motion[0]
    a1 = load3(P, k + A1)
    constant = dot(a1, circle[0])
    c = dot(a1, circle[1])
    s = dot(a1, circle[2])
    r = math.sqrt(c * c + s * s)
    if r < 1e-9:
        return n
    for end in range(2):
        closest = constant + r if end == 0 else -(constant - r)
        middle = math.atan2(s, c) if end == 0 else math.atan2(-s, -c)
        width = math.sqrt(max(2.0 * (1.0 - closest), 1e-16)) / r
        if width > 0.5:
            continue
        for turns in range(-1, 2):
            for i in range(-4, 5):
                x = middle + 2.0 * math.pi * turns + width * math.tan(i * math.pi / 10.0)
                n = add_sample(samples, n, x, lower, upper)
    return n


@kernel
def add_turns(P, k, motion, lower, upper, seeded, seed, samples, n):
    """Samples where a joint of a spherical joint changes turns, for ranges of more than a turn.

    Next to a seed, that is where the nearer turn leaves the limits, or the seed is half a turn away; else, where the
    middle of the range is.
    """
    first = int(P[k + FIRST_JOINT])
    a1 = load3(P, k + A1)
    a2 = load3(P, k + A2)
    a3 = load3(P, k + A3)
    for end in range(3):
        joint = first + end
        if P[RANGE_KIND + joint] != 0.0 or P[INVERSE_HALF_RANGE + joint] == 0.0:
            continue
        half_away = (seed[joint] if seeded else P[MIDDLE + joint]) + math.pi
        for i in range(3):
            bound = half_away if i == 0 else (P[LOWER + joint] if i == 1 else P[UPPER + joint])
            if end == 0:
                x = rotate(a1, math.cos(bound), math.sin(bound), a2)
                circle = motion[0]
                value = P[k + A2_A3]
            elif end == 1:
                x = a1
                circle = motion[0]
                value = dot(a1, rotate(a2, math.cos(bound), math.sin(bound), a3))
            else:
                x = rotate(a3, math.cos(bound), -math.sin(bound), a2)
                circle = motion[2]
                value = P[k + A1_A2]
            c = dot(x, circle[1])
            s = dot(x, circle[2])
            rest = value - dot(x, circle[0])
            r = math.sqrt(c * c + s * s)
            if abs(rest) < r:
                apart = math.atan2(math.sqrt((r - rest) * (r + rest)), rest)
                for turns in range(-1, 2):
                    middle = math.atan2(s, c) + 2.0 * math.pi * turns
                    for change in (middle + apart, middle - apart):
                        n = add_sample(samples, n, change - BESIDE, lower, upper)
                        n = add_sample(samples, n, change + BESIDE, lower, upper)
    return n


@kernel
def take_samples(P, side, lower, upper, seeded, seed, samples):
    """Fill in the sorted arm angles at which to look at an interval first, its ends included; return their number."""
    samples[0] = lower
    if upper <= lower:
        return 1
    count = max(math.ceil((upper - lower) / STEP), SMALLEST_COUNT)
    for i in range(1, count + 1):
        samples[i] = lower + (upper - lower) * i / count
    samples[count] = upper
    n = add_swings(P, SHOULDER, side[1], lower, upper, samples, count + 1)
    n = add_swings(P, WRIST, side[2], lower, upper, samples, n)
    n = add_turns(P, SHOULDER, side[1], lower, upper, seeded, seed, samples, n)
    return add_turns(P, WRIST, side[2], lower, upper, seeded, seed, samples, n)


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
def scan(P, side, branch, lower, upper, seeded, seed, respect, samples, values, peaks, n):
    """Look at an interval of a branch and keep its peaks; return how many are kept in all."""
    count = take_samples(P, side, lower, upper, seeded, seed, samples)
    for i in range(count):
        _, values[i] = branch_at(P, side, samples[i], branch, seeded, seed, respect)
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
def search_peaks(P, place_, seeded, seed, respect, peaks, n):
    """Close in on peaks: q, branch, cost of the best."""
    best_q = seed
    best = 0
    lowest = 4.0 * NO_BRANCH
    wide = has_wide_range(P)
    for i in range(n):
        if peaks[i, 0] >= lowest:
            break
        branch = int(peaks[i, 1])
        side = elbow_side(P, place_, branch >> 2)
        if wide:
            # The cost may jump at the peak itself, where a joint changes turns.
            _, q, value = refine(P, side, branch, peaks[i, 2], peaks[i, 3], seeded, seed, respect)
            _, qe, ve = refine(P, side, branch, peaks[i, 3], peaks[i, 4], seeded, seed, respect)
            if ve < value:
                q, value = qe, ve
        else:
            _, q, value = refine(P, side, branch, peaks[i, 2], peaks[i, 4], seeded, seed, respect)
        for k in range(2, 5):
            # A golden section never touches the ends of its bracket, nor a singular posture between them.
            qe, ve = branch_at(P, side, peaks[i, k], branch, seeded, seed, respect)
            if ve <= value:
                q, value = qe, ve
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
        _, floor = elbow_part(P, side[0], seeded, seed[3], respect)
        if n == PEAKS and floor >= peaks[n - 1, 0]:
            continue
        n = scan(P, side, b, found[i, 1], found[i, 2], seeded, seed, respect, samples, values, peaks, n)
    return search_peaks(P, place_, seeded, seed, respect, peaks, n)
