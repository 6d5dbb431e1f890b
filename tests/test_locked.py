"""Joints that are no part of the arm: where they are locked, and that poses are those of the whole robot there."""

import warnings

import numpy as np
import pinocchio as pin
import pytest
from command_line import Q, answer, run
from robot_files import joint_xml, serial_arm

import srs_ik
from srs_ik.errors import InvalidConfiguration, InvalidRobot, NotAnSrsLimb
from srs_ik.loading.adapter import write_adapter

LOCKED = {"lift": 0.3, "waist": -0.7, "turn": 2.0}


def joint(name: str, parent: str, child: str, kind: str, axis: str, lower: float, upper: float, more: str = "") -> str:
    limit = f'<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/>'
    inside = f'<origin xyz="0.1 0.2 0.3" rpy="0.4 0.1 0.2"/><axis xyz="{axis}"/>{limit}{more}'
    return f'<link name="{child}"/>' + joint_xml(name, parent, child, kind, inside)


def body(lowest: float = 0.0, more: str = "") -> str:
    """A lift, a waist and a turning column, an arm on them, and a finger on its hand."""
    return (
        '<robot name="body"><link name="floor"/>'
        + joint("lift", "floor", "torso", "prismatic", "0 0 1", lowest, 0.5, more)
        + joint("waist", "torso", "chest", "revolute", "0 1 0", -1.0, 1.0)
        + joint("turn", "chest", "column", "continuous", "1 0 0", 0.0, 0.0)
        + serial_arm()
        + joint_xml("on_column", "column", "l0", "fixed", "")
        + joint("finger", "l7", "nail", "prismatic", "1 0 0", 0.0, 0.1)
        + "</robot>"
    )


def tip_in_base(arm, model, configuration) -> np.ndarray:
    data = model.createData()
    pin.framesForwardKinematics(model, data, configuration)
    base, tip = (data.oMf[model.getFrameId(frame)] for frame in (arm.base, arm.tip))
    return base.actInv(tip).homogeneous


@pytest.fixture(scope="module")
def model():
    return pin.buildModelFromXML(body())


@pytest.mark.parametrize("base", ["floor", "torso", "column", None])
@pytest.mark.parametrize("tip", ["l7", "nail"])
def test_poses_are_those_of_the_whole_robot_with_its_joints_there(base, tip, model):
    arm = srs_ik.load(body(), base=base, tip=tip, locked={**LOCKED, "finger": 0.05})
    assert arm.locked == {**LOCKED, "finger": 0.05}
    whole = pin.neutral(model)
    for name, at in arm.locked.items():
        one = model.joints[model.getJointId(name)]
        whole[one.idx_q : one.idx_q + one.nq] = [at] if one.nq == 1 else [np.cos(at), np.sin(at)]
    q = np.array(Q, dtype=float)
    solution = arm.solve(arm.forward_kinematics(q), seed=q)
    # Those that are not given stand where the arm has them, too.
    for others in (whole, None):
        filled = arm.configuration(solution.q, model, others)
        reached = tip_in_base(arm, model, filled)
        np.testing.assert_allclose(reached, arm.forward_kinematics(q).homogeneous, atol=1e-12)  # m, rounding


def test_joints_elsewhere_between_base_and_tip_are_refused_and_behind_the_base_do_not_count(model):
    whole = pin.neutral(model)
    waist = model.joints[model.getJointId("waist")].idx_q
    whole[waist] = 0.5
    q = [0.1] * 7
    far = srs_ik.load(model, base="floor", tip="l7")
    moved = far.forward_kinematics(q).translation
    with pytest.raises(InvalidConfiguration, match=r"joint 'waist', between base and tip, is at 0\.5, not at 0 where"):
        far.configuration(q, model, whole)
    near = srs_ik.load(model, tip="l7")
    reached = tip_in_base(near, model, near.configuration(q, model, whole))
    np.testing.assert_allclose(reached, near.forward_kinematics(q).homogeneous, atol=1e-12)  # m, rounding
    whole[waist] = 5e-4
    whole[model.joints[model.getJointId("finger")].idx_q] = 0.1
    reached = tip_in_base(far, model, far.configuration(q, model, whole))
    # A joint that was measured a little off puts the tip off by as little: rad times the reach of 1.7 m.
    assert 0.0 < np.linalg.norm(reached[:3, 3] - moved) < 5e-4 * 1.7


@pytest.mark.parametrize(
    ("locked", "says"),
    [
        ({"lft": 0.1}, r"there is no joint 'lft' to lock \(did you mean 'lift'\?\); the joints are lift, waist"),
        ({"lift": 0.6}, "joint 'lift' goes from 0 to 0.5 and cannot be locked at 0.6"),
        ({"lift": np.nan}, "joint 'lift' is locked at a finite number, rad or m, not at nan"),
        ({"lift": "up"}, "joint 'lift' is locked at a finite number, rad or m, not at 'up'"),
        ({"turn": np.inf}, "joint 'turn' is locked at a finite number, rad or m, not at inf"),
        ({3: 0.1}, "there is no joint 3 to lock"),
        (0.3, r"locked is given as \{joint: position\}, not as 0.3"),
    ],
)
def test_what_cannot_be_locked(locked, says):
    for call in (srs_ik.load, srs_ik.find_limbs):
        with pytest.raises(InvalidRobot, match=f"^{says}"):
            call(body(), locked=locked)


def test_a_joint_of_the_arm_cannot_be_locked():
    with pytest.raises(NotAnSrsLimb, match=r"j3 cannot be of it, as locked$"):
        srs_ik.load(body(), locked={"j3": 0.1})
    with pytest.raises(NotAnSrsLimb, match=r"\(.*j3 is locked.*\)"):
        srs_ik.load(body(), base="floor", tip="l7", locked={"j3": 0.1})


def test_joints_that_cannot_be_at_zero_are_told_where_they_count():
    said = r"locked at 0, where it cannot be: lift \(0.2 to 0.5\); say where it is, by locked= or --lock"
    with pytest.warns(UserWarning, match=said):
        srs_ik.load(body(lowest=0.2), base="floor")
    (report,) = srs_ik.find_limbs(body(lowest=0.2))
    assert report.note == ""  # its base is behind the lift
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        srs_ik.load(body(lowest=0.2))  # its base is behind the lift
        srs_ik.load(body(lowest=0.2), base="floor", locked={"lift": 0.2})
    (report,) = srs_ik.find_limbs(body(lowest=0.2), locked={"lift": 0.2})
    assert (report.note, report.locked, report.locked_at) == ("", ("lift", "waist", "turn"), {"lift": 0.2})
    assert report.describe().endswith("; carried by joints on which no pose depends: lift at 0.2, waist, turn.")
    assert report.carried_by == report.locked


def test_joints_between_the_arm_and_its_tip_that_stand_still_are_told():
    said = r"the arm ends with j7, and on the way to the tip 'nail' finger stands still at zero: is this the arm"
    with pytest.warns(UserWarning, match=said):
        srs_ik.load(body(), tip="nail")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        srs_ik.load(body(), tip="nail", locked={"finger": 0.0})
        srs_ik.load(body(), base="floor", tip="l7")


def test_a_joint_that_mimics_a_locked_one_stands_where_that_has_it():
    slide = joint("second", "l7", "plate", "prismatic", "0 0 1", 0.0, 1.0, '<mimic joint="lift"/>')
    xml = body().replace("</robot>", slide + "</robot>")
    assert srs_ik.load(xml, locked={"lift": 0.1}, tip="l7").locked == {"lift": 0.1, "second": 0.1}
    assert srs_ik.load(xml, locked={"lift": 0.1, "second": 0.1}, tip="l7").locked == {"lift": 0.1, "second": 0.1}


def test_a_joint_that_is_locked_beside_the_one_that_it_mimics_is_told():
    slide = joint("second", "l7", "plate", "prismatic", "0 0 1", 0.0, 1.0, '<mimic joint="lift"/>')
    xml = body().replace("</robot>", slide + "</robot>")
    with pytest.warns(UserWarning, match=r"^'second' is locked at 0\.1 and mimics lift, which is not locked: it stays"):
        srs_ik.load(xml, tip="l7", locked={"second": 0.1})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        srs_ik.load(xml, tip="l7", locked={"lift": 0.1, "second": 0.1})


def test_joints_locked_in_degrees_are_asked_about():
    with pytest.warns(UserWarning, match=r"^locked is in radians, and joint 'turn' is given 90, .*degrees\?$"):
        srs_ik.load(body(), locked={"turn": 90})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        srs_ik.load(body(), locked={"turn": 6.2, "lift": 0.5})


def test_adapters_and_the_command_line_lock_joints_too(tmp_path, model):
    file, adapter = tmp_path / "body.urdf", tmp_path / "robot.toml"
    file.write_text(body())
    lock = ["--lock", "lift:=0.3", "--lock", "waist:=-0.7", "--base", "floor", "--tip", "l7"]
    arm = srs_ik.load(file, base="floor", tip="l7", locked={"lift": 0.3, "waist": -0.7})
    expected = arm.forward_kinematics(np.array(Q, dtype=float)).homogeneous
    np.testing.assert_allclose(answer("fk", str(file), "--q", *Q, *lock)["T_base_tip"], expected, atol=1e-12)
    (shown,) = answer("inspect", str(file), *lock, "--write", str(adapter))["limbs"]
    assert (shown["locked"], shown["locked_at"]) == (["lift", "waist", "turn"], {"lift": 0.3, "waist": -0.7})
    assert "locked between base and tip: lift at 0.3, waist at -0.7, turn\n" in run("inspect", str(file), *lock).stdout
    lock[lock.index("floor")] = "torso"
    (shown,) = answer("inspect", str(file), *lock)["limbs"]
    assert (shown["locked"], shown["carried_by"]) == (["lift", "waist", "turn"], ["lift"])
    said = run("inspect", str(file), *lock).stdout
    assert "locked between base and tip: waist at -0.7, turn\n" in said
    assert "carried by joints on which no pose depends: lift at 0.3\n" in said
    assert srs_ik.load(adapter).locked == arm.locked
    np.testing.assert_allclose(answer("fk", str(adapter), "--q", *Q)["T_base_tip"], expected, atol=1e-12)
    again = srs_ik.load(adapter, locked={"waist": 0.1})
    whole = again.configuration(np.array(Q, dtype=float), model)
    np.testing.assert_allclose(
        tip_in_base(again, model, whole), again.forward_kinematics(np.array(Q, dtype=float)).homogeneous, atol=1e-12
    )
    adapter.write_text(adapter.read_text().replace('"lift" = 0.3', '"lift" = "up"'))
    with pytest.raises(InvalidRobot, match=r"'lift' in \[locked\] must be a number, not 'up'"):
        srs_ik.load(adapter)
    assert run("fk", str(file), "--q", *Q, "--lock", "lift").stderr.startswith("srs-ik: --lock takes NAME:=VALUE")


def test_a_simulated_arm_stands_on_its_locked_joints():
    mujoco = pytest.importorskip("mujoco", "3.14")
    from srs_ik.sim.model import make_spec

    inertia = '<mass value="1"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/>'
    xml = body()
    for k in range(1, 8):
        xml = xml.replace(f'<link name="l{k}"/>', f'<link name="l{k}"><inertial>{inertia}</inertial></link>')
    arm = srs_ik.load(xml, base="floor", tip="l7", locked=LOCKED)
    simulated = make_spec(arm)[0].compile()
    state = mujoco.MjData(simulated)
    state.qpos[:] = np.array(Q, dtype=float)
    mujoco.mj_forward(simulated, state)
    data = arm.model.createData()
    pin.forwardKinematics(arm.model, data, arm.configuration(np.array(Q, dtype=float)))
    np.testing.assert_allclose(state.xpos[-1], data.oMi[7].translation, atol=1e-12)  # m, rounding


# Joints that follow others


def led(more: str, leader: str = "", lowest: float = 0.0) -> str:
    """`body` with a lift that follows another joint."""
    return body(lowest, f"<mimic {more}/>").replace("</robot>", leader + "</robot>")


AHEAD = joint("ahead", "floor", "cart", "prismatic", "0 0 1", -1.0, 1.0)


@pytest.mark.parametrize(
    ("locked", "lift"), [(None, 0.25), ({"ahead": 0.1}, 0.05), ({"ahead": 0.1, "lift": 0.0505}, 0.0505)]
)
def test_a_joint_that_follows_another_stands_where_that_one_has_it(locked, lift):
    """Against Pinocchio's own joints that follow others."""
    xml = led('joint="ahead" multiplier="-2" offset="0.25"', AHEAD)
    arm = srs_ik.load(xml, base="floor", locked=locked)
    assert arm.locked["lift"] == pytest.approx(lift, abs=1e-12)
    model = pin.buildModelFromXML(xml, mimic=True)
    data, at_zero = model.createData(), pin.neutral(model)
    at_zero[model.joints[model.getJointId("ahead")].idx_q] = (0.25 - lift) / 2.0
    pin.framesForwardKinematics(model, data, at_zero)
    base, tip = (data.oMf[model.getFrameId(frame)] for frame in (arm.base, arm.tip))
    np.testing.assert_allclose(
        arm.forward_kinematics(np.zeros(7)).homogeneous, base.actInv(tip).homogeneous, atol=1e-12
    )


def test_a_chain_of_followers_and_a_ring_of_them_stand_still():
    second = joint("second", "floor", "box", "prismatic", "0 0 1", -1.0, 1.0, '<mimic joint="ahead" offset="0.2"/>')
    xml = led('joint="second" multiplier="0.5" offset="0.1"', AHEAD + second)
    assert srs_ik.load(xml, base="floor").locked == {"lift": pytest.approx(0.2), "second": 0.2}
    ring = joint("second", "floor", "box", "prismatic", "0 0 1", -1.0, 1.0, '<mimic joint="lift"/>')
    assert np.isfinite(srs_ik.load(led('joint="second"', ring), base="floor").forward_kinematics(np.zeros(7))).all()


def test_a_position_that_contradicts_the_joint_that_it_follows_is_refused():
    xml = led('joint="ahead" offset="0.2"', AHEAD)
    with pytest.raises(InvalidRobot, match=r"^'lift' mimics 'ahead', which is locked at 0\.1: it stands at 0\.3 then"):
        srs_ik.load(xml, base="floor", locked={"ahead": 0.1, "lift": 0.1})


def test_a_base_that_a_joint_of_the_arm_moves_is_refused():
    """The lift goes up with joint 7: no arm on the floor has one pose for it."""
    second = joint("second", "floor", "box", "revolute", "0 0 1", -1.0, 1.0, '<mimic joint="j7"/>')
    for xml in (led('joint="j7"', second), led('joint="second"', second)):
        with pytest.raises(NotAnSrsLimb, match=r"'lift', between base 'floor' and tip .*, follows 'j7', a joint of"):
            srs_ik.load(xml, base="floor")
        assert srs_ik.load(xml, base="torso").still_joints == ("waist", "turn")
        with pytest.warns(UserWarning, match="it stays there while its leader moves"):
            assert srs_ik.load(xml, base="floor", locked={"lift": 0.2}).locked == {"lift": 0.2}


def test_a_tip_that_a_joint_of_the_arm_moves_a_second_time_is_refused():
    follower = '<mimic joint="j7" multiplier="0.1"/></joint>'
    head, _, finger = body().partition('<joint name="finger"')
    xml = head + '<joint name="finger"' + finger.replace("</joint>", follower, 1)
    for source in (xml, pin.buildModelFromXML(xml, mimic=True)):
        with pytest.raises(NotAnSrsLimb, match=r"'finger', between base .* and tip 'nail', follows 'j7', a joint of"):
            srs_ik.load(source, tip="nail")
        assert srs_ik.load(source, tip="l7").still_joints == ()


@pytest.mark.parametrize("more", ['joint="ahead" offset="nan"', 'joint="ahead" multiplier="1e300"'])
def test_figures_of_mimicking_joints_are_checked(more):
    with pytest.raises(InvalidRobot, match=r"<mimic>.* of joint 'lift'"):
        srs_ik.load(led(more, AHEAD), base="floor")


@pytest.mark.filterwarnings("ignore:.*it stays there while its leader moves")
def test_an_adapter_may_hold_a_joint_that_follows_one_of_the_arm(tmp_path):
    file, adapter = tmp_path / "body.urdf", tmp_path / "robot.toml"
    file.write_text(led('joint="j7"'))
    write_adapter(adapter, file, srs_ik.load(file, base="floor", locked={"lift": 0.2}))
    assert srs_ik.load(adapter).locked == {"lift": 0.2}
