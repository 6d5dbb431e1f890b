"""The search for a joint path: strips block by block, the way back through them, and its refinement."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.inputs.poses import refuse_bad_poses
from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.entries.path import MOST_NODES, MOST_STRIPS
from srs_ik.kernels.layout.answer import ROW, ROW_ORIENTATION_ERROR, ROW_POSITION_ERROR, ROW_STATUS
from srs_ik.kernels.layout.path import BREAK, BY_VELOCITY, INVERSE_PERIOD, NODE, PERIOD, STRIP, STRIP_FIRST
from srs_ik.solve.pose import solve
from srs_ik.solve.solution import Status
from srs_ik.solve.threads import Stop

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

Array = NDArray[np.float64]

BLOCK_NODES = 16 * MOST_NODES
BLOCK_STRIPS = 16 * MOST_STRIPS
BLOCK_POSES = 512
"""Size of a block: about ten megabytes."""

KEPT = 8
"""So many blocks are kept; of longer paths, the others are computed again on the way back."""

WIDTHS = np.array([0.12, 0.04])
"""Joint steps between the postures of a corridor, rad, before all arm angles move at once."""

FINE: Array = np.empty(0)
"""None, where strips were fine already."""

FINE_WIDTHS: Array = 0.12 * 0.5 ** np.arange(12.0)
"""The same where corridors alone have to do: with limits of speed."""


ROUNDS = 4
RADIUS = 0.25
"""A path is searched for again so often at most, so far around the last one, rad."""

LEAST_GAIN = 1e-3
"""A search that gains less, relative to all, is the last one."""


class Stopped(Exception):
    """Nobody wants the answer any more."""


@dataclass
class Problem:
    """A path to be found.

    Attributes:
        arm: the arm.
        T: (n, 4, 4) poses.
        seed: (7,) posture before the first one, or None.
        settings: (SETTINGS, 7), see the kernels of the programme.
        limited: whether there are velocity limits.
        known: (n, 7) postures that are given.
        has_known: (n,) where they are.
        near: (n, 7) postures around which strips are finer.
        bridges: (b, 7) postures that strips miss.
        bridged: (b,) to which poses they belong, in order.
        radius: how far around, rad; 0: nowhere.
        even: whether squared joint steps are what counts.
        in_closed_form: whether to go by the nearest exact limb of a near one.
        stop: (1,) set by another thread where nobody wants the answer any more.
    """

    arm: PackedArm
    T: Array
    seed: Array | None
    settings: Array
    limited: bool
    known: Array
    has_known: NDArray[np.bool_]
    near: Array
    radius: float = 0.0
    even: bool = True
    in_closed_form: bool = False
    stop: Stop = field(default_factory=lambda: np.zeros(1, np.int8))
    bridges: Array = field(default_factory=lambda: np.empty((0, 7)))
    bridged: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))

    def work(self) -> tuple[Array | None, Array | None]:
        """Work space of the kernels; none where the closed form is asked for alone."""
        return (None, None) if self.in_closed_form else self.arm.work()

    def bridge_ends(self) -> NDArray[np.int64]:
        """(n + 1,) the first bridge of each pose."""
        return np.searchsorted(self.bridged, np.arange(len(self.T) + 1))


@dataclass
class Wall:
    """A pose that no continuous path reaches, and the postures of the pose before from which none does."""

    sample: int
    before: Array


class Way:
    """Postures of a path: joint angles, arm angles, branches, and the ends of the strips in which they lie."""

    def __init__(self, n: int) -> None:
        self.q = np.zeros((n, 7))
        self.psi = np.zeros(n)
        self.branch = np.zeros(n, np.int64)
        self.bounds = np.zeros((n, 2))
        self.reached = np.zeros(n, np.bool_)
        self.cost = 0.0
        self.walls: list[Wall] = []


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
        nodes, cost = np.empty((BLOCK_NODES, NODE)), np.empty(BLOCK_NODES)
        strips, ends = np.empty((BLOCK_STRIPS, STRIP)), np.zeros((BLOCK_POSES + 1, 4), np.int64)
        carried = -1
        if self.before is not None:
            carried = self.before.pose
            n, m = len(self.before.nodes), len(self.before.strips)
            nodes[:n], cost[:n], strips[:m] = self.before.nodes, self.before.cost, self.before.strips
            ends[0] = 0, n, 0, m
        p = self.problem
        space = p.work()
        answer = (p.settings, p.limited, self.exact, *space, nodes, cost, strips, ends)
        after, self.reached = entries.sweep(
            p.arm.family,
            p.T,
            self.keys,
            self.first,
            carried,
            p.stop,
            p.known,
            p.has_known,
            p.bridges,
            p.bridge_ends(),
            p.near,
            p.radius,
            p.seed,
            *answer,
        )
        if p.stop[0]:
            raise Stopped
        self.count = after - self.first
        self.arrays = nodes, cost, strips, ends
        return self.arrays

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

    def carry(self) -> Carry | None:
        """The last pose of it that is reached."""
        if self.reached == 0:
            return self.before
        nodes, cost, strips, ends = self.fill()
        a, b, c, d = ends[self.reached]
        own = strips[c:d].copy()
        own[:, STRIP_FIRST:] -= a
        return Carry(int(self.keys[self.first + self.reached - 1]), nodes[a:b].copy(), cost[a:b].copy(), own)


@dataclass
class Carry:
    """The strips of one pose, on the way from a block to the next."""

    pose: int
    nodes: Array
    cost: Array
    strips: Array


def find_way(problem: Problem, keys: NDArray[np.int64], exact: bool) -> Way:
    """The best way through the strips of the key poses."""
    blocks: list[Block] = []
    first, before = 0, None
    while first < len(keys):
        block = Block(problem, keys, first, exact, before)
        block.fill()
        before, first = block.carry(), first + block.count
        if len(blocks) >= KEPT:
            blocks[-KEPT].arrays = None
        blocks.append(block)
    way = Way(len(problem.T))
    if before is not None and before.cost.min() >= BREAK and not exact:
        way.walls = [wall for block in blocks for wall in block.walls()]
    following = -1
    for block in reversed(blocks):
        place = way.q, way.psi, way.branch, way.bounds
        settings = problem.settings, problem.limited
        arrays = block.fill()
        following, least = entries.go_back(keys, block.first, block.count, following, *settings, *arrays, *place)
        if least >= 0.0:
            way.cost = least
        ends = arrays[3][1 : block.count + 1]
        way.reached[keys[block.first : block.first + block.count]] = ends[:, 1] > ends[:, 0]
        block.arrays = None
    if problem.work()[0] is not None:
        # Along the curves of a near limb, limits are looked at step by step.
        way.bounds[:] = -np.inf, np.inf
    return way


def search(problem: Problem) -> Way:
    """The best path: planned at key poses, filled in between, and refined."""
    if problem.arm.closed or problem.in_closed_form:
        return planned(problem)
    # A near limb moves almost like the exact one next to it: what is best for that one is closed on the true chain.
    way = planned(replace(problem, in_closed_form=True))
    if way.cost < 0.5 * BREAK and way.reached.all() and close(problem, way):
        improve(problem, way)
        if way.cost < 0.5 * BREAK:
            return way
    return planned(problem)


def close(problem: Problem, way: Way) -> bool:
    """Take the postures of a path to their poses, on the true chain and inside the limits; whether all could be."""
    met = np.zeros(len(way.q), np.bool_)
    entries.bridge(problem.arm.family, problem.T, way.q, met, *problem.arm.work())
    way.bounds[:] = -np.inf, np.inf
    way.psi[:] = 0.0
    way.branch[~problem.has_known] = 0
    return bool(met.all())


def planned(problem: Problem) -> Way:
    """`search` on the true chain, or on the nearest exact limb."""
    arm, T = problem.arm, problem.T
    marks, verdicts = np.zeros(len(T), np.bool_), np.zeros(len(T), np.int64)
    entries.choose_keys(arm.family, T, problem.has_known, marks, verdicts)
    refuse_bad_poses(verdicts)
    while True:
        keys = np.flatnonzero(marks)
        way = find_way(problem, keys, False)
        whole = way.cost < 0.5 * BREAK and bool(way.reached[keys].all())
        missed = np.zeros(len(T), np.bool_)
        if whole:
            place = way.q, way.psi, way.branch, way.bounds, missed
            entries.fill_between(arm.family, T, keys, way.reached, problem.settings, *place, *problem.work())
            if not missed.any():
                improve(problem, way)
                return search_around(problem, way)
            near = find_around(problem, way, np.arange(len(T)))
            if near.cost < 0.5 * BREAK and near.reached.all():
                improve(problem, near, FINE)
                return near
        if marks.all():
            break
        # Between two planned poses the path does something of its own: there, every pose is planned.
        marks |= missed if missed.any() else True
    if way.cost >= 0.5 * BREAK:
        walls = way.walls
        way = find_way(problem, keys, True)
        way.walls = walls
    improve(problem, way)
    return search_around(problem, way)


def find_around(problem: Problem, way: Way, chain: NDArray[np.int64]) -> Way:
    """The best way through strips that are fine about a path, and nowhere else."""
    return find_way(replace(problem, near=way.q, radius=RADIUS), chain, False)


def search_around(problem: Problem, way: Way) -> Way:
    """The best path around one: strips are finer there, so branches change where that is best."""
    chain = np.flatnonzero(way.reached)
    for _ in range(ROUNDS):
        if problem.even and not np.diff(way.branch[chain]).any():
            break
        again = find_around(problem, way, chain)
        if not again.reached[chain].all():
            break
        improve(problem, again, FINE)
        gain = way.cost - again.cost
        if gain > 0.0:
            way = again
        if not gain > LEAST_GAIN * way.cost:
            break
    return way


def improve(problem: Problem, way: Way, widths: Array | None = None) -> None:
    """Move the postures of a path to the best ones near them."""
    if not problem.even:
        refine(problem, way, FINE_WIDTHS, False)
        return
    planned = copy(way)
    refine(replace(problem, limited=False), way, WIDTHS if widths is None else widths, True)
    if problem.limited and is_too_fast(problem, way):
        # All at once, arm angles keep no velocity limits: then corridors alone, finer and finer.
        way.q, way.psi, way.branch, way.bounds = planned.q, planned.psi, planned.branch, planned.bounds
        refine(problem, way, FINE_WIDTHS, False)


def refine(problem: Problem, way: Way, widths: Array, even: bool) -> None:
    """Move the postures of a path, in place, through corridors of some widths, and all at once where that will do."""
    chain = np.flatnonzero(way.reached)
    fixed = problem.has_known | (way.branch < 0)
    place = (problem.T, chain, fixed, way.bounds, widths, even, problem.seed, problem.settings)
    work = problem.work()
    way.cost = entries.refine(problem.arm.family, *place, problem.limited, way.q, way.psi, way.branch, *work)


def copy(way: Way) -> Way:
    """A copy of the postures of a path."""
    other = Way(len(way.q))
    other.q, other.psi, other.branch = way.q.copy(), way.psi.copy(), way.branch.copy()
    other.bounds, other.reached, other.cost = way.bounds.copy(), way.reached.copy(), way.cost
    return other


def steps_of(problem: Problem, q: Array) -> Array:
    """Joint steps of a path, joints without end the shorter way round."""
    steps = np.diff(q, axis=0)
    turns = np.round(steps * problem.settings[INVERSE_PERIOD])
    return steps - problem.settings[PERIOD] * turns


def is_too_fast(problem: Problem, way: Way) -> bool:
    """Whether a path breaks a velocity limit."""
    chain = np.flatnonzero(way.reached)
    limits = problem.settings[BY_VELOCITY] * np.diff(chain)[:, None]
    return bool((np.abs(steps_of(problem, way.q[chain])) > limits * (1.0 + 1e-9)).any())


def rows_of(problem: Problem, way: Way) -> Array:
    """Rows of the postures of a path; where there is none, that of the search for one pose near the one before."""
    arm, T = problem.arm, problem.T
    rows = np.full((len(T), ROW), np.nan)
    chain = np.flatnonzero(way.reached)
    entries.finish(arm.family, T, chain, way.q, way.psi, way.branch, *arm.work(), rows)
    for i in np.flatnonzero(~way.reached | (rows[:, ROW_STATUS] != Status.OK)).tolist():
        rows[i] = solve(arm, T[i], seed=rows[i - 1, :7] if i else problem.seed)._row
    return rows


def off_pose(arm: PackedArm, pose: Array, q: Array) -> float:
    """How far a posture is off a pose, the larger of m and rad."""
    rows = np.empty((1, ROW))
    one = np.zeros(1, np.int64)
    entries.finish(arm.family, pose[None], one, q[None], np.zeros(1), one - 1, None, None, rows)
    return float(rows[0, ROW_POSITION_ERROR : ROW_ORIENTATION_ERROR + 1].max())
