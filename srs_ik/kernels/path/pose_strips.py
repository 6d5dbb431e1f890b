"""All strips of a pose: of its feasible intervals, and of the turns of joints that have more than one."""

import math

from srs_ik.kernels.algebra.joint_vectors import along7, short_way
from srs_ik.kernels.algebra.pointers import copy, read7, row
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.exact.flat import is_as_good_as_flat
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import path as at
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.limb import BOTTOM_GAP, IS_NEAR, LIMITED, LOWER, PHASE, SHOULDER, TOP_GAP, UPPER, WRIST
from srs_ik.kernels.limb.in_line import closest, may_split
from srs_ik.kernels.limb.limits import TURN
from srs_ik.kernels.limb.triangle import elbow_side, target_of
from srs_ik.kernels.path.followed import along_cell, settled
from srs_ik.kernels.path.near_strips import take_line, take_runs
from srs_ik.kernels.path.splits import SPLIT, put_splits
from srs_ik.kernels.path.strips import ROUNDING, fill_ends, is_wide, put_node, take_strip

SAME_ELBOW = 1e-5
"""Elbow angles this close, rad, are of one elbow branch ..."""

BENT = 1e-2
"""... if the sine of the elbow's bend is larger than this."""

NEXT_TO = 1e-5
"""An interval that ends so close to a singular arm angle, rad, ends there."""


@kernel
def pose_strips(family, T, around, sheet, n, desk, J, A):
    """Write the postures of a pose from row n on, finer around one of them; the next free row.

    Loose tolerances find also the arm angles that two joints on their limits leave alone.
    """
    P = row(family, LIMITED)
    target = target_of(P, T)
    place_ = target.place
    if P[IS_NEAR] != 0.0:
        first = n
        if around.radius > 0.0:
            n = take_line(P, target, around, sheet, n, J, A)
        else:
            n = take_runs(P, target, sheet, n, J, A)
        return within_limits(P, sheet, first, n, desk)
    if not abs(place_[5]) < SOLVED:
        return n
    sides = (elbow_side(P, place_, 0), elbow_side(P, place_, 1))
    return branch_strips(family, place_, sides, around, sheet, n, desk)


@kernel
def roomy(family, place_):
    """The limb with limits drawn out by what rounding does to a pose: two joints on limits leave no room else."""
    return row(family, at.ROOMIEST if is_as_good_as_flat(place_) else at.ROOMY)


@kernel
def allowed_intervals(family, place_, desk):
    """Write the intervals of all branches into `desk.found`, or those that are given."""
    if desk.given[0] < 0:
        return find_intervals(roomy(family, place_), place_, -1, desk.found)
    count = min(desk.given[1] - desk.given[0], desk.found.shape[0])
    copy(row(desk.allowed, desk.given[0]), row(desk.found, 0), 3 * count)
    return count


@kernel
def branch_strips(family, place_, sides, around, sheet, n, desk):
    """Write the postures of the intervals of all branches; the next free row."""
    P = row(family, LIMITED)
    splits = may_split(P, place_)
    count = allowed_intervals(family, place_, desk)
    if count > 0:
        fill_ends(P, sides, desk.found, count, desk.ends)
    for i in range(count):
        branch = int(desk.found[i, 0])
        side = sides[0] if branch < 4 else sides[1]
        if around.radius > 0.0 and not may_be_near(P, side, branch, around):
            continue
        begin, end = desk.found[i, 1], desk.found[i, 2]
        if splits:
            begin, end = to_singular(P, side, begin, end)
        middle, wide = window(P, place_, side, around)
        for turn in range(-1, 2):
            lower = max(begin, middle + TURN * turn - wide)
            upper = min(end, middle + TURN * turn + wide)
            if lower <= upper:
                first = n
                n = take_strip(P, side, (branch, lower, upper, row(desk.ends, 2 * i)), around, sheet, n, desk)
                n = put_splits(P, sheet, first, within_limits(P, sheet, first, n, desk), around)
            if wide == math.inf:
                break
    return n


@kernel
def next_to_singular(P, side, psi):
    """The end of an interval, or the arm angle next to it at which shoulder or wrist are singular.

    Limits that are drawn out let an interval go on past a singular posture on a limit, where two joints turn at once.
    """
    for i in range(4):
        k = SHOULDER if i < 2 else WRIST
        if P[k + (TOP_GAP if i % 2 == 0 else BOTTOM_GAP)] == 0.0:
            there, least, most = closest(P, k, side[1] if i < 2 else side[2], i % 2)
            if least < SPLIT and most > NEXT_TO:
                off = short_way(there - psi)
                if abs(off) < NEXT_TO:
                    return psi + off
    return psi


@kernel
def to_singular(P, side, begin, end):
    """`next_to_singular` for both ends of an interval, or for the nearer one alone where both are next to the same."""
    first, last = next_to_singular(P, side, begin), next_to_singular(P, side, end)
    if first < last:
        return first, last
    return (begin, last) if last - begin > first - end else (first, end)


@kernel
def window(P, place_, side, around):
    """Middle and half width of the arm angles at which one elbow branch may be near a posture.

    The upper arm turns with the arm angle, and no farther than its three joints together.
    """
    if around.radius == 0.0 or 3.0 * around.radius > math.pi or abs(short_way(side[0] - around.q[3])) > SAME_ELBOW:
        return 0.0, math.inf
    if not place_[3] > BENT:
        return 0.0, math.inf
    return arm_angle(P, around.q, place_[0], place_[1]), 3.0 * around.radius + SAME_ELBOW


@kernel
def may_be_near(P, side, branch, around):
    """Whether a branch may have postures about a given one: joints 2, 4 and 6 lie to its side, or close."""
    if abs(short_way(side[0] - around.q[3])) > around.radius:
        return False
    return is_on_side(P[SHOULDER + PHASE], around.q[1], (branch >> 1) & 1, around.radius) and is_on_side(
        P[WRIST + PHASE], around.q[5], branch & 1, around.radius
    )


@kernel
def is_on_side(phase, angle, sign, radius):
    """Whether a joint angle is above its phase (sign 0) or below it (1), or that close to it."""
    x = short_way(angle - phase)
    return min(abs(x), math.pi - abs(x)) < radius or (x < 0.0) == (sign == 1)


@kernel
def within_limits(P, sheet, first, last, desk):
    """Keep the postures inside the limits, in all turns of joints that have more than one; the next free row."""
    for joint in range(7):
        if is_wide(P, joint):
            return turn_strips(P, sheet, first, last, desk.turns)
    return keep_inside(P, sheet.nodes, sheet.linked, first, last)


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
        put_node(nodes, n, q, nodes[i, at.NODE_PSI], nodes[i, at.NODE_BRANCH])
        linked[n] = linked[i]
        n += 1
    return n


@kernel
def turns_inside(P, joint, nodes, n0, n1):
    """First and last whole turn by which a joint of a run of postures may be turned to be inside its limits."""
    least, most = nodes[n0, joint], nodes[n0, joint]
    for i in range(n0 + 1, n1):
        least = min(least, nodes[i, joint])
        most = max(most, nodes[i, joint])
    first = math.ceil((P[LOWER + joint] - most - ROUNDING) / TURN)
    last = math.floor((P[UPPER + joint] - least + ROUNDING) / TURN)
    return int(first), int(last)


@kernel
def part_inside(P, a, b):
    """The part of the way from a posture inside the limits to one outside that is inside."""
    t = 1.0
    for j in range(7):
        d = b[j] - a[j]
        if b[j] > P[UPPER + j] and d > 0.0:
            t = min(t, (P[UPPER + j] - a[j]) / d)
        elif b[j] < P[LOWER + j] and d < 0.0:
            t = min(t, (P[LOWER + j] - a[j]) / d)
    return max(t, 0.0)


@kernel
def put_end(P, inner, outer, sheet, n, follows):
    """Append the last posture inside the limits on the way from row `inner` to row `outer`; the next free row."""
    nodes = sheet.nodes
    a, b = read7(row(nodes, inner)), read7(row(nodes, outer))
    t = part_inside(P, a, b)
    if n >= nodes.shape[0] or t == 0.0:
        return n
    q, _ = settled(P, along7(a, t, along_cell(a, b)), ROUNDING)
    put_node(nodes, n, q, nodes[inner, at.NODE_PSI] + t * (nodes[outer, at.NODE_PSI] - nodes[inner, at.NODE_PSI]), 0.0)
    nodes[n, at.NODE_BRANCH] = nodes[inner, at.NODE_BRANCH]
    sheet.linked[n] = False
    if follows:
        sheet.linked[n - 1] = True
    return n + 1


@kernel
def put_turned(P, sheet, first, last, turns, n):
    """Append a run of postures, joints turned by whole turns, as far as they are inside the limits then.

    Where a linked pair has one posture inside alone, the run goes on to the limit between them.
    """
    nodes, linked = sheet.nodes, sheet.linked
    room = nodes.shape[0] - 2
    before = False
    for i in range(first, last):
        turned = along7(read7(row(nodes, i)), TURN, turns)
        q, inside = settled(P, turned, ROUNDING)
        follows = i > first and linked[i - 1]
        if follows and inside != before and n < room:
            # Rows behind those in use hold the pair as it is turned.
            other = along7(read7(row(nodes, i - 1)), TURN, turns)
            put_node(nodes, room, other, nodes[i - 1, at.NODE_PSI], nodes[i, at.NODE_BRANCH])
            put_node(nodes, room + 1, turned, nodes[i, at.NODE_PSI], nodes[i, at.NODE_BRANCH])
            n0 = n
            if inside:
                n = put_end(P, room + 1, room, sheet, n, False)
                before = n > n0
            else:
                n = put_end(P, room, room + 1, sheet, n, True)
        if inside and n < room:
            put_node(nodes, n, q, nodes[i, at.NODE_PSI], nodes[i, at.NODE_BRANCH])
            linked[n] = False
            if before and follows:
                linked[n - 1] = True
            n += 1
        before = inside
    return n


@kernel
def turn_strips(P, sheet, first, last, turns):
    """Replace a run of postures by one run for each combination of turns inside the limits; the next free row.

    `turns` (3, 7) is work space: the turns of a run, the first ones, and how many there are.
    """
    nodes, linked = sheet.nodes, sheet.linked
    total = 1
    for joint in range(7):
        turns[1, joint] = 0.0
        turns[2, joint] = 1.0
        if is_wide(P, joint):
            low, high = turns_inside(P, joint, nodes, first, last)
            turns[1, joint] = low
            turns[2, joint] = max(high - low + 1, 0)
        total *= int(turns[2, joint])
    n = last
    for number in range(total):
        rest = number
        for joint in range(7):
            count = int(turns[2, joint])
            turns[0, joint] = turns[1, joint] + rest % count
            rest //= count
        n = put_turned(P, sheet, first, last, row(turns, 0), n)
    copy(row(nodes, last), row(nodes, first), at.NODE * (n - last))
    for i in range(last, n):
        linked[first + i - last] = linked[i]
    return first + n - last


@kernel
def list_strips(sheet, first, last, count):
    """Measure the strips among the postures of rows first to last - 1 and list them; returns how many there are."""
    nodes, strips = sheet.nodes, sheet.strips
    start = first
    for i in range(first, last):
        if sheet.linked[i] and i + 1 < last:
            continue
        if count < strips.shape[0]:
            for j in range(7):
                least, most = nodes[start, j], nodes[start, j]
                for k in range(start + 1, i + 1):
                    least = min(least, nodes[k, j])
                    most = max(most, nodes[k, j])
                strips[count, j], strips[count, 7 + j] = least, most
            strips[count, at.STRIP_FIRST], strips[count, at.STRIP_LAST], strips[count, at.STRIP_LEAST] = start, i, 0.0
            count += 1
        start = i + 1
    return count
