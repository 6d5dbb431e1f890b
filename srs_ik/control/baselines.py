"""What torque control by superposition is compared with, each as it is written in textbooks, by Pinocchio's dynamics.

All three have the weight of the arm held, as `TorqueController` has, and the interface of it: `torque(q, v)`,
`set_target`. Until a target is set they hold the weight alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from srs_ik.analysis.gravity import require_masses
from srs_ik.arm import Arm
from srs_ik.inputs.angles import as_bounded_joint_vector, as_joint_vector
from srs_ik.inputs.control import not_negative, one_of, positive, thing, vector
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.system.arrays import Array

Inverse = Literal["pinv", "damped"]

DETERMINANT = 1e-2
"""Determinant of J M^-1 J' under which the plain form changes to a pseudo-inverse, as it is copied from program to
program."""

WEAK = (1e-5, 1e-4)
"""Eigenvalues of J M^-1 J' between which the damped form fades a direction out, m^2/(kg m^2) and the like."""

_LOWER = np.tril_indices(7, -1)


@dataclass(frozen=True)
class Gains:
    """Stiffness and damping of the baselines.

    Attributes:
        point: stiffness of the tip point, N/m; for operational space per unit of mass, 1/s^2.
        turn: stiffness of its orientation, N m/rad; for operational space 1/s^2.
        joints: stiffness of the joints, N m/rad; in the null space of operational space 1/s^2.
        ratio: damping ratio.

    Raises:
        InvalidController: a figure is negative, or no number.
    """

    point: float = 1000.0
    turn: float = 60.0
    joints: float = 100.0
    ratio: float = 1.0

    def __post_init__(self) -> None:
        for name in ("point", "turn", "joints", "ratio"):
            not_negative(getattr(self, name), f"{name} of the gains")


class _Baseline:
    """Dynamics and target, which all baselines share; they hold the weight alone until they have a target.

    Raises:
        InvalidController: a thing of another class, or a figure that is none.
        InvalidTask: the arm has no masses.
    """

    def __init__(self, arm: Arm, gains: Gains | None, usual: Gains) -> None:
        self.arm = thing(arm, Arm, "arm", "srs_ik.load")
        self.gains = usual if gains is None else thing(gains, Gains, "set of gains")
        require_masses(arm, "load a description with inertias")
        self._data = arm.model.createData()
        self._endless = np.isinf(arm.lower) & np.isinf(arm.upper)
        self._T = np.eye(4)
        self._q = np.zeros(7)
        self.gravity_torque = np.zeros(7)
        self.energy = 0.0
        self._aimed = False

    def set_target(self, pose: PoseLike, arm_angle: float | None = None, seed: ArrayLike | None = None) -> Any:
        """Aim at a pose, and at the posture that `Arm.solve` gives for it.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidConfiguration: arm angle or seed are malformed.
        """
        T = as_rigid_matrix(pose)
        solution = self.arm.solve(T, arm_angle=arm_angle, seed=seed)
        self._T, self._q, self._aimed = T, solution.q, True
        return solution

    def set_posture(self, q: ArrayLike) -> None:
        """Aim at seven joint angles, rad, and the pose of the tip there."""
        self._q = as_bounded_joint_vector(q)
        self._T, self._aimed = self.arm.forward_kinematics(self._q).homogeneous, True

    def torque(self, q: Array, v: Array) -> Array:
        """Torques of the joints, (7,), N m.

        Args:
            q: (7,) joint angles, rad.
            v: (7,) joint speeds, rad/s.

        Raises:
            InvalidConfiguration: not 7 finite figures each.
        """
        q, v = as_bounded_joint_vector(q), as_joint_vector(v, "v")
        if not self._aimed:
            self._dynamics(q, v)
            return self.gravity_torque.copy()
        return self._torque(q, v)

    def _torque(self, q: Array, v: Array) -> Array:
        raise NotImplementedError

    def _error(self, q: Array) -> tuple[Array, Array]:
        """Twist (6,) from the tip to its target, base axes, and the Jacobian (6, 7)."""
        T = self.arm.forward_kinematics(q)
        turn = pin.log3(self._T[:3, :3] @ T.rotation.T)
        return np.append(self._T[:3, 3] - T.translation, turn), self.arm.jacobian(q)

    def _way(self, q: Array) -> Array:
        """(7,) from joint angles to those of the target, rad; the short way round where a joint has no limits."""
        way = self._q - q
        return np.where(self._endless, np.remainder(way + np.pi, 2.0 * np.pi) - np.pi, way)

    def _dynamics(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Mass matrix (7, 7) and bias torques (7,); notes those of gravity."""
        configuration = self.arm.configuration(q)
        model, data = self.arm.model, self._data
        M = pin.crba(model, data, configuration)
        # Pinocchio fills the upper triangle alone.
        M[_LOWER] = M.T[_LOWER]
        self.gravity_torque = np.array(pin.computeGeneralizedGravity(model, data, configuration))
        return M, np.array(pin.nonLinearEffects(model, data, configuration, v))


class OperationalSpace(_Baseline):
    """Operational space control with a posture in the dynamically consistent null space.

    tau = J' Lambda (kp e - kd J v) + (I - J' Jbar') M (kp (q_d - q) - kd v) + h, Lambda = (J M^-1 J')^-1,
    Jbar = M^-1 J' Lambda.

    Args:
        arm: the arm.
        gains: stiffness and damping.
        inverse: of J M^-1 J': "pinv" as everybody has it, the inverse, and a pseudo-inverse where the determinant is
            below 1e-2; or "damped", eigenvalue by eigenvalue, smoothly faded out from 1e-4 down to 1e-5.

    Source: O. Khatib, A unified approach for motion and force control of robot manipulators, IEEE J. Robotics and
    Automation 3(1), 1987.
    """

    def __init__(self, arm: Arm, gains: Gains | None = None, inverse: Inverse = "damped") -> None:
        self.inverse = one_of(inverse, ("pinv", "damped"), "an inverse is")
        super().__init__(arm, gains, Gains(point=400.0, turn=400.0, joints=100.0))

    def _torque(self, q: Array, v: Array) -> Array:
        M, h = self._dynamics(q, v)
        error, J = self._error(q)
        g = self.gains
        kp = np.repeat([g.point, g.turn], 3)
        M_inverse = np.linalg.inv(M)
        mobility = J @ M_inverse @ J.T
        inertia = _inverse(mobility) if self.inverse == "pinv" else _faded_inverse(mobility)
        wanted = kp * error - 2.0 * g.ratio * np.sqrt(kp) * (J @ v)
        null = np.eye(7) - J.T @ inertia @ J @ M_inverse
        posture = g.joints * self._way(q) - 2.0 * g.ratio * np.sqrt(g.joints) * v
        return J.T @ (inertia @ wanted) + null @ (M @ posture) + h


class LinearImpedance(_Baseline):
    """Superposition of linear springs and dampers on tip and elbow: what a fractal impedance is without its fractal.

    Args:
        arm: the arm.
        gains: stiffness and damping; that of the joints is a spring on every joint angle.
        masses: kg and kg m^2, to which the damping ratio refers at the tip point and for its turn.
    """

    def __init__(self, arm: Arm, gains: Gains | None = None, masses: tuple[float, float] = (3.0, 0.01)) -> None:
        point, turn = vector(masses, "pair of masses", 2)
        self.masses = positive(point, "mass at the tip"), positive(turn, "inertia at the tip")
        super().__init__(arm, gains, Gains(joints=10.0))

    def _torque(self, q: Array, v: Array) -> Array:
        self._dynamics(q, v)
        error, J = self._error(q)
        g = self.gains
        kp = np.repeat([g.point, g.turn], 3)
        kd = 2.0 * g.ratio * np.sqrt(kp * np.repeat(self.masses, 3))
        posture = g.joints * self._way(q) - 2.0 * g.ratio * np.sqrt(0.1 * g.joints) * v
        return J.T @ (kp * error - kd * (J @ v)) + posture + self.gravity_torque


class JointImpedance(_Baseline):
    """Springs and dampers on the joints, around the posture that inverse kinematics gives; scaled by the mass matrix.

    Args:
        arm: the arm.
        gains: that of the joints counts, 1/s^2.
    """

    def __init__(self, arm: Arm, gains: Gains | None = None) -> None:
        super().__init__(arm, gains, Gains(joints=400.0))

    def _torque(self, q: Array, v: Array) -> Array:
        M, h = self._dynamics(q, v)
        k = self.gains.joints
        return M @ (k * self._way(q) - 2.0 * self.gains.ratio * np.sqrt(k) * v) + h


def _inverse(A: Array) -> Array:
    inverse: Any = np.linalg.inv(A) if abs(np.linalg.det(A)) >= DETERMINANT else np.linalg.pinv(A, rcond=DETERMINANT)
    return np.asarray(inverse)


def _faded_inverse(A: Array) -> Array:
    """Inverse of a symmetric matrix, its weak directions left out; between the thresholds, in part."""
    values, axes = np.linalg.eigh(A)
    low, high = WEAK
    share = np.clip((values - low) / (high - low), 0.0, 1.0)
    smooth = share * share * (3.0 - 2.0 * share)
    inverse: Any = (axes * (smooth / np.maximum(values, low))) @ axes.T
    return np.asarray(inverse, dtype=np.float64)
