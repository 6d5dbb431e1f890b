"""The eight branches at an arm angle, their numbers, and the arm angle itself."""

from itertools import product

import arms
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from oracles import (
    Forward,
    arm_angle,
    distance,
    geometric_arm_angle,
    limbs,
    middle_phase,
    other_elbow_reaches,
    phases,
    wrapped,
)
from scipy.optimize import least_squares

import srs_ik


def gap(a, b):
    """Largest difference of joint angles, modulo whole turns."""
    return np.abs(wrapped(a - b)).max(axis=-1)


def assert_distinct(q):
    n = len(q)
    apart = gap(q[:, None], q[None]) + np.eye(n)
    assert apart.min() > 1e-6


@pytest.mark.parametrize("name", arms.EXACT)
def test_eight_branches_hold_the_configuration(name):
    arm, forward = arms.load(name), arms.forward(name)
    complete = 0
    for q in arms.configurations(name, 100):
        pose, psi = forward(q), arm.arm_angle(q)
        every = arm.solve_all(pose, arm_angle=psi, respect_limits=False)
        assert gap(every.q, q).min() < 1e-6
        if other_elbow_reaches(arm.limb, q) > 0.0:
            complete += 1
            assert every.branch.tolist() == list(range(8))
        else:
            # Oblique axes do not make every rotation: folded the other way, the elbow may ask too much of them.
            first = 4 * int(every[0].branch >= 4)
            assert every.branch.tolist() == list(range(first, first + 4))
        assert_distinct(every.q)
        for solution in every:
            assert solution
            assert max(distance(pose, forward(solution.q))) < 1e-11
    assert complete == 100 or name.startswith("romeo")
    assert complete > 50


@pytest.mark.parametrize("name", arms.EVERY)
def test_the_arm_angle_is_that_of_the_elbow(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.generator(name, 11).uniform(-np.pi, np.pi, (50, 7)):
        assert abs(wrapped(arm.arm_angle(q) - arm_angle(forward, arm.limb, q))) < 1e-9
        assert -np.pi <= arm.arm_angle(q) < np.pi


@pytest.mark.parametrize("name", arms.EXACT)
def test_all_branches_put_the_elbow_at_the_arm_angle(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 20, 12):
        psi = float(wrapped(arm.arm_angle(q) + 0.1))
        for solution in arm.solve_all(forward(q), arm_angle=psi, respect_limits=False):
            assert abs(wrapped(solution.arm_angle - psi)) < 1e-12
            assert abs(wrapped(arm_angle(forward, arm.limb, solution.q) - psi)) < 1e-9


@pytest.mark.parametrize("name", arms.here("iiwa14", "human_arm", "sia5d", "openarm_left", "romeo_left"))
def test_the_same_elbow_position_has_the_same_arm_angle(name):
    """Shoulder and wrist branches and the hand's rotation leave the elbow where it is."""
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 20, 13):
        elbow, psi = forward.carried(q, 4, arm.limb.elbow), arm.arm_angle(q)
        every = arm.solve_all(forward(q), arm_angle=psi, respect_limits=False)
        same = [s for s in every if np.linalg.norm(forward.carried(s.q, 4, arm.limb.elbow) - elbow) < 1e-9]
        assert len(same) >= 4
        assert max(abs(wrapped(arm.arm_angle(s.q) - psi)) for s in same) < 1e-9


def test_elbow_branches_of_an_arm_without_offset_share_the_elbow_position():
    arm, forward = arms.load("iiwa14"), arms.forward("iiwa14")
    for q in arms.configurations("iiwa14", 20, 14):
        every = arm.solve_all(forward(q), arm_angle=arm.arm_angle(q), respect_limits=False)
        elbows = np.array([forward.carried(s.q, 4, arm.limb.elbow) for s in every])
        assert np.ptp(elbows, axis=0).max() < 1e-9


@pytest.mark.parametrize("name", arms.here("iiwa14", "human_arm", "sia5d"))
def test_the_arm_angle_is_right_handed_about_shoulder_to_wrist(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 20, 15):
        pose, psi = forward(q), arm.arm_angle(q)
        W = forward.carried(q, 7, arm.limb.wrist)
        turned = arm.solve(pose, arm_angle=psi + 0.2, branch=arm.branch(q), respect_limits=False)
        before, after = (forward.carried(p, 4, arm.limb.elbow) for p in (q, turned.q))
        assert geometric_arm_angle(arm.limb.shoulder, after, W, before - arm.limb.shoulder) == pytest.approx(0.2)


@pytest.mark.parametrize("name", arms.here("iiwa14", "human_arm", "openarm_left", "sia5d"))
def test_arm_angle_zero_is_in_the_half_plane_of_the_reference(name):
    arm, forward = arms.load(name), arms.forward(name)
    S, reference = arm.limb.shoulder, arm.limb.reference
    for q in arms.configurations(name, 20, 16):
        solution = arm.solve(forward(q), arm_angle=0.0, respect_limits=False)
        E, W = (forward.carried(solution.q, k, p) for k, p in ((4, arm.limb.elbow), (7, arm.limb.wrist)))
        normal = np.cross(W - S, reference)
        assert abs((E - S) @ normal) < 1e-9
        assert np.cross(W - S, E - S) @ normal > 0.0


def test_another_reference_shifts_the_arm_angle_and_nothing_else():
    arm, other = arms.load("iiwa14"), srs_ik.load("iiwa14", reference=[0.3, -2.0, 0.4])
    for q in arms.configurations("iiwa14", 20, 17):
        S, W = arm.limb.shoulder, arms.forward("iiwa14").carried(q, 7, arm.limb.wrist)
        shift = geometric_arm_angle(S, S + other.limb.reference, W, arm.limb.reference)
        assert abs(wrapped(arm.arm_angle(q) - other.arm_angle(q) - shift)) < 1e-9
        assert arm.branch(q) == other.branch(q)


def test_branch_numbers_are_the_signs_of_the_middle_joints():
    arm = arms.load("iiwa14")
    for branch in range(8):
        signs = [-1.0 if branch & bit else 1.0 for bit in (2, 4, 1)]
        q = np.array([0.3, 0.7 * signs[0], -0.4, 1.1 * signs[1], 0.5, 0.6 * signs[2], -0.2])
        assert arm.branch(q) == branch
        assert arm.solve(arm.forward_kinematics(q), seed=q).branch == branch


def check_numbers(arm, q):
    """Bits against the sides of the middle positions, which plain geometry gives for axes of any direction."""
    axes = arm.limb.axes
    shoulder = np.sin(q[..., 1] - middle_phase(*axes[:3]))
    wrist = np.sin(q[..., 5] - middle_phase(*axes[4:]))
    a4, S, E, W = axes[3], arm.limb.shoulder, arm.limb.elbow, arm.limb.wrist
    back, forth = ((p - E) - a4 * (a4 @ (p - E)) for p in (S, W))
    straight = np.arctan2(a4 @ np.cross(forth, -back), forth @ -back)
    elbow = np.sin(q[..., 3] - straight)
    return 4 * (elbow < 0.0) + 2 * (shoulder < 0.0) + (wrist < 0.0)


@pytest.mark.parametrize("name", arms.EXACT)
def test_branch_numbers_of_real_arms(name):
    arm = arms.load(name)
    for q in arms.configurations(name, 30, 18):
        assert arm.branch(q) == check_numbers(arm, q)
        every = arm.solve_all(arm.forward_kinematics(q), arm_angle=arm.arm_angle(q), respect_limits=False)
        assert (every.branch == check_numbers(arm, every.q)).all()


@pytest.mark.parametrize("name", arms.EXACT)
@pytest.mark.parametrize("respect", [True, False])
def test_the_best_posture_at_an_arm_angle_is_the_best_of_all_branches(name, respect):
    """Each branch is asked for with a seed, whose answer is found joint by joint, and turned to the middles here."""
    arm, forward = arms.load(name), arms.forward(name)
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    middle, half = 0.5 * (arm.lower + arm.upper)[limited], 0.5 * (arm.upper - arm.lower)[limited]
    rng = np.random.default_rng(5)

    def margin(q):
        off = q[limited] - middle
        off -= 2.0 * np.pi * np.rint(off / (2.0 * np.pi))
        return (1.0 - np.abs(off) / half).min()

    met = 0
    for known in arms.configurations(name, 60, 8):
        pose, psi, seed = forward(known), rng.uniform(-np.pi, np.pi), rng.uniform(-1.0, 1.0, 7)
        each = [arm.solve(pose, arm_angle=psi, branch=b, seed=seed, respect_limits=False) for b in range(8)]
        margins = {b: margin(each[b].q) for b in range(8) if each[b]}
        best = arm.solve(pose, arm_angle=psi, respect_limits=respect)
        assert bool(best) == (max(margins.values(), default=-1.0) > 0.0 or (not respect and bool(margins)))
        if best:
            met += 1
            assert abs(margin(best.q) - max(margins.values())) < 1e-9
            assert max(distance(pose, forward(best.q))) < 1e-11
        for b, most in margins.items():
            alone = arm.solve(pose, arm_angle=psi, branch=b, respect_limits=False)
            assert alone.branch == b
            assert abs(margin(alone.q) - most) < 1e-9
    assert met > 10


@given(limbs())
def test_random_limbs_have_all_their_branches(limb):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    forward = Forward(limb.model, "base", "tool", arm.joint_names)
    for _ in range(3):
        q = limb.rng.uniform(-np.pi, np.pi, 7)
        pose, psi = forward(q), arm.arm_angle(q)
        assert abs(wrapped(psi - arm_angle(forward, arm.limb, q))) < 1e-9
        every = arm.solve_all(pose, arm_angle=psi, respect_limits=False)
        assert gap(every.q, q).min() < 1e-6
        assert (every.branch == check_numbers(arm, every.q)).all()
        assert len(every) == (8 if other_elbow_reaches(arm.limb, q) > 0.0 else 4)
        assert_distinct(every.q)
        for solution in every:
            assert max(distance(pose, forward(solution.q))) < 1e-10


@given(limbs(miss=0.01))
def test_random_limbs_whose_axes_miss_their_centres_hold_the_configuration(limb):
    """Away from singularities: next to one, a branch may have two postures at an arm angle, or lie elsewhere."""
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    forward = Forward(limb.model, "base", "tool", arm.joint_names)
    singular = phases(arm.limb)
    for _ in range(3):
        q = limb.rng.uniform(-np.pi, np.pi, 7)
        pose = forward(q)
        every = arm.solve_all(pose, arm_angle=arm.arm_angle(q), respect_limits=False)
        if min(abs(np.sin(q[joint] - phase)) for joint, phase in singular.items()) > 0.35:
            assert gap(every.q, q).min() < 1e-6
        assert_distinct(every.q)
        check_met(forward, pose, every)


SINGULAR_ALL_OVER = (
    [
        -2.0063285123593966,
        3.1415925535897933,
        -3.141592653588793,
        3.141592653589793,
        -3.141592643589791,
        1.9882552717898179,
        -3.094774303084184,
    ],
    [
        -3.141592653489793,
        3.141592753589793,
        3.141592653589793,
        3.141592653588793,
        -1.4896533148178233,
        1.1344640137963142,
        -3.141592653489793,
    ],
    [
        -0.20984784660700662,
        3.141592653589793,
        0.6924364203250484,
        3.141592653489793,
        -0.3508648279588944,
        4.52748693975621,
        1.027866748514838,
    ],
    [
        0.2173947747919156,
        3.141592653589793,
        -2.6917752980132232,
        3.141592654589793,
        -0.8665730681089592,
        1.5450831484145933,
        0.4221418713845688,
    ],
)
"""Postures of `j2s7s300` at an arm angle that no curve from the closed form's postures passes in all branches."""


@pytest.mark.skipif("j2s7s300" not in arms.here("j2s7s300"), reason="needs the file of the robot")
@pytest.mark.parametrize("q", SINGULAR_ALL_OVER)
def test_branches_that_no_curve_leads_to_are_met(q):
    arm, forward = arms.load("j2s7s300"), arms.forward("j2s7s300")
    pose = forward(np.array(q))
    every = arm.solve_all(pose, arm_angle=arm.arm_angle(q))
    assert every.branch.tolist() == list(range(8))
    check_met(forward, pose, every)


def check_met(forward, pose, every):
    for solution in every:
        assert max(distance(pose, forward(solution.q))) < 1e-9


@pytest.mark.parametrize("name", arms.here("iiwa14", "human_arm", "openarm_right"))
def test_with_limits_solve_all_keeps_exactly_the_branches_inside(name):
    arm, forward = arms.load(name), arms.forward(name)
    some_left_out = False
    for q in arms.configurations(name, 50, 19):
        pose, psi = forward(q), arm.arm_angle(q)
        every = arm.solve_all(pose, arm_angle=psi, respect_limits=False)
        kept = arm.solve_all(pose, arm_angle=psi)
        fits = [s.branch for s in every if any_turn_fits(s.q, arm)]
        assert kept.branch.tolist() == fits
        some_left_out |= len(fits) < 8
        assert arm.branch(q) in fits
        assert (kept.q >= arm.lower).all()
        assert (kept.q <= arm.upper).all()
    assert some_left_out


def any_turn_fits(q, arm):
    turned = wrapped(q)[:, None] + 2.0 * np.pi * np.arange(-2, 3)
    return bool(((turned >= arm.lower[:, None]) & (turned <= arm.upper[:, None])).any(axis=1).all())


def postures_by_search(forward, limb, q, psi):
    """Postures for the pose of one with an almost straight elbow, at an arm angle, by least squares from all over."""
    pose, phase = forward(q), phases(limb)

    def off(x):
        way = pin.log6(pose.actInv(forward(x))).vector
        return np.append(way, wrapped(np.array(arm_angle(forward, limb, x) - psi)))

    for s, e, w in product((1.0, -1.0), repeat=3):
        flip = np.pi * np.array([s < 0.0, 0.0, s < 0.0, 0.0, w < 0.0, 0.0, w < 0.0])
        start = q + flip
        start[1], start[5] = phase[1] + s * (q[1] - phase[1]), phase[5] + w * (q[5] - phase[5])
        for bend, turn, sense in product((0.03, 0.2), np.arange(3.0) * 2.0 * np.pi / 3.0, (1.0, -1.0)):
            there = start.copy()
            there[3], there[2], there[4] = phase[3] + e * bend, start[2] + turn, start[4] + sense * turn
            found = least_squares(off, there, xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=15)
            if np.abs(found.fun).max() < 1e-9:
                yield found.x


def side_of(limb, q):
    """Branch of a posture, and the least sine that tells it."""
    sines = [np.sin(q[joint] - phases(limb)[joint]) for joint in (3, 1, 5)]
    return sum(bit * (sine < 0.0) for bit, sine in zip((4, 2, 1), sines, strict=True)), np.abs(sines).min()


@pytest.mark.slow
@pytest.mark.parametrize("name", arms.here("gen3", "j2s7s300"))
def test_a_branch_asked_for_with_an_almost_straight_elbow_is_there_or_not(name):
    """What a search by least squares finds is there, what is there meets the pose, and some branches are not there."""
    arm, forward = arms.load(name), arms.forward(name)
    rng = arms.generator(name, 14)
    denied = searched = 0
    for q in arms.configurations(name, 3, 14):
        phase = phases(arm.limb)
        q[1], q[5] = phase[1] + rng.uniform(0.7, 1.4), phase[5] + rng.uniform(0.7, 1.4)
        q[3] = phase[3] + rng.uniform(0.0, 0.003)
        psi, pose = rng.uniform(-np.pi, np.pi), forward(q)
        answers = [arm.solve(pose, arm_angle=psi, branch=b, respect_limits=False) for b in range(8)]
        for branch, answer in enumerate(answers):
            denied += not answer
            if answer:
                assert max(distance(pose, forward(answer.q))) < 1e-9
                assert abs(wrapped(arm_angle(forward, arm.limb, answer.q) - psi)) < 1e-6
                assert side_of(arm.limb, answer.q)[0] == branch
        for found in postures_by_search(forward, arm.limb, q, psi):
            searched += 1
            branch, least = side_of(arm.limb, found)
            assert answers[branch] or least < 1e-6, (q.tolist(), psi, branch)
    assert denied
    assert searched
