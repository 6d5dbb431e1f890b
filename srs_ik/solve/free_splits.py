"""Free splits: the segments of postures that hang at single arm angles of singular poses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from srs_ik.inputs.poses import PoseLike, as_matrix, invalid_pose
from srs_ik.kernels.entries import free_splits as entries
from srs_ik.kernels.layout import search as at
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm


@dataclass(frozen=True, eq=False, slots=True)
class FreeSplit:
    """Postures of a pose at one arm angle, where it fixes but the sum or the difference of two joints.

    There the outer axes of the shoulder or of the wrist lie in one line. All postures between the two ends meet the
    pose, and on the way from one to the other only those two joints move.

    Attributes:
        branches: the branches that meet there: two, or four where shoulder and wrist are singular at once.
        arm_angle: where the segment hangs, rad; None where every arm angle has one. Then the ends are those of one.
        joints: places of the two joints in `q`: (0, 2) at the shoulder, (4, 6) at the wrist.
        lower: (7,) posture at the end with the least angle of the first of the two joints, rad.
        upper: (7,) posture at the other end, rad.
    """

    branches: tuple[int, ...]
    arm_angle: float | None
    joints: tuple[int, int]
    lower: Array
    upper: Array

    @property
    def width(self) -> float:
        """How far either joint turns from end to end, rad; a whole turn where nothing limits them."""
        return float(self.upper[self.joints[0]] - self.lower[self.joints[0]])

    def at(self, share: float) -> Array:
        """(7,) posture at a share of the way from 0 at `lower` to 1 at `upper`."""
        between = self.lower + share * (self.upper - self.lower)
        # Rounding must not lead past an end, which may be a limit.
        return np.clip(between, np.minimum(self.lower, self.upper), np.maximum(self.lower, self.upper))

    def __repr__(self) -> str:
        where = "every arm angle" if self.arm_angle is None else f"arm_angle={self.arm_angle:.6g}"
        return f"FreeSplit(joints={self.joints}, {where}, branches={self.branches}, width={self.width:.6g} rad)"


def free_splits(arm: PackedArm, pose: PoseLike, respect_limits: bool) -> list[FreeSplit]:
    """See `Arm.free_splits`."""
    rows = np.empty((at.MOST_SPLITS, at.SPLIT_ROW))
    count = entries.free_splits(arm.family, as_matrix(pose), respect_limits, rows)
    if count < 0:
        raise invalid_pose(-count)
    return [_free_split(row) for row in rows[:count]]


def _free_split(row: Array) -> FreeSplit:
    first, branch = int(row[at.SPLIT_FIRST]), int(row[at.SPLIT_BRANCH])
    sides = (0, 1, 2, 3) if row[at.SPLIT_BOTH] else (0, 2) if first == 0 else (0, 1)
    lower = row[at.SPLIT_LOWER : at.SPLIT_LOWER + 7].copy()
    upper = row[at.SPLIT_UPPER : at.SPLIT_UPPER + 7].copy()
    arm_angle = None if row[at.SPLIT_EVERYWHERE] else float(row[at.SPLIT_ARM_ANGLE])
    return FreeSplit(tuple(branch + side for side in sides), arm_angle, (first, first + 2), lower, upper)
