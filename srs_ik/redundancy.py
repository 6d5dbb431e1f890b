"""A limb with its redundancy: where a configuration is on its circle, and how joints and arm angle move together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.inputs.poses import as_joint_vector
from srs_ik.kernels.entries import rates
from srs_ik.mounted import MountedLimb
from srs_ik.robot.chain import Chain
from srs_ik.robot.limb import Hand, SrsLimb
from srs_ik.solve.packed import pack_family

if TYPE_CHECKING:
    from srs_ik.robot.description.model import Drawing

Array = NDArray[np.float64]


class RedundantLimb(MountedLimb):
    """The limb with the seventh coordinate that its tip pose leaves open: branch and arm angle."""

    def __init__(
        self, chain: Chain, limb: SrsLimb, name: str, hand: Hand | None = None, drawing: Drawing | None = None
    ) -> None:
        super().__init__(chain, limb, name, hand, drawing)
        self._family = pack_family(limb, chain.lower, chain.upper)

    def arm_angle(self, q: ArrayLike) -> float:
        """Arm angle of a configuration, in [-pi, pi), rad: right-handed about shoulder-wrist, zero at `limb.reference`.

        Raises:
            InvalidConfiguration: not 7 finite angles.
        """
        return float(rates.configuration_arm_angle(self._family, as_joint_vector(q))[0])

    def branch(self, q: ArrayLike) -> int:
        """Branch of a configuration, 0 to 7.

        Raises:
            InvalidConfiguration: not 7 finite angles.
        """
        return int(rates.configuration_arm_angle(self._family, as_joint_vector(q))[1])

    def arm_angle_jacobian(self, q: ArrayLike) -> Array:
        """Derivatives of the arm angle by the joint angles, (7,), rad/rad: its rate is ``arm_angle_jacobian(q) @ dq``.

        Below `jacobian` it makes a square matrix, ``np.vstack([arm.jacobian(q), arm.arm_angle_jacobian(q)])``, that is
        regular where the tip pose and the arm angle together determine the joint rates. All are zero where the arm
        angle has no derivative: with shoulder to wrist along `limb.reference` (to 1e-8 rad), with the wrist on the
        shoulder, and, on a near limb alone, with the elbow on the line between them (to a micrometre). Close to
        these places they grow without bound.

        Raises:
            InvalidConfiguration: not 7 finite angles.

        Source: the derivative of the definition, for any axes; for perpendicular ones see K. Kreutz-Delgado, M. Long,
        H. Seraji, Kinematic Analysis of 7-DOF Manipulators, IJRR 11(5), 1992.
        """
        derivatives = np.empty(7)
        rates.arm_angle_jacobian(self._family, as_joint_vector(q), derivatives)
        return derivatives

    def self_motion_tangent(self, q: ArrayLike) -> Array:
        """How the joints move with the arm angle while the tip stands still: dq/d(arm angle), (7,), rad/rad.

        Where `jacobian` with `arm_angle_jacobian` below it is regular, it is the last column of the inverse of that
        matrix; on an exact limb with a straight elbow, it is the motion that keeps that straight. All are zero where
        the arm angle has no derivative, and where the joints would have to move infinitely fast: with the outer axes of
        the shoulder or of the wrist in line. Close to these places they grow without bound.

        Raises:
            InvalidConfiguration: not 7 finite angles.
        """
        derivatives = np.empty(7)
        rates.self_motion_tangent(self._family, as_joint_vector(q), derivatives)
        return derivatives
