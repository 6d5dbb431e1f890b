"""Turns of joints without end: from pose to pose of a path, and in which turns the path is."""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.layout.answer import ROW_STATUS
from srs_ik.kernels.layout.path import BY_CONTINUITY
from srs_ik.solve.path.problem import Problem, steps_of
from srs_ik.solve.solution import Status
from srs_ik.system.arrays import Array


def unwound(problem: Problem, rows: Array) -> Array:
    """(n, 7) the postures of a path's rows, joints that turn without end counted on from pose to pose.

    A posture that is given is in the turns that it is given in, and so are those that are continuous with it; else the
    path begins in the turns of the seed. A break goes the shorter way round where that leaves a choice.
    """
    q, met = rows[:, :7].copy(), np.flatnonzero(rows[:, ROW_STATUS] == Status.OK)
    endless = np.flatnonzero(np.isinf(problem.arm.lower) & np.isinf(problem.arm.upper))
    if not (len(met) and len(endless)):
        return q
    way, period = q[met][:, endless], 2.0 * np.pi
    turns = np.zeros(way.shape)
    turns[1:] = -np.cumsum(np.round(np.diff(way, axis=0) / period), axis=0)
    piece = np.cumsum(
        np.append(False, (np.abs(steps_of(problem, q[met])) > problem.settings[BY_CONTINUITY]).any(axis=1))
    )
    begin: dict[int, Array] = {}
    for k in np.flatnonzero(problem.has_known[met]).tolist():
        given = problem.known[met[k], endless]
        begin.setdefault(int(piece[k]), np.round((given - way[k]) / period) - turns[k])
    if problem.seed is not None:
        begin.setdefault(0, np.round((problem.seed[endless] - way[0]) / period))
    if begin:
        # A piece without a given posture follows the one before, and what is before the first such posture precedes it.
        pieces = np.array(sorted(begin))
        of = pieces[np.maximum(np.searchsorted(pieces, piece, side="right") - 1, 0)]
        turns += np.array([begin[k] for k in of.tolist()])
    q[met[:, None], endless] = way + period * turns
    # Postures of poses that are not met lie beside the one before, and those that begin a path beside the one behind.
    unmet = np.setdiff1d(np.arange(len(q)), met)
    for k in (*unmet[unmet > met[0]].tolist(), *unmet[unmet < met[0]][::-1].tolist()):
        beside = q[k - 1 if k > met[0] else k + 1, endless]
        q[k, endless] += period * np.round((beside - q[k, endless]) / period)
    return q
