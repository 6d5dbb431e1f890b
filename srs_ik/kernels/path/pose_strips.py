"""All strips of a pose: of its feasible intervals, and of the turns of joints that have more than one."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.limb import LIMITED, LOOSE, LOWER, UPPER
from srs_ik.kernels.limb.limits import TURN
from srs_ik.kernels.limb.poses import read7, read_pose
from srs_ik.kernels.limb.triangle import elbow_side, place
from srs_ik.kernels.path.followed import away, settled
from srs_ik.kernels.path.near_strips import take_runs
from srs_ik.kernels.path.strips import (
    NODE,
    NODE_BRANCH,
    NODE_PSI,
    NODE_WAY,
    ROUNDING,
    STRIP_FIRST,
    STRIP_LAST,
    is_wide,
    put_node,
    take_strip,
)


@kernel
def pose_strips(family, T, near, radius, found, nodes, linked, n, strips, m, work, turns, wide, J, A):
    """Write the strips of a pose, finer around a posture: the next free rows of postures and strips.

    Loose tolerances find also the arm angles that two joints on their limits leave alone.
    """
    P = row(family, LIMITED)
    R, p, _ = read_pose(T)
    place_ = place(P, R, p)
    begin = n
    if J is not None:
        n = take_runs(P, place_, R, p, near, radius, nodes, linked, n, J, A)
        n = turn_strips(P, nodes, linked, begin, n, turns) if wide else keep_inside(P, nodes, linked, begin, n)
        return n, list_strips(nodes, linked, begin, n, strips, m)
    count = find_intervals(row(family, LOOSE), place_, -1, found) if abs(place_[5]) < SOLVED else 0
    sides = (elbow_side(P, place_, 0), elbow_side(P, place_, 1))
    for i in range(count):
        branch = int(found[i, 0])
        side = sides[0] if branch < 4 else sides[1]
        first = n
        n = take_strip(P, side, branch, (found[i, 1], found[i, 2]), near, radius, nodes, linked, n, work)
        n = turn_strips(P, nodes, linked, first, n, turns) if wide else keep_inside(P, nodes, linked, first, n)
    return n, list_strips(nodes, linked, begin, n, strips, m)


@kernel
def keep_inside(P, nodes, linked, first, last):
    """Put postures that are outside their limits by rounding on them, and leave out what is farther outside."""
    n = first
    for i in range(first, last):
        q, inside = settled(P, read7(row(nodes, i)), ROUNDING)
        if not inside:
            if n > first:
                linked[n - 1] = False
            continue
        put_node(nodes, n, q, nodes[i, NODE_PSI], nodes[i, NODE_BRANCH])
        linked[n] = linked[i]
        n += 1
    return n


@kernel
def turns_inside(P, joint, nodes, n0, n1):
    """First and last whole turn by which a joint of a run of postures may be turned to be inside its limits."""
    least = nodes[n0, joint]
    most = least
    for i in range(n0 + 1, n1):
        least = min(least, nodes[i, joint])
        most = max(most, nodes[i, joint])
    first = math.ceil((P[LOWER + joint] - most - ROUNDING) / TURN)
    last = math.floor((P[UPPER + joint] - least + ROUNDING) / TURN)
    return int(first), int(last)


@kernel
def put_turned(P, nodes, linked, n0, n1, turns, n):
    """Append a run of postures, joints turned by whole turns, as far as they are inside the limits then."""
    before = False
    for i in range(n0, n1):
        q = read7(row(nodes, i))
        q = (
            q[0] + TURN * turns[0],
            q[1] + TURN * turns[1],
            q[2] + TURN * turns[2],
            q[3] + TURN * turns[3],
            q[4] + TURN * turns[4],
            q[5] + TURN * turns[5],
            q[6] + TURN * turns[6],
        )
        q, inside = settled(P, q, ROUNDING)
        if inside and n < nodes.shape[0]:
            put_node(nodes, n, q, nodes[i, NODE_PSI], nodes[i, NODE_BRANCH])
            linked[n] = False
            if before and linked[i - 1]:
                linked[n - 1] = True
            n += 1
        before = inside
    return n


@kernel
def turn_strips(P, nodes, linked, n0, n1, turns):
    """Replace a run of postures by one run for each combination of turns inside the limits; the next free row."""
    firsts = np.zeros(7, np.int64)
    counts = np.ones(7, np.int64)
    total = 1
    for joint in range(7):
        if is_wide(P, joint):
            first, last = turns_inside(P, joint, nodes, n0, n1)
            firsts[joint] = first
            counts[joint] = max(last - first + 1, 0)
            total *= counts[joint]
    n = n1
    for number in range(total):
        rest = number
        for joint in range(7):
            turns[joint] = firsts[joint] + rest % counts[joint]
            rest //= counts[joint]
        n = put_turned(P, nodes, linked, n0, n1, turns, n)
    for i in range(n1, n):
        for j in range(NODE):
            nodes[n0 + i - n1, j] = nodes[i, j]
        linked[n0 + i - n1] = linked[i]
    return n0 + n - n1


@kernel
def list_strips(nodes, linked, n0, n1, strips, count):
    """Measure the strips among the postures of rows n0 to n1 - 1 and list them; returns how many there are."""
    start = n0
    for i in range(n0, n1):
        if i == start:
            nodes[i, NODE_WAY] = 0.0
        else:
            nodes[i, NODE_WAY] = nodes[i - 1, NODE_WAY] + away(row(nodes, i), row(nodes, i - 1))
        if linked[i] and i + 1 < n1:
            continue
        if count < strips.shape[0]:
            for j in range(7):
                strips[count, j] = nodes[start, j]
                strips[count, 7 + j] = nodes[start, j]
                for k in range(start + 1, i + 1):
                    strips[count, j] = min(strips[count, j], nodes[k, j])
                    strips[count, 7 + j] = max(strips[count, 7 + j], nodes[k, j])
            strips[count, STRIP_FIRST] = start
            strips[count, STRIP_LAST] = i
            count += 1
        start = i + 1
    return count
