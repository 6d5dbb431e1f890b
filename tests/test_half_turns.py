"""Poses half a circle from where the arm is, exactly: there sines of the turn vanish, as where it has arrived."""

import arms
import numpy as np
import pinocchio as pin
import pytest

import srs_ik
from srs_ik.control import ForceProfile, FractalImpedance, TorqueController

HALF_TURNS = {
    "x": np.diag([1.0, -1.0, -1.0]),
    "z, rounded": pin.rpy.rpyToMatrix(0.0, 0.0, np.pi),
    "z, almost": pin.exp3(np.array([0.0, 0.0, np.pi - 1e-12])),
    "oblique": pin.exp3(np.pi * np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)),
}
Q, THERE = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 0.8, -np.pi / 2]), np.array([0.0, 0.6, 0.0, -1.4, 0.0, 0.8, np.pi / 2])


# The wrist of a human arm turns about no axis far enough for the other two.
CASES = [
    (name, turn)
    for name in ("iiwa14", "gen3", "human_arm")
    for turn in HALF_TURNS
    if (name, turn[0]) != ("human_arm", "z")
]


@pytest.mark.parametrize(("name", "turn"), CASES)
def test_postures_before_a_half_turn_are_seeds_like_others(name, turn):
    arm, rng, reached = srs_ik.load(name), arms.generator(name, 180), 0
    while reached < 6:
        q = rng.uniform(np.maximum(arm.lower, -2.0), np.minimum(arm.upper, 2.0))
        before = arm.forward_kinematics(q)
        pose = pin.SE3(before.rotation @ HALF_TURNS[turn], before.translation)
        if not arm.intervals(pose):
            continue
        reached += 1
        answer = arm.solve(pose, seed=q)
        error = arm.verify(pose, answer.q)
        assert answer.status == "OK"
        assert max(error.position, error.orientation) < 1e-9
        # A seed beside it, whose turn is not half a circle, has the same nearest posture.
        assert abs(np.linalg.norm(answer.q - q) - np.linalg.norm(arm.solve(pose, seed=q + 1e-7).q - q)) < 1e-5
        assert arm.solve_batch([pose], seed=q).ok[0]
        assert arm.optimise(pose, "reference_posture", reference=q)
        assert not [
            b for b in arm.solve_path([before, pose], seed=q, longest_step=7.0).breaks if "not reached" in b.message
        ]


def test_a_tracker_turns_to_its_target():
    arm = srs_ik.load("iiwa14")
    tracker, pose = arm.tracker(Q, dt=0.01), arm.forward_kinematics(THERE)
    steps = [tracker.update(pose) for _ in range(400)]
    for step in steps:
        error = arm.verify(pose, step.q)
        assert (step.status == "OK") == (max(error.position, error.orientation) < 1e-6)
    assert steps[0].status == "LIMITED"
    assert steps[-1].status == "OK"


def test_an_impedance_pulls_about_the_axis_of_the_half_turn():
    arm = srs_ik.load("iiwa14")
    controller = TorqueController(arm, [FractalImpedance("orientation", ForceProfile.tanh(60, 12))])
    controller.set_posture(THERE)
    torque = controller.torque(Q, np.zeros(7)) - controller.gravity_torque
    error = controller.readings[0].error
    turned = pin.exp3(error) @ arm.forward_kinematics(Q).rotation
    np.testing.assert_allclose(turned, arm.forward_kinematics(THERE).rotation, atol=1e-12)
    pull = arm.jacobian(Q)[3:].T @ error / np.pi * 12.0
    np.testing.assert_allclose(torque, pull, atol=1e-3)
