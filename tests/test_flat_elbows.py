"""Intervals of poses that leave the bend of a straight elbow open: ends at any bend, and nothing that no bend has."""

import numpy as np
import pytest
from arms import load
from numba import njit

from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.exact.flat import ease, span_of_bends, stretch
from srs_ik.kernels.layout.limb import LIMITED, LOOSE, SIZE
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import place

STRAIGHT = np.array([0.3, 0.7, -0.4, 1e-6, 0.5, 0.8, -0.2])


@njit
def stretched(family, T, rows, out):
    boxes = np.empty((1, SIZE))
    P, eased = row(family, LOOSE + LIMITED), row(boxes, 0)
    ease(P, eased)
    R, p, _ = read_pose(row(T, 0))
    place_ = place(P, R, p)
    n = stretch((P, eased), place_, span_of_bends(P, place_), rows, out)
    keep(family), keep(T), keep(boxes)
    return n


@pytest.mark.numba
def test_a_narrow_interval_that_no_bend_has_is_none():
    arm = load("iiwa14")
    T = arm.forward_kinematics(STRAIGHT).homogeneous
    psis = np.linspace(-3.0, 3.0, 61)
    unmet, met = {}, {}
    for psi in psis:
        for branch in range(8):
            found = met if arm.solve(T, arm_angle=psi, branch=branch) else unmet
            found.setdefault(branch, psi)
    one, other = next((a, b) for a in unmet for b in met if a < b)
    rows = np.array([[one, unmet[one], unmet[one] + 1e-7], [other, met[other], met[other] + 1e-7]])
    out = np.full((8, 3), np.nan)
    assert stretched(arm.packed.family, T, rows[:1].copy(), out) == 0
    assert stretched(arm.packed.family, T, rows, out) == 1
    assert out[0, 0] == other
    assert (met[other] - out[0, 1]) % (2.0 * np.pi) <= out[0, 2] - out[0, 1]
