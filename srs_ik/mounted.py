"""A limb as it is used: with its hand, with a tool, in surroundings that have a frame of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from srs_ik.errors import NotAnSrsLimb
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.kinematics import ChainKinematics
from srs_ik.robot import changes
from srs_ik.robot.chain import Chain
from srs_ik.robot.limb import Hand, SrsLimb
from srs_ik.robot.recognition import recognise

if TYPE_CHECKING:
    from srs_ik.robot.description.model import Drawing

Array = NDArray[np.float64]


class MountedLimb(ChainKinematics):
    """The 7 joints between two frames, recognised as a limb, with what they carry and what carries them.

    Attributes:
        limb: the recognised limb.
        hand: axes of the hand, where known.
        drawing: where the shapes of the robot are; None if it was loaded from a ``pinocchio.Model`` or MJCF.
    """

    def __init__(
        self, chain: Chain, limb: SrsLimb, name: str, hand: Hand | None = None, drawing: Drawing | None = None
    ) -> None:
        super().__init__(chain, name)
        self._chain = chain
        self.limb = limb
        self.hand = hand
        self.drawing = drawing

    def with_tool(self, T_tip_tool: PoseLike, name: str | None = None) -> Self:
        """This arm with a tool: poses are those of the tool's frame from then on. The arm itself stays as it is.

        Args:
            T_tip_tool: pose of the tool in the tip frame.
            name: name of the tool's frame; by default "tool", numbered where that is taken.

        Raises:
            InvalidPose: no finite rigid transform.
            InvalidRobot: the robot has a frame of that name already.
        """
        T = as_rigid_matrix(T_tip_tool)
        hand = self.hand and Hand(*(tuple((T[:3, :3].T @ axis).tolist()) for axis in self.hand))
        return self._again(changes.with_tool(self._chain, T, name), self.limb.reference, hand)

    def with_base(self, T_newbase_base: PoseLike, name: str | None = None) -> Self:
        """This arm in other surroundings: poses are given in their frame from then on. The arm itself stays as it is.

        The reference of the arm angle turns with the arm, so that every posture keeps its arm angle.

        Args:
            T_newbase_base: pose of the base frame in the new base frame, such as that of a table or a room.
            name: name of the new base frame; by default "world", numbered where that is taken.

        Raises:
            InvalidPose: no finite rigid transform.
            InvalidRobot: the robot has a frame of that name already.
        """
        T = as_rigid_matrix(T_newbase_base)
        return self._again(changes.on_base(self._chain, T, name), T[:3, :3] @ self.limb.reference, self.hand)

    def _again(self, chain: Chain, reference: Array, hand: Hand | None) -> Self:
        """This arm, made anew from a chain with the same joints."""
        found = recognise(chain.axes, chain.points, chain.T_base_tip_zero, reference)
        if found.limb is None:
            raise NotAnSrsLimb(f"moved, {self.name} is no S-R-S limb: {found.reason}", self.joint_names)
        return type(self)(chain, found.limb, self.name, hand, self.drawing)
