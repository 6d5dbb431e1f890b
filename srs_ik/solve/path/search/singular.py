"""Singular postures, where joints turn on the spot: those of two such turns, of which strips hold lines alone."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries.kinematics import configuration_arm_angle
from srs_ik.kernels.layout.limb import BOTTOM_GAP, LIMITED, PHASE, SHOULDER, STRAIGHT, TOP_GAP, WRIST
from srs_ik.kernels.layout.path import HELD, HELD_BRANCH, HELD_PSI
from srs_ik.solve.path.problem import Problem, Way
from srs_ik.solve.pose import solve
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

ALIGNED = 1e-7
"""Sine of a middle angle below which two joints turn about one axis."""

APART = 1e-4
"""Postures closer than this, rad, are one."""

BITS = 2, 4, 1
"""Of a branch, what says on which side shoulder, elbow and wrist are."""

SIDE_BY_SIDE = np.linspace(-np.pi, np.pi, 64)
"""Where shoulder and wrist turn on the spot, strips have lines of the one at these turns of the other, rad."""


def two_turns(problem: Problem, way: Way) -> NDArray[np.bool_]:
    """(n,) where two of shoulder, elbow and wrist turn on the spot, the elbow one that is straight."""
    if not problem.arm.closed or problem.free is not None:
        return np.zeros(len(way.q), np.bool_)
    return (aligned(problem.arm, way.q).sum(axis=1) == 2) & way.reached & ~problem.has_known


def with_turns(problem: Problem, way: Way, some: NDArray[np.bool_], angles: Array) -> Problem:
    """The problem with postures turned by angles (k,) from those of a path, at poses where two turn on the spot.

    There, postures have two freedoms, and a strip holds lines of them alone. Each posture brings the turn of its
    shoulder or wrist along, as every held one: turned are the elbow, and the wrist where the elbow is bent.
    """
    rows, poses = [], []
    for i in np.flatnonzero(some):
        if aligned(problem.arm, way.q[i])[1]:
            found = _turned_elbows(problem, way, int(i), angles)
        else:
            found = list(turned_wrists(problem.arm, way.q[i], angles))
        rows += found
        poses += [i] * len(found)
    if not rows:
        return problem
    return replace(problem, held=held_rows(problem.arm, np.array(rows)), held_of=np.array(poses))


def aligned(arm: PackedArm, q: Array) -> NDArray[np.bool_]:
    """(..., 3) whether shoulder, elbow and wrist of postures (..., 7) are singular."""
    ends = arm.family[LIMITED][[SHOULDER + PHASE, STRAIGHT, WRIST + PHASE]]
    return np.asarray(np.abs(np.sin(q[..., [1, 3, 5]] - ends)) < ALIGNED)


def _turned_elbows(problem: Problem, way: Way, i: int, angles: Array) -> list[Array]:
    """Postures of a pose at arm angles from that of a path, in its branch or one that meets it where it is singular."""
    arm, q, branches = problem.arm, way.q[i], [int(way.branch[i])]
    for bit, singular in zip(BITS, aligned(arm, q), strict=True):
        if singular:
            branches += [branch ^ bit for branch in branches]
    rows = []
    for psi in (way.psi[i] + angles).tolist():
        found = (solve(arm, problem.T[i], arm_angle=psi, branch=branch) for branch in branches)
        alike = (one.q for one in found if one and np.abs(one.q[[1, 3, 5]] - q[[1, 3, 5]]).max() < APART)
        rows += list(islice(alike, 1))
    return rows


def turned_wrists(arm: PackedArm, q: Array, angles: Array) -> Array:
    """(m, 7) postures with joints 5 and 7 turned against each other from one (7,), those inside the limits."""
    P = arm.family[LIMITED]
    middle = np.cos(q[5] - P[WRIST + PHASE])
    if P[WRIST + (TOP_GAP if middle > 0.0 else BOTTOM_GAP)] != 0.0:
        return np.empty((0, 7))
    rows = np.tile(q, (len(angles), 1))
    rows[:, 4] += angles
    rows[:, 6] -= np.sign(middle) * angles
    return rows[((rows >= arm.lower) & (rows <= arm.upper)).all(axis=1)]


def held_rows(arm: PackedArm, postures: Array) -> Array:
    """(h, HELD) postures; singular ones, whose joints may turn, with their arm angles and branches."""
    rows = np.zeros((len(postures), HELD))
    rows[:, :HELD_PSI], rows[:, HELD_BRANCH] = postures, -1.0
    P = arm.family[LIMITED]
    middles = postures[:, [1, 5]] - P[[SHOULDER + PHASE, WRIST + PHASE]]
    for i in np.flatnonzero((np.abs(np.sin(middles)) < ALIGNED).any(axis=1) & arm.closed):
        rows[i, HELD_PSI : HELD_BRANCH + 1] = configuration_arm_angle(arm.family, postures[i])
    return rows


def note_two_turns(problem: Problem, poses: NDArray[np.int64], q: Array) -> None:
    """Note which of the postures (k, 7) of some poses (k,) have a shoulder and a wrist that turn on the spot."""
    P = problem.arm.family[LIMITED]
    some = np.abs(np.sin(q[:, 1] - P[SHOULDER + PHASE])) < ALIGNED
    if some.any():
        some &= (np.abs(np.sin(q[:, 5] - P[WRIST + PHASE])) < ALIGNED) & ~problem.has_known[poses]
        problem.two_turns.update(zip(poses[some].tolist(), q[some], strict=True))


def side_by_side(problem: Problem) -> Problem:
    """The problem with lines side by side where shoulder and wrist turn on the spot; the same one if nowhere."""
    poses = sorted(problem.two_turns)
    rows = [turned_wrists(problem.arm, problem.two_turns[i], SIDE_BY_SIDE) for i in poses]
    if len(problem.held) or not any(map(len, rows)):
        return problem
    held = held_rows(problem.arm, np.vstack(rows))
    return replace(problem, held=held, held_of=np.repeat(poses, [len(each) for each in rows]), two_turns={})
