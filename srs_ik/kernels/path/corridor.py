"""A path made better within a corridor: the same programme over a few postures to both sides of each of its own."""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, apart, largest, store7
from srs_ik.kernels.algebra.lanes import as_bits, eight_of
from srs_ik.kernels.algebra.pointers import read7, row, scratch
from srs_ik.kernels.algebra.vectors import load3, load_pose
from srs_ik.kernels.chain.newton import CLOSED, STEPS, close_free
from srs_ik.kernels.chain.newton_eight import largest as largest_of
from srs_ik.kernels.curves.in_step import one_of_seven
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import path as at
from srs_ik.kernels.layout.limb import IS_NEAR, LIMITED
from srs_ik.kernels.layout.path import SETTINGS, Course, Posture, Sheet, Span, Stop
from srs_ik.kernels.limb.self_motion import rates
from srs_ik.kernels.limb.triangle import target_of
from srs_ik.kernels.path.followed import ON_LIMIT, along_cell, posture_of, read_side, settled, write_sides
from srs_ik.kernels.path.near_strips import direction, moved_along, setting_of
from srs_ik.kernels.path.pose_strips import list_strips
from srs_ik.kernels.path.programme import advance, cheapest, first_costs, step_back
from srs_ik.kernels.path.splits import along_split, split_of
from srs_ik.kernels.path.steps import copied, rules_for
from srs_ik.kernels.path.strips import put_node
from srs_ik.kernels.pose.moved import moved_eight, within, write_tip

WIDTH = 2
"""Postures to each side."""

ACROSS = 2 * WIDTH + 1

WIDEST_MOVE = 0.3
"""Longest move of an arm angle, rad."""

ON_LIMIT_OF_CURVE = 1e-11
"""`ON_LIMIT` where strips are curves on the true chain, rad."""

SHORTENED = 3
"""A posture that cannot move so far is moved half as far, and so on, so often in all."""

FARTHEST = 0.5
"""A posture of a strip is no farther, rad, from the straight line between its neighbours."""


@kernel
def put_inside(P, q):
    """A posture with joints that are beyond their limits by rounding put on them, and whether it is inside then.

    On a near limb, where a joint is on its limit, others may have to move far for what that leaves of an error.
    """
    if P[IS_NEAR] != 0.0:
        return settled(P, q, ON_LIMIT_OF_CURVE)
    return settled(P, q, ON_LIMIT)


@kernel
def course_of(P, poses, chain, fixed, bounds, branch):
    """A course with the sides of its postures, or on a near limb with its poses as they are read."""
    is_near = P[IS_NEAR] != 0.0
    course = Course(poses, chain, fixed, bounds, np.empty((poses.shape[0], at.TIP if is_near else at.SIDE)))
    if not is_near:
        write_sides(P, course, branch)
        return course
    for i in range(poses.shape[0]):
        write_tip(row(poses, i), row(course.sides, i))
    return course


@kernel
def posture_at(line, i):
    """The posture of a path at a pose."""
    return Posture(read7(row(line.q, i)), line.psi[i], line.branch[i])


@kernel
def stop_of(course, i):
    """What a course tells of one of its poses."""
    return Stop(row(course.poses, i), row(course.bounds, i), row(course.sides, i))


@kernel
def moving_rates(P, stop, here, J, A):
    """Joint rates with the arm angle, on a near limb along its curve, and whether there are any."""
    if P[IS_NEAR] != 0.0:
        return direction(P, setting_of(P, target_of(P, stop.pose), J, A), here.q)
    return rates(P, here.q, load3(stop.side, at.SIDE_LINE), load3(stop.side, at.SIDE_FOREARM))


@kernel
def moved_by(P, stop, here, motion, J, A):
    """The posture with its arm angle moved, on a near limb so far along its curve."""
    v, move = motion
    if P[IS_NEAR] != 0.0:
        return moved_along(P, setting_of(P, target_of(P, stop.pose), J, A), here.q, v, move)
    return posture_of(P, read_side(stop.side), here.psi + move, here.branch, here.q, True)


@kernel
def beside(P, stop, here, motion, J, A):
    """The posture moved on, or half as far, or a quarter: posture, arm angle, whether there is one.

    `motion` is the direction of its curve, how far it is to be moved, and the longest joint step.
    """
    v, move, longest = motion
    for _ in range(SHORTENED):
        there = min(max(here.psi + move, stop.bounds[0]), stop.bounds[1])
        if there == here.psi:
            break
        moved, good = moved_by(P, stop, here, (v, there - here.psi), J, A)
        moved, inside = put_inside(P, moved)
        if good and inside and apart(moved, here.q) < longest:
            return moved, there, True
        move *= 0.5
    return here.q, here.psi, False


@kernel
def put_along_curve(P, stop, here, motion, sheet, n, space):
    """`put_across` on a near limb, the postures taken to their curve in step; `motion` as in `beside`."""
    v, move, longest = motion
    far = (eight_of(0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 4.0) - float(WIDTH)) * move
    aside, met = moved_eight(P, load_pose(stop.side, 0), here.q, (v, far))
    aside, inside = within(P, aside, ON_LIMIT_OF_CURVE)
    met &= inside & as_bits(largest_of(along7(aside, -1.0, here.q)) < longest)
    for k in range(ACROSS):
        x = float(k - WIDTH)
        if k == WIDTH:
            put_node(sheet.nodes, n, here.q, here.psi, here.branch)
            n += 1
        elif met >> k & 1:
            put_node(sheet.nodes, n, one_of_seven(aside, k), here.psi, here.branch)
            n += 1
        else:
            moved, there, found = beside(P, stop, here, (v, x * move, longest), space.J, space.A)
            if found:
                put_node(sheet.nodes, n, moved, there, here.branch)
                n += 1
    return n


@kernel
def put_across(P, course, line, asked, sheet, n, space):
    """Write the postures of a corridor at a pose, that of the path in the middle; the next free row.

    `asked` are the number of the pose and the joint step from one posture of the corridor to the next.
    """
    i, width = asked
    here = posture_at(line, i)
    nodes = sheet.nodes
    if course.fixed[i]:
        put_node(nodes, n, here.q, here.psi, here.branch)
        return n + 1
    split, is_singular = split_of(P, here.q)
    stop = stop_of(course, i)
    v, good = moving_rates(P, stop, here, space.J, space.A)
    move = min(width / max(largest(v), 1e-3), WIDEST_MOVE)
    if good and P[IS_NEAR] != 0.0:
        return put_along_curve(P, stop, here, (v, move, 4.0 * WIDTH * width), sheet, n, space)
    for k in range(ACROSS):
        x = float(k - WIDTH)
        if k == WIDTH:
            put_node(nodes, n, here.q, here.psi, here.branch)
            n += 1
        elif is_singular:
            turned, inside = along_split(P, here.q, split, x * width)
            if inside:
                put_node(nodes, n, turned, here.psi, here.branch)
                n += 1
        elif good:
            moved, there, found = beside(P, stop, here, (v, x * move, 4.0 * WIDTH * width), space.J, space.A)
            if found:
                put_node(nodes, n, moved, there, here.branch)
                n += 1
    return n


@kernel
def corridor(family, course, line, width, start, rules, space):
    """Move the postures of a path, in place, to the best way through the corridor around them.

    `width` is the joint step from one posture of the corridor to the next, rad, `start` (k, 7) the posture before the
    first one, or none; `rules` are those of a step over one pose.
    """
    P = row(family, LIMITED)
    chain = course.chain
    count = chain.shape[0]
    room = count * ACROSS
    sheet = Sheet(
        np.empty((room, at.NODE)), np.ones(room, np.bool_), np.full(room, at.IMPOSSIBLE), np.empty((count, at.STRIP))
    )
    ends = np.zeros(count + 1, np.int64)
    scaled = copied(rules.settings, row(scratch(SETTINGS, 7), 0))
    for c in range(count):
        i = chain[c]
        ends[c + 1] = put_across(P, course, line, (i, width), sheet, ends[c], space)
        list_strips(sheet, ends[c], ends[c + 1], c)
        now = Span(ends[c], ends[c + 1], c, c + 1)
        if c == 0:
            first_costs(sheet, now, start, rules.settings)
            continue
        stepped = rules_for(rules.settings, scaled, i - chain[c - 1], rules.limited)
        advance(sheet, Span(ends[c - 1], ends[c], c - 1, c), now, stepped, True)
    for c in range(count - 1, -1, -1):
        i = chain[c]
        if c == count - 1:
            best = float(cheapest(sheet.cost, ends[c], ends[c + 1]))
        else:
            stepped = rules_for(rules.settings, scaled, chain[c + 1] - i, rules.limited)
            _, best = step_back(row(line.q, chain[c + 1]), sheet, Span(ends[c], ends[c + 1], c, c + 1), stepped)
        if not course.fixed[i]:
            settle_on(P, course, line, i, sheet.nodes, best, space)


@kernel
def on_pose(P, stop, here, J, A):
    """The posture at an arm angle next to one that almost meets its pose, on a near limb the nearest one."""
    if P[IS_NEAR] != 0.0:
        target = target_of(P, stop.pose)
        v, good = direction(P, setting_of(P, target, J, A), here.q)
        if good:
            q, good = moved_along(P, setting_of(P, target, J, A), here.q, v, 0.0)
            _, inside = put_inside(P, q)
            if good and inside:
                return q, True
        q, error = close_free(P, here.q, target.R, target.p, True, 2 * STEPS, J, A)
        return q, error < CLOSED
    return posture_of(P, read_side(stop.side), here.psi, here.branch, here.q, True)


@kernel
def settle_on(P, course, line, i, nodes, best, space):
    """Take the posture at a place between two of a corridor, or the nearer one of them."""
    k = math.floor(best)
    t = best - k
    following = k + 1 if t > 0.0 else k
    nearer = read7(row(nodes, k if t < 0.5 else following))
    angle = nodes[k if t < 0.5 else following, at.NODE_PSI]
    if t > 0.0:
        a, b = read7(row(nodes, k)), read7(row(nodes, following))
        between = along7(a, t, along_cell(a, b))
        there = nodes[k, at.NODE_PSI] + t * (nodes[following, at.NODE_PSI] - nodes[k, at.NODE_PSI])
        _, is_singular = split_of(P, between)
        if is_singular and nodes[k, at.NODE_PSI] == nodes[following, at.NODE_PSI]:
            nearer = between
        else:
            wanted = Posture(between, there, line.branch[i])
            found, good = on_pose(P, stop_of(course, i), wanted, space.J, space.A)
            found, inside = put_inside(P, found)
            if good and inside and apart(found, between) < apart(a, b) + 0.1:
                nearer, angle = found, there
    line.psi[i] = angle
    store7(row(line.q, i), 0, nearer)


@kernel
def put_on_poses(family, course, line, space):
    """Bring postures from the straight lines between those of a strip to their poses; whether all could be."""
    P = row(family, LIMITED)
    all_good = True
    for c in range(course.chain.shape[0]):
        i = course.chain[c]
        here = posture_at(line, i)
        _, is_singular = split_of(P, here.q)
        if course.fixed[i] or is_singular:
            continue
        found, good = on_pose(P, stop_of(course, i), here, space.J, space.A)
        found, inside = put_inside(P, found)
        good = good and inside and apart(found, here.q) < FARTHEST
        all_good = all_good and good
        if good:
            store7(row(line.q, i), 0, found)
    return all_good
