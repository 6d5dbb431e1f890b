"""Where descriptions come from: packages, xacro, SRDF, MJCF, and which of several limbs is meant."""

import re
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from command_line import run
from robot_files import EXAMPLES, at_hand, example_urdf, joint_xml, robot_file, serial_arm

import srs_ik
from srs_ik.errors import FrameNotFound, InvalidRobot, MissingExtra, NotAnSrsLimb, install_command
from srs_ik.loading.adapter import write_adapter
from srs_ik.robot.description.packages import find_package, inside
from srs_ik.robot.description.srdf import groups
from srs_ik.robot.places import missing
from srs_ik.robot.sides import side_of

ARM = f'<robot name="small">{serial_arm()}</robot>'
XACRO = """<robot name="grown" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="reach" default="0.3"/>
<xacro:include filename="$(find small_description)/urdf/arm.xacro"/>
<xacro:arm reach="$(arg reach)"/>
</robot>"""
MACRO = (
    '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="arm" params="reach">'
    + serial_arm().replace('xyz="0 0 .3"', 'xyz="0 0 ${reach}"')
    + "</xacro:macro></robot>"
)


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A ROS package in a workspace, as a clone of a repository has it."""
    folder = tmp_path / "src" / "repository" / "small_description"
    (folder / "urdf").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>small_description</name></package>")
    (folder / "urdf" / "small.urdf").write_text(ARM)
    (folder / "urdf" / "grown.urdf.xacro").write_text(XACRO)
    (folder / "urdf" / "arm.xacro").write_text(MACRO)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    return folder


# ROS packages


def test_packages_are_found_below_the_path_of_ros_and_in_installations(package, tmp_path, monkeypatch):
    assert find_package("small_description") is None
    for depth in (package, *package.parents[:3]):
        monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{depth}")
        assert find_package("small_description") == package
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    share = tmp_path / "opt" / "share"
    share.mkdir(parents=True)
    package.rename(share / "small_description")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "opt"))
    assert find_package("small_description") == share / "small_description"


def test_packages_are_found_around_a_file_by_their_own_name(package):
    near = package / "urdf" / "grown.urdf.xacro"
    assert find_package("small_description", near) == package
    clone = package.rename(package.with_name("clone-of-it"))
    assert find_package("small_description", clone / "urdf" / "small.urdf") == clone
    assert find_package("clone-of-it", clone / "urdf" / "small.urdf") is None


def test_a_folder_that_bears_the_name_will_do_where_no_package_does(package, tmp_path, monkeypatch):
    bare = tmp_path / "copied" / "small_description"
    (bare / "urdf").mkdir(parents=True)
    assert find_package("small_description", bare / "urdf" / "arm.xacro") == bare
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "copied"))
    assert find_package("small_description") == bare
    assert find_package("small_description", package / "urdf" / "small.urdf") == package
    (bare / "package.xml").write_text("<package><name>another</name></package>")
    assert find_package("small_description") is None


@pytest.mark.parametrize("name", ["", "..", "a/b", "*", "a b"])
def test_names_that_are_no_names_of_packages(name, package, monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(package.parent))
    assert find_package(name, package / "urdf" / "small.urdf") is None


def test_a_package_address_loads_and_does_not_lead_out_of_the_package(package, monkeypatch):
    address = "package://small_description/urdf/small.urdf"
    with pytest.raises(InvalidRobot, match=r"no ROS package 'small_description' here: put the .* ROS_PACKAGE_PATH"):
        srs_ik.load(address)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(package.parent))
    assert srs_ik.load(address).tip == "l7"
    assert missing([address], "small") == ""
    (package.parent / "out.urdf").write_text(ARM)
    for wrong in ("../out.urdf", "urdf/../../out.urdf", str(package.parent / "out.urdf"), "urdf", ""):
        with pytest.raises(InvalidRobot, match="has no file"):
            srs_ik.load(f"package://small_description/{wrong}")
    assert inside(package, "urdf/small.urdf") == package / "urdf/small.urdf"
    with pytest.raises(InvalidRobot, match=r"no address of a description \(did you mean 'package'\?\)"):
        srs_ik.load("packages://small_description/urdf/small.urdf")


# xacro


def test_xacro_files_with_arguments(package):
    pytest.importorskip("xacro")
    path = package / "urdf" / "grown.urdf.xacro"
    plain, long = srs_ik.load(path), srs_ik.load(str(path), xacro_args={"reach": "0.5"})
    assert (plain.name, plain.joint_names) == ("grown", tuple(f"j{k}" for k in range(1, 8)))
    assert (plain.limb.upper_arm, long.limb.upper_arm) == pytest.approx((0.3, 0.5), abs=1e-12)
    np.testing.assert_array_equal(plain.limb.points, srs_ik.load(ARM).limb.points)
    (report,) = srs_ik.find_limbs(path, xacro_args={"reach": "0.4"})
    assert report.limb.upper_arm == pytest.approx(0.4)


def test_an_argument_that_a_xacro_file_makes_no_use_of_is_told(package):
    pytest.importorskip("xacro")
    path = package / "urdf" / "grown.urdf.xacro"
    said = r"grown\.urdf\.xacro makes no use of the argument 'raech' \(did you mean 'reach'\?\)$"
    with pytest.warns(UserWarning, match=said):
        arm = srs_ik.load(path, xacro_args={"raech": "0.5"})
    assert arm.limb.upper_arm == pytest.approx(0.3)
    # It is printed, though what xacro itself prints is not.
    code = f"import srs_ik; srs_ik.load({str(path)!r}, xacro_args={{'raech': '0.5'}})"
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stderr
    assert "makes no use of the argument 'raech'" in printed
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        srs_ik.load(path, xacro_args={"reach": "0.5"})


def test_what_is_wrong_with_a_xacro_file_is_one_line(package, monkeypatch, capfd):
    pytest.importorskip("xacro")
    path = package / "urdf" / "grown.urdf.xacro"
    wrong = {
        XACRO.replace("$(find small_", "$(find other_"): "needs the ROS package 'other_description', which is not here",
        XACRO.replace("arm.xacro", "leg.xacro"): "cannot be expanded: .*leg.xacro",
        XACRO.replace("$(arg reach)", "${1/0}"): "cannot be expanded: .*division by zero",
        XACRO.replace("$(arg reach)", "$(arg rich)"): "argument 'rich' has no value: .* --xacro-arg rich:=VALUE$",
        '<robot name="a" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:macro name="m"><link name="l"/></xacro:macro>'
        "</robot>": "expands to nothing: .*macros",
        XACRO.replace("</robot>", ""): "cannot be expanded: .*no element found",
        XACRO.replace("<xacro:arm", "<xacro:leg"): "cannot be expanded: .*leg",
        XACRO.replace("$(arg reach)", "x"): "xyz of joint 'j3' is '0 0 x'|'x'",
    }
    for text, says in wrong.items():
        path.write_text(text)
        with pytest.raises(InvalidRobot, match=says) as raised:
            srs_ik.load(path)
        assert len(str(raised.value).splitlines()) == 1
        assert path.name in str(raised.value)
    assert capfd.readouterr() == ("", "")
    with pytest.raises(InvalidRobot, match="there is no file"):
        srs_ik.load(package / "none.xacro")
    with pytest.raises(InvalidRobot, match=r"arguments are for xacro files"):
        srs_ik.load(package / "urdf" / "small.urdf", xacro_args={"a": "b"})
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(MissingExtra, match=re.escape(install_command("xacro"))):
        srs_ik.load(path)
    # No package would bring a file that is not there.
    with pytest.raises(InvalidRobot, match="there is no file"):
        srs_ik.load(package / "none.xacro")


def test_a_recursive_xacro_macro_ends(package):
    pytest.importorskip("xacro")
    path = package / "urdf" / "loop.xacro"
    path.write_text(
        '<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="a"><xacro:a/></xacro:macro>'
        "<xacro:a/></robot>"
    )
    with pytest.raises(InvalidRobot, match="cannot be expanded"):
        srs_ik.load(path)


@pytest.fixture
def expanded(monkeypatch):
    """The xacro files that are run."""
    xacro = pytest.importorskip("xacro")
    seen, process = [], xacro.process_file

    def watched(path, **options):
        seen.append(Path(path).name)
        return process(path, **options)

    monkeypatch.setattr(xacro, "process_file", watched)
    return seen


@pytest.mark.slow
def test_a_xacro_file_that_an_adapter_names_is_run_only_when_allowed(package, tmp_path, expanded):
    adapter = tmp_path / "robot.toml"
    source = package / "urdf" / "grown.urdf.xacro"
    write_adapter(adapter, source, srs_ik.load(source), {"reach": "0.5"})
    assert "a program: allow_xacro=True, --allow-xacro" in adapter.read_text()
    expanded.clear()
    for ask in (srs_ik.load, srs_ik.find_limbs):
        with pytest.raises(
            InvalidRobot, match=r"names the xacro file .*grown.urdf.xacro, which is a program: .*--allow-"
        ):
            ask(adapter)
    for command in (["inspect"], ["solve", "--from-q", *"0000000"], ["intervals", "--from-q", *"0000000"]):
        result = run(*command[:1], str(adapter), *command[1:])
        assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)
        assert "which is a program" in result.stderr
    assert expanded == []
    assert srs_ik.load(adapter, allow_xacro=True).limb.upper_arm == pytest.approx(0.5)
    assert run("inspect", str(adapter), "--allow-xacro").exit_code == 0
    assert set(expanded) == {source.name}


def test_a_xacro_file_of_another_name_is_never_run(package, expanded):
    for name in ("robot.urdf", "robot.xml", "robot.srdf", "robot"):
        path = package / name
        path.write_text(XACRO)
        for ask in (srs_ik.load, srs_ik.find_limbs):
            with pytest.raises(InvalidRobot, match="is a xacro file: give it a name that ends"):
                ask(path)
        with pytest.raises(InvalidRobot):
            srs_ik.load(ARM, srdf=path)
    with pytest.raises(InvalidRobot, match="is a xacro file"):
        srs_ik.load(XACRO)
    assert expanded == []


def test_a_xacro_file_that_the_user_names_is_run(package, tmp_path, expanded, monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(package.parent))
    assert srs_ik.load("package://small_description/urdf/grown.urdf.xacro").limb
    with pytest.raises(FrameNotFound):
        srs_ik.load("iiwa14", urdf=package / "urdf" / "grown.urdf.xacro")
    assert expanded == ["grown.urdf.xacro"] * 2


def test_a_xacro_file_behind_a_name_of_this_package_is_run(package, expanded, monkeypatch):
    clone = package.parent / "openarm_description"
    (clone / "urdf" / "robot").mkdir(parents=True)
    (clone / "urdf" / "robot" / "v10.urdf.xacro").write_text(XACRO)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(clone.parent))
    with pytest.raises(FrameNotFound):
        srs_ik.load("openarm_left")
    assert expanded == ["v10.urdf.xacro"]


# MoveIt

SRDF = """<?xml version="1.0"?>
<robot name="twins">
  <group name="left_arm"><chain base_link="left_l0" tip_link="left_l7"/></group>
  <group name="right_arm"><chain base_link="torso" tip_link="right_l7"/></group>
  <group name="fingers"><joint name="f1"/></group>
  <group_state name="home" group="left_arm"/>
</robot>"""


def twins() -> str:
    sides = [
        serial_arm(prefix=side) + joint_xml(side, "torso", f"{side}l0", "fixed", "") for side in ("left_", "right_")
    ]
    return f'<robot name="twins"><link name="torso"/>{"".join(sides)}</robot>'


def test_a_limb_of_which_a_joint_is_locked_is_not_looked_for_in_vain():
    with pytest.raises(NotAnSrsLimb, match="the arms end at right_l7; left_j3 cannot be of it, as locked"):
        srs_ik.load(twins(), limb="left", locked={"left_j3": 0.1})


def test_chains_of_an_srdf_choose_the_limb(tmp_path):
    path = tmp_path / "twins.srdf"
    path.write_text(SRDF)
    assert {name: group.ends for name, group in groups(path).items()} == {
        "left_arm": ("left_l0", "left_l7"),
        "right_arm": ("torso", "right_l7"),
    }
    arm = srs_ik.load(twins(), srdf=path, limb="right_arm")
    assert (arm.base, arm.tip) == ("torso", "right_l7")
    assert srs_ik.load(twins(), srdf=SRDF, limb="left_arm").base == "left_l0"
    for ends in ({"base": "torso"}, {"tip": "right_l7"}):
        with pytest.raises(InvalidRobot, match="it goes with neither base nor tip"):
            srs_ik.load(twins(), srdf=path, limb="right_arm", **ends)


@pytest.mark.parametrize(
    ("srdf", "limb", "says"),
    [
        (SRDF, None, "several groups, name one of them as the limb: left_arm, right_arm"),
        (SRDF, "lef_arm", r"no chain 'lef_arm' \(did you mean 'left_arm'"),
        ('<robot name="x"/>', None, "no group of one chain or of seven joints"),
        (
            SRDF.replace('</group>\n  <group name="right_arm">', ""),
            "left_arm",
            "no group of one chain or of seven joints; name base and tip",
        ),
        (SRDF.replace('base_link="left_l0" ', ""), None, "chain of group 'left_arm' lacks base_link or tip_link"),
        ("<robot", None, "not well-formed"),
        ("nowhere.srdf", None, "there is no file nowhere.srdf"),
    ],
)
def test_srdf_files_without_the_chain(srdf, limb, says):
    with pytest.raises(InvalidRobot, match=says):
        srs_ik.load(twins(), srdf=srdf, limb=limb)


def test_a_chain_of_an_srdf_that_the_robot_does_not_have():
    with pytest.raises(FrameNotFound, match="left_l8"):
        srs_ik.load(twins(), srdf=SRDF.replace("left_l7", "left_l8"), limb="left_arm")


def listed_group(kind: str, *names: str) -> str:
    parts = "".join(f'<{kind} name="{name}"/>' for name in names)
    return (
        f'<robot name="twins"><group name="fingers"><joint name="f1"/></group><group name="arm">{parts}</group></robot>'
    )


@pytest.mark.parametrize(
    ("kind", "names", "base"),
    [
        ("joint", [f"right_j{k}" for k in (3, 1, 2, 7, 5, 6, 4)], "right_l0"),
        ("link", [f"right_l{k}" for k in range(1, 8)], "right_l0"),
        ("joint", ["right_l0", *(f"right_j{k}" for k in range(1, 8))], "torso"),
    ],
)
def test_a_group_that_lists_joints_or_links(kind, names, base):
    # The joint that is fixed to the torso has the name of its link.
    arm = srs_ik.load(twins(), srdf=listed_group(kind, *names))
    assert (arm.base, arm.tip, arm.joint_names) == (base, "right_l7", tuple(f"right_j{k}" for k in range(1, 8)))


@pytest.mark.parametrize("odd", ["left_j1", "nobody"])
def test_a_group_that_lists_what_is_not_in_one_line(odd):
    with pytest.raises(InvalidRobot, match="what group 'arm' lists is not in one line"):
        srs_ik.load(twins(), srdf=listed_group("joint", *(f"right_j{k}" for k in range(1, 8)), odd))


def test_the_srdf_of_romeo_names_its_frames():
    path = example_urdf("romeo").parents[1] / "srdf" / "romeo_moveit.srdf"
    if not path.is_file():
        pytest.skip(f"{path.name} is not installed")
    assert isinstance(groups(path), dict)


# MuJoCo


def test_an_mjcf_file_is_read_with_what_it_includes(tmp_path):
    """As MuJoCo reads it: wherever includes stand, however often a section comes, and defaults after their use."""
    folder = tmp_path / "parts"
    folder.mkdir()
    inner = "".join(
        f'<body name="l{k}" pos="0 0 {height}"><joint name="j{k}" class="turning" axis="{axis}"/>'
        for k, (axis, height) in enumerate(
            zip(("0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1"), (0, 0.3, 0, 0.3, 0, 0.1), strict=True), 2
        )
    )
    wrap = "<mujocoinclude>{}</mujocoinclude>".format
    (folder / "arm.xml").write_text(wrap(inner + "</body>" * 6))
    (folder / "floor.xml").write_text('<mujoco><worldbody><geom type="plane" size="1 1 1"/></worldbody></mujoco>')
    (folder / "defaults.xml").write_text(
        wrap('<default><default class="turning"><joint range="-2 2" limited="true"/></default></default>')
    )
    scene = tmp_path / "scene.xml"
    scene.write_text(
        '<mujoco model="scene"><compiler angle="radian"/><include file="parts/floor.xml"/><worldbody>'
        '<body name="l1"><joint name="j1" class="turning" axis="0 0 1"/><include file="parts/arm.xml"/></body>'
        '</worldbody><include file="parts/defaults.xml"/></mujoco>'
    )
    arm, same = srs_ik.load(scene), srs_ik.load(ARM)
    assert arm.joint_names == same.joint_names
    np.testing.assert_allclose(arm.lower, same.lower)
    q = np.linspace(-0.5, 0.7, 7)
    tip = arm.forward_kinematics(q).homogeneous
    np.testing.assert_allclose(tip, same.forward_kinematics(q).homogeneous, atol=1e-14)
    assert set(tmp_path.iterdir()) == {folder, scene}
    (folder / "arm.xml").write_text(wrap("<a>" * 900 + "</a>" * 900))
    (folder / "floor.xml").write_text(wrap("<a>" * 900 + '<include file="parts/arms.xml"/>' + "</a>" * 900))
    (folder / "arms.xml").write_text(wrap("<a>" * 900 + "</a>" * 900))
    with pytest.raises(InvalidRobot, match="nested"):
        srs_ik.load(scene)


def test_an_mjcf_file_is_read(tmp_path):
    bodies, ends = "", ""
    for k, (axis, height) in enumerate(zip("zyzyzyz", (0, 0, 0.3, 0, 0.3, 0, 0.1), strict=True), 1):
        unit = {"z": "0 0 1", "y": "0 1 0"}[axis]
        bodies += (
            f'<body name="l{k}" pos="0 0 {height}"><joint name="j{k}" type="hinge" axis="{unit}" range="-2 2" '
            'limited="true"/><geom type="sphere" size="0.01" mass="1"/>'
        )
        ends += "</body>"
    path = tmp_path / "arm.xml"
    header = '<mujoco model="small"><compiler angle="radian"/><worldbody>'
    path.write_text(f"{header}{bodies}{ends}</worldbody></mujoco>")
    arm, same = srs_ik.load(path, tip="l7"), srs_ik.load(ARM)
    assert (arm.name, arm.joint_names) == ("small", same.joint_names)
    np.testing.assert_allclose(arm.upper, same.upper)
    q = np.linspace(-0.5, 0.7, 7)
    expected = same.forward_kinematics(q)
    np.testing.assert_allclose(arm.forward_kinematics(q).homogeneous, expected.homogeneous, atol=1e-14)
    assert arm.solve(expected)
    whole = path.read_text()
    wrong = {
        f"{header}{bodies}": "not well-formed XML",
        whole.replace("hinge", "hinges", 1): "type of joint 'j1' is 'hinges', not one of hinge, slide, ball, free$",
        "<mujoco><worldbody/></mujoco>": "without any <body>",
        whole.replace('pos="0 0 0.3"', 'pos="0 0 1e9"', 1): "'0 0 1e9', farther than 1e\\+06 m",
        whole.replace('range="-2 2"', 'range="3 2"', 1): "a lower limit above its upper limit",
        whole.replace("l7", "\ue000", 1): "cannot be printed",
        whole.replace("<worldbody>", "<worldbody>" + "<a>" * 1000): "nested more than 1000 deep",
        whole.replace('"l2"', '"universe"'): "something in it is called 'universe'",
        "<!DOCTYPE a>" + whole: "DOCTYPE",
        whole.replace(
            "</worldbody>", '<body><joint type="free"/></body>' * 33 + "</worldbody>"
        ): "more than the 200 deg",
        whole.replace("<worldbody>", '<include file="none.xml"/><worldbody>'): "includes '.*none.xml', which cannot be",
        whole.replace("<worldbody>", '<include file="arm.xml"/><worldbody>'): "includes the file 'arm.xml' twice, or",
        whole.replace("<worldbody>", '<include file="0.xml"/><worldbody>'): "includes more than 20 files",
    }
    for k in range(21):
        (tmp_path / f"{k}.xml").write_text(f'<mujoco><include file="{k + 1}.xml"/></mujoco>')
    for text, says in wrong.items():
        path.write_text(text)
        with pytest.raises(InvalidRobot, match=says) as raised:
            srs_ik.load(path)
        assert len(str(raised.value).splitlines()) == 1


# Which limb


@pytest.mark.parametrize(
    ("names", "side"),
    [
        (["openarm_left_joint1", "openarm_left_hand"], "left"),
        (["LShoulderPitch", "l_wrist"], "left"),
        (["RARM_SHOULDER_P", "r_wrist"], "right"),
        (["yumi_joint_1_r"], "right"),
        (["lbr_link_0", "lbr_link_ee", "roll_link"], "either"),
        (["left_foot", "right_foot"], "either"),
        (["base", "right_hand", "joint1", "joint2"], "either"),
        (["link_base", "left_finger", "left_drive", "joint1"], "either"),
        (["torso", "left_hand", "left_joint1"], "left"),
        ([], "either"),
    ],
)
def test_sides_are_read_from_names(names, side):
    assert side_of(names) == side


def test_a_single_arm_is_meant_by_the_side_that_one_of_its_names_says():
    arm = ARM.replace('"l7"', '"right_hand"')
    (report,) = srs_ik.find_limbs(arm)
    assert report.side == "either"
    assert srs_ik.load(arm, limb="right").tip == "right_hand"
    with pytest.raises(NotAnSrsLimb, match="no arm of 'small' has 'left' in its names"):
        srs_ik.load(arm, limb="left")


@pytest.mark.parametrize("name", at_hand(*EXAMPLES, "made_twins", "openarm_v10_bimanual", "unitree_h1_2_handless"))
def test_the_limb_of_a_side(name):
    path = robot_file(name)
    left, right = srs_ik.find_limbs(path)
    assert (left.side, right.side) == ("left", "right")
    assert srs_ik.load(path, limb="left").tip == left.tip
    assert srs_ik.load(path, limb="RIGHT").tip == right.tip
    assert srs_ik.load(path, limb=right.joint_names[3]).tip == right.tip
    with pytest.raises(NotAnSrsLimb, match=rf"no arm of .* has 'middle' in its names; the arms end at {left.tip}, "):
        srs_ik.load(path, limb="middle")


def test_of_more_than_seven_joints_those_of_the_limb_are_taken_and_the_others_said():
    longer = serial_arm().replace('<link name="l0"/>', "")
    first = '<link name="root"/><link name="l0"/>' + joint_xml("j0", "root", "l0")
    xml = f'<robot name="eight">{first}{longer}</robot>'
    arm = srs_ik.load(xml, base="root", tip="l7")
    assert arm.joint_names == tuple(f"j{k}" for k in range(1, 8))
    model = pin.buildModelFromXML(xml)
    assert model.nq == 8
    (report,) = srs_ik.find_limbs(xml)
    assert report.locked == ("j0",)
    assert report.describe().endswith("; carried by joints on which no pose depends: j0.")
