"""`Arm.solution_derivatives` against differences of `solve`, for poses and arm angles a little off."""

import arms
import numpy as np
import pinocchio as pin
import pytest
from oracles import random_angles

H = 1e-5
"""Step of the central differences, m and rad; what they miss is its square by the third derivative."""


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "human_arm", "made_near", "made_oblique", "openarm_left"))
def test_they_are_the_differences_of_solutions(name):
    arm, rng = arms.load(name), arms.generator(name)
    tried = 0
    while tried < 10:
        q = random_angles(rng, arm.lower, arm.upper)
        found = arm.solution_derivatives(q)
        assert found.exist
        if max(np.abs(found.pose).max(), np.abs(found.arm_angle).max()) > 20.0:
            continue
        tried += 1
        pose, psi, branch = arms.forward(name)(q), arm.arm_angle(q), arm.branch(q)

        def at(dx, dpsi, pose=pose, psi=psi, branch=branch, q=q):
            moved = pin.SE3(pin.exp3(dx[3:]) @ pose.rotation, pose.translation + dx[:3])
            solution = arm.solve(moved, arm_angle=psi + dpsi, branch=branch, seed=q, respect_limits=False)
            assert solution
            return solution.q

        for k in range(6):
            dx = H * np.eye(6)[k]
            np.testing.assert_allclose(found.pose[:, k], (at(dx, 0.0) - at(-dx, 0.0)) / (2.0 * H), atol=2e-4)
        still = np.zeros(6)
        np.testing.assert_allclose(found.arm_angle, (at(still, H) - at(still, -H)) / (2.0 * H), atol=2e-4)


def test_where_there_are_none_it_says_so():
    found = arms.load("iiwa14").solution_derivatives(np.zeros(7))
    assert not found.exist
    assert not found.pose.any()
    assert not found.arm_angle.any()


def test_the_way_of_the_elbow_is_the_tangent_of_the_self_motion():
    arm = arms.load("gen3")
    q = [0.1, 0.5, -0.3, -1.1, 0.4, 0.9, 0.2]
    np.testing.assert_allclose(arm.solution_derivatives(q).arm_angle, arm.self_motion_tangent(q), rtol=1e-9, atol=1e-12)
