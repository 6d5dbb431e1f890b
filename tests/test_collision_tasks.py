"""Tasks in scenes: the free arm angle nearest to the one that is asked for, against the intervals and NumPy."""

import json

import numpy as np
import pytest
from collision_oracle import clearance
from command_line import answer

import srs_ik

TASK = {"position": [0.3, 0.15, -0.1], "velocity": [1.0, 0.0, 0.3], "force": [0.0, 0.2, 1.0]}


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("human_arm")


def at_elbow(arm, solution, radius=0.06):
    scene = srs_ik.Scene()
    scene.add_sphere("ball", arm.joint_frames(solution.q)[4, :3, 3], radius)
    return scene


def test_a_task_that_hits_nothing_is_answered_as_ever(arm):
    task = srs_ik.Task(**TASK)
    plain, clear = arm.solve_task(task), arm.solve_task(task, scene=srs_ik.Scene())
    assert plain
    # It stays a nanoradian inside of its interval.
    assert np.abs(plain.q - clear.q).max() < 1e-8
    assert clear.angle_lost == pytest.approx(plain.angle_lost, abs=1e-8)


GIVEN = {"grasp": [1.0, 0.2, 0.5], "pronosupination": [0.0, 0.3, 1.0]}


@pytest.mark.parametrize(("given", "radius"), [(GIVEN, 0.01), ({}, 0.06)])
def test_the_elbow_goes_to_the_nearest_free_arm_angle(arm, given, radius):
    task = srs_ik.Task(**TASK, **given)
    plain = arm.solve_task(task)
    assert plain
    scene = at_elbow(arm, plain, radius)
    moved = arm.solve_task(task, scene=scene)
    assert moved.status is srs_ik.Status.OK
    assert clearance(arm, arm.tables(scene), plain.q) < 0.0
    assert clearance(arm, arm.tables(scene), moved.q) >= -1e-9
    wanted = plain.posture.arm_angle
    free = arm.intervals(moved.T_base_tip, scene=scene)
    ends = [end for each in free for end in (each.lower, each.upper)]
    nearest = min(abs(np.remainder(end - wanted + np.pi, 2 * np.pi) - np.pi) for end in ends)
    assert not any(wanted in each for each in free)
    assert moved.angle_lost == pytest.approx(nearest, abs=1e-6)
    assert arm.verify(moved.T_base_tip, moved.q)[0] < 1e-9
    assert "deg from where the task wants it" in moved.message


def test_a_free_roll_gives_way(arm):
    task = srs_ik.Task(**TASK, grasp=[1.0, 0.2, 0.0])
    plain = arm.solve_task(task)
    assert plain
    rolled = arm.solve_task(task, scene=srs_ik.Scene())
    grasp = rolled.T_base_tip[:3, :3].T @ plain.posture.direction
    scene = at_elbow(arm, plain)
    moved = arm.solve_task(task, scene=scene)
    assert moved
    assert np.abs(moved.T_base_tip[:3, :3].T @ plain.posture.direction - grasp).max() < 1e-9


def test_a_task_inside_of_an_object_says_what_it_hits(arm):
    task = srs_ik.Task(**TASK)
    scene = srs_ik.Scene()
    scene.add_sphere("melon", TASK["position"], 0.03)
    found = arm.solve_task(task, scene=scene)
    assert found.status is srs_ik.Status.COLLISION
    assert found.collision.second == "melon"
    assert "melon" in found.message


def test_many_tasks(arm):
    positions = np.array([TASK["position"], [0.25, 0.2, 0.0], [0.3, 0.15, -0.1]])
    task = srs_ik.Task(positions, TASK["velocity"], TASK["force"])
    scene = srs_ik.Scene()
    scene.add_sphere("melon", TASK["position"], 0.03)
    many = arm.solve_task(task, scene=scene)
    for i, position in enumerate(positions):
        one = arm.solve_task(srs_ik.Task(position, TASK["velocity"], TASK["force"]), scene=scene)
        assert many.status[i] == one.status
        assert np.abs(many[i].q - one.q).max() < 1e-9
        assert (many[i].collision is None) == (one.collision is None)


def test_the_command(arm, tmp_path):
    (tmp_path / "scene.json").write_text('{"objects": []}')
    words = [str(x) for x in ("--xyz", *TASK["position"], "--velocity", *TASK["velocity"], "--force", *TASK["force"])]
    found = answer("task", "human_arm", *words, "--scene", str(tmp_path / "scene.json"))
    assert np.allclose(found["q"], arm.solve_task(srs_ik.Task(**TASK), scene=srs_ik.Scene()).q, atol=1e-9)
    melon = {"objects": [{"name": "melon", "sphere": 0.03, "xyz": TASK["position"]}]}
    (tmp_path / "melon.json").write_text(json.dumps(melon))
    hit = answer("task", "human_arm", *words, "--scene", str(tmp_path / "melon.json"), exit_code=1)
    assert hit["collision"]["second"] == "melon"
