"""Planned movements of the hand: minimum jerk, harmonic, and by passive motion, which plans the posture with it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from srs_ik.arm import Arm
from srs_ik.inputs import control as given
from srs_ik.inputs.angles import as_bounded_joint_vector
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.system.arrays import Array


def minimum_jerk(share: ArrayLike) -> Array:
    """Share of the way after shares (n,) of the time, both from 0 to 1: peak speed is 1.875 times the mean.

    Raises:
        InvalidController: a share is no finite number.

    Source: T. Flash, N. Hogan, The coordination of arm movements, J. Neuroscience 5(7), 1985.
    """
    s = np.clip(given.distances(share, "the share"), 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def harmonic(share: ArrayLike) -> Array:
    """Half a cosine, as a fractal impedance moves a free mass: peak speed is pi/2 times the mean.

    Raises:
        InvalidController: a share is no finite number.
    """
    s = np.clip(given.distances(share, "the share"), 0.0, 1.0)
    return 0.5 - 0.5 * np.cos(np.pi * s)


def between(T_start: PoseLike, T_end: PoseLike, way: ArrayLike) -> Array:
    """Poses (n, 4, 4) on the straight line between two poses, turned about one axis, at shares of the way (n,).

    Raises:
        InvalidPose: a pose is no finite rigid transform.
        InvalidController: a share is no finite number.
    """
    shares = given.distances(way, "the way").ravel()
    A, B = as_rigid_matrix(T_start), as_rigid_matrix(T_end)
    turn = pin.log3(A[:3, :3].T @ B[:3, :3])
    poses = np.tile(np.eye(4), (shares.size, 1, 1))
    for pose, s in zip(poses, shares, strict=True):
        pose[:3, :3] = A[:3, :3] @ pin.exp3(float(s) * turn)
        pose[:3, 3] = A[:3, 3] + float(s) * (B[:3, 3] - A[:3, 3])
    return poses


def passive_motion(
    arm: Arm, q: ArrayLike, T_end: PoseLike, count: int, compliance: ArrayLike = 1.0, turning: float = 0.1
) -> Array:
    """Joint angles (count, 7) of an arm that its target drags along, at rest in its joints: no inverse kinematics.

    dq/dt = gamma(t) C J' K e with a time base that ends the motion in finite time, scaled so that the tip arrives
    where J C J' K lets it.

    Args:
        arm: the arm.
        q: (7,) where it starts, rad.
        T_end: pose of the tip at the end.
        count: samples, evenly spaced in time.
        compliance: of the joints, one or (7,), relative.
        turning: stiffness of the turn, relative to that of the tip point, m^2/rad.

    Raises:
        InvalidConfiguration: q is not 7 finite angles.
        InvalidPose: the pose is no finite rigid transform.
        InvalidController: no arm, or a figure that is none.

    Source: F. A. Mussa Ivaldi, P. Morasso, R. Zaccaria, Kinematic networks, Biological Cybernetics 60, 1988.
    """
    given.thing(arm, Arm, "arm", "srs_ik.load")
    q, T, count = as_bounded_joint_vector(q), as_rigid_matrix(T_end), given.count(count, "count")
    C = given.seven_not_negative(compliance, "compliance")
    K = np.repeat([1.0, given.not_negative(turning, "turning")], 3)
    way = minimum_jerk(np.linspace(0.0, 1.0, count))
    path = np.empty((count, 7))
    for i in range(count):
        path[i] = q
        if i + 1 == count:
            break
        now = arm.forward_kinematics(q)
        error = np.append(T[:3, 3] - now.translation, pin.log3(T[:3, :3] @ now.rotation.T))
        J = arm.jacobian(q)
        pull = C * (J.T @ (K * error))
        moved = J @ pull
        # The longest step along this pull that still brings the tip nearer.
        best = float(moved @ (K * error)) / max(float(moved @ (K * moved)), 1e-300)
        share = (way[i + 1] - way[i]) / max(1.0 - way[i], 1e-12)
        q = q + min(share, 1.0) * best * pull
    return path
