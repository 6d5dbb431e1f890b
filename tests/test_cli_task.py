"""`srs-ik task`: what it prints is what the package answers, and wrong words are told in one line."""

import arms
import numpy as np
import pytest
from command_line import answer, pose_by_pinocchio, run

from srs_ik import Task

TASK = ["--xyz", "0.4", "0.1", "-0.2", "--velocity", "1", "0", "0", "--force", "0", "0", "1"]
HELD = [*TASK, "--grasp", "1", "0", "0", "--pronosupination", "0", "-0.4", "1"]


@pytest.mark.parametrize("side", ["left", "right"])
def test_json_is_the_answer_of_the_package(side):
    found = answer("task", "human_arm", *TASK, "--grasp", "1", "0", "0", "--side", side)
    solution = arms.load("human_arm").solve_task(Task([0.4, 0.1, -0.2], [1, 0, 0], [0, 0, 1], [1, 0, 0]), side)
    assert found["q"] == solution.q.tolist()
    assert found["angle_lost"] == solution.angle_lost
    assert found["side"] == side
    posture = found["posture"]
    for name in ("shoulder", "elbow", "wrist", "hand", "normal", "task_normal", "direction"):
        assert posture[name] == getattr(solution.posture, name).tolist()
    assert posture["reached"] is True
    reached = pose_by_pinocchio("human_arm", found["q"])
    assert np.allclose(reached, found["T_base_tip"], rtol=0.0, atol=1e-11)
    assert reached[:3, 3] == pytest.approx([0.4, 0.1, -0.2], abs=1e-11)


def test_the_roll_and_the_limits_can_be_left_out():
    held = answer("task", "human_arm", *HELD, "--no-limits")
    assert np.array(held["T_base_tip"])[:3, 2] == pytest.approx(np.array([0, -0.4, 1]) / np.hypot(0.4, 1.0))
    assert held["angle_lost"] == 0.0
    upper = answer("task", "human_arm", *HELD[:4], *TASK[4:], "--tie", "upper", "--no-limits")
    assert upper["status"] == "OK"


def test_a_seed_chooses_the_branch():
    words = ["task", "iiwa14", "--xyz", "0.5", "0.1", "0.6", *TASK[4:], "--grasp", "0", "0", "-1", "--no-limits"]
    task = Task([0.5, 0.1, 0.6], [1, 0, 0], [0, 0, 1], [0, 0, -1])
    plain = answer(*words)
    # Axis 2 mirrored, axes 1 and 3 turned by half a turn: the other shoulder of the same posture.
    seed = np.array(plain["q"]) * [1, -1, 1, 1, 1, 1, 1] + np.pi * np.array([1, 0, 1, 0, 0, 0, 0])
    found = answer(*words, "--seed", *map(str, seed))
    assert found["branch"] == plain["branch"] ^ 2
    assert found["q"] == pytest.approx(seed, abs=1e-8)
    assert found["q"] == arms.load("iiwa14").solve_task(task, respect_limits=False, seed=seed).q.tolist()
    in_degrees = [str(angle) for angle in np.rad2deg(seed)]
    assert answer(*words, "--seed", *in_degrees, "--degrees")["q"] == pytest.approx(seed, abs=1e-8)
    assert "Then add --degrees" in run(*words, "--seed", *in_degrees).stderr
    result = run(*words, "--seed", *"1234567"[:6], "x")
    assert (result.exit_code, "--seed" in result.stderr) == (2, True)


def test_tables_name_the_points_and_the_joints():
    result = run("task", "iiwa14", "--xyz", "0.5", "0.1", "0.6", *TASK[4:], "--grasp", "0", "0", "-1")
    assert result.exit_code == 0
    for word in (
        "shoulder",
        "elbow",
        "wrist",
        "hand",
        "iiwa_joint_7",
        "arm angle lost",
        "The hand reaches the target.",
    ):
        assert word in result.stdout


def test_out_of_reach_is_exit_status_1_and_still_an_answer():
    far = ["--xyz", "2", "0", "0", *TASK[4:]]
    found = answer("task", "human_arm", *far, exit_code=1)
    assert found["status"] == "UNREACHABLE"
    assert found["posture"]["miss"] == pytest.approx(2.0 - 0.79)
    result = run("task", "human_arm", *far)
    assert result.exit_code == 1
    assert result.stderr.startswith("srs-ik: UNREACHABLE: ")
    assert result.stderr.count("\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize("name", arms.here("med7"))
def test_a_hand_can_be_given(name):
    _, base, tip = arms.PLACES[name]
    words = ["task", str(arms.file_of(name)), "--base", base, "--tip", tip]
    words += ["--xyz", "0.4", "0.1", "0.5", *TASK[4:], "--grasp", "0", "0", "-1"]
    result = run(*words)
    assert result.exit_code == 2
    assert "hand" in result.stderr
    found = answer(*words, "--hand", "0", "0", "1", "1", "0", "0")
    assert np.array(found["T_base_tip"])[:3, 2] == pytest.approx([0, 0, -1])


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--xyz", "0.4", "0", "0"], "--velocity"),
        (["--xyz", "0.4", "0", *TASK[4:]], "--xyz"),
        ([*TASK[:-1], "up"], "--force"),
        ([*TASK[:-1], "nan"], "--force"),
        ([*TASK[:-1], "0"], "force is zero"),
        ([*TASK, "--grasp", "0", "0", "0"], "grasp is zero"),
        ([*TASK, "--grasp", "0", "0", "1", "--pronosupination", "0", "0", "2"], "parallel"),
        ([*TASK, "--side", "up"], "--side"),
        ([*TASK, "--hand", "1", "0", "0", "1", "0", "0"], "parallel"),
    ],
)
def test_wrong_words_are_named_in_one_line(words, named):
    result = run("task", "human_arm", *words)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.startswith("srs-ik: ")
    assert result.stderr.count("\n") == 1
    assert named in result.stderr
