"""The best posture for an objective, over everything that `survey` has sampled.

Every local minimum among the samples is bracketed; those that may still be the best are closed in on, the most
promising first. Where several postures are equally good, as in branches that mirror each other, the one farthest from
its limits wins.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from srs_ik.kernels.algebra.minimum import propose, start_search, tell
from srs_ik.kernels.chain.kinematics import tip_lines
from srs_ik.kernels.curves.ends import on_curve
from srs_ik.kernels.curves.follow import put
from srs_ik.kernels.curves.in_step import load_sample
from srs_ik.kernels.curves.runs import sample_again, samples_of
from srs_ik.kernels.exact.samples import STEP
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Setting
from srs_ik.kernels.layout.search import BEST, BRACKET, F_BEST, REFUSED, STATE, TIE
from srs_ik.kernels.limb.goal import NO_SEED, cost
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.optimum.objectives import figure, objective

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
def dips_beside(rows, values, first, last, i, way):
    """Whether values fall and rise again between sample i of a run and the next one before (way -1) or behind it (1).

    A parabola through the next two tells. Sample i need not show it: beside a singularity samples lie close, and there
    values may fall a little further for another reason.
    """
    j, k = i + way, i + 2 * way
    if k < first or k >= last or values[j] < values[i] or max(values[j], values[k]) >= REFUSED:
        return False
    width = abs(rows[j, 0] - rows[i, 0])
    slope = (values[j] - values[i]) / width
    next_slope = (values[k] - values[j]) / abs(rows[k, 0] - rows[j, 0])
    return (next_slope - slope) * width > slope * abs(rows[k, 0] - rows[i, 0])


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
                if dips_beside(rows, values, first, last, i, -1):
                    behind = i
                elif dips_beside(rows, values, first, last, i, 1):
                    before = i
                else:
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


class Objective(NamedTuple):
    """What is to be least: an objective, and another one that must not exceed a cap."""

    kind: Any
    params: Any
    cap_kind: Any  # FORCE or VELOCITY; -1: none
    cap: Any


@kernel
def alone(wanted):
    """An objective without its cap."""
    return Objective(wanted.kind, wanted.params, -1, 0.0)


@kernel
def capped(P, wanted, q, J):
    """Value of an objective at a posture, refused where another objective exceeds a cap."""
    if wanted.cap_kind < 0:
        return objective(P, wanted.kind, wanted.params, q, J)
    tip_lines(P, q, J)
    return REFUSED if figure(wanted.cap_kind, wanted.params, J) > wanted.cap else figure(wanted.kind, wanted.params, J)


@kernel
def value_rows(P, wanted, rows, n, values, J):
    """Value of every sample."""
    for i in range(n):
        values[i] = capped(P, wanted, load_sample(rows[i]), J)


@kernel
def value_at(P, by, rows, run, x, wanted):
    """Posture of a run at a parameter, and its value; refused where it is not feasible."""
    q, off = on_curve(P, by, int(run[0]), samples_of(rows, run), x)
    if off > 0.0:
        return q, REFUSED
    return q, capped(P, wanted, q, by.J)


@kernel
def on_side(P, by, branch):
    """A setting on the side of the elbow of a branch."""
    return Setting(by.target, elbow_side(P, by.target.place, (branch >> 2) & 1), by.respect, by.J, by.A)


@kernel
def least_in(P, by, rows, run, bracket, wanted, S):
    """Close in on the minimum in a bracket of a run, and write its value and parameter there."""
    while True:
        x, more = propose(S)
        if not more:
            break
        _, f = value_at(P, by, rows, run, x, wanted)
        tell(S, f)
    bracket[0] = S[F_BEST]
    bracket[3] = S[BEST]


@kernel
def close_in(P, by, sampled, brackets, spread, wanted, resolution):
    """Close in on every bracket that may hold a value within `spread` (relative) of the best.

    `sampled` holds samples and runs. Each of those brackets gets its own minimum as value (place 0) and middle
    (place 3), the others are refused. Returns the index of the best bracket, -1 if there is none, and its posture.
    """
    rows, runs = sampled
    S = np.empty(STATE)
    chosen = -1
    chosen_q = NO_SEED
    lowest = REFUSED
    room = 0.0
    for i in range(brackets.shape[0]):
        bracket = brackets[i]
        if bracket[0] >= REFUSED or bracket[7] > lowest + spread * abs(lowest):
            bracket[0] = REFUSED
            continue
        run = runs[int(bracket[1])]
        by = on_side(P, by, int(run[0]))
        start_search(S, bracket[2], bracket[3], bracket[4], bracket[5], bracket[0], bracket[6], resolution)
        least_in(P, by, rows, run, bracket, wanted, S)
        if bracket[0] > lowest + TIE * abs(lowest):
            continue
        q, _ = value_at(P, by, rows, run, bracket[3], alone(wanted))
        spare = -cost(P, q, False, NO_SEED, False)
        if chosen < 0 or bracket[0] < lowest - TIE * abs(lowest) or spare > room:
            chosen = i
            chosen_q = q
            room = spare
        lowest = min(lowest, bracket[0])
    return chosen, chosen_q


@kernel
def span_end(P, by, rows, run, known, end, wanted):
    """How far from a parameter with a known value towards the end of its run an objective stays below its cap."""
    x, value = known
    wanted_alone, cap = alone(wanted), wanted.cap
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
        _, f = value_at(P, by, rows, run, y, wanted_alone)
    for i in range(EDGE_STEPS):
        if abs(y - x) < EDGE * max(1.0, abs(x)):
            break
        m = 0.5 * (x + y)
        # A secant, but every third step halves the gap for certain; a refused posture has no value to draw one from.
        if i % 3 != 2 and f < REFUSED:
            m = x + (y - x) * min(max((cap - value) / (f - value), 0.001), 0.999)
        _, g = value_at(P, by, rows, run, m, wanted_alone)
        if g <= cap:
            x, value = m, g
        else:
            y, f = m, g
    return x


@kernel
def put_span(P, by, sampled, start, wanted, line, out, used):
    """Sample the postures around one of a run as far as an objective stays below its cap, unless that has been done.

    `sampled` holds samples and runs; `start` is the run, the parameter and the value. `out` takes the samples, the
    parts of runs, and the run that each is a part of; how many samples and parts are in use is given and returned.
    """
    rows, runs = sampled
    index, x, value = start
    samples, spans, origin = out
    n, k = used
    if k >= spans.shape[0]:
        return used
    for j in range(k):
        if origin[j] == index and spans[j, 1] <= x <= spans[j, 2]:
            return used
    run = runs[index]
    by = on_side(P, by, int(run[0]))
    a = span_end(P, by, rows, run, (x, value), run[1], wanted)
    b = span_end(P, by, rows, run, (x, value), run[2], wanted)
    count = sample_again(P, by, rows, run, (a, b), line)
    spans[k, 0] = run[0]
    spans[k, 1] = a
    spans[k, 2] = b
    spans[k, 3] = n
    for j in range(count):
        n = put(samples, n, line[j, 0], load_sample(line[j]))
    spans[k, 4] = n
    origin[k] = index
    return n, (k + 1 if n > spans[k, 3] else k)


@kernel
def survey_best(P, by, sampled, known, wanted, line, out):
    """Sample all postures for which an objective stays below its cap: the number of samples and of parts of runs.

    They lie around minima and around samples, for two stretches may be parted by a rise that no sample shows. `known`
    holds the brackets of the minima, the values of the samples and the number of runs; the rest is as for `put_span`.
    """
    rows, runs = sampled
    brackets, values, count = known
    used = (0, 0)
    for i in range(brackets.shape[0]):
        if brackets[i, 0] <= wanted.cap:
            start = (int(brackets[i, 1]), brackets[i, 3], brackets[i, 0])
            used = put_span(P, by, sampled, start, wanted, line, out, used)
    for index in range(count):
        for i in range(int(runs[index, 3]), int(runs[index, 4])):
            if values[i] <= wanted.cap:
                used = put_span(P, by, sampled, (index, rows[i, 0], values[i]), wanted, line, out, used)
    return used
