"""Postures of a dense sweep, and what they are worth, for all of them at once: NumPy on figures of Pinocchio.

Kernels make the postures, nothing else: Jacobians and torques come from Pinocchio's figures of the arm at zero, and
`difference` compares their values with Pinocchio's own.
"""

from __future__ import annotations

import numpy as np

import srs_ik
from srs_ik import Objective, Optimum

TURN = 2.0 * np.pi
SAME = 1e-9
"""Arm angles this near to an end (rad), distances (rad) and values (relative) this near to each other, are equal."""


def wrapped(angle: np.ndarray) -> np.ndarray:
    return (np.asarray(angle) + np.pi) % TURN - np.pi


def sweep(arm: srs_ik.Arm, pose: np.ndarray, count: int) -> tuple[np.ndarray, srs_ik.BatchSolution]:
    """Arm angles all around the circle, off any round figure, and every branch there without regard to limits."""
    angles = wrapped(np.linspace(-np.pi, np.pi, count, endpoint=False) + 1e-4)
    poses = np.broadcast_to(pose, (count, 4, 4))
    return angles, arm.solve_batch(poses, arm_angle=angles, all_branches=True, respect_limits=False)


def turned(arm: srs_ik.Arm, q: np.ndarray, near: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every joint in the turn inside its limits that is nearest to an angle, and whether there is one for all seven."""
    turns = q[..., None] + TURN * np.arange(-3, 4)
    away = np.where(
        (turns >= arm.lower[:, None]) & (turns <= arm.upper[:, None]), np.abs(turns - near[:, None]), np.inf
    )
    best = away.argmin(-1)
    return np.take_along_axis(turns, best[..., None], -1)[..., 0], np.isfinite(away.min(-1)).all(-1)


class Chain:
    """The arm at zero, by Pinocchio: joint axes as lines, the tip, and the weights, all in the base frame."""

    def __init__(self, arm: srs_ik.Arm) -> None:
        J = arm.jacobian(np.zeros(7))
        self.axes = J[3:].T
        self.tip = arm.forward_kinematics(np.zeros(7)).translation
        self.points = self.tip + np.cross(self.axes, J[:3].T)
        frames = arm.joint_frames(np.zeros(7))
        inertias = [arm.model.inertias[i] for i in range(1, 8)]
        self.masses = np.array([inertia.mass for inertia in inertias])
        self.centres = np.array([T[:3, :3] @ i.lever + T[:3, 3] for T, i in zip(frames[1:], inertias, strict=True)])
        self.gravity = frames[0, :3, :3] @ arm.model.gravity.linear

    def moved(self, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Axes (n, 7, 3), points on them (n, 7, 3), centres of mass (n, 7, 3) and tips (n, 3) at postures (n, 7)."""
        R, shift = np.broadcast_to(np.eye(3), (len(Q), 3, 3)), np.zeros((len(Q), 3))
        axes, points, centres = (np.empty((len(Q), 7, 3)) for _ in range(3))
        for j in range(7):
            K = np.cross(np.eye(3), self.axes[j])  # K v = a x v
            s, c = np.sin(Q[:, j])[:, None, None], np.cos(Q[:, j])[:, None, None]
            axes[:, j], points[:, j] = R @ self.axes[j], R @ self.points[j] + shift
            R = R @ (np.eye(3) + s * K + (1.0 - c) * (K @ K))
            shift = points[:, j] - R @ self.points[j]
            centres[:, j] = R @ self.centres[j] + shift
        return axes, points, centres, R @ self.tip + shift

    def jacobians(self, Q: np.ndarray) -> np.ndarray:
        """(n, 6, 7) Jacobians of the tip point in base axes, linear rows first."""
        axes, points, _, tip = self.moved(Q)
        return np.concatenate([np.cross(axes, tip[:, None] - points), axes], axis=2).transpose(0, 2, 1)

    def torques(self, Q: np.ndarray) -> np.ndarray:
        """(n, 7) torques that hold the arm against its weight, N m."""
        axes, points, centres, _ = self.moved(Q)
        weight = self.masses[:, None] * self.gravity
        carried = np.arange(7)[:, None] <= np.arange(7)
        moments = np.cross(centres[:, None] - points[:, :, None], weight) * carried[..., None]
        return -np.einsum("nji,njki->nj", axes, moments)


def swept_values(arm: srs_ik.Arm, chain: Chain, objective: Objective, Q: np.ndarray) -> list[np.ndarray]:
    """Values of postures (n, 7): (n,), and for a lexicographic objective those of its second one as well."""
    given = objective.parameters
    if objective.name == "gravity_torque":
        scale = 1.0 / arm.effort_limit if np.isfinite(arm.effort_limit).all() else np.ones(7)
        return [((chain.torques(Q) * scale) ** 2).sum(-1)]
    if objective.name == "reference_posture":
        return [((Q - given["reference"]) ** 2).sum(-1)]
    if objective.name == "limit_margin":
        half = 0.5 * (arm.upper - arm.lower)
        room = np.minimum(Q - arm.lower, arm.upper - Q)
        return [np.where(np.isfinite(half), room / np.where(np.isfinite(half), half, 1.0), 1.0).min(-1)]
    J = chain.jacobians(Q)
    if objective.name == "manipulability":
        return [np.prod(np.linalg.svd(J, compute_uv=False), axis=-1)]
    if objective.name in ("twist", "wrench"):
        return [((given[objective.name] @ J) ** 2).sum(-1)]
    force, velocity = (((given[key] @ J[:, :3]) ** 2).sum(-1) for key in ("force", "velocity"))
    if objective.name == "force_velocity_ratio":
        return [force / velocity]
    return [force, velocity] if objective.name == "force_then_velocity" else [velocity, force]


def difference(arm: srs_ik.Arm, objective: Objective, q: np.ndarray, values: list[float]) -> float:
    """Largest relative difference of the values of one posture from those by Pinocchio."""
    measured = objective.values(arm, q)
    return max(abs(a - b) / max(abs(b), 1e-12) for a, b in zip(values, measured, strict=True))


def excess(arm: srs_ik.Arm, pose: np.ndarray, best: Optimum, values: list[np.ndarray]) -> float:
    """By how much an optimum is worse than the best of a sweep, relative to it; negative where it is better.

    A lexicographic one may be worse in three ways: its first value is not within the tolerance of the best, that best
    is not the best, or a posture within the tolerance has a better second value.
    """
    objective = best.objective
    sign = -1.0 if objective.maximise else 1.0
    first = sign * values[0]
    if len(values) == 1:
        return relative(sign * best.value, first.min())
    exact = sign * arm.optimise(pose, Objective(objective.name, **objective.parameters, tolerance=0.0)).value
    cap = exact + objective.tolerance * abs(exact)
    rivals = -sign * values[1][first <= cap]
    least = [relative(exact, first.min()), relative(sign * best.value, cap)]
    if rivals.size:
        least.append(relative(-sign * best.second_value, rivals.min()))
    return max(least)


def relative(value: float, best: float) -> float:
    return (value - best) / max(abs(best), 1e-12)
