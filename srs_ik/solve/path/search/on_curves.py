"""A path of a near limb in free intervals: planned on the nearest exact limb, and moved along its true curves.

Planned postures that are taken to their poses one by one lie beside one another. Moved all at once they are the best,
but leave what is free where that costs less. Those stay on the ends of their intervals, and the others move again.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.layout.answer import ROW, ROW_ARM_ANGLE, ROW_BRANCH
from srs_ik.solve.path.problem import Problem, Way, copy
from srs_ik.solve.path.search.polish import improve
from srs_ik.solve.pose import lead
from srs_ik.system.arrays import Array

ROUNDS = 6
"""Postures are put on ends of their intervals so often at most."""

ON_END = 1e-7
"""An arm angle beyond the end of an interval by less than this, rad, is on it."""

TURN = 2.0 * np.pi


class Home(NamedTuple):
    """A free interval: its branch, and its least and largest arm angle, rad."""

    branch: int
    lower: float
    upper: float

    def off(self, psi: float) -> tuple[float, float]:
        """How far an arm angle is outside, rad, and the nearest one inside."""
        ahead = (psi - self.lower) % TURN
        width = self.upper - self.lower
        if ahead <= width:
            return 0.0, self.lower + ahead
        beyond, before = ahead - width, TURN - ahead
        return (beyond, self.upper) if beyond < before else (before, self.lower)


def homes_of(problem: Problem, way: Way) -> list[Home | None]:
    """The free interval in which each posture of a plan lies, by its branch and arm angle; None where it has none."""
    homes: list[Home | None] = []
    for i, rows in enumerate(problem.free or []):
        of_branch = [] if rows is None else [Home(int(b), *ends) for b, *ends in rows.tolist() if b == way.branch[i]]
        moves = way.reached[i] and not problem.has_known[i]
        homes.append(min(of_branch, key=lambda home: home.off(way.psi[i])[0], default=None) if moves else None)
    return homes


def improve_in(homes: list[Home | None], problem: Problem, way: Way) -> None:
    """Move the postures of a path, in place, to the best ones near them that are in free intervals."""
    stays = problem.has_known | np.array([home is None for home in homes])
    for _ in range(ROUNDS):
        before = copy(way)
        improve(replace(problem, has_known=stays), way)
        psi, branch = places_of(problem, way)
        out = np.flatnonzero(way.reached & ~stays & ~are_free(problem, psi, branch))
        if not len(out):
            return
        for i in out.tolist():
            home = homes[i]
            assert home is not None
            end = lead(problem.arm, problem.T[i], home.off(psi[i])[1], home.branch, way.q[i], None, True)
            way.q[i] = before.q[i] if end is None else end.q
        stays[out] = True
    improve(replace(problem, has_known=stays), way)


def places_of(problem: Problem, way: Way) -> tuple[Array, NDArray[np.int64]]:
    """(n,) arm angles and branches of postures on the true chain, where they are reached."""
    rows, chain = np.zeros((len(way.q), ROW)), np.flatnonzero(way.reached)
    entries.finish(problem.arm.family, problem.T, chain, way.q, way.psi, np.full(len(way.q), -1), rows)
    return rows[:, ROW_ARM_ANGLE], rows[:, ROW_BRANCH].astype(np.int64)


def are_free(problem: Problem, psi: Array, branch: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(n,) whether arm angles of branches are in a free interval of their poses."""
    free = np.ones(len(psi), np.bool_)
    for i, rows in enumerate(problem.free or []):
        if rows is not None:
            own = rows[rows[:, 0] == branch[i]]
            ahead = (psi[i] - own[:, 1] + ON_END) % TURN
            free[i] = bool((ahead <= own[:, 2] - own[:, 1] + 2.0 * ON_END).any())
    return free
