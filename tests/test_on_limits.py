"""Singular postures whose other joints are on limits: what rounding leaves of them is found, and the nearest of it.

The postures are known by construction. `benchmarks/singular.py` and `benchmarks/known.py` try many more.
"""

import runpy
import sys
from pathlib import Path

import arms
import numpy as np
import pytest
from oracles import distance, inside, phases

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"

NAMES = arms.here("iiwa14", "human_arm", "med7")


@pytest.fixture(scope="module")
def bench():
    sys.path.insert(0, str(BENCHMARKS))
    yield runpy.run_path(str(BENCHMARKS / "known.py"), run_name="known")
    sys.path.remove(str(BENCHMARKS))


def bent_little(name, count, salt, least, most):
    """Postures with joints 2 and 6 on limits and a bend of the elbow between two powers of ten, and seeds around them."""
    arm, rng = arms.load(name), arms.generator(name, salt)
    straight = phases(arm.limb)[3]
    for q in arms.configurations(name, count, salt):
        for joint in (1, 5):
            q[joint] = (arm.lower, arm.upper)[rng.integers(2)][joint]
        bend = 10.0 ** rng.uniform(least, most)
        q[3] = straight + bend if straight + bend <= arm.upper[3] else straight - bend
        yield q, np.clip(q + 10.0 ** rng.uniform(-4.0, -0.3) * rng.uniform(-1.0, 1.0, 7), arm.lower, arm.upper)


def assert_no_farther(name, q, seed):
    arm, forward = arms.load(name), arms.forward(name)
    pose = forward(q)
    solution = arm.solve(pose, seed=seed)
    assert solution, q.tolist()
    assert max(distance(pose, forward(solution.q))) < 1e-9
    assert inside(solution.q, arm.lower, arm.upper)
    farther = np.linalg.norm(solution.q - seed) - np.linalg.norm(q - seed)
    assert farther < 1e-6, (farther, q.tolist(), seed.tolist())


@pytest.mark.parametrize(("least", "most"), [(-12.0, -6.0), (-6.0, -4.0), (-4.0, -3.0)])
@pytest.mark.parametrize("name", NAMES)
def test_the_nearest_posture_of_a_flat_elbow_with_two_joints_on_limits(name, least, most):
    """Each bend that the pose leaves open has its own arm angles, and the one it seems to have may have none."""
    for q, seed in bent_little(name, 25, 81, least, most):
        assert_no_farther(name, q, seed)


def test_a_posture_six_radians_nearer():
    q = "-2.9085056371629383 2.0943951023931953 -.6883472562299473 1.1220607739645686e-05 .27792328080109163 "
    seed = "-2.920879095555911 2.0943951023931953 -.7024788152305194 .0023060138866191618 .27263622492168005 "
    q, seed = q + "-2.0943951023931953 .6466494486720618", seed + "-2.0943951023931953 .6365981774572843"
    assert_no_farther("iiwa14", np.array(q.split(), float), np.array(seed.split(), float))


@pytest.mark.parametrize("name", NAMES)
def test_a_flat_elbow_with_two_joints_on_limits_is_solved_without_a_seed(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q, _ in bent_little(name, 25, 82, -12.0, -4.0):
        solution = arm.solve(forward(q))
        assert solution, q.tolist()
        assert max(distance(forward(q), forward(solution.q))) < 1e-9
        assert inside(solution.q, arm.lower, arm.upper)


@pytest.mark.parametrize("name", NAMES)
def test_every_interval_of_a_flat_elbow_has_its_posture(name):
    arm, forward, seen = arms.load(name), arms.forward(name), 0
    for q, _ in bent_little(name, 12, 83, -12.0, -4.0):
        pose = forward(q)
        intervals, every = arm.intervals(pose), arm.solve_all(pose)
        assert sorted(i.branch for i in intervals) == sorted(every.branch.tolist()), q.tolist()
        assert all(max(distance(pose, forward(row))) < 1e-9 for row in every.q)
        assert all(inside(row, arm.lower, arm.upper) for row in every.q)
        assert all(-np.pi <= i.lower < np.pi for i in intervals)
        seen += len(intervals)
    assert seen > 12


ON_LIMITS = {
    "iiwa14": [
        # An elbow that is told to 1e-8 rad, two joints on limits.
        "2.9670597283903604 1.0851618413054882 -1.1635576430107546 -0.0001 -0.6713318880353674 2.0943951023931953 "
        "3.0543261909900767",
        # Limits that a joint almost touches: where the bend lets it.
        "-2.9670597183903604 0.4804281070081613 -0.9347916579729683 -1e-06 -2.9670597183903604 1e-06 1.721745058168385",
        "0.639097210870728 -0.4478024330709216 2.9670597283803604 0.0001 1.5465193923851963 -0.6413492589599881 "
        "3.0543261909800767",
        # Both outer joints of a singular shoulder.
        "-2.9670597283903604 0.0001 -2.9670597283903604 1.6584164185957495 -0.46429277943491964 -0.9110974133381942 "
        "3.0543261909900767",
    ],
    "human_arm": [
        "1.5707963267948966 -1.5707963167948966 -3.141592653589793 -0.44060925050757715 0.5716907685246475 "
        "-1.3962634015954636 -0.11267746473124199",
        "-0.10710158898492428 1.5707963167948966 -3.141592653589793 -1.1443244603554616 -0.11910509552754656 "
        "0.22150063460788694 -0.3490658503988659",
        "1.3803237164962385 1.5706963267948966 -3.141592653589793 -0.0001 0.7390399674937906 0.6716213640982602 "
        "0.5235987755982988",
        "1.4503313743234658 2.6179938779914944 0.1536831201213169 -2.4871883629073187e-09 -0.9321310218483052 "
        "1.2217304763960306 0.13117742090097534",
    ],
    "human_left": [
        "1.0882440231912618 -0.016876387497678502 -1.4142958385214537 1.4151895948473872 3.14159 -1.5707963257948965 "
        "0.785398",
        "-1.3370532615594348 0.3400953688278556 0.5962926122608969 2.617991667 3.14159 -1.5707863267948965 0.785398",
    ],
}
"""Postures next to singular ones with some joints on limits, each the only one of its arm angles, or at their end."""


@pytest.mark.parametrize("name", arms.here(*ON_LIMITS))
def test_postures_on_limits_next_to_singular_ones_are_in_intervals(bench, name):
    arm = arms.load(name)
    for given in ON_LIMITS[name]:
        q = np.array(given.split(), float)
        case = bench["Case"](q, arms.forward(name)(q).homogeneous, q, (), 0.0)
        intervals = arm.intervals(case.pose)
        assert bench["beside"](arm, case, intervals) < 1e-6, given
        assert not list(bench["missed"](arm, [case], [intervals])), given
