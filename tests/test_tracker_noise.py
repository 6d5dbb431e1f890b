"""The noise of a target, as a tracker measures it by itself, and what it makes of it.

Noise is told by NumPy from how the targets were made, tips by Pinocchio on the robot's own file.
"""

import arms
import numpy as np
import pinocchio as pin
import pytest
from motions import motion, off_target
from tracked import NEAR_TARGET

from srs_ik.kernels.layout.track import WINDOWED

DT = 0.002
ROBOTS = arms.here("iiwa14", "gen3")
BENT = np.array([0.2, 0.6, 0.1, -1.2, 0.2, 0.8, 0.1])
"""A posture well inside the limits."""

SHAKEN = (5e-4, 2e-3)
"""Standard deviations of jitter along each axis, m, and about each, rad."""


def shaken(poses, deviations, seed):
    """Poses with white noise."""
    rng = np.random.default_rng(seed)
    out = np.array(poses)
    for T in out:
        T[:3, 3] += rng.normal(0.0, deviations[0], 3)
        T[:3, :3] = T[:3, :3] @ pin.exp3(rng.normal(0.0, deviations[1], 3))
    return out


def troubled(poses, seed):
    """Poses of which 5 % are lost, and which jump aside by 30 mm and 0.15 rad, and back: by less than ends a trend."""
    rng = np.random.default_rng(seed)
    n = len(poses)
    jump = pin.SE3(pin.exp3(np.array([0.0, 0.15, 0.0])), np.array([0.0, 0.0, 0.03])).homogeneous
    out = [T @ jump if n // 3 < k < n // 2 else T for k, T in enumerate(poses)]
    return [None if k and rng.uniform() < 0.05 else T for k, T in enumerate(out)]


def followed(name, q0, targets, dt=DT, **options):
    """(n, 7) joint angles, (n, 2) noise and (n,) time constants of the filter."""
    tracker = arms.load(name).tracker(q0, dt, **options)
    q, noise, smoothed = [], [], []
    for T in targets:
        q.append(tracker.update(T).q)
        noise.append(tracker.noise)
        smoothed.append(tracker.smoothed)
    return np.array(q), np.array(noise), np.array(smoothed)


@pytest.mark.parametrize("dt", [DT, 0.02])
@pytest.mark.parametrize("kind", ["joints", "limits", "singular", "hand", "reach"])
@pytest.mark.parametrize("name", ROBOTS)
def test_a_target_without_noise_is_taken_as_it_comes(name, kind, dt):
    moving = motion(arms.load(name), 5300, 1000 * dt, dt, kind, trouble=False)
    targets = troubled(moving.true, 1)
    q, noise, smoothed = followed(name, moving.q0, targets, dt)
    assert (smoothed == 0.0).all()
    # Of figures rounded to 1e-16, and of what jumps and lost targets leave: nothing.
    assert noise.max() < 1e-12
    np.testing.assert_array_equal(q, followed(name, moving.q0, targets, dt, smoothing=0.0)[0])


@pytest.mark.parametrize("deviations", [SHAKEN, (5e-6, 0.0), (0.0, 2e-5), (2e-3, 1e-2)])
@pytest.mark.parametrize("dt", [DT, 0.02])
@pytest.mark.parametrize("trouble", [False, True])
def test_white_noise_is_measured_also_between_jumps_and_lost_targets(trouble, dt, deviations):
    moving = motion(arms.load("iiwa14"), 5301, 2000 * dt, dt, "joints", trouble=False)
    targets = shaken(moving.true, deviations, 2)
    _, noise, _ = followed("iiwa14", moving.q0, troubled(targets, 3) if trouble else targets, dt)
    # The median of 32 samples varies by a third; that of 60 medians by a tenth of that.
    assert np.median(noise[100:], axis=0) == pytest.approx(deviations, rel=0.1, abs=1e-9)


def rarely(targets, every):
    """None between targets that come every so many updates, by turns."""
    out, at, turn = [None] * len(targets), 0, 0
    while at < len(targets):
        out[at] = targets[at]
        at += every[turn % len(every)]
        turn += 1
    return out


UNEVEN = [(10,), (9, 11), (1, 1, 1, 2), (1, 2)]
"""A camera, one that is not quite on time, every fifth target lost, every third."""


@pytest.mark.parametrize("every", UNEVEN)
@pytest.mark.parametrize("deviations", [SHAKEN, (5e-6, 0.0), (0.0, 2e-5)])
def test_noise_is_measured_where_targets_are_lost_between_others(every, deviations):
    moving = motion(arms.load("iiwa14"), 5301, 4000 * DT, DT, "joints", trouble=False)
    targets = rarely(shaken(moving.true, deviations, 2), every)
    _, noise, _ = followed("iiwa14", moving.q0, targets)
    # The median of 32 samples varies by a third; of the camera, there are 12 independent ones.
    assert np.median(noise[400:], axis=0) == pytest.approx(deviations, rel=0.2, abs=1e-9)


@pytest.mark.parametrize("every", UNEVEN)
def test_without_noise_none_is_measured_where_targets_are_lost_between_others(every):
    for kind in ("joints", "limits", "singular", "hand"):
        moving = motion(arms.load("iiwa14"), 5302, 4000 * DT, DT, kind, trouble=False)
        _, noise, smoothed = followed("iiwa14", moving.q0, rarely(moving.true, every))
        assert noise.max() < 1e-12
        assert (smoothed == 0.0).all()


@pytest.mark.parametrize("every", UNEVEN)
def test_with_jitter_and_lost_targets_a_tracker_by_default_is_on_target_longer_and_shakes_less(every):
    moving = motion(arms.load("iiwa14"), 5301, 3000 * DT, DT, "joints", trouble=False)
    targets = rarely(shaken(moving.true, SHAKEN, 2), every)
    shares, pushes = [], []
    for options in ({}, {"smoothing": 0.0}):
        q, _, _ = followed("iiwa14", moving.q0, targets, **options)
        position, angle = off_target(arms.forward("iiwa14"), q, moving.true)
        shares.append(((position < NEAR_TARGET[0]) & (angle < NEAR_TARGET[1])).mean())
        pushes.append(np.abs(np.diff(q, n=2, axis=0)).mean())
    assert shares[0] > 1.2 * shares[1]
    assert pushes[0] < 0.6 * pushes[1]


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("acceleration", [None, np.inf])
def test_with_jitter_a_tracker_by_default_is_on_target_longer_and_shakes_less(name, acceleration):
    arm = arms.load(name)
    by_default, by_hand, as_it_comes = [], [], []
    for seed, kind in enumerate(("joints", "limits", "singular", "hand"), 5310):
        moving = motion(arm, seed, 4.0, DT, kind, trouble=True)
        for figures, options in ((by_default, {}), (by_hand, {"smoothing": 0.02}), (as_it_comes, {"smoothing": 0.0})):
            q, _, _ = followed(name, moving.q0, moving.given, acceleration=acceleration, **options)
            position, angle = off_target(arms.forward(name), q, moving.true)
            on = (position < NEAR_TARGET[0]) & (angle < NEAR_TARGET[1])
            pushes = np.diff(q, n=2, axis=0) / DT**2
            figures.append([on.mean(), np.abs(pushes).mean(), np.abs(np.diff(pushes, axis=0)).mean()])
    share, push, jerk = np.mean(by_default, axis=0)
    usual, raw = np.mean(by_hand, axis=0), np.mean(as_it_comes, axis=0)
    assert share > 1.05 * raw[0]
    assert push < 0.55 * raw[1]
    assert jerk < 0.25 * raw[2]
    # As good as with the time constant that such jitter is best taken out with.
    assert share > 0.95 * usual[0]
    assert push < 1.05 * usual[1]
    assert jerk < 1.25 * usual[2]


def test_more_noise_is_smoothed_longer_and_none_that_no_joint_feels():
    T = arms.load("iiwa14").forward_kinematics(BENT).homogeneous
    lengths = []
    for size in (2e-5, 1e-3, 0.1, 1.0, 4.0):
        targets = shaken([T] * 200, (size * SHAKEN[0], size * SHAKEN[1]), 4)
        lengths.append(np.median(followed("iiwa14", BENT, targets)[2][100:]))
    assert lengths[0] == 0.0
    assert (np.diff(lengths) > 0.0).all()
    assert 0.01 < lengths[3] < 0.03


def test_once_the_noise_is_gone_the_target_is_met():
    start = arms.load("iiwa14").forward_kinematics(BENT).homogeneous
    poses = np.repeat(start[None], 1000, axis=0)
    poses[:, 1, 3] += 0.1 * np.sin(2.0 * DT * np.arange(1000))
    targets = [*shaken(poses[:500], SHAKEN, 5), *poses[500:]]
    q, _, smoothed = followed("iiwa14", BENT, targets)
    assert (smoothed[100:500] > 0.01).all()
    # Half of the window and some differences.
    assert (smoothed[500 + WINDOWED :] == 0.0).all()
    position, angle = off_target(arms.forward("iiwa14"), q[750:], poses[750:])
    assert max(position.max(), angle.max()) < 1e-6


def test_a_filter_does_not_lag_at_constant_acceleration():
    """For a filter of constant velocity it would be 0.2 mm: the acceleration by the square of the time constant."""
    start = arms.load("iiwa14").forward_kinematics(BENT).homogeneous
    t = DT * np.arange(1, 1001)
    poses = np.repeat(start[None], len(t), axis=0)
    poses[:, 1, 3] += 0.25 * np.maximum(t - 0.2, 0.0) ** 2
    poses = poses[t < 1.0]
    tracker = arms.load("iiwa14").tracker(BENT, DT, smoothing=0.02)
    q = np.array([tracker.update(T).q for T in poses])
    position, _ = off_target(arms.forward("iiwa14"), q[-10:], poses[-10:])
    # What is left of the beginning.
    assert position.max() < 1e-5


@pytest.mark.parametrize("name", ROBOTS)
def test_targets_that_come_every_tenth_update_are_followed_and_those_repeated_twice_or_thrice_are_smoothed(name):
    """A camera has fewer targets a second than the loop of the joints: None between them, or the last one again."""
    arm = arms.load(name)
    moving = motion(arm, 5331, 4.0, DT, "hand", trouble=False)

    def share(targets):
        q, _, smoothed = followed(name, moving.q0, targets)
        position, angle = off_target(arms.forward(name), q, moving.true)
        return ((position < NEAR_TARGET[0]) & (angle < NEAR_TARGET[1])).mean(), smoothed

    rarely, _ = share([None if k % 10 else T for k, T in enumerate(moving.true)])
    assert rarely > 0.9
    for times in (2, 3):
        again, smoothed = share([moving.true[k - k % times] for k in range(len(moving.true))])
        assert again > 0.9
        assert np.median(smoothed) > 0.01
