"""The best way through the strips of a path: block by block forth, and back again."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.entries.path import MOST_NODES, MOST_STRIPS
from srs_ik.kernels.layout.path import (
    BREAK,
    HELD,
    HELD_BRANCH,
    HELD_LINKED,
    HELD_PSI,
    IMPOSSIBLE,
    NODE,
    NODE_BRANCH,
    NODE_PSI,
    NODE_SAG,
    STRIP,
    STRIP_FIRST,
    STRIP_LAST,
    STRIP_LEAST,
)
from srs_ik.solve.path.problem import Problem, Stopped, Wall, Way
from srs_ik.solve.path.search.singular import note_two_turns
from srs_ik.system.arrays import Array

BLOCK_NODES = 4 * MOST_NODES
BLOCK_STRIPS = 4 * MOST_STRIPS
BLOCK_POSES = 512
"""Size of a block: about ten megabytes."""

KEPT = 24
"""So many blocks are kept; of longer paths, the others are computed again on the way back."""


ALL = slice(None)


class Block:
    """The strips of some key poses, and the costs of their postures."""

    def __init__(
        self, problem: Problem, keys: NDArray[np.int64], first: int, exact: bool, before: Carry | None
    ) -> None:
        self.problem, self.keys, self.first, self.exact, self.before = problem, keys, first, exact, before
        self.arrays: tuple[Any, ...] | None = None
        self.count = 0
        self.reached = 0

    def fill(self) -> tuple[Any, ...]:
        """Its arrays, computed if they are not there."""
        if self.arrays is not None:
            return self.arrays
        p = self.problem
        nodes, cost = np.empty((BLOCK_NODES, NODE)), np.empty(BLOCK_NODES)
        strips, ends = np.empty((BLOCK_STRIPS, STRIP)), np.zeros((BLOCK_POSES + 1, 4), np.int64)
        carried = -1
        if self.before is not None:
            carried = self.before.pose
            n, m = len(self.before.nodes), len(self.before.strips)
            nodes[:n], cost[:n], strips[:m] = self.before.nodes, self.before.cost, self.before.strips
            ends[0] = 0, n, 0, m
        answer = (p.settings, p.limited, self.exact, nodes, cost, strips, ends)
        after, self.reached = entries.sweep(
            p.family,
            p.T,
            self.keys,
            self.first,
            carried,
            p.stop,
            p.known,
            p.has_known,
            *p.known_before(),
            *p.allowed(),
            p.near,
            np.full(len(p.T), p.radius),
            np.full(len(p.T), p.spacing),
            p.start,
            *answer,
        )
        if p.stop[0]:
            raise Stopped
        self.count = after - self.first
        if p.arm.closed and p.free is None:
            firsts = strips[ends[1, 2] : ends[self.count, 3], STRIP_FIRST].astype(np.int64)
            poses = np.repeat(self.keys[self.first : after], np.diff(ends[: self.count + 1, 3]))
            note_two_turns(p, poses, nodes[firsts, :NODE_PSI])
        self.arrays = nodes, cost, strips, ends
        return self.arrays

    def held(self, some: NDArray[np.bool_] | slice = ALL) -> tuple[Array, NDArray[np.int64]]:
        """Its postures (h, HELD), or some of them, and to which poses they belong."""
        nodes, _, _, ends = self.fill()
        own = nodes[ends[1, 0] : ends[self.count, 1]][some]
        rows = np.empty((len(own), HELD))
        rows[:, :HELD_PSI] = own[:, :NODE_PSI]
        rows[:, HELD_PSI], rows[:, HELD_BRANCH] = own[:, NODE_PSI], own[:, NODE_BRANCH]
        rows[:, HELD_LINKED] = self.linked()[some]
        return rows, self.poses()[some]

    def linked(self) -> NDArray[np.bool_]:
        """(h,) whether each of its postures is linked to the next one."""
        _, _, strips, ends = self.fill()
        linked = np.ones(ends[self.count, 1] - ends[1, 0], np.bool_)
        linked[strips[ends[1, 2] : ends[self.count, 3], STRIP_LAST].astype(np.int64) - ends[1, 0]] = False
        return linked

    def poses(self) -> NDArray[np.int64]:
        """(h,) to which poses its postures belong."""
        ends = self.fill()[3][1 : self.count + 1]
        return np.repeat(self.keys[self.first : self.first + self.count], ends[:, 1] - ends[:, 0])

    def places(self) -> tuple[Array, Array]:
        """(h,) arm angles and branches of its postures."""
        nodes, _, _, ends = self.fill()
        own = nodes[ends[1, 0] : ends[self.count, 1]]
        return own[:, NODE_PSI], own[:, NODE_BRANCH]

    def costs(self) -> tuple[Array, Array]:
        """What its postures cost, and how far these costs sag to the next one, in the order of `held`."""
        nodes, cost, _, ends = self.fill()
        first, last = ends[1, 0], ends[self.count, 1]
        return cost[first:last], nodes[first:last, NODE_SAG]

    def walls(self) -> list[Wall]:
        """Where all ways need one more break, if breaks are made as late as can be."""
        nodes, cost, _, ends = self.fill()
        found, last, level = [], -1, -1
        for number in range(self.count + 1):
            a, b = ends[number, :2]
            if a == b:
                continue
            needed = int(cost[a:b].min() // BREAK)
            if last >= 0 and needed > level:
                c, d = ends[last, :2]
                open_ended = nodes[c:d][cost[c:d] < (level + 1) * BREAK, :7]
                found.append(Wall(int(self.keys[self.first + number - 1]), open_ended.copy()))
            last, level = number, needed
        return found

    def least(self) -> float:
        """What a way to the last pose of it that is reached costs at least."""
        if self.reached == 0:
            return 0.0 if self.before is None else float(self.before.cost.min())
        _, cost, _, ends = self.fill()
        return float(cost[ends[self.reached, 0] : ends[self.reached, 1]].min())

    def ends_at(self) -> tuple[NDArray[np.int64], Array]:
        """Numbers of the strips of its last pose, and what no way to each costs less than: the cheapest first."""
        _, _, strips, ends = self.fill()
        numbers = np.arange(*ends[self.count, 2:4])
        least = strips[numbers, STRIP_LEAST]
        order = np.argsort(least, kind="stable")
        return numbers[order], least[order]

    def carry(self) -> Carry | None:
        """The last pose of it that is reached."""
        if self.reached == 0:
            return self.before
        nodes, cost, strips, ends = self.fill()
        return carried(int(self.keys[self.first + self.reached - 1]), ends[self.reached], nodes, cost, strips)


@dataclass
class Carry:
    """The strips of one pose, on the way from a block to the next."""

    pose: int
    nodes: Array
    cost: Array
    strips: Array


def carried(pose: int, ends: NDArray[np.int64], nodes: Array, cost: Array, strips: Array) -> Carry:
    """The strips of a pose, of whose rows in arrays these are the ends."""
    a, b, c, d = ends
    own = strips[c:d].copy()
    own[:, STRIP_FIRST:STRIP_LEAST] -= a
    return Carry(pose, nodes[a:b].copy(), cost[a:b].copy(), own)


def find_way(problem: Problem, keys: NDArray[np.int64], exact: bool) -> Way:
    """The best way through the strips of the key poses."""
    return through(problem, keys, exact)[0]


def held_in(problem: Problem, keys: NDArray[np.int64], blocks: list[Block]) -> Problem:
    """The problem with the strips of blocks known already, unless these are many."""
    if len(blocks) > KEPT:
        return problem
    rows, poses = zip(*(block.held() for block in blocks), strict=True)
    alone = np.zeros(len(problem.T), np.bool_)
    alone[keys] = True
    return replace(problem, held=np.vstack(rows), held_of=np.concatenate(poses), held_alone=alone)


def through(problem: Problem, keys: NDArray[np.int64], exact: bool) -> tuple[Way, list[Block]]:
    """The best way through the strips of the key poses, and these strips."""
    blocks: list[Block] = []
    first, before = 0, None
    while first < len(keys):
        block = Block(problem, keys, first, exact, before)
        block.fill()
        first += block.count
        if first < len(keys):
            before = block.carry()
        if len(blocks) >= KEPT:
            blocks[-KEPT].arrays = None
        blocks.append(block)
    return gone_back(problem, keys, blocks), blocks


def gone_back(problem: Problem, keys: NDArray[np.int64], blocks: list[Block], last: int = -1) -> Way:
    """The best way through the strips of blocks, or to the one of the last pose with the number `last`."""
    way = Way(len(problem.T))
    if blocks and blocks[-1].least() >= BREAK and not blocks[-1].exact:
        way.walls = [wall for block in blocks for wall in block.walls()]
    following = -1
    for block in reversed(blocks):
        place = way.q, way.psi, way.branch, way.bounds
        settings = problem.settings, problem.limited
        arrays = block.fill()
        if last >= 0 and following < 0:
            arrays = ending_in(arrays, block.count, last)
        following, least = entries.go_back(keys, block.first, block.count, following, *settings, *arrays, *place)
        if least >= 0.0:
            way.cost = least
        ends = arrays[3][1 : block.count + 1]
        way.reached[keys[block.first : block.first + block.count]] = ends[:, 1] > ends[:, 0]
        if len(blocks) > KEPT:
            block.arrays = None
    if problem.is_near:
        # Along the curves of a near limb, limits are looked at step by step.
        way.bounds[:] = -np.inf, np.inf
    return way


def ending_in(arrays: tuple[Any, ...], count: int, strip: int) -> tuple[Any, ...]:
    """The arrays of a block as if its last pose, number `count`, had no postures but those of one strip."""
    nodes, cost, strips, ends = arrays
    others = np.ones(ends[count, 1] - ends[count, 0], np.bool_)
    first, last = strips[strip, STRIP_FIRST : STRIP_LAST + 1].astype(np.int64) - ends[count, 0]
    others[first : last + 1] = False
    own = cost.copy()
    own[ends[count, 0] : ends[count, 1]][others] = IMPOSSIBLE
    return nodes, own, strips, ends
