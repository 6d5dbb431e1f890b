"""What a map tells of a pose: its branches, the width and number of its intervals, its margin and its arcs of yaw."""

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.exact.events import TOUCH, TURN
from srs_ik.kernels.exact.farthest import farthest, farthest_of_all
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import maps as at
from srs_ik.kernels.layout.answer import GOOD_POSE, SOLVED
from srs_ik.kernels.layout.limb import LIMITED, LOOSE
from srs_ik.kernels.limb.goal import OUTSIDE
from srs_ik.kernels.limb.triangle import elbow_side, read_target
from srs_ik.kernels.maps.arcs import put_arc, write_arcs
from srs_ik.kernels.maps.first_joint import ahead, first_range, singular_angle, split_angles, turning_points
from srs_ik.kernels.maps.reach import room

STEP_ASIDE = 1e-9
"""Joint 1 is looked at so far, rad, beside the arm angle of a singularity, at which it jumps."""


@kernel
def clear(most, out):
    """A cell that is not reached."""
    for k in range(at.CELL_ARCS + 2 * most):
        out[k] = 0.0


@kernel
def write_measures(found, n, out):
    """Write what n intervals tell of a cell."""
    branches, total, widest = 0, 0.0, 0.0
    for i in range(n):
        width = found[i, 2] - found[i, 1]
        branches |= 1 << int(found[i, 0])
        total += width
        widest = max(widest, width)
    out[at.CELL_BRANCHES] = branches
    out[at.CELL_PIECES] = n
    out[at.CELL_WIDTH] = total
    out[at.CELL_WIDEST] = widest


@kernel
def put_arcs_of(P, motion, turns, interval, limits, arcs, n):
    """Append the arcs of one interval (branch, lower, upper) of arm angles; their number, -1: the whole circle."""
    branch, lower, upper = interval
    sign = (branch >> 1) & 1
    begin = lower
    for end in range(2):
        psi, singular = singular_angle(P, motion, end)
        psi = ahead(psi, lower - STEP_ASIDE)
        if not singular or psi > upper + STEP_ASIDE:
            continue
        low, high = split_angles(P, motion, psi, end)
        n = put_arc(low, high, limits, arcs, n)
        if n >= 0 and psi - STEP_ASIDE > begin:
            low, high = first_range(P, motion, turns, sign, begin, psi - STEP_ASIDE)
            n = put_arc(low, high, limits, arcs, n)
        if n < 0:
            return n
        begin = psi + STEP_ASIDE
    if begin > upper and begin > lower:
        return n
    low, high = first_range(P, motion, turns, sign, begin, upper)
    return put_arc(low, high, limits, arcs, n)


@kernel
def write_yaws(P, place_, found, n, limits, most, out):
    """Write the arcs of yaw over which joint 1 keeps its limits; the intervals are found without regard to these."""
    if limits[1] - limits[0] >= TURN - TOUCH:
        write_arcs(np.empty((1, 2)), -1, most, out)
        return
    arcs = np.empty((at.MOST_ARCS + n + 2, 2))
    count = 0
    for elbow in range(2):
        _, motion, _, _ = elbow_side(P, place_, elbow)
        turns = turning_points(P, motion)
        for i in range(n):
            if int(found[i, 0]) >> 2 == elbow and count >= 0:
                interval = (int(found[i, 0]), found[i, 1], found[i, 2])
                count = put_arcs_of(P, motion, turns, interval, limits, arcs, count)
    write_arcs(arcs, count, most, out)


@kernel
def write_cell(family, place_, limits, asked, space, out):
    """Write what a map tells of a pose of an exact limb into a cell, as in `layout.maps`; for arcs, joint 1 is free.

    `limits` are those of joint 1, rad; `asked` how many arcs there is room for (0: none are wanted), and whether the
    margin is wanted; `space` is that of `reach.room`.
    """
    most, margin = asked
    if abs(place_[5]) >= SOLVED:
        clear(most, out)
        return
    P = row(family, LIMITED)
    n = find_intervals(P, place_, -1, space.found)
    if n == 0:
        # A pose whose postures all lie on limits leaves room by rounding alone.
        P = row(family, LOOSE)
        n = find_intervals(P, place_, -1, space.found)
    if n == 0:
        clear(most, out)
        return
    write_measures(space.found, n, out)
    out[at.CELL_MARGIN] = 0.0
    if margin:
        _, _, cost = farthest(P, place_, space.found[:n], -1, True)
        out[at.CELL_MARGIN] = max(-cost, 0.0) if math.isfinite(cost) else 0.0
    if most > 0:
        write_yaws(P, place_, space.found, n, limits, most, out)


@kernel
def margin_of_poses(family, poses, first, last, out):
    """Write the largest margin to the limits of poses first to last - 1 of (N, 4, 4) into out (N,), 0 where none is."""
    for i in range(first, last):
        target, verdict = read_target(row(family, LIMITED), row(poses, i))
        place_ = target.place
        out[i] = 0.0
        if verdict != GOOD_POSE or abs(place_[5]) >= SOLVED:
            continue
        _, _, cost = farthest_of_all(row(family, LIMITED), row(family, LIMITED), place_, -1, True)
        if cost >= OUTSIDE:
            _, _, cost = farthest_of_all(row(family, LOOSE), row(family, LOOSE), place_, -1, True)
        if cost < OUTSIDE:
            out[i] = max(-cost, 0.0)


@kernel
def measure_poses(family, poses, first, last, limits, asked, out):
    """`write_cell` of poses first to last - 1 of (N, 4, 4) into rows of out."""
    space = room(family)
    for i in range(first, last):
        target, verdict = read_target(row(family, LIMITED), row(poses, i))
        if verdict == GOOD_POSE:
            write_cell(family, target.place, limits, asked, space, row(out, i))
        else:
            clear(asked[0], row(out, i))
