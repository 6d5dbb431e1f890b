"""`Arm.tracker`: limits are kept whatever comes, targets that can be followed are followed, others are come back from.

Limits are checked on differences of the joint angles that come out, and tips by Pinocchio on the robot's own file.
"""

from copy import deepcopy
from threading import Thread
from types import SimpleNamespace

import arms
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import KINDS, minimum_jerk, motion, off_target, within
from tracked import recoveries

from srs_ik import (
    FreeAxis,
    InvalidConfiguration,
    InvalidPose,
    InvalidTask,
    MissingLimits,
    Objective,
    Scene,
    Task,
    TrackerStatus,
    force_velocity_ratio,
    load,
)

DT = 0.002
ROUNDING = 1e-9
"""Limits are kept to this, rad, rad/s and rad/s^2."""

FOLLOWED = arms.here("iiwa14", "gen3", "human_arm", "made_near", "j2s7s300", "h1_2_left", "openarm_left")


def follow(name, moving, tracker):
    """(n, 7) joint angles and the steps."""
    steps = [tracker.update(T) for T in moving]
    return np.array([step.q for step in steps]), steps


def tracker_of(name, q0, **options):
    arm = arms.load(name)
    known = np.isfinite(arm.velocity_limit) & (arm.velocity_limit > 0.0)
    return arm.tracker(q0, DT, np.where(known, arm.velocity_limit, 2.0), **options)


def assert_limits_kept(name, q0, q, tracker):
    arm = arms.load(name)
    assert np.isfinite(q).all()
    assert (q >= arm.lower).all()
    assert (q <= arm.upper).all()
    from_rest = np.vstack([q0, q0, q])
    velocity = np.diff(from_rest, axis=0) / DT
    acceleration = np.diff(velocity, axis=0) / DT
    assert (np.abs(velocity) <= tracker.velocity_limit + ROUNDING).all()
    assert (np.abs(acceleration) <= tracker.acceleration_limit + ROUNDING).all()


def start(name):
    """A posture well inside the limits, and bent."""
    lower, upper = within(arms.load(name))
    return lower + (upper - lower) * np.array([0.55, 0.6, 0.45, 0.35, 0.6, 0.65, 0.45])


@pytest.mark.parametrize("name", FOLLOWED)
@given(seed=st.integers(0, 10_000), kind=st.sampled_from(KINDS), elbow=st.sampled_from(["keep", 0.5, "limit_margin"]))
def test_limits_are_kept_whatever_comes(name, seed, kind, elbow):
    moving = motion(arms.load(name), seed, 0.6, DT, kind, trouble=True)
    tracker = tracker_of(name, moving.q0, elbow=elbow)
    q, steps = follow(name, moving.given, tracker)
    assert_limits_kept(name, moving.q0, q, tracker)
    for step, target in zip(steps, moving.given, strict=True):
        assert step.message
        assert (step.status == "HELD") or target is not None


@pytest.mark.parametrize("name", FOLLOWED)
def test_slow_motions_of_the_hand_are_followed(name):
    arm, q0 = arms.load(name), start(name)
    T = arm.forward_kinematics(q0).homogeneous
    t = DT * np.arange(1000)
    poses = np.repeat(T[None], len(t), axis=0)
    ramp = 0.02 * minimum_jerk(t / 1.5)
    poses[:, :3, 3] += np.stack([ramp * np.sin(t), ramp * np.cos(2.0 * t), ramp], axis=1)
    tracker = tracker_of(name, q0)
    q, steps = follow(name, poses, tracker)
    position, angle = off_target(arms.forward(name), q, poses)
    assert max(position.max(), angle.max()) < 1e-8
    assert all(steps)
    assert steps[-1].joint is None
    np.testing.assert_allclose(steps[-1].velocity, (q[-1] - q[-2]) / DT, atol=1e-9)


def test_a_far_target_is_come_to_in_the_shortest_time_and_without_passing_it():
    q0 = start("iiwa14")
    arm = arms.load("iiwa14")
    goal = q0 + np.array([0.4, 0.1, -0.1, 0.1, 0.2, -0.1, 0.1])
    tracker = tracker_of("iiwa14", q0)
    q, steps = follow("iiwa14", [arm.forward_kinematics(goal)] * 1500, tracker)
    assert_limits_kept("iiwa14", q0, q, tracker)
    assert steps[-1].status == "OK"
    position, angle = off_target(arms.forward("iiwa14"), q, [arm.forward_kinematics(goal).homogeneous] * len(q))
    assert max(position[-1], angle[-1]) < 1e-8
    arrived = int(np.argmax(position < 1e-3))
    assert position[arrived:].max() < 5e-3


def test_lost_targets_are_expected_to_go_on_and_come_to_rest():
    arm, q0 = arms.load("iiwa14"), start("iiwa14")
    T = arm.forward_kinematics(q0).homogeneous
    tracker = tracker_of("iiwa14", q0)
    assert tracker.update(None).message == "Waiting for the first target."
    for k in range(500):
        T[0, 3] += 1e-4 * min(k / 250.0, 1.0)
        before = tracker.update(T)
    assert before.status == "OK"
    step = tracker.update(None)
    assert step.status == "HELD"
    assert "1 update:" in step.message
    # One sample that is lost is not seen: the tip is where the target is expected.
    T[0, 3] += 1e-4
    assert np.linalg.norm(arms.forward("iiwa14")(step.q).translation - T[:3, 3]) < 1e-6
    for _ in range(1000):
        step = tracker.update(None)
    assert np.abs(step.velocity).max() < 1e-4
    for _ in range(500):
        step = tracker.update(T)
    assert step.status == "OK"


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_out_of_reach_the_arm_stretches_and_comes_back(name):
    arm, q0 = arms.load(name), start(name)
    T = arm.forward_kinematics(q0).homogeneous
    outward = T[:3, 3] - arm.limb.shoulder
    outward /= np.linalg.norm(outward)
    tracker = tracker_of(name, q0)
    t = DT * np.arange(4000)
    poses = np.repeat(T[None], len(t), axis=0)
    # Out by 0.9 m, back, and at rest there.
    poses[:, :3, 3] += 0.9 * (np.sin(np.pi * np.minimum(t / t[3200], 1.0)) ** 2)[:, None] * outward
    q, steps = follow(name, poses, tracker)
    assert_limits_kept(name, q0, q, tracker)
    middle = steps[1600]
    assert middle.status == "UNREACHABLE"
    assert "out of reach" in middle.message
    far = arms.forward(name)(middle.q)
    assert np.linalg.norm(far.translation - poses[1600, :3, 3]) == pytest.approx(middle.position_error, abs=1e-6)
    assert steps[-1].status == "OK"
    position, _ = off_target(arms.forward(name), q[-1:], poses[-1:])
    assert position[0] < 1e-8


def test_what_is_no_pose_holds_the_arm_and_what_has_no_shape_is_refused():
    arm, q0 = arms.load("iiwa14"), start("iiwa14")
    tracker = tracker_of("iiwa14", q0)
    T = arm.forward_kinematics(q0).homogeneous
    tracker.update(T)
    for bad in (np.full((4, 4), np.nan), 2.0 * T):
        step = tracker.update(bad)
        assert step.status == "HELD"
        assert "not finite or no rigid transform" in step.message
        assert np.isfinite(step.q).all()
    with pytest.raises(InvalidPose, match="4 x 4"):
        tracker.update(np.zeros(3))
    assert tracker.update(T).status == "OK"


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_the_elbow_goes_to_the_arm_angle_that_is_asked_for(name):
    arm, q0 = arms.load(name), start(name)
    T = arm.forward_kinematics(q0).homogeneous
    wanted = arm.arm_angle(q0) + 0.5
    tracker = tracker_of(name, q0, elbow=wanted)
    q, steps = follow(name, [T] * 2000, tracker)
    assert_limits_kept(name, q0, q, tracker)
    assert all(steps)
    assert abs(np.sin(arm.arm_angle(q[-1]) - wanted)) < 0.01
    tracker.elbow = "keep"
    q, _ = follow(name, [T] * 500, tracker)
    assert np.ptp(q[-100:], axis=0).max() < 1e-6


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_the_elbow_follows_an_objective(name):
    arm, q0 = arms.load(name), start(name)
    T = arm.forward_kinematics(q0).homogeneous
    best = arm.optimise(T, "manipulability").value
    tracker = tracker_of(name, q0, elbow="manipulability")
    q, steps = follow(name, [T] * 3000, tracker)
    values = [np.prod(np.linalg.svd(arm.jacobian(each), compute_uv=False)) for each in (q[0], q[-1])]
    assert all(steps)
    assert values[1] > values[0]
    assert values[1] <= best * (1.0 + 1e-9)


def test_another_configuration_is_taken_only_when_allowed():
    rng = np.random.default_rng(1)
    lower, upper = within(arms.load("iiwa14"), 0.9)
    held = 0
    for _ in range(12):
        q0 = rng.uniform(lower, upper)
        target = arms.forward("iiwa14")(rng.uniform(lower, upper))
        tracker = tracker_of("iiwa14", q0)
        q, steps = follow("iiwa14", [target] * 2000, tracker)
        assert_limits_kept("iiwa14", q0, q, tracker)
        if steps[-1].status != "HELD":
            continue
        held += 1
        assert "reconfigure()" in steps[-1].message
        assert tracker.reconfigure()
        after, steps = follow("iiwa14", [target] * 3000, tracker)
        assert_limits_kept("iiwa14", q0, np.vstack([q, after]), tracker)
        assert steps[-1].status == "OK"
    assert held


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"dt": 0.0}, InvalidConfiguration, "dt must be a positive"),
        ({"q0": np.full(7, 9.0)}, InvalidConfiguration, "outside its limits"),
        ({"velocity": -1.0}, InvalidConfiguration, "velocity must be a positive"),
        ({"acceleration": [1.0, 2.0]}, InvalidConfiguration, "acceleration must be a positive"),
        ({"acceleration": np.nan}, InvalidConfiguration, "acceleration must be a positive number \\(inf: none\\)"),
        ({"velocity": np.inf}, InvalidConfiguration, "velocity must be a positive"),
        ({"velocity": 1e307, "acceleration": np.inf}, InvalidConfiguration, "1e\\+06 at most"),
        ({"dt": True}, InvalidConfiguration, "dt must be a positive number of seconds, not True"),
        ({"dt": 1e300}, InvalidConfiguration, "100 s at most"),
        ({"dt": 1e-300}, InvalidConfiguration, "1e-06 s at least"),
        ({"smoothing": -1.0}, InvalidConfiguration, "smoothing must be a number of seconds from 0 on, or None"),
        ({"elbow": "best"}, InvalidTask, "elbow must be .*, not 'best'"),
        ({"elbow": np.inf}, InvalidConfiguration, "arm angle must be a finite"),
        ({"elbow": np.zeros((2, 7))}, InvalidConfiguration, 'elbow must be "keep", .*, not an array of shape'),
        ({"elbow": np.sum}, InvalidConfiguration, 'elbow must be "keep", .*, a built-in Objective'),
        (
            {"elbow": Objective(np.sum)},
            InvalidTask,
            "of one value, not 'sum'; .* takes the arm_angle",
        ),
    ],
)
def test_wrong_arguments_are_named(options, error, words):
    arm = arms.load("iiwa14")
    with pytest.raises(error, match=words):
        arm.tracker(**{"q0": np.zeros(7), "dt": DT, **options})


def test_an_arm_without_velocity_limits_needs_them():
    model = arms.load("iiwa14").model.copy()
    model.velocityLimit = np.full(7, np.inf)
    arm = load(model, base=arms.load("iiwa14").base, tip=arms.load("iiwa14").tip)
    with pytest.raises(MissingLimits, match="velocity"):
        arm.tracker(np.zeros(7), DT)
    assert arm.tracker(np.zeros(7), DT, velocity=2.0).acceleration_limit == pytest.approx(np.full(7, 20.0))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_without_limits_of_acceleration_those_of_position_and_velocity_are_kept(name, kind):
    arm = arms.load(name)
    moving = motion(arm, 5, 2.0, DT, kind, trouble=True)
    tracker = tracker_of(name, moving.q0, acceleration=np.inf)
    q, steps = follow(name, moving.given, tracker)
    assert np.isinf(tracker.acceleration_limit).all()
    assert_limits_kept(name, moving.q0, q, tracker)
    assert all(step.status in TrackerStatus and step.message for step in steps)
    # They are made use of: the target jumps on the way.
    velocity = np.diff(np.vstack([moving.q0, moving.q0, q]), axis=0) / DT
    assert (np.abs(np.diff(velocity, axis=0)) / DT > 10.0 * arm.velocity_limit).any()


def test_one_joint_alone_may_be_without_a_limit_of_acceleration():
    most = np.full(7, 5.0)
    most[3] = np.inf
    q0 = start("iiwa14")
    tracker = tracker_of("iiwa14", q0, acceleration=most)
    T = arms.load("iiwa14").forward_kinematics(q0 + 0.3).homogeneous
    q, steps = follow("iiwa14", [T] * 1000, tracker)
    assert_limits_kept("iiwa14", q0, q, tracker)
    assert steps[-1]


def test_jitter_is_smoothed_without_a_lag():
    arm, q0 = arms.load("iiwa14"), start("iiwa14")
    rng = np.random.default_rng(0)
    T = arm.forward_kinematics(q0).homogeneous
    ends, roughness = [], []
    for smoothing in (0.0, 0.1):
        tracker = tracker_of("iiwa14", q0, smoothing=smoothing)
        here, off, rough = T.copy(), [], []
        for k in range(1500):
            here[1, 3] += 5e-5 * min(k / 300.0, 1.0)
            shaken = here.copy()
            shaken[:3, 3] += rng.normal(0.0, 3e-4, 3)
            shaken[:3, :3] = shaken[:3, :3] @ pin.exp3(rng.normal(0.0, 1e-3, 3))
            step = tracker.update(shaken)
            off.append(np.linalg.norm(arms.forward("iiwa14")(step.q).translation - here[:3, 3]))
            rough.append(np.abs(step.acceleration).mean())
        ends.append(np.mean(off[1000:]))
        roughness.append(np.mean(rough[1000:]))
    assert ends[1] < 5e-4
    assert roughness[1] < 0.3 * roughness[0]


@pytest.mark.parametrize("kind", KINDS)
def test_the_jerk_is_limited_too(kind):
    pytest.importorskip("ruckig")
    arm = arms.load("iiwa14")
    moving = motion(arm, 3, 2.0, DT, kind, trouble=True)
    tracker = tracker_of("iiwa14", moving.q0, jerk=200.0, smoothing=0.02)
    q, _ = follow("iiwa14", moving.given, tracker)
    assert_limits_kept("iiwa14", moving.q0, q, tracker)
    jerk = np.diff(np.vstack([np.repeat(moving.q0[None], 3, axis=0), q]), n=3, axis=0) / DT**3
    # The third difference of figures rounded to 4e-16 rad has errors of 4e-7 rad/s^3.
    assert np.abs(jerk).max() <= 200.0 + 1e-6
    end = moving.true[-1] if kind not in ("reach", "hand") else arm.forward_kinematics(q[-1])
    for _ in range(1500):
        step = tracker.update(end)
    assert np.abs(step.velocity).max() < 1e-3
    off = np.linalg.norm(
        arms.forward("iiwa14")(step.q).translation - np.asarray(getattr(end, "homogeneous", end))[:3, 3]
    )
    assert step.position_error == pytest.approx(off, abs=1e-9)


def test_a_step_that_ruckig_does_not_find_is_no_error():
    """At update 166 of this motion Ruckig raises an error of its own: the joints then slow down as it had planned."""
    pytest.importorskip("ruckig")
    arm, dt, rng = arms.load("iiwa14"), 0.05, np.random.default_rng(52)
    q0, pace = rng.uniform(arm.lower, arm.upper), rng.uniform(0.2, 3.0, 7)
    tracker = arm.tracker(q0, dt, jerk=arm.velocity_limit / 0.01)
    q = [q0, q0, q0]
    for i in range(400):
        goal = arm.forward_kinematics(np.clip(q0 + 0.5 * np.sin(pace * i * dt), arm.lower, arm.upper))
        ahead = deepcopy(tracker).update(goal).q if 160 < i < 180 else None
        q.append(tracker.update(goal).q)
        assert ahead is None or ahead.tobytes() == q[-1].tobytes()
    most = arm.velocity_limit
    for order, limit in enumerate((most, tracker.acceleration_limit, most / 0.01), 1):
        assert (np.abs(np.diff(q, order, axis=0)) / dt**order <= limit + 1e-6).all()
    assert (q >= arm.lower).all()
    assert (q <= arm.upper).all()


def test_without_a_target_to_reconfigure_for_a_pose_is_missing():
    tracker = tracker_of("iiwa14", start("iiwa14"))
    tracker.update(None)
    with pytest.raises(InvalidPose, match="no target yet"):
        tracker.reconfigure()


def freed_error(name, free, q, T):
    """Metres and radians that are left of a target, by Pinocchio."""
    tip = arms.forward(name)(q)
    a, b = tip.rotation @ free.axis, T[:3, :3] @ free.axis
    lean = np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)
    return np.linalg.norm(tip.translation - T[:3, 3]), max(lean - free.cone, 0.0)


@pytest.mark.parametrize("free", [FreeAxis([0, 0, 1]), FreeAxis([0.3, 0, 1], cone=0.2), FreeAxis(cone=np.pi)])
@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_a_free_turn_of_the_target_is_not_followed(name, free):
    arm, q0 = arms.load(name), start(name)
    T = arm.forward_kinematics(q0).homogeneous
    tracker = tracker_of(name, q0, free_axis=free)
    poses = np.repeat(T[None], 1000, axis=0)
    for k, pose in enumerate(poses):
        # The tip goes on, and the target turns about what is free faster than any joint could.
        pose[:3, :3] = T[:3, :3] @ pin.exp3(0.1 * k * free.axis)
        pose[:3, 3] += 0.03 * minimum_jerk(np.array(k / 900.0)) * np.array([1.0, -0.5, 0.5])
    q, steps = follow(name, poses, tracker)
    assert_limits_kept(name, q0, q, tracker)
    errors = np.array([freed_error(name, free, each, pose) for each, pose in zip(q, poses, strict=True)])
    assert errors.max() < 1e-8
    assert all(steps)
    reported = [steps[-1].position_error, steps[-1].orientation_error]
    assert reported == pytest.approx(errors[-1].tolist(), abs=1e-8)


@pytest.mark.parametrize("name", FOLLOWED)
@given(seed=st.integers(0, 10_000), kind=st.sampled_from(KINDS), cone=st.sampled_from([0.0, 0.3, np.pi]))
def test_limits_are_kept_with_a_free_turn_too(name, seed, kind, cone):
    moving = motion(arms.load(name), seed, 0.6, DT, kind, trouble=True)
    tracker = tracker_of(name, moving.q0, free_axis=FreeAxis(cone=cone))
    q, steps = follow(name, moving.given, tracker)
    assert_limits_kept(name, moving.q0, q, tracker)
    assert all(step.message for step in steps)


def test_a_free_roll_brings_more_targets_into_reach():
    """A target turned half about the tip's axis, which the roll as it is cannot follow without another posture."""
    arm, q0 = arms.load("iiwa14"), start("iiwa14")
    T = arm.forward_kinematics(q0).homogeneous
    T[:3, :3] = T[:3, :3] @ pin.exp3(np.array([0.0, 0.0, np.pi]))
    tracker = tracker_of("iiwa14", q0, free_axis=[0, 0, 1])
    _, steps = follow("iiwa14", [T] * 5, tracker)
    assert all(steps)
    assert np.abs(steps[-1].velocity).max() < 1e-9
    assert tracker.reconfigure()
    with pytest.raises(InvalidTask, match="free_axis"):
        tracker_of("iiwa14", q0, free_axis=[0, 0, 0])


def test_the_elbow_serves_a_task():
    arm, q0 = arms.load("iiwa14"), start("iiwa14")
    T = arm.forward_kinematics(q0).homogeneous
    task = Task(T[:3, 3], velocity=[1.0, 0.0, 0.0], force=[0.0, 0.0, 1.0])
    tracker = tracker_of("iiwa14", q0, elbow=task)
    q, steps = follow("iiwa14", [T] * 3000, tracker)
    assert_limits_kept("iiwa14", q0, q, tracker)
    assert all(steps)
    costs = [force_velocity_ratio(arm.jacobian(each), task.force, task.velocity) for each in (q[0], q[-1])]
    assert abs(costs[1] - costs[0]) > 1e-3
    best = arm.optimise(T, "force_velocity_ratio", force=task.force, velocity=task.velocity).value
    assert abs(costs[1] - best) < abs(costs[0] - best)
    with pytest.raises(InvalidTask, match="one task, not 2"):
        tracker.elbow = Task(np.zeros((2, 3)), velocity=[1.0, 0.0, 0.0], force=[0.0, 0.0, 1.0])


def test_the_elbow_keeps_away_from_what_stands_around():
    arm, q0 = arms.load("iiwa14"), start("iiwa14")
    T = arm.forward_kinematics(q0).homogeneous
    scene = Scene()
    elbow = arms.forward("iiwa14").carried(q0, 4, arm.limb.elbow)
    side = np.cross(arm.limb.shoulder - T[:3, 3], elbow - arm.limb.shoulder)
    ball = elbow + 0.3 * side / np.linalg.norm(side)
    scene.add_sphere("ball", ball, 0.05)
    tracker = tracker_of("iiwa14", q0, elbow=scene)
    q, steps = follow("iiwa14", [T] * 1000, tracker)
    assert_limits_kept("iiwa14", q0, q, tracker)
    assert all(steps)
    elbows = [arms.forward("iiwa14").carried(each, 4, arm.limb.elbow) for each in (q0, q[-1])]
    assert np.linalg.norm(elbows[1] - ball) > np.linalg.norm(elbows[0] - ball) + 0.05
    scene.remove("ball")
    assert all(follow("iiwa14", [T] * 20, tracker)[1])


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_a_target_that_jumped_is_met_in_little_more_than_the_least_time(name):
    for seconds, least in recoveries(arms.load(name), 12, 500, DT):
        assert seconds < 2.5 * least + 0.1


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_behind_a_target_that_starts_at_once_the_tip_is_no_farther_than_the_limits_imply(name):
    """Joint 1 would have to reach half of its velocity at once: until it does, it falls behind by v^2 / (2 a)."""
    arm, q0 = arms.load(name), start(name)
    rate = 0.5 * arm.velocity_limit[0]
    t = DT * np.arange(1, 400)
    poses = np.array([arm.forward_kinematics(q0 + np.eye(7)[0] * rate * each).homogeneous for each in t])
    tracker = tracker_of(name, q0)
    q, _ = follow(name, poses, tracker)
    assert_limits_kept(name, q0, q, tracker)
    position, _ = off_target(arms.forward(name), q, poses)
    lever = np.linalg.norm(poses[0][:2, 3])
    bound = lever * rate**2 / (2.0 * tracker.acceleration_limit[0])
    assert position.max() < 1.1 * bound
    assert position[200:].max() < 1e-3


def test_the_elbow_keeps_away_from_an_object_where_it_is_now():
    """An object that was moved stood for the tracker where it had been, until another question was asked."""
    arm = arms.load("iiwa14")
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose, scene = arm.forward_kinematics(q), Scene()
    scene.add_sphere("ball", [3.0, 3.0, 3.0], 0.1)
    tracker = arm.tracker(q, 0.01, elbow=scene)
    for _ in range(50):
        step = tracker.update(pose)
    elbow = arm.joint_frames(step.q)[4, :3, 3]
    beside = np.cross(elbow - arm.limb.shoulder, pose.translation - elbow)
    there = np.eye(4)
    there[:3, 3] = elbow + 0.28 * beside / np.linalg.norm(beside)
    scene.move("ball", there)
    for _ in range(200):
        step = tracker.update(pose)
    assert np.linalg.norm(arm.joint_frames(step.q)[4, :3, 3] - there[:3, 3]) > 0.35


def test_a_misspelt_attribute_is_refused():
    tracker = load("iiwa14").tracker([0.1] * 7, 0.002)
    with pytest.raises(AttributeError, match="did you mean 'smoothing'"):
        tracker.smothing = 0.02


def test_who_starts_outside_the_limits_is_told_what_is_inside():
    arm = load("iiwa14")
    past = np.append(arm.upper[:6], 0.0) + 1e-4
    with pytest.raises(InvalidConfiguration, match=r"np\.clip\(q0, arm\.lower, arm\.upper\)"):
        arm.tracker(past, 0.002)
    assert arm.tracker(np.clip(past, arm.lower, arm.upper), 0.002).update(None).status == "HELD"


def test_velocities_above_the_robots_own_are_told():
    with pytest.warns(UserWarning, match="joint '.*' may go at 30 rad/s, its own limit is"):
        load("gen3").tracker([0.1] * 7, 0.01, velocity=30.0)


def test_threads_that_share_a_tracker_wait_for_each_other():
    arm = load("iiwa14")
    tracker = arm.tracker([0.1] * 7, 0.01)
    T = arm.forward_kinematics([0.4] * 7).homogeneous
    steps = []

    def follow():
        for _ in range(200):
            steps.append(tracker.update(T).q)
            tracker.reconfigure()

    threads = [Thread(target=follow) for _ in range(4)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert len(steps) == 800
    assert np.isfinite(steps).all()
    assert tracker.update(T)
    again = deepcopy(tracker)
    assert np.array_equal(again.update(T).q, tracker.update(T).q)


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0, 0.0), (np.nan, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 2.0)])
def test_a_message_without_a_pose_is_a_lost_target(turn):
    tracker = load("iiwa14").tracker([0.1] * 7, 0.002)
    position = SimpleNamespace(x=0.5, y=0.1, z=0.5)
    message = SimpleNamespace(position=position, orientation=SimpleNamespace(**dict(zip("xyzw", turn, strict=True))))
    step = tracker.update(message)
    assert step.status == "HELD"
    assert step.message.startswith("No pose")
    with pytest.raises(InvalidPose):
        tracker.update(SimpleNamespace(position=position))
