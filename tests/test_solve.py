"""`Arm.solve`: poses are met, limits kept, and the posture given is the best one."""

import re

import arms
import numpy as np
import pytest
from hypothesis import given
from oracles import Forward, distance, inside, limbs, random_limb, room, wrapped
from robot_files import serial_arm

import srs_ik
from srs_ik import Status


def assert_met(arm, forward, pose, solution, tolerance, respect_limits=True):
    assert solution.status is Status.OK, solution
    position, orientation = distance(pose, forward(solution.q))
    assert max(position, orientation) < tolerance
    # What the solution says of itself is what Pinocchio measures, up to rounding.
    assert solution.position_error == pytest.approx(position, abs=1e-13)
    assert solution.orientation_error == pytest.approx(orientation, abs=1e-13)
    if respect_limits:
        assert inside(solution.q, arm.lower, arm.upper)


@pytest.mark.parametrize("name", arms.EVERY)
def test_poses_inside_the_limits_are_met(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 100):
        pose = forward(q)
        assert_met(arm, forward, pose, arm.solve(pose), arms.tolerance(name))


@pytest.mark.parametrize("name", arms.EVERY)
def test_poses_are_met_at_the_arm_angle_asked_for(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 40, 1):
        pose, psi = forward(q), arm.arm_angle(q)
        solution = arm.solve(pose, arm_angle=psi)
        assert_met(arm, forward, pose, solution, arms.tolerance(name))
        assert abs(wrapped(solution.arm_angle - psi)) < 1e-9
        assert abs(wrapped(arm.arm_angle(solution.q) - psi)) < 1e-9


@pytest.mark.parametrize("name", arms.EVERY)
def test_the_branch_asked_for_is_given(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 20, 2):
        pose, branch = forward(q), arm.branch(q)
        for arm_angle in (None, arm.arm_angle(q)):
            solution = arm.solve(pose, arm_angle=arm_angle, branch=branch)
            assert_met(arm, forward, pose, solution, arms.tolerance(name))
            assert solution.branch == branch == arm.branch(solution.q)


@pytest.mark.parametrize("name", arms.EVERY)
def test_without_limits_any_configuration_is_met(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.generator(name, 3).uniform(-np.pi, np.pi, (20, 7)):
        pose = forward(q)
        for arm_angle in (None, arm.arm_angle(q)):
            solution = arm.solve(pose, arm_angle=arm_angle, respect_limits=False)
            assert_met(arm, forward, pose, solution, arms.tolerance(name), respect_limits=False)


# Random limbs ---------------------------------------------------------------------------------------------------


def check_random(limb, tolerance, every_angle=True):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    forward = Forward(limb.model, "base", "tool", arm.joint_names)
    for _ in range(3):
        q = limb.configuration()
        pose = forward(q)
        assert_met(arm, forward, pose, arm.solve(pose), tolerance)
        assert_met(arm, forward, pose, arm.solve(pose, seed=q), tolerance)
        solution = arm.solve(pose, arm_angle=arm.arm_angle(q))
        if solution or every_angle:
            assert_met(arm, forward, pose, solution, tolerance)
        anywhere = limb.rng.uniform(-np.pi, np.pi, 7)
        pose = forward(anywhere)
        assert_met(arm, forward, pose, arm.solve(pose, respect_limits=False), tolerance, respect_limits=False)
        # Inside the limits there may be no posture; an answer says so, or is right.
        solution = arm.solve(pose)
        assert inside(solution.q, arm.lower, arm.upper)
        if solution:
            assert_met(arm, forward, pose, solution, tolerance)
        else:
            assert solution.status is Status.OUT_OF_LIMITS
            assert max(solution.position_error, solution.orientation_error) > 1e-9


@given(limbs())
def test_random_limbs_are_solved(limb):
    check_random(limb, 1e-10)


@pytest.mark.slow
@given(limbs(miss=0.01))
def test_random_limbs_whose_axes_miss_their_centres_are_solved(limb):
    """A branch of such a limb may have two postures at an arm angle, of which a given one finds only the first."""
    check_random(limb, 1e-9, every_angle=False)


# The best posture -----------------------------------------------------------------------------------------------


def sweep(arm, pose, count=720):
    """(count * 8, 7) postures in every branch all around the circle, in any turn; those that reach the pose."""
    angles = np.linspace(-np.pi, np.pi, count, endpoint=False)
    poses = np.broadcast_to(pose.homogeneous, (count, 4, 4))
    batch = arm.solve_batch(poses, arm_angle=angles, all_branches=True, respect_limits=False)
    return batch.q[batch.ok]


def turns_near(q, seed, lower, upper):
    """Every angle in the turn nearest to a seed that keeps its limits; NaN where none does."""
    best = np.full(q.shape, np.nan)
    for turns in range(-4, 5):
        turned = wrapped(q) + 2.0 * np.pi * turns
        fits = (turned >= lower) & (turned <= upper)
        nearer = fits & ~(np.abs(best - seed) <= np.abs(turned - seed))
        best = np.where(nearer, turned, best)
    return best


BEST = arms.here("iiwa14", "gen3", "human_arm", "sia5d", "openarm_left", "romeo_left", "rm75")


@pytest.mark.parametrize("spread", [0.02, 1.0, 2.5])
@pytest.mark.parametrize("name", BEST)
def test_the_seeded_posture_is_the_nearest(name, spread):
    arm, forward, rng = arms.load(name), arms.forward(name), arms.generator(name, 4)
    for known in arms.configurations(name, 25, 5):
        seed = known + rng.uniform(-spread, spread, 7)
        pose = forward(known)
        solution = arm.solve(pose, seed=seed)
        assert_met(arm, forward, pose, solution, arms.tolerance(name))
        found = np.sum((solution.q - seed) ** 2)
        assert found <= np.sum((known - seed) ** 2) + 1e-9
        swept = np.sum((turns_near(sweep(arm, pose), seed, arm.lower, arm.upper) - seed) ** 2, axis=1)
        assert not found > np.nanmin(swept, initial=np.inf) + 1e-9


@pytest.mark.slow
@given(limbs())
def test_on_random_limbs_the_seeded_posture_is_the_nearest(limb):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    for _ in range(2):
        known = limb.configuration()
        pose = arm.forward_kinematics(known)
        assert np.abs(arm.solve(pose, seed=known).q - known).max() < 1e-6
        seed = known + limb.rng.uniform(-1.0, 1.0, 7)
        solution = arm.solve(pose, seed=seed)
        found = np.sum((solution.q - seed) ** 2)
        assert found <= np.sum((known - seed) ** 2) + 1e-9
        swept = np.sum((turns_near(sweep(arm, pose), seed, arm.lower, arm.upper) - seed) ** 2, axis=1)
        assert not found > np.nanmin(swept, initial=np.inf) + 1e-9


@pytest.mark.parametrize(
    ("case", "draws"),
    [
        ((3165182844, "oblique", "straight", "wide"), 2),
        ((3710268475, "oblique", "offset", "wide"), 2),
        ((3828998945, "coordinate", "straight", "wide"), 2),
    ],
)
def test_ranges_wider_than_a_turn_do_not_hide_the_nearest_posture(case, draws):
    """Where the turn nearest to the seed leaves the limits, the distance jumps within an interval."""
    limb = random_limb(*case)
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    for _ in range(draws):
        known = limb.configuration()
        seed = known + limb.rng.uniform(-1.0, 1.0, 7)
    pose = arm.forward_kinematics(known)
    found = np.sum((arm.solve(pose, seed=seed).q - seed) ** 2)
    swept = np.sum((turns_near(sweep(arm, pose), seed, arm.lower, arm.upper) - seed) ** 2, axis=1)
    assert found <= np.nanmin(swept) + 1e-9


@pytest.mark.parametrize(
    ("name", "known", "seed"),
    [
        (
            "iiwa14",
            [-0.56979093, 0.00139116, -1.5405611, 2.00097128, -0.48572252, 1.86619936, 1.830081],
            [-0.60341158, 0.09375826, -1.47034097, 2.08894391, -0.43478061, 1.87344514, 1.78183229],
        ),
        (
            "iiwa14",
            [-0.65393697, 0.00158977, 2.71701349, 0.24258021, -0.350234, 0.2468485, -1.28436867],
            [-0.13593496, -0.82966419, 2.74586432, 0.06838578, -1.13045896, 0.28060483, -0.29198377],
        ),
        (
            "human_arm",
            [0.33046059, -1.52775775, -0.39685713, -1.59807569, 0.67271174, -1.25564728, 0.51601712],
            [-0.03198023, 0.2900085, -1.43884463, -1.44581142, 0.8434332, -0.2807988, 0.10455025],
        ),
    ],
)
def test_a_second_valley_next_to_a_singularity_does_not_hide_the_nearest_posture(name, known, seed):
    """Within less than 0.3 rad of arm angle the distance has two minima there."""
    arm = arms.load(name)
    solution = arm.solve(arm.forward_kinematics(known), seed=seed)
    assert np.linalg.norm(solution.q - seed) <= np.linalg.norm(np.subtract(known, seed)) + 1e-9


def margin(arm, q):
    """Smallest distance from the limits relative to half the range; 1 for a joint without limits."""
    half = 0.5 * (arm.upper - arm.lower)
    with np.errstate(invalid="ignore"):
        return np.where(np.isfinite(half), room(q, arm.lower, arm.upper) / half, 1.0).min(axis=-1)


@pytest.mark.parametrize("name", BEST)
def test_without_a_seed_the_posture_is_farthest_from_the_limits(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 25, 6):
        pose = forward(q)
        solution = arm.solve(pose)
        assert_met(arm, forward, pose, solution, arms.tolerance(name))
        assert margin(arm, solution.q) >= margin(arm, sweep(arm, pose)).max() - 1e-9


@given(limbs(limits=("usual", "wide", "beyond", "continuous")))
def test_on_random_limbs_the_posture_is_farthest_from_the_limits(limb):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    known = limb.configuration()
    pose = arm.forward_kinematics(known)
    best = max(margin(arm, sweep(arm, pose)).max(), margin(arm, known))
    assert margin(arm, arm.solve(pose).q) >= best - 1e-9


@pytest.mark.parametrize(
    "case",
    [
        (506495681, "tilted", "offset", "wide"),
        (3275039810, "coordinate", "offset", "wide"),
        (1736716537, "coordinate", "offset", "wide"),
    ],
)
def test_ranges_wider_than_a_turn_do_not_hide_the_posture_farthest_from_the_limits(case):
    """Such ranges change turns within an interval: the margin has more than one peak there."""
    limb = random_limb(*case)
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    pose = arm.forward_kinematics(limb.configuration())
    assert margin(arm, arm.solve(pose).q) >= margin(arm, sweep(arm, pose)).max() - 1e-9


def best_around(arm, pose, found, width=1e-3):
    """Largest margin of its branch close to a posture, at arm angles on both sides of it down to rounding."""
    steps = width * 10.0 ** -np.arange(0.0, 11.0, 0.25)
    angles = found.arm_angle + np.concatenate([-steps, steps])
    poses = np.broadcast_to(pose.homogeneous, (len(angles), 4, 4))
    batch = arm.solve_batch(poses, arm_angle=angles, branch=found.branch, respect_limits=False)
    return margin(arm, batch.q[batch.ok]).max()


@pytest.mark.parametrize("name", arms.here("iiwa14", "human_arm", "openarm_left", "romeo_left", "rm75"))
@pytest.mark.parametrize("respect", [True, False])
def test_no_arm_angle_next_to_the_farthest_posture_has_more_margin(name, respect):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 25, 9):
        pose = forward(q)
        solution = arm.solve(pose, respect_limits=respect)
        assert margin(arm, solution.q) >= best_around(arm, pose, solution) - 1e-10


@pytest.mark.slow
@given(limbs(limits=("usual", "wide", "beyond", "mixed")))
def test_each_interval_has_its_posture_farthest_from_the_limits(limb):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    pose = arm.forward_kinematics(limb.configuration())
    Q = sweep(arm, pose, 360)
    Q = Q[margin(arm, Q) >= 0.0]
    branches, angles = np.array([arm.branch(q) for q in Q]), np.array([arm.arm_angle(q) for q in Q])
    for interval, solution in zip(arm.intervals(pose), arm.solve_all(pose), strict=True):
        within = (branches == interval.branch) & ((angles - interval.lower) % (2.0 * np.pi) < interval.width)
        assert margin(arm, solution.q) >= margin(arm, Q[within]).max(initial=0.0) - 1e-9


@pytest.mark.parametrize("name", arms.here("gen3", "gen3_upstream", "j2s7s300"))
def test_continuous_joints_come_back_in_the_turn_of_the_seed(name):
    arm, rng = arms.load(name), arms.generator(name, 7)
    continuous = np.isinf(arm.upper)
    assert continuous.any()
    for q in arms.configurations(name, 15, 8):
        seed = q + np.where(continuous, 2.0 * np.pi * rng.integers(-3, 4, 7), 0.0)
        solution = arm.solve(arm.forward_kinematics(q), seed=seed)
        assert solution
        assert np.abs(solution.q - seed).max() < 1e-6
        at_angle = arm.solve(arm.forward_kinematics(q), seed=seed, arm_angle=arm.arm_angle(q))
        assert np.abs(at_angle.q - seed).max() < 1e-6


def test_ranges_wider_than_a_turn_keep_the_turn_of_the_seed():
    limb = random_limb(5, "tilted", "offset", "wide")
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    assert (arm.upper - arm.lower > 2.0 * np.pi).all()
    beyond = 0
    for _ in range(40):
        q = limb.configuration()
        beyond += int((np.abs(q) > np.pi).any())
        solution = arm.solve(arm.forward_kinematics(q), seed=q)
        assert np.abs(solution.q - q).max() < 1e-6
    assert beyond > 10


def test_the_same_posture_in_every_turn_inside_the_limits_is_left_alone_without_a_seed():
    limb = random_limb(9, "coordinate", "straight", "continuous")
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    q = limb.configuration()
    solution = arm.solve(arm.forward_kinematics(q + 4.0 * np.pi))
    assert solution
    assert (np.abs(solution.q) <= np.pi + 1e-12).all()


@pytest.mark.parametrize("locked", [(1,), (2,), (3,), (4,), (5,), (6,), (7,), (3, 5), (1, 7)])
def test_joints_that_their_limits_lock_are_kept_where_they_are(locked, tmp_path):
    text = f'<robot name="locked">{serial_arm()}</robot>'
    for k in locked:
        text = re.sub(rf'(name="j{k}".*?)lower="-2" upper="2"', r'\1lower="0.3" upper="0.3"', text, count=1)
    path = tmp_path / "locked.urdf"
    path.write_text(text)
    arm = srs_ik.load(path)
    assert [k for k in range(1, 8) if arm.lower[k - 1] == arm.upper[k - 1]] == list(locked)
    forward = Forward(path, arm.base, arm.tip, arm.joint_names)
    for q in np.random.default_rng(31).uniform(arm.lower, arm.upper, (30, 7)):
        pose = forward(q)
        for seed in (None, q):
            assert_met(arm, forward, pose, arm.solve(pose, seed=seed), 1e-9)
