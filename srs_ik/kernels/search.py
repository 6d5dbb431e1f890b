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
from srs_ik.kernels.closure import CLOSED, clipped, close_at_angle, close_free
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
    PHASE,
    RANGE_KIND,
    SHOULDER,
    STRAIGHT,
    UPPER,
    WRIST,
)
from srs_ik.kernels.scoring import OUTSIDE, cost, elbow_part, turn
from srs_ik.kernels.vectors import dot, load3, rotate

STEP = 2.0 * math.pi / 48.0
"""Widest spacing of the arm angles at which an interval is first looked at."""

SMALLEST_COUNT = 8
"""Fewest parts into which an interval is cut."""

PEAKS = 24
"""So many of the most hopeful peaks are closed in on, as long as they may beat the best so far."""

MOST_RISE = 4.0
"""A neighbour outside the limits tells nothing of the slope; the cost falls no more than this below a sample."""

MAX_SAMPLES = 160
"""Most arm angles at which an interval is looked at first."""

REFINE_STEPS = 60
"""Golden-section steps at most; each leaves 62 % of the bracket."""

GOLDEN = 0.6180339887498949

STEPS = 12
MORE_STEPS = 80
"""Steps of Newton's method at an arm angle: from the closed form, and where that failed."""

ATTEMPTS = 9
"""Arm angles from which a given one is tried."""

ALMOST = 0.1
JITTERS = 100
"""A near limb that comes this close to a pose (m, rad) is tried from so many more postures around."""

NEAR_SINGULAR = 0.05
"""Sine of a middle angle under which a spherical joint or the elbow is close to singular, for a second attempt."""


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
    q, closed = close_at_angle(P, q, R, p, place_[0], place_[1], psi, STEPS, J, A)
    if not closed or branch_of(P, q) != branch:
        return q, NO_BRANCH
    q = turned(P, q, seeded, seed, respect)
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
def refine(P, place_, side, R, p, branch, lower, upper, seeded, seed, respect, J, A):
    """Golden-section search for the best arm angle of a branch between two arm angles: psi, q, cost."""
    a = lower
    b = upper
    x = b - GOLDEN * (b - a)
    y = a + GOLDEN * (b - a)
    qx, fx = evaluate_branch(P, place_, side, R, p, x, branch, seeded, seed, respect, J, A)
    qy, fy = evaluate_branch(P, place_, side, R, p, y, branch, seeded, seed, respect, J, A)
    for _ in range(REFINE_STEPS):
        if b - a < 1e-10:
            break
        if fx <= fy:
            b = y
            y = x
            qy = qx
            fy = fx
            x = b - GOLDEN * (b - a)
            qx, fx = evaluate_branch(P, place_, side, R, p, x, branch, seeded, seed, respect, J, A)
        else:
            a = x
            x = y
            qx = qy
            fx = fy
            y = a + GOLDEN * (b - a)
            qy, fy = evaluate_branch(P, place_, side, R, p, y, branch, seeded, seed, respect, J, A)
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
                    n = add_sample(samples, n, middle + apart, lower, upper)
                    n = add_sample(samples, n, middle - apart, lower, upper)
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
def scan(P, place_, side, R, p, branch, lower, upper, seeded, seed, respect, samples, values, peaks, n, J, A):
    """Look at an interval of a branch and keep its peaks; return how many are kept in all."""
    count = take_samples(P, side, lower, upper, seeded, seed, samples)
    for i in range(count):
        _, values[i] = evaluate_branch(P, place_, side, R, p, samples[i], branch, seeded, seed, respect, J, A)
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
def search_peaks(P, place_, R, p, seeded, seed, respect, peaks, n, J, A):
    """Close in on peaks on the true chain: q, branch, cost of the best."""
    best_q = seed
    best = 0
    lowest = 4.0 * NO_BRANCH
    for i in range(n):
        if peaks[i, 0] >= lowest:
            break
        branch = int(peaks[i, 1])
        side = elbow_side(P, place_, branch >> 2)
        _, q, value = refine(P, place_, side, R, p, branch, peaks[i, 2], peaks[i, 4], seeded, seed, respect, J, A)
        for k in range(2, 5):
            # A golden section never touches the ends of its bracket, nor a singular posture between them.
            qe, ve = evaluate_branch(P, place_, side, R, p, peaks[i, k], branch, seeded, seed, respect, J, A)
            if ve <= value:
                q = qe
                value = ve
        if value < lowest:
            best_q = q
            best = branch
            lowest = value
    return best_q, best, lowest


@kernel
def search_intervals(P, place_, R, p, found, first, last, branch, seeded, seed, respect, work, J, A):
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
        n = scan(
            P, place_, side, R, p, b, found[i, 1], found[i, 2], seeded, seed, respect, samples, values, peaks, n, J, A
        )
    return search_peaks(P, place_, R, p, seeded, seed, respect, peaks, n, J, A)


@kernel
def bent(q, phase, side):
    """A middle angle, moved away from its phase (or the opposite of it) to its side if it is close."""
    if abs(math.sin(q - phase)) > NEAR_SINGULAR:
        return q
    inwards = 2.0 * NEAR_SINGULAR if math.cos(q - phase) > 0.0 else -2.0 * NEAR_SINGULAR
    return q + inwards if side == 0 else q - inwards


@kernel
def bend(P, q, branch):
    """A posture with elbow, shoulder and wrist moved away from their singularities, to the sides of a branch."""
    return (
        q[0],
        bent(q[1], P[SHOULDER + PHASE], (branch >> 1) & 1),
        q[2],
        bent(q[3], P[STRAIGHT], branch >> 2),
        q[4],
        bent(q[5], P[WRIST + PHASE], branch & 1),
        q[6],
    )


@kernel
def evaluate_again(P, place_, R, p, psi, branch, seeded, seed, respect, attempts, J, A):
    """Second attempt at an arm angle on a near limb, where Newton's method did not close: from many postures.

    Near a singular shoulder or wrist the closed form fixes two joint angles of which the true chain knows little more
    than their sum. So the starts turn one against the other, and bend what is straight.
    """
    best_q, best, _ = best_branch(P, place_, psi, branch, seeded, seed, respect)
    lowest = 2.0 * NO_BRANCH
    for attempt in range(attempts):
        # At the arm angle itself, then from either side of it, farther and farther.
        from_psi = psi + (0.0 if attempt == 0 else (0.25 if attempt % 2 == 0 else -0.25) * ((attempt + 1) // 2))
        for b in range(8):
            q0, _, exists = best_branch(P, place_, from_psi, b, False, seed, False)
            if exists >= NO_BRANCH:
                continue
            q = bend(P, q0, b)
            turns_s = 6 if q[1] != q0[1] else 1
            turns_w = 6 if q[5] != q0[5] else 1
            against_s = -1.0 if math.cos(q[1] - P[SHOULDER + PHASE]) > 0.0 else 1.0
            against_w = -1.0 if math.cos(q[5] - P[WRIST + PHASE]) > 0.0 else 1.0
            for i in range(turns_s * turns_w):
                ds = (i % turns_s) * math.pi / 3.0
                dw = (i // turns_s) * math.pi / 3.0
                start = (q[0] + ds, q[1], q[2] + against_s * ds, q[3], q[4] + dw, q[5], q[6] + against_w * dw)
                closed_q, closed = close_at_angle(P, start, R, p, place_[0], place_[1], psi, MORE_STEPS, J, A)
                if closed and (branch < 0 or branch_of(P, closed_q) == branch):
                    closed_q = turned(P, closed_q, seeded, seed, respect)
                    value = cost(P, closed_q, seeded, seed, respect)
                    if value < lowest:
                        best_q = closed_q
                        best = branch_of(P, closed_q)
                        lowest = value
        if lowest < OUTSIDE:
            break
    return best_q, best, lowest


@kernel
def jitter(q, state, size):
    """A posture with every joint moved by up to `size`, by a linear congruential generator: the same one always."""
    state = (state * 1103515245 + 12345) % 2147483648
    a = size * (state / 1073741824.0 - 1.0)
    state = (state * 1103515245 + 12345) % 2147483648
    b = size * (state / 1073741824.0 - 1.0)
    state = (state * 1103515245 + 12345) % 2147483648
    c = size * (state / 1073741824.0 - 1.0)
    state = (state * 1103515245 + 12345) % 2147483648
    d = size * (state / 1073741824.0 - 1.0)
    state = (state * 1103515245 + 12345) % 2147483648
    e = size * (state / 1073741824.0 - 1.0)
    return (q[0] + a, q[1] + b, q[2] + c, q[3] + d, q[4] + e, q[5] + a * 0.7 - b, q[6] + c * 0.7 - d), state


@kernel
def free_start(P, q, R, p, wanted, seeded, seed, respect, J, A):
    """Free steps from a posture: q and its cost, more than any posture's if pose or wanted branch are not reached."""
    if respect:
        q = clipped(P, q)
    q, error = close_free(P, q, R, p, respect, MORE_STEPS, J, A)
    q = turned(P, q, seeded, seed, respect)
    if error > CLOSED:
        return q, OUTSIDE * (2.0 + error)
    if wanted >= 0 and branch_of(P, q) != wanted:
        return q, OUTSIDE * 10.0
    return q, cost(P, q, seeded, seed, respect)


@kernel
def rescue(P, place_, R, p, branch, seeded, seed, respect, J, A):
    """Last resort on a near limb, free steps from postures on the circle, then from bent ones: q, branch, cost.

    Close to the edge of reach, the nearest exact limb may not reach a pose that the true one does, and a given arm
    angle may have no solution where a neighbouring one has.
    """
    best_q = seed
    best = 0
    lowest = 2.0 * NO_BRANCH
    first = 0 if branch < 0 else branch
    last = 7 if branch < 0 else branch
    for attempt in range(2):
        for i in range(12):
            for b in range(first, last + 1):
                q, _, value = best_branch(P, place_, i * math.pi / 6.0, b, seeded, seed, respect)
                if value < NO_BRANCH:
                    if attempt == 1:
                        q = bend(P, q, b)
                    q, value = free_start(P, q, R, p, branch, seeded, seed, respect, J, A)
                    if value < lowest:
                        best_q = q
                        best = b
                        lowest = value
        if lowest < OUTSIDE:
            return best_q, best, lowest
    if lowest < OUTSIDE * (2.0 + ALMOST):
        state = 1
        around = best_q
        for i in range(JITTERS):
            q, state = jitter(around, state, 0.02 if i % 2 == 0 else 0.3)
            q, value = free_start(P, q, R, p, branch, seeded, seed, respect, J, A)
            if value < lowest:
                best_q = q
                best = branch_of(P, q)
                lowest = value
                if lowest < OUTSIDE:
                    break
    return best_q, best, lowest
