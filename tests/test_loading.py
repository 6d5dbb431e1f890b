import os
import re
import subprocess
import sys
import warnings
import xml.etree.ElementTree as ElementTree
from importlib import metadata

import chains
import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from robot_files import REAL, SHARED, at_hand, example_urdf, joint_xml, robot_file, serial_arm, shared_urdf

from srs_ik.errors import (
    AmbiguousLimb,
    FrameNotFound,
    InvalidRobot,
    InvalidTask,
    MissingExtra,
    NotAnSrsLimb,
    install_command,
)
from srs_ik.loading import find_limbs, load, robots
from srs_ik.robot import sources, zoo

ARMS = {
    "made_offsets": [("link_0", "tool", "exact", "XYX")],
    "made_bent": [("link_0", "tool", "exact", "XYX")],
    "made_rounded": [("link_0", "tool", "exact", "XYX")],
    "made_near": [("link_0", "tool", "near", "XYX")],
    "made_folded": [("link_0", "tool", "near", "XYX")],
    "made_oblique": [("link_0", "tool", "near", "XYZ")],
    "made_twins": [
        ("left_link_0", "left_tool", "exact", "XYZ"),
        ("right_link_0", "right_tool", "exact", "XYZ"),
    ],
    "iiwa14_drake_models": [("iiwa_link_0", "iiwa_link_7", "exact", "XYX")],
    "iiwa14_kuka_experimental": [("base_link", "tool0", "near", "XYX")],
    "kinova_gen3_7dof": [("base_link", "tool_frame", "near", "XYX")],
    "kinova_j2s7s300": [("j2s7s300_link_base", "j2s7s300_link_7", "near", "XYX")],
    "med7_lbr_stack": [("lbr_link_0", "lbr_link_ee", "exact", "XYX")],
    "motoman_sia10f": [("base_link", "link_tool0", "exact", "XYX")],
    "motoman_sia5d": [("base_link", "tool0", "exact", "XYX")],
    "realman_rm75": [("base_link", "Link7", "exact", "XYX")],
    "openarm_v10_bimanual": [
        ("openarm_left_link0", "openarm_left_hand", "exact", "XYZ"),
        ("openarm_right_link0", "openarm_right_hand", "exact", "XYZ"),
    ],
    "unitree_h1_2_handless": [
        ("torso_link", "left_wrist_yaw_link", "near", "XYZ"),
        ("torso_link", "right_wrist_yaw_link", "near", "XYZ"),
    ],
}
HUMANOIDS = {
    "human": [("left_clavicle", "left_hand", "exact", "XYZ"), ("right_clavicle", "right_hand", "exact", "XYZ")],
    "simple_humanoid": [("torso", "l_wrist", "exact", "XYZ"), ("torso", "r_wrist", "exact", "XYZ")],
    "icub": [("chest", "l_hand", "exact", "XYZ"), ("chest", "r_hand", "exact", "XYZ")],
    "romeo": [("torso", "l_wrist", "exact", "XYZ"), ("torso", "r_wrist", "exact", "XYZ")],
}
REFUSED = {
    "made_fr3": [("link_0", "tool", "joint_7", 58.7)],
    "made_xarm7": [("link_0", "tool", "joint_7", 50.7)],
    "made_sawyer": [("link_0", "tool", "joint_1", 104.4)],
    "made_yumi": [
        ("left_link_0", "left_tool", "left_joint_2", 20.0),
        ("right_link_0", "right_tool", "right_joint_2", 20.0),
    ],
    "franka_fr3": [("fr3_link0", "fr3_link8", "fr3_joint7", 58.7)],
    "xarm7": [("link_base", "link_eef", "joint7", 50.7)],
    "sawyer": [("right_arm_base_link", "right_hand", "right_j0", 104.4)],
    "abb_yumi": [
        ("yumi_body", "gripper_l_base", "yumi_joint_2_l", 20.0),
        ("yumi_body", "gripper_r_base", "yumi_joint_2_r", 20.0),
    ],
}


def robot(*parts: str, name: str = "small") -> str:
    return f'<robot name="{name}">{"".join(parts)}</robot>'


def fixed(parent: str, child: str, new: bool = True, origin: str = "0 0 0", rpy: str = "0 0 0") -> str:
    link = f'<link name="{child}"/>' if new else ""
    return link + joint_xml(f"{parent}_{child}", parent, child, "fixed", f'<origin xyz="{origin}" rpy="{rpy}"/>')


def moving(parent: str, child: str, kind: str = "revolute", axis: str = "0 0 1", origin: str = "0 0 0") -> str:
    inside = f'<origin xyz="{origin}"/><axis xyz="{axis}"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
    return f'<link name="{child}"/>' + joint_xml(f"{parent}_{child}", parent, child, kind, inside)


def bimanual() -> str:
    arms = [serial_arm(prefix=side) + fixed("torso", f"{side}l0", new=False) for side in ("left_", "right_")]
    return robot('<link name="root"/>', moving("root", "torso"), *arms, name="twins")


def summary(report):
    return (report.base, report.tip, report.kind, report.wrist_kind)


# find_limbs


@pytest.mark.parametrize("name", at_hand(*ARMS))
def test_arms_of_files_are_found(name):
    reports = find_limbs(robot_file(name))
    assert [summary(report) for report in reports] == ARMS[name]
    for report in reports:
        assert report.limb is not None
        assert report.limb.kind == report.kind
        assert report.misses_mm.max() < (1e-3 if report.kind == "exact" else 20)
        assert report.reason == ""
        assert f"{report.base} -> {report.tip} is a" in report.describe()


@pytest.mark.parametrize("name", HUMANOIDS)
def test_arms_of_humanoids_are_found_and_nothing_else(name):
    assert [summary(report) for report in find_limbs(example_urdf(name))] == HUMANOIDS[name]


@pytest.mark.parametrize("name", at_hand(*REFUSED))
def test_other_arms_are_refused_in_millimetres(name):
    reports = find_limbs(robot_file(name))
    assert len(reports) == len(REFUSED[name])
    for report, (base, tip, joint, miss) in zip(reports, REFUSED[name], strict=True):
        assert summary(report) == (base, tip, "refused", None)
        assert report.limb is None
        worst = int(np.argmax(report.misses_mm))
        assert report.joint_names[worst] == joint
        assert report.misses_mm[worst] == pytest.approx(miss, abs=0.05)
        assert f"({joint}) misses" in report.describe()
        assert f"{miss:.1f} mm" in report.describe()


@pytest.mark.parametrize("name", at_hand(*REFUSED))
def test_loading_another_arm_names_the_joints_that_miss(name):
    with pytest.raises(NotAnSrsLimb) as raised:
        load(robot_file(name))
    base, tip, joint, miss = REFUSED[name][0]
    error = raised.value
    assert f"{base} -> {tip}" in str(error)
    assert f"{joint} {miss:.1f}"[:-2] in str(error)
    assert len(error.joint_names) == len(error.misses_mm) == 7
    assert max(error.misses_mm) == pytest.approx(miss, abs=0.05)


@pytest.mark.parametrize("name", at_hand(*ARMS, *HUMANOIDS))
def test_what_is_reported_can_be_loaded(name):
    path = robot_file(name)
    for report in find_limbs(path):
        arm = load(path, base=report.base, tip=report.tip)
        assert (arm.base, arm.tip, arm.joint_names) == (report.base, report.tip, report.joint_names)
        assert (arm.limb.kind, arm.limb.wrist_kind) == (report.kind, report.wrist_kind)
        np.testing.assert_allclose(arm.limb.wrist, report.limb.wrist, atol=1e-12)


def test_a_trunk_that_is_a_limb_by_itself_steps_back_behind_the_arm_and_can_be_asked_for():
    path = example_urdf("human")
    left, _ = find_limbs(path)
    assert left.note == "preferred to chains that share joints with it: middle_abdomen -> left_upperarm"
    assert left.note in left.describe()
    trunk = load(path, base="middle_abdomen", tip="left_upperarm")
    assert trunk.joint_names[0] == "middle_thoracic_Z"
    assert trunk.limb.kind == "exact"


def test_a_refused_chain_that_shares_joints_with_a_limb_is_not_reported():
    xml = robot(
        '<link name="root"/>',
        moving("root", "l0").replace('<link name="l0"/>', ""),
        serial_arm(),
        moving("l7", "finger"),
    )
    (report,) = find_limbs(xml)
    assert report.joint_names == tuple(f"j{k}" for k in range(1, 8))
    assert report.note == ""


def test_one_report_for_a_chain_that_is_none_however_long():
    xml = robot(serial_arm("z y x z y x z y x z y x z y", " ".join(["0.2"] * 14)))
    reports = find_limbs(xml)
    assert [report.kind for report in reports] == ["refused"]
    assert "mm" in reports[0].describe()


def test_parallel_axes_are_explained_by_the_names_of_their_joints():
    (report,) = find_limbs(robot(serial_arm("z z y y z y z")))
    assert np.isnan(report.misses_mm).all()
    assert report.describe() == "l0 -> l7 is no S-R-S limb: axes 1 (j1) and 2 (j2) are parallel."


def test_limbs_come_before_chains_that_are_none():
    bad = serial_arm(offsets="0 0.1 0.3 0 .3 .2 .1", axes="z y z y z y x", prefix="bad_")
    xml = robot('<link name="w"/>', bad, fixed("w", "bad_l0", False), serial_arm(), fixed("w", "l0", False))
    assert [(report.kind, report.tip) for report in find_limbs(xml)] == [("exact", "l7"), ("refused", "bad_l7")]


def test_mimicking_joints_are_no_joints_of_a_limb():
    xml = robot(serial_arm().replace("</joint>", '<mimic joint="j1"/></joint>'))
    assert find_limbs(xml) == []
    with pytest.raises(NotAnSrsLimb, match=r"\(j1 mimics j1, j2 mimics j1, .* j7 mimics j1\)"):
        load(xml, tip="l7")


# load: which limb


def test_models_that_know_mimicking_joints_give_the_arms_of_their_file():
    """Such a joint has no velocity of its own, but a column in the Jacobian, before those of all joints behind it."""
    follows = moving("root", "lift", "prismatic") + moving("lift", "torso", "prismatic").replace(
        "</joint>", '<mimic joint="root_lift"/></joint>'
    )
    finger = moving("left_l7", "a") + moving("left_l7", "b").replace("</joint>", '<mimic joint="left_l7_a"/></joint>')
    arms = [serial_arm(prefix=side) + fixed("torso", f"{side}l0", new=False) for side in ("left_", "right_")]
    xml = robot('<link name="root"/>', follows, arms[0], finger, arms[1])
    model = pin.buildModelFromXML(xml, mimic=True)
    assert model.nvExtended == model.nv + 2
    assert [summary(report) for report in find_limbs(model)] == [summary(report) for report in find_limbs(xml)]
    q = np.linspace(-0.7, 0.6, 7)
    data = model.createData()
    for side in ("left", "right"):
        arm = load(model, limb=side)
        assert arm.limb.kind == "exact"
        pin.framesForwardKinematics(model, data, arm.configuration(q, model))
        base, tip = (data.oMf[model.getFrameId(frame)] for frame in (arm.base, arm.tip))
        solution = arm.solve(base.actInv(tip), seed=q)
        np.testing.assert_allclose(solution.q, q, atol=1e-9)  # rad; rounding of the closed form


def test_two_arms_are_ambiguous_until_one_is_named():
    xml = bimanual()
    with pytest.raises(AmbiguousLimb, match="2 arms of 'twins' fit") as raised:
        load(xml)
    assert raised.value.candidates == (("left_l0", "left_l7"), ("right_l0", "right_l7"))
    for base, tip in raised.value.candidates:
        assert base in str(raised.value)
        for ends in ({"base": base, "tip": tip}, {"tip": tip}, {"base": base}):
            arm = load(xml, **ends)
            assert (arm.base, arm.tip) == (base, tip)


@pytest.mark.parametrize("base", ["root", "torso", "right_l0", "right_l7"])
def test_the_base_may_be_anything_that_the_arm_does_not_move(base):
    plain, arm = load(bimanual(), tip="left_l7"), load(bimanual(), base=base, tip="left_l7")
    assert (arm.base, arm.joint_names) == (base, plain.joint_names)
    assert arm.limb.upper_arm == pytest.approx(plain.limb.upper_arm, abs=1e-12)


@pytest.mark.parametrize("base", ["root", "torso"])
def test_a_base_before_both_arms_does_not_choose_between_them(base):
    with pytest.raises(AmbiguousLimb):
        load(bimanual(), base=base)


def test_a_base_on_which_nothing_hangs_serves_where_there_is_one_arm():
    xml = robot(serial_arm(), fixed("l0", "table", origin="1 2 3"))
    arm = load(xml, base="table")
    assert (arm.base, arm.tip) == ("table", "l7")
    np.testing.assert_allclose(arm.limb.T_base_tip_zero[:3, 3], [-1, -2, 0.7 - 3], atol=1e-14)


def test_joints_after_the_arm_are_locked_and_the_tip_may_lie_behind_them():
    xml = robot(
        serial_arm(), moving("l7", "slide", "prismatic", origin="0 0 .1"), moving("slide", "finger", origin="0 0 .1")
    )
    for tip, height in (("l7", 0.7), ("slide", 0.8), ("finger", 0.9)):
        arm = load(xml, base="l0", tip=tip)
        assert arm.joint_names == tuple(f"j{k}" for k in range(1, 8))
        assert arm.limb.T_base_tip_zero[2, 3] == pytest.approx(height)


@pytest.mark.parametrize(
    ("ends", "says"),
    [
        (
            {"base": "l2", "tip": "l7"},
            "between base 'l2' and tip 'l7' there are no 7 .* but 5 moving joints: j3, j4, j5, j6, j7",
        ),
        ({"base": "l0", "tip": "l6"}, "6 moving joints"),
        ({"base": "l7", "tip": "l0"}, "no moving joint; base and tip are perhaps swapped"),
        ({"base": "l7", "tip": "l7"}, "no moving joint"),
        ({"tip": "l1"}, "on the way to the tip 'l1' there are no 7 .* but 1 moving joint: j1"),
        ({"base": "l3"}, "what hangs on 'l3' has no chain of 7"),
    ],
)
def test_ends_without_seven_joints_between_them(ends, says):
    with pytest.raises(NotAnSrsLimb, match=says):
        load(robot(serial_arm()), **ends)


def test_a_sliding_joint_within_the_arm_is_named():
    xml = robot(serial_arm(kinds={4: "prismatic"}))
    with pytest.raises(NotAnSrsLimb, match=r"j4 is prismatic") as raised:
        load(xml, base="l0", tip="l7")
    assert len(raised.value.joint_names) == 7
    with pytest.raises(NotAnSrsLimb, match="'small' has no chain of 7 consecutive revolute joints"):
        load(xml)


@pytest.mark.parametrize(
    "ends", [{"base": "nix"}, {"tip": "nix"}, {"base": "l0", "tip": "nix"}, {"base": "nix", "tip": "l7"}]
)
def test_unknown_frames(ends):
    with pytest.raises(FrameNotFound) as raised:
        load(robot(serial_arm()), **ends)
    assert raised.value.frame == "nix"
    assert {"l0", "l7"} <= set(raised.value.available)


def test_of_several_refused_chains_the_error_shows_the_nearest():
    far = serial_arm("z y z y z y x", "0 0 .3 0 .3 0 .3", prefix="far_")
    near = serial_arm("z y z y z y x", "0 0 .3 0 .3 0 .1", prefix="near_")
    xml = robot('<link name="w"/>', far, fixed("w", "far_l0", False), near, fixed("w", "near_l0", False))
    with pytest.raises(NotAnSrsLimb, match=r"none of 2 chains of 7 revolute joints .* near_l0 -> near_l7"):
        load(xml)


def test_an_arm_of_six_joints_with_fingers_is_told_where_it_forks():
    six = serial_arm("z y z y z y", "0 0 .3 0 .3 0")
    hinge = '<origin xyz="0.03 0.04 0.1"/><axis xyz="1 0 0"/><limit lower="0" upper="1" effort="1" velocity="1"/>'
    fingers = "".join(
        f'<link name="{name}"/>' + joint_xml(f"{name}_joint", "l6", name, inside=hinge)
        for name in ("left_finger", "right_finger")
    )
    reports = find_limbs(robot(six, fingers))
    forks = "it forks after axis 6 (j6), on which 2 joints hang: a hand may begin there"
    assert [report.note for report in reports] == [forks]
    assert reports[0].side == "either"
    with pytest.raises(NotAnSrsLimb, match=re.escape(forks)):
        load(robot(six, fingers))


def test_the_longest_chain_is_named_where_none_is_long_enough():
    says = "the longest has 5: j1, j2, j3, j4, j5; j6 after them is prismatic; other arms are for packages such as ssik"
    with pytest.raises(NotAnSrsLimb, match=says) as raised:
        load(robot(serial_arm(kinds={6: "prismatic"})))
    assert raised.value.joint_names == ("j1", "j2", "j3", "j4", "j5")


@pytest.mark.parametrize(("mimic", "why"), [('<mimic joint="j1"/>', "j1"), ("<mimic/>", "another joint")])
def test_the_joint_that_interrupts_a_chain_is_named(mimic, why):
    joints = serial_arm().split("</joint>")
    joints[2] += mimic
    with pytest.raises(NotAnSrsLimb, match=f"the longest has 4: j4, j5, j6, j7; j3 before them mimics {why}; other"):
        load(robot("</joint>".join(joints)))


def test_a_chain_that_is_too_short_and_interrupted_by_nothing_has_no_reason():
    with pytest.raises(NotAnSrsLimb, match=r"the longest has 6: j1, j2, j3, j4, j5, j6; other arms"):
        load(robot(serial_arm("z y z y z y", "0 0 .3 0 .3 0")))


def test_limits_that_look_like_degrees_are_noted():
    def of(lower, upper):
        return robot(serial_arm().replace('lower="-2" upper="2"', f'lower="{lower}" upper="{upper}"', 2))

    (report,) = find_limbs(of(-120, 120))
    said = (
        "limits are in radians, and those of j1, j2 are up to 240 rad apart, more than 16 turns: they look like degrees"
    )
    assert report.note == said
    assert report.describe().endswith(f"; {said}.")
    for lower, upper in ((-2.0, 2.0), (-2 * np.pi, 2 * np.pi), (-50.0, 50.0), (-1e4, 1e4), (-1e9, 1e9)):
        assert find_limbs(of(lower, upper))[0].note == ""
    six = serial_arm("z y z y z y", "0 0 .3 0 .3 0")
    hinge = '<axis xyz="1 0 0"/><limit lower="-120" upper="120" effort="1" velocity="1"/>'
    fingers = "".join(f'<link name="f{k}"/>' + joint_xml(f"f{k}_joint", "l6", f"f{k}", inside=hinge) for k in (1, 2))
    (report,) = find_limbs(robot(six, fingers))
    first = "preferred to chains that share joints with it: l0 -> f1; limits are in radians, and those of f2_joint are"
    assert report.note.startswith(first)


def test_joints_that_a_file_leaves_without_a_range_are_told():
    """A <limit> without lower and upper means 0 for both; the file is valid, and the arm cannot move."""
    xml = robot(serial_arm().replace('lower="-2" upper="2" ', "", 2))
    said = "j1, j2 cannot move: lower and upper limit are 0, as where a file leaves them out"
    assert find_limbs(xml)[0].note == said
    with pytest.warns(UserWarning, match=f"^the URDF text: {said}$"):
        assert load(xml).upper.tolist() == [0.0, 0.0, 2.0, 2.0, 2.0, 2.0, 2.0]


@pytest.mark.parametrize("part", ['lower="-150" upper="150" ', ""])
def test_odd_limits_are_a_warning_unless_others_are_given(part):
    xml = robot(serial_arm().replace('lower="-2" upper="2" ', part, 1))
    with pytest.warns(UserWarning, match="j1"):
        load(xml)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert load(xml, limits={"j1": {"lower": -1.0, "upper": 1.0}}).lower[0] == -1.0
        load(robot(serial_arm()))


def test_lengths_that_look_like_millimetres_are_told():
    """An arm of 0.6 m in millimetres, and one of 14 m that is no slip: arms in space are as long."""
    said = "lengths are in metres, and the arm is 600 m long: are these millimetres?"
    xml = robot(serial_arm(offsets="0 0 300 0 300 0 100"))
    assert find_limbs(xml)[0].note == said
    with pytest.warns(UserWarning, match=re.escape(f"the URDF text: {said}")):
        load(xml)
    assert find_limbs(robot(serial_arm(offsets="0 0 7 0 7 0 1")))[0].note == ""


# load: from what


@pytest.mark.parametrize("name", at_hand("made_offsets", "iiwa14_drake_models"))
def test_every_form_of_a_robot_gives_the_same_arm(name):
    path = robot_file(name)
    model = pin.buildModelFromUrdf(str(path))
    before = model.copy()
    urdf = yourdfpy.URDF.load(str(path), build_scene_graph=False, load_meshes=False)
    arms = [load(s) for s in (path, str(path), path.read_text(), model, urdf)]
    assert model == before
    q = np.linspace(-1, 1, 7)
    for arm in arms:
        assert arm.name == ElementTree.fromstring(path.read_text()).get("name")
        assert [(arm.base, arm.tip)] == [row[:2] for row in ARMS[name]]
        np.testing.assert_array_equal(arm.lower, arms[0].lower)
        np.testing.assert_array_equal(arm.effort_limit, arms[0].effort_limit)
        np.testing.assert_allclose(
            arm.forward_kinematics(q).homogeneous, arms[0].forward_kinematics(q).homogeneous, rtol=0, atol=1e-14
        )


@pytest.mark.parametrize("name", zoo.robots())
def test_a_built_in_robot_comes_with_what_its_card_says(name):
    arm, card = load(name), zoo.card(name)
    assert (arm.name, arm.base, arm.tip) == (name, card.base, card.tip)
    np.testing.assert_array_equal(arm.limb.reference, card.reference)
    assert arm.hand == (card.grasp, card.pronosupination)
    (report,) = find_limbs(name)
    assert (report.base, report.tip) == (card.base, card.tip)
    assert load(name, name="mine").name == "mine"


def test_reference_and_hand_of_a_built_in_robot_turn_with_the_frames():
    plain, turned = load("iiwa14"), load("iiwa14", base="iiwa_link_0", tip="iiwa_link_7")
    R = plain.limb.T_base_tip_zero[:3, :3].T @ turned.limb.T_base_tip_zero[:3, :3]
    assert np.abs(R - np.eye(3)).max() > 0.5, "the two tip frames ought to differ"
    for axis, same in zip(turned.hand, plain.hand, strict=True):
        np.testing.assert_allclose(R @ axis, same, atol=1e-12)
    asked = load("iiwa14", reference=[0, -2, 0], hand=[[0, 0, 3], [1, 0, 1]])
    np.testing.assert_array_equal(asked.limb.reference, [0, -1, 0])
    np.testing.assert_allclose(asked.hand, [[0, 0, 1], [1, 0, 0]], atol=1e-15)


def test_the_reference_of_a_built_in_robot_turns_into_another_base(monkeypatch, tmp_path):
    text = zoo.card("iiwa14").urdf.read_text()
    text = text.replace("</robot>", fixed("iiwa_link_0", "tilted", rpy="0.3 0.4 0.5") + "</robot>")
    path = tmp_path / "iiwa14.urdf"
    path.write_text(text)
    card = zoo.card("iiwa14")
    fields = {field: getattr(card, field) for field in card.__dataclass_fields__} | {"places": (str(path),)}
    monkeypatch.setattr(zoo, "card", lambda name: type(card)(**fields))
    arm = load("iiwa14", base="tilted")
    expected = pin.rpy.rpyToMatrix(0.3, 0.4, 0.5).T @ np.array(card.reference)
    np.testing.assert_allclose(arm.limb.reference, expected, atol=1e-14)


def test_a_name_wins_over_a_file_of_that_name_but_not_over_a_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "iiwa14").write_text(robot(serial_arm()))
    (tmp_path / "my_robot_description").write_text(robot(serial_arm()))
    assert load("iiwa14").name == "iiwa14"
    assert load("./iiwa14").name == "small"
    assert load(tmp_path / "iiwa14").name == "small"
    assert load("my_robot_description").name == "small"


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_human_arms_of_example_robot_data(side):
    example_urdf("human")
    arm = load(f"human_{side}")
    assert (arm.name, arm.base, arm.tip) == (f"human_{side}", f"{side}_clavicle", f"{side}_hand")
    assert arm.joint_names[0] == f"{side}_shoulder_Z"
    assert (arm.limb.kind, arm.limb.wrist_kind) == ("exact", "XYZ")
    assert (arm.limb.upper_arm, arm.limb.forearm) == pytest.approx((0.276, 0.287), abs=1e-9)
    # The arm hangs down at zero: the grasp direction goes on along the forearm, the other one is the axis of the elbow.
    R = arm.limb.T_base_tip_zero[:3, :3]
    forearm = arm.limb.wrist - arm.limb.elbow
    np.testing.assert_allclose(R @ arm.hand.grasp, forearm / np.linalg.norm(forearm), atol=1e-12)
    np.testing.assert_allclose(R @ arm.hand.pronosupination, arm.limb.axes[3], atol=1e-12)


def test_the_human_is_found_by_the_package_where_it_is_in_no_prefix(monkeypatch):
    path = example_urdf("human")
    monkeypatch.setattr(pin, "__file__", "/nowhere/pinocchio/__init__.py")
    monkeypatch.setattr(sys, "prefix", "/nowhere")
    assert sources.describe("human_left").robot.source == str(path)


def test_missing_packages_are_named_with_the_command_that_brings_them(monkeypatch):
    def missing(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(pin, "__file__", "/nowhere/pinocchio/__init__.py")
    monkeypatch.setattr(sys, "prefix", "/nowhere")
    monkeypatch.setattr(metadata, "files", missing)
    monkeypatch.setitem(sys.modules, "robot_descriptions", None)
    for name in ("human_left", "iiwa14_description"):
        with pytest.raises(MissingExtra, match=rf"'{name}'.*{re.escape(install_command('robots'))}") as raised:
            load(name)
        assert raised.value.extra == "robots"
    commands = {entry.name: entry.install for entry in sources.catalogue()}
    assert list(commands) == robots()
    assert commands["iiwa14"] == ""
    assert commands["human_left"] == commands["human_right"] == install_command("robots")


def test_the_catalogue_names_the_frames_that_load_takes():
    for entry in sources.catalogue():
        if not entry.install and not entry.fetched:
            arm = load(entry.name)
            assert (arm.base, arm.tip) == (entry.base, entry.tip)


@pytest.fixture
def robot_descriptions(monkeypatch, tmp_path):
    """A stand-in for the package, which fetches its files from the network."""
    package = tmp_path / "robot_descriptions"
    package.mkdir()
    (tmp_path / "arm.urdf").write_text(robot(serial_arm(), name="described"))
    (package / "__init__.py").write_text("")
    (package / "arm_description.py").write_text(f"print('Cloning'); URDF_PATH = {str(tmp_path / 'arm.urdf')!r}")
    (package / "grown_description.py").write_text(
        f"XACRO_PATH = {str(tmp_path / 'grown.urdf.xacro')!r}\nXACRO_ARGS = {{'reach': '0.35'}}\n"
        f"XACRO_PACKAGE_PATHS = {{'parts': {str(tmp_path / 'elsewhere')!r}}}\n"
    )
    (tmp_path / "grown.urdf.xacro").write_text(
        '<robot name="grown" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="reach" default="1"/>'
        '<xacro:include filename="$(find parts)/arm.xacro"/></robot>'
    )
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "arm.xacro").write_text(robot(serial_arm()).replace('"0 0 .3"', '"0 0 $(arg reach)"'))
    (package / "arm_mj_description.py").write_text("MJCF_PATH = 'arm.xml'")
    (package / "far_description.py").write_text("raise OSError('no network\\nand more')")
    monkeypatch.syspath_prepend(tmp_path)
    for module in [name for name in sys.modules if name.partition(".")[0] == "robot_descriptions"]:
        monkeypatch.delitem(sys.modules, module)
    yield
    for module in [name for name in sys.modules if name.partition(".")[0] == "robot_descriptions"]:
        del sys.modules[module]


@pytest.mark.usefixtures("robot_descriptions")
def test_names_of_robot_descriptions():
    assert load("arm_description").name == "described"
    with pytest.raises(
        InvalidRobot,
        match=r"'amr_description' is neither .* \(did you mean .*'arm_description'.*; there are arm_description, ",
    ):
        load("amr_description")
    with pytest.raises(InvalidRobot, match="'arm_mj_description' in other formats than URDF only"):
        load("arm_mj_description")
    with pytest.raises(InvalidRobot, match=r"'far_description' could not be fetched: no network; where there"):
        load("far_description")


def test_names_lists_what_load_knows():
    assert robots() == [*zoo.robots(), *zoo.adapters()]
    assert {"iiwa14", "gen3", "human_arm", "human_left", "human_right"} <= set(robots())


@pytest.mark.parametrize(
    ("source", "says"),
    [
        (
            "iwa14",
            r"'iwa14' is neither a file nor .* \(did you mean 'iiwa14' or .*\?\); there are .*human_left",
        ),
        ("human_lef", "did you mean 'human_left' or"),
        ("nowhere.urdf", r"there is no file nowhere\.urdf"),
        ("folder/nowhere", "there is no file folder/nowhere"),
        ("", "neither a file nor the name"),
        ("kinova", r"robot \(perhaps gen3, j2s7s300\); there are"),
        ("ur5", "; others have a path, or NAME_description$"),
        ("x" * 5000, r"\.\.\.' is neither a file"),
        ("a\0b", "neither a file nor the name"),
        ("<robot", "not well-formed"),
        (5, "object of type int"),
    ],
)
def test_sources_that_are_none(source, says):
    for function in (load, find_limbs):
        with pytest.raises(InvalidRobot, match=says) as raised:
            function(source)
        assert len(str(raised.value)) < 400


def test_a_missing_file_is_told_the_files_beside_it(tmp_path):
    (tmp_path / "left_arm.urdf").write_text("")
    (tmp_path / "left_amr").mkdir()  # a folder is no file
    with pytest.raises(InvalidRobot, match=r"left_amr\.urdf \(did you mean 'left_arm\.urdf'\?\)"):
        load(tmp_path / "left_amr.urdf")


@pytest.mark.usefixtures("robot_descriptions")
def test_a_xacro_file_of_robot_descriptions_comes_with_its_arguments_and_packages():
    pytest.importorskip("xacro")
    assert load("grown_description").limb.upper_arm == pytest.approx(0.35, abs=1e-12)
    asked = load("robot_descriptions://grown_description", xacro_args={"reach": "0.25"})
    assert asked.limb.upper_arm == pytest.approx(0.25, abs=1e-12)


@pytest.mark.usefixtures("robot_descriptions")
def test_fetching_says_nothing_where_nobody_watches(capfd):
    load("arm_description")
    assert capfd.readouterr() == ("", "")
    with pytest.raises(InvalidRobot, match=r"did you mean 'arm_description'"):
        load("arm")


@pytest.mark.parametrize("name", at_hand(*REFUSED))
def test_refusals_name_the_file_and_what_would_be_accepted(name):
    with pytest.raises(NotAnSrsLimb) as raised:
        load(robot_file(name))
    assert str(raised.value).startswith(str(robot_file(name)))
    worst, allowed = max(raised.value.misses_mm), raised.value.allowed_mm
    assert 5 < allowed < worst
    assert f"; {allowed:.1f} mm are allowed" in str(raised.value)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"reference": [0, 0, 0]}, "reference is .* no direction"),
        ({"reference": [0, float("nan"), 1]}, "no direction"),
        ({"reference": [0, 1]}, r"reference has the shape \(2,\), not \(3,\)"),
        ({"reference": "up"}, "reference is not an array of 3 numbers"),
        ({"hand": [[1, 0, 0], [2, 0, 0]]}, "parallel"),
        ({"hand": [1, 0, 0]}, "hand is not a pair"),
        ({"hand": [[1, 0, 0], [0, 0, 0]]}, "pronosupination of hand is .* no direction"),
        ({"hand": 3}, "hand is not a pair"),
    ],
)
def test_directions_that_are_none(options, says):
    with pytest.raises(InvalidTask, match=says):
        load("iiwa14", **options)


# The rest


@pytest.mark.parametrize("name", at_hand("made_folded", "kinova_gen3_7dof"))
def test_continuous_joints_reach_the_arm(name):
    arm = load(robot_file(name))
    np.testing.assert_array_equal(np.isinf(arm.upper), [True, False] * 3 + [True])
    assert arm.model.nq == 11


@pytest.mark.parametrize("name", at_hand("made_near", "iiwa14_kuka_experimental"))
def test_limits_that_a_file_does_not_give_are_infinite(name):
    arm = load(robot_file(name))
    assert np.isinf(arm.effort_limit).all()
    assert np.isfinite(arm.velocity_limit).all()


@pytest.mark.parametrize("name", at_hand("made_twins", "unitree_h1_2_handless"))
def test_nothing_is_printed_and_nothing_is_written(name, capfd, tmp_path):
    text = robot_file(name).read_text()
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    left, *_ = find_limbs(path)
    load(path, tip=left.tip)
    assert capfd.readouterr() == ("", "")
    assert os.listdir(tmp_path) == ["robot.urdf"]
    assert path.read_text() == text


def test_importing_the_loader_brings_none_of_the_heavy_libraries():
    heavy = ("yourdfpy", "meshcat", "typer", "rich", "scipy", "trimesh", "robot_descriptions", "numba")
    code = f"import sys, srs_ik.loading; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("name", REAL)
def test_a_real_file_is_at_hand(name):
    """Each file that is not is one skipped test; others leave it out."""
    assert shared_urdf(name).is_file()


def test_every_file_has_its_expectation():
    assert {*ARMS, *REFUSED} == {*chains.MAKERS, *REAL} >= {path.stem for path in SHARED.glob("*.urdf")}


def test_a_model_without_finite_masses_is_refused_in_one_line():
    model = load("iiwa14").model.copy()
    model.inertias[4] = pin.Inertia(1.0, np.array([0.0, np.nan, 0.0]), np.eye(3))
    with pytest.raises(InvalidRobot, match=r"^what joint 'iiwa_joint_4' of 'iiwa14' carries has no finite mass"):
        load(model)


def test_one_of_seven_joints_locked_says_how_to_hold_it():
    with pytest.raises(NotAnSrsLimb, match=r"but 6 moving joints: iiwa_joint_1, .*Arm\.with_limits") as error:
        load("iiwa14", locked={"iiwa_joint_3": 0.0})
    assert str(error.value).count("iiwa_joint_3") == 2


@pytest.mark.parametrize("content", [b"#usda 1.0\n(\n)\n", b"PXR-USDC\x00\x08\x00\x80\xff"])
def test_usd_is_refused_by_its_name(content, tmp_path):
    file = tmp_path / "robot.usd"
    file.write_bytes(content)
    with pytest.raises(InvalidRobot, match="USD, which is not read: URDF, xacro and MJCF are"):
        load(file)


def test_limits_of_a_file_for_all_joints_of_a_robot_are_taken_for_those_of_the_arm():
    """As a joint_limits.yaml of MoveIt has them, with the other arm and the trunk."""
    every = {f"{side}j{k}": {"velocity": 0.5 * k} for side in ("left_", "right_") for k in range(1, 8)}
    arm = load(bimanual(), limb="left", limits={**every, "root_torso": {"max_velocity": 0.1}})
    assert arm.velocity_limit.tolist() == [0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5]
    for limits in ({**every, "lefty_j1": {"velocity": 1.0}}, {"root_torso": {"velocity": 1.0}}):
        with pytest.raises(InvalidRobot, match=r"limits are given for '(lefty_j1|root_torso)'"):
            load(bimanual(), limb="left", limits=limits)
