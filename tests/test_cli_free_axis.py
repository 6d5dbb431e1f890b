"""`--free-axis` and `--cone` of `srs-ik solve`, `path` and `follow`; wrong input is one line."""

import csv
import json

import numpy as np
import pinocchio as pin
import pytest
from command_line import POSE, Q, answer, run

import srs_ik

ROLLED = ["--xyz", "0.5", "0.1", "0.6", "--rpy", "0.9", "1.5707963", "0"]
"""`POSE`, turned about the tip's x axis."""


def test_the_roll_that_is_free_is_not_asked_for():
    free = ["--free-axis", "1", "0", "0", "--seed", *Q]
    one, other = answer("solve", "iiwa14", *POSE, *free), answer("solve", "iiwa14", *ROLLED, *free)
    np.testing.assert_allclose(one["q"], other["q"], atol=1e-6)
    q = np.array(one["q"])
    tip = srs_ik.load("iiwa14").forward_kinematics(q)
    np.testing.assert_allclose(tip.translation, [0.5, 0.1, 0.6], atol=1e-9)
    np.testing.assert_allclose(tip.rotation[:, 0], [0.0, 0.0, -1.0], atol=1e-7)


def test_a_cone_is_kept_and_used():
    free = ["--free-axis", "1", "0", "0", "--seed", *Q]
    wide = answer("solve", "iiwa14", *POSE, *free, "--cone", "0.35")
    tip = srs_ik.load("iiwa14").forward_kinematics(wide["q"])
    lean = np.arccos(np.clip(-tip.rotation[2, 0], -1.0, 1.0))
    assert 0.01 < lean <= 0.35 + 1e-6


def test_files_of_poses_take_it_too(tmp_path):
    file = tmp_path / "poses.csv"
    T = srs_ik.load("iiwa14").forward_kinematics([float(x) for x in Q]).homogeneous
    with file.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["x", "y", "z", "roll", "pitch", "yaw"])
        for k in range(20):
            turned = T[:3, :3] @ pin.exp3(np.array([0.3 * k, 0.0, 0.0]))
            writer.writerow([repr(float(x)) for x in (*T[:3, 3], *pin.rpy.matrixToRpy(turned))])
    free = ["--free-axis", "1", "0", "0"]
    path = answer("path", "iiwa14", str(file), *free)
    assert np.abs(np.diff(path["q"], axis=0)).max() < 1e-3
    followed = answer("follow", "iiwa14", str(file), "--dt", "0.01", "--q", *Q, *free)
    assert set(followed["status"]) == {"OK"}
    np.testing.assert_allclose(followed["q"], np.tile([float(x) for x in Q], (20, 1)), atol=1e-6)
    solved = answer("solve", "iiwa14", "--file", str(file), "--seed", *Q, *free)
    assert solved["solved"] == 20


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--cone", "0.2"), "give that too"),
        (("--free-axis", "0", "0", "0"), "3 finite numbers that are not all zero"),
        (("--free-axis", "0", "0", "1", "--cone", "7"), "from 0 to pi"),
        (("--free-axis", "0", "0", "1", "--cone", "200", "--degrees"), "from 0 to 180 degrees, not 200"),
        (("--free-axis", "0", "0", "1", "--branch", "0"), "--free-axis goes with none of"),
        (("--free-axis", "0", "0"), "takes 3 numbers, not 2"),
    ],
)
def test_wrong_input_is_one_line(words, said):
    done = run("solve", "iiwa14", *POSE, *words)
    assert done.exit_code == 2
    assert said in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_position_alone_will_do_where_any_rotation_does():
    position, free = ("--xyz", "0.5", "0.1", "0.6"), ("--free-axis", "0", "0", "1")
    found = answer("solve", "iiwa14", *position, *free, "--cone", "180", "--degrees")
    assert found["status"] == "OK"
    tip = srs_ik.load("iiwa14").forward_kinematics(found["q"])
    np.testing.assert_allclose(tip.translation, [0.5, 0.1, 0.6], atol=1e-9)
    for words in (free, (*free, "--cone", "3"), ()):
        refused = run("solve", "iiwa14", *position, *words)
        assert (refused.exit_code, "a position alone is no pose" in refused.stderr) == (2, True)


def test_a_free_roll_in_a_scene_is_that_of_python(tmp_path):
    file = tmp_path / "scene.json"
    arm = srs_ik.load("iiwa14")
    T = arm.forward_kinematics([float(x) for x in Q])
    asked = ("solve", "iiwa14", "--q", *Q, "--free-axis", "1", "0", "0")
    # Where the elbow is without a scene.
    x, y, z = arm.joint_frames(answer(*asked)["q"])[4, :3, 3]
    file.write_text(json.dumps({"objects": [{"name": "ball", "sphere": 0.1, "xyz": [x, y + 0.1, z]}]}))
    found = answer(*asked, "--scene", str(file), "--margin", "0.005")
    wanted = arm.solve(T, scene=srs_ik.Scene.from_file(file), margin=0.005, free_axis=[1, 0, 0])
    assert found["status"] == "OK"
    np.testing.assert_allclose(found["q"], wanted.q, atol=1e-9)
    assert np.abs(wanted.q - answer(*asked)["q"]).max() > 1e-3
