"""What the commands say of themselves: help, examples, likely slips, and closed streams."""

import inspect
import os
import shlex
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from command_line import POSE, Q, answer, run, run_apart

import srs_ik
from srs_ik.cli.app import app
from srs_ik.cli.examples import EXAMPLES
from srs_ik.cli.map_use import map_app
from srs_ik.robot import zoo

COMMANDS = sorted(command.name for command in app.registered_commands)
RUNNABLE = [
    line
    for name, lines in EXAMPLES.items()
    for line in lines
    if name not in ("bench", "reproduce")
    and not {"my_robot.urdf", "poses.csv", "joints.csv", "--interactive"} & set(line.split())
]


def test_every_command_has_examples():
    assert set(EXAMPLES) <= set(COMMANDS)
    assert all(
        line.startswith(f"srs-ik {name} ") or line == f"srs-ik {name}" for name in EXAMPLES for line in EXAMPLES[name]
    )


@pytest.mark.parametrize("command", EXAMPLES)
def test_examples_stand_in_the_help_on_one_line_each(command):
    shown = run(command, "--help").stdout
    for line in EXAMPLES[command]:
        assert f"\n  {line}\n" in shown + "\n"


@pytest.mark.parametrize("line", RUNNABLE)
def test_examples_work_as_they_stand(line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(*shlex.split(line)[1:])
    assert result.exit_code == 0, result.stderr or result.exception
    assert result.stderr == ""


@pytest.mark.parametrize("columns", [80, 120, 200])
def test_help_is_as_wide_as_the_terminal(columns):
    shown = run_apart(["solve", "--help"], COLUMNS=str(columns)).stdout
    width = max(len(line) for line in shown.partition("Examples:")[0].splitlines())
    assert min(columns, 120) - 25 < width <= min(columns, 120)


@pytest.mark.parametrize("group", [(), ("map",)])
def test_the_list_of_commands_is_cut_nowhere(group):
    shown = run_apart([*group, "--help"], COLUMNS="80").stdout
    listed = shown.partition("Commands:")[2].splitlines()[1:]
    assert listed
    assert all(len(line) <= 80 and line.endswith((".", ")")) and not line.endswith("...") for line in listed if line)


def test_every_command_that_takes_a_robot_reads_it_alike():
    """A xacro file by its arguments, if it is allowed to run; and an arm by its names, unless a map has these."""
    asked = [command for command in app.registered_commands + map_app.registered_commands if command.name != "bench"]
    every = [set(inspect.signature(each.callback).parameters) for each in asked]
    taking = [options for options in every if {"source", "robot"} & options or {"folder", "exact"} <= options]
    assert len(taking) >= 16
    for options in taking:
        assert options >= {"allow_xacro", "xacro_arg", "lock"}
        assert "folder" in options or options >= {"base", "tip", "limb", "srdf"}


@pytest.mark.parametrize("command", ["solve", "intervals", "ellipsoids"])
def test_the_former_name_of_q_is_understood_and_not_shown(command):
    assert answer(command, "iiwa14", "--from-q", *Q) == answer(command, "iiwa14", "--q", *Q)
    assert "--from-q" not in run(command, "--help").stdout


def said(*words: str) -> str:
    result = run(*words)
    assert result.exit_code in (0, 1), result.stderr
    return result.stderr


@pytest.mark.parametrize(
    ("words", "option"),
    [
        (["solve", "iiwa14", "--xyz", "0.5", "0.1", "0.6", "--rpy", "180", "0", "0"], "--rpy"),
        (["solve", "iiwa14", *POSE, "--seed", "0", "40", "0", "-80", "0", "10", "0"], "--seed"),
        (["solve", "iiwa14", *POSE, "--arm-angle", "-45"], "--arm-angle"),
        (["ellipsoids", "iiwa14", "--q", "0", "20", "0", "-80", "0", "10", "0"], "--q"),
        (["intervals", "iiwa14", "--q", "0", "20", "0", "-80", "0", "10", "0"], "--q"),
        (["path", "iiwa14", "poses.csv", "--longest-step", "30"], "--longest-step"),
        (["follow", "iiwa14", "poses.csv", "--dt", "0.1", "--elbow", "30"], "--elbow"),
        (["fk", "iiwa14", "--file", "joints.csv"], "joints.csv"),
    ],
)
def test_degrees_where_radians_belong_are_noticed(words, option, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("poses.csv").write_text("x,y,z,qx,qy,qz,qw\n0.5,0.1,0.6,0,0.6,0,0.8\n")
    Path("joints.csv").write_text("q1,q2,q3,q4,q5,q6,q7\n0,20,0,-80,0,10,0\n")
    lines = [line for line in said(*words).splitlines() if "degrees?" in line]
    assert len(lines) == 1
    assert lines[0].startswith(f"srs-ik: {option} is in radians")
    assert "add --degrees" in lines[0]
    assert "degrees?" not in said(*words, "--degrees")


@pytest.mark.slow
def test_degrees_are_noticed_once():
    seeded = ["--seed", "0", "40", "0", "-80", "0", "10", "0"]
    lines = run_apart(["solve", "iiwa14", *POSE, *seeded, "--arm-angle", "45"]).stderr.splitlines()
    assert [line.split()[1] for line in lines if "degrees?" in line] == ["--arm-angle", "--seed"]


def test_degrees_in_a_file_of_poses_are_noticed(tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text("x,y,z,roll,pitch,yaw\n0.5,0.1,0.6,0,90,0\n0.5,0.1,0.61,0,90,0\n")
    assert f"srs-ik: {path} is in radians, and 90 rad" in said("path", "iiwa14", str(path))
    assert said("path", "iiwa14", str(path), "--degrees") == ""


def test_whole_turns_and_less_are_not():
    assert said("solve", "iiwa14", "--xyz", "0.5", "0.1", "0.6", "--rpy", "6.28", "1.57", "-6.28") == ""


def test_degrees_in_an_adapter_are_noticed(tmp_path):
    path = tmp_path / "robot.toml"
    assert run("inspect", "iiwa14", "--write", str(path)).exit_code == 0
    text = path.read_text()
    joint = srs_ik.load("iiwa14").joint_names[0]
    path.write_text(text + f'\n[limits]\n"{joint}" = {{ lower = -90, upper = 90 }}\n')
    assert tomllib.loads(path.read_text())["limits"]
    with pytest.warns(UserWarning, match=f"limits are in radians, and joint '{joint}' is given 90: are these degrees"):
        srs_ik.load(path)


def test_millimetres_are_noticed():
    arm = srs_ik.load("iiwa14")
    pose = np.eye(4)
    pose[:3, 3] = 500.0, 100.0, 600.0
    assert arm.solve(pose).message.endswith("Positions are in metres: is this one in millimetres?")
    assert arm.solve_batch([pose]).message(0) == arm.solve(pose).message
    pose[:3, 3] = 5.0, 1.0, 6.0
    assert "millimetres" not in arm.solve(pose).message


def test_a_task_without_a_hand_is_answered_with_the_option(tmp_path):
    urdf = tmp_path / "plain.urdf"
    urdf.write_text(zoo.card("iiwa14").urdf.read_text())
    words = [str(urdf), "--xyz", "0.4", "0", "0.5", "--velocity", "1", "0", "0", "--force", "0", "0", "1"]
    result = run("task", *words)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "--hand GX GY GZ PX PY PZ" in result.stderr
    assert "hand=" not in result.stderr
    shown = run("inspect", str(urdf)).stdout
    (line,) = (line for line in shown.splitlines() if "takes --hand" in line)
    axes = line.partition("--hand ")[2].rstrip(".").split()
    assert len(axes) == 6
    assert run("task", *words, "--hand", *axes).exit_code in (0, 1)
    found = answer("inspect", str(urdf))["limbs"][0]
    assert found["hand_axes"] is None
    arm = srs_ik.load(urdf)
    T = arm.limb.T_base_tip_zero
    along = T[:3, :3] @ np.array([float(x) for x in axes[:3]])
    out = T[:3, 3] - arm.limb.wrist
    np.testing.assert_allclose(along, out / np.linalg.norm(out), atol=1e-4)


def test_inspect_says_where_a_known_hand_points():
    assert "The hand reaches out along (1 0 0) of the tip frame" in run("inspect", "iiwa14").stdout
    assert answer("inspect", "iiwa14")["limbs"][0]["hand_axes"]["grasp"] == list(srs_ik.load("iiwa14").hand.grasp)


COMMAND = f"{shlex.quote(sys.executable)} -c 'from srs_ik.cli import main; main()'"


@pytest.mark.slow
@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&-", ">&- 2>&-", ">&- 2>&- <&-"])
@pytest.mark.parametrize(
    ("words", "code"),
    [
        ("robots", 0),
        ("robots --json", 0),
        ("solve iiwa14 --q 0 0.3 0 -1 0 0.5 0", 0),
        ("solve no/such/file", 2),
        ("", 0),
    ],
)
def test_closed_streams_are_no_error(closed, words, code):
    done = subprocess.run(
        ["bash", "-c", f"{COMMAND} {words} {closed}"], capture_output=True, text=True, timeout=300, env=os.environ
    )
    assert done.returncode == code
    assert "Traceback" not in done.stdout + done.stderr
    assert done.stderr.count("\n") <= 1


@pytest.mark.slow
@pytest.mark.parametrize(
    "words", ["robots", "robots --json", "inspect iiwa14", "solve --help", "--version", "solve no/such/file 2>&1"]
)
def test_a_broken_pipe_ends_as_by_sigpipe(words):
    reader, writer = os.pipe()
    os.close(reader)
    command = ["bash", "-c", f"{COMMAND} {words}"]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, timeout=300)
    os.close(writer)
    assert done.returncode == 128 + signal.SIGPIPE
    assert done.stderr == ""
