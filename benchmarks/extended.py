"""Postures closed with 64 bits of mantissa, where the 53 bits of a float do not tell two of them apart.

Next to a singular posture the smallest singular value of the Jacobian is that of the offset or less, and an error of
the pose divided by it is how far a posture may be from one that meets the pose: 0.01 rad for 1e-14 at 1e-12.
"""

from __future__ import annotations

import numpy as np

Long = np.longdouble

MET = 2e-18
"""Largest error of a posture, m and rad."""

STEPS = 60
LONGEST = 0.05
"""Newton's steps, and the longest one, rad."""

OUTSIDE = 1e-15
"""A joint this far outside its limit, rad, is on it."""


class ExtendedChain:
    """Seven axes as lines and the tip at zero, base frame."""

    def __init__(self, axes: np.ndarray, points: np.ndarray, tip: np.ndarray, R_tip: np.ndarray) -> None:
        axes = axes.astype(Long)
        self.axes = axes / np.sqrt((axes**2).sum(axis=1, keepdims=True))
        self.points, self.tip, self.R_tip = points.astype(Long), tip.astype(Long), R_tip.astype(Long)
        self.crosses = [np.cross(np.eye(3, dtype=Long), axis) for axis in self.axes]  # K v = axis x v

    def errors(self, q: np.ndarray, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(6,) twist that leads to a pose close by, and the (6, 7) Jacobian."""
        R, shift, J, seen = np.eye(3, dtype=Long), np.zeros(3, Long), np.empty((6, 7), Long), []
        for j in range(7):
            axis, point = R @ self.axes[j], R @ self.points[j] + shift
            seen.append((axis, point))
            K = self.crosses[j]
            R = R @ (np.eye(3, dtype=Long) + np.sin(q[j]) * K + 2.0 * np.sin(0.5 * q[j]) ** 2 * (K @ K))
            shift = point - R @ self.points[j]
        tip, D = R @ self.tip + shift, pose[:3, :3] @ (R @ self.R_tip).T
        for j, (axis, point) in enumerate(seen):
            J[:3, j], J[3:, j] = np.cross(axis, tip - point), axis
        turn = Long(0.5) * np.array([D[2, 1] - D[1, 2], D[0, 2] - D[2, 0], D[1, 0] - D[0, 1]])
        return np.concatenate([pose[:3, 3] - tip, turn]), J

    def closed(self, q: np.ndarray, pose: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray | None:
        """The posture inside the limits to which shortest steps lead; None where they lead to none."""
        q, pose = q.astype(Long), pose.astype(Long)
        free = np.ones(7, bool)
        for _ in range(STEPS):
            e, J = self.errors(q, pose)
            if np.abs(e).max() < MET:
                return q
            step = np.zeros(7, Long)
            found = shortest(J[:, free], e)
            if found is None:
                return None
            step[free] = found
            q = q + step * min(Long(1.0), LONGEST / np.abs(step).max())
            outside = (q < lower - OUTSIDE) | (q > upper + OUTSIDE)
            free &= ~outside
            q = np.clip(q, lower, upper)
        return None


def shortest(J: np.ndarray, e: np.ndarray) -> np.ndarray | None:
    """The shortest x with J x = e, by the method of Gram and Schmidt, each row made orthogonal twice."""
    n, m = J.shape
    if m < n:
        return None
    Q, L = np.zeros((n, m), Long), np.zeros((n, n), Long)
    for i in range(n):
        rest = J[i].copy()
        for _ in range(2):
            for k in range(i):
                share = Q[k] @ rest
                L[i, k] += share
                rest -= share * Q[k]
        L[i, i] = np.sqrt(rest @ rest)
        if L[i, i] == 0.0:
            return None
        Q[i] = rest / L[i, i]
    y = np.zeros(n, Long)
    for i in range(n):
        y[i] = (e[i] - L[i, :i] @ y[:i]) / L[i, i]
    return Q.T @ y
