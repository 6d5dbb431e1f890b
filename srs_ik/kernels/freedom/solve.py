"""A pose that leaves a turn free: its posture into a row."""

from __future__ import annotations

from srs_ik.kernels.algebra.joint_vectors import between
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.answer import write_row
from srs_ik.kernels.chain.freedom import as_rotation, free_error
from srs_ik.kernels.chain.kinematics import forward_kinematics
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.freedom.constraints import THIN
from srs_ik.kernels.freedom.from_seed import CLOSE, from_seed
from srs_ik.kernels.freedom.nearest import in_other_branches, nearest, once_more
from srs_ik.kernels.freedom.settle import EVEN, NO_POSTURE, led_to, onto_pose, settle
from srs_ik.kernels.freedom.starts import MOST_ATTEMPTS, NONE_LEFT, is_loose, starts_of_roll, starts_of_turns
from srs_ik.kernels.freedom.turns import held_straight
from srs_ik.kernels.freedom.widest import any_limited, weights, widest_of_all
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import GOOD_POSE, ROW_STATUS, SOLVED, UNREACHABLE
from srs_ik.kernels.layout.freedom import Found, Freedom, Liking, Sought
from srs_ik.kernels.layout.limb import FREE, LIMITED, LOWER, UPPER
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.limits import middles
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import place

NEAREST, NEAREST_IN_NARROW, NEAREST_IN_CONE = (24, 4, 1.0), (10, 4, 1.0), (16, 8, 2.0)
"""With the roll alone free, in a narrow cone, and in a wider one: local searches at most once a posture is known; those
of starts that are good once they are inside the limits, which come late; and how much nearer to the seed than these
starts searches come, rad. In a wide cone, postures pressed between limits have starts farther away."""

NARROW = 0.3
"""In a cone up to this, rad, the roll alone is searched first: it may be all that is near."""

ROUNDING = 1e-13
"""Errors of a pose, m and rad, that need no step any more."""


@kernel
def limits(P, k):
    """The seven lower or upper limits of joints."""
    return P[k], P[k + 1], P[k + 2], P[k + 3], P[k + 4], P[k + 5], P[k + 6]


@kernel
def liking_of(family, P, goal):
    """What is nearest: the seed, or without one the middles of the ranges."""
    lower, upper = limits(P, LOWER), limits(P, UPPER)
    if goal.seeded:
        return Liking(goal.seed, EVEN, lower, upper, NONE_LEFT, NO_POSTURE)
    limited = row(family, LIMITED)
    wish = middles(limited)
    return Liking(wish, weights(limited), lower, upper, NONE_LEFT, NO_POSTURE)


@kernel
def found_posture(family, P, pose, given, goal, liking, desk):
    """The posture nearest to a seed, or without one farthest from the limits."""
    none = Found(liking.posture, NONE_LEFT, False)
    if goal.seeded:
        known, alone = from_seed(family, P, pose, given[0], goal, liking, desk)
        if alone:
            return known
        # One that is farther ends no other search: at singular shoulders and wrists these go a long way round.
        found = nearest_of_all(P, pose, given, liking, known if known.cost < CLOSE * CLOSE else none, desk)
        found = known if known.cost < found.cost else found
        if not found.met:
            return found
        found = once_more(P, pose, given[0], liking, found, desk)
        # The grid is coarse in a wide cone, and may have starts of the best branch at other turns alone.
        return in_other_branches(P, pose, given[0], liking, found, desk) if given[0].cone > NARROW else found
    if goal.respect and any_limited(P):
        found = widest_of_all(P, pose, given, liking, desk)
        if found.met:
            return found
    # Without a seed other starts, from distances and not margins, may yet lead to a posture.
    return nearest_of_all(P, pose, given, liking, none, desk)


@kernel
def nearest_of_all(P, pose, given, liking, found, desk):
    """The nearest posture that searches lead to, from starts all over what is free, or the one that is known.

    A thin cone is searched as a roll: that of the way to which its axis presses. In a narrow one the roll alone comes
    first, too: what is found there leads to a posture that is no worse. A few searches tell whether there is one.
    """
    freedom = given[0]
    loose = is_loose(P, freedom.axis)
    count = starts_of_roll(P, pose, freedom, Sought(True, liking.posture, found, loose, 0.0), desk)
    if freedom.cone <= NARROW:
        held = held_straight(P, pose, freedom.axis, liking)
        first = freedom if freedom.cone <= THIN else Freedom(freedom.axis, 0.0)
        most = MOST_ATTEMPTS if freedom.cone == 0.0 else NEAREST_IN_NARROW[0]
        found = nearest(P, pose, first, held, (count, NEAREST, most), found, desk)
    if found.met and freedom.cone > THIN:
        q, cost, error, at_rest = settle(P, found.q, pose, freedom, liking, desk)
        if error < SOLVED and cost < found.cost:
            found = Found(q, cost, True)
        liking = led_to(liking, q if at_rest else NO_POSTURE)
    elif freedom.cone == 0.0 or found.met:
        return found
    count = starts_of_turns(P, pose, given, Sought(True, liking.posture, found, loose, 0.0), desk, count)
    enough = NEAREST_IN_NARROW if freedom.cone <= NARROW else NEAREST_IN_CONE
    return nearest(P, pose, freedom, liking, (count, enough, MOST_ATTEMPTS), found, desk)


@kernel
def closed_up(P, found, pose, freedom, liking, desk):
    """A posture that was found, taken onto its pose to rounding: searches may end as soon as it counts as met."""
    there = between(found.q, liking.lower, liking.upper)
    off, turned = free_error(P, there, pose[0], pose[1], freedom)
    if not found.met or max(off, turned) < ROUNDING:
        return Found(there, found.cost, found.met)
    q, error = onto_pose(P, there, pose, freedom, liking, desk)
    return Found(q if error < max(off, turned) else there, found.cost, True)


@kernel
def write_found(P, pose, freedom, q, out):
    """Write a posture that meets a pose up to its freedom."""
    x, y, z, position = forward_kinematics(P, q)
    place_ = place(P, as_rotation((x, y, z)), position)
    off, turned = free_error(P, q, pose[0], pose[1], freedom)
    psi = arm_angle(P, q, place_[0], place_[1])
    write_row(place_, q, branch_of(P, q), psi, (off, turned), (False, 0), out)


@kernel
def solve_free(family, T, free, goal, desk, out):
    """Solve one pose that leaves a turn free into a row of `out`; returns the verdict on the pose.

    Args:
        family: (4, SIZE) packed limb.
        T: the 16 figures of the pose.
        free: the freedom, the turns (n, 9) that it is searched at where the axis may lean, and how many of these first.
        goal: seven joint angles to stay near, or none, and whether joint limits count.
        desk: work space.
        out: a row; one that is UNREACHABLE has no posture in it.
    """
    R, p, verdict = read_pose(T)
    if verdict != GOOD_POSE:
        return verdict
    P = row(family, LIMITED if goal.respect else FREE)
    liking = liking_of(family, P, goal)
    found = found_posture(family, P, (R, p), free, goal, liking, desk)
    found = closed_up(P, found, (R, p), free[0], liking, desk)
    out[ROW_STATUS] = UNREACHABLE
    if found.met:
        write_found(row(family, LIMITED), (R, p), free[0], found.q, out)
    return GOOD_POSE
