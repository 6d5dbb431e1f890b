"""Entry points for what no path through some poses costs less than."""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.entries.path import MOST_NODES, MOST_STRIPS
from srs_ik.kernels.exact.samples import MAX_SAMPLES
from srs_ik.kernels.jit import entry, kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.layout.path import (
    IMPOSSIBLE,
    MEMO,
    NODE,
    POINT,
    STRIP,
    WORTH_BEGIN,
    WORTH_END,
    WORTH_SAG,
    Desk,
    Net,
    Sheet,
)
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.path.cells import SLACK, put_cell
from srs_ik.kernels.path.corridor import spot_of
from srs_ik.kernels.path.cover import cover_pose, cut_cell
from srs_ik.kernels.path.reached import MOST_CORNERS, reach_cell
from srs_ik.kernels.path.relaxed import GROUP, advance_cell, write_groups
from srs_ik.kernels.path.strips import DEEPEST


@entry
def cover(family, poses, first, known, has_known, extra, longest, J, A, cells, ends):
    """Write cells that hold all postures of the poses from number `first` on, until the arrays are full.

    Args:
        family: packed limb.
        poses: (n, 4, 4).
        first: number of the first pose.
        known: (n, 7) postures that are given.
        has_known: (n,) where they are.
        extra: (n, 7) a posture of each pose beside those of the intervals, or NaN.
        longest: length of a cell, rad.
        J: (6, 7) work space, or None.
        A: (16, 9) work space, or None.
        cells: (M, CELL) output.
        ends: (K + 1,) output: the first row of each pose and one behind its last.

    Returns:
        How many poses are done.
    """
    net = net_of(cells, longest, True)
    ends[0] = 0
    count = 0
    while first + count < poses.shape[0] and count + 1 < ends.shape[0]:
        i = first + count
        n = ends[count]
        if has_known[i]:
            if n < cells.shape[0]:
                q = read7(row(known, i))
                put_cell(cells, n, q, q, SLACK, (0.0, 0.0, float(POINT)))
            n += 1
        else:
            n = cover_pose(family, row(poses, i), net, n, J, A)
            if n < cells.shape[0] and extra[i, 0] == extra[i, 0]:
                q = read7(row(extra, i))
                put_cell(cells, n, q, q, SLACK, (0.0, 0.0, float(POINT)))
                n += 1
        if n >= cells.shape[0]:
            break
        count += 1
        ends[count] = n
    return count


@entry
def cut(family, poses, coarse, coarse_ends, longest, J, A, cells, ends):
    """Write finer cells (M, CELL) in the place of coarse ones of poses (k, 4, 4), until the array is full.

    Returns how many poses are done.
    """
    net = net_of(cells, longest, False)
    ends[0] = 0
    for i in range(poses.shape[0]):
        n = ends[i]
        spot = spot_of(row(family, LIMITED), row(poses, i))
        for k in range(coarse_ends[i], coarse_ends[i + 1]):
            if n < cells.shape[0]:
                n = cut_cell(family, spot, row(coarse, k), net, n, J, A)
        if n >= cells.shape[0]:
            return i
        ends[i + 1] = n
    return poses.shape[0]


@entry
def relax(cells, ends, backward, settings, worth):
    """Write what the cells of some poses cost at least, from those of the first pose on, which are there already.

    Args:
        cells: (M, CELL).
        ends: (k + 1,) the first row of each pose and one behind its last; the array may end behind them.
        backward: whether from those of the last pose back.
        settings: (SETTINGS, 7); with an infinite step of continuity, a path may leap.
        worth: (M, WORTH) in place.

    A pose without cells is passed for nothing, and so is the step over it.
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
            lowest_of_all = IMPOSSIBLE
            for g in range(least):
                lowest_of_all = min(lowest_of_all, groups[g, 8])
            for j in range(ends[i], ends[i + 1]):
                if gap:
                    begin, end, sag = lowest_of_all, lowest_of_all, 0.0
                else:
                    before = (cells, ends[last], ends[last + 1], worth)
                    begin, end, sag = advance_cell(before, groups, cells, j, row(settings, 0), tried)
                worth[j, WORTH_BEGIN] = begin
                worth[j, WORTH_END] = end
                worth[j, WORTH_SAG] = sag
        last = i


@kernel
def net_of(cells, longest, all_turns):
    """Cells to be made, with work space."""
    sheet = Sheet(
        np.empty((MOST_NODES, NODE)), np.zeros(MOST_NODES, np.bool_), np.empty(1), np.empty((MOST_STRIPS, STRIP))
    )
    found, given = np.empty((8 * MAX_PIECES, 3)), np.full(2, -1)
    held, turns, memo = np.empty((DEEPEST, NODE)), np.zeros((3, 7)), np.empty((0, MEMO))
    desk = Desk(found, np.empty(MAX_SAMPLES), held, turns, np.empty((0, 3)), given, memo, np.zeros(1))
    return Net(cells, longest, all_turns, desk, sheet)


@entry
def reach(cells, ends, backward, limit, settings, spans):
    """Write which part (M, 2) of each cell a path reaches whose steps stay below a limit, from the first pose on.

    What is reached of the first pose (backward: of the last one) is there already. A pose without cells is passed, and
    the pose behind it reached everywhere. An end below its begin says that no part is reached.

    Returns:
        Whether the path goes through.
    """
    count = ends.shape[0] - 1
    work = np.empty((2, MOST_CORNERS, 2))
    last = -1
    some = True
    for step in range(count):
        i = count - 1 - step if backward else step
        if ends[i] == ends[i + 1]:
            continue
        if last >= 0:
            some = False
            for j in range(ends[i], ends[i + 1]):
                begin, end = 1.0, 0.0
                if abs(i - last) > 1:
                    begin, end = 0.0, 1.0
                else:
                    for k in range(ends[last], ends[last + 1]):
                        if spans[k, 0] > spans[k, 1] or (begin == 0.0 and end == 1.0):
                            continue
                        part = (spans[k, 0], spans[k, 1])
                        first, behind = reach_cell(cells, k, part, j, limit, row(settings, 0), work)
                        if first <= behind:
                            begin, end = (min(begin, first), max(end, behind)) if begin <= end else (first, behind)
                spans[j, 0], spans[j, 1] = begin, end
                some = some or begin <= end
            if not some:
                break
        last = i
    return some
