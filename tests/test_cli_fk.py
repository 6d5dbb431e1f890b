"""`srs-ik fk`, and `srs-ik solve --file`: many at once through files, each checked by Pinocchio."""

import csv
import json

import numpy as np
import pytest
from command_line import POSE, Q, answer, pose_by_pinocchio, run

import srs_ik

JOINTS = [
    [0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2],
    [0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0],
    [0.0, 0.4, 0.0, -1.5, 0.0, 0.9, 1.0],
]


def write(path, header, rows):
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    return str(path)


def read(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture
def names():
    return srs_ik.load("iiwa14").joint_names


def test_one_configuration_in_radians_and_in_degrees():
    found = answer("fk", "iiwa14", "--q", *Q)
    expected = pose_by_pinocchio("iiwa14", [float(x) for x in Q])
    np.testing.assert_allclose(found["T_base_tip"], expected, atol=1e-12)
    assert found["q"] == pytest.approx([float(x) for x in Q])
    degrees = [repr(float(np.rad2deg(float(x)))) for x in Q]
    turned = answer("fk", "iiwa14", "--q", *degrees, "--degrees")
    np.testing.assert_allclose(turned["T_base_tip"], expected, atol=1e-12)
    row = run("fk", "iiwa14", "--q", *Q).stdout.splitlines()[-1].split()
    assert [float(x) for x in row[1:4]] == pytest.approx(expected[:3, 3], abs=1e-9)
    rpy, quaternion = ([float(x) for x in row[i:j]] for i, j in ((4, 7), (7, 11)))
    for pose in (
        srs_ik.pose_from_xyz_rpy([0, 0, 0], rpy),
        srs_ik.pose_from_xyz_quaternion([0, 0, 0], quaternion, order="xyzw"),
    ):
        np.testing.assert_allclose(pose.rotation, expected[:3, :3], atol=1e-8)


@pytest.mark.parametrize("kind", ["joint names", "numbers", "degrees"])
def test_joints_of_a_file_become_poses_that_solve_reads(tmp_path, names, kind):
    unit = 180.0 / np.pi if kind == "degrees" else 1.0
    header = ["t", *([f"q{k}" for k in range(1, 8)] if kind == "numbers" else names[::-1])]
    rows = [[0.5, *(unit * np.array(q if kind == "numbers" else q[::-1])).tolist()] for q in JOINTS]
    joints, poses, back = write(tmp_path / "joints.csv", header, rows), tmp_path / "poses.csv", tmp_path / "back.csv"
    words = ["--degrees"] if kind == "degrees" else []
    found = answer("fk", "iiwa14", "--file", joints, "--out", str(poses), *words)
    np.testing.assert_allclose(found["q"], JOINTS, atol=1e-12)
    expected = [pose_by_pinocchio("iiwa14", q) for q in JOINTS]
    np.testing.assert_allclose(found["T_base_tip"], expected, atol=1e-12)

    solved = answer("solve", "iiwa14", "--file", str(poses), "--seed", *(str(x) for x in JOINTS[0]), "--out", str(back))
    assert (solved["solved"], [s["line"] for s in solved["solutions"]]) == (3, [2, 3, 4])
    table = read(back)
    for s, row, T in zip(solved["solutions"], table, expected, strict=True):
        q = [float(row[name]) for name in names]
        assert (row["status"], q) == ("OK", s["q"])
        assert int(row["branch"]) == s["branch"]
        np.testing.assert_allclose(pose_by_pinocchio("iiwa14", q), T, atol=1e-9)
    np.testing.assert_allclose(solved["solutions"][0]["q"], JOINTS[0], atol=1e-7)
    # What solve writes, fk reads.
    again = answer("fk", "iiwa14", "--file", str(back))
    np.testing.assert_allclose(again["T_base_tip"], expected, atol=1e-9)


def test_poses_without_a_solution_are_told_by_their_line(tmp_path):
    far = [[0.5, 0.1, 0.6, 0, 1.57, 0], [5, 0, 0, 0, 0, 0], [0.5, 0.1, 0.7, 0, 1.57, 0], [6, 0, 0, 0, 0, 0]]
    path = write(tmp_path / "poses.csv", ["x", "y", "z", "roll", "pitch", "yaw"], far)
    out = tmp_path / "joints.csv"
    result = run("solve", "iiwa14", "--file", path, "--out", str(out))
    assert result.exit_code == 1
    assert result.stderr.startswith(f"srs-ik: {path}, line 3: UNREACHABLE: ")
    assert result.stderr.endswith("(1 more)\n")
    assert "2 of 4 poses solved" in result.stdout
    assert [row["status"] for row in read(out)] == ["OK", "UNREACHABLE", "OK", "UNREACHABLE"]
    result = run("solve", "iiwa14", "--file", path, "--json")
    assert result.exit_code == 1
    assert [s["status"] for s in json.loads(result.stdout)["solutions"]] == ["OK", "UNREACHABLE", "OK", "UNREACHABLE"]


def test_options_of_one_pose_hold_for_all_of_a_file(tmp_path):
    path = write(tmp_path / "poses.csv", ["x", "y", "z", "roll", "pitch", "yaw"], [[0.5, 0.1, 0.6, 0, 1.57, 0]] * 2)
    found = answer("solve", "iiwa14", "--file", path, "--arm-angle", "0.3", "--branch", "4", "--no-limits")
    assert [(s["branch"], s["arm_angle"]) for s in found["solutions"]] == [(4, pytest.approx(0.3))] * 2


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["fk", "iiwa14"], "--q Q1 .. Q7, or --file JOINTS.csv"),
        (["fk", "iiwa14", "--q", *Q, "--file", "FILE"], "--q Q1 .. Q7, or --file JOINTS.csv"),
        (["fk", "iiwa14", "--file", "FILE"], "it lacks q1, q2"),
        (["fk", "iiwa14", "--file", "nowhere.csv"], "nowhere.csv: No such file"),
        (["fk", "iiwa14", "--q", "1", "2"], "--q takes 7 numbers, not 2"),
        (["fk", "iiwa14", "--q", *Q[:6], "nan"], "--q takes finite numbers"),
        (["solve", "iiwa14", *POSE, "--file", "FILE"], "--file has the poses"),
        (["solve", "iiwa14", "--all", "--file", "FILE"], "--file has the poses"),
        (["solve", "iiwa14", "--objective", "manipulability", "--file", "FILE"], "--file has the poses"),
        (["solve", "iiwa14", *POSE, "--out", "joints.csv"], "--out writes what becomes of the poses of --file"),
        (["solve", "iiwa14", "--file", "EMPTY"], "is empty"),
        (["fk", "iiwa14", "--file", "EMPTY"], "is empty"),
    ],
)
def test_wrong_input_is_one_line(tmp_path, words, named):
    file = write(tmp_path / "poses.csv", ["x", "y", "z", "roll", "pitch", "yaw"], [[0.5, 0.1, 0.6, 0, 1.57, 0]])
    (tmp_path / "empty.csv").touch()
    places = {"FILE": file, "EMPTY": str(tmp_path / "empty.csv")}
    result = run(*(places.get(word, word) for word in words))
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.count("\n") == 1
    assert named in result.stderr


@pytest.mark.parametrize(
    ("rows", "named"),
    [
        ([["a"] * 7], "line 2: iiwa_joint_1 must be a finite number, not 'a'"),
        ([[0.0] * 6], "line 2: there is no iiwa_joint_7; the line ends after 6 columns"),
        ([], "has a header and no joint angles below it"),
    ],
)
def test_a_wrong_line_of_joints_is_named(tmp_path, names, rows, named):
    result = run("fk", "iiwa14", "--file", write(tmp_path / "joints.csv", names, rows))
    assert result.exit_code == 2
    assert named in result.stderr


def test_radians_that_are_read_in_degrees_are_noticed(tmp_path, names):
    file = write(tmp_path / "joints.csv", names, JOINTS)
    said = run("fk", "iiwa14", "--file", file, "--degrees")
    assert said.exit_code == 0
    assert "is read in degrees, and none of its angles is more than 1.5: are these radians?" in said.stderr
    assert "degrees" not in run("fk", "iiwa14", "--file", file).stderr
