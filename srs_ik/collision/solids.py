"""Real shapes as the convex solids that kernels read, `kernels.layout.shapes`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.parts import inner_radius
from srs_ik.collision.tables import PLACES
from srs_ik.kernels.layout import shapes as at
from srs_ik.kernels.layout.collision import BASE, UPPER
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.forms import Form
    from srs_ik.collision.parts import Part
    from srs_ik.robot.limb import SrsLimb

Integers = NDArray[np.int64]


class Carried(NamedTuple):
    """Bodies, and what carries them."""

    joints: Sequence[int]  # that carry each body, 0 for the root, negative for objects
    parts: Sequence[Sequence[Part]]  # of each body, in the frames of these joints
    # largest distance of a point of each from the axis that it spins about, m; 0 where it does not spin
    spins: Sequence[float]
    # of each body of the arm, the largest distance from the axis of the joint that carries it, from that of the next
    # one, and from the centre of the shoulder or the wrist, m
    reaches: Sequence[tuple[float, float, float]]


class Solids:
    """The solids of an arm and of what stands around it.

    Attributes:
        solids: (S, SOLID).
        of_solid: (S, OF_SOLID).
        points: (N, 3).
        bodies: (B, SHAPED).
        of_body: (B, OF_BODY).
        outer: (2, OUTER) axes of shoulder and wrist.
    """

    def __init__(self, carried: Carried, zero: Array, limb: SrsLimb) -> None:
        rows: list[tuple[Array, list[int], Array]] = []
        self.of_body = np.zeros((len(carried.joints), at.OF_BODY), np.int64)
        self.bodies = np.zeros((len(carried.joints), at.SHAPED))
        for k, (joint, spin) in enumerate(zip(carried.joints, carried.spins, strict=True)):
            T = np.eye(4) if joint < 0 else zero[joint]
            own = [_solid(part, T) for part in carried.parts[k]]
            place = BASE if joint < 0 else PLACES[joint]
            self.of_body[k] = len(rows), len(rows) + len(own), max(joint, 0), place, spin > 0.0
            if joint >= 0:
                self.bodies[k] = spin, *carried.reaches[k]
            rows += own
        self.points = np.concatenate([np.zeros((1, 3)), *(points for _, _, points in rows)])
        self.solids = np.array([row for row, _, _ in rows]).reshape(-1, at.SOLID)
        self.of_solid = np.zeros((len(rows), at.OF_SOLID), np.int64)
        count = 1
        for i, (_, (kind, whole), points) in enumerate(rows):
            self.of_solid[i] = kind, count, count + len(points), whole
            count += len(points)
        self.outer = np.array([outer_axes(*limb.axes[k : k + 3]) for k in (0, 4)])

    @property
    def tables(self) -> tuple[Array, Integers, Array, Array, Integers]:
        """What entries take: solids, of_solid, points, bodies, of_body."""
        return self.solids, self.of_solid, self.points, self.bodies, self.of_body

    def couples(
        self, rows: Sequence[tuple[int, int] | None], watched: Sequence[tuple[int, int]]
    ) -> tuple[Integers, list[tuple[int, int]]]:
        """(K, PAIR) the pairs of rows of tables, and others that are watched; the same by the numbers of bodies."""
        found = [(self._in_order(*pair), row) for row, pair in enumerate(rows) if pair is not None]
        seen = {frozenset(pair) for pair in rows if pair is not None}
        found += [(self._in_order(*pair, ranged=True), at.RANGED) for pair in watched if frozenset(pair) not in seen]
        couples = np.array([(a, b, row) for (a, b), row in found], np.int64).reshape(-1, at.PAIR)
        return couples, [pair for pair, _ in found]

    def _in_order(self, a: int, b: int, ranged: bool = False) -> tuple[int, int]:
        """What turns comes first; of bodies whose chain counts, the one nearer to the base, and objects last."""
        (_, _, joint_a, place_a, spins_a), (_, _, joint_b, place_b, spins_b) = self.of_body[[a, b]].tolist()
        if spins_a or spins_b or ranged:
            return (a, b) if joint_b == 0 or 0 < joint_a <= joint_b else (b, a)
        return (a, b) if place_a >= UPPER or place_b < UPPER else (b, a)


_SIGNS = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
"""The corners of a cube."""


def _solid(part: Part, T: Array) -> tuple[Array, list[int], Array]:
    """A row of solids, its kind and whether it is the whole of the part, and its points."""
    form: Form = part.form.moved(T)
    row = np.zeros(at.SOLID)
    row[at.CENTRE : at.CENTRE + 3] = T[:3, :3] @ part.ball[:3] + T[:3, 3]
    row[at.BALL] = part.ball[3]
    points = np.zeros((0, 3))
    kind = at.POINTS
    if form.kind == "cylinder":
        kind = at.CYLINDER
        row[at.AXIS : at.AXIS + 3] = form.T[:3, 2]
        row[at.RADIUS], row[at.HALF] = form.size[0], 0.5 * form.size[1]
    elif form.kind in ("sphere", "capsule"):
        row[at.RADIUS] = form.size[0]
        half = 0.5 * form.size[1] if form.kind == "capsule" else 0.0
        ends = [form.T[:3, 3] - half * form.T[:3, 2], form.T[:3, 3] + half * form.T[:3, 2]]
        points = np.array(ends[: 2 if half else 1])
    elif form.kind == "half_space":
        kind = at.HALF_SPACE
        row[at.AXIS : at.AXIS + 3] = form.T[:3, 2]
        points = form.T[None, :3, 3]
    elif form.kind == "box":
        points = form.T[:3, 3] + 0.5 * _SIGNS * np.array(form.size) @ form.T[:3, :3].T
    else:
        points = part.corners @ T[:3, :3].T + T[:3, 3]
    row[at.INNER], row[at.SEGMENT : at.SEGMENT + 3] = _within(form, points, row)
    return row, [kind, int(part.cover is None)], points


def _within(form: Form, points: Array, row: Array) -> tuple[float, Array]:
    """Radius and half the segment of a capsule within a form, about its centre; minus one for none."""
    axes = form.T[:3, :3]
    if form.kind == "half_space":
        return -1.0, np.zeros(3)
    if form.kind == "mesh":
        return inner_radius(points, row[at.CENTRE : at.CENTRE + 3]), np.zeros(3)
    if form.kind == "box":
        longest, radius = int(np.argmax(form.size)), 0.5 * min(form.size)
        return radius, (0.5 * form.size[longest] - radius) * axes[:, longest]
    radius = form.size[0]
    if form.kind == "sphere":
        return radius, np.zeros(3)
    half = 0.5 * form.size[1]
    if form.kind == "capsule":
        return radius, half * axes[:, 2]
    return min(radius, half), max(half - radius, 0.0) * axes[:, 2]


def outer_axes(first: Array, middle: Array, last: Array) -> tuple[Any, ...]:
    """(OUTER,) the outer ones of the three axes of shoulder or wrist."""
    to_first, to_last = (_rounded(float(axis @ middle)) for axis in (first, last))
    fixed = to_first * to_last
    return fixed, float(first @ last) - fixed, float(first @ np.cross(middle, last)), to_first, to_last


def _rounded(cosine: float) -> float:
    return 0.0 if abs(cosine) < _SQUARE else cosine


_SQUARE = 1e-9
"""Axes whose angle has a cosine below this are square to each other."""
