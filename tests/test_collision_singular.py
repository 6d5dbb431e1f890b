"""A near limb among bodies at nearly singular poses, where its branches meet: Pinocchio's check, and a brute sweep."""

import numpy as np
import pinocchio as pin
import pytest
from arms import generator
from collision_oracle import Truth, file_of_and
from scene_sets import boxes_and_balls

import srs_ik

LOOKS = 12
"""Arm angles of every free interval that the sweep tries."""


@pytest.fixture(scope="module")
def among_things():
    """Gen3, what collides by Pinocchio, and a scene of the same things."""
    arm = srs_ik.load("gen3")
    truth, scene = Truth(*file_of_and(arm)), srs_ik.Scene()
    boxes_and_balls(arm, truth, scene)
    return arm, truth, scene


def nearly_singular(arm, rng):
    """A posture with most joints at, or next to, multiples of a right angle."""
    lower, upper = np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0)
    return np.clip(rng.choice([0.0, 0.5 * np.pi, -0.5 * np.pi, 1e-9, 1e-5], 7), lower, upper)


@pytest.mark.parametrize("number", range(4))
def test_the_nearest_free_posture_is_as_near_as_a_sweep_finds(among_things, number):
    arm, truth, scene = among_things
    rng = generator("nearly singular", number)
    T = arm.forward_kinematics(nearly_singular(arm, rng))
    seed = rng.uniform(np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0))
    free = arm.intervals(T, scene=scene)
    found = arm.solve(T, seed=seed, scene=scene)
    # Where spheres leave nothing, the real shapes may.
    assert found or not free
    if not found:
        return
    assert not truth.collides(found.q)
    assert max(found.position_error, found.orientation_error) < 1e-9
    nearest = np.inf
    for each in free:
        for psi in np.linspace(each.lower, each.upper, LOOKS):
            posture = arm.solve(T, arm_angle=float(psi), branch=each.branch, seed=seed)
            if posture and posture.branch == each.branch:
                nearest = min(nearest, np.linalg.norm(posture.q - seed))
    assert np.linalg.norm(found.q - seed) <= nearest + 1e-6


@pytest.mark.parametrize("number", range(4, 8))
def test_nothing_called_free_collides(among_things, number):
    arm, truth, scene = among_things
    rng = generator("nearly singular", number)
    called = 0
    T = arm.forward_kinematics(nearly_singular(arm, rng))
    for each in arm.intervals(T, scene=scene):
        for psi in rng.uniform(each.lower, each.upper, LOOKS):
            posture = arm.solve(T, arm_angle=float(psi), branch=each.branch)
            if posture and posture.branch == each.branch:
                called += 1
                assert not truth.collides(posture.q)
    assert called or not arm.intervals(T, scene=scene)


@pytest.mark.parametrize(
    ("name", "q"),
    [
        ("iiwa14", [2.9670597283903604, 1e-05, -2.66, 1e-09, 0.71, 0.0, 2.7]),
        ("iiwa14", [-1.46, -0.52, -0.13, 1e-09, -2.85, 1e-05, 0.0]),
        ("human_arm", [1.5707963267948966, -1.37, 1.06, 0.0, -0.11, -0.44, -0.11]),
        ("human_arm", [-0.44, -0.001, 0.78, 0.0, -1.19, 0.63, 0.5235987755982988]),
    ],
)
def test_every_free_interval_of_a_flat_elbow_has_its_posture(name, q):
    arm = srs_ik.load(name)
    scene = srs_ik.Scene()
    scene.add_sphere("ball", [0.5, 0.1, 0.3], 0.1)
    T = arm.forward_kinematics(q)
    free = arm.intervals(T, scene=scene)
    found = arm.solve_all(T, scene=scene)
    assert len(free) > 1
    assert len(found) == len(free)
    for solution in found:
        error = pin.log6(T.actInv(arm.forward_kinematics(solution.q))).vector
        assert np.abs(error).max() < 1e-9
        assert (solution.q >= arm.lower).all()
        assert (solution.q <= arm.upper).all()
