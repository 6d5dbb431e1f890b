"""Every feasible posture of a pose, sampled: runs of postures close enough to miss nothing between them.

A run is a piece of a curve of postures. On an exact limb the curve is a branch and its parameter the arm angle; the
pieces are the feasible intervals. On a near limb it is a curve that `follow` has followed on the true chain, its
parameter the length along it; the ends of the pieces are closed in on.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import difference
from srs_ik.kernels.chain.newton import arm_angle, clipped
from srs_ik.kernels.curves.ends import dip, edge, infeasibility_of, is_exact, on_curve
from srs_ik.kernels.curves.follow import CURVE, MAX_CURVES, follow_all, put
from srs_ik.kernels.curves.gaps import put_bounds, put_gaps
from srs_ik.kernels.curves.in_step import SAMPLE, load_sample
from srs_ik.kernels.exact.samples import take_samples
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.search import SPLIT
from srs_ik.kernels.limb.branches import NO_BRANCH
from srs_ik.kernels.limb.goal import NO_SEED, turned
from srs_ik.kernels.limb.triangle import elbow_side

LARGEST_MOTION = 0.5
"""Between neighbouring samples of a branch no joint moves by more than this, rad ..."""

SMALLEST_GAP = 1e-6
"""... unless they are this close, rad."""

DEPTH = 32
"""Room for samples on hold while the gap before them is filled: more than the halvings between the figures above."""

SHALLOW = 0.5
"""A sample this far outside the limits, rad, may have feasible postures beside it."""


SPARE_ROWS = 1024
CURVE_ROWS = 8192
"""Room for samples: beside those of each interval of an exact limb, and for all curves of a near limb."""

MOST_GAPS = 8
"""One for each joint between two samples."""


CUTS = 4
"""Samples for each gap between samples, where a part of a run is sampled again."""


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
def survey_curves(P, place_, R, p, respect, curves, count, rows, line, out, runs, J, A):
    """Sample the feasible postures of followed curves of a near limb: rows and runs in use."""
    n = 0
    k = 0
    side = elbow_side(P, place_, 0)
    for i in range(count):
        length = unroll(P, R, p, rows, curves[i], respect, line, J, A)
        n, k = cut(P, side, R, p, 0, respect, line, 0, length, out, n, runs, k, J, A)
    return n, k


@kernel
def near_runs(P, place_, R, p, respect, runs, J, A):
    """Sample all feasible postures of a near limb: samples, rows and runs in use, and spare rows for one curve."""
    curves = np.empty((MAX_CURVES, CURVE))
    followed = np.empty((CURVE_ROWS, SAMPLE))
    rows = np.empty((CURVE_ROWS + SPARE_ROWS, SAMPLE))
    line = np.empty((CURVE_ROWS, SAMPLE))
    count = follow_all(P, place_, R, p, respect, followed, curves, J, A)
    n, k = survey_curves(P, place_, R, p, respect, curves, count, followed, line, rows, runs, J, A)
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
