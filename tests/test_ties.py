"""Where branches are as far from the limits, rounding does not choose between them: a pose beside has the same one."""

import arms
import numpy as np
import pytest

TURNED = 1e-3
"""Postures of poses a nanometre apart, rad; next to singular ones they may be so far apart."""


def beside(T: np.ndarray) -> np.ndarray:
    """The pose, and the same moved by a nanometre along each axis, to either side."""
    poses = np.repeat(T[None], 7, axis=0)
    poses[1:4, :3, 3] += 1e-9 * np.eye(3)
    poses[4:, :3, 3] -= 1e-9 * np.eye(3)
    return poses


def distance(arm, q: np.ndarray, other: np.ndarray) -> float:
    off = np.abs(q - other)
    return float(np.where(np.isinf(arm.upper), np.minimum(off, 2.0 * np.pi - off), off).max())


@pytest.mark.parametrize("name", arms.EVERY)
def test_a_pose_beside_has_the_same_branch_at_an_arm_angle(name):
    """Where joint 4 is nearest to its limits, eight branches have the same margin, but for rounding."""
    arm, rng = arms.load(name), np.random.default_rng(20)
    lower, upper = np.clip(arm.lower, -3.0, 3.0), np.clip(arm.upper, -3.0, 3.0)
    tied = 0
    for q in rng.uniform(lower, upper, (60, 7)):
        poses, psi = beside(arm.forward_kinematics(q).homogeneous), arm.arm_angle(q)
        found = [arm.solve(T, arm_angle=psi) for T in poses]
        many = arm.solve_batch(poses, arm_angle=psi)
        assert [one.branch for one in found] == many.branch.tolist()
        if not all(found) or np.abs(np.sin(found[0].q[[1, 3, 5]])).min() < 0.01:
            continue
        tied += 1
        assert max(distance(arm, found[0].q, one.q) for one in found) < TURNED
    assert tied > 20
