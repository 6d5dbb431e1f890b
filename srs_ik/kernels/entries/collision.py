"""Entry points for bodies: free arm angles, the widest posture, and the best posture that is free.

The tables of bodies are those of `layout.collision`; `local` (rows, LOCAL_ROW) and `ready` (G,) are work space.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.collision.arcs import add_arc, cut
from srs_ik.kernels.collision.clearance import MOST_PARTS, resting_clearance, turning_clearance, widest_within
from srs_ik.kernels.collision.free import arcs_of_pairs, best_of, forbidden_arcs
from srs_ik.kernels.collision.seen import World, see_balls, still_frames, turning_frames
from srs_ik.kernels.jit import entry, kernel
from srs_ik.kernels.layout.collision import (
    MOST_ARCS,
    NO_GROUP,
    WIDE_ARM_ANGLE,
    WIDE_BRANCH,
    WIDE_CLEARANCE,
    WIDE_FIRST,
    WIDE_SECOND,
)
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.layout.path import Spot
from srs_ik.kernels.limb.limits import TURN
from srs_ik.kernels.limb.poses import read7, read_pose
from srs_ik.kernels.limb.triangle import place

ROUNDING = 1e-12
"""An arm angle may be off its interval so far, rad."""


@kernel
def spot_of(P, T):
    """What all configurations of a pose share."""
    R, p, _ = read_pose(row(T, 0))
    return Spot(R, p, place(P, R, p))


@entry
def forbidden(family, T, bodies, groups, pairs, slack, local, ready, arcs, counts):
    """Forbidden arm angles of one pose: sorted pieces between -pi and pi, for each elbow.

    Args:
        family: packed limbs.
        T: (4, 4) pose, a good one.
        bodies: (rows, BODY_ROW).
        groups: (G, GROUP) integers.
        pairs: (n, 2) integers.
        slack: (SLACK,) margin and drift.
        local: (rows, LOCAL_ROW) work space.
        ready: (G,) integers, work space.
        arcs: (2, MOST_ARCS, 2) output.
        counts: (2,) integers, output: pieces of each elbow.
    """
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    forbidden_arcs(P, spot_of(P, T), world, slack, arcs, counts, np.empty((MOST_ARCS, 2)))


@entry
def forbidden_by_pair(family, T, bodies, groups, pairs, slack, local, ready, out):
    """Arcs that each pair forbids, for each elbow, into out (n, ARC): how many there are, those that do not fit too."""
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    work = np.empty((MOST_ARCS, 2)), np.empty((MOST_ARCS, 2))
    return arcs_of_pairs(P, spot_of(P, T), world, slack, work, out)


@entry
def free_intervals(family, T, bodies, groups, pairs, slack, local, ready, found, n, out):
    """What bodies leave of the first n intervals of one pose in found (n, 3): number of rows written to out."""
    world = World(bodies, groups, pairs, local, ready)
    arcs = np.empty((2, MOST_ARCS, 2))
    counts = np.zeros(2, np.int64)
    P = row(family, LIMITED)
    forbidden_arcs(P, spot_of(P, T), world, slack, arcs, counts, np.empty((MOST_ARCS, 2)))
    return cut(found, n, arcs, counts, out)


@entry
def clearance(family, T, bodies, groups, pairs, local, ready, elbow, psi, out):
    """Least clearance of one pose at an arm angle into out (WIDE,), with the two groups that are nearest."""
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    R, p, _ = read_pose(row(T, 0))
    place_ = place(P, R, p)
    still = still_frames(P, place_, R, p)
    see_balls(world, 0, still, turning_frames(P, place_, 0))
    frames = (still, turning_frames(P, place_, elbow))
    see_balls(world, elbow, still, frames[1])
    least, pair = turning_clearance(world, elbow, frames, psi)
    resting, other = resting_clearance(world, elbow, frames)
    put_wide(world, psi, elbow << 2, min(least, resting), pair if least <= resting else other, out)


@kernel
def put_wide(world, psi, branch, value, pair, out):
    """Write an arm angle with its clearance and the two groups that are nearest there."""
    out[WIDE_ARM_ANGLE], out[WIDE_BRANCH], out[WIDE_CLEARANCE] = psi, branch, value
    out[WIDE_FIRST] = world.pairs[pair, 0] if pair != NO_GROUP else NO_GROUP
    out[WIDE_SECOND] = world.pairs[pair, 1] if pair != NO_GROUP else NO_GROUP


@kernel
def all_angles(found, n, elbow, arcs):
    """Write the arm angles of the first n intervals of an elbow, of all its branches, as one set: number of pieces."""
    count = 0
    for i in range(n):
        if int(found[i, 0]) >> 2 == elbow:
            half = 0.5 * (found[i, 2] - found[i, 1])
            count = add_arc(arcs, count, found[i, 1] + half, half)
    return count


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
    R, p, _ = read_pose(row(T, 0))
    place_ = place(P, R, p)
    still = still_frames(P, place_, R, p)
    parts, arcs = np.empty((MOST_PARTS, 3)), np.empty((MOST_ARCS, 2))
    best = -math.inf
    out[WIDE_CLEARANCE] = -math.inf
    for elbow in range(2):
        frames = (still, turning_frames(P, place_, elbow))
        see_balls(world, elbow, still, frames[1])
        resting, other = resting_clearance(world, elbow, frames)
        psi, turning = 0.0, -math.inf
        # All branches of an elbow are as clear as each other.
        for i in range(all_angles(found, n, elbow, arcs)):
            ends = (arcs[i, 0], arcs[i, 1])
            psi, turning = widest_within(world, elbow, frames, ends, (psi, turning), tolerance, parts)
        branch = branch_at(found, n, elbow, psi)
        if branch < 0 or (min(turning, resting), turning) <= (out[WIDE_CLEARANCE], best):
            continue
        best = turning
        _, pair = turning_clearance(world, elbow, frames, psi)
        put_wide(world, psi, branch, min(turning, resting), pair if turning <= resting else other, out)


@entry
def best_within(family, T, found, n, branch, seed, seeded, respect, out):
    """The best posture of an exact limb over the first n intervals in found (n, 3), into a row; its cost.

    Args:
        family: packed limbs.
        T: (4, 4) pose, a good one.
        found: (n, 3) branch, lower and upper end of each interval.
        n: how many.
        branch: the only one that is wanted; -1: all.
        seed: (7,) posture to be near to.
        seeded: whether that is the goal; else the margin to the limits.
        respect: whether the joint limits have to be kept.
        out: (ROW,) output.
    """
    P = row(family, LIMITED)
    return best_of(P, spot_of(P, T), found[:n], branch, (seeded, read7(seed), respect), row(out, 0))
