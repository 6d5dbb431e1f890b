"""What is asked of the elbow: where it was, an arm angle, or the way on which an objective falls."""

import math

from srs_ik.kernels.algebra.joint_vectors import short_way, with_joint
from srs_ik.kernels.algebra.pointers import read7, row, scratch
from srs_ik.kernels.algebra.vectors import add, along, dot, load3, store3
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.exact.farthest import branch_at
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.track import ANGLE, ANGLE_WANTED, ELBOW, KEEP, KEPT, Q
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import OUTSIDE
from srs_ik.kernels.limb.triangle import elbow_side, frame_at, place
from srs_ik.kernels.optimum.objectives import objective
from srs_ik.kernels.track.catch_up import tip_pose

STEP = 0.12
"""Objectives are compared at arm angles this far apart, rad."""

FINER = 0.25
SHORTEST = 5e-3
"""Next to the end of an interval, and around the best arm angle, which may be where two joints are equally close to
their limits, they are closer together by this factor, but no closer than that, rad."""

FARTHEST = 0.36
"""The elbow is not asked to go farther than this at a time, rad."""

PULL = 30.0
"""What a radian away from the arm angle that is asked for costs, squared."""

KEPT_PULL = 0.3
"""The same for where the elbow is kept; twice that without a turn of the line from shoulder to wrist."""

OPPOSITE = 0.05
"""Directions from shoulder to wrist are opposite to each other where the cosine between them is this close to -1."""

TINY = 1e-6
"""Difference of joint angles for slopes, rad."""


@kernel
def vertex(below, middle, above):
    """Where a parabola through three values a step apart is least, in steps from the middle one; at most one."""
    bend = above - 2.0 * middle + below
    rise = 0.5 * (above - below)
    if bend > abs(rise):
        return -rise / bend
    return -1.0 if rise > 0.0 else (1.0 if rise < 0.0 else 0.0)


@kernel
def downhill(P, C, task, q, place_, psi, J):
    """How far an objective falls with the arm angle, rad: to the end of a parabola, or a step."""
    kind, branch = int(C[ELBOW]), branch_of(P, q)
    side = elbow_side(P, place_, branch >> 2)
    middle, here = branch_at(P, side, psi, branch, True, q, True)
    step, way = STEP, 0.0
    while step > SHORTEST:
        below, one = branch_at(P, side, psi - step, branch, True, q, True)
        above, other = branch_at(P, side, psi + step, branch, True, q, True)
        if max(one, here, other) < OUTSIDE:
            costs = objective(P, kind, task, below, J), objective(P, kind, task, above, J)
            way = step * vertex(costs[0], objective(P, kind, task, middle, J), costs[1])
            if abs(way) == step:
                break
        step *= FINER
    return way


@kernel
def elbow_frame(P, q):
    """Directions from shoulder to wrist, across it to the elbow, and normal to both."""
    R, p = tip_pose(P, q)
    place_ = place(P, R, p)
    psi = arm_angle(P, q, place_[0], place_[1])
    return frame_at(place_, math.cos(psi), math.sin(psi))


@kernel
def keep_elbow(P, S):
    """Remember where the elbow is."""
    t, h, _ = elbow_frame(P, read7(row(S, Q)))
    store3(S, KEPT, t)
    store3(S, KEPT + 3, h)


@kernel
def way_back(S, place_, psi):
    """How far the elbow should go to where it is kept, rad, and how much that counts.

    That is where it was, turned with the line from shoulder to wrist on the shortest way: the same whenever a target
    comes back. An elbow that is straight is nowhere, and for the opposite of that line there is no shortest way.
    """
    t, h, n = frame_at(place_, math.cos(psi), math.sin(psi))
    before, kept = load3(S, KEPT), load3(S, KEPT + 3)
    near = 1.0 + dot(t, before)
    if near < OPPOSITE:
        return 0.0, 0.0
    there = along(kept, -dot(t, kept) / near, add(t, before))
    return math.atan2(-dot(there, n), dot(there, h)), KEPT_PULL * near * place_[3] ** 2


@kernel
def wish(P, S, C, task, q, pose, calm, J):
    """How far the elbow should go by what is asked of it, rad, and how much that counts.

    An elbow that is to be kept is drawn back by a share, `calm`.
    """
    place_ = place(P, pose[0], pose[1])
    psi = arm_angle(P, q, place_[0], place_[1])
    if C[ELBOW] == KEEP:
        way, pull = way_back(S, place_, psi)
        pull *= calm
    else:
        way = short_way(C[ANGLE_WANTED] - psi) if C[ELBOW] == ANGLE else downhill(P, C, task, q, place_, psi, J)
        pull = PULL
    return min(max(way, -FARTHEST), FARTHEST), pull


@kernel
def slope_by(P, q, place_, psi, j):
    """How fast the arm angle changes with a joint."""
    moved = with_joint(q, j, q[j] + TINY)
    return short_way(arm_angle(P, moved, place_[0], place_[1]) - psi) / TINY


@kernel
def slope(P, q, pose):
    """How fast the arm angle changes with each joint."""
    place_ = place(P, pose[0], pose[1])
    psi = arm_angle(P, q, place_[0], place_[1])
    found = row(scratch(1, 7), 0)
    for joint in range(7):
        found[joint] = slope_by(P, q, place_, psi, joint)
    return read7(found)
