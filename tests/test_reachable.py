"""Reachability of many poses, and places for a base: against Pinocchio, brute force and other ways to ask."""

import arms
import numpy as np
import pinocchio as pin
import pytest
from oracles import random_limb
from scipy.optimize import least_squares

import srs_ik
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, MIDDLE
from srs_ik.solve.reachable import largest_margins

ROOM = np.array([0.3, 0.3, 0.4])
UP = np.array([0.0, 0.0, 0.5])


def poses_around(arm, count, rng, size=0.9):
    """Random poses in a cube about the shoulder: some are reached, some not."""
    T = np.tile(np.eye(4), (count, 1, 1))
    for each in T:
        each[:3, :3] = pin.Quaternion(*_unit(rng.normal(size=4))).matrix()
        each[:3, 3] = arm.limb.shoulder + size * (arm.limb.upper_arm + arm.limb.forearm) * rng.uniform(-1.0, 1.0, 3)
    return T


def _unit(v):
    return v / np.linalg.norm(v)


@pytest.mark.parametrize("name", arms.EVERY)
def test_no_pose_of_a_configuration_inside_the_limits_is_missed(name):
    forward, count = arms.forward(name), 40 if name in arms.NEAR else 400
    poses = [forward(q).homogeneous for q in arms.configurations(name, count, 19)]
    assert arms.load(name).reachable_batch(poses).all()


@pytest.mark.parametrize("name", [name for name in arms.EVERY if name in arms.NEAR])
def test_near_arms_reach_as_far_as_they_are_stretched(name):
    """Beyond the nearest exact limb, too: straight elbows, where the axes that miss their centres lengthen the arm."""
    arm, forward = arms.load(name), arms.forward(name)
    Q = arms.configurations(name, 60, 27)
    Q[:, 3] = np.clip(arm.packed.elbow.straight + np.linspace(-1e-3, 1e-3, len(Q)), arm.lower[3], arm.upper[3])
    assert arm.reachable_batch([forward(q).homogeneous for q in Q]).all()


@pytest.mark.parametrize("name", arms.EXACT)
def test_poses_of_configurations_on_limits_are_not_missed(name):
    arm, forward, rng = arms.load(name), arms.forward(name), arms.generator(name, 20)
    Q = arms.configurations(name, 300, 21)
    for q in Q:
        for joint in rng.choice(7, rng.integers(1, 8), replace=False):
            limit = (arm.lower, arm.upper)[rng.integers(2)][joint]
            q[joint] = limit if np.isfinite(limit) else q[joint]
    poses = np.array([forward(q).homogeneous for q in Q])
    assert arm.reachable_batch(poses).all()
    found = arm.solve_batch(poses)
    assert found.ok.all()
    # Rounding past a limit is cut off, which next to a singularity moves the tip.
    assert max(found.position_error.max(), found.orientation_error.max()) < 1e-9


@pytest.mark.parametrize("name", [name for name in arms.EVERY if name in arms.NEAR])
def test_near_arms_on_limits_are_not_told_to_be_outside(name):
    """Where the nearest exact limb's postures are outside, and curves inside for a point alone."""
    arm, forward, rng = arms.load(name), arms.forward(name), arms.generator(name, 31)
    Q = arms.configurations(name, 200, 32)
    for q in Q:
        for joint in rng.choice(7, rng.integers(1, 7), replace=False):
            limit, inwards = ((arm.lower, 1.0), (arm.upper, -1.0))[rng.integers(2)]
            q[joint] = limit[joint] + inwards * rng.choice([0.0, 1e-6, 1e-3]) if np.isfinite(limit[joint]) else q[joint]
    poses = np.array([forward(q).homogeneous for q in Q])
    assert arm.reachable_batch(poses).all()
    assert arm.solve_batch(poses).ok.all()


@pytest.mark.parametrize("name", ["iiwa14", "human_arm", "made_bent", "gen3"])
def test_reached_is_what_has_an_interval(name):
    arm = arms.load(name)
    poses = poses_around(arm, 300 if name in arms.NEAR else 3000, arms.generator(name, 22))
    reached = arm.reachable_batch(poses)
    assert 0.02 < reached.mean() < 0.98
    np.testing.assert_array_equal(reached, arm.intervals_batch(poses).counts > 0)


@pytest.mark.parametrize("seed", range(8))
def test_limbs_with_any_axes_and_limits(seed):
    case = random_limb(seed, limits="mixed")
    arm = srs_ik.load(case.model, base="base", tip="tool")
    poses = [arm.forward_kinematics(case.configuration()) for _ in range(30)]
    assert arm.reachable_batch(poses).all()


@pytest.mark.slow
def test_what_is_not_reached_no_other_solver_finds():
    arm, rng = srs_ik.load("iiwa14"), np.random.default_rng(23)
    poses = poses_around(arm, 60, rng, size=0.6)
    missed = poses[~arm.reachable_batch(poses)][:6]
    assert len(missed) == 6
    for T in missed:
        for _ in range(15):
            start = rng.uniform(arm.lower, arm.upper)
            found = least_squares(_error, start, args=(arm, pin.SE3(T)), bounds=(arm.lower, arm.upper), xtol=1e-12)
            assert np.sqrt(2.0 * found.cost) > 1e-6


def _error(q, arm, T):
    return pin.log6(arm.forward_kinematics(q).actInv(T)).vector


def test_threads_and_wrong_input():
    arm = srs_ik.load("iiwa14")
    poses = poses_around(arm, 1000, np.random.default_rng(24))
    np.testing.assert_array_equal(arm.reachable_batch(poses, threads=1), arm.reachable_batch(poses, threads=2))
    assert arm.reachable_batch(np.empty((0, 4, 4))).shape == (0,)
    poses[7, 0, 0] = np.nan
    with pytest.raises(srs_ik.InvalidPose, match="7 of 1000"):
        arm.reachable_batch(poses)


def task_and_places(rng, poses=12, places=40):
    T_room_tip = np.tile(np.eye(4), (poses, 1, 1))
    for each in T_room_tip:
        each[:3, :3] = pin.Quaternion(*_unit(rng.normal(size=4))).matrix()
        each[:3, 3] = rng.uniform(-ROOM, ROOM) + UP
    T_room_base = np.tile(np.eye(4), (places, 1, 1))
    for each in T_room_base:
        each[:3, :3] = pin.rpy.rpyToMatrix(0.0, 0.0, rng.uniform(-3.0, 3.0))
        each[:2, 3] = rng.uniform(-1.0, 1.0, 2)
    return T_room_tip, T_room_base


@pytest.mark.parametrize("by", ["share", "width", "margin", "manipulability"])
def test_places_are_ranked_by_what_the_moved_arm_answers(by):
    arm = srs_ik.load("iiwa14")
    T_room_tip, T_room_base = task_and_places(np.random.default_rng(25), 6, 10)
    found = srs_ik.base_placement(arm, T_room_tip, T_room_base, by=by)
    for i, T in enumerate(T_room_base):
        there = arm.with_base(T)
        solutions = [there.solve(pose) for pose in T_room_tip]
        np.testing.assert_array_equal(found.reached[i], [bool(s) for s in solutions])
        expected = np.mean(
            [_value(there, pose, s, by) if s else 0.0 for pose, s in zip(T_room_tip, solutions, strict=True)]
        )
        assert found.value[i] == pytest.approx(expected, rel=1e-6, abs=1e-9)
    ranked = [(found.value[each.candidate], found.share[each.candidate]) for each in found]
    assert ranked == sorted(ranked, reverse=True)
    np.testing.assert_array_equal(found.best, T_room_base[next(iter(found)).candidate])
    with pytest.raises(TypeError, match=r"placement\[0\]\.share"):
        bool(found)


@pytest.mark.parametrize("name", arms.EXACT)
def test_the_largest_margin_is_that_of_the_posture_farthest_from_the_limits(name):
    arm = arms.load(name)
    T = poses_around(arm, 600, arms.generator(name, 28), size=0.8)
    found = arm.solve_batch(T)
    limits = arm.packed.family[0]
    margins = 1.0 - np.abs(found.q - limits[MIDDLE : MIDDLE + 7]) * limits[INVERSE_HALF_RANGE : INVERSE_HALF_RANGE + 7]
    expected = np.where(found.ok, margins.min(axis=1), 0.0)
    np.testing.assert_allclose(largest_margins(arm.packed, T), np.maximum(expected, 0.0), atol=1e-9)


def _value(arm, pose, solution, by):
    if by == "share":
        return 1.0
    if by == "width":
        return sum(interval.width for interval in arm.intervals(pose))
    if by == "margin":
        half = 0.5 * (arm.upper - arm.lower)
        return np.min(1.0 - np.abs(solution.q - 0.5 * (arm.lower + arm.upper)) / half)
    return arm.optimise(pose, "manipulability").value


def test_a_placement_says_what_is_wrong():
    arm = srs_ik.load("iiwa14")
    T_room_tip, T_room_base = task_and_places(np.random.default_rng(26), 2, 2)
    with pytest.raises(srs_ik.InvalidTask, match="did you mean 'margin'"):
        srs_ik.base_placement(arm, T_room_tip, T_room_base, by="margins")
    with pytest.raises(srs_ik.InvalidTask, match="one pose and among one candidate"):
        srs_ik.base_placement(arm, T_room_tip, np.empty((0, 4, 4)))
    T_room_base[1, :3, :3] *= 2.0
    with pytest.raises(srs_ik.InvalidPose, match="1 of 2"):
        srs_ik.base_placement(arm, T_room_tip, T_room_base)
