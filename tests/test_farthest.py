"""The posture farthest from the limits: none that a sweep closed in on by SciPy finds has more margin."""

import numpy as np
import pytest
from arms import EXACT, generator, load
from numba import njit
from oracles import random_angles, random_limb
from scipy.optimize import minimize_scalar

import srs_ik
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.exact.glance import GLANCES, NEXT_GLANCE, glance
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import elbow_side, place

COUNT = 48
"""Arm angles of a branch that are looked at first."""


def margins(arm, q):
    """(...) distance of the tightest joint from its nearest limit, as a part of half its range; 1 without limits."""
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    middle, half = 0.5 * (arm.lower + arm.upper)[limited], 0.5 * (arm.upper - arm.lower)[limited]
    return (1.0 - np.abs(q[..., limited] - middle) / half).min(axis=-1, initial=1.0)


def closed_in(arm, T, branch, respect):
    """The largest margin of a branch by a sweep and SciPy's line search around its three best arm angles."""
    psis = np.linspace(-np.pi, np.pi, COUNT, endpoint=False)
    swept = arm.solve_batch(np.repeat(T[None], COUNT, axis=0), arm_angle=psis, branch=branch, respect_limits=respect)
    found = np.where(swept.ok, margins(arm, swept.q), -np.inf)

    def cost(psi):
        answer = arm.solve(T, arm_angle=psi, branch=branch, respect_limits=respect)
        return -margins(arm, answer.q) if answer else 1e9

    best = found.max()
    for i in np.argsort(-found)[:3]:
        if np.isfinite(found[i]):
            span = psis[i] - 2 * np.pi / COUNT, psis[i] + 2 * np.pi / COUNT
            best = max(best, -minimize_scalar(cost, bounds=span, method="bounded", options={"xatol": 1e-9}).fun)
    return best


def limbs():
    for name in EXACT[:4]:
        yield pytest.param(lambda name=name: load(name), id=name)
    for k, (pattern, limits) in enumerate(
        [("oblique", "usual"), ("oblique", "mixed"), ("tilted", "wide"), ("coordinate", "narrow")]
    ):
        model = random_limb(700 + k, pattern=pattern, limits=limits).model
        yield pytest.param(lambda m=model: srs_ik.load(m, base="base", tip="tool"), id=f"{pattern}-{limits}")


@pytest.mark.parametrize("make", list(limbs()))
@pytest.mark.parametrize("respect", [True, False], ids=["limited", "free"])
def test_no_posture_has_more_margin(make, respect):
    arm = make()
    rng = generator(arm.name, 16)
    for k in range(6):
        T = arm.forward_kinematics(random_angles(rng, arm.lower, arm.upper)).homogeneous
        branch = None if k % 2 else int(rng.integers(8))
        answer = arm.solve(T, branch=branch, respect_limits=respect)
        best = max(closed_in(arm, T, b, respect) for b in (range(8) if branch is None else [branch]))
        if not answer:
            assert best == -np.inf
            continue
        assert max(arm.verify(T, answer.q)) < 1e-9
        # SciPy's search ends within 1e-9 rad of a corner, and joints may turn a little faster than the arm.
        assert margins(arm, answer.q) >= best - 1e-9


def test_where_the_elbow_is_tightest_the_others_have_room():
    """All postures of such a pose are as good; what is given is at a top of the margin of the other joints."""
    arm = load("iiwa14")
    rng = generator("iiwa14", 17)
    others = [0, 1, 2, 4, 5, 6]
    met = 0
    for _ in range(40):
        T = arm.forward_kinematics(random_angles(rng, arm.lower, arm.upper)).homogeneous
        answer = arm.solve(T)
        room = 1.0 - np.abs(answer.q[others]) / arm.upper[others]
        if 1.0 - abs(answer.q[3]) / arm.upper[3] > room.min() - 1e-9:
            continue
        met += 1
        for step in (-1e-3, 1e-3):
            beside = arm.solve(T, arm_angle=answer.arm_angle + step, branch=answer.branch)
            assert (1.0 - np.abs(beside.q[others]) / arm.upper[others]).min() <= room.min() + 1e-9
    assert met > 10


@njit
def glances(family, T, out):
    P = row(family, 0)
    R, p, _ = read_pose(row(T, 0))
    place_ = place(P, R, p)
    for elbow in range(2):
        out[elbow, 0], out[elbow, 1] = glance(P, elbow_side(P, place_, elbow), (-1, -1))
    keep(family), keep(T)


@pytest.mark.numba
@pytest.mark.parametrize("name", EXACT[:3])
def test_a_glance_tells_the_best_of_its_arm_angles(name):
    arm, rng, out = load(name), generator(name, 18), np.empty((2, 2))
    for _ in range(20):
        T = arm.forward_kinematics(random_angles(rng, arm.lower, arm.upper)).homogeneous
        glances(arm.packed.family, T, out)
        psis = NEXT_GLANCE * np.arange(GLANCES)
        for elbow in range(2):
            best = -np.inf
            for branch in range(4 * elbow, 4 * elbow + 4):
                q = arm.solve_batch(np.repeat(T[None], GLANCES, axis=0), psis, branch=branch, respect_limits=False).q
                q[:, 3] = 0.5 * (arm.lower + arm.upper)[3]
                best = max(best, margins(arm, q).max())
            assert abs(out[elbow, 1] + best) < 1e-5
