"""Near limbs away from singularities: intervals and margins that the nearest exact limb predicts, against sweeps."""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import pairwise

import arms
import numpy as np
import pytest
from interval_oracle import assert_well_formed, disagreements
from oracles import closed_by_newton, postures_by_steps, random_limb
from scipy.optimize import minimize_scalar

import srs_ik
from srs_ik import Status
from srs_ik.kernels.layout import limb as at

NEAR = arms.here("gen3", "j2s7s300", "iiwa14_experimental", "rm75")

SHALLOW = {
    "gen3": [
        (
            -3.11677045424895,
            2.1328286828379,
            -2.21274125031904,
            -1.36981104765625,
            2.5735393046219,
            -1.97821600612058,
            1.26170610139727,
        ),
        (
            -1.76977324250128,
            -0.782859919458323,
            -2.63552388931865,
            -1.62412473688387,
            0.652840209624426,
            1.90886495238282,
            2.60463240704989,
        ),
    ],
    "j2s7s300": [
        (
            1.29904167630024,
            1.34512069596711,
            2.57956242847342,
            2.45990288737313,
            3.12955233390011,
            3.23558266598833,
            0.922459779225693,
        )
    ],
    "iiwa14_experimental": [
        (
            -0.721694745470292,
            -1.83400458576634,
            2.75183600174833,
            0.81906162555794,
            1.06075328513874,
            1.260780873377,
            0.469512290832126,
        )
    ],
}
"""Configurations of poses at which a joint is barely outside its limits for a while, between two feasible intervals."""


@pytest.mark.parametrize("name", [name for name in arms.here(*SHALLOW) if name in SHALLOW])
def test_shallow_gaps_are_found(name):
    arm = arms.load(name)
    for q in SHALLOW[name]:
        pose = arm.forward_kinematics(q)
        intervals = arm.intervals(pose)
        assert_well_formed(intervals)
        assert disagreements(arm, pose, intervals) == []


@pytest.mark.parametrize("name", NEAR)
def test_postures_are_feasible_up_to_a_limit_and_no_farther(name):
    arm = arms.load(name)
    ends = 0
    for q in arms.configurations(name, 12, 61):
        pose = arm.forward_kinematics(q)
        for i in arm.intervals(pose):
            if not 1e-5 < i.width < 2.0 * np.pi - 1e-5:
                continue
            for end, inwards in ((i.lower, 1e-7), (i.upper, -1e-7)):
                solution = arm.solve(pose, arm_angle=end + inwards, branch=i.branch)
                assert solution
                # The other ends are changes of branch, beside a singular posture.
                if min((solution.q - arm.lower).min(), (arm.upper - solution.q).min()) < 1e-5:
                    assert not arm.solve(pose, arm_angle=end - inwards, branch=i.branch)
                    ends += 1
    assert ends > 30


@pytest.mark.parametrize("name", NEAR)
def test_no_swept_posture_is_farther_from_the_limits(name):
    arm = arms.load(name)
    for q in arms.configurations(name, 6, 62):
        pose = arm.forward_kinematics(q)
        best = margin(arm, arm.solve(pose).q)
        for psi in np.linspace(-np.pi, np.pi, 240):
            for solution in arm.solve_all(pose, arm_angle=psi):
                assert margin(arm, solution.q) <= best + 1e-9


@pytest.mark.parametrize("name", NEAR)
def test_the_best_of_each_interval_is_in_it_and_one_is_the_best_of_all(name):
    arm = arms.load(name)
    for q in arms.configurations(name, 6, 63):
        pose = arm.forward_kinematics(q)
        found, intervals = arm.solve_all(pose), arm.intervals(pose)
        assert len(found) == len(intervals)
        assert all(any(s.branch == i.branch and s.arm_angle in i for i in intervals) for s in found)
        assert max(margin(arm, s.q) for s in found) == pytest.approx(margin(arm, arm.solve(pose).q), abs=1e-9)


@pytest.mark.parametrize("elbow", ["straight", "offset"])
@pytest.mark.parametrize("pattern", ["coordinate", "tilted"])
@pytest.mark.parametrize("miss", [1e-6, 0.003])
def test_random_limbs_with_square_axes(pattern, elbow, miss):
    for seed in range(4):
        limb = random_limb(700 + seed, pattern, elbow, "usual", miss)
        arm = srs_ik.load(limb.model, base="base", tip="tool")
        for _ in range(2):
            pose = arm.forward_kinematics(limb.configuration())
            intervals = arm.intervals(pose)
            assert_well_formed(intervals)
            assert disagreements(arm, pose, intervals, 180) == []


@pytest.mark.parametrize("name", arms.here("gen3", "j2s7s300"))
def test_barely_bent_elbows_next_to_those_that_may_be_straight(name):
    """The elbow's cosine is as far from straight as offsets may move it: by 0.2 to 1.3 times what they do at most."""
    arm, rng = arms.load(name), arms.generator(name, 66)
    P = arm.packed.family[0]
    widths = []
    for k, q in enumerate(arms.configurations(name, 10, 67)):
        q[3] = P[at.STRAIGHT] + np.arccos(1.0 - rng.uniform(0.2, 1.3) * P[at.COSINE_OFF]) * (-1.0) ** k
        pose = arm.forward_kinematics(q)
        intervals = arm.intervals(pose)
        assert_well_formed(intervals)
        assert any(i.branch == arm.branch(q) and in_it(i, arm.arm_angle(q)) for i in intervals)
        assert disagreements(arm, pose, intervals, 120) == []
        widths.append(sum(i.width for i in intervals))
    assert max(widths) > 2.0


@pytest.mark.parametrize("name", NEAR)
@pytest.mark.parametrize("joint", [2, 4, 6])
def test_arcs_next_to_singularities_and_elbows_at_their_limits(name, joint):
    """Shoulder or wrist next to singular, where curves are followed, or the elbow next to a limit."""
    arm, rng = arms.load(name), arms.generator(name, joint)
    for q in arms.configurations(name, 8, 65):
        near = abs(rng.normal()) * 0.02
        q[joint - 1] = arm.upper[3] - near if joint == 4 else singular(arm, joint) + near
        pose = arm.forward_kinematics(q)
        intervals = arm.intervals(pose)
        assert_well_formed(intervals)
        for branch, psi in disagreements(arm, pose, intervals, 180):
            # A branch may have two postures at an arm angle here, and `solve_all` lists the one outside the limits.
            assert any(i.branch == branch and psi in i for i in intervals)
            assert arm.solve(pose, arm_angle=psi, branch=branch)
        branch, psi = arm.branch(q), arm.arm_angle(q)
        assert any(i.branch == branch and in_it(i, psi) for i in intervals)
        best = margin(arm, arm.solve(pose).q)
        for psi in np.linspace(-np.pi, np.pi, 90):
            for solution in arm.solve_all(pose, arm_angle=psi):
                assert margin(arm, solution.q) <= best + 1e-9


def singular(arm, joint):
    """An angle inside the limits of joint 2 or 6 at which the axes of its neighbours are parallel."""
    phase = arm.packed.family[0, (at.SHOULDER if joint == 2 else at.WRIST) + at.PHASE]
    angles = phase + np.pi * np.arange(-4, 5)
    return angles[(angles > arm.lower[joint - 1] + 0.1) & (angles < arm.upper[joint - 1] - 0.1)][0]


def in_it(interval, psi):
    """Whether an arm angle is in an interval, up to rounding next to a singularity."""
    ahead = (psi - interval.lower + 1e-7) % (2.0 * np.pi)
    return ahead <= interval.width + 2e-7


@pytest.mark.parametrize("name", NEAR)
def test_out_of_reach_the_elbow_is_stretched_and_the_orientation_kept(name):
    """Wherever the limits allow it: the limb of a far pose's own orientation is looked at without them."""
    arm = arms.load(name)
    for q in arms.configurations(name, 10, 64):
        pose = arm.forward_kinematics(q).homogeneous
        direction = pose[:3, 3] - arm.limb.shoulder
        pose[:3, 3] += 2.0 * direction / np.linalg.norm(direction)
        solution = arm.solve(pose, respect_limits=False)
        assert solution.status == Status.UNREACHABLE
        reached = arm.forward_kinematics(solution.q).homogeneous
        assert np.abs(reached[:3, :3] - pose[:3, :3]).max() < 1e-9
        # No turn about the shoulder and no bend of the elbow brings the wrist nearer: the triangle is flat.
        wrist = pose[:3, 3] + pose[:3, :3] @ wrist_in_tip(arm)
        there = reached[:3, 3] + reached[:3, :3] @ wrist_in_tip(arm)
        reach = sum(np.linalg.norm(b - a) for a, b in pairwise((arm.limb.shoulder, arm.limb.elbow, arm.limb.wrist)))
        beyond = np.linalg.norm(wrist - arm.limb.shoulder) - reach
        assert np.linalg.norm(wrist - there) < beyond + 6.0 * arm.limb.misses.max() + 1e-9


def wrist_in_tip(arm):
    """The wrist centre in the tip frame."""
    T = arm.limb.T_base_tip_zero
    return T[:3, :3].T @ (arm.limb.wrist - T[:3, 3])


def margin(arm, q):
    """Least distance to a limit in parts of half the range; joints without limits do not count."""
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    lower, upper = arm.lower[limited], arm.upper[limited]
    return float(np.min(1.0 - np.abs(q[limited] - 0.5 * (lower + upper)) / (0.5 * (upper - lower))))


@pytest.mark.parametrize("name", arms.here("gen3", "j2s7s300", "rm75"))
def test_no_arm_angle_has_a_larger_margin_where_the_elbow_decides(name):
    arm = arms.load(name)
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    lower, upper = np.where(limited, arm.lower, -np.inf), np.where(limited, arm.upper, np.inf)
    middle = np.where(limited, 0.5 * (np.maximum(lower, -10.0) + np.minimum(upper, 10.0)), 0.0)
    half = 0.5 * (upper - lower)
    sweep = np.linspace(-np.pi, np.pi, 241)
    tried = 0
    for q in arms.configurations(name, 60, 77):
        pose = arm.forward_kinematics(q)
        solution = arm.solve(pose)
        used = np.abs(solution.q - middle) / half
        if not solution or used.argmax() != 3:
            continue
        tried += 1
        poses = np.repeat(pose.homogeneous[None], len(sweep), axis=0)
        answers = arm.solve_batch(poses, arm_angle=sweep, all_branches=True)
        others = (np.abs(answers.q - middle) / half).max(axis=-1)[answers.status == Status.OK]
        assert used.max() <= others.min() + 1e-9
    assert tried >= 3


COUNTED = """
import numpy as np, srs_ik
from srs_ik.kernels.curves import changes, laid
from srs_ik.kernels.near import arcs, on_curves, predicted_best
from srs_ik.kernels.layout.limb import STRAIGHT
arm = srs_ik.load("gen3")
calls = []
def count(module, name):
    kernel = getattr(module, name)
    setattr(module, name, lambda *given: (calls.append(name), kernel(*given))[1])
for module, name in {counted}:
    count(module, name)
{call}
print(len(calls))
"""


def curves_followed(call, counted="((on_curves, 'certain_runs'), (predicted_best, 'search_followed'))"):
    """How often all curves of a pose are followed in calls of gen3, told by kernels that are not compiled.

    Or other kernels called.
    """
    clean = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", COUNTED.format(call=call, counted=counted)],
        capture_output=True,
        text=True,
        env=clean,
        check=True,
        timeout=300,
    )
    return int(done.stdout)


SLIVERS = (
    (
        -0.66187201529906,
        -1.19924459072082,
        1.56297831642153,
        0.738642477092795,
        1.41847736970079,
        -1.74386015275265,
        -0.925240406881799,
    ),
    (
        0.521467288603056,
        1.06026941221308,
        -0.749241397475382,
        -1.25500004596704,
        0.809701794110522,
        -1.27092357689223,
        1.24223871718928,
    ),
    (
        0.376423471811116,
        -1.55676988269577,
        0.393366305411693,
        -0.97929000250142,
        2.9601332609646,
        -1.77466581983029,
        2.37318934345849,
    ),
)
"""The best posture is where the costs of two joints cross: none is better past it, though one of both falls."""


@pytest.mark.slow
def test_no_curves_are_followed_where_two_joints_decide():
    assert curves_followed(f"for q in {SLIVERS}: arm.solve(arm.forward_kinematics(q))") == 0


@pytest.mark.slow
def test_the_curves_of_a_pose_are_followed_once_for_many_arm_angles():
    call = (
        "q = np.array([0.3, 0.9, -0.5, arm.packed.family[0, STRAIGHT] + 0.02, 0.4, 1e-3, 0.2]);"
        "poses = np.repeat(arm.forward_kinematics(q).homogeneous[None], 3, 0);"
        "arm.solve_batch(poses, [0.1, 0.2, 0.3], all_branches=True, threads=1)"
    )
    assert curves_followed(call) == 1


TURNING = (
    -1.91569671428396,
    0.348041758480009,
    0.642387690846607,
    2.37685469865932,
    -2.68753659899304,
    -0.000113597106974783,
    1.53370969534831,
)
"""Its branch ends 6e-6 rad beside its arm angle, next to a singular wrist."""

LEANING = (
    2.23379523869942,
    0.139882330201076,
    -0.640641710657882,
    -0.0313949623322811,
    -3.09871881615031,
    -1.21160002631473,
    2.77945879234427,
)
"""The elbow is almost straight and the shoulder almost singular, but by more than the elbow can be bent."""

STRAIGHT = (
    0.871646043829398,
    1.17759027760354,
    1.8230662373569,
    -0.0121999548930005,
    -2.10452001674153,
    -0.453343128801712,
    1.14423922751663,
)
PASSING = (
    -2.02687094225084,
    -0.0892762341519568,
    -2.31671967981741,
    -0.989364124904295,
    -0.790884088278028,
    0.816215704869657,
    -1.15076464004689,
)
"""Shoulder and wrist pass by their singularities, one after the other."""


@pytest.mark.slow
def test_a_branch_that_arcs_show_next_to_its_end_needs_no_other_curves():
    arm = arms.load("gen3")
    pose, psi = arm.forward_kinematics(TURNING), arm.arm_angle(TURNING)
    found = arm.solve(pose, psi, branch=0)
    assert found
    assert max(arm.verify(pose, found.q)) < 1e-12
    assert abs(np.remainder(arm.arm_angle(found.q) - psi + np.pi, 2.0 * np.pi) - np.pi) < 1e-9
    assert curves_followed(f"q = {TURNING}; arm.solve(arm.forward_kinematics(q), {psi}, branch=0)") == 0


@pytest.mark.slow
def test_a_branch_of_an_almost_straight_elbow_needs_the_curves_of_its_signs_alone():
    call = f"pose = arm.forward_kinematics({STRAIGHT}); arm."
    counted, psi = "((laid, 'to_curves'),)", arms.load("gen3").arm_angle(STRAIGHT)
    every = curves_followed(call + "intervals(pose, False)", counted)
    own = curves_followed(call + f"solve(pose, {psi}, branch=0)", counted)
    assert 0 < 3 * own < every


@pytest.mark.slow
def test_a_shoulder_farther_from_singular_than_bends_reach_is_clear():
    arm = arms.load("gen3")
    pose = arm.forward_kinematics(LEANING)
    assert disagreements(arm, pose, arm.intervals(pose), 180) == []
    assert curves_followed(f"arm.intervals(arm.forward_kinematics({LEANING}))", "((laid, 'lay_predicted'),)") == 1


@pytest.mark.slow
def test_middle_angles_that_pass_by_a_singularity_are_not_looked_at_again():
    call = f"arm.intervals(arm.forward_kinematics({PASSING}))"
    assert curves_followed(call, "((arcs, 'follow_marks'),)") > 0
    assert curves_followed(call, "((changes, 'dip_between'),)") == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", arms.here("gen3", "j2s7s300"))
def test_no_posture_of_a_curve_is_farther_from_the_limits_than_the_best_one(name):
    arm = arms.load(name)
    straight = arm.packed.family[0, at.STRAIGHT]
    for number, q in enumerate(arms.configurations(name, 4, 93)):
        # So little bent that no prediction holds, and the curves are followed.
        q[3] = straight + (0.02 + 0.01 * number) * (1.0 if straight + 0.1 < arm.upper[3] else -1.0)
        pose = arm.forward_kinematics(q)
        postures, ways = postures_by_steps(arm, pose, q)
        best = max(range(len(postures)), key=lambda i: margin(arm, postures[i]))
        here, t = postures[best], ways[best]

        def lost(along, here=here, t=t, pose=pose):
            there = closed_by_newton(arm, pose, here + along * t, t, t @ here + along)
            return np.inf if there is None else -margin(arm, there)

        found = minimize_scalar(lost, bounds=(-0.01, 0.01), method="bounded", options={"xatol": 1e-12})
        assert margin(arm, arm.solve(pose).q) > -found.fun - 1e-9
