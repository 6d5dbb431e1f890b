"""Tools, bases and limits: by Pinocchio on the untouched file, with the transforms multiplied on."""

import pickle

import numpy as np
import pinocchio as pin
import pytest
from arms import configurations, forward, load
from hypothesis import given, settings
from hypothesis import strategies as st

import srs_ik
from srs_ik.errors import InvalidPose, InvalidRobot

NAMES = ("iiwa14", "gen3", "human_arm")
vectors = st.tuples(*[st.floats(-3, 3)] * 3)


def placement(xyz, rpy) -> pin.SE3:
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(xyz))


@pytest.mark.slow
@given(st.sampled_from(NAMES), vectors, vectors, vectors, vectors, st.integers(0, 99))
@settings(deadline=None, max_examples=60)
def test_a_moved_arm_reaches_what_the_plain_arm_reaches(name, xyz, rpy, tool_xyz, tool_rpy, k):
    T_room_base, T_tip_tool = placement(xyz, rpy), placement(tool_xyz, tool_rpy)
    plain = load(name)
    arm = plain.with_tool(T_tip_tool).with_base(T_room_base)
    q = configurations(name, 100)[k]
    expected = T_room_base * pin.SE3(forward(name)(q)) * T_tip_tool
    np.testing.assert_allclose(arm.forward_kinematics(q).homogeneous, expected.homogeneous, rtol=0, atol=1e-13)
    assert arm.arm_angle(q) == pytest.approx(plain.arm_angle(q), abs=1e-9)
    assert arm.branch(q) == plain.branch(q)
    assert (arm.limb.kind, arm.limb.wrist_kind) == (plain.limb.kind, plain.limb.wrist_kind)
    for solution in (arm.solve(expected), arm.solve(expected, arm_angle=plain.arm_angle(q), seed=q)):
        assert solution, solution.message
        reached = T_room_base * pin.SE3(forward(name)(solution.q)) * T_tip_tool
        np.testing.assert_allclose(reached.homogeneous, expected.homogeneous, rtol=0, atol=1e-9)
    np.testing.assert_allclose(solution.q, q, atol=1e-7)


@pytest.mark.parametrize("name", NAMES)
def test_the_jacobian_is_that_of_the_tool_point_in_the_new_axes(name):
    arm = load(name).with_tool(placement([0.1, -0.2, 0.3], [1, 2, 3])).with_base(placement([1, 2, 3], [0.3, 0.2, 0.1]))
    q, h = configurations(name, 1)[0], 1e-6
    before = arm.forward_kinematics(q)
    for k, step in enumerate(np.eye(7) * h):
        ahead, behind = arm.forward_kinematics(q + step), arm.forward_kinematics(q - step)
        linear = (ahead.translation - behind.translation) / (2 * h)
        angular = pin.log3(ahead.rotation @ behind.rotation.T) / (2 * h)
        np.testing.assert_allclose(arm.jacobian(q)[:, k], [*linear, *angular], atol=1e-8)
    assert arm.verify(before, q).position == 0.0


def test_the_plain_arm_stays_as_it_is_and_names_are_numbered():
    plain = load("iiwa14")
    frames = plain.model.nframes
    T = placement([0, 0, 0.1], [0, 0, 0])
    twice = plain.with_tool(T).with_tool(T).with_base(T).with_base(T)
    assert (twice.base, twice.tip, plain.model.nframes) == ("world_2", "tool_2", frames)
    assert (plain.base, plain.tip) == ("iiwa_link_0", "iiwa_link_ee")
    named = plain.with_tool(T, name="screwdriver").with_base(T, "table")
    assert (named.base, named.tip, named.name) == ("table", "screwdriver", "iiwa14")
    assert named.model.existFrame("screwdriver")
    for move in (plain.with_tool, plain.with_base):
        with pytest.raises(InvalidRobot, match="has a frame 'iiwa_link_3' already"):
            move(T, name="iiwa_link_3")
        with pytest.raises(InvalidPose):
            move(np.eye(3))
        with pytest.raises(InvalidPose):
            move(2 * np.eye(4))


@pytest.mark.parametrize("name", ["", 3, ["tool"]])
def test_the_name_of_a_frame_is_text(name):
    for move in (load("iiwa14").with_tool, load("iiwa14").with_base):
        with pytest.raises(srs_ik.InvalidRobot, match="the name of a frame is text"):
            move(np.eye(4), name=name)


def test_the_hand_turns_with_the_tool():
    plain = load("human_arm")
    R = pin.rpy.rpyToMatrix(0.3, -1.0, 2.0)
    arm = plain.with_tool(pin.SE3(R, np.zeros(3)))
    for turned, axis in zip(arm.hand, plain.hand, strict=True):
        np.testing.assert_allclose(R @ turned, axis, atol=1e-14)
    assert plain.with_base(pin.SE3(R, np.ones(3))).hand == plain.hand
    assert srs_ik.load(plain.model, tip=plain.tip, base=plain.base).with_tool(np.eye(4)).hand is None


def test_a_rotation_that_is_one_to_a_millionth_only_leaves_no_error():
    T = np.eye(4)
    T[0, 1] = 3e-7
    arm = load("iiwa14").with_tool(T)
    pose = arm.forward_kinematics(configurations("iiwa14", 1)[0])
    np.testing.assert_allclose(pose.rotation.T @ pose.rotation, np.eye(3), rtol=0, atol=1e-14)
    assert arm.solve(pose).position_error < 1e-12


def test_a_moved_arm_can_be_pickled():
    arm = load("gen3").with_tool(placement([0, 0, 0.2], [0, 0, 1]))
    q = configurations("gen3", 1)[0]
    again = pickle.loads(pickle.dumps(arm))
    np.testing.assert_array_equal(again.forward_kinematics(q).homogeneous, arm.forward_kinematics(q).homogeneous)
    assert again.with_tool(np.eye(4)).tip == "tool_2"


def test_limits_that_are_not_as_described():
    names = load("iiwa14").joint_names
    arm = srs_ik.load("iiwa14", limits={names[1]: {"lower": -0.5, "upper": 0.6}, names[6]: {"effort": 9, "upper": 9.0}})
    plain = load("iiwa14")
    assert (arm.lower[1], arm.upper[1], arm.effort_limit[6], arm.upper[6]) == (-0.5, 0.6, 9.0, 9.0)
    assert (arm.model.lowerPositionLimit[1], arm.model.upperPositionLimit[6], arm.model.effortLimit[6]) == (-0.5, 9, 9)
    others = [0, 2, 3, 4, 5]
    np.testing.assert_array_equal(arm.lower[others], plain.lower[others])
    q = np.array([0.1, 1.5, 0.2, -1.0, 0.3, 0.4, 0.5])
    pose = plain.forward_kinematics(q)
    assert plain.solve(pose, seed=q)
    solution = arm.solve(pose, seed=q)
    assert abs(solution.q[1]) <= 0.6
    assert (solution.q <= arm.upper).all()


def test_continuous_joints_can_be_given_limits_and_others_none():
    gen3 = load("gen3")
    first, second = gen3.joint_names[:2]
    arm = srs_ik.load("gen3", limits={first: {"lower": -1, "upper": 1}, second: {"lower": -np.inf, "upper": np.inf}})
    assert (arm.lower[0], arm.upper[0]) == (-1, 1)
    assert np.isinf([arm.lower[1], arm.upper[1]]).all()
    for q in configurations("gen3", 50):
        solution = arm.solve(gen3.forward_kinematics(q))
        assert abs(solution.q[0]) <= 1
        if abs(q[0]) <= 1:
            assert solution
            assert max(gen3.verify(gen3.forward_kinematics(q), solution.q)) < 1e-9


@pytest.mark.parametrize(
    ("limits", "says"),
    [
        ({"iiwa_joint_8": {"lower": 0}}, r"'iiwa_joint_8' \(did you mean 'iiwa_joint_7'.*the joints are iiwa_joint_1,"),
        (
            {"iiwa_joint_1": {"low": 0}},
            r"'iiwa_joint_1' has no limit 'low' \(did you mean 'lower'\?\); limits are lower, upper, velocity",
        ),
        ({"iiwa_joint_1": {"lower": 5}}, r"lower limit 5.0 and the upper limit 2\.96\d*, no range"),
        ({"iiwa_joint_1": {"lower": np.inf, "upper": np.inf}}, "no range"),
        ({"iiwa_joint_1": {"lower": "a"}}, "lower of joint 'iiwa_joint_1' must be a number, not 'a'"),
        ({"iiwa_joint_1": {"upper": np.nan}}, "must be a number, not nan"),
        ({"iiwa_joint_1": {"velocity": 0}}, "must be positive"),
        ({"iiwa_joint_1": {"has_velocity_limits": "false", "max_velocity": 1.0}}, "must be true or false, not 'false'"),
        ({"iiwa_joint_1": 2.0}, r"given as \{joint: \{limit: figure\}\}, not as \{'iiwa_joint_1': 2.0\}"),
        ([2.0] * 7, r"given as \{joint: "),
    ],
)
def test_limits_that_are_none(limits, says):
    with pytest.raises(InvalidRobot, match=says):
        srs_ik.load("iiwa14", limits=limits)


def test_limits_of_moveit_are_read_by_its_names():
    plain = load("gen3")
    both = {"has_velocity_limits": True, "max_velocity": 0.87, "has_acceleration_limits": True, "max_acceleration": 3.0}
    off = {"has_position_limits": False, "min_position": -1.0, "max_position": 1.0}
    arm = srs_ik.load("gen3", limits={"joint_2": both, "joint_4": {"min_position": -1.5}, "joint_6": off})
    assert arm.velocity_limit[1] == 0.87
    assert arm.lower[3] == -1.5
    expected = np.array(plain.lower)
    expected[3] = -1.5
    assert arm.lower == pytest.approx(expected)
    assert arm.upper == pytest.approx(plain.upper)
    with pytest.raises(InvalidRobot, match="has no limit 'max_speed'"):
        srs_ik.load("gen3", limits={"joint_2": {"max_speed": 1.0}})


def test_accelerations_are_kept_by_trackers_paths_and_motions():
    plain = load("iiwa14")
    assert np.isinf(plain.acceleration_limit).all()
    moveit = {"max_velocity": 0.5, "has_acceleration_limits": True, "max_acceleration": 1.0}
    off = {"has_acceleration_limits": False, "max_acceleration": 0.0}
    names = plain.joint_names
    arm = srs_ik.load("iiwa14", limits={**dict.fromkeys(names[:6], moveit), names[6]: off})
    np.testing.assert_array_equal(arm.acceleration_limit, [1.0] * 6 + [np.inf])
    for again in (arm.with_tool(np.eye(4)), arm.with_limits(effort=[9.0] * 7), pickle.loads(pickle.dumps(arm))):
        np.testing.assert_array_equal(again.acceleration_limit, arm.acceleration_limit)
    q0 = np.array([0.1, 0.5, 0.2, -1.0, 0.3, 0.4, 0.5])
    # The seventh joint has none: as before, what leads to its largest velocity in 0.1 s.
    expected = [1.0] * 6 + [10.0 * plain.velocity_limit[6]]
    np.testing.assert_allclose(arm.tracker(q0, 0.004).acceleration_limit, expected, rtol=1e-12)
    np.testing.assert_array_equal(arm.tracker(q0, 0.004, acceleration=2.0).acceleration_limit, [2.0] * 7)
    poses = arm.forward_kinematics_batch(q0 + np.linspace(0.0, 0.5, 20)[:, None] * [1.0, 0.4, 0.0, 0.7, 0.0, -0.3, 0.0])
    limited = arm.with_limits(acceleration=[1.0] * 7)
    given = limited.solve_path(poses, seed=q0, objective="time", acceleration_limit=1.0)
    path = limited.solve_path(poses, seed=q0, objective="time")
    np.testing.assert_array_equal(path.times, given.times)
    # Changes of velocity from step to step, over half of the time of both.
    for one, joints in ((path, slice(7)), (arm.solve_path(poses, seed=q0, objective="time"), slice(6))):
        lasts = np.diff(one.times)
        change = np.abs(np.diff(one.steps / lasts[:, None], axis=0)) / (0.5 * (lasts[:-1] + lasts[1:]))[:, None]
        assert 0.5 < change[:, joints].max() <= 1.0 + 1e-6
    assert limited.solve_path(poses, seed=q0).times is None
    motion = limited.solve_path(poses, seed=q0, dt=0.05).trajectory()
    assert np.abs(motion.sample(0.001)[3]).max() <= 1.0 + 1e-9


def test_velocities_that_look_like_degrees_are_noticed():
    with pytest.warns(UserWarning, match="velocities are in rad/s, and joint 'joint_1' is given 90: are these degrees"):
        load("gen3").with_limits(velocity=[90.0] * 7)
