"""Forward kinematics that owes nothing to srs_ik: Pinocchio on a robot's file as its maker wrote it."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pinocchio as pin

import srs_ik
from srs_ik.robot.description import xacro


class Untouched:
    """A robot as Pinocchio reads it; all joints but those of the arm stay at their neutral position.

    Args:
        path: URDF, xacro (expanded by the package of that name) or MJCF file.
        arm: names the frames and joints.
    """

    def __init__(self, path: Path, arm: srs_ik.Arm) -> None:
        text = xacro.expand(path, path.name, {}) if path.suffix == ".xacro" else path.read_text()
        with _quiet():
            if "<robot" not in text:
                self.model = pin.buildModelFromMJCF(str(path))
            else:
                self.model = pin.buildModelFromXML(_readable(text))
        self.data = self.model.createData()
        self.neutral = pin.neutral(self.model)
        self.joints = [self.model.joints[self.model.getJointId(name)] for name in arm.joint_names]
        self.base, self.tip = self._frame(arm.base), self._frame(arm.tip)

    def __call__(self, q: np.ndarray) -> pin.SE3:
        configuration = self.neutral.copy()
        for angle, joint in zip(q, self.joints, strict=True):
            values = [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            configuration[joint.idx_q : joint.idx_q + joint.nq] = values
        pin.framesForwardKinematics(self.model, self.data, configuration)
        return self.data.oMf[self.base].actInv(self.data.oMf[self.tip])

    def poses(self, Q: np.ndarray) -> np.ndarray:
        """(n, 4, 4) poses at (n, 7) angles."""
        return np.array([self(q).homogeneous for q in Q]).reshape(-1, 4, 4)

    def _frame(self, name: str) -> int:
        """A link, where a joint has the same name."""
        if self.model.existFrame(name, pin.FrameType.BODY):
            return self.model.getFrameId(name, pin.FrameType.BODY)
        return self.model.getFrameId(name)


def _readable(urdf: str) -> str:
    """A URDF without what makers write and Pinocchio refuses, and on which no pose depends.

    These are negative limits, for "not given"; limits of continuous joints that lack one; and shapes of any other kind
    than the four of a URDF.
    """
    urdf = re.sub(r"<(visual|collision)\b[^>]*(?<!/)>.*?</\1>", "", urdf, flags=re.DOTALL)
    urdf = re.sub(r'(effort|velocity)="-[\d.]+"', r'\1="0"', urdf)
    return re.sub(r"<limit (?![^>]*\beffort=)", '<limit effort="0" ', urdf)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep what the parser has to say of shapes off the terminal; it writes past Python."""
    saved = os.dup(2)
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)


def distances(wanted: np.ndarray, reached: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Metres and radians between (..., 4, 4) poses; the angle without the loss of digits of an arc cosine."""
    turn = np.swapaxes(wanted[..., :3, :3], -1, -2) @ reached[..., :3, :3]
    skew = np.stack([turn[..., i, j] - turn[..., j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=-1)
    angle = np.arctan2(np.linalg.norm(skew, axis=-1), np.trace(turn, axis1=-2, axis2=-1) - 1.0)
    return np.linalg.norm(wanted[..., :3, 3] - reached[..., :3, 3], axis=-1), angle
