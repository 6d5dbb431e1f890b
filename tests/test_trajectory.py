"""Motions through the postures of paths: against dense samples, finite differences and SciPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

import srs_ik
from srs_ik import InvalidConfiguration
from srs_ik.solve.path.timing import passing_times
from srs_ik.solve.path.trajectory import Trajectory

Q = np.array([0.2, 0.6, 0.1, -1.2, 0.2, 0.8, 0.1])


def line(arm, count, metres=0.2):
    poses = np.repeat(arm.forward_kinematics(Q).homogeneous[None], count, axis=0)
    poses[:, 1, 3] += np.linspace(0.0, metres, count)
    return poses


def dense(trajectory, count=20001):
    return trajectory.sample(trajectory.duration / (count - 1))


@pytest.mark.parametrize("count", [1, 2, 3, 40])
@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_a_motion_from_rest_to_rest_keeps_the_limits_at_all_times(name, count):
    arm = srs_ik.load(name)
    limit = np.linspace(4.0, 9.0, 7)
    path = arm.solve_path(line(arm, count, 0.005 * count), seed=Q, objective="time", acceleration_limit=limit)
    motion = path.trajectory()
    assert motion.duration == pytest.approx(path.times[-1] * motion.stretch)
    assert (np.diff(motion.passes) >= np.diff(path.times) * (1.0 - 1e-12)).all()
    assert 1.0 <= motion.stretch < 1.8
    if count == 1:
        assert motion.sample(0.01).q == pytest.approx(path.q)
        return
    times, q, v, a = dense(motion)
    assert (np.abs(v) <= arm.velocity_limit * (1.0 + 1e-9)).all()
    assert (np.abs(a) <= limit * (1.0 + 1e-9)).all()
    assert (q >= arm.lower).all()
    assert (q <= arm.upper).all()
    assert v[[0, -1]] == pytest.approx(np.zeros((2, 7)), abs=1e-12)
    # What is said of velocities and accelerations is what the angles do.
    h = times[1]
    assert np.diff(q, axis=0) / h == pytest.approx(0.5 * (v[1:] + v[:-1]), abs=1e-6)
    assert np.diff(v[:-1], axis=0) / h == pytest.approx(0.5 * (a[1:-1] + a[:-2]), abs=1e-2)
    # Between two samples joints move by 1e-4 rad at most.
    at = np.abs(times[:, None] - motion.passes).argmin(axis=0)
    assert q[at] == pytest.approx(path.q, abs=1e-3)
    # A limit is used up, or the path's own times are kept.
    used = max((np.abs(v) / arm.velocity_limit).max(), (np.abs(a) / limit).max())
    assert used > 0.98 or motion.stretch == 1.0


def test_with_dt_the_postures_are_passed_dt_apart_where_the_limits_let_them():
    arm = srs_ik.load("iiwa14")
    path = arm.solve_path(line(arm, 50), seed=Q, dt=0.05)
    motion = path.trajectory()
    assert motion.stretch == 1.0
    samples = motion.sample(0.05)
    assert samples.q == pytest.approx(path.q, abs=1e-12)
    clamped = CubicSpline(samples.times, path.q, bc_type="clamped")
    fine = motion.sample(0.001)
    assert fine.q == pytest.approx(clamped(fine.times), abs=1e-9)
    quick = arm.solve_path(line(arm, 50), seed=Q, dt=0.002).trajectory()
    assert quick.stretch > 1.0
    assert np.abs(dense(quick).velocity / arm.velocity_limit).max() == pytest.approx(1.0, abs=1e-4)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 12), narrow=st.booleans())
def test_random_postures_and_times(seed, count, narrow):
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.0, 1.0, (count, 7))
    times = np.append(0.0, np.cumsum(10.0 ** rng.uniform(-2.0, 0.5, count - 1)))
    if count > 3:
        q[2], times[2:] = q[1], times[2:] - (times[2] - times[1])  # the path stands still for a pose
    limits = (q.min(axis=0), q.max(axis=0)) if narrow else (np.full(7, -np.inf), np.full(7, np.inf))
    velocity, acceleration = rng.uniform(0.5, 3.0, (2, 7))
    stands = np.zeros(count - 1, dtype=bool)
    if count > 6:
        stands[4] = True
    motion = Trajectory(q, times, stands, limits, (velocity, acceleration))
    _, angles, v, a = dense(motion, 5001)
    assert np.isfinite(a).all()
    moving = motion.sample(motion.passes[4]).velocity[1] if count > 6 else np.zeros(7)
    assert np.abs(moving).max() <= 1e-9
    assert (np.abs(v) <= velocity * (1.0 + 1e-9)).all()
    assert (np.abs(a) <= acceleration * (1.0 + 1e-9)).all()
    assert (angles >= limits[0] - 1e-8).all()
    assert (angles <= limits[1] + 1e-8).all()
    at = np.abs(np.linspace(0.0, motion.duration, 5001)[:, None] - motion.passes).argmin(axis=0)
    assert np.abs(angles[at] - q).max() <= 3.0 * motion.duration / 5000


def test_samples_end_at_rest_in_the_last_posture():
    arm = srs_ik.load("iiwa14")
    path = arm.solve_path(line(arm, 20), seed=Q, objective="time", acceleration_limit=[5.0] * 7)
    times, q, v, a = path.trajectory().sample(0.004)
    assert np.diff(times) == pytest.approx(0.004)
    assert times[-2] < path.trajectory().duration <= times[-1]
    assert q[-1] == pytest.approx(path.q[-1], abs=1e-12)
    assert not v[-1].any()
    assert not a[-1].any()


def test_joints_without_end_go_on_over_pi():
    arm = srs_ik.load("gen3")
    q = Q.copy()
    q[0] = 3.1
    poses = [arm.forward_kinematics(q + 0.01 * k * np.eye(7)[0]) for k in range(12)]
    path = arm.solve_path(poses, seed=q, dt=0.1)
    angles = path.trajectory().sample(0.1).q
    assert np.abs(np.diff(angles, axis=0)).max() < 0.2
    assert angles[-1, 0] > np.pi


def test_what_is_no_motion_is_refused():
    arm = srs_ik.load("iiwa14")
    with pytest.raises(InvalidConfiguration, match="nothing says how fast"):
        arm.solve_path(line(arm, 5), seed=Q).trajectory()
    poses = line(arm, 5)
    poses[3, 0, 3] = 3.0
    with pytest.raises(InvalidConfiguration, match="breaks at pose 3"):
        arm.solve_path(poses, seed=Q, dt=0.1).trajectory()
    with pytest.raises(InvalidConfiguration, match="period must be a positive number"):
        arm.solve_path(line(arm, 5), seed=Q, dt=0.1).trajectory().sample(0.0)
    with pytest.raises(InvalidConfiguration, match="at most 1e\\+07"):
        arm.solve_path(line(arm, 5), seed=Q, dt=0.1).trajectory().sample(1e-12)
    with pytest.raises(InvalidConfiguration, match="no poses"):
        arm.solve_path([], dt=0.1).trajectory()
    long = arm.solve_path(line(arm, 5), seed=Q, dt=0.1)
    assert long.trajectory().sample(1e9).q[-1] == pytest.approx(long.q[-1])


def test_a_motion_that_does_not_begin_in_the_seed_says_so():
    arm = srs_ik.load("gen3")
    poses = line(arm, 5)
    away = Q + 0.2 * np.eye(7)[2]
    path = arm.solve_path(poses, seed=away, dt=0.1)
    gap = np.abs(path.q[0] - away).max()
    with pytest.warns(UserWarning, match=rf"the motion begins {gap:.3g} rad from the seed \(joint 'joint_"):
        path.trajectory()
    assert arm.solve_path(poses, known={0: Q}, dt=0.1).trajectory().sample(0.1).q[0] == pytest.approx(Q, abs=1e-9)


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
@pytest.mark.parametrize("options", [{"dt": 0.3}, {"objective": "time", "acceleration_limit": 2.0}])
def test_where_the_path_stands_still_the_tip_does(name, options):
    arm = srs_ik.load(name)
    there = line(arm, 4, 0.1)
    poses = np.concatenate([there[:1], there[:1], there, there[-1:], there[-1:], there[::-1]])
    path = arm.solve_path(poses, known={0: Q}, **options)
    motion = path.trajectory()
    _, q, v, _ = dense(motion, 4001)
    y = np.array([arm.forward_kinematics(each).translation[1] for each in q]) - there[0, 1, 3]
    assert y.min() > -1e-6
    assert y.max() < 0.1 + 1e-6
    stops = np.flatnonzero((np.diff(motion.passes) > 1e-6) & (np.abs(np.diff(poses, axis=0)).max(axis=(1, 2)) < 1e-12))
    at = np.abs(np.linspace(0.0, motion.duration, 4001)[:, None] - motion.passes[stops]).argmin(axis=0)
    assert np.abs(v[at]).max() < 0.02


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_times_of_a_path_know_of_its_rests(name):
    arm = srs_ik.load(name)
    poses = line(arm, 21)
    once = arm.solve_path(poses, objective="time", acceleration_limit=5.0).times[-1]
    path = arm.solve_path(np.insert(poses, 10, poses[10], axis=0), objective="time", acceleration_limit=5.0)
    # Two halves from rest to rest take root two times as long where accelerations bind, and no stretching comes on top.
    assert once < path.times[-1] < 1.6 * once
    assert path.trajectory().stretch < 1.25


def test_each_part_between_two_rests_is_as_fast_as_the_limits_let_it():
    limit = 2.0 * np.ones(7)
    angles = np.linspace(0.0, 1.0, 30)[:, None] * np.linspace(0.2, 1.0, 7)
    # A grip for five poses, whose postures differ by rounding; before it a line, behind it another one.
    q = np.concatenate([angles, angles[-1] + 1e-9 * np.arange(1, 5)[:, None] * np.ones(7), angles[::-1]])
    stands = np.zeros(len(q) - 1, dtype=bool)
    stands[29:34] = True
    times = passing_times(np.diff(q, axis=0), 2.0 * np.ones(7), limit, stands)
    free = (np.full(7, -np.inf), np.full(7, np.inf))
    motion = Trajectory(q, times, stands, free, (2.0 * np.ones(7), limit))
    alone = Trajectory(angles, times[:30], stands[:29], free, (2.0 * np.ones(7), limit))
    parts = np.diff(motion.passes[[0, 29, 34, -1]])
    # The same line there and back, and nothing of it in the 1.73 of the steps from rest to rest.
    assert parts[[0, 2]] == pytest.approx(alone.duration * np.ones(2), rel=1e-6)
    assert parts[1] == pytest.approx(np.sqrt(3.0) * (times[34] - times[29]), rel=1e-6)
    assert motion.stretch == pytest.approx(motion.duration / times[-1], rel=1e-12)
    assert motion.stretch < alone.stretch + 1e-3
    _, _, v, a = dense(motion)
    for part in (slice(0, 9000), slice(11001, None)):
        assert max(np.abs(v[part]).max() / 2.0, np.abs(a[part]).max() / 2.0) == pytest.approx(1.0, abs=0.01)
    assert (np.abs(a) <= limit * (1.0 + 1e-9)).all()


def test_where_the_path_stands_for_a_time_that_is_given_it_stands_as_long():
    arm = srs_ik.load("iiwa14")
    there = line(arm, 30)
    poses = np.concatenate([there, np.repeat(there[-1:], 20, axis=0)])
    path = arm.solve_path(poses, known={0: Q}, dt=0.005)
    motion = path.trajectory()
    assert motion.stretch > 1.0
    assert motion.passes[-1] - motion.passes[29] == pytest.approx(20 * 0.005, rel=1e-9)


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_a_motion_is_slow_where_limits_ask_for_it_alone(name):
    """Slowed down as a whole until it kept them at its ends and its corner, it took five times as long."""
    arm = srs_ik.load(name).with_limits(acceleration=np.full(7, 5.0))
    poses = np.concatenate([line(arm, 40), line(arm, 30)])
    poses[40:, :3, 3] = poses[39, :3, 3] + np.linspace(0.005, 0.15, 30)[:, None] * [0.0, 0.0, -1.0]
    path = arm.solve_path(poses, seed=Q, dt=0.02)
    motion, own = path.trajectory(), 69 * 0.02
    _, _, v, a = dense(motion)
    assert (np.abs(v) <= arm.velocity_limit * (1.0 + 1e-9)).all()
    assert (np.abs(a) <= 5.0 * (1.0 + 1e-9)).all()
    whole = CubicSpline(own * np.linspace(0.0, 1.0, 70), path.q, bc_type="clamped")
    at_once = own * np.sqrt(np.abs(whole(whole.x, 2)).max() / 5.0)
    assert at_once > 4.0 * own
    assert motion.duration < 1.8 * own
    # From pose to pose it is never quicker than the path's own times.
    assert (np.diff(motion.passes) >= 0.02 * (1.0 - 1e-9)).all()
