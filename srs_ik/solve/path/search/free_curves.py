"""The strips of a near limb in a scene: its curves on the true chain, cut to free intervals."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.layout.path import HELD, HELD_LINKED
from srs_ik.solve.path.problem import Problem
from srs_ik.solve.path.search.blocks import KEPT, held_in, through
from srs_ik.solve.path.search.on_curves import last_free, places_of, which_free
from srs_ik.solve.pose import solve
from srs_ik.system.arrays import Array

Poses = NDArray[np.int64]


class Curves(NamedTuple):
    """Postures on the curves of all poses, (h, HELD), their poses (h,), arm angles (h,), and branches (h,)."""

    rows: Array
    poses: Poses
    psi: Array
    branch: NDArray[np.int64]


def curves_of(problem: Problem) -> Curves | None:
    """All curves of all poses, whatever they hit; None where they are too many to be kept."""
    keys = np.arange(len(problem.T))
    whole = replace(problem, free=None, limited=False)
    blocks = through(whole, keys, False)[1]
    if len(blocks) > KEPT:
        return None
    known = held_in(whole, keys, blocks)
    rows, poses = known.held, known.held_of
    return Curves(rows, poses, *places_of(problem, poses, rows[:, :7]))


def on_free_curves(problem: Problem, curves: Curves) -> Problem:
    """The problem whose only strips are the free parts of its curves, with postures on the ends of these."""
    rows, poses, psi, branch = curves
    own = which_free(problem, poses, psi, branch)
    free, first = own >= 0, np.flatnonzero(rows[:-1, HELD_LINKED] > 0.0)
    ends_in, ends_out = first[free[first] & ~free[first + 1]], first[~free[first] & free[first + 1]]
    inner, outer = np.append(ends_in, ends_out + 1), np.append(ends_in + 1, ends_out)
    ends = rows[inner].copy()
    ends[:, :7] = last_free(problem, poses[inner], rows[inner, :7], rows[outer, :7])
    linked = np.zeros(len(rows), np.bool_)
    # From one interval to another one of the same branch something is in the way; other branches go on into each other.
    linked[first] = free[first] & ((own[first] == own[first + 1]) | (branch[first] != branch[first + 1]))
    linked[ends_in] = True
    told = rows.copy()
    told[:, HELD_LINKED] = linked
    ends[:, HELD_LINKED] = np.arange(len(ends)) >= len(ends_in)
    places = np.concatenate([np.flatnonzero(free), ends_in + 0.5, ends_out + 0.5])
    order = np.argsort(places, kind="stable")
    held, held_of = np.vstack([told[free], ends])[order], np.append(poses[free], poses[inner])[order]
    slivers, slivers_of = between_postures(problem, poses, own)
    held, held_of = np.vstack([held, slivers]), np.append(held_of, slivers_of)
    order = np.argsort(held_of, kind="stable")
    alone = np.ones(len(problem.T), np.bool_)
    return replace(problem, held=held[order], held_of=held_of[order], held_alone=alone)


def between_postures(problem: Problem, poses: Poses, own: NDArray[np.int64]) -> tuple[Array, Poses]:
    """(k, HELD) one posture of each free interval so narrow that no posture of the curves is in it, and (k,) its pose.

    `own` (h,) are the intervals of postures of some poses.
    """
    allowed, ends = problem.allowed()
    empty = np.ones(len(allowed), np.bool_)
    empty[(ends[poses, 0] + own)[(own >= 0) & (ends[poses, 0] >= 0)]] = False
    rows, of = [], []
    for i in np.flatnonzero(~problem.has_known).tolist():
        for branch, lower, upper in allowed[slice(*ends[i])][empty[slice(*ends[i])]].tolist():
            found = solve(problem.arm, problem.T[i], 0.5 * (lower + upper), None, int(branch), True)
            if found:
                rows.append([*found.q, 0.0, branch, 0.0])
                of.append(i)
    return np.array(rows).reshape(-1, HELD), np.array(of, np.int64)
