"""Almost exact limbs where two or three of shoulder, elbow and wrist are singular at once: what is lost there."""

import runpy
import sys
from pathlib import Path

import arms
import numpy as np
import pytest
from oracles import inside

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"
NAMES = (*arms.here("rm75"), "random_0", "random_1")
TOGETHER = ((1, 3), (3, 5), (1, 5), (1, 3, 5))
MISS = 1e-6


@pytest.fixture(scope="module")
def judges():
    """The scripts that try many more: of seeded answers, and of intervals."""
    sys.path.insert(0, str(BENCHMARKS))
    yield [runpy.run_path(str(BENCHMARKS / f"{name}.py"), run_name=name) for name in ("singular", "known")]
    sys.path.remove(str(BENCHMARKS))


def load(judges, name):
    """A real arm of a file with rounded figures, or a made one whose axes miss by as much."""
    if name in arms.PLACES:
        return arms.load(name)
    return list(judges[0]["random_arms"](2, 5, (MISS,)))[int(name.split("_")[1])]


@pytest.mark.xfail(strict=False, reason="a few postures are still missed where the curves are steepest")
@pytest.mark.parametrize("joints", TOGETHER)
@pytest.mark.parametrize("name", NAMES)
def test_a_known_posture_bounds_the_distance_from_any_seed(judges, name, joints):
    """Seeds from a breath to a radian beside the posture of which the pose is."""
    arm, rng = load(judges, name), np.random.default_rng(72)
    for case in judges[0]["cases"](arm, 12, rng, (joints,)):
        seed = np.clip(case.q + rng.uniform(-1.0, 1.0, 7) * 10.0 ** rng.uniform(-3.0, 0.0), arm.lower, arm.upper)
        solution = arm.solve(case.pose, seed=seed)
        assert max(arm.verify(case.pose, solution.q)) < 1e-11
        assert inside(solution.q, arm.lower, arm.upper)
        assert np.linalg.norm(solution.q - seed) < np.linalg.norm(case.q - seed) + 1e-9, case


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_seeded_answers_against_a_sweep_that_scipy_polishes(judges, name):
    arm = load(judges, name)
    known = judges[0]["Known"](arm)
    for case in judges[0]["cases"](arm, 8, np.random.default_rng(73), TOGETHER):
        away = judges[0]["farther"](arm, known, case)
        assert not judges[0]["is_told"](case, away), (case, away)


@pytest.mark.xfail(strict=False, reason="a few postures are still missed where the curves are steepest")
@pytest.mark.parametrize("name", NAMES)
def test_known_postures_lie_in_an_interval(judges, name):
    arm, known = load(judges, name), judges[1]
    for case in judges[0]["cases"](arm, 30, np.random.default_rng(74), TOGETHER):
        away = known["beside"](arm, case, arm.intervals(case.pose))
        bend = max(abs(np.sin(case.q[3] - judges[0]["singular_angles"](arm.limb)[3])), 1e-300)
        assert away < known["BESIDE"] + known["ROUNDING"] / bend, (case, away)
