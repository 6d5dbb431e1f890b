"""MJCF files against MuJoCo itself, and by name what is refused."""

import os
import warnings

import numpy as np
import pinocchio as pin
import pytest
from robot_files import serial_arm

import srs_ik
from srs_ik import InvalidRobot
from srs_ik.robot.description import load_model
from srs_ik.system import bounds

mujoco = pytest.importorskip("mujoco")

from mjcf_variants import Maker, compared, write  # noqa: E402

ARM = f'<robot name="small">{serial_arm()}</robot>'
PLACES = list(zip("zyzyzyz", (0, 0, 0.3, 0, 0.3, 0, 0.1), strict=True))
AXES = {"y": "0 1 0", "z": "0 0 1"}


def arm(joint: str = 'range="-2 2"', body: str = "", before: str = "", after: str = "", angle: str = "radian") -> str:
    """The arm of `serial_arm`, with more attributes on each joint and body and more sections."""
    bodies = "".join(
        f'<body name="l{k}" pos="0 0 {height}" {body}><joint name="j{k}" axis="{AXES[axis]}" {joint}/>'
        '<geom size="0.01" mass="1"/>'
        for k, (axis, height) in enumerate(PLACES, 1)
    )
    world = f"<worldbody>{bodies}{'</body>' * 7}</worldbody>"
    return f'<mujoco model="small"><compiler angle="{angle}"/>{before}{world}{after}</mujoco>'


@pytest.mark.slow
def test_variants_agree_with_mujoco_or_are_refused(tmp_path):
    verdicts = []
    for seed in range(200):
        folder = tmp_path / str(seed)
        folder.mkdir()
        verdicts.append(compared(write(Maker(seed).whole(), folder), seed).partition(":")[0])
    assert verdicts.count("agrees") > 150
    assert verdicts.count("refused") < 8
    assert verdicts.count("refused by both") > 10


def test_a_file_read_wrongly_would_be_noticed(tmp_path, monkeypatch):
    """The comparison fails where Pinocchio's own reader of MJCF stands for this one."""
    import mjcf_variants

    from srs_ik.robot.description.model import RobotModel

    def theirs(path):
        model = pin.buildModelFromMJCF(str(path))
        return RobotModel(model, model.name, str(path))

    monkeypatch.setattr(mjcf_variants, "load_model", theirs)
    text = arm(body='euler="0.3 0.2 0.1"', before='<compiler eulerseq="XYZ"/>')
    with pytest.raises(AssertionError, match="misses by"):
        compared(write({"main.xml": text}, tmp_path), 0)


DIFFERENTLY = {
    "Euler angles about fixed axes": arm(body='euler="0.3 0.2 0.1"', before='<compiler eulerseq="XYZ"/>'),
    "mixed Euler angles": arm(body='euler="0.3 0.2 0.1"', before='<compiler eulerseq="xYz"/>'),
    "anchor of a default class": arm(before='<default><joint pos="0 0.03 0"/></default>'),
    "axis of any length": arm(body='axisangle="0 0 5 0.3"'),
    "limits that do not count": arm('range="-2 2" limited="false"'),
    "limits in degrees": arm('range="-100 100"', angle="degree"),
    "a reference": arm('range="-2 2" ref="0.4"'),
    "quaternion of any length": arm(body='quat="5 0.1 0.2 0.3"'),
    "crooked axes": arm(body='xyaxes="2 0.1 0 0.3 1 0.1"'),
}


@pytest.mark.parametrize("case", DIFFERENTLY)
def test_what_readers_get_wrong(case, tmp_path):
    assert compared(write({"main.xml": DIFFERENTLY[case]}, tmp_path), 0) == "agrees"
    limits = load_model(tmp_path / "main.xml").model.upperPositionLimit
    np.testing.assert_allclose(limits, np.inf if "do not" in case else np.deg2rad(100) if "degrees" in case else 2.0)


REFUSED = {
    arm(body='twist="1"'): "body 'l1' has the attribute 'twist', which is not understood",
    arm('spin="1"'): "joint 'j1' has the attribute 'spin', which is not understood",
    arm('limited="yes"'): "limited of joint 'j1' is 'yes', not one of true, false, auto",
    arm('range="2 -2"'): "joint 'j1' has the range 2 -2: a lower limit above its upper limit",
    arm('class="a"'): "joint 'j1' has the class 'a', which is not defined",
    arm(body='axisangle="0 0 0 1"'): "axisangle of body 'l1' has no direction",
    arm(body='quat="1 0 0 0" euler="1 0 0"'): "body 'l1' has an orientation by euler and by quat",
    arm(before='<compiler coordinate="global"/>'): "coordinate of <compiler> is 'global'",
    arm(before='<compiler eulerseq="abc"/>'): "eulerseq of <compiler> is 'abc'",
    arm(before='<compiler speed="1"/>'): "<compiler> has the attribute 'speed'",
    arm(before='<compiler autolimits="false"/>'): "joint 'j1' has a range but no limited",
    arm(after="<worldbody><attach prefix='a'/></worldbody>"): "body 'world' has a <attach>, which is not understood",
    arm(after="<worldbody><replicate count='2'><body/></replicate></worldbody>"): "has a <replicate>",
    arm(after="<equality><gear/></equality>"): "<gear> of <equality> is not understood",
    arm(after="<equality><joint joint1='j9'/></equality>"): "joint1 of <joint> of <equality> is 'j9', which is not",
    arm(after="<arms/>"): "<mujoco> has a <arms>, which is not understood",
}


@pytest.mark.parametrize("text", REFUSED, ids=REFUSED.values())
def test_what_is_not_understood_is_refused_by_name(text, tmp_path):
    path = write({"main.xml": text}, tmp_path)
    with pytest.raises(InvalidRobot) as raised:
        load_model(path)
    assert REFUSED[text] in str(raised.value)


@pytest.mark.parametrize(
    ("constraint", "tied"),
    [
        ('<joint joint1="j2" joint2="j4"/>', {"j2", "j4"}),
        ('<joint joint1="j2"/>', {"j2"}),
        ('<joint joint1="j2" active="false"/>', set()),
        ('<connect body1="l3" body2="l6" anchor="0 0 0"/>', {"j4", "j5", "j6"}),
        ('<weld body1="l2"/>', {"j1", "j2"}),
        ('<tendon tendon1="t"/>', {"j3", "j7"}),
    ],
)
def test_joints_that_are_tied_are_no_joints_of_a_limb(constraint, tied, tmp_path):
    tendon = '<tendon><fixed name="t"><joint joint="j3" coef="1"/><joint joint="j7" coef="1"/></fixed></tendon>'
    path = write({"main.xml": arm(after=f"{tendon}<equality>{constraint}</equality>")}, tmp_path)
    assert compared(path, 0) == "agrees"
    assert set(load_model(path).mimic_joints) == tied
    assert len(srs_ik.find_limbs(path)) == (not tied)


def test_a_joint_that_an_equality_ties_is_told_where_it_interrupts_the_arm(tmp_path):
    path = write({"main.xml": arm(after='<equality><joint joint1="j3"/></equality>')}, tmp_path)
    says = "the longest has 4: j4, j5, j6, j7; j3 before them is tied by an equality; other arms are for packages"
    with pytest.raises(srs_ik.NotAnSrsLimb, match=says):
        srs_ik.load(path)


def test_the_world_has_the_name_that_mujoco_gives_it(tmp_path):
    path = write({"main.xml": arm()}, tmp_path)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.qpos = [0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]
    mujoco.mj_kinematics(model, data)
    world = model.body(0).name
    found = srs_ik.load(path, base=world)
    assert found.base == srs_ik.load(path).base == srs_ik.find_limbs(path)[0].base == world
    assert found.forward_kinematics(data.qpos).translation == pytest.approx(data.body("l7").xpos, abs=1e-12)
    with pytest.raises(srs_ik.FrameNotFound) as caught:
        srs_ik.load(path, base="wrold")
    assert world in caught.value.available
    assert "did you mean 'world'" in str(caught.value)


def test_several_joints_of_one_body_are_a_shoulder(tmp_path):
    """As in models of people: three joints at one place, on one body."""
    shoulder = "".join(f'<joint name="j{k}" axis="{AXES[axis]}" range="-2 2"/>' for k, axis in enumerate("zyz", 1))
    rest = "".join(
        f'<body name="l{k}" pos="0 0 {height}"><joint name="j{k}" axis="{AXES[axis]}" range="-2 2"/>'
        for k, (axis, height) in enumerate([("y", 0.3), *PLACES[4:]], 4)
    )
    world = f'<worldbody><body name="upper">{shoulder}{rest}{"</body>" * 5}</worldbody>'
    path = write({"main.xml": f'<mujoco><compiler angle="radian"/>{world}</mujoco>'}, tmp_path)
    loaded, same = srs_ik.load(path), srs_ik.load(ARM)
    assert loaded.joint_names == same.joint_names
    q = np.linspace(-0.5, 0.7, 7)
    np.testing.assert_allclose(
        loaded.forward_kinematics(q).homogeneous, same.forward_kinematics(q).homogeneous, atol=1e-14
    )


def test_every_arm_of_a_scene_is_read(tmp_path):
    second = arm().partition("<worldbody>")[2].replace('"l', '"r').replace('"j', '"k')
    path = write({"main.xml": arm().replace("</worldbody></mujoco>", "") + second}, tmp_path)
    assert [report.tip for report in srs_ik.find_limbs(path)] == ["l7", "r7"]


def test_masses_that_depend_on_meshes_are_unknown(tmp_path):
    path = write({"main.xml": arm()}, tmp_path)
    assert srs_ik.load(path).model.inertias[3].mass == 1.0
    mesh = '<body><joint/><geom type="mesh" mesh="nowhere"/></body>'
    write({"main.xml": arm().replace("</worldbody>", f"{mesh}</worldbody>")}, tmp_path)
    assert [inertia.mass for inertia in load_model(path).model.inertias] == [0.0] * 9


# Bounds


def test_files_that_never_end_are_refused(tmp_path):
    """A pipe that nobody writes to, a circle of includes, and a file that includes itself under another name."""
    os.mkfifo(tmp_path / "fifo")
    (tmp_path / "again.xml").symlink_to(tmp_path / "main.xml")
    (tmp_path / "a.xml").write_text('<mujoco><include file="b.xml"/></mujoco>')
    (tmp_path / "b.xml").write_text('<mujoco><include file="a.xml"/></mujoco>')
    for name, says in {
        "fifo": "'fifo', which cannot be read: .* is not a regular file",
        "a.xml": "includes the file 'a.xml' twice, or in a circle",
        "again.xml": "includes the file 'again.xml' twice, or in a circle",
        "/dev/zero": "'/dev/zero', which cannot be read: .* is not a regular file",
        "": "an <include> names one file",
    }.items():
        path = write({"main.xml": arm(before=f'<include file="{name}"/>')}, tmp_path)
        with pytest.raises(InvalidRobot, match=says):
            load_model(path)


@pytest.mark.parametrize(
    ("inside", "says"),
    [
        ("<body/>" * 60_000, f"more than the {bounds.LINKS} bodies that are read"),
        ("<body>" * 501 + "</body>" * 501, f"a chain of more than {bounds.CHAIN} joints"),
        ("<body><joint/></body>" * 201, f"more than the {bounds.FREEDOM} degrees of freedom"),
        ("<geom/>" * 200_000, f"more than {bounds.XML_ELEMENTS} XML elements"),
        ('<body name="' + "a" * 1001 + '"/>', f"longer than {bounds.NAME}"),
        ('<body pos="0 0 2e6"/>', "pos of body 'body8' is '0 0 2e6', farther than 1e+06 m"),
        ('<body pos="0 0 9e5"/>' * 2 + '<body pos="0 0 9e5"><body pos="0 0 9e5"/></body>', "lies nowhere, or farther"),
    ],
)
def test_bounds(inside, says, tmp_path):
    path = write({"main.xml": arm().replace("</worldbody>", f"{inside}</worldbody>")}, tmp_path)
    with pytest.raises(InvalidRobot) as raised:
        load_model(path)
    assert says in str(raised.value)
    assert len(str(raised.value)) < 500


@pytest.mark.parametrize(
    "options",
    [
        "",
        '<option gravity="0.1 0 -3"/>',
        '<option gravity="0 0 -3"/><option timestep="0.01"/><option gravity="0 1 0"/>',
        '<option gravity="0 0 -3"><flag gravity="disable"/></option>',
    ],
)
def test_gravity_losses_and_rotors_are_those_of_mujoco(tmp_path, options):
    losses = 'range="-2 2" damping="0.3" frictionloss="0.2"'
    defaults = '<default><joint armature="0.05"/></default>'
    path = write({"main.xml": arm(losses, before=options + defaults)}, tmp_path)
    mine, theirs = srs_ik.load(path), mujoco.MjModel.from_xml_path(str(path))
    data, q = mujoco.MjData(theirs), np.array([0.3, 0.7, -0.4, 1.1, 0.5, 0.8, -0.2])
    data.qpos[:] = q
    mujoco.mj_forward(theirs, data)
    model = mine.model
    weight = pin.computeGeneralizedGravity(model, model.createData(), mine.configuration(q))
    np.testing.assert_allclose(weight, data.qfrc_bias, atol=1e-12)
    M = np.zeros((7, 7))
    mujoco.mj_fullM(theirs, data, M)
    np.testing.assert_allclose(
        np.triu(pin.crba(model, model.createData(), mine.configuration(q))), np.triu(M), atol=1e-12
    )
    np.testing.assert_allclose(model.damping, theirs.dof_damping)
    np.testing.assert_allclose(model.friction, theirs.dof_frictionloss)


def test_a_plant_of_an_mjcf_file_has_its_losses_and_rotors(tmp_path):
    pytest.importorskip("mujoco", "3.14")
    from srs_ik.sim import Plant

    path = write({"main.xml": arm('range="-2 2" damping="0.3" frictionloss="0.2" armature="0.05"')}, tmp_path)
    plant, theirs = Plant(srs_ik.load(path), armature=0.01), mujoco.MjModel.from_xml_path(str(path))
    np.testing.assert_allclose(plant.damping, theirs.dof_damping)
    np.testing.assert_allclose(plant.friction, theirs.dof_frictionloss)
    np.testing.assert_allclose(plant.model.dof_armature, theirs.dof_armature + 0.01)


@pytest.mark.parametrize(
    ("joint", "before", "said"),
    [
        ('range="-2 2" armature="-1"', "", "armature -1"),
        ('range="-2 2" damping="x"', "", "damping of joint 'j1'"),
        ('range="-2 2"', '<option gravity="0 0"/>', "gravity of <option>"),
        ('range="-2 2"', '<option><flag gravity="off"/></option>', "gravity that makes no sense"),
    ],
)
def test_losses_and_gravity_that_make_no_sense_are_refused(tmp_path, joint, before, said):
    with pytest.raises(InvalidRobot, match=said):
        srs_ik.load(write({"main.xml": arm(joint, before=before)}, tmp_path))


def random_actuators(rng: np.random.Generator) -> tuple[str, str]:
    """Default classes, and actuators of the joints of `arm`; those with a law of their own have a force limit."""

    def figures(forced: bool = False) -> str:
        def ends(name: str) -> str:
            return f' {name}range="{-rng.uniform(1.0, 9.0):.3f} {rng.uniform(1.0, 9.0):.3f}"'

        text = ends("force") if forced or rng.random() < 0.5 else ""
        text += ends("ctrl") if rng.random() < 0.5 else ""
        text += f' gear="{rng.uniform(-60.0, 60.0):.3f}{rng.choice(["", " 0 0 0 0 0"])}"' if rng.random() < 0.5 else ""
        return text + (f' ctrllimited="{rng.choice(["true", "false"])}"' if "ctrlrange" in text else "")

    kinds = ("general", "motor")
    inner = f'<default class="b"><{rng.choice(kinds)}{figures()}/></default>'
    classes = (
        f'<default><motor{figures()}/><default class="a"><{rng.choice(kinds)}{figures()}/>{inner}</default></default>'
    )
    actuators = ""
    for k in range(1, 8):
        for _ in range(int(rng.integers(0, 3))):
            kind = str(rng.choice((*kinds, "position")))
            law = figures(forced=True) + ' kp="100"' if kind == "position" else figures()
            of = str(rng.choice(["", ' class="a"', ' class="b"']))
            actuators += f'<{kind} joint="j{k}"{of}{law}/>'
    return classes, f"<actuator>{actuators}</actuator>"


@pytest.mark.parametrize("seed", range(12))
def test_effort_limits_are_what_actuators_reach(seed, tmp_path):
    rng = np.random.default_rng(seed)
    classes, actuators = random_actuators(rng)
    path = write({"main.xml": arm(before=classes, after=actuators)}, tmp_path)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    reached = []
    for sign in (1.0, -1.0):
        data.ctrl[:] = sign * np.sign(model.actuator_gear[:, 0]) * 1e9
        mujoco.mj_forward(model, data)
        reached.append(sign * data.qfrc_actuator)
    expected = np.min(reached, axis=0)
    unlimited = (expected > 1e6) | (expected == 0.0)
    np.testing.assert_allclose(srs_ik.load(path).effort_limit, np.where(unlimited, np.inf, expected), rtol=1e-9)


def test_the_lesser_of_joint_and_actuators_limits_the_effort(tmp_path):
    def efforts(joint: str, actuator: str) -> set[float]:
        actuators = "".join(f'<{actuator.split()[0]} joint="j{k}" {actuator.partition(" ")[2]}/>' for k in range(1, 8))
        text = arm(f'range="-2 2" {joint}', after=f"<actuator>{actuators}</actuator>")
        return set(srs_ik.load(write({"main.xml": text}, tmp_path)).effort_limit.tolist())

    assert efforts('actuatorfrcrange="-30 30"', 'motor gear="10" forcerange="-2 2"') == {20.0}
    assert efforts('actuatorfrcrange="-15 18"', 'motor gear="10" forcerange="-2 2"') == {15.0}
    assert efforts("", 'motor gear="-10" ctrlrange="-2 3"') == {20.0}
    assert efforts("", 'position kp="100" ctrlrange="-2 2" forcerange="-39 39"') == {39.0}
    assert efforts("", 'position kp="100" ctrlrange="-2 2"') == {np.inf}
    assert efforts("", 'general forcerange="-39 39" forcelimited="false"') == {np.inf}
    with pytest.raises(InvalidRobot, match="forcerange of <motor> '' is '1', not 2 numbers"):
        efforts("", 'motor forcerange="1"')
    motor, never = '<motor joint="j1" ctrlrange="-2 2"/>', '<compiler autolimits="false"/>'
    text = arm('limited="true" range="-2 2"', before=never, after=f"<actuator>{motor}</actuator>")
    with pytest.raises(InvalidRobot, match="has a ctrlrange but no ctrllimited"):
        load_model(write({"main.xml": text}, tmp_path))


@pytest.mark.parametrize("ref", [0.0, 0.2])
@pytest.mark.parametrize("coefficients", ['polycoef="0.3 0 0 0 0"', 'polycoef="-0.25"', 'polycoef=""', ""])
def test_a_joint_that_an_equality_holds_stands_there(coefficients, ref, tmp_path):
    """Under the base: MuJoCo's own constraint, at the position where nothing is left of it, tells where."""
    slide = f'<joint name="slide" type="slide" axis="1 0 0" range="-1 1" ref="{ref}"/><geom size="0.01" mass="1"/>'
    text = arm(after=f'<equality><joint joint1="slide" {coefficients}/></equality>')
    text = text.replace("<worldbody>", f'<worldbody><body name="b0" pos="1 0 0">{slide}', 1)
    path = write({"main.xml": text.replace("</worldbody>", "</body></worldbody>")}, tmp_path)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    q = np.array([0.3, 0.4, -0.2, 1.0, 0.5, -0.6, 0.7])
    held = ref + model.eq_data[0, 0]
    data.qpos[:] = [held, *q]
    mujoco.mj_forward(model, data)
    assert abs(data.efc_pos[: data.ne]).max() < 1e-12
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        limb = srs_ik.load(path, base="world", tip="l7")
    np.testing.assert_allclose(limb.forward_kinematics(q).translation, data.body("l7").xpos, atol=1e-12)
    np.testing.assert_allclose(limb.forward_kinematics(q).rotation.ravel(), data.body("l7").xmat, atol=1e-12)
    assert limb.locked == ({} if held == 0.0 else {"slide": pytest.approx(held)})
    with pytest.raises(InvalidRobot, match=r"'slide' is held at .* by the file, and cannot be locked at 0.9"):
        srs_ik.load(path, base="world", tip="l7", locked={"slide": 0.9})
