"""The best posture for an objective, over everything that `survey` has sampled.

Every local minimum among the samples is bracketed; those that may still be the best are closed in on, the most
promising first. Where several postures are equally good, as in branches that mirror each other, the one farthest from
its limits wins.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.minimum import propose, start_search, tell
from srs_ik.kernels.curves.ends import on_curve
from srs_ik.kernels.curves.follow import put
from srs_ik.kernels.curves.in_step import load_sample
from srs_ik.kernels.curves.runs import sample_again
from srs_ik.kernels.exact.samples import STEP
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.search import BEST, BRACKET, F_BEST, REFUSED, TIE
from srs_ik.kernels.limb.goal import NO_SEED, cost
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.optimum.objectives import figure, objective, tip_jacobian

EDGE = 1e-13
EDGE_STEPS = 100
"""The end of a stretch of equal values is found to this, rad, in at most so many steps."""

ROUNDING = 1e-13
"""Relative width given to the set of postures that are best by a first objective, beside its tolerance."""


@kernel
def curvature(rows, values, first, last, i):
    """Magnitude of the second derivative of the values at sample i of a run, rows first to last - 1; 0 at its ends."""
    if i <= first or i >= last - 1:
        return 0.0
    a = rows[i, 0] - rows[i - 1, 0]
    b = rows[i + 1, 0] - rows[i, 0]
    return abs(2.0 * ((values[i + 1] - values[i]) / b - (values[i] - values[i - 1]) / a) / (a + b))


@kernel
def promise(rows, values, first, last, i):
    """A value below any around sample i, the lowest one between its neighbours.

    A parabola of the greatest curvature nearby, across the wider gap, would lie eight times less deep.
    """
    if last - first < 3 or max(values[max(i - 1, first)], values[min(i + 1, last - 1)]) >= REFUSED:
        return -REFUSED
    greatest = curvature(rows, values, first, last, i)
    for j in (i - 1, i + 1):
        greatest = max(greatest, curvature(rows, values, first, last, j))
    before = rows[i, 0] - rows[max(i - 1, first), 0]
    behind = rows[min(i + 1, last - 1), 0] - rows[i, 0]
    gap = max(before, behind)
    return values[i] - greatest * gap * gap


@kernel
def find_brackets(rows, values, runs, k, out):
    """Write a bracket for every local minimum of the samples' values, lowest first, into rows of out; their number.

    Where there are more than out holds, the lowest are kept.
    """
    count = 0
    for run in range(k):
        first = int(runs[run, 3])
        last = int(runs[run, 4])
        for i in range(first, last):
            value = values[i]
            before = max(i - 1, first)
            behind = min(i + 1, last - 1)
            if value > values[before] or value > values[behind]:
                continue
            if count == out.shape[0] and value >= out[count - 1, 0]:
                continue
            place = min(count, out.shape[0] - 1)
            while place > 0 and out[place - 1, 0] > value:
                for j in range(BRACKET):
                    out[place, j] = out[place - 1, j]
                place -= 1
            out[place, 0] = value
            out[place, 1] = run
            out[place, 2] = rows[before, 0]
            out[place, 3] = rows[i, 0]
            out[place, 4] = rows[behind, 0]
            out[place, 5] = values[before]
            out[place, 6] = values[behind]
            out[place, 7] = promise(rows, values, first, last, i)
            count = min(count + 1, out.shape[0])
    return count


@kernel
def capped(P, kind, cap_kind, cap, params, q, J):
    """Value of an objective at a posture, refused where another objective exceeds a cap (-1: no other).

    The other one is FORCE or VELOCITY, which leave J as it is.
    """
    if cap_kind < 0:
        return objective(P, kind, params, q, J)
    tip_jacobian(P, q, J)
    return REFUSED if figure(cap_kind, params, J) > cap else figure(kind, params, J)


@kernel
def value_rows(P, kind, cap_kind, cap, params, rows, n, values, J):
    """Value of every sample."""
    for i in range(n):
        values[i] = capped(P, kind, cap_kind, cap, params, load_sample(rows[i]), J)


@kernel
def value_at(P, side, R, p, rows, run, x, respect, kind, cap_kind, cap, params, J, A):
    """Posture of a run at a parameter, and its value; refused where it is not feasible."""
    q, off = on_curve(P, side, R, p, int(run[0]), respect, rows, int(run[3]), int(run[4]), x, J, A)
    if off > 0.0:
        return q, REFUSED
    return q, capped(P, kind, cap_kind, cap, params, q, J)


@kernel
def close_in(
    P, place_, R, p, rows, runs, brackets, count, spread, respect, kind, cap_kind, cap, params, resolution, S, J, A
):
    """Close in on every bracket that may hold a value within `spread` (relative) of the best.

    Each of those gets its own minimum as value (place 0) and middle (place 3), the others are refused. Returns the
    index of the best bracket, -1 if there is none, and its posture.
    """
    chosen = -1
    chosen_q = NO_SEED
    lowest = REFUSED
    room = 0.0
    elbow = -1
    side = elbow_side(P, place_, 0)
    for i in range(count):
        bracket = brackets[i]
        if bracket[0] >= REFUSED or bracket[7] > lowest + spread * abs(lowest):
            bracket[0] = REFUSED
            continue
        run = runs[int(bracket[1])]
        if int(run[0]) >> 2 != elbow:
            elbow = int(run[0]) >> 2
            side = elbow_side(P, place_, elbow)
        start_search(S, bracket[2], bracket[3], bracket[4], bracket[5], bracket[0], bracket[6], resolution)
        while True:
            x, wanted = propose(S)
            if not wanted:
                break
            _, f = value_at(P, side, R, p, rows, run, x, respect, kind, cap_kind, cap, params, J, A)
            tell(S, f)
        bracket[0] = S[F_BEST]
        bracket[3] = S[BEST]
        if bracket[0] > lowest + TIE * abs(lowest):
            continue
        q, _ = value_at(P, side, R, p, rows, run, bracket[3], respect, kind, -1, 0.0, params, J, A)
        spare = -cost(P, q, False, NO_SEED, False)
        if chosen < 0 or bracket[0] < lowest - TIE * abs(lowest) or spare > room:
            chosen = i
            chosen_q = q
            room = spare
        lowest = min(lowest, bracket[0])
    return chosen, chosen_q


@kernel
def span_end(P, side, R, p, rows, run, x, value, end, respect, kind, cap, params, J, A):
    """How far from a parameter with a known value towards the end of its run an objective stays below a cap."""
    direction = math.copysign(0.5 * STEP, end - x)
    y = x
    f = value
    while f <= cap:
        x, value = y, f
        if x == end:
            return end
        y = x + direction
        if (y - end) * direction >= 0.0:
            y = end
        _, f = value_at(P, side, R, p, rows, run, y, respect, kind, -1, 0.0, params, J, A)
    for i in range(EDGE_STEPS):
        if abs(y - x) < EDGE * max(1.0, abs(x)):
            break
        m = 0.5 * (x + y)
        # A secant, but every third step halves the gap for certain; a refused posture has no value to draw one from.
        if i % 3 != 2 and f < REFUSED:
            m = x + (y - x) * min(max((cap - value) / (f - value), 0.001), 0.999)
        _, g = value_at(P, side, R, p, rows, run, m, respect, kind, -1, 0.0, params, J, A)
        if g <= cap:
            x, value = m, g
        else:
            y, f = m, g
    return x


@kernel
def survey_best(
    P, place_, R, p, rows, runs, brackets, count, cap, respect, kind, params, line, out, spans, origin, J, A
):
    """Sample the postures around the minima in brackets for which an objective stays below a cap: the number of spans.

    out receives the samples, spans the parts of runs, origin the run that each one is a part of.
    """
    n = 0
    k = 0
    for i in range(count):
        if brackets[i, 0] > cap or k >= spans.shape[0]:
            continue
        index = int(brackets[i, 1])
        run = runs[index]
        x = brackets[i, 3]
        known = False
        for j in range(k):
            if origin[j] == index and spans[j, 1] <= x <= spans[j, 2]:
                known = True
        if known:
            continue
        side = elbow_side(P, place_, int(run[0]) >> 2)
        value = brackets[i, 0]
        a = span_end(P, side, R, p, rows, run, x, value, run[1], respect, kind, cap, params, J, A)
        b = span_end(P, side, R, p, rows, run, x, value, run[2], respect, kind, cap, params, J, A)
        count_line = sample_again(P, side, R, p, respect, rows, run, a, b, line, J, A)
        spans[k, 0] = run[0]
        spans[k, 1] = a
        spans[k, 2] = b
        spans[k, 3] = n
        for j in range(count_line):
            n = put(out, n, line[j, 0], load_sample(line[j]))
        spans[k, 4] = n
        if n > spans[k, 3]:
            origin[k] = index
            k += 1
    return n, k
