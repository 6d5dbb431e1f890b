"""Where the goal comes no closer to the target: whether other postures reach it, and which of them may be gone to.

The goal moves on the true chain, step by step; limits can stop it where the same branch has a posture a way on. That is
read off the intervals of the pose.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import apart
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.exact.farthest import branch_at
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MOST_INTERVALS
from srs_ik.kernels.layout.limb import FAR, MISS
from srs_ik.kernels.layout.track import DETOUR, DETOUR_END, ELSEWHERE, GAP, GOAL, NOWHERE, RECONFIGURE
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import OUTSIDE
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.limb.triangle import elbow_side

INSIDE = 0.02
"""A posture is looked for this far inside of an interval, rad."""

SPACING = 0.5
"""Postures inside of an interval are looked at this close together, rad."""

LONGEST = 2.0
"""A joint that would have to move farther than this, rad, is reconfigured: nobody expects that of a tracker."""

LONGEST_FLIP = 1.0
"""The same for postures of other branches, which lie next to each other where the arm is almost singular."""

RELUCTANT = 0.5
"""How much nearer that has to be of which the goal takes another branch by itself."""

NEARER = 0.9
"""A posture that is nearer to the joints than this share of what they are behind the goal is nearer."""

SHORTEST = 1e-3
"""A posture this close, rad, is where the goal is stuck."""


@kernel
def out_of_reach(P, place_):
    """Whether the wrist of a pose is farther from the shoulder than the arm is long, or too close."""
    return abs(place_[5]) > 8.0 * P[MISS] + 1e-9 * P[FAR]


@kernel
def nearest_in(P, side, interval, goal, best, least):
    """The posture of an interval that is nearest to the goal, of those looked at, if it is nearer than another."""
    branch = int(interval[0])
    middle, half = 0.5 * (interval[1] + interval[2]), 0.5 * (interval[2] - interval[1])
    half -= min(INSIDE, 0.5 * half)
    pieces = math.ceil(2.0 * half / SPACING)
    for i in range(pieces + 1):
        psi = middle - half + (2.0 * half * i / pieces if pieces > 0 else 0.0)
        q, value = branch_at(P, side, psi, branch, True, goal, True)
        way = apart(q, goal)
        if value < OUTSIDE and way < least:
            best, least = q, way
    return best, least


@kernel
def nearest_posture(P, q, place_, share):
    """A posture on the target that is near another, and how far it is, rad; how many intervals there are.

    Of other branches, only postures that are next to it are near, and nearer than a share of what its own has: else
    the arm would flip.
    """
    branch = branch_of(P, q)
    found = np.empty((MOST_INTERVALS, 3))
    n = find_intervals(P, place_, -1, found)
    best, least, other, nearest = q, math.inf, q, math.inf
    for elbow in range(2):
        side = elbow_side(P, place_, elbow)
        for i in range(n):
            if int(found[i, 0]) >> 2 != elbow:
                continue
            if int(found[i, 0]) == branch:
                best, least = nearest_in(P, side, row(found, i), q, best, least)
            else:
                other, nearest = nearest_in(P, side, row(found, i), q, other, nearest)
    if nearest < LONGEST_FLIP and nearest < share * least:
        best, least = other, nearest
    return best, least, n


@kernel
def look_elsewhere(P, S, place_):
    """Send the goal to the nearest posture on the target; where none is near, write what there is.

    A goal that is on its way to a posture stays on it, and goes to where that has come to with the target.
    """
    best, least, n = nearest_posture(P, read7(row(S, DETOUR_END if S[DETOUR] == 1.0 else GOAL)), place_, RELUCTANT)
    if SHORTEST < least < LONGEST:
        send(S, best)
    elif S[DETOUR] == 0.0 and n == 0:
        S[ELSEWHERE] = NOWHERE
    elif S[DETOUR] == 0.0 and least >= LONGEST:
        S[ELSEWHERE] = RECONFIGURE


@kernel
def look_nearer(P, S, q, place_):
    """Where the joints fall behind a goal on its target, send it to a posture that is nearer to them.

    The goal knows no inertia: it goes around a singular posture in whose midst joints are too slow, and then away.
    """
    gap = apart(q, read7(row(S, GOAL)))
    if gap > S[GAP]:
        best, least, _ = nearest_posture(P, q, place_, 1.0)
        if least < NEARER * gap:
            send(S, best)
    S[GAP] = gap


@kernel
def send(S, q):
    """Let the goal go to a posture."""
    S[DETOUR] = 1.0
    for j in range(7):
        S[DETOUR_END + j] = q[j]
