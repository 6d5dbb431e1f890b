"""Curves of near limbs: closed, on their pose, through every known configuration; nothing hides between samples."""

from __future__ import annotations

import runpy
from itertools import islice
from pathlib import Path

import arms
import numba
import numpy as np
import pytest
from oracles import postures_by_steps, random_limb

import srs_ik
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.curves.all_curves import MAX_CURVES, follow_all
from srs_ik.kernels.curves.changes import goes_on
from srs_ik.kernels.curves.follow import CURVE
from srs_ik.kernels.curves.in_step import SAMPLE
from srs_ik.kernels.curves.laid import LEAST_TURNED, LONGEST
from srs_ik.kernels.curves.told import TOLD, TOLD_PSI, TOLD_RATE, TOLD_SINES, turns_back
from srs_ik.kernels.layout.asked import Samples, Setting, Target
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import elbow_side, place

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"

BESIDE_ITSELF = [0.519780808, -0.874196618, 0.393787372, 0.00043453032, 1.367878079, 2.411936817, -2.517392925]

NEAR = arms.here("gen3", "j2s7s300", "h1_2_left", "rm75")


@numba.njit(error_model="numpy")
def curves_of(family, T, J, A, rows, curves):
    R, p, _ = read_pose(row(T, 0))
    P = row(family, 0)
    place_ = place(P, R, p)
    count, _ = follow_all(P, Setting(Target(R, p, place_), elbow_side(P, place_, 0), False, J, A), 0b1111, rows, curves)
    return count


def followed(arm, pose):
    """The curves of a pose: (N, 7) samples and whether they close."""
    rows, curves = np.empty((8192, SAMPLE)), np.empty((MAX_CURVES, CURVE))
    T = np.ascontiguousarray(pose.homogeneous)[None]
    count = curves_of(arm.packed.family, T, np.empty((6, 7)), np.empty((16, 9)), rows, curves)
    return [(rows[int(first) : int(last), 1:8], closed == 1.0) for first, last, closed in curves[:count]]


def away(angles):
    return np.abs((angles + np.pi) % (2.0 * np.pi) - np.pi)


@pytest.mark.parametrize("name", NEAR)
def test_curves_are_closed_on_the_pose_and_pass_every_known_configuration(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 25, 91):
        pose = arm.forward_kinematics(q)
        nearest = np.inf
        for samples, closed in followed(arm, pose):
            assert closed
            assert away(samples[-1] - samples[0]).max() < 1e-9
            for sample in samples[::7]:
                assert np.abs(forward(sample).homogeneous - pose.homogeneous).max() < 1e-9
            chords = (np.diff(samples, axis=0) + np.pi) % (2.0 * np.pi) - np.pi
            steps = np.linalg.norm(chords, axis=1)
            if steps.max() >= 0.35:
                # A curve that is laid out, not followed: longer steps, to first order, from which it hardly turns.
                assert steps.max() < 1.05 * LONGEST
                ways = chords[steps > 1e-6] / steps[steps > 1e-6, None]
                assert (ways[1:] * ways[:-1]).sum(axis=1).min() > LEAST_TURNED
            nearest = min(nearest, np.linalg.norm(away(samples - q), axis=1).min() - 0.5 * steps.max())
        # Half a step and what a curve bends in it.
        assert nearest < 0.05


@pytest.mark.parametrize("name", NEAR)
def test_no_curve_is_followed_twice(name):
    arm = arms.load(name)
    for q in arms.configurations(name, 10, 92):
        curves = [samples for samples, _ in followed(arm, arm.forward_kinematics(q))]
        for i, one in enumerate(curves):
            for other in curves[:i]:
                for sample in one[:-1:5]:
                    assert np.linalg.norm(away(other - sample), axis=1).min() > 1e-6


HIDDEN = {
    "bulge": ("tilted", 1001, 0.002, 17, True),  # a joint is outside for a moment, next to the limit of another
    "bulge between": ("coordinate", 1005, 0.005, 18, True),  # ... between two samples that keep all limits
    "turning": ("tilted", 1007, 0.01, 8, False),  # the arm angle turns around where a curve begins
}
"""Random limbs, the number of the configuration, and whether limits count."""


@pytest.mark.parametrize("what", HIDDEN)
def test_nothing_hides_between_samples(what):
    pattern, seed, miss, number, respect = HIDDEN[what]
    limb = random_limb(seed, pattern, "offset", "usual", miss)
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    q = [limb.configuration() for _ in range(number + 1)][-1]
    pose = arm.forward_kinematics(q)
    assert_whole(arm, pose, respect)


def assert_whole(arm, pose, respect):
    """Every arm angle of the intervals is met, and every one that is met is in an interval."""
    intervals = arm.intervals(pose, respect_limits=respect)
    for i in intervals:
        for psi in np.linspace(i.lower, i.upper, 42)[1:-1]:
            assert arm.solve(pose, arm_angle=psi, branch=i.branch, respect_limits=respect)
    for psi in np.linspace(-np.pi, np.pi, 720):
        for solution in arm.solve_all(pose, arm_angle=psi, respect_limits=respect):
            assert any(solution.branch == i.branch and psi in i for i in intervals)


@pytest.mark.parametrize("respect", [False, True])
def test_a_curve_that_comes_back_beside_itself_is_followed_to_both_ends(respect):
    made = runpy.run_path(str(BENCHMARKS / "subjects.py"))["random_arms"](np.random.default_rng(9), 1e-3, 0.0)
    arm = next(islice(made, 2, None))
    # Its corners are as sharp as 1e-6 rad; a step of Newton's that does not converge leaves the curve there.
    pose = arm.forward_kinematics(BESIDE_ITSELF)
    assert_whole(arm, pose, respect)
    (only,) = arm.intervals(pose, respect_limits=respect)
    # By steps along the null vector of Pinocchio's Jacobian, with the posture closed by Newton's method after each.
    lower, upper = ends_by_steps(arm, pose, np.array(BESIDE_ITSELF))
    assert abs(only.lower - lower) < 1e-4
    assert abs(only.upper - upper) < 1e-4


def ends_by_steps(arm, pose, q):
    """Least and greatest arm angle of the closed curve through a posture, followed in steps of at most 0.01 rad."""
    angles = np.unwrap([arm.arm_angle(each) for each in postures_by_steps(arm, pose, q)[0]])
    # Around the curve once, and back.
    assert abs(angles[-1] - angles[0]) < 0.1
    return angles.min(), angles.max()


@numba.njit(error_model="numpy")
def foretold(first, last):
    return turns_back(first, last)


@pytest.mark.parametrize("turns", [(0.2, 0.7), (0.45, 0.55), (-0.4, 0.5), (0.3, 1.6)])
def test_an_arm_angle_that_turns_around_twice_between_samples_is_foretold(turns):
    """Of a cubic with these places of its turns: only with both between, and then in the middle."""
    first, last = turns
    length, scale = 0.3, 0.4
    rate = np.polynomial.Polynomial.fromroots(turns) * scale
    angle = rate.integ()
    places = ((0.0, 0.0, rate(0.0) / length), (length, angle(1.0) - angle(0.0), rate(1.0) / length))
    share, found = foretold(*places)
    both = 0.0 < first < last < 1.0
    assert found == both
    if both:
        assert share == pytest.approx(0.5 * (first + last))


@numba.njit(error_model="numpy")
def goes_on_between(P, rows, told, rise):
    return goes_on(P, Samples(rows, 0, 2), 1, told, rise)


def test_nothing_is_looked_for_where_the_arm_angle_goes_on():
    """Of random cubics between two samples: none is passed over that turns, or before which the angle went back."""
    rng = np.random.default_rng(1)
    told = np.ones((2, TOLD))
    rows = np.zeros((2, SAMPLE))
    rows[1, 0] = length = 0.3
    P = np.zeros(0)
    passed_over = 0
    for rates in rng.uniform(-2.0, 2.0, (2000, 2)):
        told[:, TOLD_RATE] = rates
        told[1, TOLD_PSI] = told[0, TOLD_PSI] + length * rng.uniform(-2.0, 2.0)
        rise = rng.choice([-1.0, 1.0])
        if goes_on_between(P, rows, told, rise):
            change = told[1, TOLD_PSI] - told[0, TOLD_PSI]
            a, b = length * rates
            # Hermite's cubic on the way from 0 to 1.
            angle = np.polynomial.Polynomial([0.0, a, 3.0 * change - 2.0 * a - b, a + b - 2.0 * change])
            assert (rise * angle.deriv()(np.linspace(0.0, 1.0, 201)) > 0.0).all()
            assert not foretold((0.0, 0.0, rates[0]), (length, change, rates[1]))[1]
            passed_over += 1
    assert passed_over > 100
    # Nor where a middle angle is on either side of its singularity.
    told[:, TOLD_RATE], told[1, TOLD_PSI] = 1.0, told[0, TOLD_PSI] + length
    assert goes_on_between(P, rows, told, 1.0)
    told[1, TOLD_SINES + 1] = -1.0
    assert not goes_on_between(P, rows, told, 1.0)
