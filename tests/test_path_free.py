"""Paths through poses that leave a turn free, against motions that are known to go through them."""

import numpy as np
import pinocchio as pin
import pytest
from arms import forward, load

import srs_ik
from srs_ik import FreeAxis

LONGEST = 0.25
"""Longest joint step of a known motion, rad."""


def known_motion(name, salt):
    """A motion of up to 0.99 of the ranges of joints, what is free, its poses rolled at random, and its velocities."""
    rng, arm = np.random.default_rng(salt), load(name)
    lower, upper = np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0)
    count = int(rng.integers(12, 40))
    t = np.linspace(0.0, 1.0, count)[:, None]
    reach = 0.5 * (upper - lower) * rng.uniform(0.0, 0.99, 7)
    waves = np.sin(2.0 * np.pi * rng.uniform(0.0, 0.6, 7) * t + rng.uniform(0.0, 2.0 * np.pi, 7))
    q = 0.5 * (lower + upper) + reach * waves
    free = FreeAxis(rng.normal(size=3), cone=float(rng.choice([0.0, 0.2, 1.0, np.pi])))
    poses = np.array([forward(name)(each).homogeneous for each in q])
    for T in poses:
        T[:3, :3] = T[:3, :3] @ pin.exp3(free.axis * rng.uniform(-3.0, 3.0))
    assert np.abs(np.diff(q, axis=0)).max() < LONGEST
    return q, poses, free


def least_dt(name, q):
    """The time between two poses in which a motion takes 0.95 of a velocity limit."""
    return float((np.abs(np.diff(q, axis=0)) / load(name).velocity_limit).max()) / 0.95


def assert_goes_through(name, path, poses, free, longest):
    arm = load(name)
    assert path
    assert (path.q >= arm.lower).all()
    assert (path.q <= arm.upper).all()
    assert (np.abs(np.diff(path.q, axis=0)) <= longest).all()
    for q, T in zip(path.q, poses, strict=True):
        tip = forward(name)(q)
        assert np.linalg.norm(tip.translation - T[:3, 3]) < 1e-9
        a, b = tip.rotation @ free.axis, T[:3, :3] @ free.axis
        assert np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b) < free.cone + 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(("name", "salt"), [("iiwa14", 92), ("gen3", 63)])
def test_a_path_is_found_where_a_motion_is_known(name, salt):
    _, poses, free = known_motion(name, salt)
    assert_goes_through(name, load(name).solve_path(poses, free_axis=free), poses, free, 0.5)


@pytest.mark.parametrize(("name", "salt"), [("iiwa14", 66)])
def test_velocity_limits_are_kept_where_a_motion_keeps_them(name, salt):
    q, poses, free = known_motion(name, salt)
    dt = least_dt(name, q)
    path = load(name).solve_path(poses, dt=dt, free_axis=free)
    assert_goes_through(name, path, poses, free, dt * load(name).velocity_limit * (1.0 + 1e-9))
    assert (path.velocity_use <= 1.0).all()


@pytest.mark.slow
def test_what_breaks_for_good_says_no_more_than_that_no_path_was_found():
    """Poses that jump, and one out of reach: what is not reached is what no posture meets alone."""
    name = "iiwa14"
    motions = [known_motion(name, salt)[0] for salt in (45, 66)]
    poses = np.array([forward(name)(q).homogeneous for q in np.vstack(motions)])
    count, free = len(motions[0]), FreeAxis([0.0, 0.0, 1.0], cone=0.2)
    poses[5, :3, 3] += 3.0
    path = load(name).solve_path(poses, free_axis=free)
    alone = load(name).solve_batch(poses, free_axis=free)
    np.testing.assert_array_equal(path.ok, alone.ok)
    messages = {each.sample: each.message for each in path.breaks}
    assert messages[5].startswith("Pose 5 is not reached")
    assert messages[count].startswith(f"No path was found that goes on at pose {count}: joint ")
    assert not any("cannot be avoided" in message for message in messages.values())
    assert all(each.earliest is None and each.latest is None for each in path.breaks)


def test_no_poses_are_asked_for_with_what_there_is():
    arm, none = load("iiwa14"), np.empty((0, 4, 4))
    assert not len(arm.solve_path(none, free_axis=[0.0, 0.0, 1.0]))
    with pytest.raises(srs_ik.InvalidTask):
        arm.solve_path(none, free_axis=[0.0, 0.0, 0.0])
    with pytest.raises(srs_ik.InvalidTask):
        arm.solve_path(none, free_axis=[0.0, 0.0, 1.0], known={0: np.zeros(7)})
    with pytest.raises(srs_ik.InvalidConfiguration, match="no pose 7"):
        arm.solve_path(none, known={7: np.zeros(7)})
