"""Paths through poses that leave a turn free, in scenes: found where a motion is known, clear by the real shapes."""

from itertools import pairwise

import coal
import numpy as np
import pinocchio as pin
import pytest
from arms import forward, load
from collision_oracle import Truth, clearance, file_of

import srs_ik
from srs_ik import FreeAxis

BETWEEN = 6
"""Postures that are looked at between two poses, beside those of the poses."""

ROOM = 0.005
"""A known motion keeps so far away from everything by the spheres, m."""


def dense(q):
    """Postures on the lines from each to the next."""
    parts = np.linspace(0.0, 1.0, BETWEEN + 2)[:, None]
    return np.vstack([a + parts * (b - a) for a, b in pairwise(q)])


def hindered(name, salt):
    """Poses of a motion, rolled at random, what is free, and a ball in the way of the best path without it alone."""
    rng, arm = np.random.default_rng(salt), load(name)
    lower, upper = np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0)
    while True:
        t = np.linspace(0.0, 1.0, 24)[:, None]
        waves = np.sin(2.0 * np.pi * rng.uniform(0.0, 0.5, 7) * t + rng.uniform(0.0, 2.0 * np.pi, 7))
        q = 0.5 * (lower + upper) + 0.5 * (upper - lower) * rng.uniform(0.0, 0.9, 7) * waves
        free = FreeAxis(rng.normal(size=3), cone=float(rng.choice([0.0, 0.2, 1.0, np.pi])))
        poses = np.array([forward(name)(each).homogeneous for each in q])
        for T in poses:
            T[:3, :3] = T[:3, :3] @ pin.exp3(free.axis * rng.uniform(-3.0, 3.0))
        if np.abs(np.diff(q, axis=0)).max() > 0.25:
            continue
        best = arm.solve_path(poses, free_axis=free)
        for _ in range(20):
            centre = arm.joint_frames(best.q[rng.integers(24)])[rng.integers(3, 6), :3, 3]
            radius = float(rng.uniform(0.04, 0.1))
            scene = srs_ik.Scene()
            scene.add_sphere("ball", centre, radius)
            tables = arm.tables(scene)
            if min(clearance(arm, tables, each) for each in dense(q)) > ROOM:
                return poses, free, scene, (centre, radius)


@pytest.mark.parametrize(
    ("name", "salt"),
    [("iiwa14", 1), *(pytest.param("iiwa14", salt, marks=pytest.mark.slow) for salt in (2, 3, 4, 5, 6))],
)
def test_a_path_is_found_where_a_motion_hits_nothing(name, salt):
    arm = load(name)
    poses, free, scene, (centre, radius) = hindered(name, salt)
    path = arm.solve_path(poses, free_axis=free, scene=scene)
    assert path
    assert (path.q >= arm.lower).all()
    assert (path.q <= arm.upper).all()
    assert np.abs(np.diff(path.q, axis=0)).max() <= 0.5
    assert max(path.position_error.max(), path.orientation_error.max()) < 1e-9
    for q, T in zip(path.q, poses, strict=True):
        tip = forward(name)(q)
        assert np.linalg.norm(tip.translation - T[:3, 3]) < 1e-9
        a, b = tip.rotation @ free.axis, T[:3, :3] @ free.axis
        assert np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b) < free.cone + 1e-9
    file, folders = file_of(arm)
    truth = Truth(file, arm, folders)
    at = np.eye(4)
    at[:3, 3] = centre
    truth.add("ball", at, coal.Sphere(radius))
    # What this scene keeps a path from is what it would do without.
    assert any(truth.collides(q) for q in dense(arm.solve_path(poses, free_axis=free).q))
    assert not any(truth.collides(q) for q in dense(path.q))


def test_a_pose_whose_every_turn_hits_something_is_not_reached():
    arm = load("iiwa14")
    q = np.linspace([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2], [0.5, 0.9, -0.4, -1.1, 0.5, 0.8, -0.2], 6)
    poses = np.array([forward("iiwa14")(each).homogeneous for each in q])
    scene = srs_ik.Scene()
    scene.add_sphere("ball", poses[3, :3, 3], 0.01)
    path = arm.solve_path(poses, free_axis=[0.0, 0.0, 1.0], scene=scene)
    assert not path.ok[3]
    broken = {each.sample: each for each in path.breaks}
    assert broken[3].message.startswith("Pose 3 is not reached")
    assert "ball" in broken[3].bodies


def test_a_path_that_hits_nothing_is_the_one_without_the_scene():
    arm = load("iiwa14")
    q = np.linspace([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2], [0.5, 0.9, -0.4, -1.1, 0.5, 0.8, -0.2], 6)
    poses = np.array([forward("iiwa14")(each).homogeneous for each in q])
    scene = srs_ik.Scene()
    scene.add_sphere("ball", [-2.0, 0.0, 0.0], 0.1)
    alone, found = (arm.solve_path(poses, free_axis=[0.0, 0.0, 1.0], **around) for around in ({}, {"scene": scene}))
    assert found
    np.testing.assert_array_equal(found.q, alone.q)
