"""Every feasible posture of a pose, sampled: runs of postures close enough to miss nothing between them.

A run is a piece of a curve of postures. On an exact limb the curve is a branch and its parameter the arm angle; the
pieces are the feasible intervals. On a near limb it is a curve that `follow` has followed on the true chain, its
parameter the length along it; the ends of the pieces are closed in on.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, short_way
from srs_ik.kernels.algebra.minimum import GOLDEN
from srs_ik.kernels.algebra.roots import has_settled, next_parameter, start_crossing, tell_figure
from srs_ik.kernels.chain.newton import arm_angle, clipped
from srs_ik.kernels.curves.follow import CURVE, MAX_CURVES, SAMPLE, between, correct, follow_all, load_sample, put
from srs_ik.kernels.curves.gaps import put_bounds, put_gaps
from srs_ik.kernels.exact.samples import take_samples
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import IS_CLOSED, LOWER, UPPER
from srs_ik.kernels.layout.search import SPLIT
from srs_ik.kernels.limb.branches import NO_BRANCH, side_posture
from srs_ik.kernels.limb.goal import NO_SEED, turned
from srs_ik.kernels.limb.limits import beyond, beyond_any, turn_to_middle
from srs_ik.kernels.limb.triangle import elbow_side

LARGEST_MOTION = 0.5
"""Between neighbouring samples of a branch no joint moves by more than this, rad ..."""

SMALLEST_GAP = 1e-6
"""... unless they are this close, rad."""

DEPTH = 32
"""Room for samples on hold while the gap before them is filled: more than the halvings between the figures above."""

EDGE_STEPS = 100
DIP_STEPS = 40

SHALLOW = 0.5
"""A sample this far outside the limits, rad, may have feasible postures beside it."""


SPARE_ROWS = 1024
CURVE_ROWS = 8192
"""Room for samples: beside those of each interval of an exact limb, and for all curves of a near limb."""

LIMITS_IN_TURN = 3
ON_LIMIT = 1e-12
ASTRAY = 0.1
"""An edge is looked for on so many limits, one after the other; a posture on one, rad, keeps it; and it is no farther
from the way between two samples, squared and in parts of it."""

MOST_GAPS = 8
"""One for each joint between two samples."""


CUTS = 4
"""Samples for each gap between samples, where a part of a run is sampled again."""


@kernel
def is_exact(P):
    """Whether the closed form is the answer."""
    return P[IS_CLOSED] == 1.0


@kernel
def infeasibility(P, q, respect):
    """By how much a posture is not feasible, rad: 0 or less where it is."""
    return beyond_any(P, q) if respect else -1.0


@kernel
def infeasibility_of(P, row, respect):
    """The same for a sample."""
    return infeasibility(P, turned(P, load_sample(row), False, NO_SEED, respect), respect)


@kernel
def sample_before(rows, first, last, x):
    """The row of the sample before a parameter, of those in rows first to last - 1; never the last one."""
    low = first
    high = last - 1
    while high - low > 1:
        middle = (low + high) // 2
        if rows[middle, 0] <= x:
            low = middle
        else:
            high = middle
    return low


@kernel
def on_curve(P, side, R, p, branch, respect, rows, first, last, x, J, A):
    """Posture at a parameter, and its infeasibility; rows first to last - 1 sample the curve if no branch gives it."""
    if is_exact(P) and branch < SPLIT:
        q, _, value = side_posture(P, side, x, (branch >> 1) & 1, branch & 1, False, NO_SEED, respect)
        return q, (NO_BRANCH if value >= NO_BRANCH else infeasibility(P, q, respect))
    low = sample_before(rows, first, last, x)
    high = min(low + 1, last - 1)
    if x in (rows[low, 0], rows[high, 0]):
        # The sample itself: the end of a run keeps the limits to the last bit.
        q = load_sample(rows[low if x == rows[low, 0] else high])
    else:
        share = (x - rows[low, 0]) / (rows[high, 0] - rows[low, 0])
        q, met = between(P, R, p, load_sample(rows[low]), load_sample(rows[high]), share, J, A)
        if not met:
            return q, NO_BRANCH
    q = turned(P, q, False, NO_SEED, respect)
    return q, infeasibility(P, q, respect)


@kernel
def first_limit(P, a, b):
    """The limit that is met first on the straight way from a posture inside to one outside: joint, limit, share."""
    joint = -1
    limit = 0.0
    least = 2.0
    for j in range(7):
        at_b = turn_to_middle(P, j, b[j])
        at_a = turn_to_middle(P, j, a[j])
        off = beyond(P, j, at_b)
        if off > 0.0:
            inside = max(-beyond(P, j, at_a), 0.0)
            if inside < least * (inside + off):
                joint, least = j, inside / (inside + off)
                limit = P[UPPER + j] if at_b > P[UPPER + j] else P[LOWER + j]
    return joint, limit, least


@kernel
def only(joint, x):
    """A vector whose one figure is x."""
    return (
        x if joint == 0 else 0.0,
        x if joint == 1 else 0.0,
        x if joint == 2 else 0.0,
        x if joint == 3 else 0.0,
        x if joint == 4 else 0.0,
        x if joint == 5 else 0.0,
        x if joint == 6 else 0.0,
    )


@kernel
def edge_on_limit(P, R, p, rows, first, last, x, y, J, A):
    """`edge` by Newton's method for the pose and the limit together, and whether that is met between two samples."""
    low = sample_before(rows, first, last, 0.5 * (x + y))
    start, end = load_sample(rows[low]), load_sample(rows[low + 1])
    width = rows[low + 1, 0] - rows[low, 0]
    chord = difference(start, end)
    a = along7(start, (x - rows[low, 0]) / width, chord)
    b = along7(start, (y - rows[low, 0]) / width, chord)
    if min(x, y) < rows[low, 0] or max(x, y) > rows[low + 1, 0]:
        return x, False
    for _ in range(LIMITS_IN_TURN):
        joint, limit, share = first_limit(P, a, b)
        if joint < 0:
            return x, False
        q = along7(a, share, difference(a, b))
        # The same limit, a whole turn away or not.
        limit = q[joint] + short_way(limit - q[joint])
        q, met = correct(P, q, only(joint, 1.0), limit, R, p, J, A)
        if not met:
            return x, False
        to_q = difference(start, q)
        share = dot7(to_q, chord) / dot7(chord, chord)
        off = along7(to_q, -share, chord)
        found = rows[low, 0] + share * width
        if dot7(off, off) > ASTRAY * dot7(chord, chord) or (found - x) * (found - y) > 0.0:
            return x, False
        if infeasibility(P, turned(P, q, False, NO_SEED, True), True) < ON_LIMIT:
            return found, True
        b = q
    return x, False


@kernel
def edge(P, side, R, p, branch, respect, rows, first, last, x, fx, y, fy, J, A):
    """The last feasible parameter from a feasible one, x, towards y, which is not."""
    if not is_exact(P):
        found, met = edge_on_limit(P, R, p, rows, first, last, x, y, J, A)
        if met:
            return found
    crossing = start_crossing(x, fx, y, fy)
    for _ in range(EDGE_STEPS):
        if has_settled(crossing):
            break
        m = next_parameter(crossing)
        _, f = on_curve(P, side, R, p, branch, respect, rows, first, last, m, J, A)
        crossing = tell_figure(crossing, m, f)
    return crossing[0]


@kernel
def dip(P, side, R, p, branch, respect, rows, first, last, a, b, J, A):
    """The least infeasible parameter between two, or any feasible one: parameter and infeasibility."""
    x = b - GOLDEN * (b - a)
    y = a + GOLDEN * (b - a)
    wanted = x
    fx = NO_BRANCH
    fy = NO_BRANCH
    for i in range(DIP_STEPS):
        _, f = on_curve(P, side, R, p, branch, respect, rows, first, last, wanted, J, A)
        if f <= 0.0:
            return wanted, f
        if wanted == x:
            fx = f
        else:
            fy = f
        if i == 0:
            wanted = y
        elif fx <= fy:
            b, y, fy = y, x, fx
            x = b - GOLDEN * (b - a)
            wanted = x
        else:
            a, x, fx = x, y, fy
            y = a + GOLDEN * (b - a)
            wanted = y
    return wanted, 1.0


@kernel
def put_run(P, side, R, p, branch, respect, line, first, last, lower, upper, out, n, runs, k, J, A):
    """Write the run between two feasible parameters of a sampled curve, its samples and ends: rows and runs in use."""
    if k >= runs.shape[0]:
        return n, k
    runs[k, 0] = branch
    runs[k, 1] = lower
    runs[k, 2] = upper
    runs[k, 3] = n
    # The ends are on a limit up to rounding: on it, so that they count as inside.
    q, _ = on_curve(P, side, R, p, branch, respect, line, first, last, lower, J, A)
    n = put(out, n, lower, clipped(P, q) if respect else q)
    for i in range(first, last):
        if lower < line[i, 0] < upper:
            n = put(out, n, line[i, 0], turned(P, load_sample(line[i]), False, NO_SEED, respect))
    if upper > lower:
        q, _ = on_curve(P, side, R, p, branch, respect, line, first, last, upper, J, A)
        n = put(out, n, upper, clipped(P, q) if respect else q)
    runs[k, 4] = n
    return n, (k + 1 if n > runs[k, 3] else k)


@kernel
def cut(P, side, R, p, branch, respect, line, first, last, out, n, runs, k, J, A):
    """Cut a sampled curve, rows first to last - 1 of line, into its feasible runs: rows and runs in use."""
    lower = line[first, 0]
    f_before = -1.0  # infeasibility of the sample before the last one, as long as neither is feasible
    x0 = lower
    f0 = infeasibility_of(P, line[first], respect)
    for i in range(first + 1, last):
        x1 = line[i, 0]
        f1 = infeasibility_of(P, line[i], respect)
        upper = lower - 1.0
        if f0 > 0.0 and f1 <= 0.0:
            lower = edge(P, side, R, p, branch, respect, line, first, last, x1, f1, x0, f0, J, A)
        elif f0 <= 0.0 and f1 > 0.0:
            upper = edge(P, side, R, p, branch, respect, line, first, last, x0, f0, x1, f1, J, A)
        elif 0.0 < f0 < f_before and f0 <= f1 and f0 < SHALLOW:
            x, f = dip(P, side, R, p, branch, respect, line, first, last, line[i - 2, 0], x1, J, A)
            if f <= 0.0:
                lower = edge(P, side, R, p, branch, respect, line, first, last, x, f, line[i - 2, 0], f_before, J, A)
                upper = edge(P, side, R, p, branch, respect, line, first, last, x, f, x1, f1, J, A)
        if i == last - 1 and f1 <= 0.0:
            upper = x1
        if upper >= lower:
            n, k = put_run(P, side, R, p, branch, respect, line, first, last, lower, upper, out, n, runs, k, J, A)
        f_before = f0 if f0 > 0.0 else -1.0
        x0, f0 = x1, f1
    if last - first == 1 and f0 <= 0.0:
        n, k = put_run(P, side, R, p, branch, respect, line, first, last, x0, x0, out, n, runs, k, J, A)
    return n, k


@kernel
def far_apart(a, b):
    """Whether a joint moves too far between two samples."""
    d = difference(a, b)
    largest = max(abs(d[0]), abs(d[1]), abs(d[2]), abs(d[3]), abs(d[4]), abs(d[5]), abs(d[6]))
    return largest > LARGEST_MOTION


@kernel
def sample_branch(P, side, R, p, branch, lower, upper, work, line, J, A):
    """Sample an interval of a branch of an exact limb into line, closer where joints move fast; the number of rows."""
    wanted = work[0]
    held = work[1]
    count = take_samples(P, side, lower, upper, wanted)
    q, _ = on_curve(P, side, R, p, branch, False, line, 0, 0, lower, J, A)
    n = put(line, 0, lower, q)
    for i in range(1, count):
        held[0] = wanted[i]
        on_hold = 1
        while on_hold > 0:
            x = held[on_hold - 1]
            next_q, f = on_curve(P, side, R, p, branch, False, line, 0, 0, x, J, A)
            gap = x - line[n - 1, 0]
            if on_hold < DEPTH and gap > SMALLEST_GAP and f < NO_BRANCH and far_apart(q, next_q):
                held[on_hold] = x - 0.5 * gap
                on_hold += 1
                continue
            on_hold -= 1
            q = next_q
            n = put(line, n, x, q)
    return n


@kernel
def unroll(P, R, p, rows, curve, respect, line, J, A):
    """Copy a followed curve to line, a closed one from a posture outside the limits on if there is one; rows in use.

    Where limits count, the gaps between them get samples of their own.
    """
    first = int(curve[0])
    count = int(curve[1]) - first
    start = 0
    if curve[2] == 1.0:
        for i in range(count - 1):
            if infeasibility_of(P, rows[first + i], respect) > 0.0:
                start = i
                break
    length = rows[first + count - 1, 0]
    gaps = np.empty((MOST_GAPS, SAMPLE))
    n = 0
    x = 0.0
    q = NO_SEED
    for i in range(count):
        j = start + i
        round_ = 0.0
        if j >= count:
            j -= count - 1
            round_ = length
        next_x = rows[first + j, 0] + round_
        next_q = load_sample(rows[first + j])
        if respect and i > 0:
            for k in range(put_gaps(P, R, p, x, q, next_x, next_q, gaps, 0, J, A)):
                gap_q = load_sample(gaps[k])
                n = put_bounds(P, R, p, x, q, gaps[k, 0], gap_q, line, n, J, A)
                n = put(line, n, gaps[k, 0], gap_q)
                x, q = gaps[k, 0], gap_q
            n = put_bounds(P, R, p, x, q, next_x, next_q, line, n, J, A)
        n = put(line, n, next_x, next_q)
        x, q = next_x, next_q
    return n


@kernel
def survey_exact(P, place_, R, p, found, pieces, respect, work, line, out, runs, J, A):
    """Sample the feasible intervals in the first rows of found (branch, lower, upper): rows and runs in use."""
    n = 0
    k = 0
    elbow = -1
    side = elbow_side(P, place_, 0)
    for i in range(pieces):
        branch = int(found[i, 0])
        if branch >> 2 != elbow:
            elbow = branch >> 2
            side = elbow_side(P, place_, elbow)
        count = sample_branch(P, side, R, p, branch, found[i, 1], found[i, 2], work, line, J, A)
        n, k = cut(P, side, R, p, branch, respect, line, 0, count, out, n, runs, k, J, A)
    return n, k


@kernel
def survey_near(P, place_, R, p, respect, curves, rows, line, out, runs, J, A):
    """Sample all feasible postures of a near limb: rows and runs in use."""
    n = 0
    k = 0
    side = elbow_side(P, place_, 0)
    count = follow_all(P, place_, R, p, respect, rows, curves, J, A)
    for i in range(count):
        length = unroll(P, R, p, rows, curves[i], respect, line, J, A)
        n, k = cut(P, side, R, p, 0, respect, line, 0, length, out, n, runs, k, J, A)
    return n, k


@kernel
def near_runs(P, place_, R, p, respect, runs, J, A):
    """`survey_near` with room of its own: samples, rows and runs in use, and spare rows for samples of one curve."""
    curves = np.empty((MAX_CURVES, CURVE))
    followed = np.empty((CURVE_ROWS, SAMPLE))
    rows = np.empty((CURVE_ROWS + SPARE_ROWS, SAMPLE))
    line = np.empty((CURVE_ROWS, SAMPLE))
    n, k = survey_near(P, place_, R, p, respect, curves, followed, line, rows, runs, J, A)
    return rows, n, k, line


@kernel
def sample_again(P, side, R, p, respect, rows, run, lower, upper, line, J, A):
    """Sample a part of a run, a few times as close: rows of line in use."""
    branch = int(run[0])
    first = int(run[3])
    last = int(run[4])
    q, _ = on_curve(P, side, R, p, branch, respect, rows, first, last, lower, J, A)
    n = put(line, 0, lower, q)
    a = lower
    for i in range(first, last):
        b = min(rows[i, 0], upper) if i < last - 1 else upper
        if b <= a:
            continue
        for c in range(1, CUTS + 1):
            x = b if c == CUTS else a + (b - a) * c / CUTS
            q, _ = on_curve(P, side, R, p, branch, respect, rows, first, last, x, J, A)
            n = put(line, n, x, q)
        a = b
    return n


@kernel
def arm_angles_of_run(P, place_, rows, run):
    """First and last arm angle of a run; where these are not its parameters, the least and the greatest on its way."""
    if is_exact(P) and run[0] < SPLIT:
        return run[1], run[2]
    first = int(run[3])
    psi = arm_angle(P, load_sample(rows[first]), place_[0], place_[1])
    lower = psi
    upper = psi
    for i in range(first + 1, int(run[4])):
        d = arm_angle(P, load_sample(rows[i]), place_[0], place_[1]) - psi
        psi += d - 2.0 * math.pi * math.floor(d / (2.0 * math.pi) + 0.5)
        lower = min(lower, psi)
        upper = max(upper, psi)
    if upper - lower >= 2.0 * math.pi:
        return -math.pi, math.pi
    shift = 2.0 * math.pi * math.floor((lower + math.pi) / (2.0 * math.pi))
    return lower - shift, upper - shift
