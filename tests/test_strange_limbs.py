"""Every question about one posture, put to limbs that nobody builds: none is answered worse than the known posture.

`benchmarks/questions.py` tries many more.
"""

import numpy as np
import pytest
from oracles import distance, inside
from strange_limbs import strange_limb

import srs_ik

# fmt: off
POSTURES = {
    15: (0.10051778286989532, 0.37179575220016226, -0.7608516778055114, 1.0306265523449527,
         -1.6481243442811906, 0.0035995450542665175, -0.3694043235148421),
    20: (-0.2306728107992434, 1.5714805775357696, -0.21547915816032648, 0.44158709452416245,
         -1.1835537466351362, 1.2673803233064704, -2.2206489257391486),
    1009: (-1.6698257981169304, -2.712741849108725, -1.6333831366261657, -2.6214775229681178,
           -3.8299980043808133, 0.38084396791067743, -0.20288158400392808),
    1018: (2.116379031454845, 1.157514133485246, -0.49277471270871764, 0.7847758784926251,
           -0.9071865333413127, -0.390115945362965, 0.13155496256985755),
    1041: (-0.8351682345624816, -2.3588297528662037, 0.8406057322126852, -0.5426531802859584,
           -1.5617425304677246, -2.041312151076231, 2.6092531595120074),
    2002: (-0.28057048770436555, 1.0671266155446422, 0.7671855853974043, 0.6721460469415059,
           -2.0260375459760382, 0.5909387999962032, 0.9651174694789351),
    2021: (2.49986631755291, 0.5457164666398127, 0.6671385825974561, 1.2159632756830399,
           -0.593643308871497, -2.4050397840187494, -0.7954133877130967),
    3079: (1.2863306121767257, 0.4341396006073279, 1.354908269323678, -0.9188474836684024,
           -1.0070389586465551, -0.7243448397020888, 1.1515372189414825),
}
SEEDS_AT_BORDERS = (
    (True, (2.07139039687152, 1.1575146683617301, -0.6658532072189701, 0.7957574658314077,
            -0.6141752293847387, -0.5775853103945502, 0.0653152669217564)),
    (False, (2.126303554215592, 1.1559859574138693, -0.4776588008210724, 0.815186584088909,
             -0.8896872325729308, -0.4318548471725508, 0.14718120458075046)),
)
# fmt: on


def known(number, kind, miss):
    """A strange limb, and a posture of it."""
    return srs_ik.load(strange_limb(number, kind, miss).model, base="base", tip="tool"), np.array(POSTURES[number])


def seed_around(q, around):
    return q + around * np.random.default_rng(1).uniform(-1.0, 1.0, 7)


def assert_no_farther(arm, q, seed, slack, **setting):
    """An answer meets the pose of a known posture, and is no farther from a seed than that."""
    pose = arm.forward_kinematics(q)
    answer = arm.solve(pose, seed=seed, **setting)
    assert answer
    assert max(distance(pose, arm.forward_kinematics(answer.q))) < 1e-9
    assert inside(answer.q, arm.lower, arm.upper) or not setting.get("respect_limits", True)
    assert np.linalg.norm(answer.q - seed) < np.linalg.norm(q - seed) + slack


@pytest.mark.parametrize("number", [15, 20])
@pytest.mark.parametrize("around", [0.0, 0.05, 0.3])
def test_a_seed_at_an_arm_angle_finds_the_branch_that_newton_missed(number, around):
    arm, q = known(number, "locked", 0.005)
    setting = {"arm_angle": arm.arm_angle(q), "respect_limits": False}
    assert_no_farther(arm, q, seed_around(q, around), 1e-9, **setting)


@pytest.mark.parametrize(
    ("number", "kind", "branch", "psi", "margin"),
    [(1009, "mixed", 7, -2.51, 0.22), (1041, "pinched", 4, 0.4943, 0.156), (3079, "pinched", 3, -0.74983075, 0.2088)],
)
def test_a_joint_that_passes_its_narrow_range_and_turns_back_hides_no_better_posture(number, kind, branch, psi, margin):
    (arm, q), objective = known(number, kind, 0.005), srs_ik.Objective("limit_margin")
    pose = arm.forward_kinematics(q)
    there = arm.solve(pose, arm_angle=psi, branch=branch)
    assert there
    assert objective.value(arm, there.q) > margin
    assert objective.value(arm, arm.solve(pose).q) > margin


@pytest.mark.parametrize(("respect", "seed"), SEEDS_AT_BORDERS)
def test_seeds_of_oblique_axes_are_looked_for_on_curves_next_to_borders(respect, seed):
    arm, q = known(1018, "pinched", 0.005)
    assert_no_farther(arm, q, np.array(seed), 1e-9, respect_limits=respect)


@pytest.mark.parametrize("branch", [None, 5])
@pytest.mark.parametrize("around", [0.05, 0.3])
def test_seeds_without_limits_are_met_where_an_exact_limb_is_singular_three_times(branch, around):
    arm, q = known(2021, "wide", 0.0)
    assert_no_farther(arm, q, seed_around(q, around), 1e-5, branch=branch, respect_limits=False)


@pytest.mark.parametrize("around", [0.0, 0.05, 0.3])
def test_a_seed_finds_its_branch_where_a_locked_joint_leaves_one_posture(around):
    arm, q = known(2002, "locked", 0.0)
    seed = np.clip(seed_around(q, around), arm.lower, arm.upper)
    assert_no_farther(arm, q, seed, 1e-6, branch=arm.branch(q))
