"""Postures closed with 64 bits of mantissa, or with 40 digits, where the 53 bits of a float do not tell two apart.

Next to a singular posture the smallest singular value of the Jacobian is that of the offset or less, and an error of
the pose divided by it is how far a posture may be from one that meets the pose: 0.01 rad for 1e-14 at 1e-12. With a
joint on a limit that it hardly leaves along the curve, one small number is divided by another.
"""

from __future__ import annotations

import mpmath
import numpy as np

Long = np.longdouble

MET = 2e-18
"""Largest error of a posture, m and rad."""

DIGITS, MET_IN_DIGITS = 40, 1e-35
"""Decimal digits where 64 bits are too few, and the largest error with so many."""

STEPS = 60
LONGEST = 0.05
"""Newton's steps, and the longest one, rad."""

OUTSIDE = 1e-15
"""A joint this far outside its limit, rad, is on it."""


class ExtendedChain:
    """Seven axes as lines and the tip at zero, base frame."""

    met = MET
    sine = staticmethod(np.sin)

    def __init__(self, axes: np.ndarray, points: np.ndarray, tip: np.ndarray, R_tip: np.ndarray) -> None:
        axes = self.long(axes)
        self.axes = axes / (axes**2).sum(axis=1, keepdims=True) ** 0.5
        self.points, self.tip, self.R_tip, self.eye = map(self.long, (points, tip, R_tip, np.eye(3)))
        self.crosses = [np.cross(self.eye, axis) for axis in self.axes]  # K v = axis x v

    def long(self, array: np.ndarray) -> np.ndarray:
        """Floats as numbers with more bits."""
        return array.astype(Long)

    def errors(self, q: np.ndarray, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(6,) twist that leads to a pose close by, and the (6, 7) Jacobian."""
        R, shift, J, seen = self.eye, self.long(np.zeros(3)), self.long(np.empty((6, 7))), []
        for j in range(7):
            axis, point = R @ self.axes[j], R @ self.points[j] + shift
            seen.append((axis, point))
            K = self.crosses[j]
            R = R @ (self.eye + self.sine(q[j]) * K + 2.0 * self.sine(0.5 * q[j]) ** 2 * (K @ K))
            shift = point - R @ self.points[j]
        tip, D = R @ self.tip + shift, pose[:3, :3] @ (R @ self.R_tip).T
        for j, (axis, point) in enumerate(seen):
            J[:3, j], J[3:, j] = np.cross(axis, tip - point), axis
        turn = 0.5 * np.array([D[2, 1] - D[1, 2], D[0, 2] - D[2, 0], D[1, 0] - D[0, 1]])
        return np.concatenate([pose[:3, 3] - tip, turn]), J

    def closed(
        self, q: np.ndarray, pose: np.ndarray, lower: np.ndarray, upper: np.ndarray, held: np.ndarray | None = None
    ) -> np.ndarray | None:
        """The posture inside the limits to which shortest steps lead; None where they lead to none.

        Args:
            q: the posture from which they lead.
            pose: (4, 4) pose.
            lower: lower limits.
            upper: upper limits.
            held: joints that stay where they are, (7,); by default none.
        """
        q, pose = self.long(q), self.long(pose)
        free = np.ones(7, bool) if held is None else ~held
        for _ in range(STEPS):
            e, J = self.errors(q, pose)
            if np.abs(e).max() < self.met:
                return q
            step = self.long(np.zeros(7))
            found = shortest(J[:, free], e)
            if found is None:
                return None
            step[free] = found
            q = q + step * min(1.0, LONGEST / np.abs(step).max())
            outside = (q < lower - OUTSIDE) | (q > upper + OUTSIDE)
            free &= ~outside
            q = np.clip(q, lower, upper)
        return None


class ChainInDigits(ExtendedChain):
    """The same with decimal digits, which is a thousand times slower."""

    met = MET_IN_DIGITS
    sine = staticmethod(mpmath.sin)

    def long(self, array: np.ndarray) -> np.ndarray:
        mpmath.mp.dps = DIGITS
        return np.vectorize(mpmath.mpf, otypes=[object])(array)


def shortest(J: np.ndarray, e: np.ndarray) -> np.ndarray | None:
    """The shortest x with J x = e, by the method of Gram and Schmidt, each row made orthogonal twice."""
    n, m = J.shape
    if m < n:
        return None
    Q, L = np.zeros_like(J), np.zeros_like(J[:, :n])
    for i in range(n):
        rest = J[i].copy()
        for _ in range(2):
            for k in range(i):
                share = Q[k] @ rest
                L[i, k] += share
                rest -= share * Q[k]
        L[i, i] = (rest @ rest) ** 0.5
        if L[i, i] == 0.0:
            return None
        Q[i] = rest / L[i, i]
    y = np.zeros_like(e)
    for i in range(n):
        y[i] = (e[i] - L[i, :i] @ y[:i]) / L[i, i]
    return Q.T @ y
