"""Postures of the poses between two at which a path is planned."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import cross, norm
from srs_ik.kernels.chain.answer import OK
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.exact.intervals import MAX_PIECES, find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import LIMITED, LOOSE, ROW, ROW_ARM_ANGLE, ROW_BRANCH, ROW_STATUS
from srs_ik.kernels.limb.limits import TURN
from srs_ik.kernels.limb.poses import read7, read_pose
from srs_ik.kernels.limb.triangle import elbow_side, place
from srs_ik.kernels.path.followed import away, posture_of, settled
from srs_ik.kernels.path.programme import BY_CONTINUITY, largest, steps_between
from srs_ik.kernels.pose.solve import solve_row

ON_LIMIT = 1e-9


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
def part_of_way(a, e, t):
    """The posture a moved on by a part of the joint steps e."""
    return (
        a[0] + t * e[0],
        a[1] + t * e[1],
        a[2] + t * e[2],
        a[3] + t * e[3],
        a[4] + t * e[4],
        a[5] + t * e[5],
        a[6] + t * e[6],
    )


@kernel
def follow_on(family, poses, before, i, behind, settings, q, psi, branch, bounds, J, A):
    """Write a posture of pose i near the straight line between those of two others; whether there is one."""
    P = row(family, LIMITED)
    start = read7(row(q, before))
    e = steps_between(settings, start, row(q, behind))
    near = part_of_way(start, e, (i - before) / (behind - before))
    reach = 0.5 * settings[BY_CONTINUITY, 0]
    R, p, _ = read_pose(row(poses, i))
    place_ = place(P, R, p)
    if branch[before] >= 0 and branch[before] == branch[behind]:
        angle = arm_angle(P, near, place_[0], place_[1])
        side = elbow_side(P, place_, branch[before] >> 2)
        here, good = posture_of(P, place_, side, R, p, angle, branch[before], near, True, False, J, A)
        here, inside = settled(P, here, ON_LIMIT)
        if good and inside and away(here, near) < reach:
            write_posture(q, psi, branch, i, here, angle, branch[before])
            write_bounds(family, place_, branch[before], angle, bounds, i, J)
            return True
    answer = np.empty(ROW)
    solve_row(family, row(poses, i), -1, near, True, J, A, row(answer, 0))
    here = read7(answer)
    e = steps_between(settings, near, here)
    if answer[ROW_STATUS] != OK or largest(e) > reach:
        return False
    write_posture(q, psi, branch, i, part_of_way(near, e, 1.0), answer[ROW_ARM_ANGLE], int(answer[ROW_BRANCH]))
    write_bounds(family, place_, branch[i], psi[i], bounds, i, J)
    return True


@kernel
def write_posture(q, psi, branch, i, here, angle, number):
    """Write the posture of a pose."""
    for j in range(7):
        q[i, j] = here[j]
    psi[i] = angle
    branch[i] = number


@kernel
def write_bounds(family, place_, number, angle, bounds, i, J):
    """Write the ends of the interval around an arm angle; on a near limb, limits are looked at step by step."""
    bounds[i, 0] = -math.inf
    bounds[i, 1] = math.inf
    if J is None:
        found = np.empty((8 * MAX_PIECES, 3))
        for k in range(find_intervals(row(family, LOOSE), place_, number, found)):
            low, high = found[k, 1], found[k, 2]
            turns = TURN * math.floor((angle - low + ON_LIMIT) / TURN)
            if angle <= high + turns + ON_LIMIT and high - low < TURN - ON_LIMIT:
                bounds[i, 0] = low + turns
                bounds[i, 1] = high + turns
