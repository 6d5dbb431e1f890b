"""An arm with other limits, and the nearest posture of every branch."""

import arms
import numpy as np
import pytest

import srs_ik
from srs_ik.errors import InvalidConfiguration, InvalidRobot

NAMES = ("iiwa14", "gen3", "human_arm")


def near(arm, rng, within):
    """A posture inside the limits, and a seed with every joint so close to it."""
    q = rng.uniform(np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi))
    return q, q + rng.uniform(-within, within, 7)


@pytest.mark.parametrize("name", NAMES)
def test_limits_around_a_seed_hold_every_joint_near_it(name):
    arm, rng = arms.load(name), arms.generator(name, 11)
    for _ in range(20):
        q, seed = near(arm, rng, 0.15)
        pose = arm.forward_kinematics(q)
        there = arm.with_limits(np.maximum(arm.lower, seed - 0.15), np.minimum(arm.upper, seed + 0.15))
        solution = there.solve(pose, seed=seed)
        assert solution
        assert np.abs(solution.q - seed).max() <= 0.15
        assert max(arm.verify(pose, solution.q)) < 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_other_limits_are_those_of_load(name):
    arm = arms.load(name)
    lower, upper = np.maximum(arm.lower, -1.0), np.minimum(arm.upper, 1.1)
    velocity, effort = np.full(7, 0.5), np.full(7, 20.0)
    limits = {
        joint: {"lower": lower[k], "upper": upper[k], "velocity": 0.5, "effort": 20.0}
        for k, joint in enumerate(arm.joint_names)
    }
    loaded, given = srs_ik.load(name, limits=limits), arm.with_limits(lower, upper, velocity, effort)
    for field in ("lower", "upper", "velocity_limit", "effort_limit"):
        np.testing.assert_array_equal(getattr(given, field), getattr(loaded, field))
    assert (arm.velocity_limit != 0.5).all()
    pose = arm.forward_kinematics(np.clip(np.full(7, 0.3), lower, upper))
    np.testing.assert_array_equal(given.solve(pose).q, loaded.solve(pose).q)
    wider = given.with_limits(upper=np.full(7, np.inf), lower=np.full(7, -np.inf))
    np.testing.assert_array_equal(wider.velocity_limit, velocity)
    assert np.isinf(wider.upper).all()


def test_tool_and_what_is_held_stay_with_other_limits():
    arm = srs_ik.load("iiwa14").with_tool(srs_ik.pose_from_xyz_rpy([0.1, 0, 0], [0, 0, 0]))
    held = arm.with_object("cup", srs_ik.pose_from_xyz_rpy([0.05, 0, 0], [0, 0, 0]), radius=0.04, length=0.1)
    other = held.with_limits(upper=arm.upper - 0.1)
    assert other.tip == "tool"
    assert [body.name for body in other.bodies] == [body.name for body in held.bodies]


def test_wrong_limits_are_named():
    arm = arms.load("iiwa14")
    with pytest.raises(InvalidRobot, match="lower must be 7 numbers, not"):
        arm.with_limits([0.0] * 6)
    with pytest.raises(InvalidRobot, match="upper must be 7 numbers, not"):
        arm.with_limits(upper="one")
    with pytest.raises(InvalidRobot, match="no range"):
        arm.with_limits(lower=arm.upper + 0.1)
    with pytest.raises(InvalidRobot, match="must be a number"):
        arm.with_limits(lower=[np.nan] * 7)
    with pytest.raises(InvalidRobot, match="must be positive"):
        arm.with_limits(velocity=[0.0] * 7)


@pytest.mark.parametrize("name", NAMES)
def test_the_nearest_posture_of_every_branch_and_the_nearest_first(name):
    """Against the postures of a sweep over each branch."""
    arm, rng = arms.load(name), arms.generator(name, 12)
    for _ in range(6):
        q, seed = near(arm, rng, 0.3)
        pose = arm.forward_kinematics(q)
        found = arm.solve_all(pose, seed=seed)
        away = np.linalg.norm(found.q - seed, axis=1)
        assert (np.diff(away) >= 0.0).all()
        assert away[0] <= np.linalg.norm(q - seed) + 1e-9
        np.testing.assert_allclose(found.q[0], arm.solve(pose, seed=seed).q, atol=1e-6)
        assert all(max(arm.verify(pose, each.q)) < 1e-9 for each in found)
        for motion in arm.self_motion(pose):
            # The turns of the sweep are not those nearest to the seed.
            off = np.remainder(motion.q - seed + np.pi, 2.0 * np.pi) - np.pi
            own = away[found.branch == motion.interval.branch]
            inside = ((seed + off >= arm.lower) & (seed + off <= arm.upper)).all(axis=1)
            if len(own) and inside.any():
                assert own.min() <= np.linalg.norm(off[inside], axis=1).min() + 1e-6


def test_at_an_arm_angle_the_nearest_branch_comes_first_and_scenes_count():
    arm = arms.load("iiwa14")
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose = arm.forward_kinematics(q)
    found = arm.solve_all(pose, arm.arm_angle(q), seed=q)
    np.testing.assert_allclose(found.q[0], q, atol=1e-9)
    assert sorted(found.branch) == sorted(arm.solve_all(pose, arm.arm_angle(q)).branch)
    free = arm.solve_all(pose, seed=q, scene=srs_ik.Scene())
    assert all(arm.collision(each.q, srs_ik.Scene()) is None for each in free)
    none = arm.solve_all(srs_ik.pose_from_xyz_rpy([3, 0, 0], [0, 0, 0]), seed=q)
    assert len(none) == 0
    assert none.failure.status == "UNREACHABLE"
    with pytest.raises(InvalidConfiguration, match="seed"):
        arm.solve_all(pose, seed=[0.0] * 6)
