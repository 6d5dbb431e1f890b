"""What a tracker makes of a target that can be followed, by what the limits imply for any motion (`bounded.py`)."""

from dataclasses import replace

import arms
import numpy as np
import pinocchio as pin
import pytest
from bounded import (
    BEFORE,
    FOLLOWED,
    FORESEEN,
    Known,
    Run,
    Start,
    begins_anew,
    best_motion,
    can_be_followed,
    kept_to,
    known_motion,
    late,
    leaves,
    nobody,
    off_by,
    run,
)
from causal import beyond_the_step_at_hand, expected, followed_without_foresight, least_error
from motions import joint_motion, motion, off_target, within
from tracked import NEAR_TARGET, box_after, passed, velocities, ways_to

from srs_ik.kernels.layout import track as at
from srs_ik.kernels.track.foresight import when

DT = 0.002
ROUNDING = 1e-9
"""Limits are kept to this, rad, rad/s and rad/s^2."""

CORNER = 0.1
"""A tip that leaves its target may be farther off than the step at hand by this share of what counts as on it: steps
serve place and turn together, and not the worse of both."""

ARMS = arms.here("iiwa14", "gen3")


def limits(arm):
    """The arm's velocity limits, and accelerations that lead to them in 0.1 s."""
    return velocities(arm), 10.0 * velocities(arm)


def test_accelerations_lead_to_full_velocity_in_a_tenth_of_a_second_if_not_given():
    arm = arms.load("iiwa14")
    assert arm.tracker(np.zeros(7), DT).acceleration_limit == pytest.approx(10.0 * arm.velocity_limit)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ARMS)
def test_motions_can_be_followed_but_where_they_jump(name, seed):
    arm = arms.load(name)
    known = known_motion(arm, seed, DT)
    free = can_be_followed(known.q, limits(arm), DT)
    # Two jumps; a jump is one velocity and two changes of it.
    assert 1 <= (~free).sum() <= 4
    assert (known.q >= arm.lower).all()
    assert (known.q <= arm.upper).all()


def on_the_way(name, seed, at, samples):
    """A state of a motion within limits, and the poses that come after it."""
    arm, forward = arms.load(name), arms.forward(name)
    q = joint_motion(arm, np.random.default_rng(seed), at + samples, DT, "joints", 0.5, 0.5)
    start = Start(arm, forward, q[at - 1], (q[at - 1] - q[at - 2]) / DT, limits(arm), DT)
    return start, [forward(each) for each in q[at:]]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", ARMS)
def test_a_motion_that_stays_on_a_target_is_found_and_keeps_the_limits(name, seed):
    start, targets = on_the_way(name, seed, 1000, 150)
    q, v, worst = best_motion(start, targets, np.zeros((30, 7)))
    assert worst <= 1.0
    # By differences, and by Pinocchio.
    rows = np.vstack([start.q - DT * start.v, start.q, q])
    velocity = np.diff(rows, axis=0) / DT
    np.testing.assert_allclose(velocity[1:], v, atol=1e-9)
    assert (np.abs(velocity) <= start.bounds[0] + ROUNDING).all()
    # Velocities are differences of angles of up to 3 rad, rounded to 4e-16 rad.
    assert (np.abs(np.diff(velocity, axis=0)) / DT <= start.bounds[1] + 1e-8).all()
    assert (q >= start.arm.lower - ROUNDING).all()
    assert (q <= start.arm.upper + ROUNDING).all()
    off = np.array([off_by(start.forward, x, T) for x, T in zip(q, targets, strict=True)])
    assert (off <= FOLLOWED).all()


@pytest.mark.slow
def test_no_motion_stays_on_a_target_that_is_faster_than_the_arm():
    start, targets = on_the_way("iiwa14", 0, 1000, 100)
    _, _, worst = best_motion(start, targets[::2] + targets[::-2], np.zeros((20, 7)))
    assert worst > 10.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_a_tracker_that_leaves_its_target_without_need_is_found_out(name):
    arm, forward = arms.load(name), arms.forward(name)
    found, bounds = run(arm, forward, known_motion(arm, 0, DT), DT)
    odd = begins_anew(found) | found.known.lost
    k = next(k for k in range(400, 2000) if found.on[k - 100 : k + 100].all() and odd[k - 100 : k + 100].sum() < 15)
    astray = found.off.copy()
    astray[k : k + 50] = 1.0
    false = replace(found, off=astray)
    assert k in leaves(false, BEFORE, DT)
    assert kept_to(arm, forward, false, k, BEFORE, bounds, DT) <= 1.0
    assert late(arm, false, bounds, DT)[k : k + 50].mean() > 0.8


@pytest.mark.parametrize("name", ARMS)
def test_nobody_is_said_to_be_unable_to_do_what_a_motion_does(name):
    """From rest, with the largest accelerations up and down, that are changed at random."""
    arm, forward, rng = arms.load(name), arms.forward(name), np.random.default_rng(0)
    fastest, hardest = limits(arm)
    for _ in range(20):
        q, v = rng.uniform(*within(arm, 0.6)), np.zeros(7)
        start = q.copy(), v.copy()
        for _ in range(12):
            push = rng.choice([-1.0, 1.0], 7) * hardest
            for _ in range(5):
                v = np.clip(v + DT * push, -fastest, fastest)
                q = q + DT * v
        # A target that is where this motion is after 60 periods, all the time.
        assert nobody(arm, start, [forward(q)] * 120, limits(arm), DT) <= 60
    assert nobody(arm, start, [forward(start[0] + 1.0)] * 10, limits(arm), DT) == 10


def test_no_tracker_can_follow_every_target_that_joints_within_the_limits_make():
    """Two targets rest on one pose; then each goes on as joints do that go to full velocity.

    They are made by two postures of that pose, and until then nobody can tell them apart. Of all postures of the pose,
    rested on at that time, some can be on the first target 0.3 s later, some on the second one, and none on both.
    """
    arm, forward = arms.load("iiwa14"), arms.forward("iiwa14")
    fastest, _ = limits(arm)
    seconds, rest = 0.3, np.zeros(7)
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    postures = q + ways_to(arm, q, forward(q).homogeneous)
    away = np.abs(postures - q).max(axis=1)
    beyond = []
    for far, seed in ((0.0, 0), (1.2, 6)):
        signs = np.random.default_rng(seed).choice([-1.0, 1.0], 7)
        begin = postures[np.argmin(np.abs(away - far))]
        end = begin + signs * fastest * (seconds - 0.05)
        assert (np.abs(end) < arm.upper).all()
        there = begin + ways_to(arm, begin, forward(end).homogeneous)
        boxes = [box_after(arm, (x, rest), seconds, limits(arm)) for x in postures]
        beyond.append([np.maximum(low - there, there - high).max(axis=1).min() for low, high in boxes])
    # Postures of a target are looked at 2 degrees of the arm angle apart.
    assert max(np.min(beyond, axis=1)) < 0.03
    assert np.max(beyond, axis=0).min() > 0.2


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed"), [("iiwa14", 1301), ("iiwa14", 1306), ("gen3", 1300), ("gen3", 1303)])
def test_a_target_that_could_have_been_followed_is_not_left(name, seed):
    arm, forward = arms.load(name), arms.forward(name)
    found, bounds = run(arm, forward, known_motion(arm, seed, DT), DT)
    at = leaves(found, BEFORE, DT)
    assert not [k for k in at if kept_to(arm, forward, found, k, BEFORE, bounds, DT) <= 1.0]
    assert found.on.mean() > 0.7
    assert beyond_the_step_at_hand(arm, forward, found, bounds, DT).max(initial=0.0) < CORNER
    # What counts is checked by Pinocchio on a sample.
    assert off_by(forward, found.q[1], forward(found.known.q[0])) == pytest.approx(found.off[0], abs=1e-12)
    assert found.on[0] == (found.off[0] <= NEAR_TARGET + found.noise).all()


@pytest.mark.parametrize("name", ARMS)
def test_no_step_at_hand_is_closer_than_the_least_error(name):
    start, targets = on_the_way(name, 2, 1000, 1)
    T = targets[0] * pin.SE3(pin.exp3(np.array([0.01, -0.02, 0.03])), np.array([2e-3, -1e-3, 3e-3]))
    least = least_error(start, T, np.zeros(2))
    rng, (fastest, hardest) = np.random.default_rng(0), start.bounds
    pushes = np.vstack([rng.uniform(-1.0, 1.0, (2000, 7)), rng.choice([-1.0, 1.0], (2000, 7))]) * hardest
    steps = start.q + DT * np.clip(start.v + DT * pushes, -fastest, fastest)
    errors = np.array([(off_by(start.forward, x, T) / np.array(NEAR_TARGET)).max() for x in steps])
    # The corners of the steps come close to it, and none passes it.
    assert least - 1e-6 < errors.min() < 1.01 * least


def test_a_target_that_goes_on_by_its_jolt_is_expected_where_it_goes():
    T = arms.forward("iiwa14")(np.full(7, 0.5))
    v, a, j = np.random.default_rng(0).normal(0.0, 1.0, (3, 3))
    t = DT * np.arange(-20, 100)
    way = v * t[:, None] + a * t[:, None] ** 2 + j * t[:, None] ** 3
    axis = np.array([0.6, 0.0, 0.8])
    poses = [pin.SE3(pin.exp3(axis * x[0]) @ T.rotation, T.translation + x) for x in way]
    for pose, foretold in zip(poses[21:], expected(poses[:21], 99, DT), strict=True):
        # 0.2 s ahead, from 32 ms: rounding grows by some 1e5.
        np.testing.assert_allclose(foretold.homogeneous, pose.homogeneous, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("fast", "stays"), [(1, True), (5, False)])
def test_a_follower_without_foresight_stays_on_what_joints_can_follow_and_on_nothing_else(fast, stays):
    arm, forward = arms.load("iiwa14"), arms.forward("iiwa14")
    q = joint_motion(arm, np.random.default_rng(1), 1200, DT, "joints", 0.5, 0.5)[800:][::fast]
    v = np.diff(np.vstack([q[:1], q]), axis=0) / DT / fast
    targets, nothing = [forward(each) for each in q[1:]], np.zeros(0)
    found = Run(Known(q, q, nothing, False), q, v, targets, nothing, nothing, np.zeros(2))
    worst = followed_without_foresight(arm, forward, found, slice(20, 60), limits(arm), DT)
    assert worst <= 1.0 if stays else worst > 10.0


@pytest.mark.parametrize("name", ARMS)
def test_plans_have_no_posture_that_a_joint_is_too_slow_for(name):
    """Up to 9 times as fast as the joints may, in 40 % of the plans on `iiwa14`, they led to another branch."""
    arm = arms.load(name)
    known = known_motion(arm, 5600000, DT)
    tracker = arm.tracker(known.q[0], DT, velocities(arm))
    gaps, plans, ahead = np.diff([when(k) for k in range(at.KNOTS + 1)])[:, None], 0, 0.0
    for q, lost in zip(known.given, known.lost, strict=True):
        tracker.update(None if lost else arm.forward_kinematics(q))
        S = tracker._state
        if S[at.PLANNED] == 1.0 and S[at.PLAN_AGE] == DT:
            knots = np.vstack([S[at.PLAN_Q : at.PLAN_V], S[at.KNOT : at.TREND].reshape(at.KNOTS, 7)])
            ahead = max(ahead, float((np.abs(np.diff(knots, axis=0) / gaps) / tracker.velocity_limit).max()))
            plans += 1
    assert plans > 500
    assert ahead <= 1.0 + ROUNDING


@pytest.mark.slow
def test_a_target_that_is_followed_with_foresight_of_others_is_not_left_by_a_plan_in_another_branch():
    """It was left for a third of the motion: joint 7 of the plan went 5 times as fast as it may."""
    arm, forward = arms.load("iiwa14"), arms.forward("iiwa14")
    found, bounds = run(arm, forward, known_motion(arm, 2040013, DT), DT)
    left = leaves(found, FORESEEN, DT)
    assert not [k for k in left if kept_to(arm, forward, found, k, FORESEEN, bounds, DT) <= 1.0]
    assert found.on.mean() > 0.85


@pytest.mark.parametrize(
    ("name", "kind", "seed"),
    [
        ("iiwa14", "joints", 77803),
        ("iiwa14", "singular", 77803),
        ("gen3", "joints", 77806),
        ("gen3", "singular", 77805),
    ],
)
def test_a_tip_that_falls_behind_stays_near_its_target(name, kind, seed):
    """Joints that went to another posture, each for itself, swung the tip aside by 125 to 552 mm."""
    arm = arms.load(name)
    moving = motion(arm, seed, 6.0, DT, kind, trouble=False)
    tracker = arm.tracker(moving.q0, DT)
    q = np.array([tracker.update(T).q for T in moving.given])
    position, _ = off_target(arms.forward(name), q, moving.true)
    assert passed(arm, moving.q0, q, limits(arm), DT).max() < ROUNDING
    assert position.max() < 0.04


@pytest.mark.slow
def test_along_limits_the_arm_is_ahead_of_what_comes():
    """A target foretold by velocity and acceleration alone was met for 75.6 % of the time."""
    arm, met = arms.load("human_left"), []
    for seed in range(81000, 81012):
        moving = motion(arm, seed, 8.0, DT, "limits", trouble=False)
        tracker = arm.tracker(moving.q0, DT, velocities(arm))
        q = np.array([tracker.update(T).q for T in moving.given])
        position, angle = off_target(arms.forward("human_left"), q, moving.true)
        met.append(((position < 1e-3) & (angle < 1e-2)).mean())
    assert np.mean(met) > 0.82
