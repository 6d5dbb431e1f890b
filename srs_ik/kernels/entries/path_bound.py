"""Entry points for what no path through some poses costs less than."""

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import dot7
from srs_ik.kernels.algebra.pointers import keep, read7, row, scratch
from srs_ik.kernels.entries.path import MOST_NODES, MOST_STRIPS
from srs_ik.kernels.exact.samples import MAX_SAMPLES
from srs_ik.kernels.jit import entry, kernel
from srs_ik.kernels.layout import path as at
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.layout.path import Desk, Net, Sheet, Span
from srs_ik.kernels.limb.triangle import target_of
from srs_ik.kernels.path.cells import BOX, GROUP, MOST_CORNERS, SLACK, put_cell, reach_pose
from srs_ik.kernels.path.cover import cover_pose, cut_cell
from srs_ik.kernels.path.followed import along_cell
from srs_ik.kernels.path.programme import advance, first_costs, leave_out
from srs_ik.kernels.path.relaxed import advance_cell, write_groups
from srs_ik.kernels.path.steps import rules_for
from srs_ik.kernels.path.strips import DEEPEST


@entry
def cover(family, poses, first, known, has_known, extra, longest, cells, ends):
    """Write cells that hold all postures of the poses from number `first` on, until the arrays are full.

    Postures `known` (n, 7) are given where `has_known` (n,); `extra` (n, 7) is one of each pose beside those of the
    intervals, or NaN. Cells are up to `longest` long, rad; `ends` (K + 1,) are the first row of each pose and one
    behind its last.

    Returns:
        How many poses are done.
    """
    J, A = scratch(6, 7), scratch(16, 9)
    net = net_of(cells, longest, True)
    ends[0] = 0
    count = 0
    while first + count < poses.shape[0] and count + 1 < ends.shape[0]:
        i = first + count
        n = ends[count]
        if has_known[i]:
            if n < cells.shape[0]:
                q = read7(row(known, i))
                put_cell(cells, n, q, q, SLACK, (0.0, 0.0, float(at.POINT)))
            n += 1
        else:
            n = cover_pose(family, row(poses, i), net, n, J, A)
            if n < cells.shape[0] and extra[i, 0] == extra[i, 0]:
                q = read7(row(extra, i))
                put_cell(cells, n, q, q, SLACK, (0.0, 0.0, float(at.POINT)))
                n += 1
        if n >= cells.shape[0]:
            break
        count += 1
        ends[count] = n
    return count


@entry
def cut(family, poses, coarse, coarse_ends, longest, cells, ends):
    """Write finer cells (M, CELL) in the place of coarse ones of poses (k, 4, 4), until the array is full.

    Returns how many poses are done.
    """
    J, A = scratch(6, 7), scratch(16, 9)
    net = net_of(cells, longest, False)
    ends[0] = 0
    for i in range(poses.shape[0]):
        n = ends[i]
        target = target_of(row(family, LIMITED), row(poses, i))
        for k in range(coarse_ends[i], coarse_ends[i + 1]):
            if n < cells.shape[0]:
                n = cut_cell(family, target, row(coarse, k), net, n, J, A)
        if n >= cells.shape[0]:
            return i
        ends[i + 1] = n
    return poses.shape[0]


@entry
def relax(cells, ends, backward, settings, worth):
    """Write what the cells of some poses cost at least, from those of the first pose on, which are there already.

    Or from those of the last pose back. `ends` (k + 1,) are as in `cover`; the array may end behind them. With an
    infinite step of continuity in the settings, a path may leap. A pose without cells is passed for nothing, and so is
    the step over it.
    """
    count = ends.shape[0] - 1
    most = 1
    for i in range(count):
        most = max(most, ends[i + 1] - ends[i])
    groups = np.empty(((most + GROUP - 1) // GROUP, 10))
    tried = np.empty((most, 3))
    last = -1
    for step in range(count):
        i = count - 1 - step if backward else step
        if ends[i] == ends[i + 1]:
            continue
        if last >= 0:
            gap = abs(i - last) > 1
            least = write_groups(cells, ends[last], ends[last + 1], worth, groups)
            lowest_of_all = at.IMPOSSIBLE
            for g in range(least):
                lowest_of_all = min(lowest_of_all, groups[g, 8])
            for j in range(ends[i], ends[i + 1]):
                if gap:
                    begin, end, sag = lowest_of_all, lowest_of_all, 0.0
                else:
                    before = (cells, ends[last], ends[last + 1], worth)
                    begin, end, sag = advance_cell(before, groups, cells, j, row(settings, 0), tried)
                worth[j, at.WORTH_BEGIN], worth[j, at.WORTH_END], worth[j, at.WORTH_SAG] = begin, end, sag
        last = i


@kernel
def write_rooms(sheet, span, most, rooms, rules, after):
    """Write what a path may cost from the postures of a pose on, by what it costs up to them, and their links.

    In `after` it is so much more as costs may sag towards the next posture.
    """
    nodes = sheet.nodes
    for b in range(span.first_strip, span.last_strip):
        first, last = int(sheet.strips[b, at.STRIP_FIRST]), int(sheet.strips[b, at.STRIP_LAST])
        for i in range(first, last + 1):
            sheet.linked[i] = i < last
            sag = max(nodes[i, at.NODE_SAG], nodes[i - 1, at.NODE_SAG] if i > first else 0.0)
            rooms[i] = most - sheet.cost[i] + 0.25 * sag
            sag = 0.0
            for k in range(max(i - 1, first), min(i, last - 1) + 1):
                d = along_cell(row(nodes, k), row(nodes, k + 1))
                sag = max(sag, rules.share * dot7(d, d))
            after[i] = rooms[i] + 0.25 * sag


@entry
def costs_to_end(keys, first, count, behind, most, stop, settings, limited, nodes, cost, strips, ends, after):
    """Write what the best path costs from each posture of `count` key poses from number `first` on, from the last back.

    Postures through which no path leads that costs at most `most` from its begin to its end are left out on the way.
    `behind` is the next pose behind them that is reached; -1: none. Nodes, costs, strips and their ends are those of
    `sweep`, the last row of `ends` that of the pose behind; how far costs sag, and what strips cost at least, is
    written anew. `after` (N,) is the output; what is behind them is known. Another thread sets `stop` (1,) where nobody
    wants the answer.

    Returns:
        The row in `ends` of the first pose that is reached; count + 1: none of these is.
    """
    n = nodes.shape[0]
    sheet, rooms = Sheet(nodes, np.zeros(n, np.bool_), after, strips), np.empty(n)
    forth = Sheet(nodes, sheet.linked, cost, strips)
    scales, told = settings.copy(), row(settings, 0)
    scaled = row(scales, 0)
    last, carried = count + 1, behind
    for slot in range(count, 0, -1):
        if ends[slot, 0] == ends[slot, 1] or stop[0]:
            continue
        now = Span(ends[slot, 0], ends[slot, 1], ends[slot, 2], ends[slot, 3])
        pose = keys[first + slot - 1]
        rules = rules_for(told, scaled, max(carried - pose, 1), limited)
        write_rooms(forth, now, most, rooms, rules, after)
        if carried < 0:
            first_costs(sheet, now, np.empty((0, 7)), told)
        else:
            before = Span(ends[last, 0], ends[last, 1], ends[last, 2], ends[last, 3])
            advance(sheet, before, now, rules, False)
        leave_out(sheet, now, rooms)
        last, carried = slot, pose
    keep(scales)
    return last


@kernel
def net_of(cells, longest, all_turns):
    """Cells to be made, with work space."""
    sheet = Sheet(
        np.empty((MOST_NODES, at.NODE)), np.zeros(MOST_NODES, np.bool_), np.empty(1), np.empty((MOST_STRIPS, at.STRIP))
    )
    found, given = np.empty((8 * MAX_PIECES, 3)), np.full(2, -1)
    held, turns, memo = np.empty((DEEPEST, at.NODE)), np.zeros((3, 7)), np.empty((0, at.MEMO))
    desk = Desk(found, np.empty(MAX_SAMPLES), held, turns, np.empty((0, 3)), given, memo, np.zeros(1), memo)
    return Net(cells, longest, all_turns, desk, sheet)


@entry
def reach(cells, ends, backward, limits, settings, spans):
    """Write which part (M, 2) of each cell a path reaches, joints stepping no farther than their limits (7,).

    It begins at the first pose (backward: at the last one), of which what is reached is there already. A pose without
    cells is passed, and the pose behind it reached everywhere. An end below its begin says that no part is reached.

    Returns:
        Whether the path goes through.
    """
    count, most = ends.shape[0] - 1, 1
    for i in range(count):
        most = max(most, ends[i + 1] - ends[i])
    work, boxes = np.empty((2, MOST_CORNERS, 2)), np.empty(((most + GROUP - 1) // GROUP, BOX))
    last, some = -1, True
    for step in range(count):
        i = count - 1 - step if backward else step
        if ends[i] == ends[i + 1]:
            continue
        if abs(i - last) == 1 and last >= 0:
            before, now = (ends[last], ends[last + 1]), (ends[i], ends[i + 1])
            some = reach_pose(cells, spans, before, now, row(limits, 0), row(settings, 0), boxes, work)
        elif last >= 0:
            for j in range(ends[i], ends[i + 1]):
                spans[j, 0], spans[j, 1] = 0.0, 1.0
        if not some:
            break
        last = i
    return some
