"""What a path may touch that costs no more than one at hand: finer strips there, and none elsewhere.

Between two postures of a strip joint angles are taken as straight, so a plan costs less than any path, the more so the
coarser its strips are. What a path costs from a posture on, found by the programme from the last pose back, added to
what it costs up to there, leaves most strips out; what is left may be fine.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import path_bound as entries
from srs_ik.kernels.layout.path import HELD_LINKED, NODE_SAG, STRIP_FIRST, STRIP_LEAST
from srs_ik.solve.path_blocks import Block, Carry, carried, find_way
from srs_ik.solve.path_problem import Problem, Stopped, Way

Array = NDArray[np.float64]
Marks = NDArray[np.bool_]

SAGGED = 0.25
"""Between two postures costs lie below those of both by at most this part of how far they sag."""

FINE = 3.0
"""Strips are fine so far around, rad: everywhere, for whole turns are left out."""

AT_ENDS = 1e-9
"""Rounding of arm angles, rad."""


@dataclass
class Part:
    """Intervals of some poses: branch, least and largest arm angle (k, 3), their poses (k,), ends of strips (k, 2)."""

    rows: Array
    poses: NDArray[np.int64]
    strips: Array


@dataclass
class Rest:
    """Of each block, what a path costs from each posture on (m, 2), and how far that sags to the next one.

    Left out are postures through which no path leads that costs at most `most`.
    """

    after: list[Array]
    most: float


def find_narrow(
    problem: Problem, keys: NDArray[np.int64], blocks: list[Block], rest: Rest, way: Way, asked: Problem | None = None
) -> Way:
    """The best way through fine strips of what a path may touch that costs as little as is asked for.

    Args:
        problem: the path that is asked for, on an exact limb.
        keys: (k,) the poses that count.
        blocks: their strips, as they were planned.
        rest: what a path costs from their postures on, by `costs_to_end`, and what it may cost.
        way: the path at hand.
        asked: what is asked for in fine strips, and how fine they are, if it is more than by `problem`.
    """
    parts = [kept(block, costs, rest.most) for block, costs in zip(blocks, rest.after, strict=True)]
    rows, poses = np.vstack([part.rows for part in parts]), np.concatenate([part.poses for part in parts])
    free = np.split(rows, np.searchsorted(poses, np.arange(1, len(problem.T))))
    told = replace(problem, radius=FINE) if asked is None else asked
    found = find_way(replace(told, near=way.q, free=free), keys, False)
    # Intervals that are cut have ends that are none of the strip.
    strips = np.vstack([part.strips for part in parts])
    psi = found.psi[poses]
    own = (rows[:, 0] == found.branch[poses]) & (psi >= strips[:, 0] - AT_ENDS) & (psi <= strips[:, 1] + AT_ENDS)
    found.bounds[:] = np.inf, -np.inf
    np.minimum.at(found.bounds[:, 0], poses[own], np.where(strips[own, 0] > -np.pi, strips[own, 0], -np.inf))
    np.maximum.at(found.bounds[:, 1], poses[own], np.where(strips[own, 1] < np.pi, strips[own, 1], np.inf))
    found.bounds[found.bounds[:, 0] > found.bounds[:, 1]] = -np.inf, np.inf
    return found


def costs_to_end(problem: Problem, blocks: list[Block], most: float) -> Rest:
    """What a path that costs at most so much costs from each posture on."""
    behind: Carry | None = None
    found = []
    for block in reversed(blocks):
        nodes, cost, strips, ends = block.fill()
        n, m, count = ends[block.count, 1], ends[block.count, 3], block.count
        nodes, cost, strips, after = nodes[:n].copy(), cost[:n], strips[:m].copy(), np.empty(n)
        rows = np.vstack([ends[: count + 1], np.zeros((1, 4), np.int64)])
        if behind is not None:
            rows[-1] = n, n + len(behind.nodes), m, m + len(behind.strips)
            own = behind.strips.copy()
            own[:, STRIP_FIRST:STRIP_LEAST] += n
            nodes, strips = np.vstack([nodes, behind.nodes]), np.vstack([strips, own])
            cost, after = np.append(cost, behind.cost), np.append(after, behind.cost)
        pose = -1 if behind is None else behind.pose
        told = problem.stop, problem.settings, problem.limited
        arrays = nodes, cost, strips, rows, after
        at = entries.costs_to_end(block.keys, block.first, count, pose, most, *told, *arrays)
        if problem.stop[0]:
            raise Stopped
        if at <= count:
            behind = carried(int(block.keys[block.first + at - 1]), rows[at], nodes, after, strips)
        first = ends[1, 0]
        found.append(np.column_stack([after[first:n], nodes[first:n, NODE_SAG]]))
    return Rest(found[::-1], most)


def held_below(problem: Problem, keys: NDArray[np.int64], blocks: list[Block], rest: Rest, most: float) -> Problem:
    """The problem with those postures of blocks known through which a path may lead that costs at most so much.

    `rest` is for paths that cost as much or more.
    """
    found, alone = [], np.zeros(len(problem.T), np.bool_)
    for block, costs in zip(blocks, rest.after, strict=True):
        rows, poses = block.held()
        some, cells = touched(block.linked(), block, costs, most)
        rows[:, HELD_LINKED] = cells
        found.append((rows[some], poses[some]))
    alone[keys] = True
    rows, poses = (np.concatenate(each) for each in zip(*found, strict=True))
    return replace(problem, held=rows, held_of=poses, held_alone=alone)


def touched(linked: Marks, block: Block, after: Array, most: float) -> tuple[Marks, Marks]:
    """Of a block's postures, those that such a path may touch, and those from which it may lie towards the next one."""
    cost, sag = block.costs()
    total = cost + after[:, 0]
    following = np.append(total[1:], np.inf)
    cells = linked & (np.minimum(total, following) - SAGGED * (sag + after[:, 1]) <= most)
    return (total <= most) | cells | np.append(False, cells[:-1]), cells


def kept(block: Block, after: Array, most: float) -> Part:
    """The intervals of a block through which a path may lead that costs at most so much."""
    linked, (angles, branches) = block.linked(), block.places()
    some, cells = touched(linked, block, after, most)
    some &= branches >= 0.0
    first = np.flatnonzero(some & ~np.append(False, cells[:-1]))
    last = np.flatnonzero(some & ~cells)
    lasts = np.flatnonzero(~linked)
    firsts = np.append(0, lasts[:-1] + 1)
    of = np.searchsorted(lasts, first)
    intervals = np.column_stack([branches[first], angles[first], angles[last]])
    return Part(intervals, block.poses()[first], np.column_stack([angles[firsts[of]], angles[lasts[of]]]))
