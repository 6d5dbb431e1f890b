"""What is measured: poses of random postures over the full ranges of the joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from srs_ik.arm import Arm
from srs_ik.system.arrays import Array

SEED_SPREAD = 0.02
"""Seeds are this near to a posture of the pose, rad a joint."""


@dataclass(frozen=True)
class Work:
    """Poses of random configurations inside the limits, and what the calls take along."""

    q: Array  # (N, 7) configurations, rad
    poses: Array  # (N, 4, 4) their poses
    arm_angles: Array  # (N,) their arm angles, rad
    seeds: Array  # (N, 7) configurations near them, inside the limits, rad

    @staticmethod
    def of(arm: Arm, count: int) -> Work:
        """The same poses for everybody, from a fixed seed."""
        rng = np.random.default_rng(0)
        lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
        upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
        q = rng.uniform(lower, upper, (count, 7))
        seeds = np.clip(q + rng.uniform(-SEED_SPREAD, SEED_SPREAD, q.shape), arm.lower, arm.upper)
        poses = np.array([arm.forward_kinematics(row).homogeneous for row in q]).reshape(count, 4, 4)
        return Work(q, poses, np.array([arm.arm_angle(row) for row in q]), seeds)

    def repeated(self, times: int) -> Work:
        """The same work so many times over."""
        return Work(*(np.concatenate([rows] * times) for rows in (self.q, self.poses, self.arm_angles, self.seeds)))
