"""Postures of the poses between two at which a path is planned."""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, apart, store7
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import cross, norm
from srs_ik.kernels.chain.newton import CLOSED, STEPS, arm_angle, close_free
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.limb import IS_NEAR, LIMITED
from srs_ik.kernels.layout.path import BY_CONTINUITY
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.limits import TURN
from srs_ik.kernels.limb.triangle import elbow_side, target_of
from srs_ik.kernels.path.followed import ON_LIMIT, posture_of, settled
from srs_ik.kernels.path.pose_strips import roomy
from srs_ik.kernels.path.steps import steps_between


@kernel
def pose_change(place0, place1):
    """How much a pose differs from another as the arm sees it, rad: direction S-W, bend, and hand."""
    t0, _, c0, s0, hand0, _ = place0
    t1, _, c1, s1, hand1, _ = place1
    trace = 0.0
    for i in range(9):
        trace += hand0[i] * hand1[i]
    turn = math.acos(min(max(0.5 * (trace - 1.0), -1.0), 1.0))
    return norm(cross(t0, t1)) + abs(c0 * s1 - s0 * c1) + turn


@kernel
def between_two(line, at, settings):
    """Write the point of the straight line between two postures of a path, and return it; `at` as in `follow_on`."""
    before, i, behind = at
    start = read7(row(line.q, before))
    near = along7(start, (i - before) / (behind - before), steps_between(settings, start, row(line.q, behind)))
    store7(row(line.q, i), 0, near)
    return near


@kernel
def follow_on(family, course, line, at, settings, J, A):
    """Write a posture near the straight line between those of two other poses; whether there is one.

    `at` are the numbers of the pose before, of this one and of the pose behind.
    """
    before, i, behind = at
    P = row(family, LIMITED)
    near = between_two(line, at, settings)
    reach = 0.5 * settings[7 * BY_CONTINUITY]
    target = target_of(P, row(course.poses, i))
    place_ = target.place
    if P[IS_NEAR] != 0.0:
        here, error = close_free(P, near, target.R, target.p, True, 2 * STEPS, J, A)
        good = error < CLOSED and apart(here, near) < reach
        write_posture(line, i, here, 0.0, branch_of(P, here))
        course.bounds[i, 0], course.bounds[i, 1] = -math.inf, math.inf
        return good
    angle = arm_angle(P, near, place_[0], place_[1])
    closest = reach
    for end in (before, behind):
        branch = line.branch[end]
        if branch < 0 or (end == behind and branch == line.branch[before]):
            continue
        here, good = posture_of(P, elbow_side(P, place_, branch >> 2), angle, branch, near, True)
        here, inside = settled(P, here, ON_LIMIT)
        if good and inside and apart(here, near) < closest:
            closest = apart(here, near)
            write_posture(line, i, here, angle, branch)
            write_bounds(family, place_, branch, angle, row(course.bounds, i))
    return closest < reach


@kernel
def write_posture(line, i, here, angle, number):
    """Write the posture of a pose."""
    store7(row(line.q, i), 0, here)
    line.psi[i] = angle
    line.branch[i] = number


@kernel
def write_own_bounds(family, course, line, i):
    """Write the ends of the interval of the posture of a pose, if it has one."""
    if line.branch[i] >= 0:
        place_ = target_of(row(family, LIMITED), row(course.poses, i)).place
        write_bounds(family, place_, line.branch[i], line.psi[i], row(course.bounds, i))


@kernel
def write_bounds(family, place_, number, angle, bounds):
    """Write the ends of the interval around an arm angle."""
    bounds[0], bounds[1] = -math.inf, math.inf
    found = np.empty((8 * MAX_PIECES, 3))
    for k in range(find_intervals(roomy(family, place_), place_, number, found)):
        low, high = found[k, 1], found[k, 2]
        turns = TURN * math.floor((angle - low + ON_LIMIT) / TURN)
        if angle <= high + turns + ON_LIMIT and high - low < TURN - ON_LIMIT:
            bounds[0], bounds[1] = low + turns, high + turns
