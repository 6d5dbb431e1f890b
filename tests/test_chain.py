import pickle

import chains
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robot_files import EXAMPLES, REAL, at_hand, joint_xml, random_configuration, robot_file, serial_arm

from srs_ik.errors import FrameNotFound, InvalidRobot, NotAnSrsLimb
from srs_ik.robot.chain import build_chain
from srs_ik.robot.description import load_model
from srs_ik.robot.skeleton import Skeleton

FILES = at_hand(*chains.MAKERS, *REAL, *EXAMPLES)


def model_in(name: str) -> pin.Model:
    return load_model(robot_file(name)).model


def model_of(*parts: str) -> pin.Model:
    return load_model(f'<robot name="small">{"".join(parts)}</robot>').model


def fixed(parent: str, child: str, origin: str = "0 0 0", rpy: str = "0 0 0") -> str:
    return f'<link name="{child}"/>' + joint_xml(
        f"{parent}_{child}", parent, child, "fixed", f'<origin xyz="{origin}" rpy="{rpy}"/>'
    )


def moving(parent: str, child: str, kind: str = "revolute", origin: str = "0 0 0") -> str:
    inside = f'<origin xyz="{origin}"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
    return f'<link name="{child}"/>' + joint_xml(f"{parent}_{child}", parent, child, kind, inside)


def product_of_exponentials(chain, q):
    """Pose of the tip by screws about the axes alone, which knows nothing of Pinocchio's kinematics."""
    T = np.eye(4)
    for axis, point, angle in zip(chain.axes, chain.points, q, strict=True):
        K = np.cross(np.eye(3), axis)
        R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
        screw = np.eye(4)
        screw[:3, :3], screw[:3, 3] = R, point - R @ point
        T = T @ screw
    return T @ chain.T_base_tip_zero


def pose_in_whole_robot(model, chain, q):
    data = model.createData()
    v = np.zeros(model.nv)
    v[[model.joints[model.getJointId(name)].idx_v for name in chain.joint_names]] = q
    pin.framesForwardKinematics(model, data, pin.integrate(model, pin.neutral(model), v))
    base, tip = (Skeleton(model).find_frame(name) for name in (chain.base, chain.tip))
    return data.oMf[base].actInv(data.oMf[tip]).homogeneous


@pytest.mark.parametrize("name", FILES)
def test_the_lines_and_the_reduced_model_move_as_the_whole_robot_does(name):
    model = model_in(name)
    skeleton = Skeleton(model)
    windows = skeleton.windows()
    assert windows
    rng = np.random.default_rng(0)
    for joints in windows[:: max(1, len(windows) // 5)]:
        chain = build_chain(model, joints, skeleton.default_base(joints[0]), skeleton.default_tip(joints[-1]))
        assert (chain.model.njoints, chain.model.nv) == (8, 7)
        assert chain.joint_names == tuple(chain.model.names)[1:]
        np.testing.assert_allclose(np.linalg.norm(chain.axes, axis=1), 1, atol=1e-14)
        for q in rng.uniform(-np.pi, np.pi, (5, 7)):
            expected = pose_in_whole_robot(model, chain, q)
            np.testing.assert_allclose(product_of_exponentials(chain, q), expected, rtol=0, atol=1e-13)
            data = chain.model.createData()
            pin.framesForwardKinematics(chain.model, data, pin.integrate(chain.model, pin.neutral(chain.model), q))
            reduced = data.oMf[chain.base_id].actInv(data.oMf[chain.tip_id]).homogeneous
            np.testing.assert_allclose(reduced, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", at_hand("made_twins", "unitree_h1_2_handless"))
def test_measuring_in_the_whole_robot_or_in_seven_joints_is_the_same(name):
    model = model_in(name)
    skeleton = Skeleton(model)
    for joints in skeleton.windows():
        base, tip = skeleton.default_base(joints[0]), skeleton.default_tip(joints[-1])
        lines, chain = skeleton.measure(joints, base, tip), build_chain(model, joints, base, tip)
        for field in ("axes", "points", "T_base_tip_zero"):
            np.testing.assert_allclose(getattr(lines, field), getattr(chain, field), rtol=0, atol=1e-14)


# Windows


def test_windows_are_runs_of_seven_revolute_joints():
    def names(kinds, excluded=()):
        model = model_of(serial_arm("z y z y z y z y z", "0 0 .3 0 .3 0 .1 0 0", kinds))
        return ["".join(model.names[j][-1] for j in w) for w in Skeleton(model).windows(excluded)]

    assert names({}) == ["1234567", "2345678", "3456789"]
    assert names({1: "prismatic"}) == ["2345678", "3456789"]
    assert names({2: "fixed"}) == ["1345678", "3456789"]
    assert names({3: "continuous", 9: "floating"}) == ["1234567", "2345678"]
    assert names({5: "prismatic"}) == []
    assert names({}, excluded={"j1"}) == ["2345678", "3456789"]
    assert names({}, excluded={"j5"}) == []


def test_a_fork_gives_a_window_for_each_branch():
    model = model_of(serial_arm(), moving("l6", "x"), moving("l7", "y"))
    found = [tuple(model.names[j] for j in w) for w in Skeleton(model).windows()]
    assert len(found) == len(set(found)) == 3
    assert {w[-1] for w in found} == {"j7", "l6_x", "l7_y"}


def test_six_joints_have_no_window():
    assert Skeleton(model_of(serial_arm("z y z y z y", "0 0 .3 0 .3 0"))).windows() == []


def test_a_limb_between_forks_is_less_odd_than_one_that_runs_across_them():
    arms = [serial_arm(prefix=side).replace(f'<link name="{side}l0"/>', "", 1) for side in ("left_", "right_")]
    arms += [fixed("trunk", "left_l0"), fixed("trunk", "right_l0")]
    model = model_of('<link name="root"/>', moving("root", "trunk"), *arms)
    skeleton = Skeleton(model)
    oddity = {tuple(model.names[j] for j in w): skeleton.oddity(w) for w in skeleton.windows()}
    assert oddity == {
        **{tuple(f"{side}_j{k}" for k in range(1, 8)): 0 for side in ("left", "right")},
        **{("root_trunk", *(f"{side}_j{k}" for k in range(1, 7))): 2 for side in ("left", "right")},
    }


# Frames


def test_default_frames_of_a_plain_arm():
    skeleton = Skeleton(model_of(serial_arm()))
    assert (skeleton.default_base(1), skeleton.default_tip(7)) == ("l0", "l7")


@pytest.mark.parametrize(
    ("beyond", "tip"),
    [
        ([fixed("l7", "flange"), fixed("flange", "tool")], "tool"),
        ([fixed("l7", "flange"), moving("flange", "finger")], "flange"),
        ([fixed("l7", "flange"), fixed("l7", "camera")], "l7"),
        ([fixed("l7", "flange"), fixed("flange", "tool"), fixed("flange", "camera")], "flange"),
        ([fixed("l7", "flange"), moving("l7", "finger")], "l7"),
        ([moving("l7", "finger", "prismatic")], "l7"),
        ([fixed("l6", "skin")], "l7"),
    ],
)
def test_the_default_tip_is_the_end_of_the_fixed_links_before_a_fork_or_a_moving_joint(beyond, tip):
    model = model_of(serial_arm(), *beyond)
    assert Skeleton(model).default_tip(model.getJointId("j7")) == tip


def test_the_default_base_is_the_link_of_joint_1_and_not_the_root():
    arm = serial_arm().replace('<link name="l0"/>', "", 1)
    model = model_of('<link name="world"/>', fixed("world", "table"), fixed("table", "l0"), arm)
    assert Skeleton(model).default_base(1) == "l0"


def test_a_name_means_the_link_before_the_joint():
    arm = serial_arm().replace('"j7"', '"l7"').replace('"j1"', '"l0"')
    model = model_of(arm)
    chain = build_chain(model, range(1, 8), "l0", "l7")
    assert chain.model.frames[chain.tip_id].type == pin.FrameType.BODY
    assert chain.model.frames[chain.base_id].type == pin.FrameType.BODY
    assert chain.joint_names[0] == "l0"


def test_links_and_fixed_joints_that_share_their_names_do_not_stop_the_locking():
    # Pinocchio's own function refuses this model.
    same = '<link name="{0}"/>' + joint_xml("{0}", "{1}", "{0}", "fixed", "")
    parts = serial_arm(), moving("l7", "finger"), same.format("rubber", "finger"), same.format("tip", "rubber")
    model = model_of(*parts)
    with pytest.raises(ValueError, match="Several frames"):
        pin.buildReducedModel(model, [8], pin.neutral(model))
    chain = build_chain(model, range(1, 8), "l0", "tip")
    assert {frame.name for frame in chain.model.frames} == {frame.name for frame in model.frames}
    assert (chain.model.nq, chain.model.names[7]) == (7, "j7")


@pytest.mark.parametrize("name", FILES)
def test_locked_models_are_those_of_pinocchio(name):
    model = model_in(name)
    joints = (Skeleton(model).windows() or [tuple(range(1, 8))])[0]
    chain = build_chain(model, joints, model.frames[1].name, model.names[joints[-1]])
    others = [joint for joint in range(1, model.njoints) if joint not in joints]
    assert chain.model == (pin.buildReducedModel(model, others, pin.neutral(model)) if others else model)


def test_joint_frames_can_be_named_too():
    model = model_of(serial_arm())
    chain = build_chain(model, range(1, 8), "l0", "j7")
    assert chain.model.frames[chain.tip_id].type == pin.FrameType.JOINT


def test_frames_that_a_program_adds_can_be_named():
    model = model_of(serial_arm())
    placement = pin.SE3(pin.rpy.rpyToMatrix(0.1, 0.2, 0.3), np.array([0.0, 0.1, 0.2]))
    model.addFrame(pin.Frame("tcp", 7, model.getFrameId("l7", pin.FrameType.BODY), placement, pin.FrameType.OP_FRAME))
    chain = build_chain(model, range(1, 8), "l0", "tcp")
    plain = build_chain(model, range(1, 8), "l0", "l7")
    np.testing.assert_allclose(chain.T_base_tip_zero, plain.T_base_tip_zero @ placement.homogeneous, atol=1e-15)
    assert Skeleton(model).default_tip(7) == "l7"


def test_an_unknown_frame_is_an_error_with_all_frames():
    skeleton = Skeleton(model_of(serial_arm()))
    with pytest.raises(FrameNotFound, match=r"no frame 'L7' in robot 'small' \(did you mean 'l7'") as raised:
        skeleton.find_frame("L7")
    assert set(raised.value.available) == {f"l{k}" for k in range(8)} | {f"j{k}" for k in range(1, 8)}


def test_what_hangs_on_a_frame():
    model = model_of(serial_arm(), fixed("l0", "box"))
    skeleton = Skeleton(model)
    assert skeleton.carries("l0", 1)
    assert skeleton.carries("l3", 4)
    assert not skeleton.carries("l4", 4)
    assert not skeleton.carries("box", 1)


# The chain


def test_the_base_may_be_on_another_branch_and_the_tip_anything_on_joint_7():
    turned = fixed("l7", "tool", "0.01 0.02 0.03", "0.3 -0.2 0.5")
    model = model_of(serial_arm(), fixed("l0", "table", "1 2 3", "0.4 0.5 0.6"), moving("table", "camera"), turned)
    joints = [model.getJointId(f"j{k}") for k in range(1, 8)]
    plain, moved = build_chain(model, joints, "l0", "l7"), build_chain(model, joints, "camera", "tool")
    T_l0_camera = Skeleton(model).transform("l0", "camera")
    np.testing.assert_allclose(moved.axes, plain.axes @ T_l0_camera[:3, :3], atol=1e-14)
    q = np.linspace(-1, 1, 7)
    expected = np.linalg.inv(T_l0_camera) @ product_of_exponentials(plain, q) @ Skeleton(model).transform("l7", "tool")
    np.testing.assert_allclose(product_of_exponentials(moved, q), expected, atol=1e-14)


def test_a_base_that_the_limb_moves_and_a_tip_that_it_does_not_are_errors():
    model = model_of(serial_arm(), moving("l7", "finger"))
    with pytest.raises(NotAnSrsLimb, match="base frame 'l3' is moved by joint 'j3'"):
        build_chain(model, range(1, 8), "l3", "l7")
    with pytest.raises(NotAnSrsLimb, match="tip frame 'l6' is not moved by joint 'j7'") as raised:
        build_chain(model, range(1, 8), "l0", "l6")
    assert raised.value.joint_names == tuple(f"j{k}" for k in range(1, 8))
    # What is locked moves with the limb.
    assert build_chain(model, range(1, 8), "l0", "finger").tip == "finger"


def test_limits_are_infinite_where_continuous_or_not_given():
    xml = serial_arm(kinds={1: "continuous", 5: "continuous"})
    xml = xml.replace('effort="10" velocity="3"', 'effort="0" velocity="-1"', 3)
    chain = build_chain(model_of(xml), range(1, 8), "l0", "l7")
    inf = np.inf
    np.testing.assert_array_equal(chain.lower, [-inf, -2, -2, -2, -inf, -2, -2])
    np.testing.assert_array_equal(chain.upper, [inf, 2, 2, 2, inf, 2, 2])
    np.testing.assert_array_equal(chain.effort_limit, [inf, inf, inf, 10, 10, 10, 10])
    np.testing.assert_array_equal(chain.velocity_limit, [inf, inf, inf, 3, 3, 3, 3])
    assert chain.model.nq == 9


def test_a_model_of_a_program_without_limits_or_frames():
    model = pin.Model()
    joint = 0
    for k, kind in enumerate("ZYZYZYZ", 1):
        joint = model.addJoint(joint, getattr(pin, f"JointModelR{kind}")(), pin.SE3.Identity(), f"j{k}")
    skeleton = Skeleton(model)
    assert skeleton.windows() == [(1, 2, 3, 4, 5, 6, 7)]
    assert skeleton.default_base(1) == "universe"
    with pytest.raises(InvalidRobot, match="no frame on joint 'j7': add one, to be its tip"):
        skeleton.default_tip(7)
    model.addFrame(pin.Frame("hand", 7, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    assert Skeleton(model).default_tip(7) == "hand"
    assert Skeleton(model).carries("universe", 1)
    chain = build_chain(model, range(1, 8), "universe", "hand")
    for limit in (chain.upper, -chain.lower, chain.velocity_limit, chain.effort_limit):
        np.testing.assert_array_equal(limit, np.inf)


@pytest.mark.parametrize("limit", [1e6, 1e9, 1e30, 1e300, np.inf])
def test_limits_that_no_joint_ever_meets_are_none(limit):
    model = model_of(serial_arm())
    model.lowerPositionLimit, model.upperPositionLimit = np.full(7, -limit), np.full(7, limit)
    model.velocityLimit, model.effortLimit = np.full(7, limit), np.full(7, limit)
    chain = build_chain(model, range(1, 8), "l0", "l7")
    for figures in (-chain.lower, chain.upper, chain.velocity_limit, chain.effort_limit):
        np.testing.assert_array_equal(figures, np.inf)


@pytest.mark.parametrize(("low", "high"), [(1.0, -1.0), (np.nan, 1.0), (0.0, np.nan), (1e9, 1e300)])
def test_position_limits_of_a_model_that_are_no_range_are_an_error(low, high):
    model = model_of(serial_arm())
    lower, upper = model.lowerPositionLimit.copy(), model.upperPositionLimit.copy()
    lower[2], upper[2] = low, high
    model.lowerPositionLimit, model.upperPositionLimit = lower, upper
    with pytest.raises(InvalidRobot, match="joint 'j3' has the position limits"):
        build_chain(model, range(1, 8), "l0", "l7")


@pytest.mark.parametrize("leader", ["j2", "l0_x"])
def test_joints_that_a_model_couples_are_locked_too(leader):
    inside = f'<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="{leader}"/>'
    parts = serial_arm() + moving("l0", "x") + '<link name="y"/>' + joint_xml("follower", "x", "y", inside=inside)
    model = pin.buildModelFromXML(f'<robot name="small">{parts}</robot>', True)
    joints = tuple(model.getJointId(f"j{k}") for k in range(1, 8))
    assert Skeleton(model).windows() == [joints]
    assert not Skeleton(model).is_revolute(model.getJointId("follower"))
    chain = build_chain(model, joints, "l0", "l7")
    assert (chain.model.njoints, chain.model.nq) == (8, 7)


def test_the_given_model_stays_as_it_is_and_the_arrays_are_read_only():
    model = model_of(serial_arm(), moving("l7", "finger"))
    before = model.copy()
    chain = build_chain(model, range(1, 8), "l0", "l7")
    assert model == before
    assert chain.model is not model
    for value in vars(chain).values():
        assert not isinstance(value, np.ndarray) or not value.flags.writeable
    plain = model_of(serial_arm())
    assert build_chain(plain, range(1, 8), "l0", "l7").model is not plain


def test_a_chain_can_be_pickled():
    chain = build_chain(model_of(serial_arm()), range(1, 8), "l0", "l7")
    again = pickle.loads(pickle.dumps(chain))
    assert again.model == chain.model
    np.testing.assert_array_equal(again.axes, chain.axes)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=50, deadline=None)
def test_any_axes_and_placements(seed):
    rng = np.random.default_rng(seed)
    parts = ['<link name="l0"/>']
    for k in range(1, 8):
        xyz, rpy, axis = (" ".join(map(repr, v.tolist())) for v in rng.uniform(-2, 2, (3, 3)))
        kind = rng.choice(["revolute", "continuous"])
        limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
        inside = f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>{limit}'
        parts += [f'<link name="l{k}"/>', joint_xml(f"j{k}", f"l{k - 1}", f"l{k}", kind, inside)]
    model = model_of(*parts)
    chain = build_chain(model, range(1, 8), "l0", "l7")
    q = rng.uniform(-3, 3, 7)
    np.testing.assert_allclose(
        product_of_exponentials(chain, q), pose_in_whole_robot(model, chain, q), rtol=0, atol=5e-13
    )
    assert random_configuration(chain.model, rng).shape == (chain.model.nq,)
