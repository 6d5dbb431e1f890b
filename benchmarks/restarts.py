"""An independent solver to check what a map calls empty: Levenberg-Marquardt from many random joint angles.

It knows nothing of shoulders and wrists. Joint placements and axes are Pinocchio's, each step keeps the limits by
holding still the joints that would leave them, and NumPy makes a step for many poses at once: a restart takes some 200
microseconds.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

STEPS = 60
FOUND = 1e-7
"""A posture meets its pose within this, m and rad."""

SLOW = 1e-6
"""A restart ends where a step gains less than this part of its cost, and the cost is not next to nothing."""

HOLDS = 4
"""A step is made again so often without the joints that would leave their limits."""

AT_ONCE = 5_000


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
        self._cross = np.array([_skew(axis) for axis in self.axes])

    def forward(self, q):
        """(n, 3, 3) and (n, 3) rotation and position of the tip at (n, 7) angles, (n, 7, 3) axes and their centres."""
        n = len(q)
        R, t = np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3))
        axes, points = np.empty((n, 7, 3)), np.empty((n, 7, 3))
        for j in range(7):
            axes[:, j], points[:, j] = R @ self.axes[j], R @ self.points[j] + t
            K = self._cross[j]
            sine, cosine = np.sin(q[:, j])[:, None, None], np.cos(q[:, j])[:, None, None]
            R = R @ (np.eye(3) + sine * K + (1.0 - cosine) * (K @ K))
            t = points[:, j] - R @ self.points[j]
        return R @ self.tip[:3, :3], R @ self.tip[:3, 3] + t, axes, points

    def best(self, goals, restarts, rng):
        """(N,) smallest error of poses (N, 4, 4) after so many restarts each, m and rad in one."""
        lower, upper = np.maximum(self.lower, -np.pi), np.minimum(self.upper, np.pi)
        error = np.full(len(goals), np.inf)
        for _ in range(restarts):
            left = np.flatnonzero(error >= FOUND)
            for first in range(0, len(left), AT_ONCE):
                some = left[first : first + AT_ONCE]
                found = self._descend(goals[some], rng.uniform(lower, upper, (len(some), 7)))
                error[some] = np.minimum(error[some], found)
        return error

    def _descend(self, goals, q):
        """(n,) errors after a descent from (n, 7) angles."""
        n = len(q)
        cost, damping = np.empty(n), np.full(n, 1e-2)
        e, J = np.empty((n, 6)), np.empty((n, 6, 7))
        going = np.arange(n)
        cost[:], e[:], J[:] = self._linear(goals, q)
        for _ in range(STEPS):
            if not len(going):
                break
            at = q[going]
            step = self._step(J[going], e[going], damping[going], at)
            following = np.clip(at + step, self.lower, self.upper)
            value, next_e, next_J = self._linear(goals[going], following)
            better = value < cost[going]
            slow = better & (cost[going] - value < SLOW * cost[going]) & (value > 1e-8)
            took, kept = going[better], going[~better]
            q[took], e[took], J[took], cost[took] = following[better], next_e[better], next_J[better], value[better]
            damping[took] = np.maximum(0.2 * damping[took], 1e-12)
            damping[kept] *= 5.0
            going = going[~slow & (cost[going] >= 1e-24) & (damping[going] <= 1e6)]
        return np.sqrt(cost)

    def _linear(self, goals, q):
        """Squared error, the error as position and rotation vector in the base frame, and the Jacobian."""
        R, t, axes, points = self.forward(q)
        E = goals[:, :3, :3] @ R.transpose(0, 2, 1)
        twice = np.stack([E[:, 2, 1] - E[:, 1, 2], E[:, 0, 2] - E[:, 2, 0], E[:, 1, 0] - E[:, 0, 1]], axis=1)
        sine = 0.5 * np.linalg.norm(twice, axis=1)
        angle = np.arctan2(sine, 0.5 * (np.trace(E, axis1=1, axis2=2) - 1.0))
        scale = np.where(sine > 1e-12, 0.5 * angle / np.maximum(sine, 1e-12), 0.5)
        e = np.concatenate([goals[:, :3, 3] - t, scale[:, None] * twice], axis=1)
        J = np.concatenate([np.cross(axes, t[:, None] - points), axes], axis=2).transpose(0, 2, 1)
        return (e * e).sum(axis=1), e, J

    def _step(self, J, e, damping, q):
        """The damped step of Gauss and Newton, with the joints held still that would leave their limits."""
        moving = np.ones((len(q), 7))
        for _ in range(HOLDS):
            held = J * moving[:, None]
            H = held @ held.transpose(0, 2, 1) + damping[:, None, None] * np.eye(6)
            step = (held.transpose(0, 2, 1) @ np.linalg.solve(H, e[..., None]))[..., 0]
            leaving = ((q <= self.lower) & (step < 0.0)) | ((q >= self.upper) & (step > 0.0))
            if not leaving.any():
                break
            moving[leaving] = 0.0
        return step


def _skew(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
