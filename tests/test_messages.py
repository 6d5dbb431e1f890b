"""What an answer says about itself in one sentence is true of it."""

import re

import numpy as np
import pytest

import srs_ik
from srs_ik import Status
from srs_ik.solve.solution import Solution

STRAIGHT_POSE = [0.3, 0.7, -0.4, 0.0, 0.5, 0.8, -0.2]


@pytest.fixture(scope="module")
def iiwa():
    return srs_ik.load("iiwa14")


def figures(message: str, unit: str) -> list[float]:
    return [float(word) for word in re.findall(rf"([\d.e+-]+) {unit}\b", message)]


def wrist_in_the_shoulder(arm) -> np.ndarray:
    pose = arm.limb.T_base_tip_zero.copy()
    pose[:3, 3] += arm.limb.shoulder - arm.limb.wrist
    return pose


def test_too_far_is_stretched(iiwa):
    pose = iiwa.forward_kinematics(STRAIGHT_POSE)
    pose.translation = 2.0 * pose.translation
    solution = iiwa.solve(pose)
    assert solution.status is Status.UNREACHABLE
    assert abs(solution.q[3]) < 1e-6
    assert "stretched" in solution.message
    assert figures(solution.message, "m") == pytest.approx([solution.position_error], rel=1e-2)


def test_too_near_is_folded_as_far_as_the_elbow_goes(iiwa):
    pose = wrist_in_the_shoulder(iiwa)
    solution = iiwa.solve(pose)
    assert solution.status is Status.UNREACHABLE
    assert abs(solution.q[3]) == pytest.approx(np.deg2rad(120.0), abs=1e-5)
    assert f"folded as far as {iiwa.joint_names[3]} goes" in solution.message
    assert abs(figures(solution.message.replace("(", ""), "deg")[0]) == pytest.approx(120.0, abs=1e-3)


def test_too_near_without_limits_is_folded(iiwa):
    pose = wrist_in_the_shoulder(iiwa)
    solution = iiwa.solve(pose, respect_limits=False)
    assert solution.status is Status.UNREACHABLE
    assert "with the arm folded, misses it by 0.02 m" in solution.message


@pytest.mark.parametrize("name", ["iiwa14", "human_arm", "gen3"])
def test_out_of_limits_names_a_joint_that_stands_at_its_limit(name):
    arm = srs_ik.load(name)
    rng = np.random.default_rng(5)
    seen = 0
    for _ in range(40):
        solution = arm.solve(arm.forward_kinematics(rng.uniform(-np.pi, np.pi, 7)))
        if solution.status is not Status.OUT_OF_LIMITS:
            continue
        seen += 1
        (joint,) = (i for i, joint in enumerate(arm.joint_names) if f"{joint} stops at" in solution.message)
        angle = solution.q[joint]
        assert min(abs(angle - arm.lower[joint]), abs(angle - arm.upper[joint])) < 1e-12
        assert figures(solution.message, "deg") == pytest.approx([np.rad2deg(angle)], rel=1e-5)
        assert max(solution.position_error, solution.orientation_error) > 1e-9
    assert seen


def test_errors_that_are_only_rounding_are_not_named(iiwa):
    row = iiwa.solve(iiwa.forward_kinematics(STRAIGHT_POSE))._row.copy()
    row[7:9] = 1e-16, 0.25
    row[10], row[12] = Status.OUT_OF_LIMITS, 6
    assert Solution(row, iiwa.joint_names).message.endswith("misses it by 0.25 rad.")


def test_an_answer_without_a_known_elbow_does_not_say_how_the_arm_lies(iiwa):
    row = iiwa.solve(iiwa.forward_kinematics(STRAIGHT_POSE))._row.copy()
    row[7], row[10] = 0.5, Status.UNREACHABLE
    assert "stretched" in Solution(row, iiwa.joint_names, iiwa.packed.elbow).message
    assert "stretched" not in Solution(row, iiwa.joint_names).message


def test_solved_says_where(iiwa):
    solution = iiwa.solve(iiwa.forward_kinematics(STRAIGHT_POSE), respect_limits=False, arm_angle=0.4)
    assert f"branch {solution.branch} at arm angle 0.4 rad" in solution.message


def test_many_answers_speak_like_one(iiwa):
    pose = iiwa.forward_kinematics(STRAIGHT_POSE)
    far = pose.copy()
    far.translation = 2.0 * pose.translation
    none = iiwa.solve_all(far)
    assert len(none) == 0
    assert none.message == iiwa.solve(far).message
    assert iiwa.solve_batch([pose, far]).message(1) == none.message
    one = iiwa.solve_all(pose, arm_angle=0.4)[:1]
    assert one.message == "1 posture found."


@pytest.mark.parametrize("name", ["human_arm", "gen3"])
def test_where_one_posture_is_found_the_list_of_all_is_not_empty(name):
    """At several limits at once an interval has no width, and rounding decides whether it is there."""
    arm = srs_ik.load(name)
    rng = np.random.default_rng(1)
    lower, upper = (np.clip(limit, -3.0, 3.0) for limit in (arm.lower, arm.upper))
    solved = 0
    for _ in range(60):
        pose = arm.forward_kinematics(np.where(rng.random(7) < 0.5, lower, upper))
        found = arm.solve_all(pose)
        assert len(found) > 0 or not arm.solve(pose)
        assert found.failure is None or not found.failure
        assert found.ok.all()
        solved += len(found) > 0
    assert solved
