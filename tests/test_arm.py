"""`Arm`: what it says of the robot, and forward kinematics, Jacobian and verification by Pinocchio."""

import copy
import pickle

import arms
import numpy as np
import pinocchio as pin
import pytest
from oracles import TURN, distance, random_angles, wrapped

import srs_ik
from srs_ik.control import ForceProfile, FractalImpedance, TorqueController, baselines


@pytest.mark.parametrize("name", arms.EVERY)
def test_forward_kinematics_is_that_of_the_whole_robot(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 30, 81):
        assert max(distance(forward(q), arm.forward_kinematics(q))) < 1e-12


@pytest.mark.parametrize("name", arms.EVERY)
def test_jacobian_is_the_derivative_of_forward_kinematics(name):
    arm = arms.load(name)
    h = 1e-5
    for q in arms.configurations(name, 5, 82):
        J = arm.jacobian(q)
        assert J.shape == (6, 7)
        R = arm.forward_kinematics(q).rotation
        for joint in range(7):
            step = h * np.eye(7)[joint]
            ahead, behind = arm.forward_kinematics(q + step), arm.forward_kinematics(q - step)
            linear = (ahead.translation - behind.translation) / (2.0 * h)
            turn = (ahead.rotation - behind.rotation) / (2.0 * h) @ R.T
            angular = np.array([turn[2, 1], turn[0, 2], turn[1, 0]])
            assert np.abs(J[:3, joint] - linear).max() < 1e-8
            assert np.abs(J[3:, joint] - angular).max() < 1e-8


@pytest.mark.parametrize("name", arms.EVERY)
def test_limits_are_those_of_the_file(name):
    arm, forward = arms.load(name), arms.forward(name)
    for k, joint in enumerate(forward.joints):
        if joint.nq == 2:
            assert arm.lower[k] == -np.inf
            assert arm.upper[k] == np.inf
        else:
            assert arm.lower[k] == forward.model.lowerPositionLimit[joint.idx_q]
            assert arm.upper[k] == forward.model.upperPositionLimit[joint.idx_q]
        velocity, effort = (limit[joint.idx_v] for limit in (forward.model.velocityLimit, forward.model.effortLimit))
        assert arm.velocity_limit[k] == (velocity if velocity > 0.0 else np.inf)
        assert arm.effort_limit[k] == (effort if effort > 0.0 else np.inf)


@pytest.mark.parametrize("name", arms.EVERY)
def test_the_model_has_the_seven_joints(name):
    arm = arms.load(name)
    assert arm.model.nv == 7
    assert tuple(arm.model.names)[1:] == arm.joint_names
    assert arm.model.nq == 7 + int(np.isinf(arm.upper).sum())
    assert arm.model.existFrame(arm.base)
    assert arm.model.existFrame(arm.tip)


@pytest.mark.parametrize("name", arms.here("gen3", "j2s7s300", "iiwa14"))
def test_configurations_and_angles_are_each_others_inverse(name):
    arm = arms.load(name)
    for q in arms.configurations(name, 20, 83):
        configuration = arm.configuration(q)
        assert configuration.shape == (arm.model.nq,)
        assert pin.isNormalized(arm.model, configuration, 1e-12)
        assert np.abs(wrapped(arm.angles(configuration) - q)).max() < 1e-12
        limited = np.isfinite(arm.upper)
        assert (arm.angles(configuration)[limited] == q[limited]).all()
        assert (np.abs(arm.angles(configuration)[~limited]) <= np.pi).all()


def test_turns_of_continuous_joints_are_one_configuration():
    arm = arms.load("gen3")
    q = np.array([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.4])
    turned = q + np.where(np.isinf(arm.upper), 3.0 * TURN, 0.0)
    assert np.abs(arm.configuration(turned) - arm.configuration(q)).max() < 1e-14
    assert max(distance(arm.forward_kinematics(q), arm.forward_kinematics(turned))) < 1e-14


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "h1_2_left"))
def test_verify_measures_distance_and_angle(name):
    arm, rng = arms.load(name), arms.generator(name, 84)
    for q in arms.configurations(name, 20, 85):
        pose = arm.forward_kinematics(q)
        shift, axis = rng.normal(size=3), rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        for angle in (0.0, 1e-12, 1e-6, 1.0, 3.0, np.pi):
            other = pin.SE3(pose.rotation @ pin.exp3(angle * axis), pose.translation + shift)
            error = arm.verify(other, q)
            assert error.position == pytest.approx(np.linalg.norm(shift))
            assert error.orientation == pytest.approx(angle, abs=1e-14 if angle < 1.0 else 1e-9)
            assert error == arm.verify(other.homogeneous, q)
        assert max(arm.verify(pose, q)) < 1e-14


@pytest.mark.parametrize("name", ["iiwa14", "gen3", "romeo_left"])
def test_pickled_and_copied_arms_solve_the_same(name):
    arm = arms.load(name)
    poses = [arm.forward_kinematics(q) for q in arms.configurations(name, 5, 86)]
    for other in (pickle.loads(pickle.dumps(arm)), copy.copy(arm), copy.deepcopy(arm)):
        assert repr(other) == repr(arm)
        assert other.joint_names == arm.joint_names
        for pose in poses:
            assert other.solve(pose).q.tobytes() == arm.solve(pose).q.tobytes()
            assert other.solve(pose).message == arm.solve(pose).message
            assert other.verify(pose, np.zeros(7)) == arm.verify(pose, np.zeros(7))


def test_results_are_the_callers_own():
    arm = arms.load("iiwa14")
    q = np.array([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0])
    pose = arm.forward_kinematics(q)
    kept = pose.homogeneous
    arm.forward_kinematics(np.zeros(7))
    arm.jacobian(np.ones(7))
    assert (pose.homogeneous == kept).all()
    assert (q == [0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0]).all()
    configuration = arm.configuration(q)
    configuration[:] = 9.0
    assert (arm.configuration(q) == q).all()


def test_limits_cannot_be_changed_behind_the_solver():
    arm = arms.load("iiwa14")
    for figures in (arm.lower, arm.upper, arm.velocity_limit, arm.effort_limit):
        with pytest.raises(ValueError, match="read-only"):
            figures[0] = 9.0
    for name in ("lower", "joint_names", "model", "limb", "tip"):
        with pytest.raises(
            AttributeError, match=f"Arm.{name} cannot be changed: with_tool and with_base give another"
        ) as told:
            setattr(arm, name, None)
        assert "load(limits={...})" in str(told.value)


def test_an_arm_takes_no_attribute_that_it_does_not_have():
    arm = arms.load("iiwa14")
    with pytest.raises(AttributeError, match=r"Arm has no attribute 'joint_name' \(did you mean 'joint_names'"):
        arm.joint_name = ("a",)

    class Noted(srs_ik.Arm):
        """A class of one's own may have more."""

    mine = Noted.__new__(Noted)
    mine.note = "mine"
    for each in (copy.deepcopy(arm), pickle.loads(pickle.dumps(arm)), arm.with_tool(np.eye(4))):
        assert each.solve(each.forward_kinematics(np.full(7, 0.1)))


def test_a_position_is_told_of_free_axis_where_there_is_one():
    arm, point = arms.load("iiwa14"), [0.5, 0.0, 0.5]
    tracker, scene = arm.tracker(np.full(7, 0.1), 0.01), srs_ik.Scene()
    for call in (arm.solve, lambda T: arm.solve(T, scene=scene), tracker.update):
        with pytest.raises(srs_ik.InvalidPose, match=r"makes one, whose rotation free_axis='any' leaves free$"):
            call(point)
    hold = TorqueController(arm, [FractalImpedance("tip", ForceProfile.tanh(1000.0, 60.0))])
    for call in (
        arm.solve_all,
        arm.intervals,
        hold.set_target,
        baselines.JointImpedance(arm).set_target,
        lambda T: arm.optimise(T, "manipulability"),
        lambda T: scene.add_box("box", T, [0.1, 0.1, 0.1]),
    ):
        with pytest.raises(srs_ik.SrsIkError, match=r"pose_from_xyz_rpy\(xyz, rpy\) makes one$"):
            call(point)


def test_only_what_a_tracker_looks_at_can_be_set():
    tracker = arms.load("iiwa14").tracker(np.full(7, 0.1), 0.01)
    for name in ("dt", "velocity_limit", "acceleration_limit", "jerk_limit", "free_axis"):
        with pytest.raises(AttributeError, match=f"Tracker.{name} cannot be changed: only elbow and smoothing can"):
            setattr(tracker, name, 0.1)
    for each in (tracker, copy.deepcopy(tracker), pickle.loads(pickle.dumps(tracker))):
        for figures in (each.velocity_limit, each.acceleration_limit):
            with pytest.raises(ValueError, match="read-only"):
                figures[0] = 9.0
    tracker.smoothing = tracker.elbow = 0.5


@pytest.mark.parametrize("tool", [((0.0, 0.0, 0.1), (0.0, 0.0, 0.0)), ((0.2, -0.1, 0.3), (0.4, -1.2, 2.0))])
def test_a_tool_shifts_the_tip_and_nothing_else(tool):
    """Tip frames with any offset and rotation: the joint angles are those of the bare flange."""
    arm = arms.load("iiwa14")
    offset, rpy = tool
    T_flange_tool = pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(offset))
    model = arm.model.copy()
    flange = model.frames[model.getFrameId(arm.tip)]
    model.addFrame(pin.Frame("tool", flange.parentJoint, 0, flange.placement * T_flange_tool, pin.OP_FRAME))
    with_tool = srs_ik.load(model, base=arm.base, tip="tool", reference=arm.limb.reference)
    for q in arms.configurations("iiwa14", 20, 87):
        pose = with_tool.forward_kinematics(q)
        assert max(distance(arm.forward_kinematics(q) * T_flange_tool, pose)) < 1e-12
        assert abs(wrapped(with_tool.arm_angle(q) - arm.arm_angle(q))) < 1e-10
        found, bare = with_tool.solve(pose, seed=q), arm.solve(arm.forward_kinematics(q), seed=q)
        assert np.abs(found.q - q).max() < 1e-7
        assert np.abs(bare.q - q).max() < 1e-7


def test_another_base_moves_the_poses_and_nothing_else():
    arm = arms.load("human_left")
    rng = np.random.default_rng(88)
    model = arm.model.copy()
    T_base_other = pin.SE3.Random()
    frame = model.frames[model.getFrameId(arm.base)]
    model.addFrame(pin.Frame("other", frame.parentJoint, 0, frame.placement * T_base_other, pin.OP_FRAME))
    other = srs_ik.load(model, base="other", tip=arm.tip, reference=T_base_other.rotation.T @ arm.limb.reference)
    for _ in range(20):
        q = random_angles(rng, arm.lower, arm.upper)
        assert max(distance(T_base_other.inverse() * arm.forward_kinematics(q), other.forward_kinematics(q))) < 1e-12
        assert abs(wrapped(other.arm_angle(q) - arm.arm_angle(q))) < 1e-9
        assert np.abs(other.solve(other.forward_kinematics(q), seed=q).q - q).max() < 1e-6


def test_gravity_turns_with_the_arm_or_is_that_of_the_room():
    arm, rng = srs_ik.load("gen3"), np.random.default_rng(89)
    T_room_base = pin.SE3.Random()
    model = arm.model.copy()
    base = model.frames[model.getFrameId(arm.base)].placement
    model.gravity.linear = (base * T_room_base.inverse()).rotation @ np.array([0.0, 0.0, -9.81])
    hung, turned = arm.with_base(T_room_base, gravity=[0, 0, -9.81]), arm.with_base(T_room_base)
    for _ in range(5):
        q = random_angles(rng, arm.lower, arm.upper)
        weight = pin.computeGeneralizedGravity(model, model.createData(), arm.configuration(q))
        held = [TorqueController(each, [], max_torque=1e3).torque(q, np.zeros(7)) for each in (hung, turned, arm)]
        assert np.abs(held[0] - weight).max() < 1e-9
        assert np.abs(held[1] - held[2]).max() < 1e-9
        assert np.abs(held[0] - held[1]).max() > 0.1
    for wrong in ([0, 0], [0, 0, np.nan], [0, 0, 1e300], "down", 9.81):
        with pytest.raises(srs_ik.InvalidConfiguration, match="gravity must be 3 numbers"):
            arm.with_base(T_room_base, gravity=wrong)


def test_the_name_of_an_arm_says_what_it_is():
    arm = arms.load("gen3")
    assert arm.name == "gen3"
    assert repr(arm) == f"<Arm gen3: {arm.base} to {arm.tip}, near S-R-S, wrist XYX>"
