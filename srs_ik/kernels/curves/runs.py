"""Every feasible posture of a pose, sampled: runs of postures close enough to miss nothing between them.

A run is a piece of a curve of postures. On an exact limb the curve is a branch and its parameter the arm angle; the
pieces are the feasible intervals. On a near limb it is a curve that `follow` has followed on the true chain, its
parameter the length along it; the ends of the pieces are closed in on.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import difference, largest
from srs_ik.kernels.chain.newton import arm_angle, clipped
from srs_ik.kernels.curves.all_curves import MAX_CURVES, follow_all
from srs_ik.kernels.curves.ends import corner, dip, edge, is_exact, on_curve, put_infeasibilities
from srs_ik.kernels.curves.follow import BLURRED, CURVE, put, put_with
from srs_ik.kernels.curves.gaps import MOST_TURNS, put_bounds, put_gaps
from srs_ik.kernels.curves.in_step import ARC, SAMPLE, load_sample, way_of_sample
from srs_ik.kernels.curves.lowest import dip_near
from srs_ik.kernels.curves.outreach import EVERY_PAIR
from srs_ik.kernels.exact.samples import take_samples
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Runs, Samples, Setting
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

SAME = 1e-9
"""Of samples closer than this, one is left: nothing can be told of what is beside it from the other."""


SPARE_ROWS = 1024
CURVE_ROWS = 8192
"""Room for samples: beside those of each interval of an exact limb, and for all curves of a near limb."""

MOST_GAPS = 15
"""One gap and one range for each joint between two samples."""


CUTS = 4
"""Samples for each gap between samples, where a part of a run is sampled again."""


@kernel
def way_of_end(line, i, x):
    """The way of a curve at the end of a run, a parameter, if that is its sample i."""
    return way_of_sample(line[i]) if line[i, 0] == x else NO_SEED


@kernel
def put_run(P, respect, branch, curve, ends, out, used):
    """Write the run between two ends of a sampled curve, parameters and postures: rows and runs in use."""
    line, first, last = curve
    (lower, q_lower), (upper, q_upper) = ends
    n, k = used
    runs = out.runs
    if k >= runs.shape[0]:
        return n, k
    runs[k, 0] = branch
    runs[k, 1] = lower
    runs[k, 2] = upper
    runs[k, 3] = n
    # The ends are on a limit up to rounding: on it, so that they count as inside.
    q = turned(P, q_lower, False, NO_SEED, respect)
    n = put_with(out.rows, n, lower, clipped(P, q) if respect else q, way_of_end(line, first, lower))
    x = lower
    for i in range(first, last):
        if x + SAME < line[i, 0] < upper - SAME:
            x = line[i, 0]
            q = turned(P, load_sample(line[i]), False, NO_SEED, respect)
            n = put_with(out.rows, n, x, q, way_of_sample(line[i]))
    if upper > lower:
        q = turned(P, q_upper, False, NO_SEED, respect)
        n = put_with(out.rows, n, upper, clipped(P, q) if respect else q, way_of_end(line, last - 1, upper))
    runs[k, 4] = n
    return n, (k + 1 if n > runs[k, 3] else k)


@kernel
def may_meet(f, next_f, way):
    """Whether a limit may be met on a way between two samples that are so far outside their limits, or inside."""
    return abs(f + next_f) < way


@kernel
def may_dip(P, x, f, next_x, next_f):
    """Whether there may be feasible postures between two samples outside the limits; f is how far, x the parameter."""
    return is_exact(P) or may_meet(f, next_f, ARC * (next_x - x))


@kernel
def cut(P, by, branch, curve, out, used):
    """Cut a sampled curve into its feasible runs, behind the rows and runs in use; how many are in use then."""
    line, first, last = curve
    off = np.empty((line.shape[0], 1))
    put_infeasibilities(P, curve, by.respect, off)
    begin = end = (line[first, 0], load_sample(line[first]))
    f_before = -1.0  # infeasibility of the sample before the last one, as long as neither is feasible
    x0 = begin[0]
    f0 = off[first, 0]
    for i in range(first + 1, last):
        x1 = line[i, 0]
        f1 = off[i, 0]
        ends = False
        if f0 > 0.0 and f1 <= 0.0:
            begin = edge(P, by, branch, curve, (x1, f1), (x0, f0))
        elif f0 <= 0.0 and f1 > 0.0:
            end, ends = edge(P, by, branch, curve, (x0, f0), (x1, f1)), True
        elif 0.0 < f0 < f_before and f0 <= f1 and f0 < SHALLOW:
            x_before, f = line[i - 2, 0], 1.0
            if may_dip(P, x_before, f_before, x0, f0) or may_dip(P, x0, f0, x1, f1):
                if is_exact(P):
                    x, f = dip(P, by, branch, curve, x_before, x1)
                else:
                    x, f = dip_near(P, by, curve, (x_before, x0, x1))
            if f <= 0.0:
                # The sample between the two is outside: the run ends before it, or begins behind it.
                outside = ((x_before, f_before), (x0, f0)) if x < x0 else ((x0, f0), (x1, f1))
                begin = edge(P, by, branch, curve, (x, f), outside[0])
                end, ends = edge(P, by, branch, curve, (x, f), outside[1]), True
            elif f0 < BLURRED and not is_exact(P):
                q, ends = corner(P, by, load_sample(line[i - 1]), f0)
                begin = end = (x0, q)
        if i == last - 1 and f1 <= 0.0:
            end, ends = (x1, load_sample(line[i])), True
        if ends and end[0] >= begin[0]:
            used = put_run(P, by.respect, branch, curve, (begin, end), out, used)
        f_before = f0 if f0 > 0.0 else -1.0
        x0, f0 = x1, f1
    return used


@kernel
def far_apart(a, b):
    """Whether a joint moves too far between two samples."""
    return largest(difference(a, b)) > LARGEST_MOTION


@kernel
def sample_branch(P, by, branch, ends, work, line):
    """Sample an interval of a branch of an exact limb into line, closer where joints move fast; the number of rows."""
    wanted = work[0]
    held = work[1]
    curve = Samples(line, 0, 0)
    count = take_samples(P, by.side, ends[0], ends[1], wanted)
    q, _ = on_curve(P, by, branch, curve, ends[0])
    n = put(line, 0, ends[0], q)
    for i in range(1, count):
        held[0] = wanted[i]
        on_hold = 1
        while on_hold > 0:
            x = held[on_hold - 1]
            next_q, f = on_curve(P, by, branch, curve, x)
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
def unroll(P, by, rows, curve, line):
    """Copy a followed curve to line, a closed one from its posture farthest outside the limits on; rows in use.

    The gaps between limits get samples of their own. Nothing that dips into the limits is cut there.
    """
    first = int(curve[0])
    count = int(curve[1]) - first
    start = 0
    off = np.empty((rows.shape[0], 1))
    put_infeasibilities(P, Samples(rows, first, first + count), True, off)
    if curve[2] == 1.0:
        worst = 0.0
        for i in range(count - 1):
            if off[first + i, 0] > worst:
                start, worst = i, off[first + i, 0]
    length = rows[first + count - 1, 0]
    gaps, turns = np.empty((MOST_GAPS, SAMPLE)), np.empty((MOST_TURNS, SAMPLE))
    n = 0
    before = 0.0, NO_SEED, NO_SEED
    f = 0.0
    for i in range(count):
        j = start + i
        round_ = 0.0
        if j >= count:
            j -= count - 1
            round_ = length
        here = rows[first + j, 0] + round_, load_sample(rows[first + j]), way_of_sample(rows[first + j])
        next_f = off[first + j, 0]
        if i > 0 and may_meet(f, next_f, ARC * (here[0] - before[0])):
            for k in range(put_gaps(P, by, before, here, gaps, 0)):
                gap = gaps[k, 0], load_sample(gaps[k]), NO_SEED
                n = put_bounds(P, by, before, gap, turns, line, n)
                n = put(line, n, gap[0], gap[1])
                before = gap
            n = put_bounds(P, by, before, here, turns, line, n)
        n = put_with(line, n, here[0], here[1], here[2])
        before, f = here, next_f
    return n


@kernel
def survey_exact(P, by, found, work, line, out):
    """Sample feasible intervals, rows of found (branch, lower, upper) of an exact limb: rows and runs in use."""
    used = (0, 0)
    for i in range(found.shape[0]):
        branch = int(found[i, 0])
        by = Setting(by.target, elbow_side(P, by.target.place, branch >> 2), by.respect, by.J, by.A)
        n = sample_branch(P, by, branch, (found[i, 1], found[i, 2]), work, line)
        before = used
        used = cut(P, by, branch, Samples(line, 0, n), out, used)
        if used[1] == before[1]:
            # So narrow that it has no inside: one posture, as of a joint that cannot move.
            alone = (line[n // 2, 0], load_sample(line[n // 2]))
            used = put_run(P, by.respect, branch, Samples(line, n // 2, n // 2), (alone, alone), out, used)
    return used


@kernel
def survey_curves(P, by, rows, curves, line, out):
    """Sample the feasible postures of followed curves of a near limb: rows and runs in use."""
    used = (0, 0)
    for i in range(curves.shape[0]):
        if by.respect:
            length = unroll(P, by, rows, curves[i], line)
            used = cut(P, by, 0, Samples(line, 0, length), out, used)
        else:
            curve = Samples(rows, int(curves[i, 0]), int(curves[i, 1]))
            begin, end = rows[curve.first], rows[curve.last - 1]
            ends = (begin[0], load_sample(begin)), (end[0], load_sample(end))
            used = put_run(P, False, 0, curve, ends, out, used)
    return used


@kernel
def certain_runs(P, by, which, runs):
    """`near_runs` of some pairs of signs (`follow_all`), and of which of them these are all there are for certain."""
    curves = np.empty((MAX_CURVES, CURVE))
    followed = np.empty((CURVE_ROWS, SAMPLE))
    rows = np.empty((CURVE_ROWS + SPARE_ROWS, SAMPLE))
    line = np.empty((CURVE_ROWS, SAMPLE))
    count, certain = follow_all(P, by, which, followed, curves)
    n, k = survey_curves(P, by, followed, curves[:count], line, Runs(rows, runs))
    return (rows, n, k, line), certain


@kernel
def near_runs(P, by, runs):
    """Sample all feasible postures of a near limb: samples, rows and runs in use, and spare rows for one curve."""
    sampled, _ = certain_runs(P, by, EVERY_PAIR, runs)
    return sampled


@kernel
def samples_of(rows, run):
    """The samples of a run."""
    return Samples(rows, int(run[3]), int(run[4]))


@kernel
def sample_again(P, by, rows, run, ends, line):
    """Sample a part of a run, a few times as close: rows of line in use."""
    branch = int(run[0])
    curve = samples_of(rows, run)
    first, last = curve.first, curve.last
    lower, upper = ends
    q, _ = on_curve(P, by, branch, curve, lower)
    n = put(line, 0, lower, q)
    a = lower
    for i in range(first, last):
        b = min(rows[i, 0], upper) if i < last - 1 else upper
        if b <= a:
            continue
        for c in range(1, CUTS + 1):
            x = b if c == CUTS else a + (b - a) * c / CUTS
            q, _ = on_curve(P, by, branch, curve, x)
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
