"""Near arms next to a singular shoulder or wrist: every posture is found, at no more than some times the usual cost."""

import math
import time

import arms
import numpy as np
import pinocchio as pin
import pytest
from oracles import random_angles
from scipy.optimize import root

from srs_ik.kernels.layout import limb as at

TURNS = 12
"""Starts of the search for postures, around joint 1."""

CLEAR = 1e-5
"""A posture this far from where branches meet, rad, is told to be of one; next to where two meet, rounding decides."""


def next_to_singular(arm, middle, count, spread, salt):
    """Configurations with joint 2 or 6 next to singular, rad, and the elbow and the other of them well bent."""
    rng = np.random.default_rng(salt)
    P = arm.packed.family[at.LIMITED]
    turns = P[(at.SHOULDER if middle == 1 else at.WRIST) + at.PHASE] + np.pi * np.arange(-2, 3)
    singular = turns[(turns > arm.lower[middle] + spread) & (turns < arm.upper[middle] - spread)]
    while count > 0:
        q = random_angles(rng, arm.lower, arm.upper)
        q[middle] = rng.choice(singular) + rng.uniform(-spread, spread)
        if abs(math.sin(q[3] - P[at.STRAIGHT])) > 0.5 and abs(math.sin(q[6 - middle])) > 0.5:
            count -= 1
            yield q


def middle_sines(arm, q):
    """How far shoulder, elbow and wrist are from singular, each as a sine, with its sign."""
    P = arm.packed.family[at.LIMITED]
    phases = P[at.SHOULDER + at.PHASE], P[at.STRAIGHT], P[at.WRIST + at.PHASE]
    return np.sin(np.asarray(q)[1:6:2] - phases)


def postures_by_scipy(arm, pose, psi, start):
    """Postures of a pose at an arm angle, from starts that turn joint 1 against joint 3."""
    goal = pin.SE3(pose)

    def off(q):
        angle = arm.arm_angle(q) - psi
        return [*pin.log6(goal.actInv(arm.forward_kinematics(q))).vector, math.sin(0.5 * angle)]

    for turn in np.arange(TURNS) * 2.0 * np.pi / TURNS:
        for bend in (0.02, -0.02):
            found = root(off, start + np.array([turn, bend - start[1], -turn, 0.0, 0.0, 0.0, 0.0]), tol=1e-13)
            if found.success and np.abs(off(found.x)).max() < 1e-10:
                yield found.x


@pytest.mark.parametrize("name", arms.here("gen3"))
def test_every_posture_next_to_a_singular_shoulder_is_found(name):
    """Also where the true chain has none in some branches: SciPy finds no posture of these either."""
    arm = arms.load(name)
    fewer = 0
    for number, q in enumerate(next_to_singular(arm, 1, 24, 0.06, 3)):
        pose = arm.forward_kinematics(q).homogeneous
        # Also at arm angles at which no posture is known.
        psi = arm.arm_angle(q) + (0.0 if number % 2 else 0.02)
        solved = arm.solve_all(pose, psi, respect_limits=False)
        for found in postures_by_scipy(arm, pose, psi, q):
            sines = middle_sines(arm, found)
            if min(np.abs(sines)) > CLEAR:
                assert sum(bit for bit, sine in zip((2, 4, 1), sines, strict=True) if sine < 0.0) in solved.branch
        fewer += len(solved) < 8
    assert fewer > 4


def least_times(call, cases):
    """Of three calls of each case, in this thread alone."""
    times = np.empty((3, len(cases)))
    for k in range(3):
        for i, case in enumerate(cases):
            start = time.thread_time()
            call(*case)
            times[k, i] = time.thread_time() - start
    return times.min(axis=0)


@pytest.mark.parametrize("name", arms.here("gen3"))
def test_branches_next_to_a_singular_shoulder_cost_no_more_than_some_times_the_usual(name):
    """By the median over such poses: 11 times where curves are followed, 4 where postures are counted."""
    arm = arms.load(name)

    def cases(configurations):
        return [(arm.forward_kinematics(q).homogeneous, arm.arm_angle(q), False) for q in configurations]

    near = least_times(arm.solve_all, cases(next_to_singular(arm, 1, 80, 0.02, 4)))
    usual = least_times(arm.solve_all, cases(arms.configurations(name, 80, 4)))
    assert np.median(near) < 6.0 * np.median(usual)


@pytest.mark.parametrize("name", arms.here("j2s7s300"))
def test_seeds_next_to_a_singular_wrist_cost_no_more_than_some_times_the_usual(name):
    """By the median over such seeds: 70 times where all curves are followed."""
    arm = arms.load(name)
    rng = np.random.default_rng(6)

    def cases(configurations):
        for q in configurations:
            seed = np.clip(q + rng.uniform(-0.02, 0.02, 7), arm.lower, arm.upper)
            yield arm.forward_kinematics(q).homogeneous, None, seed

    near = least_times(arm.solve, list(cases(next_to_singular(arm, 5, 60, 0.02, 5))))
    usual = least_times(arm.solve, list(cases(arms.configurations(name, 60, 5))))
    assert np.median(near) < 20.0 * np.median(usual)
