"""Entry points of `optimise`: built-in objectives in one call, and the parts of the search for any other objective."""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.minimum import propose, start_search, tell
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.answer import measure_row
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.curves.follow import SAMPLE
from srs_ik.kernels.curves.runs import SPARE_ROWS, arm_angles_of_run, is_exact, near_runs, on_curve, survey_exact
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.exact.samples import MAX_SAMPLES
from srs_ik.kernels.jit import entry, kernel
from srs_ik.kernels.layout.answer import GOOD_POSE, MAX_PIECES, ROW_STATUS
from srs_ik.kernels.layout.limb import FREE, LIMITED
from srs_ik.kernels.layout.objectives import REFERENCE
from srs_ik.kernels.layout.search import (
    BRACKET,
    FOUND,
    MAX_BRACKETS,
    MOST_RUNS,
    NO_POSTURE,
    OUT_LOWER,
    OUT_SECOND,
    OUT_UPPER,
    OUT_VALUE,
    ROUNDS,
    RUN,
    SPLIT,
    STATE,
    SURFACE,
    TIE,
)
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import NO_SEED, cost
from srs_ik.kernels.limb.in_line import may_split
from srs_ik.kernels.limb.poses import read7, read_pose
from srs_ik.kernels.limb.triangle import elbow_side, place
from srs_ik.kernels.optimum.objectives import objective, toward_reference
from srs_ik.kernels.optimum.search import ROUNDING, close_in, find_brackets, survey_best, value_rows
from srs_ik.kernels.optimum.split_runs import MOST_ROWS, put_star, survey_splits

__all__ = ["SAMPLE", "SPARE_ROWS"]
"""What a search in Python has to know of the kernels behind these."""

ROWS_A_PIECE = 160
"""Room for the samples of each interval of an exact limb."""


@kernel
def survey(family, place_, R, p, respect, runs, J, A):
    """Samples of all feasible postures, the rows and runs in use, and spare rows for samples of one curve."""
    P = row(family, LIMITED)
    if is_exact(P):
        found = np.empty((8 * MAX_PIECES, 3))
        pieces = find_intervals(row(family, LIMITED if respect else FREE), place_, -1, found)
        splits = may_split(P, place_)
        rows = np.empty((ROWS_A_PIECE * pieces + SPARE_ROWS + (MOST_ROWS if splits else 0), SAMPLE))
        line = np.empty((SPARE_ROWS, SAMPLE))
        work = np.empty((2, MAX_SAMPLES))
        n, k = survey_exact(P, place_, R, p, found, pieces, respect, work, line, rows, runs, J, A)
        if splits:
            n, k = survey_splits(P, place_, R, p, respect, line, rows, n, runs, k, J, A)
        return rows, n, k, line
    return near_runs(P, place_, R, p, respect, runs, J, A)


@kernel
def write_posture(P, place_, R, p, q, branch, respect, solution):
    """Measure a feasible posture and write its row; whether it is a solution."""
    if not is_exact(P) or branch >= SPLIT:
        branch = branch_of(P, q)
    measure_row(P, place_, R, p, q, branch, cost(P, q, False, NO_SEED, respect), respect, solution)
    return solution[ROW_STATUS] == 0.0


@kernel
def best_of_surface(P, place_, R, p, q, respect, kind, params, resolution, S, line, rows, runs, brackets, J, A):
    """The best posture on the surface around a good one, by runs in all its directions.

    Overwrites rows and runs.
    """
    side = elbow_side(P, place_, 0)
    lowest = objective(P, kind, params, q, J)
    for _ in range(ROUNDS):
        n, k = put_star(P, side, R, p, q, respect, line, rows, runs, J, A)
        values = np.empty(n)
        value_rows(P, kind, -1, 0.0, params, rows, n, values, J)
        count = find_brackets(rows, values, runs, k, brackets)
        best, better = close_in(
            P, place_, R, p, rows, runs, brackets, count, 0.0, respect, kind, -1, 0.0, params, resolution, S, J, A
        )
        if best < 0 or brackets[best, 0] >= lowest - TIE * abs(lowest):
            break
        q, lowest = better, brackets[best, 0]
    return q


@entry
def optimise(family, T, kind, second, tolerance, resolution, params, respect, solution, out):
    """The best posture for a built-in objective, into a row and `out`.

    Returns FOUND, NO_POSTURE or minus the verdict on the pose.

    Args:
        family: packed limbs.
        T: (4, 4) pose.
        kind: objective, a number of `objectives`.
        second: the objective that decides among the postures which are best by the first one within the tolerance;
            -1: none.
        tolerance: relative to the best value of the first objective.
        resolution: of the line searches.
        params: (PARAMS,) figures that belong to the objective.
        respect: whether the limits have to be kept.
        solution: (ROW,) output.
        out: (OUT,) output.
    """
    R, p, verdict = read_pose(row(T, 0))
    if verdict != GOOD_POSE:
        return -verdict
    P = row(family, LIMITED)
    place_ = place(P, R, p)
    J = np.empty((6, 7))
    A = np.empty((16, 9))
    S = np.empty(STATE)
    runs = np.empty((MOST_RUNS, RUN))
    rows, n, k, line = survey(family, place_, R, p, respect, runs, J, A)
    values = np.empty(n)
    value_rows(P, kind, -1, 0.0, params, rows, n, values, J)
    brackets = np.empty((MAX_BRACKETS, BRACKET))
    count = find_brackets(rows, values, runs, k, brackets)
    spread = 0.0 if second < 0 else tolerance
    best, q = close_in(
        P, place_, R, p, rows, runs, brackets, count, spread, respect, kind, -1, 0.0, params, resolution, S, J, A
    )
    if best < 0:
        return NO_POSTURE
    run = int(brackets[best, 1])
    if second >= 0:
        lowest = brackets[best, 0]
        cap = lowest + (tolerance + ROUNDING) * abs(lowest)
        spans = np.empty((MAX_BRACKETS, RUN))
        origin = np.empty(MAX_BRACKETS, np.int64)
        near = np.empty((4 * n + SPARE_ROWS, SAMPLE))
        n, k = survey_best(
            P, place_, R, p, rows, runs, brackets, count, cap, respect, kind, params, line, near, spans, origin, J, A
        )
        values = np.empty(n)
        value_rows(P, second, kind, cap, params, near, n, values, J)
        count = find_brackets(near, values, spans, k, brackets)
        best, better_q = close_in(
            P, place_, R, p, near, spans, brackets, count, 0.0, respect, second, kind, cap, params, resolution, S, J, A
        )
        if best >= 0:
            q = better_q
            run = origin[int(brackets[best, 1])]
    branch = int(runs[run, 0])
    lower, upper = arm_angles_of_run(P, place_, rows, runs[run])
    if second < 0 and branch >= SURFACE:
        q = best_of_surface(P, place_, R, p, q, respect, kind, params, resolution, S, line, rows, runs, brackets, J, A)
        lower = arm_angle(P, q, place_[0], place_[1])
        upper = lower
    if kind == REFERENCE:
        q = toward_reference(P, params, q)
    out[OUT_VALUE] = objective(P, kind, params, q, J)
    out[OUT_SECOND] = objective(P, second, params, q, J) if second >= 0 else 0.0
    out[OUT_LOWER], out[OUT_UPPER] = lower, upper
    return FOUND if write_posture(P, place_, R, p, q, branch, respect, solution) else NO_POSTURE


@entry
def sample(family, T, respect, runs, rows):
    """Samples of all feasible postures of a pose: how many there are, the number of runs written, and the verdict.

    They are written to `rows` (n, SAMPLE) where that holds them all, else nothing is.
    """
    R, p, verdict = read_pose(row(T, 0))
    if verdict != GOOD_POSE:
        return 0, 0, verdict
    place_ = place(row(family, LIMITED), R, p)
    found, n, k, _ = survey(family, place_, R, p, respect, runs, np.empty((6, 7)), np.empty((16, 9)))
    if n <= rows.shape[0]:
        rows[:n] = found[:n]
    return n, k, GOOD_POSE


@entry
def star(family, T, q, respect, runs, rows):
    """Samples of the postures around one on a surface, in `rows` (SPARE_ROWS, SAMPLE): the number of rows and runs."""
    R, p, _ = read_pose(row(T, 0))
    P = row(family, LIMITED)
    side = elbow_side(P, place(P, R, p), 0)
    line = np.empty((SPARE_ROWS, SAMPLE))
    return put_star(P, side, R, p, read7(q), respect, line, rows, runs, np.empty((6, 7)), np.empty((16, 9)))


@entry
def brackets(rows, values, runs, k, out):
    """Brackets of the local minima among samples, lowest first, written to `out`; their number."""
    return find_brackets(rows, values, runs, k, out)


@entry
def next_point(S):
    """Where a line search wants its function next, and whether it does."""
    return propose(S)


@entry
def answer(S, f):
    """Tell a line search the value that it wanted; returns whether it is the best so far."""
    return tell(S, f)


@entry
def begin(S, bracket, resolution):
    """Begin a line search in a bracket."""
    start_search(S, bracket[2], bracket[3], bracket[4], bracket[5], bracket[0], bracket[6], resolution)


@entry
def posture(family, T, rows, run, x, respect, solution):
    """Posture of a run at a parameter into a row; whether it is a solution."""
    R, p, _ = read_pose(row(T, 0))
    P = row(family, LIMITED)
    place_ = place(P, R, p)
    branch = int(run[0])
    side = elbow_side(P, place_, branch >> 2)
    first = int(run[3])
    last = int(run[4])
    q, off = on_curve(P, side, R, p, branch, respect, rows, first, last, x, np.empty((6, 7)), np.empty((16, 9)))
    return off <= 0.0 and write_posture(P, place_, R, p, q, branch, respect, solution)


@entry
def interval(family, T, rows, run):
    """First and last arm angle of a run."""
    R, p, _ = read_pose(row(T, 0))
    P = row(family, LIMITED)
    return arm_angles_of_run(P, place(P, R, p), rows, run)
