"""Free arm angles on the real shapes, certified: distances by coal, against a bound on how far bodies can move.

Each pair of bodies is looked at only in the arcs that its spheres forbid. Bodies that the arm angle turns as one, and
those that it does not move, are looked at once for all branches of an elbow; links 1, 2, 5 and 6, which spin beside,
for each branch. From one arm angle to the next, a pair keeps its state by a bound on its motion (`collision.reaches`);
what is not shown to be free in this way counts as forbidden.

Source: F. Schwarzer, M. Saha, J.-C. Latombe, Adaptive Dynamic Collision Checking for Single and Multiple Articulated
Robots in Complex Environments, T-RO 21(3), 2005, with a bound for one arm angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.reaches import Hinge, Rates, Spinning
from srs_ik.collision.real_world import SPINNING
from srs_ik.solve import pose as pose_solver
from srs_ik.solve.in_scene.spans import Span, certify, common, merged, turned, width, without

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings

Array = NDArray[np.float64]
Look = Callable[[float, float], float]

_CIRCLE = (-math.pi, math.pi)


class _Doubt(NamedTuple):
    """What the spheres leave undecided of an interval."""

    branch: int
    lower: float
    upper: float
    easy: list[Span]
    """Its parts that the spheres show to be free."""
    ranged: list[Span]
    """Its parts in which the ranges of joints keep apart bodies that no sphere watches."""

    @property
    def gaps(self) -> list[Span]:
        """The rest."""
        return without([(self.lower, self.upper)], self.easy)


def certified_free(
    around: Surroundings, T: Array, found: Array, respect: bool, more: float = 0.0
) -> tuple[Array, float]:
    """(n, 3) what is certainly free of some intervals of a pose, sorted, and the width left undecided, rad."""
    in_range = around.in_range(T, found, respect)
    possible = around.not_out_of_range(T, found, respect)
    easy = around.by_spheres(T, in_range, more)
    doubts = [
        _Doubt(int(branch), lower, upper, *(_of_branch(rows, branch, lower, upper) for rows in (easy, in_range)))
        for branch, lower, upper in around.clear_of_formless(T, possible, more).tolist()
    ]
    search = _Search(around, T, more) if any(doubt.gaps for doubt in doubts) else None
    pieces, undecided = [], 0.0
    for elbow in (0, 1):
        own = [doubt for doubt in doubts if doubt.branch >> 2 == elbow]
        wanted = [span for doubt in own for span in turned(doubt.gaps, *_CIRCLE)]
        blocked, unsure = search.of_elbow(elbow, own, merged(wanted)) if search and wanted else ([], [])
        for doubt in own:
            left = without(doubt.gaps, turned(blocked, doubt.lower, doubt.upper))
            open_ = [span for span in left if span[1] > span[0]] if doubt.upper > doubt.lower else left
            taken, doubtful = search.of_branch(doubt, open_) if search and open_ else ([], [])
            free = merged([*doubt.easy, *without(open_, taken)])
            pieces += [(doubt.branch, a, b) for a, b in free]
            undecided += width(common(doubt.gaps, turned(unsure, doubt.lower, doubt.upper))) + width(doubtful)
    return np.array(pieces).reshape(-1, 3), undecided


def _of_branch(rows: Array, branch: float, lower: float, upper: float) -> list[Span]:
    return turned([(a, b) for _, a, b in rows[rows[:, 0] == branch].tolist()], lower, upper)


class _Search:
    """The real shapes at one pose."""

    def __init__(self, around: Surroundings, T: Array, more: float) -> None:
        self._arm, self._packed, self._T = around.arm, around.packed, T
        self._world = around.real_world()
        self._margin = around.margin + more
        self._watched = self._world.watched(self._margin)
        self._arcs = around.arcs_by_pair(T, self._world, more)
        limb = around.arm.limb
        wrist = T @ np.linalg.inv(limb.T_base_tip_zero) @ [*limb.wrist, 1.0]
        line = wrist[:3] - limb.shoulder
        self._line = limb.shoulder, line / np.linalg.norm(line)
        self._outer = [_outer_axes(*limb.axes[k : k + 3]) for k in (0, 4)]

    def of_elbow(self, elbow: int, doubts: list[_Doubt], wanted: list[Span]) -> tuple[list[Span], list[Span]]:
        """Of the arm angles wanted, those forbidden by bodies that turn as one or stand still; of them, the unsure."""
        at = next((doubt.branch, sum(doubt.gaps[0]) / 2.0) for doubt in doubts if doubt.gaps)
        q = self._posture(*at)
        if q is None:
            return wanted, wanted
        hinge = Hinge(self._world, self._arm.joint_frames(q), at[1], self._line, self._margin)
        looks = ((hinge.look(a, b), arcs) for (a, b), arcs in self._pairs(elbow, spinning=False))
        return _blocked(looks, wanted)

    def of_branch(self, doubt: _Doubt, left: list[Span]) -> tuple[list[Span], list[Span]]:
        """Of the arm angles left, those forbidden by bodies that spin, or that ranges of joints watch; the unsure."""
        known: dict[float, Array | None] = {}

        def posture(psi: float) -> Array | None:
            if psi not in known:
                known[psi] = self._posture(doubt.branch, psi)
            return known[psi]

        spinning = Spinning(self._world, posture, self._rates, self._line, self._margin)
        arcs = [(pair, turned(own, doubt.lower, doubt.upper)) for pair, own in self._pairs(doubt.branch >> 2, True)]
        arcs += [(pair, without(left, doubt.ranged)) for pair in self._watched if pair not in self._arcs]
        return _blocked(((spinning.look(*pair), own) for pair, own in arcs), left)

    def _pairs(self, elbow: int, spinning: bool) -> Iterator[tuple[tuple[int, int], list[Span]]]:
        """Pairs with a body that spins, or those without, and the arcs that their spheres forbid; widest first."""
        joints = self._world.joints
        own = [
            (pair, arcs[elbow])
            for pair, arcs in self._arcs.items()
            if arcs[elbow] and (joints[pair[0]] in SPINNING or joints[pair[1]] in SPINNING) == spinning
        ]
        yield from sorted(own, key=lambda each: -width(each[1]))

    def _posture(self, branch: int, psi: float) -> Array | None:
        answer = pose_solver.solve(self._packed, self._T, psi, None, branch, False)
        return answer.q if answer else None

    def _rates(self, q: Array, half: float) -> Rates:
        shoulder, wrist = (
            _fastest(_angle(outer, float(angle)), half, outer.to_first, outer.to_last)
            for outer, angle in zip(self._outer, (q[1], q[5]), strict=True)
        )
        second, sixth = (
            1.0 if outer.to_first == outer.to_last == 0.0 else rate
            for outer, rate in zip(self._outer, (shoulder, wrist), strict=True)
        )
        return Rates(shoulder, second, wrist, sixth)


def _blocked(looks: Iterator[tuple[Look, list[Span]]], wanted: list[Span]) -> tuple[list[Span], list[Span]]:
    """Of the arm angles wanted, those not certified by some pair, and those left undecided."""
    blocked: list[Span] = []
    unsure: list[Span] = []
    for look, arcs in looks:
        for a, b in without(common(arcs, wanted), blocked):
            free, doubtful = certify(look, a, b)
            blocked = merged([*blocked, *without([(a, b)], free)])
            unsure += doubtful
    return blocked, merged(unsure)


class _Outer(NamedTuple):
    """The outer ones of the three axes of shoulder or wrist."""

    fixed: float
    """The cosine of the angle between them is this ..."""
    cosine: float
    """... and this times the cosine of the angle of the joint between them ..."""
    sine: float
    """... and this times its sine."""
    to_first: float
    """Cosine of the angle from the first axis to the middle one."""
    to_last: float


def _outer_axes(first: Array, middle: Array, last: Array) -> _Outer:
    to_first, to_last = (_rounded(float(axis @ middle)) for axis in (first, last))
    fixed = to_first * to_last
    return _Outer(fixed, float(first @ last) - fixed, float(first @ np.cross(middle, last)), to_first, to_last)


def _rounded(cosine: float) -> float:
    return 0.0 if abs(cosine) < _SQUARE else cosine


_SQUARE = 1e-9
"""Axes whose angle has a cosine below this are square to each other."""


def _angle(outer: _Outer, q: float) -> float:
    """The angle between two outer axes at an angle of the joint between them, rad."""
    cosine = outer.fixed + outer.cosine * math.cos(q) + outer.sine * math.sin(q)
    return math.acos(min(max(cosine, -1.0), 1.0))


def _fastest(angle: float, width: float, first: float, second: float) -> float:
    """Largest rate of joints 1 and 3 of a spherical joint whose outer axes are within `width` of an angle, rad/rad.

    The rates have the triple product of the three axes below them. Its square is a concave function of the cosine of
    the angle between the outer axes, so the smaller of both ends bounds it; and that angle changes no faster than the
    arm turns.
    """
    if angle - width <= 0.0 or angle + width >= math.pi:
        return math.inf
    least = math.inf
    for end in (angle - width, angle + width):
        c = math.cos(end)
        least = min(least, 1.0 - first * first - second * second - c * c + 2.0 * first * second * c)
    return 1.0 / math.sqrt(least) if least > 0.0 else math.inf
