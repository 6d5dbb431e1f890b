"""All cells of a pose, and finer ones in the place of some."""

import math

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.curves.follow import between, end_at
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.limb import IS_NEAR, LIMITED
from srs_ik.kernels.layout.path import CELL_BRANCH, CELL_FROM, CELL_OFF, CELL_TO, CURVE, NODE_PSI, POINT, Around
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.triangle import elbow_side, target_of
from srs_ik.kernels.path.cells import FREE, SLACK, may_be_inside, put_cell, put_turns, stray, stray_near
from srs_ik.kernels.path.followed import along_cell, posture_of
from srs_ik.kernels.path.near_strips import setting_of
from srs_ik.kernels.path.pose_strips import pose_strips, roomy
from srs_ik.kernels.path.strips import put_node

WIDEST = 0.7
"""Farthest apart in arm angle, rad."""

OFF_SHARE = 0.1
"""The postures of a cell may be off it by this part of its longest length ..."""

NARROWEST = 1e-13
"""... unless its arm angles are closer than this, rad."""

DEEPEST = 60

MOST = 100
"""A piece is cut into so many cells at most: where joints may turn on the spot all along, cutting does not help."""


@kernel
def length_of(d):
    """Length of a chord."""
    return math.sqrt(dot7(d, d))


@kernel
def cover_pose(family, T, net, n, J, A):
    """Write cells that hold all postures of a pose from row n on; the next free row."""
    P = row(family, LIMITED)
    target = target_of(P, T)
    if P[IS_NEAR] != 0.0:
        return cover_curves(family, T, target, net, n, J, A)
    if not abs(target.place[5]) < SOLVED:
        return n
    sides = (elbow_side(P, target.place, 0), elbow_side(P, target.place, 1))
    found = net.desk.found
    for i in range(find_intervals(roomy(family, target.place), target.place, -1, found)):
        branch = int(found[i, 0])
        n = cover_interval(P, sides[branch >> 2], branch, (found[i, 1], found[i, 2]), net, n)
    return n


@kernel
def cover_interval(P, side, branch, ends, net, n):
    """Write the cells of an interval of an exact limb from row n on; the next free row."""
    lower, upper = ends
    q, good = posture_of(P, side, lower, branch, NO_SEED, False)
    if not good:
        return n
    if not upper > lower:
        return put_turns(P, net.cells, n, q, q, SLACK, (lower, lower, float(branch)))
    count = math.ceil((upper - lower) / WIDEST)
    begin = lower
    for i in range(1, count + 1):
        end = lower + (upper - lower) * i / count if i < count else upper
        n, q = cover_piece(P, side, branch, (begin, end, q), net, n)
        begin = end
    return n


@kernel
def cover_piece(P, side, branch, piece, net, n):
    """Write the cells between two arm angles, halved until each is short and close to its curve.

    `piece` are both arm angles and the posture at the first one. Returns the next free row and the last posture.
    """
    psi, end, q = piece
    stack, cells = net.desk.stack, net.cells
    put_node(stack, 0, q, end, branch)
    top = 0
    enough = n + MOST
    while top >= 0 and n < cells.shape[0]:
        ahead = stack[top, NODE_PSI]
        wanted, _ = posture_of(P, side, ahead, branch, q, True)
        off = FREE
        is_long = length_of(along_cell(q, wanted)) > net.longest
        if not is_long:
            off = stray(P, side, (psi, ahead), branch, q, wanted)
            is_long = off > OFF_SHARE * net.longest
        middle = 0.5 * (psi + ahead)
        narrow = ahead - psi <= NARROWEST * max(1.0, abs(psi)) or not psi < middle < ahead
        if is_long and not narrow and top + 1 < DEEPEST and n < enough:
            top += 1
            put_node(stack, top, wanted, middle, branch)
            continue
        told = (psi, ahead, float(branch))
        if net.all_turns:
            n = put_turns(P, cells, n, q, wanted, off, told)
        elif may_be_inside(P, q, wanted, off):
            put_cell(cells, n, q, wanted, off, told)
            n += 1
        q, psi = wanted, ahead
        top -= 1
    return n, q


@kernel
def cover_curves(family, T, target, net, n, J, A):
    """Write the cells of a near limb's curves, between the postures of its strips; the next free row."""
    P = row(family, LIMITED)
    nodes, linked = net.sheet.nodes, net.sheet.linked
    last = pose_strips(family, T, Around(NO_SEED, 0.0, 0.0), net.sheet, 0, net.desk, J, A)
    for i in range(last):
        if n >= net.cells.shape[0]:
            break
        a = read7(row(nodes, i))
        if linked[i] and i + 1 < last:
            n = cover_curve(P, target, (a, read7(row(nodes, i + 1))), net, n, J, A)
        elif i == 0 or not linked[i - 1]:
            put_cell(net.cells, n, a, a, SLACK, (0.0, 0.0, float(POINT)))
            n += 1
    return n


@kernel
def cover_curve(P, target, ends, net, n, J, A):
    """Write the cells of a piece of a near limb's curve between two postures; the next free row."""
    a, b = ends
    d = along_cell(a, b)
    count = math.ceil(length_of(d) / net.longest)
    by = setting_of(P, target, J, A)
    start, end = end_at(P, by, a), end_at(P, by, b)
    q = a
    for part in range(1, count + 1):
        wanted = b
        if part < count:
            inner, met = between(P, by, start, end, part / count)
            wanted = along7(q, 1.0, difference(q, inner)) if met else along7(a, part / count, d)
        if n >= net.cells.shape[0]:
            break
        put_cell(net.cells, n, q, wanted, stray_near(P, target, q, wanted, J, A), (0.0, 0.0, float(CURVE)))
        n += 1
        q = wanted
    return n


@kernel
def cut_cell(family, target, cell, net, n, J, A):
    """Write finer cells in the place of one (a row), or the same; the next free row."""
    P = row(family, LIMITED)
    branch = int(cell[CELL_BRANCH])
    a = read7(cell)
    b = along7(a, 1.0, read7(row(cell, 7)))
    is_small = length_of(along_cell(a, b)) <= net.longest and cell[CELL_OFF] <= OFF_SHARE * net.longest
    if P[IS_NEAR] != 0.0 and branch == CURVE and not is_small:
        return cover_curve(P, target, (a, b), net, n, J, A)
    if (
        branch < 0
        or is_small
        or cell[CELL_OFF] >= FREE
        or cell[CELL_TO] - cell[CELL_FROM] <= NARROWEST * max(1.0, abs(cell[CELL_FROM]))
    ):
        put_cell(net.cells, n, a, b, cell[CELL_OFF], (cell[CELL_FROM], cell[CELL_TO], float(branch)))
        return n + 1
    side = elbow_side(P, target.place, branch >> 2)
    n, _ = cover_piece(P, side, branch, (cell[CELL_FROM], cell[CELL_TO], a), net, n)
    return n
