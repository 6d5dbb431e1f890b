import math
import os
import re
import threading

import chains
import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from hypothesis import example, given, settings
from hypothesis import strategies as st
from robot_files import REAL, at_hand, joint_xml, random_configuration, robot_file, robot_xml

from srs_ik.errors import InvalidRobot
from srs_ik.robot import zoo
from srs_ik.robot.description import load_model
from srs_ik.robot.description.from_yourdfpy import roll_pitch_yaw
from srs_ik.system import bounds

FILES = at_hand(*chains.MAKERS, *REAL)
AXIS, LIMIT = '<axis xyz="0 0 1"/>', '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def two_joints(inside: str, kind: str = "revolute") -> str:
    return robot_xml(joint_xml("first", "a", "b", kind, inside), joint_xml("second", "b", "c"))


def weighing(mass: float, ixx: float = 1.0) -> str:
    """A link d with a mass and a matrix of inertia."""
    figures = f'ixx="{ixx!r}" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"'
    return f'<link name="d"><inertial><mass value="{mass!r}"/><inertia {figures}/></inertial></link>'


# Reading what is right


@pytest.mark.parametrize("name", FILES)
def test_files_give_the_model_that_pinocchio_makes_of_the_untouched_file(name, capfd):
    path = robot_file(name)
    ours = load_model(path).model
    assert capfd.readouterr() == ("", "")
    theirs = pin.buildModelFromUrdf(str(path))
    assert list(ours.names) == list(theirs.names)
    assert [(f.name, f.type, f.parentJoint) for f in ours.frames] == [
        (f.name, f.type, f.parentJoint) for f in theirs.frames
    ]
    for a, b in zip(ours.frames, theirs.frames, strict=True):
        np.testing.assert_array_equal(a.placement.homogeneous, b.placement.homogeneous)
    for a, b in zip(ours.inertias, theirs.inertias, strict=True):
        np.testing.assert_array_equal(a.matrix(), b.matrix())
    for limit in ("lowerPositionLimit", "upperPositionLimit", "velocityLimit", "effortLimit"):
        np.testing.assert_array_equal(getattr(ours, limit), getattr(theirs, limit))


@pytest.mark.parametrize("name", FILES)
def test_a_yourdfpy_robot_loses_no_digit(name):
    path = robot_file(name)
    urdf = yourdfpy.URDF.load(str(path), build_scene_graph=False, load_meshes=False)
    ours, theirs = load_model(urdf).model, load_model(path).model
    rng = np.random.default_rng(1)
    q = random_configuration(theirs, rng)
    placements = []
    for model in (ours, theirs):
        data = model.createData()
        pin.framesForwardKinematics(model, data, q)
        placements.append({(f.name, f.type): data.oMf[k].homogeneous for k, f in enumerate(model.frames)})
    assert placements[0].keys() == placements[1].keys()
    for key, T in placements[1].items():
        np.testing.assert_allclose(placements[0][key], T, rtol=0, atol=2e-14, err_msg=str(key))
    for limit in ("lowerPositionLimit", "upperPositionLimit", "velocityLimit", "effortLimit"):
        np.testing.assert_array_equal(getattr(ours, limit), getattr(theirs, limit))


@given(
    st.floats(-4, 4),
    st.one_of(st.floats(-4, 4), st.floats(-1e-7, 1e-7).map(lambda d: np.pi / 2 + d)),
    st.floats(-4, 4),
)
@example(0.3, np.pi / 2, -0.2)
@example(0.3, -np.pi / 2, -0.2)
@example(0.0, np.pi, 0.0)
@settings(deadline=None)
def test_angles_rebuild_the_rotation_at_every_pitch(roll, pitch, yaw):
    R = pin.rpy.rpyToMatrix(roll, pitch, yaw)
    np.testing.assert_allclose(pin.rpy.rpyToMatrix(*roll_pitch_yaw(R)), R, rtol=0, atol=2e-15)


def test_text_and_file_give_the_same_robot_and_the_file_stays_as_it_is(tmp_path):
    text = two_joints(AXIS + LIMIT)
    path = tmp_path / "small.urdf"
    path.write_text(text)
    before = path.read_bytes()
    from_file, from_str, from_text = load_model(path), load_model(str(path)), load_model("\ufeff\n  " + text)
    assert from_file.model == from_str.model == from_text.model
    assert (from_file.name, from_file.source, from_text.source) == ("small", str(path), "the URDF text")
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["small.urdf"]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "iso-8859-1"])
def test_files_in_any_declared_encoding(tmp_path, encoding):
    path = tmp_path / "arm.urdf"
    text = f'<?xml version="1.0" encoding="{encoding}"?>\n' + robot_xml(links="größe", name="é")
    path.write_bytes(text.encode(encoding))
    robot = load_model(path)
    assert robot.name == "é"
    assert "größe" in [frame.name for frame in robot.model.frames]


def test_a_pinocchio_model_is_passed_on_untouched():
    model = pin.buildSampleModelManipulator()
    copy = model.copy()
    assert load_model(model).model is model
    assert model == copy


def test_what_is_not_motion_or_mass_may_be_faulty():
    nonsense = (
        '<material name="m"><color rgba="no numbers"/></material><link name="x:y"><visual><geometry>'
        '<mesh filename="package://nowhere/none.dae" scale="1"/></geometry><material/></visual>'
        "<collision><geometry/></collision></link><transmission><joint name='q'/></transmission>"
        "<gazebo><sensor:camera><xacro:thing/></sensor:camera></gazebo>"
    )
    xml = robot_xml(
        nonsense, joint_xml("j", "a", "x:y", inside=AXIS + LIMIT + '<safety_controller k_velocity="x"/>'), links="a"
    )
    assert list(load_model(xml).model.names) == ["universe", "j"]


@pytest.mark.parametrize("inside", ['effort="-1" velocity="-1"', 'effort="0" velocity="0"', ""])
def test_effort_and_velocity_that_are_not_given_become_zero(inside):
    model = load_model(two_joints(f'{AXIS}<limit lower="-1" upper="1" {inside}/>')).model
    assert (model.effortLimit[0], model.velocityLimit[0]) == (0.0, 0.0)


def test_a_robot_without_a_name_is_called_robot():
    assert load_model("<robot><link name='a'/></robot>").name == "robot"


def test_limits_that_are_left_out_are_zero_as_the_format_says():
    model = load_model(two_joints(AXIS + '<limit upper="1" effort="1" velocity="1"/>')).model
    assert (model.lowerPositionLimit[0], model.upperPositionLimit[0]) == (0.0, 1.0)


def test_a_joint_without_an_axis_turns_about_x():
    model = load_model(two_joints(LIMIT)).model
    assert model.joints[1].shortname() == "JointModelRX"


def test_a_continuous_joint_needs_no_limit_and_its_range_does_not_count():
    for inside in (AXIS, AXIS + '<limit lower="1" upper="-1" effort="2" velocity="3"/>'):
        model = load_model(two_joints(inside, "continuous")).model
        assert (model.nq, model.nv) == (3, 2)


def test_a_fixed_joint_may_have_an_axis_without_direction_and_no_limit():
    assert load_model(two_joints('<axis xyz="0 0 0"/>', "fixed")).model.nv == 1


def test_mimicking_joints_are_named():
    inside = AXIS + LIMIT + '<mimic joint="second" multiplier="-1"/>'
    assert load_model(two_joints(inside)).mimic_joints == {"first": "mimics second"}
    assert load_model(two_joints(inside, "fixed")).mimic_joints == {}


def test_an_inertia_without_mass_or_matrix_is_none():
    xml = robot_xml('<link name="d"><inertial><mass value="2"/></inertial></link>', joint_xml("j", "a", "d"), links="a")
    assert load_model(xml).model.inertias[1].mass == 0.0


def test_quaternions_of_newer_files_count():
    quaternion = '<origin xyz="0 0 0" quat_xyzw="0 0 0.70710678118654752 0.70710678118654752"/>'
    xml = two_joints(quaternion + AXIS + LIMIT).replace('name="small"', 'name="small" version="1.1"')
    placement = load_model(xml).model.jointPlacements[1]
    np.testing.assert_allclose(placement.rotation, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)


# Refusing what is wrong

WRONG_TEXT = {
    "not well-formed": ("<robot name='x'><link name='a'></robot>", "not well-formed XML: mismatched tag: line 1"),
    "cut off": ("<robot name='x'><link name='a'/>", "not well-formed"),
    "another format": ("<mujoco/>", "outermost element is <mujoco>, not <robot>"),
    "xacro": ("<robot name='x'><xacro:include filename='y'/></robot>", "xacro file: give it a name"),
    "entities": ('<!DOCTYPE r [<!ENTITY a "b">]><robot name="&a;"><link name="l"/></robot>', "<!DOCTYPE>"),
    "surrogate": ("<robot name='\ud800'/>", "not well-formed"),
    "no link": ("<robot name='x'/>", "no <link>"),
    "nameless link": ("<robot name='x'><link/></robot>", "<link> number 1 has no name"),
    "line break": ("<robot name='x'><link name='a&#10;b'/></robot>", "cannot be printed"),
    "two links of a name": (robot_xml(links="a a"), "link name 'a' is used twice"),
    "two joints of a name": (
        robot_xml(joint_xml("j", "a", "b"), joint_xml("j", "b", "c")),
        "joint name 'j' is used twice",
    ),
    "two roots": (robot_xml(joint_xml("j", "a", "b")), "2 links without a parent joint, not one: 'a', 'c'"),
    "two parents": (
        robot_xml(joint_xml("j", "a", "c"), joint_xml("k", "b", "c"), joint_xml("l", "a", "b")),
        "'c' is the child of two joints, 'j' and 'k'",
    ),
    "loop": (robot_xml(joint_xml("j", "b", "c"), joint_xml("k", "c", "b")), "closed loop at the link 'b'"),
    "loop on itself": (robot_xml(joint_xml("j", "b", "b"), links="a b"), "closed loop"),
    "only a loop": (robot_xml(joint_xml("j", "a", "b"), joint_xml("k", "b", "a"), links="a b"), "closed loop"),
    "unknown child": (
        robot_xml(joint_xml("j", "link_a", "link_bb"), links="link_a link_b"),
        "(did you mean 'link_b' or",
    ),
    "unknown parent": (robot_xml(joint_xml("j", "zz", "a"), links="a"), "parent 'zz' of joint 'j' is no link"),
    "no parent": (
        "<robot name='x'><link name='a'/><joint name='j' type='fixed'><child link='a'/></joint></robot>",
        "no parent",
    ),
    "no type": (robot_xml(joint_xml("j", "a", "b"), links="a b").replace('type="revolute"', ""), "'j' has no type"),
    "unknown type": (two_joints(AXIS + LIMIT, "ball"), "unknown type 'ball'"),
    "no limit": (two_joints(AXIS), "joint 'first' is revolute but has no <limit>"),
    "reversed": (
        two_joints(AXIS + '<limit lower="1" upper="-1" effort="1" velocity="1"/>'),
        "lower limit 1.0 above its upper",
    ),
    "limits out of reach": (
        two_joints(AXIS + '<limit lower="1e9" upper="1e10" effort="1" velocity="1"/>'),
        "limits 1000000000.0 and 10000000000.0, which are out of any reach",
    ),
    "no direction": (two_joints('<axis xyz="0 0 0"/>' + LIMIT), "no direction"),
    "NaN": (
        two_joints('<origin xyz="0 nan 0"/>' + AXIS + LIMIT),
        "<origin> xyz of joint 'first' is 'nan', not a finite",
    ),
    "infinite": (
        two_joints(AXIS + '<limit lower="-inf" upper="1" effort="1" velocity="1"/>'),
        "lower of joint 'first' is '-inf'",
    ),
    "overflow": (two_joints('<origin rpy="0 1e999 0"/>' + AXIS + LIMIT), "'1e999', not a finite"),
    "two numbers": (two_joints('<axis xyz="0 1"/>' + LIMIT), "'0 1', not 3 numbers"),
    "decimal comma": (two_joints('<axis xyz="0 0,5 1"/>' + LIMIT), "'0,5', not a finite number"),
    "formula": (two_joints('<axis xyz="0 0 ${pi}"/>' + LIMIT), "'${pi}', not a finite number"),
    "underscore": (two_joints('<axis xyz="0 0 1_0"/>' + LIMIT), "'1_0', not"),
    "NaN mass": (
        robot_xml(weighing(math.nan), links=""),
        "mass> value of inertia of link 'd' is 'nan'",
    ),
    "negative mass": (robot_xml(weighing(-0.1), links=""), "the mass of link 'd' is -0.1; a mass is between 0 and"),
    "mass beyond sums": (robot_xml(weighing(1e308), links=""), "the mass of link 'd' is 1e+308; a mass is"),
    "inertia beyond sums": (
        robot_xml(weighing(1.0, ixx=-1e200), links=""),
        "ixx of the inertia of link 'd' is -1e+200",
    ),
    "joint of Pinocchio": (two_joints(AXIS + LIMIT).replace('"first"', '"universe"'), "Pinocchio's name of the world"),
    "too many links": (robot_xml(links=" ".join(f"l{k}" for k in range(2001))), "2001 links"),
    "too many elements": ("<robot name='x'>" + "<a/>" * 200_000 + "</robot>", "more than 200000 XML elements"),
    "too deep in tags": ("<robot name='x'>" + "<a>" * 1000, "nested more than 1000 deep"),
    "too much freedom": (
        robot_xml(
            *(joint_xml(f"j{k}", "l0", f"l{k + 1}") for k in range(201)), links=" ".join(f"l{k}" for k in range(202))
        ),
        "201 degrees of freedom",
    ),
    "much freedom a joint": (
        robot_xml(
            *(joint_xml(f"j{k}", "l0", f"l{k + 1}", "floating") for k in range(34)),
            links=" ".join(f"l{k}" for k in range(35)),
        ),
        "204 degrees of freedom",
    ),
    "long name": (robot_xml(links="a" * 1001), "a name of 1001 characters"),
    "endless figure": (two_joints(f'<axis xyz="0 0 {"1" * 300_000}x"/>' + LIMIT), "...', not a finite number"),
    "far away": (two_joints('<origin xyz="0 0 2e6"/>' + AXIS + LIMIT), "'0.0 0.0 2000000.0', farther than 1e+06 m"),
    "no quaternion": (
        two_joints('<origin quat_xyzw="0 0 0 0"/>' + AXIS + LIMIT),
        "quat_xyzw of joint 'first' is '0.0 0.0 0.0 0.0', no rotation",
    ),
    "too deep": (
        robot_xml(
            *(joint_xml(f"j{k}", f"l{k}", f"l{k + 1}", "fixed", "") for k in range(600)),
            links=" ".join(f"l{k}" for k in range(601)),
        ),
        "more than 500 joints",
    ),
    "long value": (two_joints(f'<axis xyz="{"9" * 1000}"/>' + LIMIT), "..."),
}


@pytest.mark.parametrize("case", WRONG_TEXT)
def test_wrong_text_is_refused_in_one_clear_line(case, capfd):
    text, says = WRONG_TEXT[case]
    with pytest.raises(InvalidRobot, match=re.escape(says)) as raised:
        load_model(text)
    assert "\n" not in str(raised.value)
    assert len(str(raised.value)) < 400
    assert raised.value.source == "the URDF text"
    assert capfd.readouterr() == ("", "")


def test_no_chain_that_is_accepted_overflows_the_stack_of_a_thread():
    n, moving = 500, 200
    inside = AXIS + LIMIT
    kinds = ["revolute"] * moving + ["fixed"] * (n - moving)
    joints = (joint_xml(f"j{k}", f"l{k}", f"l{k + 1}", kind, inside) for k, kind in enumerate(kinds))
    xml = robot_xml(*joints, links=" ".join(f"l{k}" for k in range(n + 1)))
    results = []
    thread = threading.Thread(target=lambda: results.append(load_model(xml).model.nv))
    thread.start()
    thread.join()
    assert results == [moving]


def test_wrong_files_are_refused_and_named(tmp_path):
    empty = tmp_path / "empty.urdf"
    empty.write_text(" \n")
    binary = tmp_path / "binary.urdf"
    binary.write_bytes(bytes(range(256)))
    huge = tmp_path / "huge.urdf"
    with huge.open("wb") as file:
        file.write(b"<robot>")
        file.truncate(bounds.XML_BYTES + 10)
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    cases = {
        tmp_path / "none.urdf": "there is no file",
        tmp_path: "is a directory",
        empty: "is empty",
        binary: "not well-formed",
        huge: "larger than 8 MiB",
        fifo: "not a regular file",
        empty / "below.urdf": "cannot be read|there is no file",
        tmp_path / ("x" * 5000): "cannot be read|there is no file",
        tmp_path / "nul\0.urdf": "cannot be read|there is no file",
    }
    for path, says in cases.items():
        with pytest.raises(InvalidRobot, match=says) as raised:
            load_model(path)
        assert str(tmp_path) in str(raised.value)
        assert "\n" not in str(raised.value)
        assert len(str(raised.value)) < 500


@pytest.mark.parametrize("source", [7, None, b"<robot/>", ["arm.urdf"], object()])
def test_other_objects_are_refused_by_their_type(source):
    with pytest.raises(InvalidRobot, match=f"object of type {type(source).__name__}"):
        load_model(source)


def test_a_yourdfpy_robot_is_checked_like_a_file():
    joint = yourdfpy.Joint(name="j", type="revolute", parent="a", child="b", axis=np.array([0, 0, 1.0]))
    robot = yourdfpy.Robot(name="r", links=[yourdfpy.Link(name="a"), yourdfpy.Link(name="b")], joints=[joint])
    urdf = yourdfpy.URDF(robot, build_scene_graph=False, load_meshes=False)
    with pytest.raises(InvalidRobot, match=r"the yourdfpy.URDF 'r': joint 'j' is revolute but has no <limit>"):
        load_model(urdf)
    joint.limit = yourdfpy.Limit(effort=-1.0, velocity=None, lower=-0.1, upper=0.7)
    model = load_model(urdf).model
    assert (model.lowerPositionLimit[0], model.upperPositionLimit[0]) == (-0.1, 0.7)
    assert (model.effortLimit[0], model.velocityLimit[0]) == (0.0, 0.0)
    joint.origin = np.diag([1.0, 1.0, -1.0, 1.0])
    with pytest.raises(InvalidRobot, match="joint 'j' has an origin that is no rigid transform"):
        load_model(urdf)


# Standard error


def test_what_the_parser_prints_is_in_the_error_and_nowhere_else(monkeypatch, capfd):
    def build(text):
        os.write(2, b"Warning: nothing to worry about\nError:   the thing that is wrong\n   at line 7 in joint.cpp\n")
        raise ValueError("The XML stream does not contain a valid URDF model.")

    monkeypatch.setattr(pin, "buildModelFromXML", build)
    with pytest.raises(InvalidRobot, match=r"^the URDF text: the thing that is wrong$"):
        load_model(robot_xml(links="a"))
    os.write(2, b"afterwards\n")
    assert capfd.readouterr().err == "afterwards\n"


def test_loading_works_where_standard_error_is_closed():
    saved = os.dup(2)
    try:
        os.close(2)
        assert load_model(robot_xml(links="a")).name == "small"
    finally:
        os.dup2(saved, 2)
        os.close(saved)


def test_threads_load_at_once_and_leave_standard_error_as_it_was(capfd):
    names = []
    threads = [
        threading.Thread(target=lambda k=k: names.append(load_model(robot_xml(links="a", name=f"r{k}")).name))
        for k in range(16)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(names) == sorted(f"r{k}" for k in range(16))
    os.write(2, b"still here")
    assert capfd.readouterr().err == "still here"


# Anything at all


@pytest.mark.slow
@given(st.data())
@settings(max_examples=300, deadline=None)
def test_damaged_files_load_or_are_refused_but_never_anything_else(data):
    text = zoo.card("iiwa14").urdf.read_text()
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(text) - 1))
        end = min(len(text), start + data.draw(st.integers(0, 40)))
        put = data.draw(
            st.one_of(
                st.just(""), st.text(max_size=8), st.sampled_from(["nan", '"', "<", "-", "1e400", text[start:end] * 2])
            )
        )
        text = text[:start] + put + text[end:]
    if not text.lstrip("\ufeff \t\r\n").startswith("<"):
        text = "<" + text
    try:
        robot = load_model(text)
    except InvalidRobot as error:
        complaint = str(error)
    else:
        complaint = ""
        assert np.isfinite(robot.model.lowerPositionLimit).all()
        assert all(np.isfinite(placement.homogeneous).all() for placement in robot.model.jointPlacements)
    assert len(complaint.splitlines()) <= 1


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), max_size=7))
@settings(deadline=None)
def test_exactly_trees_are_accepted(edges):
    xml = robot_xml(
        *(joint_xml(f"j{k}", f"l{a}", f"l{b}") for k, (a, b) in enumerate(edges)),
        links=" ".join(f"l{k}" for k in range(6)),
    )
    reached, grew = {next(iter({*range(6)} - {b for _, b in edges}), None)}, True
    while grew:
        grew = False
        for a, b in edges:
            if a in reached and b not in reached:
                reached.add(b)
                grew = True
    is_tree = len(edges) == 5 and reached == {*range(6)}
    if is_tree:
        assert load_model(xml).model.nv == 5
    else:
        with pytest.raises(InvalidRobot):
            load_model(xml)
