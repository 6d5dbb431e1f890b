"""Joints with more than one turn between their limits: planned without end where the path keeps the limits anyhow.

Each turn of each such joint has strips of its own, which multiply: seven joints with two turns have 128 times as many.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries.pose import pack_limits
from srs_ik.kernels.layout.answer import ROW_STATUS
from srs_ik.kernels.layout.limb import LIMITED, LOOSE
from srs_ik.kernels.layout.path import ENDLESS, INVERSE_PERIOD, PERIOD
from srs_ik.solve.path.problem import Problem, Way, breaks_in
from srs_ik.solve.path.rows import rows_of
from srs_ik.solve.path.turns import unwound
from srs_ik.solve.solution import Status
from srs_ik.system.arrays import Array

Joints = NDArray[np.bool_]

TURN = 2.0 * np.pi


def in_fewest_turns(
    problem: Problem, find: Callable[[Problem], tuple[Way, Array]], closed: bool
) -> tuple[Way, Array, Problem]:
    """A path, the rows of its postures, and the problem that it solves: with as many joints without end as may be.

    Without the limits of a joint no path is worse: one that keeps them is the best with them, too. Else they count.
    """
    arm = problem.arm
    loose = np.isfinite(arm.lower) & np.isfinite(arm.upper) & (arm.upper - arm.lower > TURN)
    while loose.any():
        asked = without_ends(problem, loose)
        way, rows = find(asked)
        if not (way.reached.all() and (rows[:, ROW_STATUS] == Status.OK).all()) or breaks_in(asked, way).any():
            break
        q = unwound(asked, rows)
        if problem.seed is None and not problem.has_known.any():
            own = q[:, loose]
            middle = 0.5 * (arm.lower[loose] + arm.upper[loose] - own.min(axis=0) - own.max(axis=0))
            q[:, loose] += TURN * np.round(middle / TURN)
        leaves = loose & ~keeps_turns(problem, q, closed)
        if not leaves.any():
            way.q = q
            return way, rows_of(problem, way), asked
        loose &= ~leaves
    return *find(problem), problem


def without_ends(problem: Problem, joints: Joints) -> Problem:
    """The problem with some joints that turn without end."""
    arm, settings, family = problem.arm, problem.settings.copy(), problem.arm.family.copy()
    lower, upper = np.where(joints, -np.inf, arm.lower), np.where(joints, np.inf, arm.upper)
    for which in (LIMITED, LOOSE):
        pack_limits(family[which], lower, upper)
    settings[PERIOD, joints], settings[INVERSE_PERIOD, joints], settings[ENDLESS] = TURN, 1.0 / TURN, 1.0
    return replace(problem, arm=replace(arm, family=family, lower=lower, upper=upper), settings=settings)


def keeps_turns(problem: Problem, q: Array, closed: bool) -> Joints:
    """(7,) which joints of a path (n, 7) keep their limits, the turns of given postures, and a closed path closed."""
    arm, some = problem.arm, problem.has_known
    kept = np.asarray(((q >= arm.lower) & (q <= arm.upper)).all(axis=0))
    kept &= (np.abs(q[some] - problem.known[some]) < 0.5 * TURN).all(axis=0)
    if closed:
        kept &= np.abs(q[-1] - q[0]) < 0.5 * TURN
    return kept
