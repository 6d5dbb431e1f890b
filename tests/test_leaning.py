"""Exact arms that are made, and such whose axes lean by what a description rounds: 1.5708 leans one by 4e-6 rad.

Next to a singular posture that is not little: outer axes that lean never come into one line, and their joints turn fast
in arcs as narrow as the lean.
"""

import runpy
from itertools import islice
from pathlib import Path

import arms
import numpy as np
import pytest
from oracles import inside

import srs_ik

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"
LEANS = [1e-11, 1e-9, 1e-7, 1e-6]
"""By how much axes lean, rad: written with eleven digits, with nine, seven, and six."""

SINGULAR = ((1,), (3,), (5,), (1, 3), (3, 5))
"""Joints that are singular together."""


def leaning(lean, count, seed=3):
    made = runpy.run_path(str(BENCHMARKS / "subjects.py"))["random_arms"](np.random.default_rng(seed), 0.0, lean)
    return list(islice(made, count))


def assert_nothing_is_lost(bench, arm, some):
    intervals = list(arm.intervals_batch(np.array([case.pose for case in some]), threads=1))
    for case, found in zip(some, intervals, strict=True):
        assert bench["beside"](arm, case, found) < 1e-4, case.q.tolist()
    assert not list(bench["missed"](arm, some, intervals))


@pytest.mark.parametrize("lean", LEANS)
def test_known_postures_are_in_intervals_and_all_of_these_is_met(bench, lean):
    for arm in leaning(lean, 12):
        cases = bench["cases"](arm, 8, np.random.default_rng(7), (*SINGULAR, (1, 5)), 0.0)
        assert_nothing_is_lost(bench, arm, list(islice(cases, 8)))


@pytest.mark.skipif(not arms.here("human_left"), reason="example-robot-data is not here")
@pytest.mark.parametrize("name", ["icub_left", "icub_right"])
def test_arms_of_a_file_with_six_digits_lose_nothing(bench, name):
    cases = bench["cases"](srs_ik.load(name), 60, np.random.default_rng(5), bench["TOGETHER"], 0.0)
    assert_nothing_is_lost(bench, srs_ik.load(name), list(islice(cases, 60)))


def assert_none_is_farther_than_known(cases, arm, rng, count):
    for case in islice(cases, count):
        seed = np.clip(case.q + 0.1 * rng.normal(size=7), arm.lower, arm.upper)
        found = arm.solve(case.pose, seed=seed)
        assert found
        assert inside(found.q, arm.lower, arm.upper)
        assert np.linalg.norm(found.q - seed) <= np.linalg.norm(case.q - seed) + 1e-6, (case.q, seed)


@pytest.mark.parametrize("lean", LEANS)
def test_answers_are_no_farther_from_a_seed_than_a_known_posture(bench, lean):
    rng = np.random.default_rng(11)
    for arm in leaning(lean, 12):
        assert_none_is_farther_than_known(bench["cases"](arm, 8, rng, SINGULAR, 0.0), arm, rng, 8)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lean", "number"), [(0.0, 12), (0.0, 13), (0.0, 14), (0.0, 15), (1e-6, 14), (1e-6, 15), (1e-7, 14)]
)
def test_nor_where_joints_are_on_limits(bench, lean, number):
    rng = np.random.default_rng(number)
    for arm in leaning(lean, 40, 4):
        assert_none_is_farther_than_known(bench["cases"](arm, 8, rng, bench["TOGETHER"], 0.3), arm, rng, 8)


@pytest.mark.parametrize("lean", [1e-7, 1e-6])
def test_the_elbow_is_on_the_line_of_the_arm_stretched_out(lean):
    for arm in leaning(lean, 6):
        limb = arm.limb
        across = limb.axes[3]
        inner, outer = limb.elbow - limb.shoulder, limb.wrist - limb.elbow
        inner_along, outer_along = across @ inner, across @ outer
        sides = np.linalg.norm(inner - across * inner_along), np.linalg.norm(outer - across * outer_along)
        # Stretched out, the parts along axis 4 are to those across it as on one straight line.
        assert abs(inner_along / sides[0] - outer_along / sides[1]) < 1e-14
        assert np.linalg.norm(np.cross(limb.elbow - limb.points[3], across)) < 1e-15


@pytest.mark.slow
def test_where_all_is_singular_a_branch_has_the_splits_on_its_border(bench):
    """Rounding alone tells of which branches such postures are."""
    rng = np.random.default_rng(17)
    for arm in leaning(1e-6, 20):
        cases = bench["cases"](arm, 100, rng, ((1, 3, 5),), 0.0, 1.0)
        for case in islice((case for case in cases if case.offset == 0.0), 5):
            found = arm.solve(case.pose, seed=case.seed, branch=arm.branch(case.q))
            assert found
            assert inside(found.q, arm.lower, arm.upper)
            farther = np.linalg.norm(found.q - case.seed) - np.linalg.norm(case.q - case.seed)
            assert farther < 1e-6, (farther, case.q.tolist(), case.seed.tolist())
