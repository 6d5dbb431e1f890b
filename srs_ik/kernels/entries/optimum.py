"""Entry points of `optimise`: built-in objectives in one call, and the parts of the search for any other objective."""

import numpy as np

from srs_ik.kernels.algebra.minimum import propose, start_search, tell
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.chain.answer import measure_row
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.curves.ends import is_exact, on_curve
from srs_ik.kernels.curves.in_step import SAMPLE, SAMPLE_WAY
from srs_ik.kernels.curves.runs import SPARE_ROWS, arm_angles_of_run, near_runs, samples_of, survey_exact
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.exact.samples import MAX_SAMPLES
from srs_ik.kernels.jit import entry, kernel
from srs_ik.kernels.layout import search as at
from srs_ik.kernels.layout.answer import GOOD_POSE, MAX_PIECES, ROW_STATUS
from srs_ik.kernels.layout.asked import Runs, Setting
from srs_ik.kernels.layout.limb import FREE, LIMITED
from srs_ik.kernels.layout.objectives import REFERENCE
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import NO_SEED, cost
from srs_ik.kernels.limb.in_line import may_split
from srs_ik.kernels.limb.triangle import elbow_side, read_target, target_of
from srs_ik.kernels.optimum.objectives import objective, toward_reference
from srs_ik.kernels.optimum.search import ROUNDING, Objective, capped, close_in, find_brackets, survey_best, value_rows
from srs_ik.kernels.optimum.split_runs import MOST_ROWS, is_on_surface, put_star, survey_splits

__all__ = ["SAMPLE", "SAMPLE_WAY", "SPARE_ROWS"]
"""What a search in Python has to know of the kernels behind these."""

ROWS_A_PIECE = 160
"""Room for the samples of each interval of an exact limb."""


@kernel
def setting_of(P, target, branch, respect):
    """The setting of a pose on the side of the elbow of a branch."""
    side = elbow_side(P, target.place, (branch >> 2) & 1)
    return Setting(target, side, respect, np.empty((6, 7)), np.empty((16, 9)))


@kernel
def survey(family, by, runs):
    """Samples of all feasible postures, the rows and runs in use, and spare rows for samples of one curve."""
    P = row(family, LIMITED)
    if is_exact(P):
        found = np.empty((8 * MAX_PIECES, 3))
        place_ = by.target.place
        pieces = find_intervals(row(family, LIMITED if by.respect else FREE), place_, -1, found)
        splits = may_split(P, place_)
        rows = np.empty((ROWS_A_PIECE * pieces + SPARE_ROWS + (MOST_ROWS if splits else 0), SAMPLE))
        line = np.empty((SPARE_ROWS, SAMPLE))
        work = np.empty((2, MAX_SAMPLES))
        used = survey_exact(P, by, found[:pieces], work, line, Runs(rows, runs))
        if splits:
            used = survey_splits(P, by, line, Runs(rows, runs), used)
        return rows, used[0], used[1], line
    return near_runs(P, by, runs)


@kernel
def write_posture(P, target, q, branch, respect, solution):
    """Measure a feasible posture and write its row; whether it is a solution."""
    if not is_exact(P) or branch >= at.SPLIT:
        branch = branch_of(P, q)
    measure_row(P, target, q, branch, cost(P, q, False, NO_SEED, respect), respect, solution)
    return solution[ROW_STATUS] == 0.0


@kernel
def best_of_surface(P, by, q, wanted, resolution, line):
    """The best posture on the surface around a good one, by runs in all its directions; itself where it is on none."""
    out = Runs(np.empty((SPARE_ROWS, SAMPLE)), np.empty((at.MAX_RUNS, at.RUN)))
    brackets = np.empty((at.MAX_BRACKETS, at.BRACKET))
    lowest = capped(P, wanted, q, by.J)
    for _ in range(at.ROUNDS if is_on_surface(P, q) else 0):
        n, k = put_star(P, by, q, line, out)
        values = np.empty(n)
        value_rows(P, wanted, out.rows, n, values, by.J)
        count = find_brackets(out.rows, values, out.runs, k, brackets)
        best, better = close_in(P, by, out, brackets[:count], 0.0, wanted, resolution)
        # Of values that are all but zero, rounding makes others all the way.
        greatest = 0.0
        for i in range(n):
            greatest = max(greatest, abs(values[i]) if values[i] < at.REFUSED else 0.0)
        if best < 0 or brackets[best, 0] >= lowest - at.TIE * greatest:
            break
        q, lowest = better, brackets[best, 0]
    return q


@entry
def optimise(family, T, kind, second, tolerance, resolution, params, respect, solution, out):
    """The best posture for a built-in objective, into a row and `out`: FOUND, NO_POSTURE or minus a verdict.

    Objectives are numbers of `layout.objectives`, with figures `params` (PARAMS,). The second one (-1: none) decides
    among the postures which are best by the first one within the tolerance, relative to its best value; `resolution` is
    that of the line searches.
    """
    P = row(family, LIMITED)
    target, verdict = read_target(P, row(T, 0))
    if verdict != GOOD_POSE:
        return -verdict
    by = setting_of(P, target, 0, respect)
    runs = np.empty((at.MOST_RUNS, at.RUN))
    rows, n, k, line = survey(family, by, runs)
    values = np.empty(n)
    wanted = Objective(kind, params, -1, 0.0)
    value_rows(P, wanted, rows, n, values, by.J)
    brackets = np.empty((at.MAX_BRACKETS, at.BRACKET))
    count = find_brackets(rows, values, runs, k, brackets)
    spread = 0.0 if second < 0 else tolerance
    best, q = close_in(P, by, Runs(rows, runs), brackets[:count], spread, wanted, resolution)
    if best < 0:
        return at.NO_POSTURE
    run = int(brackets[best, 1])
    q = best_of_surface(P, by, q, wanted, resolution, line)
    if second >= 0:
        lowest = capped(P, wanted, q, by.J)
        cap = lowest + (tolerance + ROUNDING) * abs(lowest)
        spans = np.empty((k + at.MAX_BRACKETS, at.RUN))
        origin = np.empty(k + at.MAX_BRACKETS, np.int64)
        near = np.empty((4 * n + 4 * k + SPARE_ROWS, SAMPLE))
        under = Objective(kind, params, -1, cap)
        known = (brackets[:count], values, k)
        n, k = survey_best(P, by, Runs(rows, runs), known, under, line, (near, spans, origin))
        values = np.empty(n)
        other = Objective(second, params, kind, cap)
        value_rows(P, other, near, n, values, by.J)
        count = find_brackets(near, values, spans, k, brackets)
        best, better_q = close_in(P, by, Runs(near, spans), brackets[:count], 0.0, other, resolution)
        if best >= 0:
            q = better_q
            run = origin[int(brackets[best, 1])]
        q = best_of_surface(P, by, q, other, resolution, line)
    branch = int(runs[run, 0])
    lower, upper = arm_angles_of_run(P, target.place, rows, runs[run])
    if is_on_surface(P, q):
        lower = arm_angle(P, q, target.place[0], target.place[1])
        upper = lower
    if kind == REFERENCE:
        q = toward_reference(P, params, q)
    out[at.OUT_VALUE] = objective(P, kind, params, q, by.J)
    out[at.OUT_SECOND] = objective(P, second, params, q, by.J) if second >= 0 else 0.0
    out[at.OUT_LOWER], out[at.OUT_UPPER] = lower, upper
    return at.FOUND if write_posture(P, target, q, branch, respect, solution) else at.NO_POSTURE


@entry
def sample(family, T, respect, runs, rows):
    """Samples of all feasible postures of a pose: how many there are, the number of runs written, and the verdict.

    They are written to `rows` (n, SAMPLE) where that holds them all, else nothing is.
    """
    P = row(family, LIMITED)
    target, verdict = read_target(P, row(T, 0))
    if verdict != GOOD_POSE:
        return 0, 0, verdict
    found, n, k, _ = survey(family, setting_of(P, target, 0, respect), runs)
    if n <= rows.shape[0]:
        rows[:n] = found[:n]
    return n, k, GOOD_POSE


@entry
def star(family, T, q, respect, runs, rows):
    """Samples of the postures around one on a surface, in `rows` (SPARE_ROWS, SAMPLE): the number of rows and runs.

    None where it is on no surface.
    """
    P = row(family, LIMITED)
    if not is_on_surface(P, read7(q)):
        return 0, 0
    by = setting_of(P, target_of(P, row(T, 0)), 0, respect)
    line = np.empty((SPARE_ROWS, SAMPLE))
    return put_star(P, by, read7(q), line, Runs(rows, runs))


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
    P = row(family, LIMITED)
    target = target_of(P, row(T, 0))
    branch = int(run[0])
    by = setting_of(P, target, branch, respect)
    q, off = on_curve(P, by, branch, samples_of(rows, run), x)
    return off <= 0.0 and write_posture(P, target, q, branch, respect, solution)


@entry
def interval(family, T, rows, run):
    """First and last arm angle of a run."""
    P = row(family, LIMITED)
    return arm_angles_of_run(P, target_of(P, row(T, 0)).place, rows, run)
