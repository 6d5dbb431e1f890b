"""Where the goal comes no closer to the target: whether other postures reach it, and which of them may be gone to.

The goal moves on the true chain, step by step; limits can stop it where the same branch has a posture a way on. That is
read off the intervals of the pose.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, apart, store7
from srs_ik.kernels.algebra.pointers import read7, row, scratch
from srs_ik.kernels.chain.newton import clipped
from srs_ik.kernels.exact.farthest import branch_at
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.exact.nearest import between_limbs
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import track as at
from srs_ik.kernels.layout.answer import MOST_INTERVALS
from srs_ik.kernels.layout.limb import FAR, IS_CLOSED, MISS, SIZE
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.limits import tighten
from srs_ik.kernels.limb.triangle import elbow_side, place
from srs_ik.kernels.track.closest import DAMPING, approach, minus
from srs_ik.kernels.track.freedom import allowed_turn, turns_to_look_at, whole_rotation
from srs_ik.kernels.track.verdict import CLOSE

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

NO_OTHER = 0.03
"""A posture so little farther away, rad, than one that was tried in vain may be the same: the goal creeps."""

SPARE = 4.0
"""Next to singularities a near limb's postures are farther from those of its exact limb, by so much."""

REFINED = 8
"""Steps in which a posture is taken to the true chain."""

ALL_UP = (math.inf, math.inf, math.inf, math.inf, math.inf, math.inf, math.inf)
ALL_DOWN = (-math.inf, -math.inf, -math.inf, -math.inf, -math.inf, -math.inf, -math.inf)
"""Beyond the limits of all joints."""


@kernel
def nearest_in(P, side, interval, start, best, least):
    """The posture of an interval that is nearest to another, of those looked at, if it is nearer than the best.

    `side` is `elbow_side` of the interval, `start` the other posture, and how far from it, rad, postures have been
    tried in vain; the best so far is `least`, rad, away.
    """
    goal, tried = start
    branch = int(interval[0])
    middle, half = 0.5 * (interval[1] + interval[2]), 0.5 * (interval[2] - interval[1])
    half -= min(INSIDE, 0.5 * half)
    pieces = math.ceil(2.0 * half / SPACING)
    for i in range(pieces + 1):
        psi = middle - half + (2.0 * half * i / pieces if pieces > 0 else 0.0)
        q, value = branch_at(P, side, psi, branch, True, goal, True)
        way = apart(q, goal)
        if value < OUTSIDE and tried < way < least:
            best, least = q, way
    return best, least


@kernel
def nearest_postures(P, start, place_, share):
    """The posture of a pose that is nearest to another in its branch, and that of all: each and how far it is, rad.

    Of other branches, postures that are next to it count as its own, if they are nearer than a share of what that has:
    else the arm would flip. `start` is as in `nearest_in`.
    """
    q, _ = start
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
                best, least = nearest_in(P, side, row(found, i), start, best, least)
            else:
                other, nearest = nearest_in(P, side, row(found, i), start, other, nearest)
    if nearest < LONGEST_FLIP and nearest < share * least:
        best, least = other, nearest
    if least < nearest:
        other, nearest = best, least
    return best, least, other, nearest


@kernel
def postures_to_try(P, start, place_):
    """`nearest_postures` of the nearest exact limb: within what a near limb's limits may be for that."""
    if P[IS_CLOSED] == 1.0:
        return nearest_postures(P, start, place_, RELUCTANT)
    box = row(scratch(1, SIZE), 0)
    tighten(P, NO_SEED, math.inf, SPARE * between_limbs(P), box)
    return nearest_postures(box, start, place_, RELUCTANT)


@kernel
def end_search(S, known):
    """Write what is known of postures that reach the target; the next look begins anew."""
    S[at.ELSEWHERE] = known
    S[at.LOOKS] = S[at.TRIED] = 0.0
    S[at.SEEN] = at.UNKNOWN


@kernel
def look_elsewhere(P, S, C, pose, size, work):
    """One look of a search for a posture on the target that the goal can be sent to; where none is near, for any.

    Of the nearest exact limb, a posture is known at a time; one that does not lead onto the target on the true chain
    was tried in vain, and the next is that farther away. Where a turn is free, each look is at another one. Nothing is
    said of a target that moves and that the goal misses by `size` if that is within what the nearest exact limb can
    tell; of one that rests, the search of the whole redundancy has the last word.
    """
    goal = read7(row(S, at.GOAL))
    place_ = place(P, allowed_turn(P, C, goal, pose[0], S[at.LOOKS]), pose[1])
    own, way, other, farther = postures_to_try(P, (goal, S[at.TRIED]), place_)
    whole = C[at.HAS_FREE] == 0.0
    if whole and P[IS_CLOSED] == 1.0 and way <= SHORTEST:
        S[at.ELSEWHERE] = at.UNKNOWN
        return
    S[at.LOOKS] += 1.0
    near = way < LONGEST and not (whole and S[at.SEEN] == at.NOWHERE)
    if whole and not near and S[at.SEEN] == at.UNKNOWN and S[at.TRIED] > 0.0:
        S[at.SEEN], S[at.TRIED] = at.NOWHERE, 0.0
        return
    if not near:
        own, way = other, farther
    if way < math.inf:
        there, met = on_true_chain(P, C, own, pose, work)
        if met and near:
            send(S, there)
            end_search(S, at.UNKNOWN)
            return
        if met:
            S[at.SEEN] = at.RECONFIGURE
        elif whole:
            S[at.TRIED] = way + NO_OTHER
            return
    if S[at.LOOKS] >= turns_to_look_at(C):
        nowhere = at.NOWHERE if size > P[MISS] or S[at.ASKED] != at.MOVES else at.UNKNOWN
        end_search(S, at.RECONFIGURE if S[at.SEEN] == at.RECONFIGURE or S[at.ASKED] == at.RECONFIGURE else nowhere)


@kernel
def on_true_chain(P, C, q, pose, work):
    """A posture that is nearly on a pose, taken onto it on the true chain; whether it is there."""
    low, high = minus(clipped(P, ALL_DOWN), q), minus(clipped(P, ALL_UP), q)
    choice = (NO_SEED, NO_SEED, (P[FAR], 0.0, DAMPING), low, high)
    d, size = approach(P, C, pose, q, choice, REFINED, work)
    return clipped(P, along7(q, 1.0, d)), size < CLOSE


@kernel
def keep_detour(P, S, C, pose, work):
    """Let the end of a detour go with the target; where it cannot, end the detour."""
    there, met = on_true_chain(P, C, read7(row(S, at.DETOUR_END)), pose, work)
    if met:
        send(S, there)
    else:
        S[at.DETOUR] = 0.0


@kernel
def look_nearer(P, S, C, q, pose, work):
    """Where the joints fall behind a goal on its target, send it to a posture that is nearer to them.

    The goal knows no inertia: it goes around a singular posture in whose midst joints are too slow, and then away.
    """
    goal = read7(row(S, at.GOAL))
    gap = apart(q, goal)
    if gap > S[at.GAP]:
        place_ = place(P, whole_rotation(P, C, goal, pose[0]), pose[1])
        best, least, _, _ = nearest_postures(P, (q, -1.0), place_, 1.0)
        if least < NEARER * gap:
            there, met = on_true_chain(P, C, best, pose, work)
            if met:
                send(S, there)
    S[at.GAP] = gap


@kernel
def send(S, q):
    """Let the goal go to a posture."""
    S[at.DETOUR] = 1.0
    store7(S, at.DETOUR_END, q)
