"""Which bodies of an arm are watched for meeting each other, and why others are not."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.collision import store
from srs_ik.collision.bodies import Body
from srs_ik.collision.forms import is_round
from srs_ik.collision.ranges import BOXES, FINE, Bounds, JointRange, key_of
from srs_ik.robot.description.shapes import read_tree
from srs_ik.robot.description.srdf import disabled_pairs

if TYPE_CHECKING:
    from srs_ik.kinematics import ChainKinematics
    from srs_ik.robot.description.model import Drawing

Array = NDArray[np.float64]

POSTURES = 200
"""Random postures inside the limits, at which pairs are looked at."""

ALWAYS = 0.95
"""Bodies that touch at more than this share of them touch by design."""

_HAIR = 1e-3
"""Bodies no farther apart than this, m, count as touching: a joint's housing and what turns in it."""

_BETWEEN = 3
"""Whether bodies with no more joints than this between them can meet at all is tried to be proved ..."""

_TRIES = 4000
"""... in so many steps ..."""

_COARSE = 0.004
"""... down to where no point moves farther than this, m."""

_MOST_DOUBTFUL = 400

_ENOUGH = 0.8
"""A range that keeps two bodies apart is worth more than their spheres where it is this share of the joint's own."""

_NEVER = 1e3
"""Stands for a distance without end, m."""

_APART = 1e-4
"""Bodies nearer than this, m, are not taken to be apart: coal's own tolerance is 1e-6."""


_FAR_APART = 0.02
"""Where even the hulls of two bodies are this far apart, m, their distance is near enough to that of the bodies."""


@dataclass(frozen=True)
class Pair:
    """Two bodies of an arm.

    Attributes:
        first: name of the one nearer to the base.
        second: name of the other.
        kept: whether they are watched.
        reason: why, in a word or two.
    """

    first: str
    second: str
    kept: bool
    reason: str


def find_pairs(
    arm: ChainKinematics, bodies: Sequence[Body], drawing: Drawing | None, srdf: str | Path | None = None
) -> tuple[list[Pair], list[JointRange]]:
    """All pairs of bodies of an arm, each kept or not, with the reason, and those that the range of a joint watches.

    Bodies on one joint are rigid to each other, and links that one joint connects touch at it. With an SRDF, what that
    disables is not watched; without, what touches at more than 95 % of random postures on the real shapes, and what is
    proved never to meet: the distance at the middle of a box of joint angles, and how far any point can move in it.

    Args:
        arm: the seven joints.
        bodies: its bodies.
        drawing: where the tree of links is.
        srdf: path or text of an SRDF file.

    Raises:
        InvalidRobot: the SRDF file is missing or no SRDF.
    """
    disabled = disabled_pairs(srdf) if srdf is not None else {}
    neighbours = _neighbours(arm, bodies, drawing)
    survey = None
    pairs = []
    ranges = []
    for i, j in combinations(range(len(bodies)), 2):
        a, b = bodies[i], bodies[j]
        if a.joint > b.joint:
            i, j, a, b = j, i, b, a
        names = frozenset((a.name, b.name))
        if a.joint == b.joint:
            pairs.append(Pair(a.name, b.name, False, "on one joint"))
        elif names in disabled:
            pairs.append(Pair(a.name, b.name, False, f"SRDF: {disabled[names]}"))
        elif srdf is not None and b.joint != a.joint + 2:
            pairs.append(Pair(a.name, b.name, True, "watched"))
        elif names in neighbours and srdf is None:
            pairs.append(Pair(a.name, b.name, False, "adjacent"))
        else:
            survey = survey or _Survey(arm, bodies)
            reason = survey.reason(i, j) if srdf is None else ""
            found = None if reason or b.joint - a.joint > _BETWEEN else survey.where(i, j)
            if found is None and not reason and b.joint == a.joint + 2:
                found = survey.joint_range(i, j)
            if found is not None and found.bounds.min() > 0.0:
                reason = "never meet (proved)"
            elif found is not None:
                ranges.append(found)
                pairs.append(Pair(a.name, b.name, True, f"watched, by the range of {arm.joint_names[found.joint]}"))
                continue
            pairs.append(Pair(a.name, b.name, not reason, reason or "watched"))
    return pairs, ranges


def with_overrides(
    pairs: Iterable[Pair], keep: Iterable[tuple[str, str]], drop: Iterable[tuple[str, str]]
) -> list[Pair]:
    """The pairs, some of them watched or not as their caller says."""
    kept, dropped = {frozenset(p) for p in keep}, {frozenset(p) for p in drop}
    out = []
    for pair in pairs:
        names = frozenset((pair.first, pair.second))
        if names in kept and pair.reason != "on one joint":
            pair = Pair(pair.first, pair.second, True, "watched, as asked for")
        elif names in dropped:
            pair = Pair(pair.first, pair.second, False, "dropped, as asked for")
        out.append(pair)
    return out


def _neighbours(arm: ChainKinematics, bodies: Sequence[Body], drawing: Drawing | None) -> set[frozenset[str]]:
    """Names of bodies that one of the joints connects, links without shapes between them left out."""
    joint_of = {frame.name: frame.parentJoint for frame in arm.model.frames if frame.name}
    shaped = {body.name for body in bodies}
    carrier: dict[str, str] = {child: parent for parent, child in read_tree(drawing)}
    found = set()
    for body in bodies:
        link, crossed = body.name, 0
        while link in carrier:
            parent = carrier[link]
            crossed += joint_of.get(parent) != joint_of.get(link)
            link = parent
            if link in shaped:
                if crossed:
                    found.add(frozenset((body.name, link)))
                break
    return found


class _Survey:
    """Bodies at random postures, and what that says of their pairs."""

    def __init__(self, arm: ChainKinematics, bodies: Sequence[Body]) -> None:
        from srs_ik.collision.parts import transform
        from srs_ik.collision.real import RealBodies

        self._arm, self._bodies, self._transform = arm, bodies, transform
        self._real = RealBodies(bodies)
        self._lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
        self._upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
        q = np.random.default_rng(0).uniform(self._lower, self._upper, (POSTURES, 7))
        self._postures = [self._frames(row) for row in q]
        self._zero = arm.joint_frames(np.zeros(7))
        self._axes = arm.jacobian(np.zeros(7))[3:].T
        self._hops = np.linalg.norm(np.diff(self._zero[:, :3, 3], axis=0), axis=1)
        self._sizes = [_size(body) for body in bodies]

    def _frames(self, q: Array) -> list[Any]:
        return [self._transform(T) for T in self._arm.joint_frames(q)]

    def reason(self, i: int, j: int) -> str:
        """Why two bodies need not be watched; empty where they have to."""
        if self._always_touch(i, j):
            return f"touch at more than {ALWAYS:.0%} of postures"
        return ""

    def joint_range(self, i: int, j: int) -> JointRange:
        """How near two bodies come that are two joints apart, told by the joint between them."""
        k = self._bodies[i].joint
        turn = float(self._lower[k + 1]), float(min(self._upper[k + 1], self._lower[k + 1] + 2.0 * np.pi))
        first, second = self._reaches(i, j).tolist()
        digest = self._digest(i, j, b"range")
        kept = store.load(digest)
        if kept is None:
            q = 0.5 * (self._lower + self._upper)

            def distance(first: float, second: float) -> float:
                q[k], q[k + 1] = first, second
                frames = self._frames(q)
                hulls = self._real.hull_distance(frames, i, j)
                return hulls if hulls > _FAR_APART else self._real.distance(frames, i, j)

            found = Bounds(distance, turn, (first, second)).over(float(self._lower[k]), float(self._upper[k]))
            kept = np.clip(found, -_NEVER, _NEVER)
            store.keep(digest, kept)
        edges = np.append(kept[:, 0], kept[-1, 1])
        return JointRange(i, j, k, edges, kept[:, 2].copy(), kept[:, 3].copy())

    def _reaches(self, i: int, j: int) -> Array:
        """How far a turn of each joint between two bodies moves a point of the one against the other, at most."""
        first, last = self._bodies[i].joint, self._bodies[j].joint
        reach = np.array([self._hops[k:last].sum() + self._sizes[j] for k in range(first + 1, last + 1)])
        # The first of these joints may as well turn the first body, and the last one turns the second about its axis.
        reach[0] = min(reach[0], self._from_axis(i, first))
        reach[-1] = min(reach[-1], self._from_axis(j, last - 1))
        return reach

    def _from_axis(self, i: int, k: int) -> float:
        """Largest distance of a point of a body from the axis of joint k, 0 to 6, at one end, m; 0 where round."""
        rows, zero = self._bodies[i].spheres, self._zero[self._bodies[i].joint]
        centres = rows[:, :3] @ zero[:3, :3].T + zero[:3, 3]
        origin = self._zero[k + 1, :3, 3]
        forms = self._bodies[i].forms
        if forms and is_round([form.moved(zero) for form in forms], origin, self._axes[k]):
            return 0.0
        across = np.cross(centres - origin, self._axes[k])
        return float((np.linalg.norm(across, axis=1) + rows[:, 3]).max())

    def _always_touch(self, i: int, j: int) -> bool:
        free = 0
        for frames in self._postures:
            free += not self._touch(frames, i, j)
            if free >= (1.0 - ALWAYS) * POSTURES:
                return False
        return True

    def _touch(self, frames: list[Any], i: int, j: int) -> bool:
        """Whether two bodies touch, or are a hair apart."""
        if self._real.hull_distance(frames, i, j) > _HAIR:
            return False
        return self._real.meet(frames, i, j) or self._real.distance(frames, i, j) <= _HAIR

    def where(self, i: int, j: int) -> JointRange | None:
        """A range of one joint in which two bodies are proved not to meet; None where it leaves too little.

        Its bounds are infinite where they never meet, and minus infinity elsewhere.
        """
        first, last = self._bodies[i].joint, self._bodies[j].joint
        digest = self._digest(i, j, b"where")
        kept = store.load(digest)
        if kept is None:
            kept = np.full((BOXES + 1, 4), -np.inf)
            boxes = self._doubtful(i, j)
            best = 0.0
            for k in range(first, last) if boxes is not None else ():
                edges = np.linspace(self._lower[k], self._upper[k], BOXES + 1)
                bounds = np.full(BOXES, np.inf)
                for lower, upper in boxes or []:
                    bounds[(edges[:-1] <= upper[k - first]) & (edges[1:] >= lower[k - first])] = -np.inf
                allowed = JointRange(i, j, k, edges, bounds, bounds).allowed()
                share = (allowed[1] - allowed[0]) / (edges[-1] - edges[0]) if allowed else 0.0
                if share > best:
                    best = share
                    kept[:, 0], kept[:-1, 1], kept[:, 2], kept[:, 3] = edges, bounds, k, share
            kept = np.clip(kept, -_NEVER, _NEVER)
            store.keep(digest, kept)
        if kept[0, 3] < _ENOUGH:
            return None
        tops = np.full(len(kept) - 1, _NEVER)
        return JointRange(i, j, int(kept[0, 2]), kept[:, 0].copy(), kept[:-1, 1].copy(), tops)

    def _doubtful(self, i: int, j: int) -> list[tuple[Array, Array]] | None:
        """Boxes of the joint angles between two bodies in which they may meet; None where these are too many."""
        first, last = self._bodies[i].joint, self._bodies[j].joint
        reach = self._reaches(i, j)
        joints = slice(first, last)
        waiting = [(self._lower[joints], self._upper[joints])]
        doubtful: list[tuple[Array, Array]] = []
        q = 0.5 * (self._lower + self._upper)
        for _ in range(_TRIES):
            if not waiting:
                return doubtful
            lower, upper = waiting.pop()
            q[joints] = 0.5 * (lower + upper)
            moves = 0.5 * (upper - lower) * reach
            frames = self._frames(q)
            distance = self._real.hull_distance(frames, i, j)
            if distance <= _APART + moves.sum():
                distance = self._real.distance(frames, i, j)
            if distance > _APART + moves.sum():
                continue
            if moves.sum() < _COARSE:
                doubtful.append((lower, upper))
                if len(doubtful) > _MOST_DOUBTFUL:
                    return None
                continue
            widest = int(moves.argmax())
            middle = 0.5 * (lower[widest] + upper[widest])
            below, above = upper.copy(), lower.copy()
            below[widest], above[widest] = middle, middle
            waiting += [(lower, below), (above, upper)]
        return None

    def _digest(self, i: int, j: int, what: bytes) -> str:
        """What tells a question about two bodies from all others."""
        bodies = self._bodies[i], self._bodies[j]
        figures = [figure for body in bodies for figure in (body.spheres, *(form.T for form in body.forms))]
        what += f" {BOXES} {FINE}".encode()
        return hashlib.sha256(what + key_of(self._lower, self._upper, self._zero, *figures)).hexdigest()


def _size(body: Body) -> float:
    """Largest distance of a point of a body from the origin of its joint, m."""
    return float((np.linalg.norm(body.spheres[:, :3], axis=1) + body.spheres[:, 3]).max())
