"""Many configurations at once, and the configuration of a whole robot: against Pinocchio on the whole file."""

import warnings

import arms
import numpy as np
import pinocchio as pin
import pytest
from oracles import distance, wrapped
from robot_files import robot_file

import srs_ik
from srs_ik import InvalidConfiguration


def whole_jacobian(forward, q):
    """Jacobian of the tip in base axes, by Pinocchio on the whole robot."""
    configuration = pin.neutral(forward.model)
    for angle, joint in zip(q, forward.joints, strict=True):
        configuration[joint.idx_q : joint.idx_q + joint.nq] = (
            [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
        )
    J = pin.computeFrameJacobian(
        forward.model, forward.data, configuration, forward.tip, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    )
    pin.updateFramePlacements(forward.model, forward.data)
    R = forward.data.oMf[forward.base].rotation.T
    columns = J[:, [joint.idx_v for joint in forward.joints]]
    return np.vstack([R @ columns[:3], R @ columns[3:]])


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_arm_angles_and_branches_of_many_are_those_of_each(name):
    arm = arms.load(name)
    q = arms.generator(name, 62).uniform(-3.0, 3.0, (30, 7))
    assert arm.arm_angle(q).tolist() == [arm.arm_angle(each) for each in q]
    assert arm.branch(q).tolist() == [arm.branch(each) for each in q]
    assert (arm.arm_angle(q[:0]).shape, arm.branch(q[:0]).shape) == ((0,), (0,))
    assert (type(arm.arm_angle(q[0])), type(arm.branch(q[0]))) == (float, int)
    for ask in (arm.arm_angle, arm.branch):
        with pytest.raises(InvalidConfiguration, match="N times 7 joint angles"):
            ask(np.zeros((3, 6)))


@pytest.mark.parametrize("name", arms.EVERY)
def test_many_poses_and_jacobians_are_those_of_the_whole_robot(name):
    arm, forward = arms.load(name), arms.forward(name)
    q = arms.generator(name, 60).uniform(-7.0, 7.0, (40, 7))
    poses, jacobians = arm.forward_kinematics_batch(q), arm.jacobian_batch(q)
    assert (poses.shape, jacobians.shape) == ((40, 4, 4), (40, 6, 7))
    for one, T, J in zip(q, poses, jacobians, strict=True):
        np.testing.assert_allclose(T, forward(one).homogeneous, rtol=0, atol=1e-13)
        np.testing.assert_allclose(J, whole_jacobian(forward, one), rtol=0, atol=1e-13)


def test_threads_a_tool_and_another_base_change_nothing_but_the_frames():
    arm = arms.load("gen3").with_tool(srs_ik.pose_from_xyz_rpy([0, 0.1, 0.2], [0.3, 0, 1]))
    arm = arm.with_base(srs_ik.pose_from_xyz_rpy([1, 2, 3], [0, 0.4, 0]))
    q = arms.generator("gen3", 61).uniform(-3.0, 3.0, (5000, 7))
    for method in (arm.forward_kinematics_batch, arm.jacobian_batch):
        one = method(q, threads=1)
        assert (one == method(q, threads=2)).all()
        assert (one == method(q.tolist())).all()
        assert (one == method(np.asfortranarray(q))).all()
    for k in range(0, 5000, 500):
        np.testing.assert_allclose(arm.forward_kinematics_batch(q)[k], arm.forward_kinematics(q[k]), atol=1e-13)
        np.testing.assert_allclose(arm.jacobian_batch(q)[k], arm.jacobian(q[k]), atol=1e-13)


@pytest.mark.parametrize("method", ["forward_kinematics_batch", "jacobian_batch"])
def test_none_is_an_empty_array(method):
    call = getattr(arms.load("iiwa14"), method)
    assert len(call([])) == len(call(np.empty((0, 7)))) == 0
    assert call([]).shape[1:] == call(np.zeros((1, 7))).shape[1:]


@pytest.mark.parametrize(
    "q",
    [
        np.zeros(7),
        np.zeros((2, 6)),
        np.zeros((2, 2, 7)),
        np.full((2, 7), np.nan),
        np.full((2, 7), 1e7),
        np.full((2, 7), 1j),
        [[0.0] * 7, [0.0] * 6],
        "home",
        5,
        None,
        [[10**400] * 7],
    ],
    ids=repr,
)
def test_what_is_no_list_of_configurations_is_refused(q):
    for method in ("forward_kinematics_batch", "jacobian_batch"):
        with pytest.raises(InvalidConfiguration, match="q ") as raised:
            getattr(arms.load("iiwa14"), method)(q)
        assert "\n" not in str(raised.value)


# The configuration of the whole robot

WHOLE = arms.here("gen3", "made_left", "made_folded", "openarm_right", "h1_2_left", "romeo_right", "human_left")


def whole_model(name):
    if name == "gen3":
        from srs_ik.robot import zoo

        return pin.buildModelFromUrdf(str(zoo.card(name).urdf))
    return pin.buildModelFromUrdf(str(robot_file(arms.PLACES[name][0])))


@pytest.mark.parametrize("name", WHOLE)
def test_angles_go_into_the_configuration_of_the_whole_robot_and_back(name):
    arm, model, rng = arms.load(name), whole_model(name), arms.generator(name, 62)
    data = model.createData()
    base, tip = (model.getFrameId(frame, pin.BODY) for frame in (arm.base, arm.tip))
    for q in arms.configurations(name, 10, 63):
        others = pin.integrate(model, pin.neutral(model), rng.uniform(-1.0, 1.0, model.nv))
        before = others.copy()
        whole = arm.configuration(q, model, others)
        assert (others == before).all()
        assert pin.isNormalized(model, whole, 1e-9)
        pin.framesForwardKinematics(model, data, whole)
        T = data.oMf[base].actInv(data.oMf[tip])
        assert max(distance(T, arm.forward_kinematics(q))) < 1e-12
        assert np.abs(wrapped(arm.angles(whole, model) - q)).max() < 1e-12
        # Nothing but the seven joints has moved.
        away = np.flatnonzero(np.abs(pin.difference(model, others, whole)) > 1e-12)
        assert {model.names[j] for j in range(1, model.njoints) if model.joints[j].idx_v in away} <= set(
            arm.joint_names
        )
        neutral = arm.configuration(q, model)
        moved = pin.difference(model, pin.neutral(model), neutral)
        assert np.count_nonzero(np.abs(moved) > 1e-12) <= 7


def test_a_whole_robot_that_does_not_fit_is_refused():
    arm, model = arms.load("made_left"), whole_model("made_left")
    q = np.zeros(7)
    other = pin.buildModelFromUrdf(str(robot_file("made_bent")))
    with pytest.raises(InvalidConfiguration, match=r"no joint 'left_joint_1' \(did you mean 'joint_1'"):
        arm.configuration(q, other)
    with pytest.raises(InvalidConfiguration, match="no joint 'left_joint_1'"):
        arm.angles(np.zeros(7), other)
    for call in (lambda: arm.configuration(q, model, np.zeros(7)), lambda: arm.angles(np.zeros(7), model)):
        with pytest.raises(InvalidConfiguration, match=f"is {model.nq} finite numbers"):
            call()
    with pytest.raises(InvalidConfiguration, match=r"the whole robot is a pinocchio\.Model, not str"):
        arm.configuration(q, "robot.urdf")
    with pytest.raises(InvalidConfiguration, match="give its model, too"):
        arm.configuration(q, others=np.zeros(18))
    sliding = pin.Model()
    for k, joint_name in enumerate(arm.joint_names):
        sliding.addJoint(k, pin.JointModelPZ(), pin.SE3.Identity(), joint_name)
    with pytest.raises(InvalidConfiguration, match=r"'left_joint_1' .* does not turn about one axis"):
        arm.configuration(q, sliding)


def test_a_joint_that_is_elsewhere_is_told_of():
    """A waist between base and tip that turns: the seven angles are right, and the tip is elsewhere."""
    links = "".join(f'<link name="{name}"/>' for name in ("root", "chest"))
    robot = srs_ik.load("iiwa14").drawing.file.read_text()
    waist = '<joint name="waist" type="revolute"><parent link="root"/><child link="chest"/><axis xyz="0 0 1"/>'
    waist += '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    mount = '<joint name="mount" type="fixed"><parent link="chest"/><child link="iiwa_link_0"/></joint>'
    text = robot.replace("</robot>", f"{links}{waist}{mount}</robot>")
    arm = srs_ik.load(text, base="root", tip="iiwa_link_ee")
    model = pin.buildModelFromXML(text)
    whole = pin.neutral(model)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.allclose(arm.angles(whole, model), 0.0)
    whole[model.joints[model.getJointId("waist")].idx_q] = 0.4
    with pytest.warns(UserWarning, match=r"'waist', between base and tip, is at 0\.4, not at 0"):
        arm.angles(whole, model)
    state = {**dict.fromkeys(arm.joint_names, 0.1), "waist": 0.4}
    with pytest.warns(UserWarning, match="'waist'"):
        assert np.allclose(arm.joint_vector(state), 0.1)


def test_a_waist_without_end_is_where_it_is_a_turn_on():
    links = "".join(f'<link name="{name}"/>' for name in ("root", "chest"))
    robot = srs_ik.load("iiwa14").drawing.file.read_text()
    waist = (
        '<joint name="waist" type="continuous"><parent link="root"/><child link="chest"/><axis xyz="0 0 1"/></joint>'
    )
    mount = '<joint name="mount" type="fixed"><parent link="chest"/><child link="iiwa_link_0"/></joint>'
    text = robot.replace("</robot>", f"{links}{waist}{mount}</robot>")
    arm = srs_ik.load(text, base="root", tip="iiwa_link_ee", locked={"waist": 1.2})
    state = {**dict.fromkeys(arm.joint_names, 0.1), "waist": 1.2 - 2.0 * np.pi}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.allclose(arm.joint_vector(state), 0.1)
    with pytest.warns(UserWarning, match=r"'waist', between base and tip, is at 0\.5, not at 1\.2 where the arm"):
        arm.joint_vector({**state, "waist": 0.5})
