"""Adapters: what `srs-ik inspect --write` writes, `load` takes."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from arms import FROM_FILES, configurations, file_of, load
from command_line import answer, run
from robot_files import joint_xml, serial_arm

import srs_ik
from srs_ik.errors import InvalidRobot
from srs_ik.loading.adapter import hand_axes, write_adapter


@pytest.fixture
def arm_file(tmp_path):
    path = tmp_path / "models" / "arm.urdf"
    path.parent.mkdir()
    path.write_text(f'<robot name="my arm">{serial_arm()}</robot>')
    return path


@pytest.mark.parametrize("name", FROM_FILES)
def test_the_adapter_of_an_arm_loads_as_the_arm(name, tmp_path):
    plain, path = load(name), tmp_path / "robot.toml"
    write_adapter(path, file_of(name), plain)
    arm = srs_ik.load(path)
    assert (arm.name, arm.base, arm.tip, arm.joint_names) == (plain.name, plain.base, plain.tip, plain.joint_names)
    np.testing.assert_allclose(arm.limb.reference, plain.limb.reference, atol=1e-11)
    np.testing.assert_array_equal([arm.lower, arm.upper], [plain.lower, plain.upper])
    for q in configurations(name, 3):
        pose = plain.forward_kinematics(q)
        np.testing.assert_array_equal(arm.forward_kinematics(q).homogeneous, pose.homogeneous)
        assert arm.solve(pose, arm_angle=arm.arm_angle(q), branch=arm.branch(q))
    side = tomllib.loads(path.read_text())["side"]
    assert side == next((side for side in ("left", "right") if name.endswith(side)), "either")


@pytest.mark.parametrize("name", FROM_FILES)
def test_the_hand_reaches_out_and_its_axes_are_orthogonal(name):
    limb = load(name).limb
    grasp, across = hand_axes(limb)
    assert np.allclose([grasp @ grasp, across @ across, grasp @ across], [1, 1, 0], atol=1e-14)
    if limb.hand > 2e-3:
        out = limb.T_base_tip_zero[:3, 3] - limb.wrist
        np.testing.assert_allclose(limb.T_base_tip_zero[:3, :3] @ grasp * limb.hand, out, atol=1e-9)


def test_limits_tool_and_mount_of_an_adapter(arm_file, tmp_path):
    adapter = tmp_path / "robot.toml"
    write_adapter(adapter, arm_file, srs_ik.load(arm_file))
    assert 'urdf = "models/arm.urdf"' in adapter.read_text()
    plain = srs_ik.load(adapter)
    text = adapter.read_text()
    for line in ("[tool]", "xyz = [0.0, 0.0, 0.1]", "rpy = [0.0, 0.0, 0.0]", "[limits]", '"j3" ='):
        assert f"# {line}" in text
        text = text.replace(f"# {line}", line, 1)
    adapter.write_text(text.replace('"j3" = { lower = -2.0', '"j3" = { lower = -1.5') + "[mount]\nxyz = [1, 2, 3]\n")
    arm = srs_ik.load(adapter)
    assert (arm.base, arm.tip, arm.lower[2], arm.upper[2]) == ("world", "tool", -1.5, 2.0)
    expected = np.array([1, 2, 3]) + plain.forward_kinematics(np.zeros(7)).translation + [0, 0, 0.1]
    np.testing.assert_allclose(arm.forward_kinematics(np.zeros(7)).translation, expected, atol=1e-14)


def test_an_adapter_of_an_adapter_keeps_its_side_limits_and_arguments(arm_file, tmp_path):
    adapter, again = tmp_path / "robot.toml", tmp_path / "again.toml"
    write_adapter(adapter, arm_file, srs_ik.load(arm_file))
    said = adapter.read_text().replace('side = "either"', 'side = "right"')
    adapter.write_text(f"{said}[limits]\nj3 = {{ lower = -1.5, acceleration = 4.0 }}\n[xacro]\ndof = '7'\n")
    plain = srs_ik.load(adapter)
    write_adapter(again, adapter, plain, {"hand": "no"})
    arm, told = srs_ik.load(again), tomllib.loads(again.read_text())
    np.testing.assert_array_equal([arm.lower, arm.upper], [plain.lower, plain.upper])
    np.testing.assert_array_equal(arm.acceleration_limit, plain.acceleration_limit)
    assert arm.lower[2] == -1.5
    assert (told["side"], told["xacro"], list(told["limits"])) == ("right", {"dof": "7", "hand": "no"}, ["j3"])


def test_no_adapter_is_written_of_one_whose_tool_or_mount_it_would_lose(arm_file, tmp_path):
    adapter, again = tmp_path / "robot.toml", tmp_path / "again.toml"
    write_adapter(adapter, arm_file, srs_ik.load(arm_file))
    adapter.write_text(adapter.read_text() + "[tool]\nxyz = [0.0, 0.0, 0.1]\n[mount]\nxyz = [1, 2, 3]\n")
    found = run("inspect", str(adapter), "--write", str(again))
    assert (found.exit_code, again.exists()) == (2, False)
    assert found.stderr == f"srs-ik: {adapter} is an adapter with [tool], [mount]: copy it, and change the copy\n"


def test_frames_of_an_adapter_are_numbered_where_the_robot_has_their_names(tmp_path):
    """Many descriptions begin with a link "world", such as Kinova's of the Gen3."""
    ends = joint_xml("stand", "world", "l0", "fixed") + joint_xml("flange", "l7", "tool", "fixed")
    path, adapter = tmp_path / "arm.urdf", tmp_path / "robot.toml"
    path.write_text(f'<robot name="my arm">{serial_arm()}<link name="world"/><link name="tool"/>{ends}</robot>')
    write_adapter(adapter, path, srs_ik.load(path))
    text = adapter.read_text() + "[mount]\nxyz = [1, 2, 3]\n[tool]\nxyz = [0, 0, 0.1]\n"
    adapter.write_text(text)
    arm = srs_ik.load(adapter)
    assert (arm.base, arm.tip) == ("world_2", "tool_2")
    adapter.write_text(text + 'name = "world"\n')
    with pytest.raises(InvalidRobot, match=r"has a frame 'world' already; .* in an adapter name of \[tool"):
        srs_ik.load(adapter)
    assert '# name = "table"' in text


def test_gravity_of_the_room_an_arm_is_mounted_in(arm_file, tmp_path):
    adapter = tmp_path / "robot.toml"
    write_adapter(adapter, arm_file, srs_ik.load(arm_file))
    text = adapter.read_text()
    for line in ("[mount]", "gravity = [0.0, 0.0, -9.81]"):
        assert f"# {line}" in text
        text = text.replace(f"# {line}", line, 1)
    adapter.write_text(text.replace("[mount]\n", "[mount]\nrpy = [2.5, 0.0, 0.0]\n", 1))
    arm = srs_ik.load(adapter)
    assert arm.base == "world"
    room = arm.model.frames[arm.model.getFrameId("world")].placement.rotation
    np.testing.assert_allclose(room.T @ arm.model.gravity.linear, [0.0, 0.0, -9.81], atol=1e-12)
    assert np.abs(arm.model.gravity.linear - srs_ik.load(arm_file).model.gravity.linear).max() > 1.0


def test_the_commands_take_what_inspect_writes(arm_file, tmp_path):
    adapter = tmp_path / "robot.toml"
    result = run("inspect", str(arm_file), "--write", str(adapter))
    assert result.exit_code == 0
    assert result.stderr == f"srs-ik: wrote {adapter}; check it, then try 'srs-ik inspect {adapter}'\n"
    (limb,) = answer("inspect", str(adapter))["limbs"]
    assert (limb["base"], limb["tip"]) == ("l0", "l7")
    solved = answer("solve", str(adapter), "--q", *["0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7"])
    assert solved["robot"] == "my arm"


def test_names_and_addresses_stay_what_they_are(tmp_path):
    write_adapter(tmp_path / "a.toml", "human_left", srs_ik.load("human_left"))
    card = tomllib.loads((tmp_path / "a.toml").read_text())
    assert card["urdf"] == "example-robot-data://human_description/robots/human.urdf"
    assert card["hand"]["grasp"] == [0.0, -1.0, 0.0]


@pytest.mark.parametrize(
    ("name", "says"),
    [("robot.urdf", "name ends in .toml"), ("there.toml", "exists already"), ("no/where.toml", "cannot write")],
)
def test_where_no_adapter_is_written(arm_file, tmp_path, name, says):
    (tmp_path / "there.toml").write_text("")
    with pytest.raises(InvalidRobot, match=says):
        write_adapter(tmp_path / name, arm_file, srs_ik.load(arm_file))
    result = run("inspect", str(arm_file), "--write", str(tmp_path / name))
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert (tmp_path / "there.toml").read_text() == ""


def test_nothing_is_written_for_several_arms_or_none(tmp_path):
    adapter = tmp_path / "robot.toml"
    path = file_of("humanoid_left")
    result = run("inspect", str(path), "--write", str(adapter))
    assert (result.exit_code, result.stdout) == (2, "")
    assert "--limb left or --limb right" in result.stderr
    assert run("inspect", str(path), "--limb", "left", "--write", str(adapter)).exit_code == 0
    assert srs_ik.load(adapter).tip == "l_wrist"
    (tmp_path / "lamp.urdf").write_text('<robot name="lamp"><link name="foot"/></robot>')
    other = tmp_path / "other.toml"
    assert run("inspect", str(tmp_path / "lamp.urdf"), "--write", str(other)).exit_code == 1
    assert not other.exists()


def test_an_adapter_whose_file_is_gone_names_it(arm_file, tmp_path):
    adapter = tmp_path / "robot.toml"
    write_adapter(adapter, arm_file, srs_ik.load(arm_file))
    arm_file.rename(tmp_path / "moved.urdf")
    with pytest.raises(InvalidRobot, match=r"there is no file .*arm\.urdf, the description of 'my arm'"):
        srs_ik.load(adapter)
    assert srs_ik.load(adapter, urdf=tmp_path / "moved.urdf").name == "my arm"
    with pytest.raises(InvalidRobot, match="urdf= is the description of a robot that is given by its name"):
        srs_ik.load(tmp_path / "moved.urdf", urdf=arm_file)


def test_the_adapter_of_the_documentation_loads(arm_file, tmp_path):
    page = (Path(__file__).resolve().parents[1] / "docs" / "add_your_robot.md").read_text()
    (snippet,) = re.findall(r"```toml\n(.+?)```", page, re.DOTALL)
    text = arm_file.read_text().replace("l0", "base_link").replace("l7", "flange").replace("j2", "joint_2")
    lift = '<link name="floor"/>' + joint_xml("lift", "floor", "base_link", "prismatic")
    (tmp_path / "welder.urdf").write_text(text.replace("</robot>", f"{lift}</robot>"))
    (tmp_path / "robot.toml").write_text(snippet.split("[xacro]")[0])
    arm = srs_ik.load(tmp_path / "robot.toml")
    assert (arm.name, arm.base, arm.tip, arm.upper[1]) == ("welder", "table", "gripper", 1.9)
    assert arm.locked == {"lift": 0.3}
    q = [0.1] * 7
    assert arm.solve(arm.forward_kinematics(q), seed=q)


@pytest.mark.parametrize("command", ["solve", "intervals", "task", "ellipsoids"])
def test_every_command_takes_the_word_for_a_limb(command):
    path = str(file_of("humanoid_left"))
    options = {
        "solve": ["--q", *"0000000"],
        "intervals": ["--q", *"0000000"],
        "task": [
            *("--xyz", "0.3", "0.2", "0.1"),
            *("--velocity", "1", "0", "0"),
            *("--force", "0", "0", "1"),
            *("--hand", *"100001"),
        ],
        "ellipsoids": ["--q", *"0000000"],
    }
    assert "--limb left or --limb right" in run(command, path, *options[command]).stderr
    for side, tip in (("left", "l_wrist"), ("right", "r_wrist")):
        result = run(command, path, "--limb", side, *options[command], "--json")
        assert result.exit_code in (0, 1), result.stderr
        assert json.loads(result.stdout)["tip"] == tip
