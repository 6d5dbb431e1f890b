"""A path that is asked for, and one that is found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries.pose import pack_limits
from srs_ik.kernels.layout.limb import IS_NEAR, LOOSE
from srs_ik.kernels.layout.path import (
    BY_CONTINUITY,
    BY_VELOCITY,
    HELD,
    INVERSE_PERIOD,
    INVERSE_SPEED,
    LEAST_INVERSE,
    PERIOD,
    ROOMIEST,
    ROOMY,
)
from srs_ik.solve.pose import solve, solve_all
from srs_ik.solve.threads import Stop
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings
    from srs_ik.solve.packed import PackedArm
    from srs_ik.solve.solution import Solution
    from srs_ik.solve.solutions import Solutions

SUM_OF_SQUARES = "sum_of_squares"
LARGEST_STEP = "largest_step"
TIME = "time"
OBJECTIVES = (SUM_OF_SQUARES, LARGEST_STEP, TIME)
"""What a path can be asked to make least, among those with the fewest breaks."""


JUST_ABOVE = 1.0 + 1e-9
"""Of a limit; what is above breaks it."""


EVERYWHERE = 4.0
"""Farther than any joint angle from any other, whole turns left out, rad."""

FINE_SPACING = 0.05
"""Joints move no farther from one posture of a strip to the next, rad, where strips are fine everywhere ..."""

NEAR_SPACING = 0.1
"""... and where a path is nearly the best."""

ROOM_OF_ENDS = 1e-9
ROOM_OF_BENDS = 2e-7
"""So far are limits drawn out where intervals are looked for, rad; the second one where an elbow is as good as flat."""


ROUNDED = 1e-4
"""Joints of a near limb that are off those of its nearest exact one by less than this, rad, are so by rounding."""

STANDING = 1e-12
"""Two poses in a row are the same if no entry differs by more."""


class Stopped(Exception):
    """Nobody wants the answer any more."""


@dataclass
class Problem:
    """A path to be found."""

    arm: PackedArm  # the arm
    T: Array  # (n, 4, 4) poses
    seed: Array | None  # (7,) posture before the first one, or None
    settings: Array  # (SETTINGS, 7), see the kernels of the programme
    limited: bool  # whether there are velocity limits
    known: Array  # (n, 7) postures that are given
    has_known: NDArray[np.bool_]  # (n,) where they are
    near: Array  # (n, 7) postures around which strips are finer
    radius: float | Array = 0.0  # how far around, rad, of all or of each (n,); 0: nowhere
    # of fine strips, rad, of all or of each (n,): joints move no farther from a posture to the next
    spacing: float | Array = NEAR_SPACING
    objective: str = SUM_OF_SQUARES  # what is to be least
    in_closed_form: bool = False  # whether to go by the nearest exact limb of a near one
    # (7,) limits of joint accelerations, rad/s^2, within which the time is to be least; None: none
    acceleration: Array | None = None
    dt: float | None = None  # seconds between two poses
    # (1,) set by another thread where nobody wants the answer any more
    stop: Stop = field(default_factory=lambda: np.zeros(1, np.int8))
    held: Array = field(default_factory=lambda: np.empty((0, HELD)))  # (h, HELD) postures that are known already
    # (h,) to which poses they belong, in order
    held_of: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    # (n,) where they are all postures of their pose, and not some that strips miss; None: nowhere
    held_alone: NDArray[np.bool_] | None = None
    # (7,) postures whose shoulder and wrist turn on the spot, by their poses, as they are met on strips
    two_turns: dict[int, Array] = field(default_factory=dict)
    around: Surroundings | None = None  # what must not be touched; None for nothing
    # of each pose the (k, 3) intervals that strips may have, None for all; with `around`, those clear of it
    free: Sequence[Array | None] | None = None

    @property
    def limb(self) -> Array:
        """The packed limb that answers: that of the arm, or the nearest exact one."""
        return limbs_of(self.arm, self.in_closed_form)[0]

    @property
    def family(self) -> Array:
        """The packed limb of its strips."""
        return limbs_of(self.arm, self.in_closed_form)[1]

    @property
    def is_near(self) -> bool:
        """Whether its postures are looked for on the true chain of a near limb."""
        return not (self.in_closed_form or self.arm.closed)

    @property
    def start(self) -> Array:
        """The posture before the first one, (1, 7), or (0, 7) for none."""
        return np.empty((0, 7)) if self.seed is None else self.seed[None]

    @property
    def even(self) -> bool:
        """Whether squared joint steps are what counts."""
        return self.objective == SUM_OF_SQUARES

    def allowed(self) -> tuple[Array, NDArray[np.int64]]:
        """(m, 3) the only intervals that strips may have, and (n, 2) which of them a pose has; (0, 2) where all are."""
        if self.free is None:
            return np.empty((0, 3)), np.empty((0, 2), np.int64)
        last = np.cumsum([0 if rows is None else len(rows) for rows in self.free])
        ends = np.column_stack([np.append(0, last[:-1]), last])
        ends[[rows is None for rows in self.free]] = -1
        return np.concatenate([np.empty((0, 3)), *(rows for rows in self.free if rows is not None)]), ends

    def reordered(self, order: NDArray[np.int64]) -> dict[str, Any]:
        """What strips of the poses in another order may have, and what is known of them, as fields of a problem."""
        first = self.known_before()[1]
        rows = np.concatenate([np.empty(0, np.int64), *(np.arange(first[i], first[i + 1]) for i in order)])
        return {
            "free": None if self.free is None else [self.free[i] for i in order],
            "held": self.held[rows],
            "held_of": np.repeat(np.arange(len(order)), np.diff(first)[order]),
            "held_alone": None if self.held_alone is None else self.held_alone[order],
        }

    def solve(self, i: int, seed: Array | None) -> Solution:
        """The best posture of a pose by itself."""
        if self.around is not None:
            from srs_ik.solve.in_scene import pose as in_scene

            return in_scene.solve(self.around, self.T[i], None, seed, -1, True)
        return solve(self.arm, self.T[i], seed=seed)

    def solve_all(self, i: int) -> Solutions:
        """A posture of every interval of a pose."""
        if self.around is not None:
            from srs_ik.solve.in_scene import pose as in_scene

            return in_scene.solve_all(self.around, self.T[i], None, True)
        return solve_all(self.arm, self.T[i], None, True)

    def known_before(self) -> tuple[Array, NDArray[np.int64], NDArray[np.bool_]]:
        """`held`, (n + 1,) the first row of each pose in it, and `held_alone`."""
        alone = np.zeros(len(self.T), np.bool_) if self.held_alone is None else self.held_alone
        return self.held, np.searchsorted(self.held_of, np.arange(len(self.T) + 1)), alone


def nothing_held() -> dict[str, Any]:
    """The fields of a problem of which no strips are known."""
    return {"held": np.empty((0, HELD)), "held_of": np.empty(0, np.int64), "held_alone": None}


def as_closed(family: Array) -> Array:
    """A packed limb for which the closed form answers."""
    rows = family.copy()
    rows[:, IS_NEAR] = 0.0
    return rows


@lru_cache(maxsize=16)
def limbs_of(arm: PackedArm, in_closed_form: bool) -> tuple[Array, Array]:
    """The packed limb that answers, and that with what strips of an exact one are made of: limits with some room."""
    limb = as_closed(arm.family) if in_closed_form else arm.family
    rows = limb.copy()
    for which, room in ((ROOMY, ROOM_OF_ENDS), (ROOMIEST, ROOM_OF_BENDS)):
        rows[which] = limb[LOOSE]
        pack_limits(rows[which], arm.lower - room, arm.upper + room)
    return limb, rows


@dataclass
class Wall:
    """A pose that no continuous path reaches, and the postures of the pose before from which none does."""

    sample: int
    before: Array


class Way:
    """Postures of a path: joint angles, arm angles, branches, and the ends of the strips in which they lie.

    It is torn if finer strips about it do not join.
    """

    def __init__(self, n: int) -> None:
        self.q = np.zeros((n, 7))
        self.psi = np.zeros(n)
        self.branch = np.zeros(n, np.int64)
        self.bounds = np.zeros((n, 2))
        self.reached = np.zeros(n, np.bool_)
        self.cost = 0.0
        self.torn = False
        self.walls: list[Wall] = []


def copy(way: Way) -> Way:
    """A copy of the postures of a path."""
    other = Way(len(way.q))
    other.q, other.psi, other.branch = way.q.copy(), way.psi.copy(), way.branch.copy()
    other.bounds, other.reached, other.cost = way.bounds.copy(), way.reached.copy(), way.cost
    other.walls = way.walls
    return other


def take(way: Way, other: Way) -> None:
    """Give a path the postures of another one."""
    way.q, way.psi, way.branch, way.bounds = other.q, other.psi, other.branch, other.bounds
    way.reached, way.cost = other.reached, other.cost


def evenly(problem: Problem) -> Problem:
    """The same path with the sum of squares to be least."""
    settings = problem.settings.copy()
    settings[[INVERSE_SPEED, LEAST_INVERSE]] = 0.0
    return replace(problem, settings=settings, objective=SUM_OF_SQUARES)


def steps_of(problem: Problem, q: Array) -> Array:
    """Joint steps of a path, joints without end the shorter way round."""
    steps = np.diff(q, axis=0)
    turns = np.round(steps * problem.settings[INVERSE_PERIOD])
    return steps - problem.settings[PERIOD] * turns


def worth(problem: Problem, way: Way) -> tuple[int, float]:
    """What is compared of paths: poses not reached and steps too long, and with as many what is to be least.

    Steps above the velocity limits count for more than what is to be least does, and those over poses that are not
    reached in even parts.
    """
    chain = np.flatnonzero(way.reached)
    steps = np.abs(steps_of(problem, np.vstack([problem.start, way.q[chain]])))
    passed = np.diff(chain, prepend=chain[: len(problem.start)] - 1)
    missing = int((~way.reached).sum()) + int((steps > problem.settings[BY_CONTINUITY]).any(axis=1).sum())
    value = objective_of(problem, np.repeat(steps / passed[:, None], passed, axis=0))
    if problem.limited:
        over = too_fast(problem, way)
        value += 1e5 * float(over[over > JUST_ABOVE].sum())
    return missing, value


def objective_of(problem: Problem, steps: Array) -> float:
    """What is to be least, of the joint steps (k, 7) of a path."""
    if problem.objective == LARGEST_STEP:
        return float(np.abs(steps).max(initial=0.0))
    if problem.objective == TIME:
        return float((np.abs(steps) / problem.arm.velocity_limit).max(axis=1, initial=0.0).sum())
    return float((steps**2).sum())


def breaks_in(problem: Problem, way: Way) -> NDArray[np.bool_]:
    """(k - 1,) whether a step is too long to be continuous, beyond rounding, from each pose reached to the next."""
    steps = np.abs(steps_of(problem, way.q[way.reached]))
    return np.asarray((steps > JUST_ABOVE * problem.settings[BY_CONTINUITY]).any(axis=1))


def too_fast(problem: Problem, way: Way, loose: NDArray[np.bool_] | None = None) -> Array:
    """(k - 1,) the largest share that a joint has of its velocity limit, from each pose that is reached to the next.

    No limit holds for breaks: those that are `loose`, or those of the path.
    """
    chain = np.flatnonzero(way.reached)
    limits = problem.settings[BY_VELOCITY] * np.diff(chain)[:, None]
    shares = (np.abs(steps_of(problem, way.q[chain])) / limits).max(axis=1, initial=0.0)
    return np.where(breaks_in(problem, way) if loose is None else loose, 0.0, shares)


def stands(T: Array) -> NDArray[np.bool_]:
    """(n - 1,) where poses (n, 4, 4) have the same one twice in a row."""
    return np.asarray(np.abs(np.diff(T, axis=0)).max(axis=(1, 2), initial=0.0) <= STANDING)
