"""Feasible arm angles against a sweep that knows nothing of intervals."""

import arms
import numpy as np
import pytest
from hypothesis import given
from interval_oracle import assert_well_formed, covered, disagreements
from oracles import (
    arm_angle,
    distance,
    inside,
    limbs,
    middle_phase,
    other_elbow_reaches,
    postures_by_steps,
    random_limb,
    room,
    wrapped,
)

import srs_ik
from srs_ik import Interval, Status

TURN = 2.0 * np.pi
SWEPT = arms.here("iiwa14", "human_arm", "sia5d", "openarm_left", "romeo_left", "human_left", "med7")
NEAR = arms.here("gen3", "iiwa14_experimental", "j2s7s300", "h1_2_left", "rm75")


@pytest.mark.parametrize("name", SWEPT)
def test_intervals_are_what_a_sweep_finds(name):
    arm, forward = arms.load(name), arms.forward(name)
    partial = 0
    for q in arms.configurations(name, 25, 41):
        pose = forward(q)
        intervals = arm.intervals(pose)
        assert_well_formed(intervals)
        assert disagreements(arm, pose, intervals) == []
        assert any(i.branch == arm.branch(q) and arm.arm_angle(q) in i for i in intervals)
        partial += any(i.width < TURN - 0.1 for i in intervals)
    assert partial > 5


def is_feasible(arm, forward, pose, branch, psi):
    """Whether there is a posture of a branch at an arm angle inside the limits: one that is measured by Pinocchio.

    Next to a singularity of a near limb there may be two, of which a sweep that is blind to limits finds either.
    """
    solution = arm.solve(pose, arm_angle=psi, branch=branch)
    return (
        bool(solution)
        and max(distance(pose, forward(solution.q))) < 1e-9
        and abs(wrapped(arm_angle(forward, arm.limb, solution.q) - psi)) < 1e-6
        and arm.branch(solution.q) == branch
        and inside(solution.q, arm.lower, arm.upper)
    )


@pytest.mark.parametrize("name", NEAR)
def test_intervals_of_arms_whose_axes_miss_their_centres(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 15, 42):
        pose = forward(q)
        intervals = arm.intervals(pose)
        assert_well_formed(intervals)
        assert any(i.branch == arm.branch(q) and arm.arm_angle(q) in i for i in intervals)
        for branch, psi in disagreements(arm, pose, intervals, 240):
            within, _ = covered(intervals, branch, np.array([psi]))
            assert within[0] == is_feasible(arm, forward, pose, branch, psi)


@pytest.mark.slow
@given(limbs(limits=("usual", "narrow", "wide", "beyond", "mixed")))
def test_intervals_of_random_limbs(limb):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    for _ in range(3):
        q = limb.configuration()
        pose = arm.forward_kinematics(q)
        intervals = arm.intervals(pose)
        assert_well_formed(intervals)
        assert disagreements(arm, pose, intervals) == []
        own = [i for i in intervals if i.branch == arm.branch(q)]
        psi = arm.arm_angle(q)
        # An interval may be narrower than the rounding of the arm angle.
        assert min(min(abs(wrapped(psi - i.lower)), abs(wrapped(psi - i.upper))) * (psi not in i) for i in own) < 1e-9


@pytest.mark.parametrize("elbow", ["straight", "offset"])
@pytest.mark.parametrize("seed", [3, 5, 7, 9, 11])
def test_arm_angles_in_intervals_of_near_limbs_are_met(seed, elbow):
    """Also where Newton's method does not close the branch in question at first, and the others keep no limits."""
    limb = random_limb(seed, "oblique", elbow, "usual", 0.01)
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    for _ in range(3):
        pose = arm.forward_kinematics(limb.configuration())
        for interval in arm.intervals(pose):
            for share in (0.1, 0.5, 0.9):
                solution = arm.solve(pose, arm_angle=interval.lower + share * interval.width)
                assert solution, interval
                assert max(arm.verify(pose, solution.q)) < 1e-9


@pytest.mark.parametrize("elbow", ["straight", "offset"])
@pytest.mark.parametrize("seed", [1, 12, 15, 17, 18])
def test_short_arcs_of_oblique_near_limbs_are_not_missed(seed, elbow):
    limb = random_limb(seed, "oblique", elbow, "usual", 0.01)
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    for _ in range(3):
        q = limb.configuration()
        psi, branch = arm.arm_angle(q), arm.branch(q)
        assert any(psi in i for i in arm.intervals(arm.forward_kinematics(q)) if i.branch == branch)


def test_narrow_intervals_are_not_missed():
    """Limits of a ten-thousandth of a radian: a sweep would need luck."""
    found = 0
    for seed in range(40):
        limb = random_limb(seed, "oblique", "offset", "narrow")
        arm = srs_ik.load(limb.model, base="base", tip="tool")
        q = limb.configuration()
        intervals = arm.intervals(arm.forward_kinematics(q))
        own = [i for i in intervals if i.branch == arm.branch(q)]
        assert len(own) >= 1
        found += any(i.width < 1e-3 for i in own)
    assert found > 10


@pytest.mark.parametrize("locked", [(2, 4), (0, 6), (1, 5)])
def test_joints_without_room_leave_an_arm_angle(locked):
    free = arms.load("iiwa14")
    for q in arms.configurations("iiwa14", 20, 8):
        limits = {free.joint_names[j]: {"lower": float(q[j]), "upper": float(q[j])} for j in locked}
        arm = srs_ik.load("iiwa14", limits=limits)
        pose, psi = arm.forward_kinematics(q), arm.arm_angle(q)
        inside_any, from_end = covered(arm.intervals(pose), arm.branch(q), np.array([psi]))
        assert inside_any or from_end < 1e-6
        for interval in arm.intervals(pose):
            solution = arm.solve(pose, arm_angle=0.5 * (interval.lower + interval.upper), branch=interval.branch)
            assert max(distance(pose, free.forward_kinematics(solution.q))) < 1e-7


@pytest.mark.parametrize("name", SWEPT)
def test_every_end_has_a_reason(name):
    """At an end a joint is on its limit, or passes a singular posture, or the axes reach no farther."""
    arm, forward = arms.load(name), arms.forward(name)
    phases = {1: middle_phase(*arm.limb.axes[:3]), 5: middle_phase(*arm.limb.axes[4:])}
    ends = 0
    for q in arms.configurations(name, 25, 43):
        pose = forward(q)
        for i in arm.intervals(pose):
            if i.width >= TURN - 1e-9:
                continue
            for end in (i.lower, i.upper):
                solution = arm.solve(pose, arm_angle=end, branch=i.branch, respect_limits=False)
                if not solution:
                    continue
                limit = np.abs(room(solution.q, arm.lower, arm.upper)).min()
                singular = min(abs(np.sin(solution.q[k] - phase)) for k, phase in phases.items())
                assert min(limit, singular) < 1e-6
                ends += 1
    assert ends > 20


@pytest.mark.parametrize("name", SWEPT)
def test_postures_on_and_inside_the_ends_keep_the_limits(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 25, 44):
        pose = forward(q)
        for i in arm.intervals(pose):
            for psi in (i.lower + 1e-9, i.upper - 1e-9, 0.5 * (i.lower + i.upper)):
                if psi in i:
                    solution = arm.solve(pose, arm_angle=psi, branch=i.branch)
                    assert solution.status is Status.OK
                    assert inside(solution.q, arm.lower, arm.upper)


def test_without_limits_every_branch_is_a_whole_circle():
    arm = arms.load("iiwa14")
    for q in arms.configurations("iiwa14", 20, 45):
        intervals = arm.intervals(arm.forward_kinematics(q), respect_limits=False)
        assert sorted({i.branch for i in intervals}) == list(range(8))
        for branch in range(8):
            assert sum(i.width for i in intervals if i.branch == branch) == pytest.approx(TURN)


def test_without_limits_oblique_axes_have_their_reach():
    arm = arms.load("romeo_left")
    for q in arms.configurations("romeo_left", 10, 46):
        pose = arm.forward_kinematics(q)
        angles = wrapped(np.linspace(-np.pi, np.pi, 720, endpoint=False) + 1e-4)
        poses = np.broadcast_to(pose.homogeneous, (720, 4, 4))
        exists = arm.solve_batch(poses, arm_angle=angles, all_branches=True, respect_limits=False).ok
        intervals = arm.intervals(pose, respect_limits=False)
        for branch in range(8):
            inside_any, from_end = covered(intervals, branch, angles)
            assert (inside_any == exists[:, branch])[from_end > 1e-9].all()
        assert other_elbow_reaches(arm.limb, q) <= 0.0 or len({i.branch for i in intervals}) == 8


def test_continuous_joints_alone_leave_whole_circles():
    limb = random_limb(3, "tilted", "offset", "continuous")
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    pose = arm.forward_kinematics(limb.configuration())
    limited, free = arm.intervals(pose), arm.intervals(pose, respect_limits=False)
    assert limited == free
    assert sum(i.width for i in free) == pytest.approx(8 * TURN)


@pytest.mark.parametrize("name", arms.here("iiwa14", "human_arm", "openarm_right"))
def test_no_interval_means_out_of_limits(name):
    arm = arms.load(name)
    seen = {False: 0, True: 0}
    for q in arms.generator(name, 47).uniform(-np.pi, np.pi, (60, 7)):
        pose = arm.forward_kinematics(q)
        feasible = bool(arm.intervals(pose))
        solution = arm.solve(pose)
        assert solution.status is (Status.OK if feasible else Status.OUT_OF_LIMITS)
        seen[feasible] += 1
    assert min(seen.values()) > 3


@pytest.mark.parametrize("name", SWEPT)
def test_solve_all_gives_one_posture_an_interval(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 15, 48):
        pose = forward(q)
        intervals = arm.intervals(pose)
        every = arm.solve_all(pose)
        assert every.branch.tolist() == [i.branch for i in intervals]
        for solution, interval in zip(every, intervals, strict=True):
            assert inside(solution.q, arm.lower, arm.upper)
            psi = solution.arm_angle
            assert psi in interval or min(abs(wrapped(psi - e)) for e in (interval.lower, interval.upper)) < 1e-9


ABOUT_A_GREATEST_REACH = (
    [-2.7257, 0.8142, 0.2224, 0.0002, 1.0581, 0.9424, 0.8889],
    [1.3087, -1.6232, -0.1016, -0.0054, -1.3177, 1.5217, 2.7712],
    [-1.9001, 1.6214, -0.2335, -0.0064, -1.1897, -1.5841, -0.3475],
    [0.0232, 0.7205, -0.2265, -0.0084, 2.3569, -1.4222, 0.347],
)
"""Configurations of gen3 whose poses it reaches, with an elbow almost straight, at some arm angles alone."""


@pytest.mark.parametrize("q", ABOUT_A_GREATEST_REACH)
def test_curves_about_a_greatest_reach_are_in_intervals(q):
    arm = arms.load("gen3")
    pose = arm.forward_kinematics(q)
    intervals = arm.intervals(pose, respect_limits=False)
    for posture in postures_by_steps(arm, pose, np.array(q))[0][::5]:
        psi, branch = arm.arm_angle(posture), arm.branch(posture)
        # Where the arm angle turns around, an interval is as long as its end is known.
        assert any(i.branch == branch and psi in Interval(branch, i.lower - 1e-6, i.upper + 1e-6) for i in intervals)


def test_out_of_reach_has_no_interval():
    arm = arms.load("iiwa14")
    pose = arm.forward_kinematics(np.zeros(7))
    pose.translation = pose.translation + np.array([0.0, 0.0, 0.5])
    assert not arm.solve(pose)
    assert not any(arm.solve(pose, arm_angle=0.5 * (i.lower + i.upper), branch=i.branch) for i in arm.intervals(pose))
    assert arm.intervals(pose) == []


def test_interval_of_the_seam():
    interval = Interval(3, 3.0, 3.5)
    assert interval.width == pytest.approx(0.5)
    for psi, expected in ((3.2, True), (3.4 - TURN, True), (2.9, False), (3.6 - TURN, False), (3.5, True)):
        assert (psi in interval) is expected


@pytest.mark.parametrize("width", [np.pi, 3.1415926, 3.14159265, 3.141592653, 3.14159265358])
@pytest.mark.parametrize("name", ["iiwa14", "human_arm"])
def test_known_postures_on_limits_of_ranges_of_almost_half_a_turn_are_in_an_interval(name, width):
    half = {joint: {"lower": 0.0, "upper": width} for joint in srs_ik.load(name).joint_names[::2]}
    arm = srs_ik.load(name, limits=half)
    rng = np.random.default_rng(5)
    for _ in range(60):
        q = rng.uniform(arm.lower, arm.upper)
        q[::2] = np.where(rng.random(4) < 0.6, rng.choice([0.0, width], 4), q[::2])
        pose = arm.forward_kinematics(q)
        assert arm.solve(pose), q.tolist()
        psi, branch = arm.arm_angle(q), arm.branch(q)
        own = [i for i in arm.intervals(pose) if i.branch == branch]
        assert any((psi - i.lower + 1e-7) % (2.0 * np.pi) <= i.width + 2e-7 for i in own), q.tolist()


@pytest.mark.parametrize("name", arms.here("med7"))
def test_where_events_are_equal_across_the_seam_no_arm_angle_is_told_that_is_not_met(name):
    arm = arms.load(name)
    q = [2.9670597283903604, 0.0, 0.919105624543834, 2.0943951023931953, 0.0627894642909319, 0.0, 2.928394977057947]
    pose = arm.forward_kinematics(q)
    found = arm.intervals(pose)
    assert found
    for interval in found:
        assert interval.lower <= interval.upper
        for share in (0.0, 0.5, 1.0):
            psi = interval.lower + share * interval.width
            assert arm.solve(pose, arm_angle=psi, branch=interval.branch), (interval, share)
