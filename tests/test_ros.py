"""Poses, quaternions and joint states as programs of ROS have them."""

import re
from collections import OrderedDict
from pathlib import Path
from types import SimpleNamespace as Message

import numpy as np
import pinocchio as pin
import pytest
from arms import configurations, load
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import srs_ik
from srs_ik.errors import InvalidConfiguration, InvalidPose

angles = st.floats(-3.1, 3.1)
lengths = st.floats(-2, 2)


def xyz(values) -> Message:
    return Message(**dict(zip("xyz", values, strict=True)))


def pose_message(T: np.ndarray) -> Message:
    """A geometry_msgs/Pose, with SciPy's quaternion."""
    quaternion = Rotation.from_matrix(T[:3, :3]).as_quat()
    return Message(position=xyz(T[:3, 3]), orientation=Message(**dict(zip("xyzw", quaternion, strict=True))))


@settings(deadline=None)
@given(st.tuples(lengths, lengths, lengths), st.tuples(angles, angles, angles))
def test_quaternions_in_both_orders_are_those_of_scipy(position, rpy):
    rotation = Rotation.from_euler("xyz", rpy)
    x, y, z, w = rotation.as_quat()
    poses = (
        srs_ik.pose_from_xyz_quaternion(position, [x, y, z, w], order="xyzw"),
        srs_ik.pose_from_xyz_quaternion(position, (w, x, y, z), order="wxyz"),
        srs_ik.pose_from_xyz_quaternion(position, [-x, -y, -z, -w], order="xyzw"),
        srs_ik.pose_from_xyz_rpy(position, rpy),
    )
    for pose in poses:
        np.testing.assert_allclose(pose.rotation, rotation.as_matrix(), rtol=0, atol=1e-14)
        np.testing.assert_array_equal(pose.translation, position)
    for order, back in (("xyzw", slice(None)), ("wxyz", [1, 2, 3, 0])):
        there, quaternion = srs_ik.xyz_quaternion(poses[0].homogeneous, order=order)
        np.testing.assert_array_equal(there, position)
        np.testing.assert_allclose(Rotation.from_quat(quaternion[back]).as_matrix(), rotation.as_matrix(), atol=1e-14)
        assert quaternion[back][3] >= 0.0


def test_columns_of_a_table_are_poses_as_one_by_one():
    rng = np.random.default_rng(3)
    xyz, rpy = rng.uniform(-1.0, 1.0, (20, 3)), rng.uniform(-3.0, 3.0, (20, 3))
    quaternions = Rotation.from_euler("xyz", rpy).as_quat() * rng.uniform(0.9995, 1.0005, (20, 1))
    many = srs_ik.pose_from_xyz_rpy(xyz, rpy), srs_ik.pose_from_xyz_quaternion(xyz, quaternions, order="xyzw")
    for k in range(20):
        one = srs_ik.pose_from_xyz_rpy(xyz[k], rpy[k]).homogeneous
        for poses in many:
            np.testing.assert_allclose(poses[k], one, rtol=0.0, atol=1e-14)
    wxyz = quaternions[:, [3, 0, 1, 2]]
    turned = srs_ik.pose_from_xyz_quaternion(xyz, wxyz, order="wxyz")
    np.testing.assert_allclose(turned, many[1], rtol=0.0, atol=1e-14)
    assert srs_ik.load("iiwa14").solve_batch(many[0]).ok.shape == (20,)
    assert srs_ik.pose_from_xyz_rpy(np.empty((0, 3)), np.empty((0, 3))).shape == (0, 4, 4)
    assert srs_ik.pose_from_xyz_quaternion(np.empty((0, 3)), np.empty((0, 4)), order="xyzw").shape == (0, 4, 4)
    quaternions[7] *= 2.0
    with pytest.raises(InvalidPose, match=r"^quaternion 7 of 20 is a rotation only if its length is 1, not [12]\."):
        srs_ik.pose_from_xyz_quaternion(xyz, quaternions, order="xyzw")
    with pytest.raises(InvalidPose, match=r"a position is 3 finite numbers, .* here there are 20: .* of shape \(3,\)"):
        srs_ik.pose_from_xyz_rpy(xyz[0], rpy)
    rpy[4, 1] = np.nan
    with pytest.raises(InvalidPose, match=r"roll, pitch and yaw is 3 finite numbers, .* entries that are not finite"):
        srs_ik.pose_from_xyz_rpy(xyz, rpy)
    with pytest.warns(UserWarning, match="are these degrees"):
        srs_ik.pose_from_xyz_rpy(xyz, np.full((20, 3), 90.0))


@pytest.mark.parametrize(
    ("arguments", "order", "says"),
    [
        (([0, 0, 0], [0, 0, 0, 0]), "xyzw", "length is 1, not 0"),
        (([0, 0, 0], [0, 0, 0, 1.1]), "xyzw", "length is 1, not 1.1"),
        (([0, 0, 0], [0, 0, 1]), "xyzw", "a quaternion is 4 finite numbers"),
        (([0, 0], [0, 0, 0, 1]), "xyzw", "a position is 3 finite numbers"),
        (([0, 0, np.nan], [0, 0, 0, 1]), "xyzw", "a position is 3 finite numbers"),
        (("abc", [0, 0, 0, 1]), "xyzw", "a position is 3 finite numbers"),
        (([0, 0, 0], [0, 0, 0, 1]), "wzyx", "is 'xyzw' or 'wxyz', not 'wzyx'"),
    ],
)
def test_what_is_no_pose(arguments, order, says):
    with pytest.raises(InvalidPose, match=says):
        srs_ik.pose_from_xyz_quaternion(*arguments, order=order)


def test_the_order_has_to_be_named():
    with pytest.raises(TypeError, match="order"):
        srs_ik.pose_from_xyz_quaternion([0, 0, 0], [0, 0, 0, 1])
    with pytest.raises(InvalidPose):
        srs_ik.xyz_quaternion(np.eye(4), order="")
    with pytest.raises(InvalidPose):
        srs_ik.xyz_quaternion(np.zeros((4, 4)), order="xyzw")


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_every_message_of_a_pose_is_solved_as_the_pose(name):
    arm = load(name)
    for q in configurations(name, 5):
        T = arm.forward_kinematics(q).homogeneous
        pose = pose_message(T)
        transform = Message(translation=pose.position, rotation=pose.orientation)
        header = Message(frame_id=arm.base)
        messages = (
            pose,
            Message(header=header, pose=pose),
            Message(header=header, pose=Message(pose=pose, covariance=np.zeros(36))),
            transform,
            Message(header=header, child_frame_id=arm.tip, transform=transform),
        )
        for message in messages:
            solution = arm.solve(message, seed=q)
            assert solution
            np.testing.assert_allclose(solution.q, q, atol=1e-6)
            assert max(arm.verify(message, q)) < 1e-12
        many = (list(messages), Message(header=header, poses=[pose] * 3), [T, pose, pin.SE3(T)])
        for poses in many:
            assert arm.solve_batch(poses, seed=q).ok.all()


@pytest.mark.parametrize("field", ["position", "orientation"])
def test_messages_without_figures_are_no_poses(field):
    arm = load("iiwa14")
    message = pose_message(np.eye(4))
    setattr(message, field, None)
    with pytest.raises(InvalidPose, match=r"4 x 4 array or a geometry_msgs pose, not SimpleNamespace"):
        arm.solve(message)
    with pytest.raises(InvalidPose, match="length is 1, not 0"):
        arm.solve(Message(position=xyz([0, 0, 0]), orientation=Message(x=0.0, y=0.0, z=0.0, w=0.0)))


def test_joints_are_picked_by_name_in_any_order():
    arm = load("iiwa14")
    q = configurations("iiwa14", 1)[0]
    pairs = [("gripper", 9.0), *zip(arm.joint_names, q.tolist(), strict=True), ("lift", -9.0)]
    pairs = [pairs[k] for k in np.random.default_rng(1).permutation(len(pairs))]
    state = Message(header=None, name=[n for n, _ in pairs], position=[p for _, p in pairs], velocity=[], effort=[])
    for given_state in (dict(pairs), OrderedDict(pairs), state, arm.solve(arm.forward_kinematics(q), seed=q).as_dict()):
        np.testing.assert_allclose(arm.joint_vector(given_state), q, atol=1e-9)


@pytest.mark.parametrize(
    ("state", "says"),
    [
        ({}, "lacks 'iiwa_joint_1'; it has no joint"),
        ({"iiwa_joint1": 0.0}, r"lacks 'iiwa_joint_1' \(did you mean 'iiwa_joint1'\?\)"),
        (
            {f"left/iiwa_joint_{k}": 0.0 for k in range(1, 8)},
            r"lacks 'iiwa_joint_1' \(did you mean 'left/iiwa_joint_1'\?\)",
        ),
        (Message(name=["a"], position=[1, 2]), "1 names and 2 positions"),
        (Message(name=["a", "b", "a"], position=[1.0, 2.0, 3.0]), "two positions of 'a': 1.0 and 3.0"),
        (Message(name=["a"]), "unlike a SimpleNamespace"),
        ([0.0] * 7, "unlike a list"),
        (dict.fromkeys([f"iiwa_joint_{k}" for k in range(1, 8)], np.nan), "not finite"),
        (dict.fromkeys([f"iiwa_joint_{k}" for k in range(1, 8)], "a"), "must be 7 joint angles"),
    ],
)
def test_joint_states_that_lack_something(state, says):
    with pytest.raises(InvalidConfiguration, match=says):
        load("iiwa14").joint_vector(state)


def test_many_answers_by_joint_name():
    arm = load("gen3")
    poses = [arm.forward_kinematics(q) for q in configurations("gen3", 4)]
    batch = arm.solve_batch(poses)
    assert list(batch.as_dict()) == list(arm.joint_names)
    for k, name in enumerate(arm.joint_names):
        np.testing.assert_array_equal(batch.as_dict()[name], batch.q[:, k])
    assert arm.solve_all(poses[0], arm_angle=0.3).as_dict()[arm.joint_names[0]].ndim == 1


def test_the_snippet_of_the_documentation_runs(capsys):
    page = (Path(__file__).resolve().parents[1] / "docs" / "conventions.md").read_text()
    section = page.split("## With ROS")[1].split("\n## ")[0]
    (snippet,) = re.findall(r"```python\n(.+?)```", section, re.DOTALL)
    exec(compile(snippet, "conventions.md", "exec"), {"srs_ik": srs_ik})
    assert capsys.readouterr().out.startswith("OK {'iiwa_joint_1': ")
