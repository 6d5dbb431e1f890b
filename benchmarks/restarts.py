"""An independent solver to check what a map calls empty: Levenberg-Marquardt from many random joint angles.

It knows nothing of shoulders and wrists. Joint placements and axes are Pinocchio's, each step keeps the limits by
holding still the joints that would leave them, and Numba compiles it: a restart takes some 25 microseconds.
"""

from __future__ import annotations

import math

import numba
import numpy as np
import pinocchio as pin

STEPS = 60
FOUND = 1e-7
"""A posture meets its pose within this, m and rad."""

SLOW = 1e-6
"""A restart ends where a step gains less than this part of its cost, and the cost is not next to nothing."""


class Restarts:
    """The solver for one arm.

    Args:
        arm: the arm, of which the Pinocchio model is read.
        free: joints whose limits are set aside.
    """

    def __init__(self, arm, free=()):
        model, data = arm.model, arm.model.createData()
        q0 = arm.configuration(np.zeros(7))
        pin.framesForwardKinematics(model, data, q0)
        to_base = data.oMf[model.getFrameId(arm.base)].inverse()
        joints = [model.getJointId(name) for name in arm.joint_names]
        at_zero = [to_base * data.oMi[j] for j in joints]
        # At zero, axis and centre of each joint in the base frame: exp of each in turn moves the tip.
        twists = [pin.computeJointJacobian(model, data, q0, j) for j in joints]
        self.axes = np.array(
            [M.rotation @ J[3:, model.idx_vs[j]] for M, J, j in zip(at_zero, twists, joints, strict=True)]
        )
        self.points = np.array([M.translation for M in at_zero])
        self.tip = (to_base * data.oMf[model.getFrameId(arm.tip)]).homogeneous
        self.lower, self.upper = arm.lower.copy(), arm.upper.copy()
        self.lower[list(free)], self.upper[list(free)] = -np.inf, np.inf

    def forward(self, q):
        """(4, 4) pose of the tip, for a comparison with Pinocchio."""
        T = np.empty((4, 4))
        _forward(self.axes, self.points, self.tip, np.asarray(q, float), np.empty((7, 3)), np.empty((7, 3)), T)
        return T

    def best(self, goals, restarts, rng):
        """(N,) smallest error of poses (N, 4, 4) after so many restarts each, and (N, 7) its posture."""
        lower, upper = np.maximum(self.lower, -np.pi), np.minimum(self.upper, np.pi)
        starts = rng.uniform(lower, upper, (len(goals), restarts, 7))
        error, q = np.empty(len(goals)), np.empty((len(goals), 7))
        _search(self.axes, self.points, self.tip, self.lower, self.upper, goals, starts, error, q)
        return error, q


@numba.njit(cache=True)
def _forward(axes, points, tip, q, a, p, T):
    """Axes and centres of the joints, and the pose of the tip, by Rodrigues' formula joint after joint."""
    R, t, turned = np.eye(3), np.zeros(3), np.empty((3, 3))
    for j in range(7):
        c, s = math.cos(q[j]), math.sin(q[j])
        x, y, z = axes[j]
        for i in range(3):
            a[j, i] = R[i, 0] * x + R[i, 1] * y + R[i, 2] * z
            p[j, i] = R[i, 0] * points[j, 0] + R[i, 1] * points[j, 1] + R[i, 2] * points[j, 2] + t[i]
        for i in range(3):
            # R (c I + s [axis] + (1 - c) axis axis')
            r0, r1, r2, along = R[i, 0], R[i, 1], R[i, 2], (1.0 - c) * a[j, i]
            turned[i, 0] = c * r0 + s * (r1 * z - r2 * y) + along * x
            turned[i, 1] = c * r1 + s * (r2 * x - r0 * z) + along * y
            turned[i, 2] = c * r2 + s * (r0 * y - r1 * x) + along * z
        for i in range(3):
            t[i] = p[j, i]
            for k in range(3):
                R[i, k] = turned[i, k]
                t[i] -= turned[i, k] * points[j, k]
    for i in range(3):
        for k in range(4):
            T[i, k] = R[i, 0] * tip[0, k] + R[i, 1] * tip[1, k] + R[i, 2] * tip[2, k]
        T[i, 3] += t[i]
        T[3, i] = 0.0
    T[3, 3] = 1.0


@numba.njit(cache=True)
def _residual(T, goal, e):
    """Write position and rotation vector that are missing, in the base frame; return the square of their length."""
    E = np.empty((3, 3))
    for i in range(3):
        e[i] = goal[i, 3] - T[i, 3]
        for k in range(3):
            E[i, k] = goal[i, 0] * T[k, 0] + goal[i, 1] * T[k, 1] + goal[i, 2] * T[k, 2]
    x, y, z = E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]
    sine, cosine = 0.5 * math.sqrt(x * x + y * y + z * z), 0.5 * (E[0, 0] + E[1, 1] + E[2, 2] - 1.0)
    scale = 0.5 * math.atan2(sine, cosine) / sine if sine > 1e-12 else 0.5
    e[3], e[4], e[5] = scale * x, scale * y, scale * z
    total = 0.0
    for i in range(6):
        total += e[i] * e[i]
    return total


@numba.njit(cache=True)
def _step(J, e, damping, held, H, step):
    """Write the damped step of Gauss and Newton with the joints of a bit set held still, by Cholesky's method."""
    for i in range(7):
        still = (held >> i) & 1
        step[i] = 0.0
        for r in range(6):
            step[i] += 0.0 if still else J[r, i] * e[r]
        for k in range(i + 1):
            total = 0.0
            if not still and not (held >> k) & 1:
                for r in range(6):
                    total += J[r, i] * J[r, k]
            H[i, k] = total
        H[i, i] = 1.0 if still else H[i, i] + damping
    for i in range(7):
        for k in range(i + 1):
            total = H[i, k]
            for m in range(k):
                total -= H[i, m] * H[k, m]
            H[i, k] = math.sqrt(max(total, 1e-30)) if i == k else total / H[k, k]
        for m in range(i):
            step[i] -= H[i, m] * step[m]
        step[i] /= H[i, i]
    for i in range(6, -1, -1):
        for m in range(i + 1, 7):
            step[i] -= H[m, i] * step[m]
        step[i] /= H[i, i]


@numba.njit(cache=True)
def _search(axes, points, tip, lower, upper, goals, starts, errors, postures):
    a, p, T, e, tried = np.empty((7, 3)), np.empty((7, 3)), np.empty((4, 4)), np.empty(6), np.empty(6)
    J, H, step, following = np.empty((6, 7)), np.empty((7, 7)), np.empty(7), np.empty(7)
    for n in range(len(goals)):
        errors[n] = np.inf
        for k in range(starts.shape[1]):
            q = starts[n, k]
            damping = 1e-2
            _forward(axes, points, tip, q, a, p, T)
            cost = _residual(T, goals[n], e)
            for _ in range(STEPS):
                if cost < 1e-24 or damping > 1e6:
                    break
                for j in range(7):
                    x, y, z = T[0, 3] - p[j, 0], T[1, 3] - p[j, 1], T[2, 3] - p[j, 2]
                    J[0, j], J[1, j], J[2, j] = (
                        a[j, 1] * z - a[j, 2] * y,
                        a[j, 2] * x - a[j, 0] * z,
                        a[j, 0] * y - a[j, 1] * x,
                    )
                    J[3, j], J[4, j], J[5, j] = a[j]
                held, before = 0, -1
                while held != before:
                    before = held
                    _step(J, e, damping, held, H, step)
                    for j in range(7):
                        if (q[j] <= lower[j] and step[j] < 0.0) or (q[j] >= upper[j] and step[j] > 0.0):
                            held |= 1 << j
                for j in range(7):
                    following[j] = min(max(q[j] + step[j], lower[j]), upper[j])
                _forward(axes, points, tip, following, a, p, T)
                value = _residual(T, goals[n], tried)
                if value < cost:
                    slow = cost - value < SLOW * cost and value > 1e-8
                    cost, damping = value, max(0.2 * damping, 1e-12)
                    q[:] = following
                    e[:] = tried
                    if slow:
                        break
                else:
                    damping *= 5.0
                    _forward(axes, points, tip, q, a, p, T)
            if math.sqrt(cost) < errors[n]:
                errors[n] = math.sqrt(cost)
                postures[n] = q
            if errors[n] < FOUND:
                break
