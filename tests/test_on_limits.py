"""Singular postures whose other joints are on limits: what rounding leaves of them is found, and the nearest of it.

The postures are known by construction. `benchmarks/singular.py` tries many more.
"""

import arms
import numpy as np
import pytest
from oracles import distance, inside, phases

NAMES = arms.here("iiwa14", "human_arm", "med7")


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
