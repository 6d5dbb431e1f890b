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
from srs_ik.kernels.limb.triangle import shoulder_to_wrist, target_frame

STEPS = 20
NEARBY = 0.15
"""Starts are this far from a known configuration, rad a joint."""


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
