"""Postures whose elbow is where it is wanted, against postures on the whole self-motion that Pinocchio tells of."""

import pickle

import arms
import numpy as np
import pytest
from command_line import answer, run
from hypothesis import given
from oracles import arm_angle, distance, inside, limbs, postures_by_steps, wrapped

import srs_ik
from srs_ik import InvalidConfiguration, Status

EXACT = ("iiwa14", "human_arm", "made_offsets", "made_bent")
NEAR = ("gen3", "made_near", "made_oblique")
SAME = 1e-9
"""Two elbows closer than this, m, are one."""


def elbow_of(name, q):
    """The elbow centre at q: a point that axis 4 carries, by the robot's own file."""
    return arms.forward(name).carried(q, 4, arms.load(name).limb.elbow)


@pytest.mark.parametrize("name", arms.EVERY)
def test_centres_are_where_the_robot_carries_them(name):
    arm, forward = arms.load(name), arms.forward(name)
    q = arms.configurations(name, 20, 401)
    many = arm.centres(q)
    for i, each in enumerate(q):
        places = (arm.limb.shoulder, forward.carried(each, 4, arm.limb.elbow), forward.carried(each, 7, arm.limb.wrist))
        for one, several, place in zip(arm.centres(each), many, places, strict=True):
            assert one == pytest.approx(place, abs=1e-12)
            assert several[i] == pytest.approx(place, abs=1e-12)
    for wrong in ([0.0] * 6, [[0.0] * 7, [0.0] * 6]):
        with pytest.raises(InvalidConfiguration, match="7 joint angles"):
            arm.centres(wrong)


@pytest.mark.parametrize("name", EXACT + NEAR)
def test_a_measured_elbow_is_met_and_the_seed_chooses_among_its_postures(name):
    arm = arms.load(name)
    for q in arms.configurations(name, 40, 402):
        pose, elbow = arm.forward_kinematics(q), elbow_of(name, q)
        found = arm.solve(pose, elbow=elbow)
        assert found
        assert max(distance(pose, arm.forward_kinematics(found.q))) < 1e-9
        if name in EXACT:
            assert elbow_of(name, found.q) == pytest.approx(elbow, abs=1e-8)
        angles = [arm_angle(arms.forward(name), arm.limb, p) for p in (found.q, q)]
        assert abs(wrapped(angles[0] - angles[1])) < 1e-7
        nearest = arm.solve(pose, elbow=elbow, seed=q)
        assert np.abs(wrapped(nearest.q - q)).max() < 1e-5
        assert arm.solve(pose, elbow=arm.arm_angle(q), seed=q).q == pytest.approx(nearest.q, abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("name", EXACT)
def test_no_posture_within_limits_has_its_elbow_nearer_to_a_point(name):
    arm, rng = arms.load(name), np.random.default_rng(403)
    pushed = 0
    for q in arms.configurations(name, 12, 403):
        pose = arm.forward_kinematics(q)
        point = elbow_of(name, q) + rng.normal(size=3) * 0.3
        found = arm.solve(pose, elbow=point)
        assert found
        assert inside(found.q, arm.lower, arm.upper)
        least = np.linalg.norm(elbow_of(name, found.q) - point)
        postures, _ = postures_by_steps(arm, pose, q)
        allowed = [p for p in postures if inside(p, arm.lower, arm.upper)]
        assert allowed
        assert least <= min(np.linalg.norm(elbow_of(name, p) - point) for p in allowed) + SAME
        pushed += least > min(np.linalg.norm(elbow_of(name, p) - point) for p in postures) + 1e-3
    assert pushed or name == "made_offsets"  # whose limits are wide


@given(limbs(limits=("usual", "narrow", "mixed")))
def test_the_nearest_feasible_elbow_of_random_limbs(limb):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    for _ in range(3):
        q = limb.configuration()
        pose = arm.forward_kinematics(q)
        point = arm.centres(q).elbow + limb.rng.normal(size=3) * 0.2
        found = arm.solve(pose, elbow=point, seed=q)
        assert found
        assert inside(found.q, arm.lower, arm.upper)
        # q is one of those that the nearest one was chosen from.
        own = np.linalg.norm(arm.centres(q).elbow - point)
        assert np.linalg.norm(arm.centres(found.q).elbow - point) <= own + 1e-7


@pytest.mark.parametrize("name", EXACT + NEAR)
def test_limits_that_may_be_left_leave_the_elbow_alone(name):
    arm, rng = arms.load(name), np.random.default_rng(404)
    for q in arms.configurations(name, 10, 404):
        psi = rng.uniform(-np.pi, np.pi)
        found = arm.solve(arm.forward_kinematics(q), elbow=psi, respect_limits=False)
        strict = arm.solve(arm.forward_kinematics(q), arm_angle=psi, respect_limits=False)
        if strict:
            assert found.q == pytest.approx(strict.q)


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_a_branch_that_is_asked_for_is_kept(name):
    arm = arms.load(name)
    for q in arms.configurations(name, 10, 405):
        pose = arm.forward_kinematics(q)
        for branch in range(8):
            found = arm.solve(pose, elbow=[0.3, 0.4, 0.5], branch=branch)
            assert bool(found) == bool(arm.solve(pose, branch=branch))
            assert not found or found.branch == branch


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_many_at_once_are_the_same(name):
    arm, rng = arms.load(name), np.random.default_rng(406)
    q = arms.configurations(name, 50, 406)
    poses, points = arm.forward_kinematics_batch(q), rng.normal(size=(50, 3)) * 0.5
    each = arm.solve_batch(poses, elbow=points, seed=q)
    for i in range(50):
        assert np.array_equal(each.q[i], arm.solve(poses[i], elbow=points[i], seed=q[i]).q)
    same = arm.solve_batch(poses, elbow=points[0], threads=2)
    assert np.array_equal(same.q[7], arm.solve(poses[7], elbow=points[0]).q)
    assert np.array_equal(arm.solve_batch(poses, elbow=0.4).q[3], arm.solve(poses[3], elbow=0.4).q)


def test_where_the_elbow_has_no_say_it_is_as_without():
    arm = arms.load("iiwa14")
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose = arm.forward_kinematics(q)
    shoulder, _, wrist = arm.centres(q)
    assert np.array_equal(arm.solve(pose, elbow=0.5 * (shoulder + wrist)).q, arm.solve(pose).q)
    far = pose.copy()
    far.translation = np.array([3.0, 0.0, 0.0])
    away = arm.solve(far, elbow=[0.0, 1.0, 0.5], seed=q)
    assert away.status is Status.UNREACHABLE
    assert np.array_equal(away.q, arm.solve(far, seed=q).q)


def test_in_a_scene_the_elbow_is_as_near_as_the_obstacle_leaves():
    arm = arms.load("iiwa14")
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose, elbow = arm.forward_kinematics(q), arm.centres(q).elbow
    scene = srs_ik.Scene()
    scene.add_sphere("ball", elbow, 0.05)
    found = arm.solve(pose, elbow=elbow, seed=q, scene=scene)
    assert found
    free = arm.intervals(pose, scene=scene)
    ends = np.array([[i.lower, i.upper] for i in free])
    gaps = np.abs(wrapped(ends - arm.arm_angle(q)))
    assert abs(wrapped(found.arm_angle - arm.arm_angle(q))) == pytest.approx(gaps.min(), abs=1e-7)
    assert gaps.min() > 0.05
    many = arm.solve_batch([pose, pose], elbow=elbow, seed=q, scene=scene)
    assert np.array_equal(many.q[1], found.q)


def test_where_spheres_leave_nothing_the_real_shapes_decide():
    arm, rng = arms.load("iiwa14"), np.random.default_rng(0)
    scene = srs_ik.Scene()
    for k in range(8):
        scene.add_sphere(f"s{k}", rng.uniform([-0.6, -0.6, 0.1], [0.6, 0.6, 1.2]), 0.08)
    pose = arm.forward_kinematics([0.685, -0.487, 2.951, 2.014, 1.101, 0.630, 1.151])
    assert arm.solve(pose, arm_angle=0.18, scene=scene)
    assert arm.solve(pose, elbow=0.18, scene=scene).arm_angle == pytest.approx(0.18)
    many = arm.solve_batch([pose, pose], elbow=0.18, scene=scene)
    assert many.arm_angle == pytest.approx(0.18)
    with pytest.raises(srs_ik.InvalidPose, match="pose 1 of 2"):
        arm.solve_batch(np.array([pose.homogeneous, np.zeros((4, 4))]), elbow=0.3, scene=scene)


def test_a_tracker_takes_the_elbow_to_a_point_that_moves():
    arm = arms.load("iiwa14")
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose = arm.forward_kinematics(q)
    wanted = arm.solve(pose, arm_angle=arm.arm_angle(q) + 0.4, seed=q)
    tracker = arm.tracker(q, 0.01, elbow=arm.centres(wanted.q).elbow)
    for _ in range(200):
        step = tracker.update(pose)
        assert step
    assert arm.centres(step.q).elbow == pytest.approx(arm.centres(wanted.q).elbow, abs=1e-3)
    tracker = pickle.loads(pickle.dumps(tracker))
    for k in range(300):
        tracker.elbow = arm.centres(
            arm.solve(pose, arm_angle=wanted.arm_angle - 0.4 * min(k, 200) / 200, seed=q).q
        ).elbow
        assert tracker.update(pose)
    assert arm.centres(tracker.q).elbow == pytest.approx(arm.centres(q).elbow, abs=1e-3)


@pytest.mark.parametrize(
    ("elbow", "words"),
    [
        ([0.1, 0.2], r"a point \(3,\), m, or an arm angle, rad, not \[0.1, 0.2\]"),
        ("up", "arm angle"),
        (np.zeros((4, 3)), "not an array of shape"),
        ([np.nan, 0.0, 0.0], "finite numbers"),
        ([1e7, 0.0, 0.0], "up to 1e\\+06 m"),
    ],
)
def test_what_is_no_elbow_is_refused(elbow, words):
    arm = arms.load("iiwa14")
    with pytest.raises(InvalidConfiguration, match=words):
        arm.solve(np.eye(4), elbow=elbow)
    with pytest.raises(InvalidConfiguration, match="elbow does not go with arm_angle"):
        arm.solve(np.eye(4), arm_angle=0.1, elbow=[0.1, 0.2, 0.3])
    with pytest.raises(InvalidConfiguration, match="elbow goes with one branch for all poses"):
        arm.solve_batch([np.eye(4)] * 2, elbow=[0.1, 0.2, 0.3], branch=[0, 1])


def test_the_command_line_takes_a_point():
    arm = arms.load("iiwa14")
    q = [0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]
    pose = ["--q", *map(str, q)]
    found = answer("solve", "iiwa14", *pose, "--elbow", "0.1", "0.4", "0.6", "--seed", *map(str, q))
    expected = arm.solve(arm.forward_kinematics(q), elbow=[0.1, 0.4, 0.6], seed=q)
    assert found["q"] == pytest.approx(expected.q, abs=1e-6)
    refused = run("solve", "iiwa14", *pose, "--elbow", "0.1", "0.4", "0.6", "--arm-angle", "0.1")
    assert refused.exit_code == 2
    assert "--elbow goes with none of --arm-angle" in refused.stderr
