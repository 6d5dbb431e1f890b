"""Joint paths that hit nothing, where poses leave a turn free: turns first, and then a path through whole poses.

The best path without the scene is the answer if it hits nothing. Else turns are chosen: those of that path, and those
of ways through the free intervals of sampled turns. With its turns held, each is a path through whole poses, which is
planned in their free intervals and certified.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from srs_ik.inputs.freedom import FreeAxis
from srs_ik.kernels.layout.answer import ROW_STATUS
from srs_ik.solve.in_scene import freedom
from srs_ik.solve.in_scene.path import if_clear, with_breaks
from srs_ik.solve.path.free.sampled import keeps_limits, sampled_ways, turned_as
from srs_ik.solve.path.problem import Problem
from srs_ik.solve.path.solution import PathSolution
from srs_ik.solve.path.turns import unwound
from srs_ik.solve.solution import Status
from srs_ik.system.arrays import Array


def keep_clear(
    problem: Problem, free: FreeAxis, alone: PathSolution, find: Callable[[Array], PathSolution]
) -> PathSolution:
    """See `Arm.solve_path`, with a scene and a free axis.

    `alone` is the path without the scene, `find` the search for one in it through poses whose turns are held.
    """
    arm, around, start = problem.arm, problem.around, problem.seed
    assert around is not None
    clear = if_clear(problem, alone)
    if clear is not None:
        return clear
    nearest = None if start is None else freedom.solve(around, problem.T[0], free, start, True)
    ways = [alone.q, *sampled_ways(problem, free, nearest.q if nearest else None)]
    paths = [find(turned_as(arm, problem.T, free, q)) for q in ways]
    best = min(
        paths,
        key=lambda path: (int((~path.ok).sum()), len(path.breaks), not keeps_limits(problem, path.q), path.value),
    )
    rows = best._rows.copy()
    for i in np.flatnonzero(~best.ok).tolist():
        # What is not reached is not for good, unless no posture of its own meets it.
        rows[i] = freedom.solve(around, problem.T[i], free, rows[i - 1, :7] if i else start, True)._row
    if (rows[~best.ok, ROW_STATUS] == Status.OK).any():
        rows[:, :7] = unwound(problem, rows)
    # Which bodies count, spheres or real shapes, is as for the path.
    return with_breaks(problem if best._problem is None else replace(problem, around=best._problem.around), rows)
