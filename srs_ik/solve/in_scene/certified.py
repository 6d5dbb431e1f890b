"""Free arm angles on the real shapes, certified: distances by coal, against a bound on how far bodies can move.

At an arm angle, each pair of bodies is some distance apart. Within some angle of it, the upper arm and the forearm turn
about the line shoulder-wrist by no more than that, and links 1, 2, 5 and 6 spin beside by no more than the outer axes
of shoulder and wrist allow; so no point moves farther than is known, and no pair meets as long as that is less than
its distance. What is not shown to be free in this way counts as forbidden.

Source: F. Schwarzer, M. Saha, J.-C. Latombe, Adaptive Dynamic Collision Checking for Single and Multiple Articulated
Robots in Complex Environments, T-RO 21(3), 2005, with a bound for one arm angle.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.real import RealWorld
from srs_ik.solve import pose as pose_solver

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings

Array = NDArray[np.float64]

SPACING = 0.02
"""Arm angles from which free ones around are sought are this far apart, rad ..."""

FINEST = 2e-4
"""... and the search stops where less than this is gained, rad."""

_TOUCH = 1e-5
"""Distances are known to this, m: coal's tolerance is 1e-6."""


def certified_free(
    around: Surroundings, T: Array, found: Array, respect: bool, more: float = 0.0
) -> tuple[Array, float]:
    """(n, 3) what is certainly free of some intervals of a pose, sorted, and the width left undecided, rad.

    Undecided is what is neither certified nor next to a posture that hits something, within `SPACING`.
    """
    easy = around.by_spheres(T, around.in_range(T, found, respect), more)
    world = around.real_world()
    clear = around.clear_of_formless(T, found, more)
    pieces = []
    undecided = 0.0
    for branch, lower, upper in clear:
        own = [(max(a, lower), min(b, upper)) for a, b in _turned(easy[easy[:, 0] == branch], lower, upper)]
        known = _merged(own)
        search = _Search(around, world, T, int(branch), more)
        for a, b in _gaps(known, lower, upper):
            free, unsure = search.free(a, b)
            known += free
            undecided += unsure
        pieces += [(branch, a, b) for a, b in _merged(known)]
    return np.array(pieces).reshape(-1, 3), undecided


def _turned(rows: Array, lower: float, upper: float) -> list[tuple[float, float]]:
    """Ends of intervals in the turn in which they overlap another one."""
    turn = 2.0 * math.pi
    shifted = [(a + k * turn, b + k * turn) for _, a, b in rows for k in (-1, 0, 1)]
    return [(a, b) for a, b in shifted if b >= lower and a <= upper]


def _merged(ends: list[tuple[float, float]]) -> list[tuple[float, float]]:
    out: list[tuple[float, float]] = []
    for a, b in sorted(ends):
        if out and a <= out[-1][1]:
            out[-1] = out[-1][0], max(out[-1][1], b)
        else:
            out.append((a, b))
    return out


def _gaps(known: list[tuple[float, float]], lower: float, upper: float) -> list[tuple[float, float]]:
    """What sorted intervals leave between two ends."""
    at, gaps = lower, []
    for a, b in known:
        if a > at:
            gaps.append((at, a))
        at = max(at, b)
    return gaps if at >= upper else [*gaps, (at, upper)]


class _Search:
    """Free arm angles of one branch of a pose."""

    def __init__(self, around: Surroundings, world: RealWorld, T: Array, branch: int, more: float) -> None:
        self._arm, self._packed, self._world = around.arm, around.packed, world
        self._T, self._branch, self._margin = T, branch, around.margin + more
        limb = around.arm.limb
        wrist = T @ np.linalg.inv(limb.T_base_tip_zero) @ [*limb.wrist, 1.0]
        self._line = limb.shoulder, wrist[:3] - limb.shoulder
        self._constants = tuple(float(limb.axes[k] @ limb.axes[k + 1]) for k in (0, 1, 4, 5))

    def free(self, lower: float, upper: float) -> tuple[list[tuple[float, float]], float]:
        """Certainly free parts between two arm angles, and the width of what is undecided, rad."""
        count = max(1, math.ceil((upper - lower) / SPACING))
        starts = np.linspace(lower, upper, count + 1) if upper > lower else np.array([lower])
        known: list[tuple[float, float]] = []
        hits = []
        for psi in starts.tolist():
            if any(a <= psi <= b for a, b in known):
                continue
            reach = self._reach(psi)
            if reach <= 0.0:
                hits.append(psi)
                continue
            a, b = psi - reach, psi + reach
            while b < upper and (step := self._reach(b)) > FINEST:
                b += step
            while a > lower and (step := self._reach(a)) > FINEST:
                a -= step
            known.append((max(a, lower), min(b, upper)))
        known = _merged(known)
        unsure = 0.0
        for a, b in _gaps(known, lower, upper):
            # Around a posture that hits something it is clear that others do.
            steps = math.ceil((b - a) / SPACING)
            seen = sum(any(abs(hit - x) <= SPACING for hit in hits) for x in np.linspace(a, b, steps + 1)[:-1])
            unsure += (b - a) * (1.0 - seen / steps) if steps else 0.0
        return known, unsure

    def _reach(self, psi: float) -> float:
        """How far from an arm angle all are certainly free, rad; zero where its posture hits something."""
        answer = pose_solver.solve(self._packed, self._T, psi, None, self._branch, False)
        if not answer:
            return 0.0
        frames = self._arm.joint_frames(answer.q)
        axes = np.array([frames[k + 1, :3, :3] @ self._world.axes[k] for k in range(7)])
        angles = [
            math.atan2(float(np.linalg.norm(np.cross(axes[i], axes[j]))), float(axes[i] @ axes[j])) for i, j in _OUTER
        ]
        best = SPACING * 4.0
        return self._world.reach(frames, self._line, lambda w: self._spins(angles, w), self._margin + _TOUCH, best)

    def _spins(self, angles: list[float], width: float) -> tuple[float, float]:
        """How fast the outer joints of shoulder and wrist turn at most within some arm angle, rad/rad."""
        c12, c23, c56, c67 = self._constants
        return _fastest(angles[0], width, c12, c23), _fastest(angles[1], width, c56, c67)


_OUTER = ((0, 2), (4, 6))


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
