"""Joint paths in scenes: what is called clear never collides, looked at densely by Pinocchio on the robot's own file."""

import numpy as np
import pytest
from arms import generator
from collision_oracle import Truth, clearance, file_of
from scene_sets import KINDS, geometry_of, made, scene_of

import srs_ik
from srs_ik.solve.free.surroundings import Surroundings

BETWEEN = 6
"""Postures that are looked at between two poses, beside those of the poses."""


def motion(arm, rng, count, size=1.2):
    """(count, 7) a smooth joint motion inside the limits: two sines a joint."""
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    t = np.linspace(0.0, 1.0, count)[:, None]
    waves = sum(rng.uniform(-1, 1, 7) * np.sin(k * np.pi * t + rng.uniform(-3, 3, 7)) for k in (1, 2))
    middle = lower + (upper - lower) * rng.uniform(0.35, 0.65, 7)
    return np.clip(middle + 0.5 * size * waves, lower + 0.02, upper - 0.02)


def poses_of(arm, q):
    return np.array([arm.forward_kinematics(each).homogeneous for each in q])


def with_truth(name, kind, rng):
    arm = srs_ik.load(name)
    file, folders = file_of(arm)
    truth = Truth(file, arm, folders)
    objects = made(kind, arm, rng)
    for each in objects:
        truth.add(each.name, each.T, geometry_of(each))
    return arm, objects, truth


def lines_that_collide(path, truth):
    """How many lines of a path were looked at, and how many of those without a break hit something."""
    broken = {each.sample for each in path.breaks}
    looked = hits = 0
    for i, step in enumerate(path.steps):
        if i + 1 in broken or not (path.ok[i] and path.ok[i + 1]):
            continue
        looked += 1
        hits += any(truth.collides(path.q[i] + t * step) for t in np.linspace(0.0, 1.0, BETWEEN + 2))
    return looked, hits


def tried(name, kind, number, count, **scene):
    rng = generator(name + kind, number)
    arm, objects, truth = with_truth(name, kind, rng)
    path = arm.solve_path(poses_of(arm, motion(arm, rng, count)), scene=scene_of(objects, **scene), margin=0.005)
    return arm, objects, path, *lines_that_collide(path, truth)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_lines_called_clear_never_collide(name, kind):
    _, _, path, looked, hits = tried(name, kind, 0, 40)
    assert hits == 0
    assert looked > 0 or path.breaks


@pytest.mark.slow
@pytest.mark.parametrize("number", range(5))
@pytest.mark.parametrize("kind", KINDS)
def test_twenty_scenes_of_two_hundred_poses(kind, number):
    _, _, path, looked, hits = tried("iiwa14", kind, 10 + number, 200)
    assert hits == 0
    assert all(each.message for each in path.breaks)
    print(f"{kind} {number}: {looked} lines, {len(path.breaks)} breaks, {path.solved} poses")
