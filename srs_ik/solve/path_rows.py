"""The answers of a path: rows of its postures, each taken to its pose once more."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.layout.answer import ROW, ROW_ORIENTATION_ERROR, ROW_POSITION_ERROR, ROW_STATUS
from srs_ik.solve.path_problem import Problem, Way, as_closed
from srs_ik.solve.solution import Status

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

Array = NDArray[np.float64]

ON_POSE = 1e-10
"""A posture that is farther off its pose than this, m and rad, is taken to it once more."""


def rows_of(problem: Problem, way: Way) -> Array:
    """Rows of the postures of a path; where there is none, that of the search for one pose near the one before."""
    arm, T = problem.arm, problem.T
    rows = np.full((len(T), ROW), np.nan)
    chain = np.flatnonzero(way.reached)
    entries.finish(arm.family, T, chain, way.q, way.psi, way.branch, rows)
    errors = rows[chain, ROW_POSITION_ERROR : ROW_ORIENTATION_ERROR + 1].max(axis=1, initial=0.0)
    off = chain[(rows[chain, ROW_STATUS] != Status.OK) | (errors > ON_POSE)]
    if len(off):
        # Rounding left them beside their poses, or limits with room for it did.
        q, met = way.q[off], np.zeros(len(off), np.bool_)
        entries.bridge(arm.family, T[off], q, met)
        way.q[off[met]], way.branch[off[met]] = q[met], -1
        entries.finish(arm.family, T, off[met], way.q, way.psi, way.branch, rows)
    for i in np.flatnonzero(~way.reached | (rows[:, ROW_STATUS] != Status.OK)).tolist():
        rows[i] = problem.solve(i, rows[i - 1, :7] if i else problem.seed)._row
    return rows


def off_pose(arm: PackedArm, pose: Array, q: Array) -> float:
    """How far a posture is off a pose, the larger of m and rad."""
    rows = np.empty((1, ROW))
    one = np.zeros(1, np.int64)
    entries.finish(as_closed(arm.family), pose[None], one, q[None], np.zeros(1), one - 1, rows)
    return float(rows[0, ROW_POSITION_ERROR : ROW_ORIENTATION_ERROR + 1].max())
