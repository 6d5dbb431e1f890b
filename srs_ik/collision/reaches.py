"""How far around an arm angle two bodies are certainly apart, or certainly in each other, by their real forms.

No point of a body that turns about a line moves farther than its distance from it times the angle. So two bodies that
are some distance apart stay so for that distance divided by this rate; and two convex ones that are some depth in each
other stay so for as long, since no motion shorter than that depth takes them out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from srs_ik.collision.parts import Part, apart, is_convex, transform
from srs_ik.collision.real_world import OBJECT, SPINNING, TURNING
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.real_world import RealWorld

TOUCH = 1e-5
"""Distances are known to this, m: coal's tolerance is 1e-6."""

_NARROW = 1e-6


class Hinge:
    """Bodies that the arm angle moves as one about the line shoulder-wrist, and those that it does not move.

    `frames` (8, 4, 4) are those of the joints at a posture, `psi` its arm angle, rad, `line` a point and the unit
    direction of the line, `margin` what is to be kept, m.
    """

    def __init__(self, world: RealWorld, frames: Array, psi: float, line: tuple[Array, Array], margin: float) -> None:
        self._world, self._frames, self._psi, self._line = world, frames, psi, line
        self._margin = margin + TOUCH
        self._placed: dict[int, list[_Placed]] = {}

    def look(self, a: int, b: int) -> Callable[[float, float], float]:
        """What `spans.certify` asks of two bodies."""
        first, second = self._body(a), self._body(b)
        if (self._world.joints[a] in TURNING) == (self._world.joints[b] in TURNING):
            # Nothing moves them against each other.
            reach = math.inf if _reach(first, second, self._margin, 1.0) > 0.0 else -math.inf
            return lambda psi, half: reach

        def reach_at(psi: float, half: float) -> float:
            turn = math.cos(psi - self._psi), math.sin(psi - self._psi)
            for each in (*first, *second):
                each.turn(turn)
            return _reach(first, second, self._margin, half)

        return reach_at

    def _body(self, k: int) -> list[_Placed]:
        if k not in self._placed:
            joint = self._world.joints[k]
            T = np.eye(4) if joint == OBJECT else self._frames[joint]
            line = self._line if joint in TURNING else None
            self._placed[k] = [_Placed(part, T, line) for part in self._world.parts[k]]
        return self._placed[k]


class _Placed:
    """A part where it is at a posture, and, if it turns about a line, where a turn takes it.

    Attributes:
        part: the part.
        at: where it is, as coal's transform.
        centre: of the sphere around it.
        rate: largest distance of its points from the line, m/rad; 0 where it stands still.
    """

    def __init__(self, part: Part, T: Array, line: tuple[Array, Array] | None) -> None:
        self.part = part
        placed = T @ part.T
        self.at = transform(placed)
        centre = T[:3, :3] @ part.ball[:3] + T[:3, 3]
        self.centre = (float(centre[0]), float(centre[1]), float(centre[2]))
        self.rate = 0.0
        self._terms: tuple[Array, Array, Array] | None = None
        if line is not None:
            point, u = line
            offset = part.points @ T[:3, :3].T + (T[:3, 3] - point)
            self.rate = float(np.linalg.norm(np.cross(offset, u), axis=1).max())
            # Columns: of the rotation, the origin, and the centre of the sphere around.
            rows = np.column_stack([placed[:3, :3], placed[:3, 3] - point, centre - point])
            along = np.outer(u, u @ rows)
            shift = np.zeros_like(rows)
            shift[:, 3:] = point[:, None]
            self._terms = along + shift, rows - along, np.cross(u, rows, axisb=0, axisc=0)

    def turn(self, turn: tuple[float, float]) -> None:
        """Turn it about the line, by an angle given by cosine and sine from where it was made."""
        if self._terms is None:
            return
        c, s = turn
        fixed, cosine, sine = self._terms
        rows = fixed + c * cosine + s * sine
        self.at.setRotation(rows[:, :3])
        self.at.setTranslation(rows[:, 3])
        self.centre = tuple(rows[:, 4].tolist())


def _reach(first: list[_Placed], second: list[_Placed], margin: float, best: float) -> float:
    """What `spans.certify` asks: as much as `best`, if no pair of parts says less."""
    for one in first:
        for other in second:
            rate = one.rate + other.rate
            balls = float(one.part.ball[3] + other.part.ball[3]) + margin
            room = math.dist(one.centre, other.centre) - balls
            if room > 0.0 and room >= best * rate:
                continue
            room = apart(one.part, one.at, other.part, other.at, best * rate + margin) - margin
            if room <= 0.0:
                return _hit(one.part, other.part, room, rate)
            best = min(best, room / rate if rate > 0.0 else math.inf)
    return best


def _hit(first: Part, second: Part, room: float, rate: float) -> float:
    if rate == 0.0:
        return -math.inf
    return room / rate if is_convex(first, second) else 0.0


class Rates(NamedTuple):
    """How fast joints of shoulder and wrist turn at most, rad/rad: the outer two of each, and the one between them."""

    shoulder: float
    second: float
    wrist: float
    sixth: float

    def of(self, joint: int) -> float:
        """Of one joint, 1 to 7; the elbow stands still."""
        shoulder, second, wrist, sixth = self
        return (shoulder, second, shoulder, 0.0, wrist, sixth, wrist)[joint - 1]


class Spinning:
    """The bodies of one branch, links 1, 2, 5 and 6 as they spin.

    `posture` gives the (7,) joint angles at an arm angle, None where there are none; `rates` how fast they turn at most
    within some arm angle; `line` is a point and the unit direction of the line shoulder-wrist, `margin` what is kept,
    m.
    """

    def __init__(
        self,
        world: RealWorld,
        posture: Callable[[float], Array | None],
        rates: Callable[[Array, float], Rates],
        line: tuple[Array, Array],
        margin: float,
    ) -> None:
        self._world, self._posture, self._rates, self._line = world, posture, rates, line
        self._margin = margin + TOUCH

    def look(self, a: int, b: int) -> Callable[[float, float], float]:
        """What `spans.certify` asks of two bodies."""
        turns: list[float] = []

        def reach_at(psi: float, half: float) -> float:
            q = self._posture(psi)
            if q is None:
                return 0.0
            places = self._world.places(q, (a, b))
            if not turns:
                # The same all around the line.
                turns.append(sum(self._world.turn(k, T, self._line) for k, T in zip((a, b), places, strict=True)))
            half = max(half, _NARROW)
            rate = self._rate(a, b, self._rates(q, half), turns[0])
            while not math.isfinite(rate) and half > _NARROW:
                half *= 0.5
                rate = self._rate(a, b, self._rates(q, half), turns[0])
            return self._reach((a, b), places, rate, half) if math.isfinite(rate) else 0.0

        return reach_at

    def _rate(self, a: int, b: int, rates: Rates, turn: float) -> float:
        """How fast two bodies move against each other at most, m/rad: about the line, or by the joints between."""
        world, joints = self._world, self._world.joints
        total = sum(world.spin(k) * rates.of(SPINNING[joints[k]] + 1) for k in (a, b) if joints[k] in SPINNING)
        if not (joints[a] in TURNING and joints[b] in TURNING):
            total += turn
        if joints[a] >= 0 and joints[b] == joints[a] + 2:
            # The first of the two joints may as well turn the other body; all their axes pass one centre.
            first = min(world.behind[a], world.radius[b] if joints[a] in (0, 1, 4, 5) else math.inf)
            own = first * rates.of(joints[a] + 1) + world.before[b] * rates.of(joints[b])
            total = min(total, own)
        return total

    def _reach(self, pair: tuple[int, int], places: Sequence[Array], rate: float, half: float) -> float:
        world, margin = self._world, self._margin
        at = [transform(T) for T in places]
        best = half
        for one in world.parts[pair[0]]:
            for other in world.parts[pair[1]]:
                room = apart(one, at[0] * one.at, other, at[1] * other.at, best * rate + margin) - margin
                if room <= 0.0:
                    return max(_hit(one, other, room, rate), -half)
                best = min(best, room / rate if rate > 0.0 else math.inf)
        return best
