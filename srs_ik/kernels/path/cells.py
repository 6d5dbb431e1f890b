"""Cells of a pose: straight pieces of joint space, and how far from each the postures lie that it stands for.

Every posture of the pose is within `CELL_OFF` of the piece of some cell: what holds for all points so close to the
pieces holds for all postures. Between two arm angles h apart a curve strays from its chord by at most h^2 / 8 times its
largest second derivative, which for a spherical joint the least volume of its three axes bounds:

    w = q1' b1 + q2' b2 + q3' b3  and  b1 q1'' + b2 q2'' + b3 q3'' = -q1' q2' b1 x b2 - q3' w x b3

On the true chain of a near limb, where the curve is followed, the bound is what is measured in the middle of each part.

And what a path can reach of them with joint steps below their limits. From a part s0 to s1 of one cell, the places s
and t between which no joint steps farther are a convex polygon: seven strips cut out of a rectangle. Its extent in t is
what can be reached of the other cell.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, store7
from srs_ik.kernels.algebra.pointers import copy, read7, row
from srs_ik.kernels.algebra.vectors import cross, dot, load3, norm, swing
from srs_ik.kernels.curves.follow import between, end_at
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import A1, A2, A3, BOTTOM_GAP, LOWER, RANGE_KIND, SHOULDER, TOP_GAP, UPPER, WRIST
from srs_ik.kernels.layout.path import CELL, CELL_BRANCH, CELL_FROM, CELL_OFF, CELL_TO
from srs_ik.kernels.limb.limits import TURN
from srs_ik.kernels.limb.spherical import middle_angle
from srs_ik.kernels.path.followed import along_cell, posture_of
from srs_ik.kernels.path.near_strips import setting_of
from srs_ik.kernels.path.steps import step_of, steps_between

PARTS = 4
"""A cell is looked at in so many parts."""

SLACK = 1e-8
"""Rounding of postures, rad: ends of intervals, and what a path is put on its limits by."""

FLAT = 1e-9
"""Volume of three axes below which a spherical joint may turn on the spot."""

FREE = 2.0 * TURN
"""What joints may stray from a cell whose spherical joint may turn on the spot, rad."""

GROUP = 8
"""Cells in a row that are left out together where they are too far away."""

MOST_CORNERS = 40
"""Corners of a polygon, at most."""

BOX = 15
"""The middle of a box (7), half its edges (7), and whether a path reaches anything in it."""

MEASURED = 2.0
"""On a near limb a curve strays at most so many times as far as is measured."""


@kernel
def least_sine(P, k, circle, begin, end):
    """Least |sin(q2 - PHASE)| of the spherical joint at block k between two arm angles."""
    a1 = load3(P, k + A1)
    c, s = dot(a1, circle[1]), dot(a1, circle[2])
    top = math.atan2(s, c)
    least = 1.0
    for i in range(4):
        psi = begin if i == 0 else end
        if i >= 2:
            psi = top if i == 2 else top + math.pi
            psi += TURN * math.ceil((begin - psi) / TURN)
            if psi > end:
                continue
        v = swing(circle, math.cos(psi), math.sin(psi))
        _, sine, _ = middle_angle(P, k, v)
        least = min(least, sine)
    return least


@kernel
def bend_bound(P, k, circle, begin, end):
    """Square of what the second derivatives of the three joints at block k by the arm angle stay below, or infinity.

    `circle` is that of v = R a3 with the arm angle.
    """
    sine = least_sine(P, k, circle, begin, end)
    half = 1.0 - 0.5 * (P[k + TOP_GAP] + P[k + BOTTOM_GAP])
    volume = half * sine
    if volume < FLAT:
        return math.inf
    a1, a2, a3 = load3(P, k + A1), load3(P, k + A2), load3(P, k + A3)
    n12, n23 = norm(cross(a1, a2)), norm(cross(a2, a3))
    # Axes across one another: joint 2 turns no faster than the arm does.
    is_square = P[k + TOP_GAP] < 1e-12 and P[k + BOTTOM_GAP] < 1e-12
    rate1, rate3 = n23 / volume, n12 / volume
    rate2 = 1.0 if is_square else 1.0 / volume
    turned = math.sqrt(dot(circle[1], circle[1]))
    rest = n12 * rate1 * rate2 + turned * rate3
    return rest * rest * (rate1 * rate1 + rate2 * rate2 + rate3 * rate3)


@kernel
def distance_to(q, a, d):
    """Distance of a posture from the piece a to a + d."""
    to_q = along_cell(a, q)
    size = dot7(d, d)
    t = min(max(dot7(to_q, d) / size, 0.0), 1.0) if size > 0.0 else 0.0
    off = along7(to_q, -t, d)
    return math.sqrt(dot7(off, off))


@kernel
def stray(P, side, angles, branch, a, b):
    """How far the postures of a branch between two arm angles may be from the piece from a to b."""
    begin, end = angles
    d = along_cell(a, b)
    width = (end - begin) / PARTS
    most, rest = 0.0, 0.0
    before, good = a, True
    for part in range(1, PARTS + 1):
        psi = begin + part * width
        bend = bend_bound(P, SHOULDER, side[1][0], psi - width, psi)
        bend += bend_bound(P, WRIST, side[2][0], psi - width, psi)
        rest = max(rest, bend)
        if part < PARTS:
            q, met = posture_of(P, side, psi, branch, before, True)
            good = good and met
            most = max(most, distance_to(q, a, d))
            before = q
    if not math.isfinite(rest) or not good:
        return FREE
    return most + 0.125 * width * width * math.sqrt(rest) + SLACK


@kernel
def stray_near(P, target, a, b, J, A):
    """The same of a piece of a curve of a near limb, as it is measured."""
    d = along_cell(a, b)
    by = setting_of(P, target, J, A)
    start, end = end_at(P, by, a), end_at(P, by, b)
    most = 0.0
    for part in range(1, PARTS):
        q, met = between(P, by, start, end, part / PARTS)
        if not met:
            return FREE
        most = max(most, distance_to(along7(a, 1.0, difference(a, q)), a, d))
    return MEASURED * most + SLACK


@kernel
def put_cell(cells, n, a, b, off, told):
    """Write a cell from posture a to b; `told` are its arm angles and its branch."""
    store7(row(cells, n), 0, a)
    store7(row(cells, n), 7, along_cell(a, b))
    cells[n, CELL_OFF] = off
    cells[n, CELL_FROM], cells[n, CELL_TO], cells[n, CELL_BRANCH] = told


@kernel
def may_be_inside(P, a, b, off):
    """Whether postures so close to the piece from a to b may be inside their limits."""
    inside = True
    for j in range(7):
        inside = inside and min(a[j], b[j]) - off <= P[UPPER + j] and max(a[j], b[j]) + off >= P[LOWER + j]
    return inside


@kernel
def put_turns(P, cells, n, a, b, off, told):
    """Write a cell in all turns of joints that have limits more than a turn apart; the next free row.

    A cell that no turn takes near the limits is left out.
    """
    first = n
    if n >= cells.shape[0]:
        return n
    put_cell(cells, n, a, b, off, told)
    n += 1
    for j in range(7):
        if P[RANGE_KIND + j] != 0.0 or not math.isfinite(P[LOWER + j]) or not math.isfinite(P[UPPER + j]):
            continue
        low, high = min(a[j], b[j]) - off, max(a[j], b[j]) + off
        least = math.ceil((P[LOWER + j] - high) / TURN)
        most = math.floor((P[UPPER + j] - low) / TURN)
        last = n
        for turn in range(least, most + 1):
            if turn == least:
                continue
            for i in range(first, last):
                if n >= cells.shape[0]:
                    return n
                copy(row(cells, i), row(cells, n), CELL)
                cells[n, j] += TURN * turn
                n += 1
        if least > most:
            return first
        for i in range(first, last):
            cells[i, j] += TURN * least
    return n


@kernel
def cell_chord(cells, i):
    """From the first posture of a cell to its last."""
    return read7(row(row(cells, i), 7))


@kernel
def cut_polygon(corners, n, a, b, most, spare):
    """Cut off what lies beyond a s + b t = most from a convex polygon of n corners (s, t); how many are left."""
    m = 0
    for i in range(n):
        k = i + 1 if i + 1 < n else 0
        here = most - (a * corners[i, 0] + b * corners[i, 1])
        there = most - (a * corners[k, 0] + b * corners[k, 1])
        if here >= 0.0:
            spare[m, 0], spare[m, 1] = corners[i, 0], corners[i, 1]
            m += 1
        if (here > 0.0 and there < 0.0) or (here < 0.0 and there > 0.0):
            x = here / (here - there)
            spare[m, 0] = corners[i, 0] + x * (corners[k, 0] - corners[i, 0])
            spare[m, 1] = corners[i, 1] + x * (corners[k, 1] - corners[i, 1])
            m += 1
    for i in range(m):
        corners[i, 0], corners[i, 1] = spare[i, 0], spare[i, 1]
    return m


@kernel
def reach_cell(cells, i, part, j, limits, settings, work):
    """What is reached of cell j from the part (s0, s1) of cell i: begin and end, the end below the begin if nothing is.

    `work` (2, MOST_CORNERS, 2) is work space.
    """
    e = steps_between(settings, row(cells, i), row(cells, j))
    d, chord = cell_chord(cells, i), cell_chord(cells, j)
    off = cells[i, CELL_OFF] + cells[j, CELL_OFF]
    for k in range(7):
        if abs(e[k]) > limits[k] + off + abs(d[k]) + abs(chord[k]):
            return 1.0, 0.0
    corners, spare = work[0], work[1]
    for k in range(4):
        corners[k, 0] = part[0] if k in (0, 3) else part[1]
        corners[k, 1] = 0.0 if k < 2 else 1.0
    n = 4
    for k in range(7):
        most = limits[k] + off
        if abs(e[k]) + abs(d[k]) + abs(chord[k]) <= most:
            continue
        n = cut_polygon(corners, n, -d[k], chord[k], most - e[k], spare)
        n = cut_polygon(corners, n, d[k], -chord[k], most + e[k], spare)
        if n == 0:
            return 1.0, 0.0
    first, last = math.inf, -math.inf
    for k in range(n):
        first, last = min(first, corners[k, 1]), max(last, corners[k, 1])
    return first, last


@kernel
def write_boxes(cells, spans, first, last, boxes):
    """Write the boxes about what is reached of the cells first to last - 1, `GROUP` in a row; how many there are."""
    count = (last - first + GROUP - 1) // GROUP
    for g in range(count):
        boxes[g, 14] = 0.0
        for k in range(7):
            low, high = math.inf, -math.inf
            for i in range(first + g * GROUP, min(first + (g + 1) * GROUP, last)):
                if spans[i, 0] <= spans[i, 1]:
                    a, d = cells[i, k], cells[i, 7 + k]
                    one, other = a + spans[i, 0] * d, a + spans[i, 1] * d
                    low = min(low, min(one, other) - cells[i, CELL_OFF])
                    high = max(high, max(one, other) + cells[i, CELL_OFF])
                    boxes[g, 14] = 1.0
            boxes[g, k], boxes[g, 7 + k] = 0.5 * (low + high), 0.5 * (high - low)
    return count


@kernel
def is_out_of_reach(box, cell, limits, settings):
    """Whether no step from inside a box, as short as the limits, leads to a cell."""
    for k in (3, 1, 5, 0, 2, 4, 6):
        chord = cell[7 + k]
        apart = abs(step_of(settings, k, box[k], cell[k] + 0.5 * chord))
        if apart > limits[k] + box[7 + k] + 0.5 * abs(chord) + cell[CELL_OFF]:
            return True
    return False


@kernel
def reach_pose(cells, spans, before, now, limits, settings, boxes, work):
    """Write what is reached of the cells of a pose from those of the pose before; whether anything is.

    `before` and `now` are first and last rows, `boxes` (b, BOX) and `work` (2, MOST_CORNERS, 2) work space.
    """
    count = write_boxes(cells, spans, before[0], before[1], boxes)
    some = False
    for j in range(now[0], now[1]):
        begin, end = 1.0, 0.0
        for g in range(count):
            if boxes[g, 14] == 0.0 or is_out_of_reach(row(boxes, g), row(cells, j), limits, settings):
                continue
            first = before[0] + g * GROUP
            for i in range(first, min(first + GROUP, before[1])):
                if spans[i, 0] > spans[i, 1] or (begin == 0.0 and end == 1.0):
                    continue
                low, high = reach_cell(cells, i, (spans[i, 0], spans[i, 1]), j, limits, settings, work)
                if low <= high:
                    begin, end = (min(begin, low), max(end, high)) if begin <= end else (low, high)
        spans[j, 0], spans[j, 1] = begin, end
        some = some or begin <= end
    return some
