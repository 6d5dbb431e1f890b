"""Statuses that tell the truth, and the answers as objects."""

import copy
import itertools
import json
import pickle

import arms
import numpy as np
import pytest
from hypothesis import given
from oracles import distance, inside, limbs

import srs_ik
from srs_ik import Solution, Solutions, Status

STRETCHABLE = arms.here("iiwa14", "human_arm", "sia5d", "openarm_left", "med7")


def reach(limb):
    """Smallest and largest distance from shoulder to wrist centre, by turning the forearm about axis 4."""
    a4, S, E, W = limb.axes[3], limb.shoulder, limb.elbow, limb.wrist
    along = a4 @ (W - S)
    upper_arm, forearm = (np.linalg.norm(np.cross(a4, p - E)) for p in (S, W))
    return np.hypot(upper_arm - forearm, along), np.hypot(upper_arm + forearm, along)


def moved(forward, limb, q, wrist):
    """The pose of a configuration, shifted so that the wrist centre comes to a point."""
    pose = forward(q)
    pose.translation = pose.translation + wrist - forward.carried(q, 7, limb.wrist)
    return pose


def truthful(arm, forward, pose, solution):
    assert np.isfinite(solution.q).all()
    position, orientation = distance(pose, forward(solution.q))
    assert solution.position_error == pytest.approx(position, rel=1e-9, abs=1e-12)
    assert solution.orientation_error == pytest.approx(orientation, rel=1e-9, abs=1e-12)
    verified = arm.verify(pose, solution.q)
    assert verified.position == pytest.approx(position, rel=1e-9, abs=1e-12)
    assert verified.orientation == pytest.approx(orientation, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("name", STRETCHABLE)
def test_out_of_reach_stretches_the_arm_towards_the_target(name):
    arm, forward = arms.load(name), arms.forward(name)
    S, rng = arm.limb.shoulder, arms.generator(name, 71)
    _, farthest = reach(arm.limb)
    for q in arms.configurations(name, 20, 72):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        beyond = 10.0 ** rng.uniform(-6.0, 1.0)
        pose = moved(forward, arm.limb, q, S + direction * (farthest + beyond))
        for options in ({}, {"arm_angle": 0.4}, {"seed": q}, {"branch": 2}):
            solution = arm.solve(pose, respect_limits=False, **options)
            assert solution.status is Status.UNREACHABLE
            assert not solution
            truthful(arm, forward, pose, solution)
            assert solution.position_error == pytest.approx(beyond, rel=1e-6, abs=1e-9)
            assert solution.orientation_error < 1e-9
            wrist = forward.carried(solution.q, 7, arm.limb.wrist)
            assert np.linalg.norm(wrist - S - direction * farthest) < 1e-7
            assert "stretched" in solution.message


@pytest.mark.parametrize("name", ["human_arm", "iiwa14"])
def test_too_close_folds_the_arm(name):
    arm, forward = arms.load(name), arms.forward(name)
    S, rng = arm.limb.shoulder, arms.generator(name, 73)
    nearest, _ = reach(arm.limb)
    assert nearest > 0.01
    for q in arms.configurations(name, 20, 74):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        inwards = nearest * rng.uniform(0.01, 0.99)
        pose = moved(forward, arm.limb, q, S + direction * (nearest - inwards))
        for options in ({}, {"arm_angle": -2.0}, {"seed": q}):
            solution = arm.solve(pose, respect_limits=False, **options)
            assert solution.status is Status.UNREACHABLE
            truthful(arm, forward, pose, solution)
            assert solution.position_error == pytest.approx(inwards, rel=1e-6)
            assert solution.orientation_error < 1e-9
            assert "folded" in solution.message


@pytest.mark.parametrize("name", ["iiwa14", "human_arm", "gen3"])
def test_a_target_in_the_shoulder_itself_is_answered(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 5, 75):
        pose = moved(forward, arm.limb, q, arm.limb.shoulder)
        for options in ({}, {"arm_angle": 1.0}, {"seed": q}, {"respect_limits": False}):
            solution = arm.solve(pose, **options)
            assert solution.status is Status.UNREACHABLE
            truthful(arm, forward, pose, solution)
            assert np.isfinite(solution.arm_angle)


@pytest.mark.parametrize("name", arms.EVERY)
def test_out_of_reach_with_limits_stays_inside_them(name):
    arm, forward = arms.load(name), arms.forward(name)
    _, farthest = reach(arm.limb)
    for q in arms.configurations(name, 5, 76):
        wrist = forward.carried(q, 7, arm.limb.wrist) - arm.limb.shoulder
        pose = moved(forward, arm.limb, q, arm.limb.shoulder + wrist / np.linalg.norm(wrist) * 1.5 * farthest)
        for options in ({}, {"arm_angle": 0.4}, {"seed": q}):
            solution = arm.solve(pose, **options)
            assert solution.status is Status.UNREACHABLE
            assert inside(solution.q, arm.lower, arm.upper)
            truthful(arm, forward, pose, solution)
            assert solution.position_error > 1e-9


@pytest.mark.parametrize("name", STRETCHABLE)
def test_just_within_reach_is_reached(name):
    arm, forward = arms.load(name), arms.forward(name)
    _, farthest = reach(arm.limb)
    for q in arms.configurations(name, 10, 77):
        for short in (0.0, 1e-15, 1e-12, 1e-9, 1e-6):
            wrist = forward.carried(q, 7, arm.limb.wrist) - arm.limb.shoulder
            wrist = arm.limb.shoulder + wrist / np.linalg.norm(wrist) * (farthest - short)
            solution = arm.solve(moved(forward, arm.limb, q, wrist), respect_limits=False)
            assert solution.status is Status.OK


def test_a_blocked_elbow_is_named():
    arm, forward = arms.load("iiwa14"), arms.forward("iiwa14")
    for q in arms.configurations("iiwa14", 20, 78):
        q[3] = arm.upper[3] + 0.4
        pose = forward(q)
        for options in ({}, {"seed": q}, {"arm_angle": arm.arm_angle(q)}):
            solution = arm.solve(pose, **options)
            assert solution.status is Status.OUT_OF_LIMITS
            assert inside(solution.q, arm.lower, arm.upper)
            assert abs(solution.q[3]) == pytest.approx(arm.upper[3])
            assert arm.joint_names[3] in solution.message
            truthful(arm, forward, pose, solution)
        assert arm.solve(pose, respect_limits=False).status is Status.OK
        every = arm.solve_all(pose)
        assert len(every) == 0
        assert every.failure.status is Status.OUT_OF_LIMITS
        assert arm.joint_names[3] in every.message


@pytest.mark.parametrize("name", arms.EVERY)
def test_out_of_limits_is_inside_the_limits_and_truthful(name):
    arm, forward = arms.load(name), arms.forward(name)
    if np.isinf(arm.upper).all():
        pytest.skip("no limits")
    for q in arms.generator(name, 79).uniform(-np.pi, np.pi, (30, 7)):
        pose = forward(q)
        solution = arm.solve(pose)
        assert solution.status in (Status.OK, Status.OUT_OF_LIMITS)
        assert inside(solution.q, arm.lower, arm.upper)
        truthful(arm, forward, pose, solution)
        if not solution:
            assert any(joint in solution.message for joint in arm.joint_names)
            on_limit = np.minimum(np.abs(solution.q - arm.lower), np.abs(solution.q - arm.upper)) < 1e-12
            assert on_limit.any()


def test_the_message_names_what_else_than_the_pose_was_asked_for():
    """Postures of the pose there are, as Pinocchio says, but none at this arm angle, or in this branch."""
    arm = arms.load("human_arm")
    pose = arm.forward_kinematics(0.5 * (arm.lower + arm.upper))
    found = arm.intervals(pose)
    psi = next(psi for psi in np.linspace(-np.pi, np.pi, 400) if not any(psi in interval for interval in found))
    for asked, words in (
        ({"arm_angle": psi}, "no posture at the arm angle asked for was found"),
        ({"arm_angle": psi, "branch": 0}, "no posture in the branch and at the arm angle asked for was found"),
    ):
        solution = arm.solve(pose, **asked)
        assert solution.status == "OUT_OF_LIMITS"
        assert words in solution.message
        assert arm.solve_batch([pose], **asked).message(0) == solution.message
        assert arm.solve(pose, scene=srs_ik.Scene(), **asked).message == solution.message
    assert "asked for" not in arm.solve(pose).message


@given(limbs(limits=("narrow", "usual", "beyond", "mixed")))
def test_statuses_of_random_limbs(limb):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    for _ in range(3):
        pose = arm.forward_kinematics(limb.rng.uniform(-np.pi, np.pi, 7))
        solution = arm.solve(pose)
        assert inside(solution.q, arm.lower, arm.upper)
        assert bool(solution) == (max(solution.position_error, solution.orientation_error) < 1e-9)
        assert solution.status is (Status.OK if arm.intervals(pose) else Status.OUT_OF_LIMITS)


def test_fields_of_a_solution():
    arm = arms.load("iiwa14")
    q = np.array([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0])
    solution = arm.solve(arm.forward_kinematics(q), seed=q)
    assert isinstance(solution, Solution)
    assert solution.q.shape == (7,)
    assert solution.q.dtype == np.float64
    assert type(solution.status) is Status
    assert type(solution.branch) is int
    assert type(solution.arm_angle) is type(solution.position_error) is type(solution.orientation_error) is float
    assert solution.as_dict() == dict(zip(arm.joint_names, solution.q, strict=True))
    assert bool(solution) is True
    assert "status=OK" in repr(solution)
    assert solution.message.endswith(".")


def test_solutions_do_not_share_memory():
    arm = arms.load("iiwa14")
    pose = arm.forward_kinematics([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0])
    first, second = arm.solve(pose), arm.solve(pose)
    before = second.q.copy()
    first.q[:] = 9.0
    assert (second.q == before).all()
    assert (arm.solve(pose).q == before).all()


def test_solutions_are_a_sequence_over_arrays():
    arm = arms.load("iiwa14")
    every = arm.solve_all(arm.forward_kinematics([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0]), arm_angle=0.1)
    assert isinstance(every, Solutions)
    assert len(every) == len(list(every)) == len(every.q) > 1
    assert every.q.shape == (len(every), 7)
    for k, (solution, index) in enumerate(zip(every, itertools.count(), strict=False)):
        assert k == index
        assert isinstance(solution, Solution)
        assert (solution.q == every.q[k]).all()
        assert solution.branch == every[k].branch == every.branch[k]
        assert solution.arm_angle == every.arm_angle[k]
        assert solution.position_error == every.position_error[k]
        assert solution.orientation_error == every.orientation_error[k]
    assert (every[-1].q == every.q[-1]).all()
    assert (every[1:].q == every.q[1:]).all()
    assert every.ok.all()
    assert every.failure is None
    assert str(len(every)) in every.message
    with pytest.raises(IndexError):
        every[len(every)]


def test_an_empty_answer_says_why():
    arm = arms.load("iiwa14")
    pose = arm.forward_kinematics(np.zeros(7))
    pose.translation = pose.translation + np.array([0.0, 0.0, 1.0])
    for options in ({}, {"arm_angle": 0.0}, {"respect_limits": False}):
        every = arm.solve_all(pose, **options)
        assert len(every) == 0
        assert every.q.shape == (0, 7)
        assert not every
        assert "stretched" in every.message
        assert every.failure.status is Status.UNREACHABLE


def test_an_empty_answer_does_not_claim_success():
    """One of the arms whose axes miss, next to two singular middle joints."""
    arm = arms.load("gen3")
    q = np.array([1.9401181, -1e-4, 2.78371618, -0.432684987, 2.29682504, 1e-4, -1.06067838])
    pose, psi = arm.forward_kinematics(q), arm.arm_angle(q)
    every = arm.solve_all(pose, arm_angle=psi, respect_limits=False)
    assert bool(every) == bool(arm.solve(pose, arm_angle=psi, respect_limits=False))
    assert every.failure is None or not every.failure


def test_statuses_are_numbers_and_names():
    assert [(s.name, int(s)) for s in Status] == [("OK", 0), ("UNREACHABLE", 1), ("OUT_OF_LIMITS", 2), ("COLLISION", 3)]
    assert (str(Status.OK), f"{Status.UNREACHABLE}", f"{Status.OUT_OF_LIMITS:>14}") == (
        "OK",
        "UNREACHABLE",
        " OUT_OF_LIMITS",
    )
    assert Status.OK == 0


@pytest.mark.parametrize("status", Status)
def test_a_status_is_equal_to_its_name_and_to_its_number(status):
    others = [name for name in Status.__members__ if name != status.name]
    assert status == status.name
    assert status.name == status
    assert not status != status.name  # noqa: SIM202 (another method)
    assert not any(status == name for name in (*others, status.name.lower(), ""))
    assert all(name != status for name in others)
    assert status in [status.name]
    assert status == int(status) == np.int64(status)
    assert status != int(status) + 1
    # What it is equal to in an array finds it in a dictionary.
    assert hash(status) == hash(int(status))
    assert {int(status): 1}[status] == {status: 1}[int(status)] == 1
    assert (np.array([0, 1, 2]) == status).tolist() == [k == int(status) for k in range(3)]
    assert copy.deepcopy(status) is pickle.loads(pickle.dumps(status)) is status
    assert json.loads(json.dumps([status])) == [int(status)]


@pytest.mark.parametrize("status", [*Status, *srs_ik.TrackerStatus])
def test_a_status_alone_is_neither_true_nor_false(status):
    of, whole = ("Status", "solution") if isinstance(status, Status) else ("TrackerStatus", "step")
    with pytest.raises(TypeError, match=rf"compare it with {of}\.OK, or test the {whole}"):
        bool(status)


@pytest.mark.parametrize("all_branches", [False, True])
def test_a_table_says_what_became_of_each_answer(all_branches):
    arm = srs_ik.load("iiwa14")
    poses = arm.forward_kinematics_batch(np.full((3, 7), 0.4))
    poses[1, :3, 3] = 5.0
    found = arm.solve_batch(poses, 0.3, all_branches=all_branches)
    table = found.as_table()
    assert list(table) == [*arm.joint_names, *["status", "branch", "arm_angle", "position_error", "orientation_error"]]
    flat = found.q.reshape(-1, 7)
    for k, solution in enumerate(found[i] for i in np.ndindex(found.status.shape)):
        assert table["status"][k] == solution.status.name
        assert [table[name][k] for name in arm.joint_names] == flat[k].tolist() == solution.q.tolist()
        assert table["position_error"][k] == solution.position_error
    assert "UNREACHABLE" in table["status"]


def test_postures_are_picked_by_masks_and_numbers():
    arm = arms.load("iiwa14")
    found = arm.solve_all(arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]))
    negative = found.q[:, 3] < 0.0
    assert 0 < negative.sum() < len(found)
    for index in (negative, np.flatnonzero(negative), np.flatnonzero(negative).tolist()):
        picked = found[index]
        assert isinstance(picked, Solutions)
        assert np.array_equal(picked.q, found.q[negative])
        assert [each.branch for each in picked] == picked.branch.tolist()
    assert not found[[False] * len(found)]
    assert isinstance(found[np.int64(1)], Solution)
    with pytest.raises(IndexError):
        found[0, 1]
