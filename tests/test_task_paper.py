"""The general kernels against the paper's own equations, on the paper's limb."""

import arms
import numpy as np
import paper_posture as paper
import pytest

from srs_ik import Task

COUNT = 1000


def orthogonal_tasks(count, salt):
    """Targets in the sphere of the paper's experiments, with v, f and phi orthogonal as there: grasp v, roll f."""
    rng = arms.generator("human_arm", salt)
    for _ in range(count):
        x = paper.unit(rng.normal(size=3)) * 0.79 * rng.uniform() ** (1 / 3)
        v = paper.unit(rng.normal(size=3))
        f = paper.unit(np.cross(v, rng.normal(size=3)))
        yield x, v, f


def within_reach(x, g=None):
    d = np.linalg.norm(x if g is None else x - paper.HAND * g)
    lower = paper.FOREARM + (paper.HAND if g is None else 0.0)
    return abs(paper.ARM - lower) + 1e-3 < d < paper.ARM + lower - 1e-3


@pytest.mark.parametrize("left", [True, False])
@pytest.mark.parametrize("grasped", [True, False])
def test_postures(grasped, left):
    arm = arms.load("human_arm")
    compared = 0
    for x, v, f in orthogonal_tasks(COUNT, 951):
        g = v if grasped else None
        if not within_reach(x, g):
            continue
        x_e, x_w = paper.geometric_posture(x, v, f, g, left)
        p = arm.posture(Task(x, v, f, g), "left" if left else "right")
        # The height of the triangle by the printed form: its digits go with the square root near the ends.
        assert p.elbow == pytest.approx(x_e, abs=1e-12)
        assert p.wrist == pytest.approx(x_w, abs=1e-12)
        compared += 1
    assert compared > 500


@pytest.mark.slow
def test_joint_angles():
    """The paper's joint angles are among the eight branches at the posture's arm angle, to 1e-12."""
    arm = arms.load("human_arm")
    compared = 0
    for x, v, f in orthogonal_tasks(COUNT, 952):
        if not within_reach(x, v):
            continue
        solution = arm.solve_task(Task(x, v, f, grasp=v, pronosupination=f), respect_limits=False)
        p = solution.posture
        q = paper.inverse(p.elbow, p.wrist, v, f)
        x_e, x_w, hand, R = paper.forward(q)
        assert max(np.linalg.norm(e) for e in (x_e - p.elbow, x_w - p.wrist, hand - x)) < 1e-12
        assert max(np.linalg.norm(R[:, 0] - v), np.linalg.norm(R[:, 2] - f)) < 1e-12
        T = solution.T_base_tip
        assert pytest.approx(arm.forward_kinematics(q).homogeneous, abs=1e-12) == T
        branches = arm.solve_all(T, arm_angle=p.arm_angle, respect_limits=False).q
        away = np.abs((branches - q + np.pi) % (2 * np.pi) - np.pi).max(axis=1)
        # Near a singular shoulder or wrist, angles of joints are worth less than the pose that they make.
        bent = min(abs(np.sin(q[1] - np.pi / 2)), abs(np.cos(q[5])))
        assert away.min() < 1e-12 / min(bent, 1.0)
        assert solution
        assert solution.angle_lost == 0.0
        compared += 1
    assert compared > 500


def test_half_of_the_printed_solutions_have_the_wrong_sign_of_the_pronosupination():
    arm = arms.load("human_arm")
    signs = []
    for x, v, f in orthogonal_tasks(COUNT, 953):
        if within_reach(x, v):
            p = arm.posture(Task(x, v, f, grasp=v))
            _, _, hand, R = paper.forward(paper.inverse(p.elbow, p.wrist, v, f, sign_corrected=False))
            assert hand == pytest.approx(x, abs=1e-12)
            assert abs(R[:, 2] @ f) == pytest.approx(1.0)
            signs.append(R[:, 2] @ f > 0.0)
    assert 0.3 < np.mean(signs) < 0.7
