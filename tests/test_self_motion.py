"""Self-motion and the derivatives of the arm angle: against differences of Pinocchio's elbow and of solved postures."""

import arms
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from oracles import arm_angle, distance, inside, limbs, wrapped

import srs_ik
from srs_ik import InvalidConfiguration, InvalidPose

TURN = 2.0 * np.pi
ARMS = arms.here("iiwa14", "human_arm", "sia5d", "romeo_left", "openarm_right", "gen3", "j2s7s300", "h1_2_left")
H = 1e-6


def stacked(arm, q):
    """The square Jacobian of the tip pose and the arm angle."""
    return np.vstack([arm.jacobian(q), arm.arm_angle_jacobian(q)])


def away_from_singularities(arm, q):
    """Whether differences of a millionth of a radian have digits left."""
    return (
        np.linalg.svd(arm.jacobian(q), compute_uv=False)[-1] > 3e-3 and np.abs(arm.arm_angle_jacobian(q)).max() < 30.0
    )


def difference_quotient(angle, q):
    """(7,) central differences of an arm angle."""
    steps = np.eye(7) * H
    return np.array([wrapped(angle(q + step) - angle(q - step)) / (2.0 * H) for step in steps])


@pytest.mark.parametrize("name", ARMS)
def test_the_jacobian_is_the_slope_of_the_elbow_that_pinocchio_carries(name):
    arm, forward = arms.load(name), arms.forward(name)
    compared = 0
    for q in arms.configurations(name, 30, 60):
        if away_from_singularities(arm, q):
            expected = difference_quotient(lambda q: arm_angle(forward, arm.limb, q), q)
            np.testing.assert_allclose(arm.arm_angle_jacobian(q), expected, rtol=1e-6, atol=1e-6)
            compared += 1
    assert compared > 15


@pytest.mark.parametrize("name", ARMS)
def test_the_tangent_is_the_slope_of_solved_postures(name):
    arm, forward = arms.load(name), arms.forward(name)
    compared = 0
    for q in arms.configurations(name, 30, 61):
        if np.linalg.svd(stacked(arm, q), compute_uv=False)[-1] < 0.03:
            continue  # differences of solved postures have no digits there
        pose, psi = forward(q), arm.arm_angle(q)
        options = {"seed": q, "branch": arm.branch(q), "respect_limits": False}
        before, after = (arm.solve(pose, arm_angle=psi + h, **options) for h in (-1e-5, 1e-5))
        assert before
        assert after
        tangent = arm.self_motion_tangent(q)
        scale = np.abs(tangent).max()
        np.testing.assert_allclose(tangent, (after.q - before.q) / 2e-5, rtol=0.0, atol=1e-5 * scale**3)
        compared += 1
    assert compared > 10


@pytest.mark.parametrize("miss", [0.0, 5e-3])
def test_derivatives_of_random_limbs(miss):
    compared = 0

    @given(limbs(miss=miss))
    def on(limb):
        nonlocal compared
        arm = srs_ik.load(limb.model, base="base", tip="tool")
        q = limb.configuration()
        J, slope, tangent = arm.jacobian(q), arm.arm_angle_jacobian(q), arm.self_motion_tangent(q)
        assert np.isfinite(slope).all()
        assert np.isfinite(tangent).all()
        if away_from_singularities(arm, q):
            np.testing.assert_allclose(slope, difference_quotient(arm.arm_angle, q), rtol=1e-5, atol=1e-5)
            scale = np.abs(tangent).max()
            np.testing.assert_allclose(J @ tangent, 0.0, atol=1e-12 * scale)
            assert slope @ tangent == pytest.approx(1.0, abs=1e-9 * scale)
            compared += 1

    on()
    assert compared > 5


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_tip_and_arm_angle_are_controlled_together(name):
    """Joint rates from the square Jacobian lead to the posture that `solve` gives."""
    arm = arms.load(name)
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    goal = q + np.array([0.02, -0.03, 0.01, 0.02, 0.03, -0.02, 0.01])
    pose, psi = arm.forward_kinematics(goal), arm.arm_angle(goal)
    for _ in range(6):
        now = arm.forward_kinematics(q)
        turn = now.rotation @ pin.log3(now.rotation.T @ pose.rotation)
        rates = np.concatenate([pose.translation - now.translation, turn, [wrapped(psi - arm.arm_angle(q))]])
        q = q + np.linalg.solve(stacked(arm, q), rates)
    np.testing.assert_allclose(q, goal, atol=1e-12)


def test_a_straight_elbow_of_an_exact_arm_keeps_its_derivatives():
    arm = arms.load("iiwa14")
    q = np.array([0.3, 0.7, -0.4, 0.0, 0.5, 0.8, -0.2])
    slope = difference_quotient(arm.arm_angle, q)
    np.testing.assert_allclose(arm.arm_angle_jacobian(q)[[0, 1, 2]], slope[[0, 1, 2]], atol=1e-6)
    tangent = arm.self_motion_tangent(q)
    np.testing.assert_allclose(arm.jacobian(q) @ tangent, 0.0, atol=1e-12)
    assert arm.arm_angle_jacobian(q) @ tangent == pytest.approx(1.0)
    # Upper arm and forearm turn about one line, which is axis 3 and axis 5.
    np.testing.assert_allclose(np.abs(tangent), [0, 0, 1, 0, 1, 0, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("q", "slope_exists"),
    [
        ([0.0] * 7, False),  # upright: shoulder to wrist along the reference
        ([0.3, 0.0, -0.4, -1.1, 0.5, 0.8, -0.2], True),  # axes 1 and 3 in line
        ([0.3, 0.7, -0.4, -1.1, 0.5, 0.0, -0.2], True),  # axes 5 and 7 in line
    ],
)
def test_where_the_arm_angle_stands_still_or_has_no_slope_there_are_zeros(q, slope_exists):
    arm = arms.load("iiwa14")
    slope = arm.arm_angle_jacobian(q)
    assert bool(slope.any()) is slope_exists
    assert np.linalg.matrix_rank(stacked(arm, np.array(q)), 1e-9) < 7
    assert (arm.self_motion_tangent(q) == 0.0).all()


@pytest.mark.parametrize("method", ["arm_angle_jacobian", "self_motion_tangent"])
def test_wrong_joint_vectors_are_refused(method):
    with pytest.raises(InvalidConfiguration, match="7"):
        getattr(arms.load("iiwa14"), method)([0.0] * 6)


@pytest.mark.parametrize("name", ARMS)
def test_self_motion_goes_evenly_through_every_interval(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 4, 62):
        pose = forward(q)
        motions = arm.self_motion(pose, count=40)
        assert [m.interval for m in motions] == arm.intervals(pose)
        for motion in motions:
            i = motion.interval
            assert motion.q.shape == (40, 7)
            assert motion.ok.all()
            assert (motion.branch == i.branch).all()
            expected = np.linspace(i.lower, i.upper, 40)
            assert np.abs(wrapped(motion.arm_angle - expected)).max() < 2e-9
            for posture in motion.q[::13]:
                assert max(distance(pose, forward(posture))) < 1e-9
                assert inside(posture, arm.lower, arm.upper)


def test_self_motion_draws_a_curve_that_closes_on_a_whole_circle():
    arm = arms.load("gen3")
    pose = arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    motions = arm.self_motion(pose, count=721, respect_limits=False)
    whole = [m for m in motions if m.interval.width > TURN - 1e-9]
    assert whole
    for motion in whole:
        assert np.abs(np.diff(motion.q, axis=0)).max() < 0.2
        assert np.abs(wrapped(motion.q[-1] - motion.q[0])).max() < 1e-6
        slopes = np.diff(motion.q, axis=0) / np.diff(np.unwrap(motion.arm_angle))[:, None]
        tangents = np.array([arm.self_motion_tangent(q) for q in motion.q])
        scale = np.abs(tangents).max()
        np.testing.assert_allclose(0.5 * (tangents[1:] + tangents[:-1]), slopes, atol=2e-3 * scale**3)


def test_self_motion_of_one_branch_and_out_of_reach():
    arm = arms.load("iiwa14")
    pose = arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    motions = arm.self_motion(pose, branch=2, count=2)
    assert [m.interval for m in motions] == [i for i in arm.intervals(pose) if i.branch == 2]
    assert repr(motions[0]).startswith("SelfMotion(2 postures in branch 2")
    pose.translation = pose.translation + 3.0
    assert arm.self_motion(pose) == []


@pytest.mark.parametrize(
    ("options", "named"), [({"count": 1}, "count"), ({"count": 2.5}, "count"), ({"branch": 8}, "branch")]
)
def test_wrong_options_are_refused(options, named):
    arm = arms.load("iiwa14")
    with pytest.raises(InvalidConfiguration, match=named):
        arm.self_motion(arm.forward_kinematics([0.1] * 7), **options)
    with pytest.raises(InvalidPose):
        arm.self_motion(np.zeros((4, 4)))
