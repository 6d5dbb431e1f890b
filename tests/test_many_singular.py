"""Almost exact limbs where two or three of shoulder, elbow and wrist are singular at once."""

import runpy
import sys
from itertools import islice
from pathlib import Path

import arms
import numpy as np
import pytest
from oracles import inside

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"
NAMES = (*arms.here("rm75"), "random_0", "random_1")
TOGETHER = ((1, 3), (3, 5), (1, 5), (1, 3, 5))
MISS = 1e-6

LEFT = 1.001e-10
"""Error of a pose (m, rad) that Newton's method may leave at such a posture, and rounding."""

LOST = 1
"""Known postures of 30 that no interval holds, at most."""


@pytest.fixture(scope="module")
def judges():
    """The scripts that try many more: their arms, seeded answers, and intervals."""
    sys.path.insert(0, str(BENCHMARKS))
    names = ("subjects", "singular", "known")
    yield {name: runpy.run_path(str(BENCHMARKS / f"{name}.py"), run_name=name) for name in names}
    sys.path.remove(str(BENCHMARKS))


def load(judges, name):
    """A real arm of a file with rounded figures, or a made one whose axes miss by as much."""
    if name in arms.PLACES:
        return arms.load(name)
    made = judges["subjects"]["random_arms"](np.random.default_rng(5), MISS, 0.0)
    return next(islice(made, int(name.split("_")[1]), None))


@pytest.mark.parametrize("joints", TOGETHER)
@pytest.mark.parametrize("name", NAMES)
def test_known_postures_bound_the_distance_from_any_seed(judges, name, joints):
    """Seeds from a breath to a radian beside the posture of which the pose is."""
    arm, rng = load(judges, name), np.random.default_rng(72)
    farther = 0
    for case in judges["singular"]["cases"](arm, 12, rng, (joints,)):
        seed = np.clip(case.q + rng.uniform(-1.0, 1.0, 7) * 10.0 ** rng.uniform(-3.0, 0.0), arm.lower, arm.upper)
        solution = arm.solve(case.pose, seed=seed)
        assert max(arm.verify(case.pose, solution.q)) < LEFT
        assert inside(solution.q, arm.lower, arm.upper)
        farther += np.linalg.norm(solution.q - seed) > np.linalg.norm(case.q - seed) + 1e-9
    assert farther == 0


@pytest.mark.parametrize("name", NAMES)
def test_known_postures_lie_in_an_interval(judges, name):
    arm, known = load(judges, name), judges["known"]
    lost = 0
    for case in judges["singular"]["cases"](arm, 30, np.random.default_rng(74), TOGETHER):
        away = known["beside"](arm, case, arm.intervals(case.pose))
        bend = max(abs(np.sin(case.q[3] - judges["singular"]["singular_angles"](arm.limb)[3])), 1e-300)
        lost += away > known["BESIDE"] + known["ROUNDING"] / bend
    assert lost <= LOST
