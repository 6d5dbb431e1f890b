"""Singular postures whose other joints are on limits: what rounding leaves of them is found, and the nearest of it.

The postures are known by construction. `benchmarks/singular.py` tries many more.
"""

import runpy
import sys
from itertools import islice
from pathlib import Path

import arms
import numpy as np
import pytest
from oracles import distance, inside, phases

NAMES = arms.here("iiwa14", "human_arm", "med7")
BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"

POLISHED = 2e-5
"""Along a wrist that is singular on an almost exact arm, postures this close to the nearest one, rad, may be all that
floats tell apart."""


def bent_little(name, count, salt, least, most):
    """Postures with joints 2 and 6 on limits and an elbow bent by 10^least to 10^most rad, and seeds around them."""
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


@pytest.mark.skipif("human_left" not in arms.here("human_left"), reason="its file is not here")
def test_a_straight_elbow_and_two_joints_on_limits_leave_an_answer():
    """The last step of Newton's method, from a posture that is closed, led away by 1e-3."""
    q = "-0.6739337137840073 1.5254184202861485 2.927643163699172 0 -0.2811505104616593 -1.5707963267948966 "
    seed = "-0.5740914046434653 1.8548335487717267 3.01549578854863 0.27864018675789043 -0.349066 -1.3769326774865074 "
    q, seed = q + "-0.17597479427561247", seed + "-0.45734917224815724"
    assert_no_farther("human_left", np.array(q.split(), float), np.array(seed.split(), float))


def test_the_outer_joints_of_a_singular_shoulder_on_limits_leave_an_answer():
    q = "1.5707963267948966 -1.5707963167948966 -3.141592653589793 -0.44060925050757715 0.5716907685246475 "
    seed = "0.2269628864289186 2.220734150424233 -1.784215458801392 -0.6529118879066169 -1.0655583687871089 "
    q, seed = q + "-1.3962634015954636 -0.11267746473124199", seed + "0.9882677481128159 0.4339232254984437"
    assert_no_farther("human_arm", np.array(q.split(), float), np.array(seed.split(), float))
    arm = arms.load("human_arm")
    assert arm.solve(arm.forward_kinematics(np.array(q.split(), float)))


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


@pytest.mark.parametrize("name", arms.here("human_left"))
def test_a_joint_on_its_limit_is_so_in_batches_too(name):
    """The arm angle a nanoradian beside that of a posture on a limit puts the joint outside by 1.5e-8 rad."""
    arm = arms.load(name)
    q = "-3.14159 1.5809774076184155 0.36510768651690606 0.8949069825992658 3.077174777303355 "
    q = np.array((q + "0.3695004108987323 0.6878822191910388").split(), float)
    pose, psi = arm.forward_kinematics(q).homogeneous, arm.arm_angle(q) + 1e-9
    many = arm.solve_batch(pose[None], [psi], all_branches=True)
    one = [arm.solve(pose, arm_angle=psi, branch=branch) for branch in range(8)]
    assert [each.status for each in one] == list(many.status[0])
    assert one[2]
    assert np.abs(many.q[0, 2] - one[2].q).max() < 1e-12


NEAR = (
    ("random_near_42", 3, 0.0,
     (-3.0603284020249446, -1.4218605221034495, 0.0015276846778244924, -0.00021687876384346438,
     -4.657584187855765, -2.9750621561140247, 3.0278291521439633),
     (-3.0604505632798014, -1.421647994713406, 0.0013789997847955765, -0.00011605930333550948,
     -4.65764115632824, -2.9749034172114914, 3.0278291621439632)),
    ("random_near_46", 1, 1e-11,
     (-2.3896606242768126, 1e-11, 4.856063941920057, 3.9937626998174336,
     -3.0473222145407495, -0.7157671705027748, 1.7873703952799511),
     (-2.351139743297364, 0.009718153945414698, 4.817413621194028, 3.9581999164119135,
     -3.0210902265752266, -0.7395110439280209, 1.780451745918556)),
    ("rm75", 5, 1e-10,
     (1.596313952477597, -1.4140596821735003, -3.1, -2.355,
     3.1, -1e-10, -0.8055834399418185),
     (-1.9636546563364703, 1.2367892578066506, -1.0590667312747222, 1.539584636303461,
     -1.1611525628597155, 0.6068567139970917, -1.004595878523097)),
    ("rm75", 5, 0.0,
     (3.1, 2.268, 1.696211096776365, -1.603023261811656,
     0.1282753747379397, 0.0, 5.581769793579672),
     (3.0313401178787416, 2.152658732052544, 1.776150451376251, -1.4545374233677888,
     0.17633302569246087, 0.15281240288805617, 5.604308222489581)),
    ("h1_2_left", 3, 1e-10,
     (1.0325257154041112, 3.118505949608032, 2.187250721333334, 1.5045987786507045,
     1.9735535590372146, -0.1957236582369959, 0.4832100804014199),
     (1.0334510202844671, 3.117127867748884, 2.1871567035107065, 1.5041589961841981,
     1.9751111774513985, -0.19585783625703104, 0.4814272803528506)),
    ("gen3", 3, 1e-9,
     (1.0289832666111538, -0.64850693524459, 1.4617864648012526, -1e-09,
     0.42884285351416995, -1.6123210232021743, 2.5793605168933347),
     (1.0759996194821106, -0.6776520724856135, 1.5185989309486185, 0.0227996477678842,
     0.37391652518643315, -1.62255042822217, 2.5709289212701982)),
    ("h1_2_left", 3, 1e-3,
     (-2.068192200910961, 2.6508210964299725, -2.301525162630201, 1.5036035025872982,
     -2.5767218731792982, 0.14199141241901803, 1.141446027072191),
     (-2.0664440880467234, 2.6543436777072396, -2.3001099252096853, 1.5012107505021333,
     -2.5784640445736176, 0.13966744041474172, 1.1394819661901596)),
    ("h1_2_left", 3, 1e-10,
     (-2.5119230529179486, 2.828986134580972, 0.9885700284276142, 1.5045987785507045,
     0.15167231080089127, 0.20123050847191726, 0.5276071102222109),
     (-2.5173199512377282, 2.8472466784335864, 0.9771232463841889, 1.5020119470729862,
     0.13870886696779142, 0.2219188273365756, 0.5216059738568918)),
    ("j2s7s300", 3, 6e-3,
     (3.0427262783052376, 2.5118768082093705, -1.6374896639442797, 3.14741171906515,
     -0.7483856717520956, 3.8819034915978743, -0.4730119408530893),
     (3.0416945283066044, 2.515916232403528, -1.6332241045021318, 3.1438198687980248,
     -0.7522280927080078, 3.887234109866741, -0.4749171159521545)),
)  # fmt: skip
"""An arm, which joint is how far from singular, a posture of the pose, and a seed.

A joint's nearer turn lies outside its limits, and the posture on the limit is nearer than that in the farther turn; a
shoulder comes into line where the nearest exact limb has no posture; two where what an arm misses, a micrometre, puts
postures of the nearest exact limb outside the limits; a curve that turns around at a straight elbow; and two bends
of an elbow on one side of where it is straight in the nearest exact limb.
"""


@pytest.fixture(scope="module")
def judges():
    """The scripts that try many more: their arms, and what is nearest by descent from all around a seed."""
    sys.path.insert(0, str(BENCHMARKS))
    yield {name: runpy.run_path(str(BENCHMARKS / f"{name}.py"), run_name=name) for name in ("subjects", "singular")}
    sys.path.remove(str(BENCHMARKS))


def near_arm(judges, name):
    """A real arm, or one of the made ones."""
    kind, _, number = name.rpartition("_")
    if kind != "random_near":
        return arms.load(name)
    made = judges["subjects"]["random_arms"](np.random.default_rng([6710000, len(kind)]), 2e-4, 0.0)
    return next(islice(made, int(number), None))


@pytest.mark.slow
@pytest.mark.parametrize(
    "given",
    [case for case in NEAR if case[0] in arms.here("gen3", "rm75", "h1_2_left", "j2s7s300") or "random" in case[0]],
)
def test_no_posture_of_a_near_arm_is_nearer(judges, given):
    name, joint, offset, q, seed = given
    arm, judge, q, seed = near_arm(judges, name), judges["singular"], np.array(q), np.array(seed)
    case = judge["Case"](q, arm.forward_kinematics(q).homogeneous, seed, (joint,), offset)
    solution = arm.solve(case.pose, seed=seed)
    assert max(arm.verify(case.pose, solution.q)) < 1e-9
    assert inside(solution.q, arm.lower, arm.upper)
    assert np.linalg.norm(solution.q - seed) < np.linalg.norm(q - seed) + 1e-9
    assert judge["farther"](arm, judge["Known"](arm), case) < POLISHED


@pytest.mark.parametrize("width", [0.005, 0.6])
@pytest.mark.parametrize("kind", ["random", "random_leaning", "random_oblique"])
def test_postures_in_corners_of_the_limits_are_found_from_seeds_around_them(judges, kind, width):
    """Two to four joints are on limits: some are points, where one joint changes turns before, and one behind."""
    checked = 0
    for number, (arm, count) in enumerate(judges["subjects"]["arms_of"](kind, 120, 880004)):
        rng = np.random.default_rng([880004, number])
        for _ in range(count):
            q = rng.uniform(arm.lower, arm.upper)
            corner = rng.choice(7, rng.integers(2, 5), replace=False)
            q[corner] = np.where(rng.random(len(corner)) < 0.5, arm.lower[corner], arm.upper[corner])
            seed = q + rng.uniform(-width, width, 7)
            for branch in (None, arm.branch(q)):
                solution = arm.solve(arm.forward_kinematics(q), seed=seed, branch=branch)
                assert solution, (number, q.tolist(), seed.tolist())
                farther = np.linalg.norm(solution.q - seed) - np.linalg.norm(q - seed)
                assert farther < 1e-7, (number, q.tolist(), seed.tolist(), branch)
                checked += 1
    assert checked == 240


@pytest.mark.parametrize("name", arms.here("med7", "sia10f"))
def test_a_folded_arm_of_equal_links_is_where_its_seed_is(name):
    """Its wrist is in its shoulder, and which way to go around is anyone's choice: the seed is not left."""
    arm = arms.load(name)
    for q in arms.configurations(name, 60, 97):
        q[3] = phases(arm.limb)[3] + np.pi
        q[5] = phases(arm.limb)[5] if q[0] > 0.0 else q[5]
        solution = arm.solve(arm.forward_kinematics(q), seed=q, respect_limits=False)
        assert np.linalg.norm(solution.q - q) < 1e-6, q.tolist()
