"""Entry points for bodies: free arm angles of one pose and of many, the widest posture, the best one that is free.

The tables of bodies are those of `layout.collision`: `bodies` (rows, BODY_ROW), `groups` (G, GROUP) and `pairs` (n, 2)
integers, `slack` (SLACK,) margin and drift; `local` (rows, LOCAL_ROW) and `ready` (G,) are work space. Intervals are
rows of branch, lower and upper end; `family` are packed limbs, `T` and `poses` good poses unless verdicts are told.
Real shapes are those of `layout.shapes`: `solids` (S, SOLID) and `of_solid` (S, OF_SOLID), `points` (N, 3), `shaped`
(B, SHAPED) and `of_body` (B, OF_BODY), `couples` (K, PAIR) and `outer` (2, OUTER).
"""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.algebra.pointers import read7, row, scratch
from srs_ik.kernels.chain.answer import measure_row
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.collision.arcs import angles_of
from srs_ik.kernels.collision.clearance import MOST_PARTS, resting_clearance, turning_clearance, widest_within
from srs_ik.kernels.collision.free import forbidden_arcs, left_of
from srs_ik.kernels.collision.march import march_all
from srs_ik.kernels.collision.motion import CLEAR, look_along
from srs_ik.kernels.collision.seen import World, frames_of_either, frames_of_elbow, still_frames
from srs_ik.kernels.collision.shaped import Room, free_by_shapes
from srs_ik.kernels.collision.shapes import NORMALS, Along, Shapes
from srs_ik.kernels.exact.farthest import keep_branch
from srs_ik.kernels.exact.flat import exact_intervals
from srs_ik.kernels.jit import entry, kernel
from srs_ik.kernels.layout import collision as at
from srs_ik.kernels.layout.answer import GOOD_POSE, MOST_INTERVALS, ROW_STATUS
from srs_ik.kernels.layout.asked import Goal
from srs_ik.kernels.layout.limb import LIMITED, LOWER, UPPER
from srs_ik.kernels.layout.path import Space
from srs_ik.kernels.layout.shapes import MOST_SPINS, MOST_WAITING, RANGED, WATCHED
from srs_ik.kernels.limb.goal import OUTSIDE
from srs_ik.kernels.limb.limits import TURN
from srs_ik.kernels.limb.triangle import read_target, target_of
from srs_ik.kernels.pose.any_bend import best_of
from srs_ik.kernels.pose.solve import best_posture, own_goal

NO_COUPLE = -1
"""No shapes belong to a pair: it is one with a cloud."""

ROUNDING = 1e-12
"""An arm angle may be off its interval so far, rad."""

SAFE = 1e-9
"""A posture whose clearance is larger than the margin by this, m, is not in a forbidden arc."""


@entry
def forbidden(family, T, bodies, groups, pairs, slack, local, ready, arcs, counts):
    """Forbidden arm angles of one pose: sorted pieces between -pi and pi, for each elbow.

    They are written to arcs (2, MOST_ARCS, 2), and how many they are to counts (2,).
    """
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    forbidden_arcs(P, target_of(P, row(T, 0)), world, slack, arcs, counts, np.empty((at.MOST_ARCS, 2)))


@entry
def free_intervals(family, T, bodies, groups, pairs, slack, local, ready, found, n, out):
    """What bodies leave of the first n intervals of one pose in found (n, 3): number of rows written to out."""
    P = row(family, LIMITED)
    return left_of(P, target_of(P, row(T, 0)), found[:n], World(bodies, groups, pairs, local, ready), slack, out)


@entry
def march(family, T, found, n, bodies, groups, pairs, slack, local, ready, out):
    """The same on the true chain of a near limb, along its curves: found (m, 3) is sorted by branch."""
    P = row(family, LIMITED)
    around = (World(bodies, groups, pairs, local, ready), slack, None)
    return march_all(P, target_of(P, row(T, 0)), around, found[:n], Space(scratch(6, 7), scratch(16, 9)), out)


@entry
def free_range(
    family, limits, poses, first, last, respect, bodies, groups, pairs, slack, local, ready, rows, counts, verdicts
):
    """Free intervals of the poses from first to last - 1, as far as rows suffice: the next pose, and the rows used.

    `limits` is the same limb packed with the limits that count; rows, counts and verdicts are written as by
    `pose.intervals_range`.
    """
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    found = np.empty((MOST_INTERVALS, 3))
    used, i = 0, first
    while i < last and used + MOST_INTERVALS <= rows.shape[0]:
        target, verdicts[i] = read_target(P, row(poses, i))
        counts[i] = 0
        if verdicts[i] == GOOD_POSE:
            n, _ = exact_intervals(limits, target_of(row(limits, LIMITED), row(poses, i)), respect, found)
            if n > 0:
                counts[i] = left_of(P, target, found[:n], world, slack, rows[used : used + MOST_INTERVALS])
        used += counts[i]
        i += 1
    return i, used


@entry
def clearance(family, T, bodies, groups, pairs, local, ready, elbow, psi, out):
    """Least clearance of one pose at an arm angle into out (WIDE,), with the two groups that are nearest."""
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    frames = frames_of_either(P, target_of(P, row(T, 0)), world, elbow)
    least, pair = turning_clearance(world, elbow, frames, psi, 0, (-math.inf, math.inf))
    resting, other = resting_clearance(world, elbow, frames, math.inf)
    put_wide(world, psi, elbow << 2, min(least, resting), pair if least <= resting else other, out)


@kernel
def put_wide(world, psi, branch, value, pair, out):
    """Write an arm angle with its clearance and the two groups that are nearest there."""
    out[at.WIDE_ARM_ANGLE], out[at.WIDE_BRANCH], out[at.WIDE_CLEARANCE] = psi, branch, value
    out[at.WIDE_FIRST] = world.pairs[pair, 0] if pair != at.NO_GROUP else at.NO_GROUP
    out[at.WIDE_SECOND] = world.pairs[pair, 1] if pair != at.NO_GROUP else at.NO_GROUP


@kernel
def branch_at(found, n, elbow, psi):
    """A branch of an elbow with an arm angle, to rounding, in its intervals; -1 for none."""
    for i in range(n):
        if int(found[i, 0]) >> 2 == elbow:
            away = psi - found[i, 1] + ROUNDING
            if away - TURN * math.floor(away / TURN) <= found[i, 2] - found[i, 1] + 2.0 * ROUNDING:
                return int(found[i, 0])
    return -1


@entry
def widest(family, T, bodies, groups, pairs, local, ready, found, n, tolerance, out):
    """The largest clearance, within a tolerance, over n intervals of a pose in found (n, 3), into out (WIDE,).

    Where two bodies that no arm angle moves against each other are nearest, the others are as far apart as they can.
    """
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    target = target_of(P, row(T, 0))
    still = still_frames(P, target)
    parts, arcs = np.empty((MOST_PARTS, 4)), np.empty((at.MOST_ARCS, 2))
    best = -math.inf
    out[at.WIDE_CLEARANCE] = -math.inf
    for elbow in range(2):
        frames = frames_of_elbow(P, target, world, still, elbow)
        resting, other = resting_clearance(world, elbow, frames, math.inf)
        psi, turning = 0.0, -math.inf
        # All branches of an elbow are as clear as each other.
        for i in range(angles_of(found, n, 0b1111 << 4 * elbow, arcs)):
            ends = (arcs[i, 0], arcs[i, 1])
            psi, turning = widest_within(world, elbow, frames, ends, (psi, turning), tolerance, parts)
        branch = branch_at(found, n, elbow, psi)
        if branch < 0 or (min(turning, resting), turning) <= (out[at.WIDE_CLEARANCE], best):
            continue
        best = turning
        _, pair = turning_clearance(world, elbow, frames, psi, 0, (-math.inf, math.inf))
        put_wide(world, psi, branch, min(turning, resting), pair if turning <= resting else other, out)


@entry
def best_within(family, T, found, n, branch, seed, seeded, respect, out):
    """The best posture of an exact limb over the first n intervals in found (n, 3), into a row; its cost.

    It is the one nearest to the seed where `seeded`, else the one farthest from the limits; branch -1 stands for all.
    """
    P = row(family, LIMITED)
    target, goal = target_of(P, row(T, 0)), Goal(seeded, read7(seed), respect)
    q, best, lowest = best_of(family, target, found[:n], branch, goal)
    measure_row(P, target, q, best, lowest, respect, row(out, 0))
    return lowest


@kernel
def is_within(limits, limited, q):
    """Whether a posture keeps limits, where these count."""
    L = row(limits, LIMITED)
    inside = True
    for j in range(7):
        inside = inside and q[j] >= L[LOWER + j] and q[j] <= L[UPPER + j]
    return inside or not limited


@kernel
def is_clear(P, target, q, branch, world, slack):
    """Whether a posture of an exact limb certainly keeps the margin between all bodies."""
    if slack[at.DRIFT] != 0.0:
        return False
    wanted = slack[at.MARGIN] + SAFE
    elbow = branch >> 2
    frames = frames_of_either(P, target, world, elbow)
    psi = arm_angle(P, q, target.place[0], target.place[1])
    least, _ = turning_clearance(world, elbow, frames, psi, 0, (wanted, wanted + SAFE))
    if least <= wanted:
        return False
    least, _ = resting_clearance(world, elbow, frames, wanted + SAFE)
    return least > wanted


@entry
def solve_range(
    family,
    limits,
    poses,
    first,
    last,
    branch,
    seeds,
    respect,
    limited,
    bodies,
    groups,
    pairs,
    slack,
    local,
    ready,
    out,
    verdicts,
):
    """The best free postures of an exact limb, of poses first to last - 1, into rows of out (N, ROW); (N,) verdicts.

    `limits` is the limb packed with the limits that count, and `limited` whether these do. Of one branch, or of all
    (-1); nearest to a seed, one for all or one a pose, or farthest from the limits. Where nothing is free the status is
    NOTHING_FREE, and the rest of the row as it was. Most of the best postures of all keep clear; only where one does
    not, the arcs that bodies forbid are wanted.
    """
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    found, left = np.empty((MOST_INTERVALS, 3)), np.empty((MOST_INTERVALS, 3))
    J, A = scratch(6, 7), scratch(16, 9)
    for i in range(first, last):
        target, verdicts[i] = read_target(P, row(poses, i))
        out[i, ROW_STATUS] = at.NOTHING_FREE
        if verdicts[i] == GOOD_POSE:
            goal = own_goal(seeds, i, respect)
            q, best, lowest = best_posture(family, target, branch, goal, J, A)
            if lowest < OUTSIDE and is_within(limits, limited, q) and is_clear(P, target, q, best, world, slack):
                measure_row(P, target, q, best, lowest, respect, row(out, i))
                continue
            n, _ = exact_intervals(limits, target_of(row(limits, LIMITED), row(poses, i)), limited, found)
            n = left_of(P, target, found[:n], world, slack, left) if n > 0 else 0
            n = keep_branch(left, n, branch) if branch >= 0 else n
            if n > 0:
                q, best, lowest = best_of(family, target, left[:n], branch, goal)
                measure_row(P, target, q, best, lowest, respect, row(out, i))


@entry
def edges(family, starts, ends, bodies, groups, pairs, slack, local, ready, out):
    """Look along the straight line from each of n postures to its end: how many do not keep clear.

    Each has its slack. A row of out (n, EDGE) takes where on the line, 0 to 1, which pair is too close, and its
    clearance, m; pair -1 where the line is certainly clear.
    """
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    hits = 0
    for i in range(starts.shape[0]):
        start = read7(row(starts, i))
        step = along7(read7(row(ends, i)), -1.0, start)
        verdict, out[i, at.EDGE_AT], pair, out[i, at.EDGE_CLEARANCE] = look_along(P, start, step, world, row(slack, i))
        out[i, at.EDGE_PAIR] = pair
        hits += verdict != CLEAR
    return hits


@entry
def free_by_solids(
    family,
    T,
    found,
    ranges,
    margin,
    bodies,
    groups,
    pairs,
    slack,
    local,
    ready,
    solids,
    of_solid,
    points,
    shaped,
    of_body,
    couples,
    outer,
    out,
    rest,
):
    """What the solids of all couples leave of the intervals of one pose in found (n, 3), of an exact limb.

    `ranges` (m, 3) are those in which ranges of joints keep bodies apart; `margin` is what is left between solids, m,
    and `slack` tells what spheres count. Rows are written to out (o, 3), and to rest (R, REST) what is left of couples
    that are more than their solids.

    Returns:
        How many rows of out are written, the width left undecided, rad, and how many rows of rest there are.
    """
    P = row(family, LIMITED)
    frames, normals = np.empty((8, 12)), np.empty((NORMALS, 3))
    shapes = Shapes(
        solids, of_solid, points, shaped, of_body, couples, outer, np.empty(solids.shape[0]), frames, normals
    )
    count = couples.shape[0]
    spins, spin_counts = np.empty((count, MOST_SPINS, 2)), np.empty(count, np.int64)
    room = Room(np.empty((8, at.MOST_ARCS, 2)), np.empty((MOST_WAITING, 4)), spins, spin_counts, rest)
    world = World(bodies, groups, pairs, local, ready)
    space = Space(scratch(6, 7), scratch(16, 9))
    return free_by_shapes(
        P, target_of(P, row(T, 0)), world, shapes, found, ranges, (margin, slack[at.MARGIN]), space, room, out
    )


@entry
def march_by_solids(
    family,
    T,
    found,
    bodies,
    groups,
    pairs,
    slack,
    local,
    ready,
    solids,
    of_solid,
    points,
    shaped,
    of_body,
    couples,
    outer,
    out,
):
    """The same on the true chain of a near limb, along its curves: found (n, 3) is sorted by branch; rows of out."""
    P = row(family, LIMITED)
    frames, normals = np.empty((8, 12)), np.zeros((NORMALS, 3))
    shapes = Shapes(
        solids, of_solid, points, shaped, of_body, couples, outer, np.empty(solids.shape[0]), frames, normals
    )
    couple_of = np.full(pairs.shape[0], NO_COUPLE)
    for k in range(couples.shape[0]):
        if couples[k, WATCHED] != RANGED:
            couple_of[couples[k, WATCHED]] = k
    along = Along(shapes, couple_of, np.empty((8, 12)), np.empty((8, 12)))
    around = (World(bodies, groups, pairs, local, ready), slack, along)
    return march_all(P, target_of(P, row(T, 0)), around, found, Space(scratch(6, 7), scratch(16, 9)), out)
