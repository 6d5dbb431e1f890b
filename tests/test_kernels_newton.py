"""Newton's method on the true chain of near limbs, against SciPy on Pinocchio's kinematics."""

import arms
import numpy as np
import oracles
import pinocchio as pin
import pytest
from numba import njit
from scipy.optimize import root

from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.chain.eight import put_eight, take_eight
from srs_ik.kernels.chain.newton import arm_angle, close_at_angle
from srs_ik.kernels.chain.newton_eight import close_eight
from srs_ik.kernels.layout.asked import Best, Goal, Target
from srs_ik.kernels.limb.branches import NO_BRANCH
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.triangle import place, shoulder_to_wrist, target_frame
from srs_ik.kernels.near.branch_search import close_starts
from srs_ik.kernels.near.second_attempts import MORE_STEPS

STEPS = 20
BESIDE = 0.01
NEARBY = 0.15
"""Starts are this far from a known configuration, rad a joint: the first from a singular one."""


@njit
def close_one(limb, q, R, p, psi, A):
    P = row(limb, 0)
    _, t, h0 = target_frame(P, shoulder_to_wrist(P, R, p))
    found, met = close_at_angle(P, q, R, p, t, h0, psi, STEPS, A)
    angle = arm_angle(P, found, t, h0)
    keep(limb)
    return found, met, angle


@njit
def close_rows(limb, rows, R, p, psi):
    P = row(limb, 0)
    _, t, h0 = target_frame(P, shoulder_to_wrist(P, R, p))
    q, met = close_eight(P, take_eight(row(rows, 0), 7), R, p, t, h0, psi, STEPS)
    put_eight(row(rows, 0), 7, met, q)
    keep(limb), keep(rows)


@njit
def met_in_step(limb, starts, R, p, psi):
    """Which of eight starts, as bits, lead to a posture at an arm angle in step."""
    P = row(limb, 0)
    place_ = place(P, R, p)
    _, met = close_eight(P, take_eight(row(starts, 0), 7), R, p, place_[0], place_[1], psi, MORE_STEPS)
    keep(limb), keep(starts)
    return met


@njit
def best_from(limb, start, R, p, psi, A):
    """The posture that `close_starts` makes of a start, and whether it makes one."""
    P = row(limb, 0)
    A[8:, :7] = start
    none = Best(NO_SEED, 2.0 * NO_BRANCH)
    goal = Goal(False, NO_SEED, False)
    best = close_starts(P, Target(R, p, place(P, R, p)), psi, -1, goal, none, MORE_STEPS, A)
    keep(limb)
    return best.q, best.cost < none.cost


def figures(pose: pin.SE3):
    return tuple(pose.rotation.ravel().tolist()), tuple(pose.translation.tolist())


def settled_by_scipy(name, start, pose, psi):
    """The configuration at a pose and arm angle next to a start, by Pinocchio and the definition of the arm angle."""
    arm, forward = arms.load(name), arms.forward(name)

    def misses(q):
        turn = np.remainder(oracles.arm_angle(forward, arm.limb, q) - psi + np.pi, 2.0 * np.pi) - np.pi
        return np.append(pin.log6(forward(q).actInv(pose)).vector, turn)

    return root(misses, start, tol=1e-13)


@pytest.mark.parametrize("name", ["gen3", "h1_2_left"])
def test_newton_settles_where_scipy_does(name):
    arm = arms.load(name)
    rng = arms.generator(name, 31)
    compared = 0
    for known in arms.configurations(name, 40, 31):
        pose, psi = arms.forward(name)(known), arm.arm_angle(known)
        start = known + rng.uniform(-NEARBY, NEARBY, 7)
        found, met, angle = close_one(arm.packed.family, tuple(start), *figures(pose), psi, np.empty((16, 9)))
        if not met:
            continue
        assert oracles.distance(pose, arms.forward(name)(np.array(found))) < (1e-11, 1e-11)
        assert oracles.wrapped(np.array(angle - psi)) == pytest.approx(0.0, abs=1e-8)
        expected = settled_by_scipy(name, np.array(found) + 1e-4, pose, psi)
        if expected.success:
            np.testing.assert_allclose(found, expected.x, rtol=0, atol=1e-7)
            compared += 1
    assert compared > 30


@pytest.mark.parametrize("name", ["gen3", "h1_2_left"])
def test_eight_in_step_settle_where_one_does(name):
    arm = arms.load(name)
    rng = arms.generator(name, 32)
    met_by_both = 0
    for known in arms.configurations(name, 25, 32):
        pose, psi = arms.forward(name)(known), arm.arm_angle(known)
        starts = known + rng.uniform(-NEARBY, NEARBY, (8, 7))
        rows = np.full((8, 7), np.nan)
        rows[:] = starts
        close_rows(arm.packed.family, rows, *figures(pose), psi)
        for start, q in zip(starts, rows, strict=True):
            found, met, _ = close_one(arm.packed.family, tuple(start), *figures(pose), psi, np.empty((16, 9)))
            if met and not np.array_equal(q, start):
                np.testing.assert_allclose(q, found, rtol=0, atol=1e-9)
                met_by_both += 1
    assert met_by_both > 150


def test_starts_next_to_two_singularities_go_on_alone_where_steps_in_eight_end():
    name, arm, forward = "gen3", arms.load("gen3"), arms.forward("gen3")
    rng = arms.generator(name, 33)
    in_step = 0
    for known in arms.configurations(name, 40, 33):
        known = known.copy()
        known[[1, 5]] = rng.choice([0.0, 1e-8, -1e-7, 1e-6], 2)
        pose, psi = forward(known), arm.arm_angle(known)
        starts = known + rng.uniform(-BESIDE, BESIDE, (8, 7))
        in_step += met_in_step(arm.packed.family, starts, *figures(pose), psi).bit_count()
        for start in starts:
            found, met = best_from(arm.packed.family, start, *figures(pose), psi, np.empty((16, 9)))
            assert met
            assert oracles.distance(pose, forward(np.array(found))) < (1e-10, 1e-10)
            assert oracles.wrapped(np.array(arm.arm_angle(np.array(found)) - psi)) == pytest.approx(0.0, abs=1e-8)
    assert in_step < 8 * 40
