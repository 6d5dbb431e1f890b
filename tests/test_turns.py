"""Objectives that depend on the turn of a joint, where limits are more than a turn apart or where there are none."""

from itertools import product

import arms
import numpy as np
import pytest

import srs_ik

TURN = 2.0 * np.pi
IIWA = srs_ik.load("iiwa14").joint_names


def wide(lower: float, upper: float, joints=range(0, 7, 2)) -> srs_ik.Arm:
    """An iiwa 14 with other limits of some joints, rad."""
    return srs_ik.load("iiwa14", limits={IIWA[k]: {"lower": lower, "upper": upper} for k in joints})


def postures(arm, count: int) -> np.ndarray:
    lower, upper = np.clip(arm.lower, -7.0, 7.0), np.clip(arm.upper, -7.0, 7.0)
    return np.random.default_rng(3).uniform(lower, upper, (count, 7))


@pytest.mark.slow
@pytest.mark.parametrize("limits", [(-7.0, 7.0), (-TURN, TURN), (1.0, 8.0), (-12.0, 1.0)])
def test_a_function_of_joint_angles_has_its_optimum_in_any_turn(limits):
    arm = wide(*limits)
    for wanted in postures(arm, 6):
        pose = arm.forward_kinematics(wanted)
        found = arm.optimise(pose, lambda q, wanted=wanted: float(np.sum((q - wanted) ** 2)))
        assert found.value < 1e-12
        np.testing.assert_allclose(found.q, wanted, rtol=0.0, atol=1e-6)
        assert max(arm.verify(pose, found.q)) < 1e-11
        # What is said is the value of what is given, and no turn of any joint betters it.
        weights = np.linspace(-1.0, 1.0, 7)
        best = arm.optimise(pose, lambda q, w=weights: float(w @ q), maximise=True)
        assert best.value == pytest.approx(weights @ best.q, abs=1e-12)
        assert (best.q >= arm.lower).all()
        assert (best.q <= arm.upper).all()
        for turns in product((-1, 0, 1), repeat=4):
            other = best.q + TURN * np.array([turns[k // 2] if k % 2 == 0 else 0 for k in range(7)])
            if (other >= arm.lower).all() and (other <= arm.upper).all():
                assert weights @ other <= best.value + 1e-12
        sampled = [weights @ q for motion in arm.self_motion(pose, count=41) for q in motion.q]
        assert best.value >= max(sampled) - 1e-9


def test_without_limits_and_without_end_joints_come_in_the_first_turn():
    arm = arms.load("gen3")
    pose = arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    found = arm.optimise(pose, lambda q: float(q[0]), maximise=True)
    assert (np.abs(found.q) <= np.pi).all()
    free = wide(-7.0, 7.0).optimise(pose, lambda q: float(q[0]), respect_limits=False, maximise=True)
    assert (np.abs(free.q) <= np.pi).all()


def test_a_joint_with_many_turns_is_as_one_without_end():
    arm, calls = wide(-1e5, 1e5), []
    pose = arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    found = arm.optimise(pose, lambda q: calls.append(1) or float(q[0]), maximise=True)
    assert abs(found.q[0]) <= np.pi
    assert len(calls) < 10_000


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gen3", "wide"])
def test_a_reference_is_in_the_turns_in_which_it_is_given_among_bodies_too(name):
    """On gen3 a reference of its own pose, with joint 1 at 5 rad, had a value of 25 rad^2 in an empty scene."""
    arm, scene = arms.load("gen3") if name == "gen3" else wide(-7.0, 7.0), srs_ik.Scene()
    asked = 0
    for wanted in postures(arm, 8):
        pose = arm.forward_kinematics(wanted)
        alone = arm.optimise(pose, "reference_posture", reference=wanted)
        assert alone.value < 1e-12
        if not arm.solve(pose, seed=wanted, scene=scene) or np.abs(alone.q - wanted).max() > 1e-6:
            continue
        if np.abs(arm.solve(pose, seed=wanted, scene=scene).q - wanted).max() > 1e-6:
            continue
        asked += 1
        among = arm.optimise(pose, "reference_posture", reference=wanted, scene=scene)
        assert among.value < 1e-10
        assert among.value == pytest.approx(float(np.sum((among.q - wanted) ** 2)), abs=1e-12)
        if name == "wide":
            own = arm.optimise(pose, lambda q, wanted=wanted: float(np.sum((q - wanted) ** 2)), scene=scene)
            assert own.value < 1e-10
    assert asked > 1
