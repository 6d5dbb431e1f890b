"""Where the goal comes no closer to the target: whether other postures reach it, and which of them may be gone to.

The goal moves on the true chain, step by step; limits can stop it where the same branch has a posture a way on. That is
read off the intervals of the pose.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, apart
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import dot
from srs_ik.kernels.exact.farthest import branch_at
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MOST_INTERVALS
from srs_ik.kernels.layout.limb import FAR, MISS
from srs_ik.kernels.layout.track import (
    DETOUR,
    DETOUR_END,
    ELSEWHERE,
    GAP,
    GOAL,
    GOAL_RATE,
    NOWHERE,
    PERIOD,
    RECONFIGURE,
    SPEED,
    V,
)
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.track.closest import DAMPING, approach
from srs_ik.kernels.track.limits import time_to
from srs_ik.kernels.track.target import load_pace, part_of_way

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

SOONER = 0.9
"""A posture that joints come to within this share of the time in which they come to the goal is come to sooner."""

RUNS_AWAY = 0.5
"""A goal this far ahead, rad, is reckoned to go on as it does: one that is closer may well be slower soon."""

LEFT_BEHIND = 0.05
"""A tip that is left behind by less than this share of its target's way goes on with it."""

SHORTEST = 1e-3
"""A posture this close, rad, is where the goal is stuck."""


@kernel
def out_of_reach(P, place_):
    """Whether the wrist of a pose is farther from the shoulder than the arm is long, or too close."""
    return abs(place_[5]) > 8.0 * P[MISS] + 1e-9 * P[FAR]


@kernel
def nearest_in(P, C, side, interval, start, best, least):
    """The posture of an interval that is nearest to joints, of those looked at, if it is nearer than another.

    Near is what joints come to soon from their velocities, s, or without these how far they have to go, rad.
    """
    q, v, timed = start
    branch = int(interval[0])
    middle, half = 0.5 * (interval[1] + interval[2]), 0.5 * (interval[2] - interval[1])
    half -= min(INSIDE, 0.5 * half)
    pieces = math.ceil(2.0 * half / SPACING)
    for i in range(pieces + 1):
        psi = middle - half + (2.0 * half * i / pieces if pieces > 0 else 0.0)
        end, value = branch_at(P, side, psi, branch, True, q, True)
        if value < OUTSIDE:
            way = time_to(C, q, v, end, NO_SEED) if timed else apart(end, q)
            if way < least:
                best, least = end, way
    return best, least


@kernel
def look_elsewhere(P, S, C, place_):
    """Send the goal to the nearest posture on the target; where none is near, write what there is.

    Of other branches, only postures that are next to it are near, and nearer than a share of what its own has: else
    the arm would flip. A goal that is on its way to a posture stays on it, and goes to where that has come to with the
    target.
    """
    q = read7(row(S, DETOUR_END if S[DETOUR] == 1.0 else GOAL))
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
                best, least = nearest_in(P, C, side, row(found, i), (q, NO_SEED, False), best, least)
            else:
                other, nearest = nearest_in(P, C, side, row(found, i), (q, NO_SEED, False), other, nearest)
    if nearest < LONGEST_FLIP and nearest < RELUCTANT * least:
        best, least = other, nearest
    if SHORTEST < least < LONGEST:
        send(S, best)
    elif S[DETOUR] == 0.0 and n == 0:
        S[ELSEWHERE] = NOWHERE
    elif S[DETOUR] == 0.0 and least >= LONGEST:
        S[ELSEWHERE] = RECONFIGURE


@kernel
def pace_at(P, S, C, q, pose, work):
    """How fast joints have to be at a posture for the tip to go on with its target, rad/s; whether they can be."""
    v, w = load_pace(S)
    after = part_of_way(pose, C[PERIOD], v, w)
    fastest = read7(row(C, SPEED))
    high = along7(NO_SEED, C[PERIOD], fastest)
    choice = (NO_SEED, NO_SEED, (P[FAR], 0.0, DAMPING), along7(NO_SEED, -1.0, high), high)
    d, size = approach(P, C, after, q, choice, 2, work)
    way = C[PERIOD] * math.sqrt(dot(v, v) + P[FAR] ** 2 * dot(w, w))
    return along7(NO_SEED, 1.0 / C[PERIOD], d), size < LEFT_BEHIND * way + 8.0 * P[MISS] + 1e-9 * P[FAR]


@kernel
def look_sooner(P, S, C, q, place_, pose, work):
    """Where the joints fall behind a goal on its target, send it to a posture that they come to sooner.

    The goal knows no inertia: it goes around a singular posture in whose midst joints are too slow, and then away.
    """
    v, goal = read7(row(S, V)), read7(row(S, GOAL))
    gap = apart(q, goal)
    if gap > S[GAP]:
        chase = read7(row(S, GOAL_RATE)) if gap > RUNS_AWAY else NO_SEED
        least = SOONER * time_to(C, q, v, goal, chase)
        found = np.empty((MOST_INTERVALS, 3))
        n = find_intervals(P, place_, -1, found)
        for i in range(n):
            side = elbow_side(P, place_, int(found[i, 0]) >> 2)
            end, time = nearest_in(P, C, side, row(found, i), (q, v, True), q, least)
            if time >= least or apart(end, q) > max(LONGEST, gap):
                continue
            rate, can = pace_at(P, S, C, end, pose, work)
            time = time_to(C, q, v, end, rate)
            if can and time < least:
                least = time
                send(S, end)
    S[GAP] = gap


@kernel
def send(S, q):
    """Let the goal go to a posture."""
    S[DETOUR] = 1.0
    for j in range(7):
        S[DETOUR_END + j] = q[j]
