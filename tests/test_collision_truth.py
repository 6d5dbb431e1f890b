"""Free arm angles against Pinocchio's collision check on the shapes of the robot's own file: none of them collides."""

import numpy as np
import pytest
from arms import generator
from collision_oracle import Truth, file_of_and
from robot_files import at_hand
from scene_sets import boxes_and_balls

import srs_ik

POSES, ANGLES = 25, 12

LEAST_SHARE = {"iiwa14": 0.85, "human_arm": 0.85, "gen3": 0.9, "human_left": 0.8}
"""Of the free postures those that are called free, at least: more than what spheres leave is not promised."""


def tried(arm, truth, scene, poses, angles, salt=0):
    """How many of random arm angles inside the limits are free, called free, and falsely so."""
    rng = generator(arm.name, salt)
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    free = called = false = 0
    for _ in range(poses):
        T = arm.forward_kinematics(rng.uniform(lower, upper)).homogeneous
        every = arm.intervals(T)
        left = arm.intervals(T, scene=scene)
        widths = np.array([each.width for each in every])
        for _ in range(angles if widths.sum() > 0 else 0):
            each = every[rng.choice(len(every), p=widths / widths.sum())]
            psi = float(rng.uniform(each.lower, each.upper))
            posture = arm.solve(T, arm_angle=psi, branch=each.branch)
            if not posture:
                continue
            is_free = not truth.collides(posture.q)
            is_called = any(i.branch == each.branch and psi in i for i in left)
            free, called, false = free + is_free, called + is_called, false + (is_called and not is_free)
    return free, called, false


@pytest.mark.parametrize("with_objects", [False, True])
@pytest.mark.parametrize("name", ["iiwa14", "human_arm", "gen3", "human_left"])
def test_nothing_called_free_collides(name, with_objects):
    if name == "human_left" and not at_hand("human"):
        pytest.skip("example-robot-data is not here")
    arm = srs_ik.load(name)
    truth, scene = Truth(*file_of_and(arm)), srs_ik.Scene()
    if with_objects:
        boxes_and_balls(arm, truth, scene)
    free, called, false = tried(arm, truth, scene, POSES, ANGLES)
    assert false == 0
    assert free > 50
    if not with_objects:
        assert called >= LEAST_SHARE[name] * free


@pytest.mark.parametrize("with_objects", [False, True])
@pytest.mark.parametrize("name", ["iiwa14", "gen3", "human_left"])
def test_the_exact_mode_finds_nearly_all_and_nothing_else(name, with_objects):
    """Of an exact arm, a near one, and one with meshes that are not convex, in few poses."""
    if name == "human_left" and not at_hand("human"):
        pytest.skip("example-robot-data is not here")
    arm = srs_ik.load(name)
    truth, scene = Truth(*file_of_and(arm)), srs_ik.Scene(exact=True)
    if with_objects:
        boxes_and_balls(arm, truth, scene)
    free, called, false = tried(arm, truth, scene, 8, 40, salt=1)
    assert false == 0
    assert called >= 0.99 * free
