"""The times at which a path passes its poses: within limits of velocity and acceleration, and next to the least."""

import numpy as np
import pytest
from arms import generator, load
from known_paths import known_motion, poses_of
from scipy.optimize import minimize

import srs_ik
from srs_ik.solve.path.timing import passing_times


def measured(steps, times):
    """Joint velocities between poses, and accelerations at poses, from rest to rest, by finite differences."""
    h = np.diff(times)
    v = steps / h[:, None]
    middles = np.concatenate([times[:1], 0.5 * (times[1:] + times[:-1]), times[-1:]])
    rest = np.zeros((1, steps.shape[1]))
    return v, np.diff(np.vstack([rest, v, rest]), axis=0) / np.diff(middles)[:, None]


def smooth_steps(rng, count):
    t = np.linspace(0.0, 1.0, count)[:, None]
    return np.diff(rng.uniform(0.2, 1.0, 7) * np.sin(rng.uniform(1.0, 6.0, 7) * t + rng.uniform(0.0, 6.0, 7)), axis=0)


@pytest.mark.parametrize("count", [2, 3, 30, 300])
def test_limits_are_kept(count):
    rng = np.random.default_rng(count)
    for _ in range(5):
        steps, velocity, acceleration = smooth_steps(rng, count), rng.uniform(0.5, 3.0, 7), rng.uniform(2.0, 20.0, 7)
        times = passing_times(steps, velocity, acceleration)
        assert (np.diff(times) > 0.0).all()
        v, a = measured(steps, times)
        assert (np.abs(v) <= velocity * (1.0 + 1e-9)).all()
        assert (np.abs(a) <= acceleration * (1.0 + 1e-9)).all()
        assert max((np.abs(v) / velocity).max(), (np.abs(a) / acceleration).max()) == pytest.approx(1.0)


def test_a_straight_line_is_a_trapezoid():
    """2 rad at 1 rad/s and 2 rad/s^2: half a second to speed up, half to slow down, 1.5 s between."""
    steps = np.zeros((400, 7))
    steps[:, 0] = 2.0 / 400
    velocity, acceleration = np.full(7, 1.0), np.full(7, 2.0)
    assert passing_times(steps, velocity, acceleration)[-1] == pytest.approx(2.5, rel=1e-3)
    assert passing_times(steps, 10.0 * velocity, acceleration)[-1] == pytest.approx(2.0, rel=1e-3)


def test_a_search_over_all_times_finds_little_less():
    """The durations of all steps as unknowns of SciPy's SLSQP, with the limits as they are measured."""
    rng = np.random.default_rng(3)
    for _ in range(3):
        steps, velocity, acceleration = smooth_steps(rng, 25), rng.uniform(1.0, 3.0, 7), rng.uniform(3.0, 15.0, 7)
        times = passing_times(steps, velocity, acceleration)

        def room(h, steps=steps, velocity=velocity, acceleration=acceleration):
            v, a = measured(steps, np.append(0.0, np.cumsum(h)))
            return np.concatenate([(1.0 - np.abs(v) / velocity).ravel(), (1.0 - np.abs(a) / acceleration).ravel()])

        found = minimize(
            np.sum,
            np.diff(times),
            constraints={"type": "ineq", "fun": room},
            bounds=[(1e-4, None)] * 24,
            options={"maxiter": 200},
        )
        assert room(found.x).min() > -1e-6
        assert times[-1] <= 1.1 * found.fun


def test_a_path_that_stands_still_takes_no_time():
    assert passing_times(np.zeros((3, 7)), np.ones(7), np.ones(7)).tolist() == [0.0] * 4
    assert passing_times(np.zeros((0, 7)), np.ones(7), np.ones(7)).tolist() == [0.0]


def test_a_path_waits_for_nothing_where_it_stands_still_for_some_poses():
    steps = np.zeros((60, 7))
    steps[:20, 1] = steps[40:, 2] = 0.05
    times = passing_times(steps, np.full(7, 2.0), np.full(7, 5.0))
    assert np.isfinite(times).all()
    h = np.diff(times)
    assert (np.abs(steps) <= 2.0 * h[:, None] * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("name", ["iiwa14", "human_left"])
def test_paths_within_limits_of_acceleration(name):
    arm, rng = load(name), generator(name, 60)
    known = known_motion(arm, rng, 80, 0.08)
    poses, limit = poses_of(arm, known), np.full(7, 8.0)
    path = arm.solve_path(poses, objective="time", acceleration_limit=limit)
    assert path
    v, a = measured(path.steps, path.times)
    assert (np.abs(v) <= arm.velocity_limit * (1.0 + 1e-9)).all()
    assert (np.abs(a) <= limit * (1.0 + 1e-9)).all()
    assert path.value == path.times[-1]
    for other in (arm.solve_path(poses).q, arm.solve_path(poses, objective="time").q):
        assert path.times[-1] <= passing_times(np.diff(other, axis=0), arm.velocity_limit, limit)[-1] * (1.0 + 1e-6)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"acceleration_limit": np.ones(7)}, "objective='time'"),
        ({"acceleration_limit": np.zeros(7), "objective": "time"}, "positive"),
        (
            {"acceleration_limit": np.ones(6), "objective": "time"},
            "must be a positive .* or 7 of them",
        ),
        ({"acceleration_limit": "5", "objective": "time"}, "acceleration_limit must be a positive number, .*; not '5'"),
    ],
)
def test_wrong_limits_are_refused(options, named):
    arm = load("iiwa14")
    with pytest.raises(srs_ik.InvalidConfiguration, match=named):
        arm.solve_path([arm.forward_kinematics(np.full(7, 0.3))], **options)


def test_a_table_has_the_times_of_the_poses_where_they_are_known():
    arm = load("iiwa14")
    q = np.array([0.2, 0.6, 0.1, -1.2, 0.2, 0.8, 0.1])
    poses = np.repeat(arm.forward_kinematics(q).homogeneous[None], 6, axis=0)
    poses[:, 1, 3] += np.linspace(0.0, 0.05, 6)
    timed = arm.solve_path(poses, seed=q, objective="time", acceleration_limit=5.0)
    assert timed.as_table()["t"].tolist() == timed.times.tolist()
    assert list(timed.as_table())[:2] == ["t", arm.joint_names[0]]
    assert arm.solve_path(poses, seed=q, dt=0.1).as_table()["t"] == pytest.approx(0.1 * np.arange(6))
    assert "t" not in arm.solve_path(poses, seed=q).as_table()
