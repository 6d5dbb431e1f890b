"""The command line: what `srs-ik solve` prints is true, and what is wrong is said in one line."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import POSE, Q, answer, pose_by_pinocchio, run, run_apart
from robot_files import at_hand, joint_xml, robot_file, serial_arm

import srs_ik
from srs_ik import cli
from srs_ik.robot import zoo


def rotation(roll: float, pitch: float, yaw: float) -> np.ndarray:
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


# solve


def test_solve_finds_joint_angles_that_reach_the_pose_asked_for():
    found = answer("solve", "iiwa14", *POSE)
    asked = np.eye(4)
    asked[:3, :3], asked[:3, 3] = rotation(0.0, 1.5707963, 0.0), (0.5, 0.1, 0.6)
    assert found["status"] == "OK"
    assert np.allclose(found["T_base_tip"], asked, rtol=0.0, atol=1e-15)
    assert np.allclose(pose_by_pinocchio("iiwa14", found["q"]), asked, rtol=0.0, atol=1e-11)


def test_a_xacro_file_that_needs_an_argument_is_solved_with_it(tmp_path):
    path = tmp_path / "needs.urdf.xacro"
    links = serial_arm(prefix="$(arg side)_")
    path.write_text(f'<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">{links}</robot>')
    said = run("fk", str(path), "--q", *Q).stderr
    assert said.endswith("give it one, --xacro-arg side:=VALUE\n")
    found = answer("solve", str(path), "--q", *Q, "--seed", *Q, "--xacro-arg", "side:=left")
    assert (found["base"], found["tip"]) == ("left_l0", "left_l7")
    np.testing.assert_allclose(found["q"], np.array(Q, dtype=float), atol=1e-9)  # rad
    assert run("fk", str(path), "--q", *Q, "--xacro-arg", "side").stderr.startswith(
        "srs-ik: --xacro-arg takes NAME:=VALUE, not 'side'"
    )


def test_an_srdf_chooses_the_arm(tmp_path):
    robot = "".join(
        serial_arm(prefix=side) + joint_xml(f"to_{side}", "torso", f"{side}l0", "fixed", "")
        for side in ("left_", "right_")
    )
    Path(tmp_path / "twins.urdf").write_text(f'<robot name="twins"><link name="torso"/>{robot}</robot>')
    Path(tmp_path / "twins.srdf").write_text(
        '<robot name="twins"><group name="this"><chain base_link="torso" tip_link="right_l7"/></group></robot>'
    )
    words = ["fk", str(tmp_path / "twins.urdf"), "--q", *Q, "--srdf", str(tmp_path / "twins.srdf"), "--limb", "this"]
    found = answer(*words)
    assert (found["base"], found["tip"]) == ("torso", "right_l7")


def test_roll_pitch_and_yaw_are_those_of_a_urdf():
    found = answer("solve", "iiwa14", "--xyz", "0.4", "-0.2", "0.6", "--rpy", "0.3", "-0.5", "1.1", "--no-limits")
    assert np.allclose(pose_by_pinocchio("iiwa14", found["q"])[:3, :3], rotation(0.3, -0.5, 1.1), rtol=0.0, atol=1e-11)


def test_the_scalar_part_of_a_quaternion_comes_last():
    quaternion = [str(np.sin(0.15)), "0", "0", str(np.cos(0.15))]
    found = answer("solve", "iiwa14", "--xyz", "0.4", "-0.2", "0.6", "--quat", *quaternion)
    assert np.allclose(np.array(found["T_base_tip"])[:3, :3], rotation(0.3, 0.0, 0.0), rtol=0.0, atol=1e-15)


def test_degrees_and_radians_say_the_same():
    words = {"--rpy": [0.0, 1.5, 0.2], "--seed": [float(q) for q in Q]}
    in_radians = [w for key, values in words.items() for w in (key, *map(str, values))]
    in_degrees = [w for key, values in words.items() for w in (key, *map(str, np.rad2deg(values)))]
    xyz = ["--xyz", "0.5", "0.1", "0.6"]
    one = answer("solve", "iiwa14", *xyz, *in_radians)
    other = answer("solve", "iiwa14", *xyz, *in_degrees, "--degrees")
    assert one["q"] == pytest.approx(other["q"], abs=1e-6)


def test_from_q_asks_for_the_pose_of_these_joint_angles():
    found = answer("solve", "iiwa14", "--q", *Q)
    asked = pose_by_pinocchio("iiwa14", [float(q) for q in Q])
    assert np.allclose(found["T_base_tip"], asked, rtol=0.0, atol=1e-14)
    assert np.allclose(pose_by_pinocchio("iiwa14", found["q"]), asked, rtol=0.0, atol=1e-11)


def test_a_seed_brings_its_own_posture_back():
    found = answer("solve", "iiwa14", "--q", *Q, "--seed", *Q)
    assert found["q"] == pytest.approx([float(q) for q in Q], abs=1e-6)


def test_arm_angle_and_branch_are_kept():
    found = answer("solve", "iiwa14", *POSE, "--arm-angle", "0.4", "--no-limits", "--branch", "3")
    assert found["arm_angle"] == pytest.approx(0.4, abs=1e-9)
    assert found["branch"] == 3


def test_all_prints_every_branch_at_an_arm_angle():
    found = answer("solve", "iiwa14", "--q", *Q, "--arm-angle", "0.4", "--all", "--no-limits")
    assert sorted(s["branch"] for s in found["solutions"]) == list(range(8))
    for solution in found["solutions"]:
        assert np.allclose(pose_by_pinocchio("iiwa14", solution["q"]), found["T_base_tip"], rtol=0.0, atol=1e-11)
    table = run("solve", "iiwa14", "--q", *Q, "--arm-angle", "0.4", "--all", "--no-limits")
    assert table.exit_code == 0
    assert "8 solutions, the branches at this arm angle" in table.stdout


def test_all_without_an_arm_angle_prints_a_posture_for_every_interval():
    words = ["solve", "iiwa14", "--q", *Q, "--all"]
    found = answer(*words)
    intervals = srs_ik.load("iiwa14").intervals(np.array(found["T_base_tip"]))
    assert [s["branch"] for s in found["solutions"]] == [interval.branch for interval in intervals]
    assert all(s["arm_angle"] in i for s, i in zip(found["solutions"], intervals, strict=True))
    assert f"{len(intervals)} solutions, the best of each interval" in run(*words).stdout


def test_the_table_shows_the_joint_angles_of_the_json():
    found = answer("solve", "iiwa14", *POSE)
    text = run("solve", "iiwa14", *POSE).stdout
    for name, q in zip(found["joint_names"], found["q"], strict=True):
        (line,) = (line for line in text.splitlines() if name in line)
        radians, degrees = (float(word) for word in line.split()[1:3])
        assert radians == pytest.approx(q, abs=1e-9)
        assert degrees == pytest.approx(np.rad2deg(q), abs=1e-4)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["solve", "iiwa14", "--armangle", "0"], "solve has no option --armangle (did you mean '--arm-angle'?)"),
        (["preview", "iiwa14", "--html", "x.html"], "preview has no option --html; it takes --q, --xyz, "),
        (["robots", "-x"], "robots has no option -x; it takes --json, --help"),
    ],
)
def test_an_option_that_is_none_is_answered_with_those_that_are(words, said):
    result = run(*words)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"srs-ik: {said}")
    assert result.stderr.count("\n") == 1
    assert "--save" in result.stderr or words[0] != "preview"


def test_a_negative_position_is_no_option():
    found = answer(
        "solve",
        "iiwa14",
        "--xyz",
        "-0.3",
        "-0.2",
        ".7",
        "--rpy",
        "-1",
        "-.2",
        "-0.3",
        "--arm-angle",
        "-0.5",
        "--no-limits",
    )
    assert [row[3] for row in found["T_base_tip"]] == [-0.3, -0.2, 0.7, 1.0]


def test_no_digit_is_cut_off_in_a_narrow_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    words = ["solve", "iiwa14", "--q", *Q, "--arm-angle", "0.4", "--all", "--no-limits"]
    text = run(*words).stdout
    for solution in answer(*words)["solutions"]:
        assert all(f"{np.rad2deg(q):.2f}" in text for q in solution["q"])


@pytest.mark.parametrize("extra", [[], ["--all"]])
def test_out_of_reach_is_an_answer_with_exit_status_1(extra):
    words = ["solve", "iiwa14", "--xyz", "3", "0", "0.5", "--rpy", "0", "1.57", "0", *extra]
    result = run(*words, "--json")
    assert result.exit_code == 1
    found = json.loads(result.stdout)
    assert found["status"] == "UNREACHABLE"
    assert found["message"]
    assert found.get("solutions", []) == []
    asked, reached = np.array(found["T_base_tip"])[:3, 3], pose_by_pinocchio("iiwa14", found["q"])[:3, 3]
    assert found["position_error"] == pytest.approx(np.linalg.norm(asked - reached), abs=1e-9)
    assert result.stderr.count("\n") == 1
    assert "UNREACHABLE" in result.stderr
    assert "UNREACHABLE" in run(*words).stdout


# wrong input


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["solve"], "ROBOT"),
        (["solve", "iiwa14"], "--xyz"),
        (["solve", "iiwa14", "--xyz", "1", "2", "3"], "--rpy"),
        (["solve", "iiwa14", "--rpy", "1", "2", "3"], "--xyz"),
        (["solve", "iiwa14", "--xyz", "1", "2", "--rpy", "0", "0", "0"], "--xyz takes 3 numbers, not 2"),
        (["solve", "iiwa14", "--xyz", "1", "2"], "--xyz takes 3 numbers, not 2"),
        (["solve", "iiwa14", "--xyz", "1", "2", "3", "4", "--rpy", "0", "0", "0"], "--xyz takes 3 numbers, not 4"),
        (["solve", "iiwa14", "--xyz", "1", "up", "3", "--rpy", "0", "0", "0"], "'up'"),
        (["solve", "iiwa14", "--xyz", "1", "nan", "3", "--rpy", "0", "0", "0"], "nan"),
        (["solve", "iiwa14", *POSE, "--seed", "0", "0", "0", "inf", "0", "0", "0"], "inf"),
        (["solve", "iiwa14", *POSE, "--arm-angle", "nan"], "--arm-angle"),
        (["solve", "iiwa14", *POSE, "--arm-angle", "up"], "--arm-angle"),
        (["solve", "iiwa14", *POSE, "--quat", "0", "0", "0", "1"], "--quat"),
        (["solve", "iiwa14", "--xyz", "1", "2", "3", "--quat", "0", "0", "0", "2"], "--quat"),
        (["solve", "iiwa14", "--xyz", "1", "2", "3", "--quat", "0", "0", "0", "0"], "--quat"),
        (["solve", "iiwa14", *POSE, "--q", *Q], "--q"),
        (["solve", "iiwa14", "--q", "1", "2", "3"], "--q takes 7 numbers, not 3"),
        (["solve", "iiwa14", *POSE, "--branch", "8"], "--branch"),
        (["solve", "iiwa14", *POSE, "--branch", "-1"], "--branch"),
        (["solve", "iiwa14", *POSE, "--all", "--branch", "1"], "--all"),
        (["solve", "iiwa14", *POSE, "--colour"], "--colour"),
        (["solve", "iiwa41", *POSE], "iiwa41"),
        (["solve", "no/such/file.urdf", *POSE], "no/such/file.urdf"),
        (["solve", "iiwa14", *POSE, "--tip", "nose"], "nose"),
        (["inspect", "no/such/file.urdf"], "no/such/file.urdf"),
        (["inspect"], "ROBOT"),
        (["dance"], "dance"),
        (["--dance"], "--dance"),
    ],
)
def test_wrong_input_is_one_line_that_names_it_and_exit_status_2(words, named):
    result = run(*words)
    assert result.exit_code == 2, result.exception
    assert result.stdout == ""
    assert result.stderr.startswith("srs-ik: ")
    assert result.stderr.count("\n") == 1
    assert named in result.stderr


@pytest.mark.parametrize("text", ["", "not XML", "<robot", "<robot name='x'/>", "\x00\x01"])
@pytest.mark.parametrize("command", [["inspect"], ["solve", *POSE]])
def test_a_broken_file_is_named_in_one_line(tmp_path, text, command):
    path = tmp_path / "broken.urdf"
    path.write_text(text)
    result = run(command[0], str(path), *command[1:])
    assert result.exit_code == 2, result.stdout
    assert result.stderr.count("\n") == 1
    assert "broken.urdf" in result.stderr


@pytest.mark.parametrize("name", at_hand("made_twins", "openarm_v10_bimanual"))
def test_several_arms_are_listed_in_one_line(name):
    result = run("solve", str(robot_file(name)), *POSE)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "left" in result.stderr
    assert "right" in result.stderr


@pytest.mark.parametrize("name", at_hand("made_fr3", "franka_fr3"))
def test_a_refused_arm_is_one_line_with_millimetres(name):
    result = run("solve", str(robot_file(name)), *POSE)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert " mm" in result.stderr


def test_faults_of_the_program_are_not_hidden(monkeypatch):
    def faulty(name):
        raise RuntimeError("a fault")

    monkeypatch.setattr(zoo, "card", faulty)
    assert isinstance(run("robots").exception, RuntimeError)


# in a process of its own


@pytest.mark.slow
def test_an_error_in_a_process_of_its_own_is_one_line_and_no_traceback():
    result = run_apart(["solve", "no/such/file.urdf", *POSE])
    assert result.returncode == 2
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith("srs-ik: ")


@pytest.mark.slow
def test_json_stands_alone_on_standard_output_of_a_process():
    result = run_apart(["solve", "human_arm", "--q", *Q, "--no-limits", "--json"])
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    found = json.loads(result.stdout)
    assert np.allclose(pose_by_pinocchio("human_arm", found["q"]), found["T_base_tip"], rtol=0.0, atol=1e-11)


@pytest.mark.slow
def test_names_that_the_terminal_cannot_write_are_escaped(tmp_path):
    card = zoo.card("iiwa14")
    path = tmp_path / "umlaut.urdf"
    path.write_text(card.urdf.read_text().replace("iiwa_joint_1", "gelenk_für_[eins]"), encoding="utf-8")
    result = run_apart(["inspect", str(path)], PYTHONIOENCODING="ascii")
    assert result.returncode == 0, result.stderr
    assert r"gelenk_f\xfcr_[eins]" in result.stdout


@pytest.mark.slow
def test_a_reader_that_leaves_early_is_no_error():
    command = f"{sys.executable} -c 'from srs_ik.cli import main; main()' robots --json"
    result = subprocess.run(
        ["bash", "-c", f"{command} | true; echo ${{PIPESTATUS[0]}}"], capture_output=True, text=True, timeout=300
    )
    assert result.stderr == ""
    assert result.stdout.strip() in {"0", "141"}


@pytest.mark.slow
def test_a_full_disk_is_one_line():
    if not Path("/dev/full").exists():
        pytest.skip("/dev/full is not here")
    for extra in ([], ["--json"]):
        command = [sys.executable, "-c", "from srs_ik.cli import main; main()", "robots", *extra]
        with open("/dev/full", "w") as full:
            result = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=300)
        assert result.returncode == 2
        assert result.stderr.count("\n") == 1
        assert "space" in result.stderr


def test_an_interruption_is_quiet(monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(zoo, "robots", interrupted)
    monkeypatch.setattr(sys, "argv", ["srs-ik", "robots"])
    with pytest.raises(SystemExit) as exit_:
        cli.main()
    assert exit_.value.code == 130
    assert capsys.readouterr().err == ""


@pytest.mark.slow
def test_help_and_version_load_no_heavy_library():
    code = """
import sys
from srs_ik.cli import main
try:
    main()
finally:
    print(*{"numpy", "pinocchio", "numba", "scipy", "yourdfpy", "meshcat"} & set(sys.modules), file=sys.stderr)
"""
    for word in ("--help", "--version"):
        result = subprocess.run([sys.executable, "-c", code, word], capture_output=True, text=True, timeout=300)
        assert result.returncode == 0
        assert result.stdout
        assert result.stderr.split() == []


def test_every_command_explains_itself():
    for command in ("robots", "inspect", "solve"):
        result = run(command, "--help")
        assert result.exit_code == 0
        assert command in result.stdout
    assert run().stdout == run("--help").stdout


@pytest.mark.filterwarnings("error")
def test_a_quaternion_of_any_length_is_told_by_its_length():
    for words, said in ((("0", "0", "0", "1e200"), "1e+200"), (("0", "0", "0", "0"), "0")):
        result = run("solve", "iiwa14", "--xyz", "0.5", "0", "0.5", "--quat", *words)
        assert result.stderr == f"srs-ik: --quat is a rotation only if its length is 1, not {said}\n"
    with pytest.raises(srs_ik.InvalidPose, match=r"its length is 1, not 1e\+200"):
        srs_ik.pose_from_xyz_quaternion([0, 0, 0], [0, 0, 1e200, 0], order="xyzw")


def test_a_folder_is_no_scene(tmp_path):
    result = run("solve", "iiwa14", *POSE, "--scene", str(tmp_path))
    assert (result.exit_code, result.stderr) == (2, f"srs-ik: {tmp_path} is a directory, not a file\n")
