"""Poses out of reach whose stretched arm breaks the limits: the answer is the closest posture, by SciPy."""

import arms
import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import minimize

from srs_ik import Status

NAMES = arms.here("iiwa14", "gen3", "human_arm", "sia5d", "openarm_left")


def out_of_reach(name, count):
    """Poses whose answer is UNREACHABLE and does not keep the orientation: limits are in the way as well."""
    arm, rng = arms.load(name), arms.generator(name, 77)
    span = np.linalg.norm(arm.limb.elbow - arm.limb.shoulder) + np.linalg.norm(arm.limb.wrist - arm.limb.elbow)
    found = 0
    for _ in range(200):
        way = rng.normal(size=3)
        way *= span * rng.uniform(0.9, 3.0) / np.linalg.norm(way)
        turn = pin.Quaternion(*rng.normal(size=4)).normalized().matrix()
        pose = pin.SE3(turn, arm.limb.shoulder + way)
        solution = arm.solve(pose)
        if solution.status == Status.UNREACHABLE and solution.orientation_error > 1e-6:
            found += 1
            yield arm, pose, solution, rng
        if found == count:
            return


def errors(arm, pose, q):
    error = arm.verify(pose, q)
    return np.array([error.position, error.orientation])


@pytest.mark.parametrize("name", NAMES)
def test_no_other_posture_betters_both_errors(name):
    tried = 0
    for arm, pose, solution, rng in out_of_reach(name, 4):
        tried += 1
        own = errors(arm, pose, solution.q)
        np.testing.assert_allclose(own, [solution.position_error, solution.orientation_error], atol=1e-9)
        assert (solution.q >= arm.lower).all()
        assert (solution.q <= arm.upper).all()
        box = [(max(low, -np.pi), min(high, np.pi)) for low, high in zip(arm.lower, arm.upper, strict=True)]

        def worse(q, arm=arm, pose=pose, own=own):
            """What is least where both errors are lowered by as much as can be, made smooth."""
            return float(np.logaddexp.reduce(200.0 * (errors(arm, pose, q) - own)) / 200.0)

        for _ in range(6):
            found = minimize(worse, rng.uniform(*np.transpose(box)), bounds=box, method="L-BFGS-B").x
            assert (errors(arm, pose, found) - own).max() > -1e-4
    assert tried == 4


@pytest.mark.parametrize("name", NAMES)
def test_seeds_choose_the_turn_and_batches_agree(name):
    for arm, pose, solution, rng in out_of_reach(name, 2):
        seed = rng.uniform(np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0))
        seeded = arm.solve(pose, seed=seed)
        assert seeded.status == Status.UNREACHABLE
        free = ~np.isfinite(arm.lower)
        assert (np.abs(seeded.q - seed)[free] <= np.pi + 1e-9).all()
        batch = arm.solve_batch([pose, pose], threads=2)
        np.testing.assert_array_equal(batch.q[1], solution.q)


@pytest.mark.parametrize("distance", [1e3, 1e7, 1e150, 1e299])
def test_far_beyond_all_reach(distance):
    arm = arms.load("iiwa14")
    pose = pin.SE3(pin.rpy.rpyToMatrix(0.1, 2.0, 0.3), np.array([0.3, -0.5, -0.8]) * distance)
    solution = arm.solve(pose)
    assert solution.status == Status.UNREACHABLE
    assert np.isfinite(solution.q).all()
    assert ((solution.q >= arm.lower) & (solution.q <= arm.upper)).all()
