"""`--scene` and `--margin`, and `srs-ik inspect --bodies`, against the same questions in Python."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from command_line import POSE, Q, answer, run

import srs_ik

ROBOTS = Path(__file__).parent.parent / "robots"


@pytest.fixture
def file(tmp_path):
    objects = [
        {"name": "table", "box": [0.4, 0.4, 0.05], "xyz": [0.5, 0.1, 0.2]},
        {"name": "ball", "sphere": 0.05, "xyz": [0.3, 0.3, 0.6]},
    ]
    path = tmp_path / "scene.json"
    path.write_text(json.dumps({"objects": objects}))
    return path


@pytest.mark.slow
def test_intervals_in_a_scene(file):
    found = answer("intervals", "iiwa14", "--q", *Q, "--scene", str(file), "--margin", "0.01")["intervals"]
    arm = srs_ik.load("iiwa14")
    T = arm.forward_kinematics([float(x) for x in Q])
    wanted = arm.intervals(T, scene=srs_ik.Scene.from_file(file), margin=0.01)
    assert [i["branch"] for i in found] == [i.branch for i in wanted]
    assert np.allclose([i["lower"] for i in found], [i.lower for i in wanted], atol=1e-9)


@pytest.mark.slow
def test_solve_in_a_scene(file, tmp_path):
    found = answer("solve", "iiwa14", *POSE, "--scene", str(file))
    assert found["status"] == "OK"
    (tmp_path / "all.json").write_text('{"objects": [{"name": "all", "sphere": 3}]}')
    hit = answer("solve", "iiwa14", *POSE, "--scene", str(tmp_path / "all.json"), exit_code=1)
    assert hit["status"] == "COLLISION"
    assert hit["collision"]["second"] == "all"
    told = run("solve", "iiwa14", *POSE, "--scene", str(tmp_path / "all.json"))
    assert "COLLISION" in told.stderr
    assert told.exit_code == 1


@pytest.mark.slow
def test_the_largest_clearance_needs_a_scene(file):
    found = answer("solve", "iiwa14", *POSE, "--objective", "clearance", "--scene", str(file))
    arm = srs_ik.load("iiwa14")
    T = srs_ik.pose_from_xyz_rpy([0.5, 0.1, 0.6], [0, 1.5707963, 0])
    wanted = arm.optimise(T, "clearance", scene=srs_ik.Scene.from_file(file))
    assert np.allclose(found["q"], wanted.q, atol=1e-6)
    bare = run("solve", "iiwa14", *POSE, "--objective", "clearance")
    assert bare.exit_code == 2
    assert "needs a scene" in bare.stderr
    assert bare.stderr.count("\n") == 1


@pytest.mark.parametrize("words", [("--margin", "0.1"), ("--exact",)])
def test_a_margin_needs_a_scene(words):
    result = run("solve", "iiwa14", *POSE, *words)
    assert result.exit_code != 0


def test_a_wrong_scene_is_one_line(tmp_path):
    (tmp_path / "wrong.json").write_text('{"objects": [{"name": "a", "sphere": -1}]}')
    result = run("solve", "iiwa14", *POSE, "--scene", str(tmp_path / "wrong.json"))
    assert result.exit_code != 0
    assert isinstance(result.exception, (SystemExit, srs_ik.InvalidScene))


def test_bodies_of_an_arm():
    found = answer("inspect", "iiwa14", "--bodies")
    arm = srs_ik.load("iiwa14")
    assert [body["name"] for body in found["bodies"]] == [body.name for body in arm.bodies]
    assert np.allclose(found["bodies"][3]["spheres"], arm.bodies[3].spheres)
    assert [pair["watched"] for pair in found["pairs"]] == [pair.kept for pair in arm.pairs]
    shown = run("inspect", "iiwa14", "--bodies").stdout
    assert "never meet (proved)" in shown
    assert "iiwa_link_4" in shown


def test_meshes_of_a_package_that_is_elsewhere(file, tmp_path):
    robot, meshes = tmp_path / "robot.urdf", tmp_path / "elsewhere" / "cans"
    meshes.mkdir(parents=True)
    plain = (ROBOTS / "human_arm" / "human_arm.urdf").read_text()
    form = '<sphere radius="0.058"/>'
    robot.write_text(plain.replace(form, '<mesh filename="package://cans/can.stl"/>'))
    trimesh.creation.icosphere(1, 0.02).export(meshes / "can.stl")
    words = ["solve", str(robot), "--q", *Q, "--no-limits", "--scene", str(file)]
    refused = run(*words)
    assert (refused.exit_code, "--meshes" in refused.stderr, refused.stderr.count("\n")) == (2, True, 1)
    assert run(*words, "--meshes", str(meshes.parent)).exit_code in (0, 1)
