"""A pose that leaves a turn free: its posture into a row."""

from __future__ import annotations

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.answer import write_row
from srs_ik.kernels.chain.freedom import as_rotation, free_error
from srs_ik.kernels.chain.kinematics import forward_kinematics
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.freedom.nearest import NONE_LEFT, beside, nearest
from srs_ik.kernels.freedom.settle import EVEN, NO_RIVAL, onto_pose, settle
from srs_ik.kernels.freedom.starts import NARROW, find_starts
from srs_ik.kernels.freedom.widen import largest_share, widen
from srs_ik.kernels.freedom.widest import any_limited, weights, widest
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import GOOD_POSE, ROW_STATUS, SOLVED, UNREACHABLE
from srs_ik.kernels.layout.freedom import Found, Freedom, Liking
from srs_ik.kernels.layout.limb import FREE, LIMITED, LOWER, UPPER
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.limits import middles
from srs_ik.kernels.limb.poses import read7, read_pose
from srs_ik.kernels.limb.triangle import place

ROUNDING = 1e-13
"""Errors of a pose, m and rad, that need no step any more."""


@kernel
def limits(P, k):
    """The seven lower or upper limits of joints."""
    return P[k], P[k + 1], P[k + 2], P[k + 3], P[k + 4], P[k + 5], P[k + 6]


@kernel
def liking_of(family, P, seed):
    """What is nearest: the seed, or without one the middles of the ranges."""
    lower, upper = limits(P, LOWER), limits(P, UPPER)
    if seed is not None:
        wish = read7(seed)
        return Liking(wish, EVEN, lower, upper, NONE_LEFT, wish)
    limited = row(family, LIMITED)
    wish = middles(limited)
    return Liking(wish, weights(limited), lower, upper, NONE_LEFT, wish)


@kernel
def found_posture(P, pose, given, liking, respect, desk):
    """The posture nearest to a seed, or without one farthest from the limits."""
    freedom, turns, seed = given
    seeded = seed is not None or not respect or not any_limited(P)
    if seed is not None:
        close = beside(P, pose, freedom, liking, desk)
        if close.met:
            return close
    found = searched(P, pose, (freedom, turns), (seeded, liking), desk)
    if freedom.cone > 0.0 and (freedom.cone < NARROW or not found.met):
        # Turns of a cone are far apart, rolls leave none out: no answer is worse than with the roll alone free.
        roll = searched(P, pose, (Freedom(freedom.axis, 0.0), turns), (seeded, liking), desk)
        roll = improved(P, roll, pose, freedom, (seeded, liking), desk)
        if roll.met and not (found.met and found.cost <= roll.cost):
            found = roll
    if found.met or seeded:
        return found
    # Other starts, from distances and not margins, may yet lead to a posture.
    other = searched(P, pose, (freedom, turns), (True, liking), desk)
    return Found(other.q, largest_share(P, other.q) - 1.0, other.met)


@kernel
def improved(P, found, pose, freedom, goal, desk):
    """A posture that meets its pose where less is free, or the better one that it leads to where more is."""
    seeded, liking = goal
    if not found.met:
        return found
    if seeded:
        q, cost, error, _ = settle(P, found.q, pose, freedom, liking, desk)
    else:
        q, share, error = widen(P, found.q, pose, freedom, NO_RIVAL, desk)
        cost = share - 1.0
    return Found(q, cost, True) if error < SOLVED and cost < found.cost else found


@kernel
def searched(P, pose, given, goal, desk):
    """The nearest or widest posture that searches lead to, from starts all over what is free."""
    freedom, turns = given
    seeded, liking = goal
    count = find_starts(P, pose, freedom, turns, (seeded, liking.posture), desk)
    if seeded:
        return nearest(P, pose, freedom, liking, count, desk)
    return widest(P, pose, freedom, liking, count, desk)


@kernel
def closed_up(P, found, pose, freedom, liking, desk):
    """A posture that was found, taken onto its pose to rounding: searches may end as soon as it counts as met."""
    off, turned = free_error(P, found.q, pose[0], pose[1], freedom)
    if not found.met or max(off, turned) < ROUNDING:
        return found
    q, error = onto_pose(P, found.q, pose, freedom, liking, desk)
    return Found(q, found.cost, True) if error < max(off, turned) else found


@kernel
def write_found(P, pose, freedom, q, out):
    """Write a posture that meets a pose up to its freedom."""
    x, y, z, position = forward_kinematics(P, q)
    place_ = place(P, as_rotation((x, y, z)), position)
    off, turned = free_error(P, q, pose[0], pose[1], freedom)
    psi = arm_angle(P, q, place_[0], place_[1])
    write_row(place_, q, branch_of(P, q), psi, (off, turned), (False, 0), out)


@kernel
def solve_free(family, T, free, seed, respect, desk, out):
    """Solve one pose that leaves a turn free into a row of `out`; returns the verdict on the pose.

    Args:
        family: (4, SIZE) packed limb.
        T: the 16 figures of the pose.
        free: the freedom, and the turns (n, 9) that it is searched at where the axis may lean.
        seed: seven joint angles to stay near, or None.
        respect: whether joint limits count.
        desk: work space.
        out: a row; one that is UNREACHABLE has no posture in it.
    """
    R, p, verdict = read_pose(T)
    if verdict != GOOD_POSE:
        return verdict
    freedom, turns = free
    P = row(family, LIMITED if respect else FREE)
    liking = liking_of(family, P, seed)
    found = found_posture(P, (R, p), (freedom, turns, seed), liking, respect, desk)
    found = closed_up(P, found, (R, p), freedom, liking, desk)
    out[ROW_STATUS] = UNREACHABLE
    if found.met:
        write_found(row(family, LIMITED), (R, p), freedom, found.q, out)
    return GOOD_POSE
