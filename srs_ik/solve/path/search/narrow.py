"""What a path may touch that costs no more than one at hand: finer strips there, and none elsewhere.

Between two postures of a strip joint angles are taken as straight, so a plan costs less than any path, the more so the
coarser its strips are. What a path costs from a posture on, found by the programme from the last pose back, added to
what it costs up to there, leaves most strips out; what is left may be fine.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import path_bound as entries
from srs_ik.kernels.layout.path import HELD_LINKED, NODE_SAG, STRIP_FIRST, STRIP_LEAST
from srs_ik.solve.path.problem import EVERYWHERE, NEAR_SPACING, Problem, Stopped, Way, steps_of
from srs_ik.solve.path.search.blocks import Block, Carry, carried, through
from srs_ik.system.arrays import Array

Marks = NDArray[np.bool_]

SAGGED = 0.25
"""Between two postures costs lie below those of both by at most this part of how far they sag."""

AT_ENDS = 1e-9
"""Rounding of arm angles, rad."""

WIDE_SPACING = 0.4
"""Joints move no farther from one posture of a strip to the next, rad, where much of it may be touched."""

ROOM = 0.05
"""Postures between two of a strip are off their straight line by less than this, rad."""

SPACED = 0.4
"""About such postures, those of a strip are no farther apart than this part of how far around it is looked."""

ONE_CURVE = 1.0
"""Of a path that leads farther than this about a posture, rad, its curve tells little."""

SLIVER = 1e-4
"""An interval of arm angles that is narrower than this, rad, lies between a limit and a singular posture."""


@dataclass
class Part:
    """Intervals of some poses: branch, least and largest arm angle (k, 3), their poses (k,), ends of strips (k, 2)."""

    rows: Array
    poses: NDArray[np.int64]
    strips: Array


@dataclass
class Rest:
    """Of each block, what a path costs from each posture on (m, 2), and how far that sags to the next one.

    Left out are postures through which no path leads that costs at most `most`; `least` is what the best one does.
    """

    after: list[Array]
    most: float
    least: float


def find_narrow(
    problem: Problem,
    keys: NDArray[np.int64],
    blocks: list[Block],
    rest: Rest,
    more: Marks | None = None,
    asked: Problem | None = None,
) -> tuple[Way, list[Block]]:
    """The best way through fine strips of what a path may touch that costs as little as is asked for, and these strips.

    On an exact limb: `keys` (k,) are the poses that count, `more` (n,) others that count then, `blocks` their strips as
    they were planned, `rest` what a path costs from their postures on, by `costs_to_end`, and what it may cost. Where
    it is more than by `problem`, `asked` says what fine strips are to have, and how fine they are.
    """
    parts = [kept(block, costs, rest.most) for block, costs in zip(blocks, rest.after, strict=True)]
    rows, poses = np.vstack([part.rows for part in parts]), np.concatenate([part.poses for part in parts])
    ends = np.searchsorted(poses, np.arange(len(problem.T) + 1)).tolist()
    free: list[Array | None] = [rows[first:last] for first, last in pairwise(ends)]
    told = replace(problem, radius=EVERYWHERE) if asked is None else asked
    if more is not None and more.any():
        near, radius = between(problem, keys, blocks, rest)
        told = replace(told, near=near, radius=np.where(more, radius, EVERYWHERE))
        for i in np.flatnonzero(more):
            free[i] = None
        keys = np.union1d(keys, np.flatnonzero(more))
    found, fine = through(replace(told, free=free), keys, False)
    # Intervals that are cut have ends that are none of the strip.
    strips = np.vstack([part.strips for part in parts])
    psi = found.psi[poses]
    own = (rows[:, 0] == found.branch[poses]) & (psi >= strips[:, 0] - AT_ENDS) & (psi <= strips[:, 1] + AT_ENDS)
    found.bounds[:] = np.inf, -np.inf
    np.minimum.at(found.bounds[:, 0], poses[own], np.where(strips[own, 0] > -np.pi, strips[own, 0], -np.inf))
    np.maximum.at(found.bounds[:, 1], poses[own], np.where(strips[own, 1] < np.pi, strips[own, 1], np.inf))
    found.bounds[found.bounds[:, 0] > found.bounds[:, 1]] = -np.inf, np.inf
    return found, fine


def held_between(problem: Problem, keys: NDArray[np.int64], blocks: list[Block], rest: Rest) -> Problem:
    """The problem with what a path may touch that costs so little: known at key poses, looked for alone between."""
    near, radius = between(problem, keys, blocks, rest)
    spacing = np.clip(SPACED * radius, NEAR_SPACING, WIDE_SPACING)
    return replace(held_below(problem, keys, blocks, rest, rest.most), near=near, radius=radius, spacing=spacing)


def held_about(problem: Problem, keys: NDArray[np.int64], blocks: list[Block], rest: Rest) -> Problem:
    """`held_between` on the true chain: between key poses that a path passes on one piece of a curve, that one alone.

    Of the others all curves are looked for.
    """
    told = held_between(problem, keys, blocks, rest)
    pieces = np.zeros(len(problem.T), np.int64)
    for block, costs in zip(blocks, rest.after, strict=True):
        some, cells = touched(block.linked(), block, costs, rest.most)
        np.add.at(pieces, block.poses()[some & ~np.append(False, cells[:-1])], 1)
    one = pieces[keys] == 1
    n = np.arange(len(problem.T))
    behind = np.searchsorted(keys, n)
    before = behind - (keys[behind] > n)
    return replace(told, radius=np.where(one[before] & one[behind] & (told.radius < ONE_CURVE), told.radius, 0.0))


def between(problem: Problem, keys: NDArray[np.int64], blocks: list[Block], rest: Rest) -> tuple[Array, Array]:
    """Postures (n, 7) about which a path is at every pose, and (n,) how far around, rad, if it costs so little.

    One that is off the straight line between two key poses by d, k and l poses from them, costs d^2 (1/k + 1/l) more
    than is known of it.
    """
    q, poses = [], []
    for block, costs in zip(blocks, rest.after, strict=True):
        some, _ = touched(block.linked(), block, costs, rest.most)
        rows, own = block.held(some)
        q.append(rows[:, :7])
        poses.append(own)
    where = np.concatenate(poses)
    first = np.flatnonzero(np.diff(where, prepend=-1))
    if len(first) < len(keys):
        return np.zeros((len(problem.T), 7)), np.full(len(problem.T), EVERYWHERE)
    low, high = (each.reduceat(np.concatenate(q), first) for each in (np.minimum, np.maximum))
    n = np.arange(len(problem.T))
    behind = np.searchsorted(keys, n)
    before = behind - (keys[behind] > n)
    low, high = np.minimum(low[before], low[behind]), np.maximum(high[before], high[behind])
    k, m = n - keys[before], keys[behind] - n
    off = np.sqrt(max(rest.most - rest.least, 0.0) * k * m / np.maximum(k + m, 1))
    return 0.5 * (low + high), 0.5 * (high - low).max(axis=1) + off + ROOM


def costs_to_end(problem: Problem, blocks: list[Block], most: float) -> Rest:
    """What a path that costs at most so much costs from each posture on."""
    behind: Carry | None = None
    found = []
    for block in reversed(blocks):
        nodes, cost, strips, ends = block.fill()
        n, m, count = ends[block.count, 1], ends[block.count, 3], block.count
        sag, nodes, cost, strips, after = (
            nodes[:n, NODE_SAG].copy(),
            nodes[:n],
            cost[:n],
            strips[:m].copy(),
            np.empty(n),
        )
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
        nodes[:n, NODE_SAG] = sag
    return Rest(found[::-1], most, blocks[-1].least())


def held_below(problem: Problem, keys: NDArray[np.int64], blocks: list[Block], rest: Rest, most: float) -> Problem:
    """The problem with those postures of blocks known through which a path may lead that costs at most so much.

    `rest` is for paths that cost as much or more.
    """
    found, alone = [], np.zeros(len(problem.T), np.bool_)
    for block, costs in zip(blocks, rest.after, strict=True):
        some, cells = touched(block.linked(), block, costs, most)
        rows, poses = block.held(some)
        rows[:, HELD_LINKED] = cells[some]
        found.append((rows, poses))
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


def worse(problem: Problem, way: Way, keys: NDArray[np.int64], q: Array) -> Marks:
    """(n,) the poses between planned ones, q being the postures planned there, where a path costs more than planned."""
    more = above_plan(problem, way, keys, q)
    return from_keys(more > more.max(initial=0.0) / 8.0, keys, len(way.q))


def dear(problem: Problem, way: Way, keys: NDArray[np.int64], left: float) -> Marks:
    """(n,) from which planned poses to the next a path costs more than straight steps would, but for so much in all."""
    more = above_plan(problem, way, keys, way.q[keys])
    order = np.argsort(more)
    some = np.zeros(len(more), np.bool_)
    some[order[np.cumsum(more[order]) > left]] = True
    return from_keys(some, keys, len(way.q))


def above_plan(problem: Problem, way: Way, keys: NDArray[np.int64], q: Array) -> Array:
    """(k - 1,) what a path costs from each planned pose to the next above straight steps between the postures q."""
    costs = np.append(0.0, np.cumsum((steps_of(problem, way.q) ** 2).sum(axis=1)))
    return costs[keys[1:]] - costs[keys[:-1]] - (steps_of(problem, q) ** 2).sum(axis=1) / np.diff(keys)


def from_keys(some: Marks, keys: NDArray[np.int64], n: int) -> Marks:
    """(n,) the poses from some planned ones on to the next."""
    return np.append(some, False)[np.searchsorted(keys, np.arange(n), side="right") - 1]


def is_in_slivers(way: Way) -> bool:
    """Whether a path leads through intervals so narrow that joints turn fast in them: coarse strips tell little."""
    return bool((way.bounds[:, 1] - way.bounds[:, 0] < SLIVER).any())
